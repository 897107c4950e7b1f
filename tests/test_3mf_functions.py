"""Functions in 3MF against the same graphs evaluated by numpy, node by node."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from loaded import told
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.adapters.core_files import read_in_core
from bobrossnet.sdf import Mesh, d3

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
NAMESPACES = (
    f"xmlns='{CORE}' xmlns:v='http://schemas.3mf.io/3dmanufacturing/volumetric/2022/01' "
    "xmlns:i='http://schemas.3mf.io/3dmanufacturing/implicit/2023/12' requiredextensions='v i'"
)
POINTS = np.random.default_rng(4).uniform(-2, 2, (200, 3))

Points = NDArray[np.float64]
Node = tuple[str, dict[str, str], dict[str, str]]
"""Kind, attributes, and references by the names of inputs; its name is its number: n0, n1 ..."""


def node(kind: str, inputs: str = "", **attributes: str) -> Node:
    """Inputs as "A=n0 B=inputs.pos"; an output that has no name is called result."""
    given = dict(each.split("=") for each in inputs.split())
    return kind, attributes, {name: ref if "." in ref else f"{ref}.result" for name, ref in given.items()}


def function(number: str, nodes: list[Node], outputs: dict[str, str], inputs: str = "vector:pos") -> str:
    def attributes(values: dict[str, str]) -> str:
        return "".join(f" {name}='{value}'" for name, value in values.items())

    body = "".join(
        f"<i:{kind} identifier='n{i}'{attributes(given)}><i:in>"
        + "".join(f"<i:scalarref identifier='{name}' ref='{ref}'/>" for name, ref in refs.items())
        + f"</i:in><i:out><i:scalar identifier='result'/></i:out></i:{kind}>"
        for i, (kind, given, refs) in enumerate(nodes)
    )
    declared = "".join("<i:{} identifier='{}'/>".format(*each.split(":")) for each in inputs.split())
    found = "".join(f"<i:scalarref identifier='{name}' ref='{ref}'/>" for name, ref in outputs.items())
    return f"<i:implicitfunction id='{number}'><i:in>{declared}</i:in>{body}<i:out>{found}</i:out></i:implicitfunction>"


def box(number: str, half: float) -> str:
    vertices = "".join("<vertex x='{}' y='{}' z='{}'/>".format(*corner) for corner in product((-half, half), repeat=3))
    corners = ["013", "032", "475", "467", "051", "045", "237", "276", "026", "064", "173", "157"]
    triangles = "".join(f"<triangle v1='{c[0]}' v2='{c[1]}' v3='{c[2]}'/>" for c in corners)
    mesh = f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"
    return f"<object id='{number}'>{mesh}</object>"


def file(folder: Path, resources: str, level_set: str = "functionid='5' channel='shape' meshbboxonly='true'") -> Path:
    shape = f"<object id='9'><v:levelset meshid='1' {level_set}/></object>"
    text = f"<model {NAMESPACES}><resources>{box('1', 50)}{resources}{shape}</resources>"
    with zipfile.ZipFile(folder / "a.3mf", "w") as archive:
        archive.writestr("3D/3dmodel.model", f"{text}<build><item objectid='9'/></build></model>")
    return folder / "a.3mf"


def shape_in(path: Path) -> bob.Implicit:
    """Without tracing it: not every formula has a surface."""
    found = read_in_core(path)
    assert found == []
    (instance,) = found.shapes
    assert isinstance(instance.shape, bob.Implicit)
    return instance.shape


POS = "A=inputs.pos"
X, Y, Z = "inputs.x", "inputs.y", "inputs.z"


def of_each(compute: Callable[[Points], Points]) -> Callable[[Points], Points]:
    """A node on a vector, whose components are then added."""
    return lambda p: compute(p).sum(axis=1)


ONE = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "arctan": np.arctan, "atan": np.arctan, "abs": np.abs, "exp": np.exp,
    "cosh": np.cosh, "sinh": np.sinh, "tanh": np.tanh, "round": np.rint, "ceil": np.ceil, "floor": np.floor,
    "sign": np.sign, "fract": lambda p: p - np.floor(p),
    "arcsin": np.arcsin, "arccos": np.arccos, "asin": np.arcsin, "acos": np.arccos,
    "sqrt": np.sqrt, "log": np.log, "log2": np.log2, "log10": np.log10,
}  # fmt: skip
TWO = {
    "addition": np.add, "subtraction": np.subtract, "multiplication": np.multiply, "division": np.divide,
    "min": np.minimum, "max": np.maximum, "fmod": np.fmod, "mod": np.mod, "arctan2": np.arctan2, "atan2": np.arctan2,
}  # fmt: skip


def check(path: Path, expected: Points) -> None:
    found = shape_in(path).expression(POINTS)
    defined = ~np.isnan(expected)
    assert defined.any()
    assert np.array_equal(np.isnan(found), ~defined)
    inside = expected > -48  # else the box around it may be higher
    assert np.allclose(found[inside], expected[inside], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("kind", ONE)
def test_nodes_of_one_value(kind: str, tmp_path: Path) -> None:
    nodes = [node(kind, POS), node("dot", "A=n0 B=n2"), node("constvec", x="1", y="1", z="1")]
    with np.errstate(all="ignore"):
        check(file(tmp_path, function("5", nodes, {"shape": "n1.result"})), ONE[kind](POINTS).sum(axis=1))


@pytest.mark.parametrize("kind", TWO)
def test_nodes_of_two_values(kind: str, tmp_path: Path) -> None:
    nodes = [
        node("constvec", x="0.3", y="-0.7", z="1.9"),
        node("addition", f"{POS} B=n0"),
        node(kind, f"{POS} B=n1"),
        node("constvec", x="1", y="1", z="1"),
        node("dot", "A=n2 B=n3"),
    ]
    expected = TWO[kind](POINTS, POINTS + (0.3, -0.7, 1.9)).sum(axis=1)
    check(file(tmp_path, function("5", nodes, {"shape": "n4.result"})), expected)


MATRIX = np.arange(16.0).reshape(4, 4) ** 2 / 50 + np.eye(4)
ROWS = [node("constvec", **dict(zip("xyz", map(str, row[:3]), strict=True))) for row in MATRIX]
AT = np.hstack([POINTS, np.ones((len(POINTS), 1))])
COMPONENTS = " ".join(f"m{r}{c}=" + ("n0." + "xyz"[c] if max(r, c) < 3 else "n1") for r in range(4) for c in range(4))
OTHER = {
    "pow": (
        [node("decomposevector", POS), node("abs", "A=n0.x"), node("pow", "A=n1 B=n0.y")],
        np.abs(POINTS[:, 0]) ** POINTS[:, 1],
    ),
    "pow of a whole number": (
        [node("decomposevector", POS), node("constant", value="3"), node("pow", "A=n0.x B=n1")],
        POINTS[:, 0] ** 3,
    ),
    "clamp": (
        [node("decomposevector", POS), node("constant", value="0.5"), node("clamp", "A=n0.x min=n0.y max=n1")],
        np.maximum(POINTS[:, 1], np.minimum(POINTS[:, 0], 0.5)),
    ),
    "select": (
        [node("decomposevector", POS), node("constant", value="7"), node("select", "A=n0.x B=n0.y C=n0.z D=n1")],
        np.where(POINTS[:, 0] < POINTS[:, 1], POINTS[:, 2], 7),
    ),
    "select of what is not defined": (
        [node("decomposevector", POS), node("constant", value="0"), node("sqrt", "A=n0.x"),
         node("select", "A=n0.x B=n1 C=n0.y D=n2")],
        np.where(POINTS[:, 0] < 0, POINTS[:, 1], np.sqrt(np.abs(POINTS[:, 0]))),
    ),
    "select of vectors": (
        [node("constvec", x="0", y="1", z="-1"), node("abs", POS),
         node("select", "A=inputs.pos B=n0 C=n1 D=inputs.pos"), node("length", "A=n2")],
        np.linalg.norm(np.where(POINTS < (0, 1, -1), np.abs(POINTS), POINTS), axis=1),
    ),
    "cross": (
        [node("constvec", x="1", y="2", z="3"), node("cross", f"{POS} B=n0"), node("decomposevector", "A=n1"),
         node("composevector", "x=n2.z y=n2.x z=n2.y"), node("dot", "A=n3 B=n0")],
        np.roll(np.cross(POINTS, (1, 2, 3)), 1, axis=1) @ (1, 2, 3),
    ),
    "vectorfromscalar": (
        [node("length", POS), node("vectorfromscalar", "A=n0"), node("dot", "A=n1 B=inputs.pos")],
        np.linalg.norm(POINTS, axis=1) * POINTS.sum(axis=1),
    ),
    "constmat": (
        [node("constmat", matrix=" ".join(map(str, MATRIX.ravel()))), node("matvecmultiplication", "A=n0 B=inputs.pos"),
         node("length", "A=n1")],
        np.linalg.norm((AT @ MATRIX.T)[:, :3], axis=1),
    ),
    "transpose": (
        [node("constmat", matrix=" ".join(map(str, MATRIX.ravel()))), node("transpose", "A=n0"),
         node("matrixvectormultiplication", "A=n1 B=inputs.pos"), node("length", "A=n2")],
        np.linalg.norm((AT @ MATRIX)[:, :3], axis=1),
    ),
    "inverse": (
        [node("constmat", matrix=" ".join(map(str, MATRIX.ravel()))), node("inverse", "A=n0"),
         node("matvecmultiplication", "A=n1 B=inputs.pos"), node("length", "A=n2")],
        np.linalg.norm((AT @ np.linalg.inv(MATRIX).T)[:, :3], axis=1),
    ),
    "matrixfromrows": (
        [*ROWS, node("matrixfromrows", "A=n0 B=n1 C=n2 D=n3"), node("matvecmultiplication", "A=n4 B=inputs.pos"),
         node("length", "A=n5")],
        np.linalg.norm(POINTS @ MATRIX[:3, :3].T, axis=1),
    ),
    "matrixfromcolumns": (
        [*ROWS, node("matrixfromcolumns", "A=n0 B=n1 C=n2 D=n3"), node("matvecmultiplication", "A=n4 B=inputs.pos"),
         node("length", "A=n5")],
        np.linalg.norm(POINTS @ MATRIX[:3, :3] + MATRIX[3, :3], axis=1),
    ),
    "composematrix": (
        [node("decomposevector", POS), node("constant", value="2"),
         node("composematrix", COMPONENTS),
         node("matvecmultiplication", "A=n2 B=inputs.pos"), node("length", "A=n3")],
        np.sqrt(3) * np.abs((POINTS**2).sum(axis=1) + 2),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", OTHER)
def test_other_nodes(name: str, tmp_path: Path) -> None:
    nodes, expected = OTHER[name]
    check(file(tmp_path, function("5", nodes, {"shape": f"n{len(nodes) - 1}.result"})), expected)


def test_repetition_by_a_distance_of_zero(tmp_path: Path) -> None:
    """The cell's number is infinite or 0 / 0, and is clamped to 0."""
    nodes = [
        node("constvec", x="0", y="0", z="4"), node("division", f"{POS} B=n0"), node("round", "A=n1"),
        node("constvec", x="0", y="0", z="2"), node("constvec", x="0", y="0", z="-2"),
        node("clamp", "A=n2 min=n4 max=n3"), node("multiplication", "A=n5 B=n0"), node("subtraction", f"{POS} B=n6"),
        node("length", "A=n7"), node("constant", value="1"), node("subtraction", "A=n8 B=n9"),
    ]  # fmt: skip
    scene = bob.load(file(tmp_path, function("5", nodes, {"shape": "n10.result"})))
    assert np.allclose(scene.boxes[0], [[-1, -1, -9], [1, 1, 9]], atol=0.1)
    z = np.linspace(-9, 9, 19)
    origin = np.column_stack([np.full(19, 5), np.zeros(19), z])
    hits = scene.closest_hits(origin, np.tile((-1.0, 0, 0), (19, 1))).distance
    assert np.allclose(hits[np.isin(z, (-8, -4, 0, 4, 8))], 4, atol=1e-5)
    assert scene.unresolved_rays == 0


