"""Files of NURBS surfaces: loaded shapes, and one-line errors."""

from __future__ import annotations

import copy
import csv
import json
import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from models import MODELS, needs_models

import bobrossnet as bob
from bobrossnet.adapters.files import INSTANCE_READERS, load_mesh
from bobrossnet.command_line import cli
from bobrossnet.shapes.nurbs import Face

U, V = (x.ravel() for x in np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 7)))

# A quarter of a cylinder: radius 1 along u, height 2 along v.
CYLINDER: dict[str, Any] = {
    "rational": True,
    "dimension": 3,
    "degree_u": 2,
    "degree_v": 1,
    "knotvector_u": [0, 0, 0, 1, 1, 1],
    "knotvector_v": [0, 0, 1, 1],
    "size_u": 3,
    "size_v": 2,
    "control_points": {
        "points": [[1, 0, 0], [1, 0, 2], [1, 1, 0], [1, 1, 2], [0, 1, 0], [0, 1, 2]],
        "weights": [1, 1, 0.5**0.5, 0.5**0.5, 1, 1],
    },
}

# A circle's control points, by quarters.
AROUND = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]

# Two patches: z = x y over a unit square; and x = p, y = q² + 1, z = 3 p, linear along p.
BPT = """2
1 1
0 0 0
0 1 0
1 0 0
1 1 1
1 2
0 1 0
0 1 0
0 2 0
1 1 3
1 1 3
1 2 3
"""

CPT = "0,0,0; 0,1,0; 0,2,2\n\n1,0,0;1,1,0;1,2,2\n"

# The same cylinder; its height is along basis 1, and basis 0 varies fastest.
GISMO = """
<?xml version="1.0" encoding="UTF-8"?>
<xml>
 <Geometry type="TensorNurbs2" id="0">
  <Basis type="TensorNurbsBasis2">
   <Basis type="TensorBSplineBasis2">
    <Basis type="BSplineBasis" index="0">
     <KnotVector degree="2">0 0 0 1 1 1 </KnotVector>
    </Basis>
    <Basis type="BSplineBasis" index="1">
     <KnotVector degree="1">0	0 1 1 </KnotVector>
    </Basis>
   </Basis>
   <weights>1 0.70710678118654752 1
     1 0.70710678118654752 1</weights>
  </Basis>
  <coefs geoDim="3">1 0 0
1 1 0
0 1 0
1 0 2
1 1 2
0 1 2 </coefs>
 </Geometry>
</xml> <!-- <Geometry type="TensorBSpline2"></Geometry> -->
"""


def geomdl_json(*surfaces: dict[str, Any], kind: str = "surface") -> str:
    return json.dumps({"shape": {"type": kind, "count": len(surfaces), "data": surfaces}})


def written(path: Path, content: str | bytes) -> Path:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def faces_of(file: Path) -> tuple[Face, ...]:
    (instance,) = bob.load(file).instances
    assert instance.name == file.name
    assert instance.shape.kind == "brep"
    return instance.shape.faces


def error_of(file: Path) -> str:
    """Return the error message, after checks common to all errors."""
    with pytest.raises(bob.InputError) as caught:
        bob.load(file)
    message = str(caught.value)
    assert message.isprintable()
    assert len(message) < 400
    assert message.startswith(file.name + ": ")
    assert "could not read it" not in message or "expected a" in message
    return message


def degrees(face: Face) -> tuple[int, int]:
    return face.degree_u, face.degree_v


