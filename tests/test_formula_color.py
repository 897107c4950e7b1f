"""Colours of formulas under all operations, in Python and in scripts, in pictures, meshes and files."""

import copy
import json
import pickle
import re

import numpy as np
import pytest
from word_scripts import COLORED, SCRIPTS

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.adapters.container import layout, sealed
from bobrossnet.color import from_srgb, to_srgb
from bobrossnet.picture.files import color_to_8_bit
from bobrossnet.sdf import (
    SDF2,
    SDF3,
    X,
    Z,
    box,
    capsule,
    circle,
    d2,
    ease,
    op2,
    op3,
    op23,
    rectangle,
    sphere,
    torus,
)

pytestmark = pytest.mark.usefixtures("no_methods_are_left")

SIZE = 60, 80
RED, BLUE, WHITE = np.array((1.0, 0, 0)), np.array((0, 0, 1.0)), np.ones(3)
POINTS = np.random.default_rng(5).uniform(-2, 2, (400, 3))
A, B = sphere(1).color(RED), box(1.5).translate((0.7, 0.4, 0.3)).color("#00f")


def colors(shape, points=POINTS):
    return shape.color_formula(np.ascontiguousarray(points))


def agree(shape, expected, points=POINTS):
    np.testing.assert_allclose(colors(shape, points), np.broadcast_to(expected, (len(points), 3)), rtol=0, atol=1e-12)


def values(shape, points=POINTS):
    return shape(points)[:, 0]


def where(condition, yes, no):
    return np.where(np.reshape(condition, (-1, 1)), yes, no)


def mix(a, b, h):
    return a + (b - a) * np.reshape(h, (-1, 1))


def places(p):
    """A colour that encodes a point's position."""
    return np.stack([np.sin(p[:, 0]), np.cos(p[:, 1]), np.sin(p[:, -1] + 1)], axis=1) * 0.5 + 0.5


def painted(shape):
    return shape.color(places)


# ---- One shape -------------------------------------------------------------------------------------------


def test_colors_are_given_as_text_numbers_and_functions():
    agree(sphere(1).color("#c33"), from_srgb(np.array((0xCC, 0x33, 0x33)) / 255))
    agree(sphere(1).color("#1a2b3c"), from_srgb(np.array((0x1A, 0x2B, 0x3C)) / 255))
    agree(sphere(1).color((0.25, 0.5, 1)), (0.25, 0.5, 1))
    agree(sphere(1).color(np.array((0, 0, 1))), BLUE)
    agree(painted(sphere(1)), places(POINTS))
    agree(sphere(1).color(lambda p: (p[:, 0], 0.5, p[:, 1] / 0)), np.clip(np.c_[POINTS[:, 0], POINTS[:, 0] * 0 + 0.5,
          POINTS[:, 1] > 0], 0, 1))  # fmt: skip
    agree(sphere(1).color(A.color_formula), RED)
    assert sphere(1).color_formula is None
    assert np.array_equal(colors(sphere(1).color("#c33"))[0], bob.Material("#c33").color)
    agree(A.color("#00f"), BLUE)


def test_formulas_of_x_y_and_z_have_colors():
    def f(x, y, z):
        return np.sqrt(x * x + y * y + z * z) - 1

    shape = bob.implicit(f, color=lambda x, y, z: (x, 0.5, np.where(z > 0, 2 * y, 0)))
    x, y, z = POINTS.T
    agree(shape, np.clip(np.stack([x, np.full(400, 0.5), np.where(z > 0, 2 * y, 0)], 1), 0, 1))
    agree(bob.implicit(f, color="#f00"), RED)
    agree(bob.Implicit(sphere(1).expression, color=(1, 0, 0)), RED)
    agree(bob.Implicit(sphere(1).expression, ((-1, -1, -1), (1, 1, 1)), shape.color_formula), colors(shape))
    agree(bob.implicit(f, color=lambda x, y, z: [z, z, z]), np.clip(POINTS[:, [2, 2, 2]], 0, 1))