BALL = function(
    "3",
    [node("length", POS), node("subtraction", "A=n0 B=inputs.radius")],
    {"shape": "n1.result", "far": "n0.result"},
    "vector:pos scalar:radius",
)


def test_functions_call_each_other(tmp_path: Path) -> None:
    nodes = [
        node("functioncall", "functionID=n1.value pos=n2 radius=n3"),
        node("constresourceid", value="3"),
        node("addition", f"{POS} B=n4"),
        node("constant", value="1.5"),
        node("constvec", x="1", y="0", z="0"),
        node("multiplication", "A=n0.shape B=n0.far"),
    ]
    far = np.linalg.norm(POINTS + (1, 0, 0), axis=1)
    check(file(tmp_path, BALL + function("5", nodes, {"shape": "n5.result"})), (far - 1.5) * far)


@pytest.mark.parametrize(("kind", "inside"), [("mesh", -1), ("unsignedmesh", 1)])
def test_meshes_in_functions(kind: str, inside: int, tmp_path: Path) -> None:
    nodes = [node(kind, "pos=inputs.pos mesh=n1.value"), node("constresourceid", value="2")]
    found = shape_in(file(tmp_path, box("2", 1) + function("5", nodes, {"shape": "n0.distance"}))).expression(POINTS)
    beyond = np.abs(POINTS) - 1
    outside = np.linalg.norm(np.maximum(beyond, 0), axis=1)
    assert np.allclose(found, np.where(outside > 0, outside, inside * np.abs(beyond.max(axis=1))), atol=1e-6)