def kept(face: Face, u: float, v: float) -> bool:
    """Return whether an odd number of loops, all of straight lines, encloses a point."""
    inside = False
    for loop in face.trims:
        corners = np.concatenate([curve.control_points for curve in loop])
        for (u0, v0), (u1, v1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            if (v0 > v) != (v1 > v) and u < u0 + (v - v0) / (v1 - v0) * (u1 - u0):
                inside = not inside
    return inside


def square(low: float, high: float) -> list[list[float]]:
    return [[low, low], [high, low], [high, high], [low, high], [low, low]]


# ---- geomdl's JSON ---------------------------------------------------------------------------------------


def test_json_of_a_cylinder(tmp_path: Path) -> None:
    (face,) = faces_of(written(tmp_path / "a.JSON", geomdl_json(CYLINDER)))
    x, y, z = face.points(U, V).T
    assert np.allclose(np.hypot(x, y), 1, atol=1e-14)
    assert np.allclose(z, 2 * V, atol=1e-14)
    assert degrees(face) == (2, 1)
    assert face.trims == ()


def test_json_is_what_geomdl_wrote(tmp_path: Path) -> None:
    nurbs, bspline, exchange = (pytest.importorskip(f"geomdl.{name}") for name in ("NURBS", "BSpline", "exchange"))
    rng = np.random.default_rng(0)
    surfaces = []
    for make in (nurbs.Surface, bspline.Surface):
        surface = make()
        surface.degree_u, surface.degree_v = 3, 2
        surface.ctrlpts_size_u, surface.ctrlpts_size_v = 6, 4
        surface.ctrlpts = rng.uniform(-1, 1, (24, 3)).tolist()
        if make is nurbs.Surface:
            surface.weights = rng.uniform(0.5, 2, 24).tolist()
        surface.knotvector_u = [0, 0, 0, 0, 0.2, 0.7, 1, 1, 1, 1]
        surface.knotvector_v = [0, 0, 0, 0.4, 1, 1, 1]
        surfaces.append(surface)
    multi = pytest.importorskip("geomdl.multi").SurfaceContainer(surfaces)
    exchange.export_json(multi, str(tmp_path / "a.json"))
    for face, surface in zip(faces_of(tmp_path / "a.json"), surfaces, strict=True):
        expected = surface.evaluate_list(np.stack([U, V], axis=1).tolist())
        assert np.allclose(face.points(U, V), expected, atol=1e-14)
    assert [face.weights is None for face in faces_of(tmp_path / "a.json")] == [False, True]


def test_json_with_trims_that_geomdl_wrote(tmp_path: Path) -> None:
    nurbs, bspline, exchange, freeform, multi = (
        pytest.importorskip(f"geomdl.{name}") for name in ("NURBS", "BSpline", "exchange", "freeform", "multi")
    )
    circle = nurbs.Curve()
    circle.degree = 2
    s = 0.5**0.5
    circle.ctrlpts = [[0.3 + 0.1 * x, 0.3 + 0.1 * y] for x, y in AROUND]
    circle.weights = [1, s, 1, s, 1, s, 1, s, 1]
    circle.knotvector = [0, 0, 0, 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1, 1, 1]
    polygon = freeform.Freeform()
    polygon.evaluate(points=square(0.6, 0.9))
    line, arc = bspline.Curve(), bspline.Curve()
    line.degree, line.ctrlpts, line.knotvector = 1, [[0.6, 0.1], [0.9, 0.1]], [0, 0, 1, 1]
    arc.degree, arc.ctrlpts, arc.knotvector = 2, [[0.9, 0.1], [0.75, 0.5], [0.6, 0.1]], [0, 0, 0, 1, 1, 1]
    surface = bspline.Surface()
    surface.degree_u, surface.degree_v = 1, 1
    surface.ctrlpts_size_u, surface.ctrlpts_size_v = 2, 2
    surface.ctrlpts = [[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]]
    surface.knotvector_u = surface.knotvector_v = [0, 0, 1, 1]
    surface.trims = [circle, polygon, multi.CurveContainer([line, arc])]
    exchange.export_json(surface, str(tmp_path / "a.json"))

    (face,) = faces_of(tmp_path / "a.json")
    (read,), lines, (first, second), around = face.trims
    for curve, original in ((read, circle), (first, line), (second, arc)):
        assert curve.control_points.tolist() == np.array(original.ctrlpts).tolist()
        assert curve.knots.tolist() == original.knotvector
    assert read.weights is not None
    assert read.weights.tolist() == circle.weights
    assert first.weights is None
    corners = np.concatenate([curve.control_points for curve in lines])
    assert np.unique(corners, axis=0).tolist() == np.unique(square(0.6, 0.9), axis=0).tolist()
    # All are holes, so they need an enclosing loop, larger than the surface.
    corners = np.concatenate([curve.control_points for curve in around])
    assert (corners.min(axis=0) < 0).all()
    assert (corners.max(axis=0) > 1).all()


@pytest.mark.parametrize(
    ("senses", "expected"),
    [
        ([None], [True, False, False]),  # points in no square, in the outer one, in both
        ([0], [True, False, False]),
        ([1], [False, True, True]),
        ([1, 0], [False, True, False]),
        ([True, None], [False, True, False]),
    ],
)
def test_trims_keep_what_geomdl_keeps(senses: list[Any], expected: list[bool], tmp_path: Path) -> None:
    trims: list[dict[str, Any]] = []
    for sense, (low, high) in zip(senses, ((1.0, 9.0), (4.0, 6.0)), strict=False):
        trims.append({"type": "freeform", "points": square(low, high)})
        if sense is not None:
            trims[-1]["reversed"] = sense
    surface = CYLINDER | {"knotvector_u": [0, 0, 0, 10, 10, 10], "knotvector_v": [0, 0, 10, 10]}
    surface["trims"] = {"count": len(trims), "data": trims}
    (face,) = faces_of(written(tmp_path / "a.json", geomdl_json(surface)))
    assert [kept(face, 0.5, 5), kept(face, 2, 5), kept(face, 5, 5)] == expected


def test_a_hole_is_seen_through(tmp_path: Path) -> None:
    flat = CYLINDER | {"control_points": {"points": [[x, y, 0] for x in (0, 5, 10) for y in (0, 10)]}}
    circle = {
        "type": "spline",
        "degree": 2,
        "knotvector": [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4],
        "control_points": {
            "points": [[x / 10 + 0.5, y / 10 + 0.5] for x, y in AROUND],
            "weights": [1, 0.5**0.5, 1, 0.5**0.5, 1, 0.5**0.5, 1, 0.5**0.5, 1],
        },
    }
    file = written(tmp_path / "a.json", geomdl_json(flat | {"trims": {"count": 1, "data": [circle]}}))
    x, y = np.random.default_rng(0).uniform(0, 10, (2, 1000))
    distance = bob.load(file).closest_hits(np.stack([x, y, 1 + 0 * x], axis=1), [[0, 0, -1]] * 1000).distance
    beside = np.hypot(x - 5, y - 5) - 1
    sure = np.abs(beside) > 1e-4
    assert np.array_equal(np.isfinite(distance)[sure], (beside > 0)[sure])
    assert (beside < 0).sum() > 10


def test_surfaces_without_their_trims_are_counted(tmp_path: Path) -> None:
    file = written(tmp_path / "a.json", geomdl_json(*[CYLINDER | {"trimmed": n < 2} for n in range(3)]))
    expected = r"^a\.json: 2 of 3 faces are trimmed, but the file has no trim curves: they are shown whole$"
    with pytest.warns(bob.InputWarning, match=expected) as caught:
        faces = faces_of(file)
    assert len(caught) == 1
    assert [face.trims for face in faces] == [(), (), ()]


def test_surfaces_with_names_are_shapes_of_their_own(tmp_path: Path) -> None:
    surfaces = [CYLINDER | ({"name": name} if name else {}) for name in ("lid", "", "pot", "lid")]
    instances = bob.load(written(tmp_path / "a.json", geomdl_json(*surfaces))).instances
    assert {instance.name: len(instance.shape.faces) for instance in instances} == {"lid": 2, "a.json": 1, "pot": 1}


# ---- Bezier patches and grids ----------------------------------------------------------------------------


def test_bezier_patches(tmp_path: Path) -> None:
    one, other = faces_of(written(tmp_path / "a.bpt", BPT))
    assert np.allclose(one.points(U, V), np.stack([U, V, U * V], axis=1), atol=1e-15)
    assert np.allclose(other.points(U, V), np.stack([U, V**2 + 1, 3 * U], axis=1), atol=1e-15)
    assert (degrees(one), degrees(other)) == ((1, 1), (1, 2))


def test_a_grid_of_few_points_has_low_degrees(tmp_path: Path) -> None:
    (face,) = faces_of(written(tmp_path / "a.cpt", CPT))
    assert degrees(face) == (1, 2)
    assert np.allclose(face.points(U, V), np.stack([U, 2 * V, 2 * V**2], axis=1), atol=1e-15)


def test_a_grid_is_what_geomdl_makes_of_it(tmp_path: Path) -> None:
    bspline, utilities = pytest.importorskip("geomdl.BSpline"), pytest.importorskip("geomdl.utilities")
    rng = np.random.default_rng(0)
    surface = bspline.Surface()
    surface.degree_u = surface.degree_v = 3
    surface.ctrlpts_size_u, surface.ctrlpts_size_v = 7, 5
    surface.ctrlpts = rng.uniform(-1, 1, (35, 3)).tolist()
    surface.knotvector_u, surface.knotvector_v = (utilities.generate_knot_vector(3, n) for n in (7, 5))
    pytest.importorskip("geomdl.exchange").export_txt(surface, str(tmp_path / "a.cpt"), two_dimensional=True)
    (face,) = faces_of(tmp_path / "a.cpt")
    assert np.allclose(face.points(U, V), surface.evaluate_list(np.stack([U, V], axis=1).tolist()), atol=1e-14)


# ---- G+Smo's XML -----------------------------------------------------------------------------------------


def test_xml_of_a_cylinder(tmp_path: Path) -> None:
    (face,) = faces_of(written(tmp_path / "a.xml", GISMO))
    x, y, z = face.points(U, V).T
    assert np.allclose(np.hypot(x, y), 1, atol=1e-14)
    assert np.allclose(z, 2 * V, atol=1e-14)


def test_xml_of_several_surfaces(tmp_path: Path) -> None:
    flat = re.sub(r"(?s)<weights>.*</weights>", "", GISMO).replace('geoDim="3"', 'geoDim="2"')
    flat = re.sub(r" [02]\n", "\n", flat).replace("0 1 2 </coefs>", "0 1</coefs>")
    both = flat.replace("</xml>", GISMO.partition("<xml>")[2].partition("</xml>")[0] + "</xml>")
    volume = '<Geometry type="TensorBSpline3" id="7"></Geometry>'
    with pytest.warns(bob.InputWarning, match=r"^a\.xml: left out 1 of 3 geometries .* TensorBSpline3$"):
        first, second = faces_of(written(tmp_path / "a.xml", both.replace("<xml>", "<xml>" + volume)))
    assert first.weights is None
    assert second.weights is not None
    assert (first.points(U, V)[:, 2] == 0).all()
    assert second.points(U, V)[:, 2].max() == 2


BOMB = '<!DOCTYPE a [<!ENTITY a "aaaaaaaaaa">' + "".join(
    f'<!ENTITY {name} "{10 * f"&{of};"}">' for name, of in zip("bcdefghijk", "abcdefghij", strict=True)
)
OUTSIDE = '<!DOCTYPE a [<!ENTITY a SYSTEM "file:///etc/hostname">'


@pytest.mark.parametrize("entities", [BOMB, OUTSIDE], ids=["bomb", "outside"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_xml_with_entities_is_refused(entities: str, encoding: str, tmp_path: Path) -> None:
    text = f'{entities}]><xml><Geometry type="TensorBSpline2"><coefs>&{"k" if entities is BOMB else "a"};</coefs>'
    error = error_of(written(tmp_path / "a.xml", (text + "</Geometry></xml>").encode(encoding)))
    assert "expected XML without a document type and entities, got some" in error or encoding != "utf-8"


# ---- Errors ----------------------------------------------------------------------------------------------


def changed(**fields: Any) -> str:
    """Return the cylinder with changed fields, None to delete; `points` and `weights` are its control points'."""
    surface = copy.deepcopy(CYLINDER)
    for name, value in fields.items():
        holder = surface["control_points"] if name in ("points", "weights") else surface
        if value is None:
            del holder[name]
        else:
            holder[name] = value
    return geomdl_json(CYLINDER, surface)


def trimmed(**trim: Any) -> str:
    return changed(trims={"count": 1, "data": [trim]})


NAN, INF = float("nan"), float("inf")
LINE = {"degree": 1, "knotvector": [0, 0, 1, 2, 2], "control_points": {"points": [[0, 0], [1, 0], [1, 1]]}}

WRONG: dict[str, tuple[str, str | bytes, str]] = {
    "no object": (".json", "[]", "expected an object with shape, got list"),
    "no shape": (".json", '{"asset": {}}', "shape: expected one, got none"),
    "no JSON": (".json", "solid", "expected JSON, got something else"),
    "no UTF-8": (
        ".json",
        '{"shape": "\xff"}'.encode("latin-1").decode("latin-1"),
        "shape: expected an object, got str",
    ),
    "curves": (".json", geomdl_json({}, kind="curve"), "expected surfaces, got curves, which have no radius"),
    "volumes": (".json", geomdl_json({}, kind="volume"), "type: expected surface, got volume"),
    "no surfaces": (".json", geomdl_json(), "data: expected surfaces, got none"),
    "another count": (".json", geomdl_json(CYLINDER).replace('count": 1', 'count": 1000000000'), "count: expected 1"),
    "no surface": (".json", geomdl_json([1]), "surface 1: expected an object with size_u, got list"),  # type: ignore[arg-type]
    "no degree": (".json", changed(degree_u=None), "surface 2: degree_u: expected one, got none"),
    "degree 0": (".json", changed(degree_v=0), "surface 2: degree_v: expected an integer in 1..9, got 0"),
    "degree 10": (".json", changed(degree_v=10), "surface 2: degree_v: expected an integer in 1..9, got 10"),
    "half a degree": (".json", changed(degree_v=1.5), "surface 2: degree_v: expected an integer, got float 1.5"),
    "another degree": (".json", changed(degree_u=1), "surface 2: knotvector_u: expected shape (5,), got (6,)"),
    "no knots": (".json", changed(knotvector_v=None), "surface 2: knotvector_v: expected one, got none"),
    "words for knots": (".json", changed(knotvector_v=["a", 0, 1, 1]), "surface 2: knotvector_v: expected lists of"),
    "knots that fall": (".json", changed(knotvector_u=[0, 0, 0, 1, 1, 0]), "surface 2: knots_u: expected"),
    "NaN for a knot": (".json", changed(knotvector_u=[0, 0, 0, NAN, 1, 1]), "expected JSON, got NaN"),
    "one knot often": (".json", changed(knotvector_v=[1, 1, 1, 1]), "surface 2: knots_v: expected"),
    "another size": (".json", changed(size_v=3), "surface 2: knotvector_v: expected shape (5,), got (4,)"),
    "huge size": (".json", changed(size_v=10**9), "surface 2: knotvector_v: expected shape (1000000002,), got (4,)"),
    "size below 0": (".json", changed(size_v=-2), "surface 2: size_v: expected an integer in"),
    "no points": (".json", changed(points=None), "surface 2: points: expected one, got none"),
    "points missing": (".json", changed(points=[[1, 0, 0]] * 5), "points: expected shape (6, 3), got (5, 3)"),
    "flat points": (".json", changed(points=[[1, 0]] * 6), "points: expected shape (6, 3), got (6, 2)"),
    "ragged points": (
        ".json",
        changed(points=[[1, 0, 0]] * 5 + [[1]]),
        "points: expected lists of numbers, all of one",
    ),
    "words for points": (".json", changed(points=[["a", 0, 0]] * 6), "points: expected lists of numbers"),
    "null for points": (".json", changed(points=[[None, 0, 0]] * 6), "points: expected lists of numbers"),
    "true for points": (".json", changed(points=[[True, 0, 0]] * 6), "points: expected lists of numbers"),
    "an object for points": (".json", changed(points=[{}] * 6), "points: expected lists of numbers"),
    "large integers": (".json", changed(points=[[10**400, 0, 0]] * 6), "points: expected lists of numbers"),
    "infinite points": (
        ".json",
        changed(points=[[INF, 0, 0]] * 6).replace("Infinity", "1e999"),
        "surface 2: control_points: expected finite",
    ),
    "weights missing": (".json", changed(weights=[1] * 5), "surface 2: weights: expected shape (6,), got (5,)"),
    "NaN for a weight": (".json", changed(weights=[1, 1, NAN, 1, 1, 1]), "expected JSON, got NaN"),
    "a weight of 0": (".json", changed(weights=[1, 1, 0, 1, 1, 1]), "surface 2: weights: expected"),
    "a weight below 0": (".json", changed(weights=[1, 1, -1, 1, 1, 1]), "surface 2: weights: expected"),
    "a number for a name": (".json", changed(name=5), "surface 2: name: expected a string, got int"),
    "trims of no list": (".json", changed(trims=[1]), "surface 2: trims: expected an object, got list"),
    "a trim of no type": (".json", trimmed(points=square(0, 1)), "surface 2: trims[0]: type: expected one, got none"),
    "a trim of another": (".json", trimmed(type="x"), "surface 2: trims[0][0]: type: expected spline, freeform or a"),
    "a trim in a trim": (
        ".json",
        trimmed(type="container", data=[{"type": "container", "data": []}]),
        "surface 2: trims[0][0]: type: expected spline, freeform or a container of these, got container",
    ),
    "an empty trim": (".json", trimmed(type="container", data=[]), "surface 2: trims"),
    "a trim in space": (
        ".json",
        trimmed(type="freeform", points=[[0, 0, 0]] * 4),
        "trims[0][0]: points: expected",
    ),
    "a trim's degree": (
        ".json",
        trimmed(type="spline", **LINE | {"degree": 3}),
        "trims[0][0]: knotvector: expected",
    ),
    "a trim's knots": (
        ".json",
        trimmed(type="spline", **LINE | {"knotvector": [0, 0, NAN, 2, 2]}),
        "expected JSON, got NaN",
    ),
    "nested": (".json", '{"shape":' + "[" * 100_000, "got data nested too deeply"),
    "nested points": (".json", changed(points=json.loads("[" * 100 + "]" * 100)), "points: expected"),
    "no number": (".bpt", "", "expected a scene, got an empty file"),
    "blanks": (
        ".bpt",
        " \n\n",
        "number of patches: expected a whole number of at most 9 digits, got the end of the file",
    ),
    "no patches": (".bpt", "0\n", "expected some patches, got none"),
    "huge count": (
        ".bpt",
        BPT.replace("2\n", "999999999\n", 1),
        "patch 3 of 999999999: degree: expected a whole",
    ),
    "huger count": (
        ".bpt",
        BPT.replace("2\n", "9999999999\n", 1),
        "number of patches: expected a whole number of at most 9 digits",
    ),
    "too few": (".bpt", BPT.replace("2\n", "1\n", 1), "expected 1 patches, got more"),
    "count below 0": (
        ".bpt",
        BPT.replace("2\n", "-2\n", 1),
        "number of patches: expected a whole number of at most 9 digits, got -2",
    ),
    "huge degree": (".bpt", BPT.replace("1 1\n", "1 99999\n", 1), "patch 1 of 2: degree: expected 1..9 twice"),
    "no degrees": (".bpt", BPT.replace("1 1\n", "\n", 1), "patch 1 of 2: degree: expected 1..9 twice, got 0 and 0"),
    "a point less": (".bpt", BPT[:-6], "patch 2 of 2: expected 6 points, got the end of the file"),
    "a word in it": (".bpt", BPT.replace("1 1 1", "1 1 x"), "patch 1 of 2: expected a number, got 'x'"),
    "NaN in it": (".bpt", BPT.replace("1 1 1", "1 1 nan"), "patch 1 of 2: control_points: expected finite numbers"),
    "one point": (".bpt", "1 1 1" + " 1 2 3" * 4, "faces: expected at least one face"),
    "no rows": (".cpt", " \n", "expected at least 2 x 2 points, got 0 x 0"),
    "one row": (".cpt", CPT.splitlines()[0], "expected at least 2 x 2 points, got 1 x 3"),
    "one column": (".cpt", "0,0,0\n0,1,0\n", "expected at least 2 x 2 points, got 2 x 1"),
    "rows of two lengths": (".cpt", CPT[:-7], "row 2: expected 3 points as in the first row, got 2"),
    "two coordinates": (".cpt", CPT.replace("0,1,0", "0,1"), "row 1: expected points of three numbers"),
    "no coordinate": (".cpt", CPT.replace("0,1,0", "0,,0"), "row 1: expected a number, got ''"),
    "infinity": (".cpt", CPT.replace("0,1,0", "0,inf,0"), "control_points: expected finite numbers"),
    "no XML": (".xml", "solid", "expected XML, got something else"),
    "other XML": (".xml", "<svg/>", "expected a Geometry of type TensorBSpline2 or TensorNurbs2, got none"),
    "a volume": (".xml", GISMO.replace("Nurbs2", "Nurbs3"), "or TensorNurbs2, got TensorNurbs3"),
    "no basis 1": (".xml", GISMO.replace('index="1"', 'index="2"'), "Geometry 1: Basis 1: expected a KnotVector"),
    "no KnotVector": (".xml", GISMO.replace("KnotVector", "Knots"), "Geometry 1: Basis 0: expected a KnotVector"),
    "KnotVector's degree": (
        ".xml",
        GISMO.replace('degree="2"', ""),
        "KnotVector 0: degree: expected an integer in",
    ),
    "degree too high": (
        ".xml",
        GISMO.replace('degree="2"', 'degree="3"'),
        "expected at least 8 knots for degree 3",
    ),
    "degree too low": (".xml", GISMO.replace('degree="2"', 'degree="1"'), "coefs: expected 2 x 4 x 3 numbers, got 18"),
    "no knots at all": (".xml", GISMO.replace("0 0 0 1 1 1", ""), "KnotVector 0: expected at least 6 knots"),
    "words in knots": (".xml", GISMO.replace("0 0 0 1 1 1", "0 0 0 a 1 1"), "KnotVector 0: expected a number, got 'a'"),
    "falling knots": (".xml", GISMO.replace("0 0 0 1 1 1", "0 0 0 1 1 0"), "Geometry 1: knots_u: expected"),
    "no coefs": (".xml", GISMO.replace("coefs", "points"), "Geometry 1: coefs: expected coefficients, got none"),
    "coefs missing": (".xml", GISMO.replace("1 1 2\n", ""), "coefs: expected 2 x 3 x 3 numbers, got 15"),
    "other geoDim": (".xml", GISMO.replace('geoDim="3"', 'geoDim="9999999999"'), "geoDim: expected an integer in 2..3"),
    "NaN in coefs": (".xml", GISMO.replace("1 1 2\n", "1 1 nan\n"), "control_points: expected finite"),
    "weights too few": (".xml", GISMO.replace("<weights>1", "<weights>"), "weights: expected 2 x 3 numbers, got 5"),
    "no weight": (".xml", GISMO.replace("<weights>1", "<weights>0"), "Geometry 1: weights: expected"),
    "binary coefs": (".xml", re.sub(r"(?s)(<coefs.*?>).*?<", r"\1AAAAAAAA8D8=<", GISMO), "got 'AAAAAAAA8D8='"),
    "nested elements": (".xml", "<a>" * 100_000, "expected XML, got something else"),
    "nested whole": (".xml", "<a>" * 100_000 + "</a>" * 100_000, "expected a Geometry"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_files(case: str, tmp_path: Path) -> None:
    ending, content, expected = WRONG[case]
    start = time.thread_time()
    assert expected in error_of(written(tmp_path / f"a{ending}", content))
    assert time.thread_time() - start < 2


@pytest.mark.parametrize(
    ("ending", "content"),
    [(".json", trimmed(type="spline", **LINE)), (".bpt", BPT), (".xml", GISMO)],
    ids=[".json", ".bpt", ".xml"],
)
def test_cut_files(ending: str, content: str, tmp_path: Path) -> None:
    content = content.strip()
    faces_of(written(tmp_path / f"whole{ending}", content))
    for end in [*range(0, len(content) - 1, 50), len(content) - 60]:
        error_of(written(tmp_path / f"{end}{ending}", content[:end]))


@pytest.mark.parametrize("ending", [".json", ".bpt", ".cpt", ".xml"])
def test_nothing_and_nonsense(ending: str, tmp_path: Path) -> None:
    assert error_of(tmp_path / f"missing{ending}").startswith(f"missing{ending}: expected a file, found nothing at")
    assert error_of(written(tmp_path / f"empty{ending}", "")).endswith("expected a scene, got an empty file")
    for seed in range(20):
        error_of(written(tmp_path / f"{seed}{ending}", np.random.default_rng(seed).bytes(300)))


def test_endings(tmp_path: Path) -> None:
    file = written(tmp_path / "a.json", geomdl_json(CYLINDER))
    with pytest.raises(
        bob.InputError, match=r"^a\.json: expected one of \.ply .*, got \.json; bobrossnet\.load reads it$"
    ):
        load_mesh(file)
    error = error_of(written(tmp_path / "a.dwg", "x"))
    assert error.endswith("got .dwg")
    for ending in (".ply", ".sdf", *INSTANCE_READERS):
        assert f" {ending} " in error.replace(",", " ")
    assert error_of(written(tmp_path / "a", "x")).endswith("got no ending")


def test_info(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["info", str(written(tmp_path / "a.json", geomdl_json(CYLINDER)))]) == 0
    assert "brep, 'a.json'" in capsys.readouterr().out
    assert cli.main(["info", str(written(tmp_path / "b.json", "{}"))]) == 2
    assert capsys.readouterr().err == "bobrossnet: error: b.json: shape: expected one, got none\n"


# ---- The shared models -----------------------------------------------------------------------------------

FACES = {
    "ducky.nurbs.json": 3,
    "ex_surface01.cpt": 1,
    "gismo_duck_BRep.xml": 6,
    "gismo_egg.xml": 1,
    "gismo_g_plus_s_surf.xml": 126,
    "gismo_quarter_sphere.xml": 1,
    "gismo_teapot.xml": 32,
    "newell_teacup.bpt": 26,
    "newell_teapot.bpt": 32,
}


def model(name: str) -> tuple[Face, ...]:
    return faces_of(MODELS / "nurbs" / name)


@needs_models
def test_json_models_have_the_faces_that_the_index_counts() -> None:
    counts = re.compile(r"\((\d+) faces, (\d+) trimmed, \d+ rational, degrees (\[.*?\])\)")
    with (MODELS / "INDEX.csv").open(newline="") as lines:
        notes = {row[0].removeprefix("nurbs/"): " ".join(row) for row in csv.reader(lines)}
    names = {file.name for file in (MODELS / "nurbs").glob("*.nurbs.json")} - FACES.keys()
    assert len(names) > 10
    for name in sorted(names):
        found = counts.search(notes[name])
        assert found is not None
        total, untrimmed = int(found[1]), int(found[2])
        if untrimmed:
            with pytest.warns(bob.InputWarning, match=f"^{name}: {untrimmed} of {total} faces are trimmed, but"):
                faces = model(name)
        else:
            faces = model(name)
        assert len(faces) == total
        assert str(sorted({degrees(face) for face in faces})[:6]) == found[3]  # the index has at most six


@needs_models
@pytest.mark.parametrize("name", FACES)
def test_other_models(name: str) -> None:
    assert len(model(name)) == FACES[name]


@needs_models
def test_a_teapot_is_the_same_in_two_formats() -> None:
    for one, other in zip(model("newell_teapot.bpt"), model("gismo_teapot.xml"), strict=True):
        # Both files have the same sequence of points: here the last parameter varies fastest, there the first.
        assert np.array_equal(one.control_points, other.control_points.transpose(1, 0, 2))


@needs_models
def test_a_quarter_sphere_is_round() -> None:
    (face,) = model("gismo_quarter_sphere.xml")
    assert np.allclose(np.linalg.norm(face.points(U, V), axis=1), 10, atol=0.02)  # its pole is 0.01 wide


@needs_models
@pytest.mark.parametrize("name", ["ducky.nurbs.json", "newell_teacup.bpt", "ex_surface01.cpt", "gismo_egg.xml"])
def test_damaged_models_load_or_say_why(name: str, tmp_path: Path) -> None:
    whole = (MODELS / "nurbs" / name).read_bytes()
    rng = np.random.default_rng(0)
    for number in range(40):
        data = bytearray(whole)
        for at in rng.integers(0, len(data), 3):
            data[at] = rng.choice(list(b'0123456789eE+-.,;<>[]{}" \n\0\xff'))
        file = written(tmp_path / f"{number}{Path(name).suffix}", bytes(data))
        try:
            faces_of(file)
        except bob.InputError as error:
            assert str(error).isprintable()  # noqa: PT017