def test_nan_is_black():
    assert (colors(sphere(1).color(lambda p: np.sqrt(-1 - p**2))) == 0).all()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: sphere(1).color("rot"), 'color: c: expected #rrggbb, a CSS name or 3 numbers, got "rot"'),
        (lambda: sphere(1).color("#12345"), 'color: c: expected #rrggbb, a CSS name or 3 numbers, got "#12345"'),
        (lambda: sphere(1).color((1, 2, 0)), r"color: c: expected numbers in 0..1, got \(1, 2, 0\)"),
        (lambda: sphere(1).color((np.nan, 0, 0)), "color: c: expected finite numbers"),
        (lambda: sphere(1).color(3), "color: c: expected #rrggbb, a CSS name or 3 numbers, got a number"),
        (lambda: sphere(1).color(), "color: c: expected #rrggbb, a CSS name or 3 numbers, got nothing"),
        (lambda: sphere(1).color(lambda p: p[:, 0]), "color: c: expected a function that returns red, green and blue"),
        (lambda: sphere(1).color(lambda p: p > 0), "color: c: .+ got a condition"),
        (
            lambda: bob.implicit(lambda x, y, z: x, color=lambda x, y, z: x),
            "color: expected a function that returns red",
        ),
        (lambda: bob.implicit(lambda x, y, z: x, color=lambda x: x), "color: expected a formula, got TypeError"),
        (
            lambda: bob.implicit(lambda x, y, z: x, color="#12"),
            "color: expected #rrggbb, a CSS name or 3 numbers, got '#12'",
        ),
        (lambda: bob.Implicit(sphere(1).expression, color=(0, 0, -1)), r"color: expected a number in \[0, 1\], got -1"),
        (
            lambda: bob.Implicit(sphere(1).expression, color=lambda x, y, z: x),
            "color: .+ got a function; bobrossnet.impl",
        ),
    ],
)
def test_wrong_colors_are_one_clear_line(make, message):
    with pytest.raises(bob.InputError, match=f"^{message}") as error:
        make()
    assert "\n" not in str(error.value)


# ---- Operations ------------------------------------------------------------------------------------------


def test_unions_show_the_lower_value():
    a, b = values(A), values(B)
    agree(A | B, where(b < a, BLUE, RED))
    agree(A | box(1.5).translate((0.7, 0.4, 0.3)), where(b < a, WHITE, RED))
    agree(sphere(1) | B, where(b < a, BLUE, WHITE))
    agree(A | A.color("#00f"), RED)  # the first if both are equal
    assert (sphere(1) | box(1)).color_formula is None


def test_intersections_show_the_higher_value_or_the_only_color():
    a, b = values(A), values(B)
    agree(A & B, where(b > a, BLUE, RED))
    agree(A & box(1.5), RED)
    agree(sphere(1) & B, BLUE)


def test_differences_have_the_color_of_the_tool_if_it_has_one():
    a, b = values(A), values(B)
    agree(A - B, where(-b > a, BLUE, RED))
    agree(A - box(1.5), RED)
    agree(sphere(1) - B, where(-b > a, BLUE, WHITE))


@pytest.mark.parametrize("k", [0.25, 1.5])
def test_smooth_operations_blend_by_the_h_of_distances(k):
    a, b = values(A), values(B)
    h = np.clip(0.5 + 0.5 * (b - a) / k, 0, 1)  # as in fogleman/sdf
    np.testing.assert_allclose(values(A | B.k(k)), b + (a - b) * h - k * h * (1 - h), atol=1e-12)
    agree(A | B.k(k), mix(BLUE, RED, h))
    agree(sphere(1).union(B, k=k), mix(BLUE, WHITE, h))
    h = np.clip(0.5 - 0.5 * (b - a) / k, 0, 1)
    agree(A & B.k(k), mix(BLUE, RED, h))
    h = np.clip(0.5 - 0.5 * (b + a) / k, 0, 1)
    np.testing.assert_allclose(values(A - B.k(k)), a + (-b - a) * h + k * h * (1 - h), atol=1e-12)
    agree(A - B.k(k), mix(RED, BLUE, h))