def test_level_sets_are_placed_cut_and_colored(tmp_path: Path) -> None:
    """A ball of radius 60 is cut by a mesh, a box of half side 50; one in coordinates twice as large is not."""
    sphere = function("5", [node("length", POS), node("constant", value="60"), node("subtraction", "A=n0 B=n1")],
                      {"shape": "n2.result", "color": "inputs.pos"})  # fmt: skip
    transform = ".01 0 0 0 .01 0 0 0 .01 0 0 0"
    color = f"<v:volumedata id='7'><v:color functionid='5' channel='color' transform='{transform}'/></v:volumedata>"
    given = "functionid='5' channel='shape' volumeid='7'"
    cut = bob.load(file(tmp_path, sphere + color, given))
    assert np.allclose(cut.boxes[0], [[-50] * 3, [50] * 3], atol=0.4)
    shape = cut.instances[0].shape
    assert isinstance(shape, bob.Implicit)
    assert shape.is_colored
    assert np.allclose(shape.core.colors(np.array([[40.0, 20, 50]])), [[0.4, 0.2, 0.5]], atol=1e-5)
    whole = file(tmp_path, sphere, "functionid='5' channel='shape' transform='2 0 0 0 2 0 0 0 2 0 0 20'")
    assert np.allclose(bob.load(whole).boxes[0], [[-30, -30, -40], [30, 30, 20]], atol=0.4)


