"""Contours of sections against closed forms, and their drawings."""

import re
import xml.etree.ElementTree as ET
from math import hypot, pi, sqrt

import numpy as np
import nurbs_shapes as nurbs
import pytest

import bobrossnet as bob
from bobrossnet.sdf import Z, box, capped_cone, sphere, torus

ROOT3, ROOT5 = sqrt(3), sqrt(5)


def quarter_cylinder():
    """Return a quarter of a cylinder, of radius 2 and height 3, with its rational arc as in *The NURBS Book*."""
    arc, knots, line = np.array([(2, 0), (2, 2), (0, 2)], float), [0, 0, 0, 1, 1, 1], [0, 0, 1, 1]
    weights = np.array([1, sqrt(0.5), 1])
    side = np.stack([np.column_stack([arc, np.full(3, z)]) for z in (0, 3)], axis=1)
    faces = [bob.Face(side, knots, line, weights=np.stack([weights, weights], axis=1))]
    trim = bob.TrimCurve(arc / 2, knots, weights)
    border = [np.array([(0, 0), (1, 0)]), trim, np.array([(0, 1), (0, 0)])]
    faces += [bob.Face([[(0, 0, z), (0, 2, z)], [(2, 0, z), (2, 2, z)]], line, line, trims=[border]) for z in (0, 3)]
    faces += [bob.Face([[(0, 0, 0), (0, 0, 3)], [(x, y, 0), (x, y, 3)]], line, line) for x, y in ((2, 0), (0, 2))]
    return bob.Brep(faces)


def cone():
    """Return a cone of NURBS, of radius 1 and height 2."""
    side = nurbs.revolved(np.array([(1.0, 0), (0, 2)]), np.ones(2), [0, 0, 1, 1])
    return bob.Brep([side, nurbs.cylinder(1, 0, 1).faces[1]])


RING = sqrt(0.0525)
TORUS = pi * ((0.7 + RING) ** 2 - (0.7 - RING) ** 2), 2 * pi * 1.4

WORKED = {
    "sphere": (lambda: nurbs.sphere(1), "z=0.3", pi * 0.91, 2 * pi * sqrt(0.91), 1),
    "tilted": (lambda: nurbs.sphere(1), bob.Section((1, 2, 3), 0.3 * sqrt(14)), pi * 0.91, 2 * pi * sqrt(0.91), 1),
    "torus across": (nurbs.torus, "x=0", 2 * pi * 0.0625, 4 * pi * 0.25, 2),
    "torus along": (nurbs.torus, "z=0.1", *TORUS, 2),
    "cone": (cone, "z=1", pi / 4, pi, 1),
    "cone by its axis": (cone, "x=0", 2, 2 + 2 * ROOT5, 1),
    "quarter cylinder": (quarter_cylinder, "z=1", pi, pi + 4, 1),
    "quarter cylinder in its face": (quarter_cylinder, "z=3", pi, pi + 4, 1),
    "quarter cylinder along": (quarter_cylinder, "x=1", 3 * ROOT3, 6 + 2 * ROOT3, 1),
    "formula sphere": (lambda: sphere(1), "z=0.3", pi * 0.91, 2 * pi * sqrt(0.91), 1),
    "formula torus": (lambda: torus(0.7, 0.25), "z=0.1", *TORUS, 2),
    "formula cone": (lambda: capped_cone(-Z, Z, 1, 0.5), "x=0", 3, 3 + 2 * hypot(2, 0.5), 1),
    "formula box": (lambda: box((1, 2, 3)), "x=0.1", 6, 10, 1),
    "hollow": (lambda: sphere(1) - sphere(0.5), "y=0", pi * 0.75, 3 * pi, 2),
    "mesh": (lambda: bob.Mesh(*block()), "z>0.25", 2, 6, 1),
    "mesh in its face": (lambda: bob.Mesh(*block()), "z=0.5", 2, 6, 1),
}