def test_mixtures_mix():
    agree(A.blend(B, k=0.25), mix(RED, BLUE, np.full(400, 0.25)))
    agree(A.blend(box(1)), mix(RED, WHITE, np.full(400, 0.5)))
    t = ease.in_out_quad(np.clip((POINTS[:, 2] + 1) / 2, 0, 1))
    agree(A.transition_linear(B, e=ease.in_out_quad), mix(RED, BLUE, t))
    t = np.clip(np.hypot(*POINTS[:, :2].T) / 1.5, 0, 1)
    agree(A.transition_radial(B, r1=1.5), mix(RED, BLUE, t))
    flat = rectangle(1).color(RED).extrude_to(circle(1).color(BLUE), 2)
    agree(flat, mix(RED, BLUE, np.clip(POINTS[:, 2] / 2, -0.5, 0.5) + 0.5))


def test_what_changes_values_alone_keeps_colors():
    both = A | B
    for shape in (both.negate(), both.dilate(0.2), both.erode(0.1), both.shell(0.1), both.k(0.3), both & box(1)):
        agree(shape, colors(both))
    assert both.k(0.3).color("#c33")._k == 0.3


TURN = np.array([[np.cos(0.5), np.sin(0.5), 0], [-np.sin(0.5), np.cos(0.5), 0], [0, 0, 1]])


def twisted(p, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * p[:, 0] - s * p[:, 1], s * p[:, 0] + c * p[:, 1], p[:, 2]], axis=1)


MOVES = {
    "translate": (lambda s: s.translate((1, 2, 3)), lambda p: p - (1, 2, 3)),
    "scale": (lambda s: s.scale((1, 2, 4)), lambda p: p / (1, 2, 4)),
    "rotate": (lambda s: s.rotate(0.5, Z), lambda p: p @ TURN.T),
    "rotate_to": (lambda s: s.rotate_to(X, X), lambda p: p),
    "orient": (lambda s: s.orient(-Z), lambda p: p * (-1, 1, -1)),
    "twist": (lambda s: s.twist(0.7), lambda p: twisted(p, 0.7 * p[:, 2])),
    "bend": (lambda s: s.bend(0.7), lambda p: twisted(p, 0.7 * p[:, 0])),
    "elongate": (lambda s: s.elongate((0.5, 0.25, 1)), lambda p: np.maximum(np.abs(p) - (0.5, 0.25, 1), 0)),
    "repeat": (lambda s: s.repeat((1, 2, 0)), lambda p: p - (1, 2, 0) * np.rint(p / (1, 2, 1))),
    "some repeat": (
        lambda s: s.repeat((1, 2, 0), count=1),
        lambda p: p - (1, 2, 0) * np.clip(np.rint(p / (1, 2, 1)), -1, 1),
    ),
    "bend_linear": (
        lambda s: s.bend_linear(-Z, Z, X, ease.in_quad),
        lambda p: p - np.clip((p[:, [2]] + 1) / 2, 0, 1) ** 2 * X,
    ),
    "bend_radial": (
        lambda s: s.bend_radial(0.5, 1.5, 2),
        lambda p: p - 2 * np.clip(np.hypot(p[:, [0]], p[:, [1]]) - 0.5, 0, 1) * Z,
    ),
    "wrap_around": (
        lambda s: s.wrap_around(-2, 2, r=1),
        lambda p: np.stack(
            [-2 + 4 * (np.arctan2(p[:, 1], p[:, 0]) + np.pi) / (2 * np.pi), 1 - np.hypot(*p[:, :2].T), p[:, 2]], axis=1
        ),
    ),
}