def test_rays_meet_what_numpy_finds(tmp_path: Path) -> None:
    """A gyroid in a ball: first sign changes of dense samples along rays are where rays hit."""
    nodes = [
        node("sin", POS), node("decomposevector", POS), node("composevector", "x=n1.y y=n1.z z=n1.x"),
        node("cos", "A=n2"),
        node("dot", "A=n0 B=n3"), node("abs", "A=n4"), node("constant", value="0.3"), node("subtraction", "A=n5 B=n6"),
        node("length", POS), node("constant", value="6"), node("subtraction", "A=n8 B=n9"), node("max", "A=n7 B=n10"),
    ]  # fmt: skip
    scene = bob.load(file(tmp_path, function("5", nodes, {"shape": "n11.result"})))

    def f(p: Points) -> Points:
        gyroid = np.abs((np.sin(p) * np.cos(np.roll(p, -1, axis=-1))).sum(axis=-1)) - 0.3
        return np.maximum(gyroid, np.linalg.norm(p, axis=-1) - 6)

    random = np.random.default_rng(2)
    direction = random.normal(size=(300, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    origin = random.uniform(-4, 4, (300, 3)) - 14 * direction
    distance = scene.closest_hits(origin, direction).distance
    t = np.linspace(0, 30, 30_001)
    for o, d, found in zip(origin, direction, distance, strict=True):
        inside = f(o + t[:, None] * d) < 0
        first = t[np.argmax(inside)] if inside.any() else np.inf
        assert found <= first + 1e-4
        # Samples miss parts thinner than their step.
        assert found == first or found > first - 2e-3 or f(o + (found + 1e-4) * d) < 1e-3


@pytest.mark.parametrize(
    ("resources", "message"),
    [
        ("", "levelset: function 5: expected a function with id 5, got none"),
        (function("5", [], {"far": "inputs.pos"}), "expected an output shape, got far"),
        (function("5", [], {"shape": "inputs.pos"}), "shape: expected a scalar, got a vector"),
        (function("5", [], {"shape": "n7.result"}), "expected a node n7, got none"),
        (function("5", [node("length", "A=n0")], {"shape": "n0.result"}), "without a cycle, got one through n0"),
        (function("5", [node("length")], {"shape": "n0.result"}), "n0: expected A, got none"),
        (function("5", [node("erode", POS)], {"shape": "n0.result"}), "a supported kind of node, got erode"),
        (function("5", [node("min", f"{POS} B=n1"), node("length", POS)], {"shape": "n0.result"}),
         "expected a vector, got a scalar"),
        (function("5", [node("constant", value="many")], {"shape": "n0.result"}), "expected numbers, got others"),
        (function("5", [node("functioncall", "functionID=n1.value pos=inputs.pos"), node("constresourceid", value="5")],
                  {"shape": "n0.shape"}), "64 deep that do not call themselves"),
        (function("5", [node("mesh", "pos=inputs.pos mesh=n1.value"), node("constresourceid", value="8")],
                  {"shape": "n0.distance"}), "expected a mesh with id 8, got none"),
        (BALL.replace("id='3'", "id='5'"), "expected a value for the input radius, got none"),
    ],
)  # fmt: skip
def test_wrong_functions_are_one_line(resources: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(bob.InputError) as error:
        bob.load(file(tmp_path, resources))
    assert message in str(error.value)
    assert str(error.value).startswith("a.3mf: ")
    assert "\n" not in str(error.value)


def test_functions_that_call_without_end(tmp_path: Path) -> None:
    """Each calls the one before twice: 2ⁿ nodes."""
    twice = node("functioncall", "functionID=n1.value pos=inputs.pos")
    call = [twice, node("constresourceid", value="{}"), twice, node("addition", "A=n0.shape B=n2.shape")]
    calls = "".join(function(str(n), call, {"shape": "n3.result"}).replace("{}", str(n - 1)) for n in range(101, 140))
    first = function("100", [node("length", POS)], {"shape": "n0.result"})
    last = function("5", call, {"shape": "n3.result"}).replace("{}", "139")
    with pytest.raises(bob.InputError, match="expected at most 65,536 nodes to evaluate, got more"):
        bob.load(file(tmp_path, first + calls + last))


def test_functions_of_images_are_named(tmp_path: Path) -> None:
    image = "<v:image3d id='6'/><v:functionfromimage3d id='5' image3did='6'/>"
    with pytest.raises(bob.InputError, match=r"^a\.3mf: expected triangles, got none; left out level sets of images"):
        bob.load(file(tmp_path, image))
    nodes = [node("length", POS), node("constant", value="2"), node("subtraction", "A=n0 B=n1")]
    ball = function("4", nodes, {"shape": "n2.result"})
    volume = "<v:volumedata id='7'><v:color functionid='5' channel='color'/></v:volumedata>"
    _, warned = told(file(tmp_path, image + ball + volume, "functionid='4' channel='shape' volumeid='7'"))
    assert warned == ["a.3mf: left out colours of images in space (1)"]


# ---- Written ---------------------------------------------------------------------------------------------

EVERY_OP = (
    "np.sin(x) + np.cos(y) + np.tan(z / 9) + np.arcsin(x / 9) + np.arccos(y / 9) + np.arctan(z) + np.exp(-x)"
    " + np.log(y + 9) + np.floor(x) + np.ceil(y) + np.rint(z) + x**5 + np.sqrt(z + 9) - y / 7 + np.minimum(x, y)"
    " + np.maximum(y, z) + np.hypot(x, z) + np.arctan2(y, x) + np.mod(z, 0.7) + np.where(x < y, z, x * y) - np.abs(z)"
    " - 9 + (-x) ** 2 * 1e-300"
)
WRITTEN: dict[str, Callable[[], Any]] = {
    "part": lambda: (d3.sphere(1) & d3.box(1.5)) - d3.cylinder(0.5),
    "colors": lambda: d3.box(1).color("#ff0000") | d3.sphere(0.6).color((0, 0, 1)),
    "bent": lambda: d3.box((4, 0.6, 0.6)).bend(0.7),
    "mesh": lambda: Mesh(*corners_of(d3.sphere(1).mesh(0.6))).sdf().dilate(0.1) | d3.box((3, 0.2, 0.2)),
    "every op": lambda: bob.implicit(
        eval(f"lambda x, y, z: {EVERY_OP}", {"np": np}),
        bounds=((-2, -2, -2), (2, 2, 2)),
        color=lambda x, y, z: (x, y, z),
    ),
}


def corners_of(mesh: bob.Mesh) -> tuple[Any, Any]:
    return mesh.vertices, mesh.triangles


@pytest.mark.parametrize("name", WRITTEN)
def test_formulas_stay_formulas(name: str, tmp_path: Path) -> None:
    shape = WRITTEN[name]()
    shape.save(tmp_path / "a.3mf")
    shape.save(tmp_path / "b.3mf")
    assert (tmp_path / "a.3mf").read_bytes() == (tmp_path / "b.3mf").read_bytes()
    read = shape_in(tmp_path / "a.3mf")
    low, high = bob.Scene(shape).boxes[0]
    points = np.random.default_rng(1).uniform(low, high, (2000, 3))
    wanted, found = shape.expression(points), read.expression(points)
    assert np.array_equal(wanted < 0, found < 0)
    assert np.allclose(wanted[wanted >= 0], found[wanted >= 0], rtol=1e-12, atol=1e-12)
    a, b = (bob.trace(each, size=(60, 80)) for each in (shape, read))
    assert np.abs(a.gray - b.gray).mean() < 0.02  # bounds, and so the cameras, may differ a little
    assert read.is_colored == shape.is_colored
    if shape.is_colored:
        assert np.allclose(shape.core.colors(points), read.core.colors(points), atol=1e-6)


def test_names_of_written_files_are_checked(tmp_path: Path) -> None:
    with pytest.raises(bob.InputError, match="can't write it: there is no folder"):
        d3.sphere(1).save(tmp_path / "none" / "a.3mf")
    d3.sphere(2).save(tmp_path / "a.3mf", bounds=((0, -3, -3), (3, 3, 3)))
    assert np.allclose(bob.load(tmp_path / "a.3mf").boxes[0], [[0, -2, -2], [2, 2, 2]], atol=0.02)