def block():
    vertices = np.array([(x, y, z) for x in (0, 2) for y in (0, 1) for z in (-0.5, 0.5)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return vertices, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


@pytest.mark.parametrize("name", WORKED)
def test_worked_values(name):
    make, section, area, length, loops = WORKED[name]
    cut = bob.section(make(), section)
    assert cut.area == pytest.approx(area, rel=1e-6)
    assert cut.length == pytest.approx(length, rel=1e-6)
    assert len(cut.polylines) == loops
    assert cut.parts[0].is_closed


def test_a_transform_moves_the_contours():
    place = bob.Instance(nurbs.sphere(1)).scale((2, 3, 1)).rotate(0.4).translate((5, 0, 7))
    cut = bob.section(place, "z=7")
    assert cut.area == pytest.approx(6 * pi, rel=1e-6)
    points = cut.points(cut.polylines[0])
    assert np.abs(points[:, 2] - 7).max() < 1e-12
    assert points[:, 0].mean() == pytest.approx(5, abs=0.02)


def test_what_coordinates_mean():
    part = bob.Instance(sphere(0.25)).translate((1, 2, 3))
    for section, center in (("x=1", (2, 3)), ("y=2", (-1, 3)), ("z=3", (1, 2)), ("z>3", (-1, 2))):
        (loop,) = bob.section(part, section).polylines
        np.testing.assert_allclose((loop.min(axis=0) + loop.max(axis=0)) / 2, center, atol=1e-5)


def test_borders_are_anticlockwise_and_holes_clockwise():
    nested = (sphere(1) - sphere(0.8)) | (sphere(0.6) - sphere(0.4))
    (part,) = bob.section(nested, "x=0").parts
    areas = sorted(round(curve.area() / pi, 3) for curve in part.curves)
    assert areas == [-0.64, -0.16, 0.36, 1.0]


def test_parts_have_their_names():
    scene = bob.Scene([bob.Instance(sphere(1), name="shell"), bob.Instance(box(0.5)).translate((3, 0, 0)), box(1)])
    cut = bob.section(scene, "x=0.3")
    assert [(part.instance, part.name) for part in cut.parts] == [(0, "shell"), (2, "part 3")]
    assert cut.area == pytest.approx(sum(part.area for part in cut.parts))


def test_an_open_shape_has_lines():
    flat = bob.Mesh([(0, 0, 0), (2, 0, 0), (0, 2, 0), (2, 2, 0)], [(0, 1, 2), (1, 3, 2)])
    cut = bob.section(flat, "x=0.5")
    (line,) = cut.parts[0].lines
    assert not cut.parts[0].is_closed
    assert cut.polylines == []
    assert cut.area == 0
    assert cut.length == pytest.approx(2)
    assert sorted(line[[0, -1], 0].tolist()) == [0, 2]


def test_an_edge_opposite_to_two_shorter_ones_is_closed():
    vertices, triangles = block()
    vertices = np.concatenate([vertices, [(1, 0, -0.5)]])  # on an edge that one of its two faces does not divide
    (at,) = [i for i, t in enumerate(triangles) if {0, 4} < set(t) and (vertices[list(t), 1] == 0).all()]
    a, b, c = triangles[at]
    cut = next(k for k, pair in enumerate(((a, b), (b, c), (c, a))) if set(pair) == {0, 4})
    a, b, c = np.roll((a, b, c), -cut).tolist()
    triangles[at : at + 1] = [(a, 8, c), (8, b, c)]
    cut = bob.section(bob.Mesh(vertices, triangles), bob.Section((0, 0, 1), -0.5 + 1e-7))
    assert cut.parts[0].is_closed
    assert cut.area == pytest.approx(2, rel=1e-6)
    across = bob.section(bob.Mesh(vertices, triangles), bob.Section((1, 0, 0), 0.7))
    assert across.parts[0].is_closed
    assert across.area == pytest.approx(1)


def test_a_plane_that_misses_has_no_contours(tmp_path):
    cut = bob.section(sphere(1), "x=5")
    assert cut.parts == ()
    assert cut.area == cut.length == 0
    with pytest.raises(bob.InputError, match=r"^section: expected a plane that meets a shape"):
        cut.save(tmp_path / "cut.svg")


def test_one_section_at_a_time():
    with pytest.raises(bob.InputTypeError, match=r"^section: expected one section, got 2"):
        bob.section(sphere(1), ["x=0", "y=0"])


def test_contours_agree_with_the_tracer():
    shape = (box((2, 1, 1)) - sphere(0.45).translate((0.5, 0, 0))) | torus(0.6, 0.2)
    cut = bob.section(shape, "z=0.1")
    scene = bob.Scene(shape, section="z=0.1")
    side = 100
    x, y = np.meshgrid(np.linspace(-1.1, 1.1, side) + 1e-3, np.linspace(-1.1, 1.1, side) + 1e-3)
    rays = np.stack([x, y, np.full_like(x, 5)], axis=-1).reshape(-1, 3)
    capped = scene.closest_hits(rays, np.broadcast_to((0.0, 0, -1), rays.shape)).primitive == -2
    inside = np.zeros(len(rays), bool)
    for loop in cut.polylines:
        following = np.roll(loop, -1, axis=0)
        for (x0, y0), (x1, y1) in zip(loop, following, strict=True):
            if (y0 < y1) or (y1 < y0):
                between = (y0 <= rays[:, 1]) != (y1 <= rays[:, 1])
                inside ^= between & (x0 + (rays[:, 1] - y0) / (y1 - y0) * (x1 - x0) > rays[:, 0])
    assert (inside == capped).all()
    assert capped.mean() * 2.2**2 == pytest.approx(cut.area, rel=0.03)


def test_svg(tmp_path):
    scene = bob.Scene([bob.Instance(sphere(1) - sphere(0.5), name="a <b>", material=bob.Material("#ff0000")), box(0.5)])
    bob.section(scene, "z=0").save(tmp_path / "cut.svg", unit="cm")
    root = ET.parse(tmp_path / "cut.svg").getroot()
    space = "{http://www.w3.org/2000/svg}"
    assert root.get("width") == "2.08cm"
    assert [float(x) for x in root.get("viewBox").split()] == pytest.approx([-1.04, -1.04, 2.08, 2.08], abs=1e-4)
    first, _ = root.findall(f"{space}g")
    assert first.find(f"{space}title").text == "a <b>"
    paths = first.findall(f"{space}path")
    assert [path.get("fill") for path in paths] == ["#ff0000", "url(#h0)", "none"]
    assert paths[0].get("fill-rule") == "evenodd"
    assert paths[0].get("d").count("Z") == 2
    assert {pattern.get("patternTransform") for pattern in root.findall(f"{space}pattern")} == {
        "rotate(45)",
        "rotate(-45)",
    }
    bob.section(scene, "z=0").save(tmp_path / "plain.svg", hatch=False)
    assert "pattern" not in (tmp_path / "plain.svg").read_text()


def test_dxf(tmp_path):
    scene = bob.Scene([bob.Instance(sphere(1) - sphere(0.5), name="shell ä"), bob.Instance(box(0.5), name="core")])
    cut = bob.section(scene, "z=0")
    cut.save(tmp_path / "cut.dxf", unit="in")
    lines = (tmp_path / "cut.dxf").read_text(encoding="ascii").splitlines()
    groups = list(zip((int(code) for code in lines[::2]), lines[1::2], strict=True))
    assert groups[-1] == (0, "EOF")
    assert groups[groups.index((9, "$INSUNITS")) + 1] == (70, "1")
    names = [value for code, value in groups if code == 0]
    assert names.count("POLYLINE") == names.count("SEQEND") == 3
    assert names.count("VERTEX") == sum(map(len, cut.polylines))
    assert [value for code, value in groups if code == 2 and value[0].isdigit()] == ["1_SHELL__", "2_CORE"]
    assert all(re.fullmatch(r"[A-Z0-9$_-]{1,31}", value) for code, value in groups if code == 8)
    first = groups.index((0, "VERTEX"))
    np.testing.assert_allclose([float(groups[first + i][1]) for i in (2, 3)], cut.parts[0].curves[0].points[0])


def test_dxf_is_read_by_ezdxf(tmp_path):
    ezdxf = pytest.importorskip("ezdxf", reason="the reader is not installed")
    cut = bob.section(sphere(1) - sphere(0.5), "z=0")
    cut.save(tmp_path / "cut.dxf")
    drawing = ezdxf.readfile(tmp_path / "cut.dxf")
    assert not drawing.audit().has_errors
    polylines = drawing.modelspace().query("POLYLINE")
    assert [line.is_closed for line in polylines] == [True, True]
    read = [np.array([vertex.dxf.location.vec2 for vertex in line.vertices]) for line in polylines]
    for ours, theirs in zip(cut.polylines, read, strict=True):
        np.testing.assert_allclose(theirs, ours, atol=1e-11)


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("cut.pdf", {}, "cut.pdf: expected"),
        ("cut.svg", {"unit": "mile"}, "unit: expected"),
        ("cut.svg", {"hatch": 3}, "hatch: expected"),
    ],
)
def test_drawings_out_of_range(tmp_path, name, options, message):
    with pytest.raises(bob.InputError) as error:
        bob.section(sphere(1), "z=0").save(tmp_path / name, **options)
    assert message in str(error.value)


def test_drawings_are_converted_from_a_known_unit(tmp_path):
    cut = bob.section(bob.Scene(box(2), unit="in"), "z=0")
    cut.save(tmp_path / "cut.dxf", unit="mm")
    lines = (tmp_path / "cut.dxf").read_text(encoding="ascii").splitlines()
    header = lines.index("ENTITIES")
    across = [
        float(x) for code, x in zip(lines[header + 1 :: 2], lines[header + 2 :: 2], strict=False) if code == " 10"
    ]
    assert (min(across), max(across)) == pytest.approx((-25.4, 25.4), rel=1e-6)
    cut.save(tmp_path / "cut.svg", unit="mm")
    assert ET.parse(tmp_path / "cut.svg").getroot().get("width") == "52.832mm"


@pytest.mark.parametrize(("unit", "number"), [(None, "4"), ("in", "1"), ("m", "6")])
def test_drawings_have_the_unit_of_the_scene(tmp_path, unit, number):
    """Millimetres, if the scene has no unit."""
    bob.section(bob.Scene(box(2), unit=unit), "z=0").save(tmp_path / "cut.dxf")
    lines = (tmp_path / "cut.dxf").read_text().split("\n")
    assert lines[lines.index("$INSUNITS") + 2] == number