@pytest.mark.parametrize("name", MOVES)
def test_what_moves_points_moves_colors(name):
    operation, moved = MOVES[name]
    agree(operation(painted(box((1, 2, 3)))), places(moved(POINTS)))


def test_copies_have_the_color_of_the_nearest():
    shape = painted(sphere(0.3))
    offsets = [(i, j, 0) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    cell = POINTS - (1, 1, 0) * np.rint(POINTS / (1, 1, 1))
    nearest = np.argmin([values(shape, cell - offset) for offset in offsets], axis=0)
    expected = np.choose(nearest[:, None], [places(cell - offset) for offset in offsets])
    agree(shape.repeat((1, 1, 0), padding=1), expected)

    def turned(p, i, n):
        c, s = np.cos(2 * np.pi * i / n), np.sin(2 * np.pi * i / n)
        return np.stack([c * p[:, 0] + s * p[:, 1], c * p[:, 1] - s * p[:, 0], *p[:, 2:].T], axis=1)

    copies = [turned(POINTS, i, 5) - X for i in range(5)]
    nearest = np.argmin([values(shape, copy) for copy in copies], axis=0)
    agree(shape.circular_array(5, 1), np.choose(nearest[:, None], [places(copy) for copy in copies]))
    disk = painted(circle(0.3).translate((1, 0)))
    copies = [turned(POINTS[:, :2], -i, 5) for i in range(5)]
    nearest = np.argmin([disk(copy)[:, 0] for copy in copies], axis=0)
    agree(disk.circular_array(5).extrude(9), np.choose(nearest[:, None], [places(copy) for copy in copies]))


def test_colors_go_from_two_dimensions_to_three_and_back():
    flat = painted(rectangle((1, 2)))
    agree(flat.extrude(1), places(POINTS[:, :2]))
    agree(flat.revolve(0.5), places(np.stack([np.hypot(*POINTS[:, :2].T) - 0.5, POINTS[:, 2]], axis=1)))
    agree(painted(sphere(1)).slice().extrude(1), places(POINTS * (1, 1, 0)))
    agree((d2.circle(1).color(RED) | rectangle(1.9).color(BLUE)).extrude(1),
          where(rectangle(1.9)(POINTS[:, :2]) < circle(1)(POINTS[:, :2]), BLUE, RED))  # fmt: skip


@pytest.mark.parametrize("text", [text for text in COLORED if '"' not in text])
def test_distances_are_the_same_node_by_node(text):
    made, plain = _core.run_script(text.encode()), re.sub(r"\.color\(('.+?'|\(.+?\))\)", "", text)
    assert plain in SCRIPTS
    assert made.color is not None
    assert made.expression == _core.run_script(plain.encode()).expression


# ---- Custom words ----------------------------------------------------------------------------------------


def test_custom_operations_carry_colors():
    @op3
    def wavy(other, height):
        return lambda p: other(p) + height * np.sin(5 * p[:, [2]])

    @op3
    def swirled(other, k):
        return lambda p: other(twisted_symbols(p, k))

    def twisted_symbols(p, k):
        x, y, z = p[:, 0], p[:, 1], p[:, 2]
        c, s = np.cos(k * z), np.sin(k * z)
        return np.stack([c * x - s * y, s * x + c * y, z], axis=-1)

    @op3
    def joined(a, b):
        return lambda p: np.minimum(a(p), b(p))

    @op3
    def cut(a, b):
        return lambda p: np.maximum(a(p), -b(p))

    @op3
    def chosen(a, b):
        return lambda p: np.where(p[:, [2]] > 0, a(p), b(p))

    @op3
    def added(a, b):
        return lambda p: a(p) + 2 * b(p)

    assert A.wavy(0.1).expression == sphere(1).wavy(0.1).expression
    agree(A.wavy(0.1), RED)
    assert sphere(1).wavy(0.1).color_formula is None
    agree(painted(box(1)).swirled(0.7), colors(painted(box(1)).twist(0.7)))
    for made, expected in ((A.joined(B), A | B), (A.cut(B), A - B), (A.joined(box(1)), A | box(1))):
        assert made.expression.uses("select") == expected.expression.uses("select")
        agree(made, colors(expected))
    agree(A.cut(box(1)), RED)
    agree(A.chosen(B), where(POINTS[:, 2] > 0, RED, BLUE))
    agree(A.chosen(sphere(2)), where(POINTS[:, 2] > 0, RED, WHITE))
    agree(A.chosen(A), RED)
    assert A.added(B).color_formula is None


def test_custom_operations_between_dimensions_carry_colors():
    @op2
    def thick(other, by):
        return lambda p: np.abs(other(p)) - by

    @op23
    def pulled(other, h):
        def f(p):
            w = np.concatenate([other(p[:, [0, 1]]).reshape(-1, 1), np.abs(p[:, 2]).reshape(-1, 1) - h / 2], axis=1)
            return np.minimum(np.maximum(w[:, 0], w[:, 1]), 0) + np.linalg.norm(np.maximum(w, 0), axis=1)

        return f

    agree(painted(circle(1)).thick(0.1).pulled(1), places(POINTS[:, :2]))
    agree(SDF3(lambda p: np.minimum(A(p), B(p))), colors(A | B))
    agree(SDF3(A), RED)
    agree(SDF2(circle(1).color(RED)).extrude(1), RED)
    agree(SDF3(lambda p: p[:, 0], color=places), places(POINTS))


# ---- Scripts ---------------------------------------------------------------------------------------------

PROGRAM = """f = sphere(1).color("#c33") & box(1.5)
f -= cylinder(0.5).color((0, 0.25, 1)).k(0.1)
f |= capsule(-Z, Z, 0.2).color('#fd3').rotate(0.3, X)
"""


def test_scripts_make_the_colors_that_python_makes(tmp_path):
    (tmp_path / "a.sdf").write_text(PROGRAM)
    (shape,) = (instance.shape for instance in bob.load(tmp_path / "a.sdf").instances)
    names = {}
    exec("from bobrossnet.sdf import *\n" + PROGRAM, names)
    assert shape.color_formula == names["f"].color_formula
    assert shape.digest == names["f"].digest
    (tmp_path / "a.sdf").write_text("sphere(1).color('blau')")
    with pytest.raises(
        bob.InputError, match=r"a.sdf: line 1, column 11: color: c: expected #rrggbb, a CSS name or 3 numbers"
    ):
        bob.load(tmp_path / "a.sdf")


# ---- Pictures --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def shape():
    return (A - B.k(0.2)) | painted(torus(1.2, 0.2)) | capsule(-Z, Z, 0.2)


def test_hits_and_normals_have_the_same_bits(shape):
    plain = (sphere(1) - box(1.5).translate((0.7, 0.4, 0.3)).k(0.2)) | torus(1.2, 0.2) | capsule(-Z, Z, 0.2)
    assert shape.expression == plain.expression
    camera = bob.Camera(azimuth=30, fov=40)
    seen, expected = bob.trace(shape, camera, size=SIZE), bob.trace(plain, camera, size=SIZE)
    assert seen.channels == ("mask", "gray", "depth", "normal", "color", "albedo")
    assert expected.channels == ("mask", "gray", "depth", "normal")
    for channel in ("mask", "depth", "normal"):
        assert np.array_equal(seen.channel(channel), expected.channel(channel))
    assert shape.cells == plain.cells


def test_pictures_show_the_formula_at_the_hits(shape):
    scene = bob.Scene(bob.Instance(shape, material=bob.Material((1, 0.5, 0.25))).scale(3).translate((5, 0, 0)))
    seen = bob.trace(scene, bob.Camera(azimuth=0, elevation=0), size=(100, 100))
    row, column = np.nonzero(seen.alpha)
    across, up = (column + 0.5 - 50) / 50, (50 - 0.5 - row) / 50
    origins = scene.center + scene.radius * np.stack([np.full(len(row), 3), across, up], axis=1)
    t = scene.closest_hits(origins, np.broadcast_to((-1, 0, 0), origins.shape)).distance
    found = np.isfinite(t)
    points = (origins - t[:, None] * X - (5, 0, 0))[found] / 3
    expected = colors(shape, points) * (1, 0.5, 0.25)
    different = np.abs(seen.albedo[row, column][found] - expected).max(axis=1) > 1e-4
    assert found.mean() > 0.99
    assert different.mean() < 0.01  # where colours meet
    assert len(np.unique(expected.round(2), axis=0)) > 50


def test_everything_that_shows_colors_shows_them(shape):
    rendered = np.asarray(bob.render(bob.Instance(A), size=SIZE))
    red, green, blue = rendered[30, 40, :3]
    assert red > 2 * max(green, blue)
    *_, frame = bob.progressive(A, size=SIZE)
    assert frame.gbuffer.color[30, 40, 0] > 2 * frame.gbuffer.color[30, 40, 1]
    view = bob.View(shape, size=SIZE)
    for azimuth in (30, 32):  # reprojected samples are shaded again
        seen = view.frame(bob.Camera(azimuth=azimuth), fraction=1)
    assert np.array_equal(seen.gbuffer.albedo, bob.trace(shape, bob.Camera(azimuth=32), size=SIZE).albedo)


# ---- Meshes ----------------------------------------------------------------------------------------------


def test_meshes_have_the_colors_at_their_vertices(shape):
    mesh = shape.mesh(0.05)
    expected = colors(shape, mesh.vertices)
    assert mesh.colors.dtype == np.float32
    assert (np.abs(mesh.colors - expected).max(axis=1) > 1e-4).mean() < 0.01
    assert sphere(1).mesh(0.1).colors is None
    plain = (sphere(1) - box(1.5).translate((0.7, 0.4, 0.3)).k(0.2)) | torus(1.2, 0.2) | capsule(-Z, Z, 0.2)
    assert np.array_equal(plain.mesh(0.05).vertices, mesh.vertices)
    whole = bob.Scene([bob.Instance(shape).translate(X), bob.Instance(sphere(1), material=bob.Material("#0f0"))])
    both = whole.mesh(0.1)
    assert (both.colors[-1] == (0, 1, 0)).all()
    assert np.array_equal(both.colors[: len(shape.mesh(0.1).vertices)], shape.mesh(0.1).colors)
    assert bob.Scene(sphere(1)).mesh(0.1).colors is None


@pytest.mark.parametrize("ending", ["ply", "obj", "glb"])
def test_files_of_meshes_hold_the_colors(shape, ending, tmp_path):
    mesh = shape.mesh(0.1)
    mesh.save(tmp_path / f"a.{ending}")
    again = bob.load_mesh(tmp_path / f"a.{ending}")
    assert len(again.vertices) == len(mesh.vertices)
    order = [np.lexsort(np.round(m.vertices.T, 4)) for m in (mesh, again)]
    ours, theirs = mesh.colors[order[0]], again.colors[order[1]]
    if ending != "glb":
        ours, theirs = to_srgb(ours), to_srgb(theirs)
    assert (np.abs(ours - theirs).max(axis=1) < 0.6 / 255).mean() > 0.99  # except for the order of close vertices
    mesh.save(tmp_path / "a.stl")
    shape.save(tmp_path / f"b.{ending}", step=0.1)
    assert (tmp_path / f"b.{ending}").read_bytes() == (tmp_path / f"a.{ending}").read_bytes()


def test_pictures_that_shapes_save_are_in_color(tmp_path):
    from PIL import Image

    A.save(tmp_path / "a.png", size=SIZE)
    picture = np.asarray(Image.open(tmp_path / "a.png").convert("RGB"))
    assert np.array_equal(picture, color_to_8_bit(bob.trace(A, size=SIZE).color))
    assert picture[..., 0].max() > 2 * picture[30, 40, 1]


# ---- Files -----------------------------------------------------------------------------------------------


def test_scene_files_hold_the_formula(shape, tmp_path):
    bob.save_scene([bob.Instance(shape), bob.Instance(shape).translate(3 * X), sphere(0.5)], tmp_path / "a.bob")
    again = bob.load(tmp_path / "a.bob")
    assert again.instances[0].shape.color_formula == shape.color_formula
    assert again.instances[0].shape.digest == shape.digest
    data = (tmp_path / "a.bob").read_bytes()
    header = json.loads(data[8 : 8 + int.from_bytes(data[:8], "little")])
    assert header["__metadata__"]["version"] == "2"
    assert {name for name in header if name.startswith("0.color")} == {
        "0.color_ops", "0.color_operands", "0.color_values", "0.color_roots"
    }  # fmt: skip
    bob.save_scene(again, tmp_path / "b.bob")
    assert (tmp_path / "b.bob").read_bytes() == data
    bob.save_scene(sphere(0.5), tmp_path / "c.bob")
    data = (tmp_path / "c.bob").read_bytes()
    assert b'"version":"1"' in data
    assert b"color_" not in data


def test_wrong_color_tensors_are_refused(tmp_path):
    tensors = {f"0.{name}": tensor for name, tensor in A.tensors().items()}
    instance = {"shape": 0, "transform": np.eye(4).tolist(), "material": None, "name": None}
    instance["material"] = {"color": [1, 1, 1], "ambient": 0.1, "diffuse": 0.7, "specular": 0.2, "shininess": 32}

    def told(changed):
        scene = {"shapes": ["implicit"], "instances": [instance]}
        given = {name: tensor for name, tensor in {**tensors, **changed}.items() if tensor is not None}
        (tmp_path / "a.bob").write_bytes(sealed(layout(scene, given, "2")))
        with pytest.raises(bob.InputError) as error:
            bob.load(tmp_path / "a.bob")
        return str(error.value).removeprefix("a.bob: shapes[0]: ")

    assert told({"0.color_roots": None}) == "color_roots: expected an array of uint32, got none"
    assert told({"0.color_ops": None}).startswith("color_ops: expected an array of uint8, got none")
    roots = np.array((0, 1, 9), np.uint32)
    assert told({"0.color_roots": roots}) == "color: expected red, green and blue among the nodes, got a later one"
    assert told({"0.color_ops": np.array((99, 0), np.uint8)}).startswith("color: node 0: expected an op")
    assert told({"0.color_roots": np.zeros(4, np.uint32)}).startswith("color: ")
    assert told({"0.color_roots": np.zeros(3)}).startswith("color_roots: expected uint32")


def test_copies_are_equal(shape):
    for again in (pickle.loads(pickle.dumps(shape)), copy.deepcopy(shape), shape.k(0.1), SDF3(shape)):
        assert again.color_formula == shape.color_formula
        assert hash(again.color_formula) == hash(shape.color_formula)
        assert again.digest == shape.digest
    flat = pickle.loads(pickle.dumps(circle(1).color("#f00")))
    assert flat.color_formula == circle(1).color("#f00").color_formula
    assert A.digest != sphere(1).digest
    assert A.digest != A.color("#f01").digest
    assert "colours" in A.describe()
    assert "color=<ColorFormula of 2 steps>" in repr(bob.Implicit(A.expression, color=A.color_formula))


def test_coincident_shapes_are_seen_in_the_order_of_their_digests():
    pair = [sphere(1).color("#f00"), sphere(1).color("#00f")]
    seen = [bob.trace(scene, size=SIZE) for scene in (pair, pair[::-1])]
    assert seen[0] == seen[1]
