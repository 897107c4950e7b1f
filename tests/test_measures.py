"""Measures: areas, volumes, boxes and radii against OpenCascade, trimesh and closed forms; picks."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from models import MODELS, needs_models

import bobrossnet as bob
from bobrossnet import sdf

CORNERS = np.array([(0, 0, 0), (3, 0, 0), (0, 4, 0), (0, 0, 5)], float)
SIDES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
SIZE = (120, 160)


def solids():
    """Solids of planes, cylinders, cones, spheres, tori and free forms, trimmed and not, by their names."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
    from OCP.BRepBuilderAPI import (
        BRepBuilderAPI_MakeEdge,
        BRepBuilderAPI_MakeFace,
        BRepBuilderAPI_MakePolygon,
        BRepBuilderAPI_MakeWire,
        BRepBuilderAPI_Transform,
    )
    from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
    from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections
    from OCP.BRepPrimAPI import (
        BRepPrimAPI_MakeBox,
        BRepPrimAPI_MakeCone,
        BRepPrimAPI_MakeCylinder,
        BRepPrimAPI_MakeRevol,
        BRepPrimAPI_MakeSphere,
        BRepPrimAPI_MakeTorus,
    )
    from OCP.gp import gp_Ax1, gp_Ax2, gp_Circ, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopoDS import TopoDS
    from test_opencascade import explore

    def box(x, y, z):
        return BRepPrimAPI_MakeBox(float(x), float(y), float(z)).Shape()

    def cylinder(r, h, at=(0, 0, 0), along=(0, 0, 1)):
        return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(*map(float, at)), gp_Dir(*along)), float(r), float(h)).Shape()

    def ball(r, x=0.0):
        return BRepPrimAPI_MakeSphere(gp_Pnt(x, 0, 0), float(r)).Shape()

    def cut(a, b):
        return BRepAlgoAPI_Cut(a, b).Shape()

    def filleted(shape, radius):
        made = BRepFilletAPI_MakeFillet(shape)
        for edge in explore(shape, TopAbs_ShapeEnum.TopAbs_EDGE):
            made.Add(radius, TopoDS.Edge(edge))
        return made.Shape()

    def turned(shape):
        move = gp_Trsf()
        move.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(1, 2, 3)), 0.7)
        move.SetTranslationPart(gp_Vec(100, -50, 20))
        return BRepBuilderAPI_Transform(shape, move, True).Shape()

    outline = BRepBuilderAPI_MakePolygon()
    for point in ((2, 0, 0), (5, 0, 1), (4, 0, 3), (2, 0, 2)):
        outline.Add(gp_Pnt(*map(float, point)))
    outline.Close()
    profile = BRepBuilderAPI_MakeFace(outline.Wire()).Face()
    axis = gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))
    loft = BRepOffsetAPI_ThruSections(True, False)
    for radius, z in ((3, 0), (5, 4), (2, 9)):
        circle = gp_Circ(gp_Ax2(gp_Pnt(0, 0, z), gp_Dir(0, 0, 1)), radius)
        loft.AddWire(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(circle).Edge()).Wire())
    loft.Build()
    torus = BRepPrimAPI_MakeTorus(7.0, 2.0).Shape()
    drilled = cut(box(10, 10, 10), cylinder(2, 20, (5, 5, -5)))
    return {
        "box": box(1, 2, 3),
        "cylinder": cylinder(3, 7),
        "cone": BRepPrimAPI_MakeCone(5.0, 2.0, 7.0).Shape(),
        "tip": BRepPrimAPI_MakeCone(5.0, 0.0, 7.0).Shape(),
        "sphere": ball(4),
        "torus": torus,
        "drilled": drilled,
        "turned": turned(drilled),
        "drilled ball": cut(ball(5), cylinder(2, 20, (0, 0, -10))),
        "hollow": cut(ball(5), ball(4)),
        "lens": BRepAlgoAPI_Common(ball(5), ball(5, 6.0)).Shape(),
        "crossed": cut(cylinder(4, 20, (0, 0, -10)), cylinder(2, 20, (-10, 0, 0), (1, 0, 0))),
        "tee": BRepAlgoAPI_Fuse(cylinder(3, 20, (0, 0, -10)), cylinder(2, 15, along=(1, 0, 0))).Shape(),
        "filleted": filleted(box(6, 5, 4), 0.7),
        "rounded": filleted(cylinder(3, 6), 0.5),
        "loft": loft.Shape(),
        "revolved": BRepPrimAPI_MakeRevol(profile, axis, 2 * math.pi).Shape(),
        "part of a turn": BRepPrimAPI_MakeRevol(profile, axis, 2.0).Shape(),
        "half a ring": cut(torus, box(20, 20, 20)),
        "quarter": BRepAlgoAPI_Common(cylinder(3, 7), box(20, 20, 20)).Shape(),
    }


@pytest.fixture(scope="module")
def cad(tmp_path_factory):
    """One file of 20 solids: their shapes as OpenCascade reads them, and the scene; both in the file's sequence."""
    pytest.importorskip("OCP")
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_ShapeEnum
    from test_opencascade import Document, explore

    document = Document()
    for name, shape in solids().items():
        document.part(shape, name)
    file = document.write(tmp_path_factory.mktemp("solids") / "solids.step")
    scene = bob.load(file)
    reader = STEPControl_Reader()
    reader.ReadFile(str(file))
    reader.TransferRoots()
    read = list(explore(reader.OneShape(), TopAbs_ShapeEnum.TopAbs_SOLID))
    assert len(read) == len(scene.instances) == 20
    return scene, read


def test_areas_and_volumes_are_those_of_opencascade(cad):
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    scene, read = cad
    measured = bob.measure(scene)
    assert measured.unit == "mm"
    for part, shape in zip(measured.parts, read, strict=True):
        area, volume = GProp_GProps(), GProp_GProps()
        BRepGProp.SurfaceProperties_s(shape, area, 1e-9)
        BRepGProp.VolumeProperties_s(shape, volume, 1e-9)
        # 1e-6: the trims of intersections are known to about 1e-7 of a part's size.
        assert part.area == pytest.approx(area.Mass(), rel=1e-6), part.name
        assert part.volume == pytest.approx(volume.Mass(), rel=1e-6), part.name
        assert part.error < 1e-6
    assert measured.volume == pytest.approx(sum(part.volume for part in measured.parts))


def test_boxes_are_those_of_opencascade(cad):
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    scene, read = cad
    for part, shape in zip(scene.parts, read, strict=True):
        box = Bnd_Box()
        BRepBndLib.AddOptimal_s(shape, box, False, False)
        expected = [[corner.X(), corner.Y(), corner.Z()] for corner in (box.CornerMin(), box.CornerMax())]
        assert np.abs(np.array(part.extent) - expected).max() < 1e-6 * part.extent.size.max(), part.name


def test_closed_forms(cad):
    scene, _ = cad
    measured = {part.name: part for part in bob.measure(scene).parts}
    assert measured["sphere"].volume == pytest.approx(4 / 3 * math.pi * 64, rel=1e-9)
    assert measured["torus"].area == pytest.approx(4 * math.pi**2 * 14, rel=1e-9)
    assert measured["hollow"].volume == pytest.approx(4 / 3 * math.pi * (125 - 64), rel=1e-9)
    assert measured["cone"].volume == pytest.approx(math.pi * 7 / 3 * (25 + 10 + 4), rel=1e-9)


def test_an_open_shell_has_no_volume(cad):
    scene, _ = cad
    shape = scene.instances[scene.part("drilled").instances[0]].shape
    opened = bob.measure(bob.Brep(shape.faces[1:], shape.tolerance))
    assert opened.volume is None
    assert not opened.is_closed
    assert opened.area < bob.measure(shape).area
    assert "open" in str(opened)


def test_placed_and_stretched_parts(cad):
    scene, _ = cad
    torus = scene.instances[scene.part("torus").instances[0]]
    volume = 2 * math.pi**2 * 7 * 4
    moved = bob.measure(torus.rotate(1, (1, 2, 3)).scale(2).translate((5, 6, 7)))
    assert moved.volume == pytest.approx(8 * volume, rel=1e-8)
    assert moved.area == pytest.approx(4 * 4 * math.pi**2 * 14, rel=1e-8)
    stretched = bob.measure(torus.scale((1, 2, -3)))
    assert stretched.volume == pytest.approx(6 * volume, rel=1e-7)
    assert np.allclose(stretched.size, (18, 36, 12))


def test_faces_have_their_radii(cad):
    from bobrossnet.measuring.surfaces import recognised

    scene, _ = cad
    expected = {
        "sphere": {("sphere", 4, None)},
        "torus": {("torus", 2, 7)},
        "cylinder": {("cylinder", 3, None), ("plane", None, None)},
        "rounded": {("cylinder", 3, None), ("torus", 0.5, 2.5), ("plane", None, None)},
        "turned": {("cylinder", 2, None), ("plane", None, None)},
        "crossed": {("cylinder", 4, None), ("cylinder", 2, None), ("plane", None, None)},
    }
    for name, kinds in expected.items():
        instance = scene.instances[scene.part(name).instances[0]]
        found = [recognised(face, instance.transform) for face in instance.shape.faces]
        radii = {(f.kind, f.radius and round(f.radius, 9), f.major_radius and round(f.major_radius, 9)) for f in found}
        assert radii == kinds, name
    loft = scene.instances[scene.part("loft").instances[0]]
    assert "freeform" in {recognised(face, loft.transform).kind for face in loft.shape.faces}
    cone = scene.instances[scene.part("tip").instances[0]]
    angles = [recognised(face, cone.transform).half_angle for face in cone.shape.faces]
    assert max(filter(None, angles)) == pytest.approx(math.degrees(math.atan2(5, 7)))


def test_picks_of_a_solid(cad):
    scene, _ = cad
    alone = scene.isolate("turned")
    view = bob.View(alone, size=SIZE)
    view.frame("isometric", fraction=0.02)
    hole = None
    for row in range(0, SIZE[0], 6):
        for column in range(0, SIZE[1], 6):
            found = view.pick(row, column)
            if found is not None and bob.measure(found).kind == "cylinder":
                hole = found
    assert hole is not None
    assert hole.part.name == "turned"
    measured = bob.measure(hole)
    assert measured.radius == pytest.approx(2, rel=1e-9)
    axis = measured.axis
    offset = hole.point - measured.center
    assert np.linalg.norm(offset - (offset @ axis) * axis) == pytest.approx(2, rel=1e-9)
    assert measured.area == pytest.approx(2 * math.pi * 2 * 10, rel=1e-6)  # both halves that the reader makes
    assert bob.measure(hole, unit="in").radius == pytest.approx(2 / 25.4)
    assert view.pick(0, 0) is None


def test_distance_angle_and_gap():
    cube = bob.Mesh(*_cube(2))
    scene = bob.Scene(bob.Instance(cube, name="cube"), unit="mm")
    front, right = (bob.pick(scene, 60, 80, view, size=SIZE) for view in ("front", "right"))
    assert np.allclose(front.normal, (0, -1, 0))
    assert np.allclose(right.normal, (1, 0, 0))
    between = bob.measure(front, right)
    assert between.angle == pytest.approx(90)
    assert between.distance == pytest.approx(np.linalg.norm(right.point - front.point))
    assert between.unit == "mm"
    back = bob.pick(scene, 60, 80, "back", size=SIZE)
    assert bob.measure(front, back).gap == pytest.approx(2)
    assert bob.measure(front, back).angle == pytest.approx(180)
    assert bob.measure(front).thickness == pytest.approx(2, rel=1e-12)
    assert bob.measure(front, unit="in").thickness == pytest.approx(2 / 25.4)
    angled = bob.pick(scene, 60, 80, bob.Camera(azimuth=-60, elevation=0), size=SIZE)
    assert bob.measure(angled).thickness_along_ray >= 2
    with pytest.raises(bob.InputError, match="other: expected a pick of the same scene"):
        bob.measure(front, bob.pick(cube, 60, 80, "front", size=SIZE))


def _cube(side):
    points = np.array([(x, y, z) for x in (0, side) for y in (0, side) for z in (0, side)], float)
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return points, [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]


@needs_models
@pytest.mark.parametrize(
    "name", ["loader_originals/obj_quads/horse_quad.obj", "scans/stanford_bunny.ply", "mechanical/machinist_cube.ply"]
)
def test_meshes_are_those_of_trimesh(name):
    trimesh = pytest.importorskip("trimesh")
    mesh = bob.load_mesh(MODELS / name)
    other = trimesh.Trimesh(mesh.vertices, mesh.triangles)
    found = bob.measure(mesh)
    assert found.area == pytest.approx(other.area, rel=1e-12)
    assert found.is_closed == other.is_watertight
    if found.is_closed:
        assert found.volume == pytest.approx(abs(other.volume), rel=1e-9)


def test_rounding_of_zeros_opens_no_mesh():
    """As in STL files of CAD systems, where each triangle has its own vertices."""
    points, triangles = _cube(2)
    apart = points[np.ravel(triangles)] - 1
    apart[:, 2] += 1
    apart[np.abs(apart) < 0.5] += np.random.default_rng(0).uniform(-1e-15, 1e-15, (np.abs(apart) < 0.5).sum())
    measured = bob.measure(bob.Mesh(apart, np.arange(36).reshape(12, 3)))
    assert measured.volume == pytest.approx(8, rel=1e-12)
    apart[0] += 1e-6
    assert not bob.measure(bob.Mesh(apart, np.arange(36).reshape(12, 3))).is_closed


def test_volumes_of_parts_that_close_each_other():
    points, triangles = _cube(2)
    pieces = [(("lower",), 6), (("upper",), 6)]
    measured = bob.measure(bob.Instance(bob.Mesh(points, triangles), pieces=pieces))
    assert [part.volume for part in measured.parts] == [None, None]
    assert measured.volume == pytest.approx(8)
    assert measured.area == pytest.approx(24)
    mirrored = bob.measure(bob.Instance(bob.Mesh(points, triangles)).scale((-1, 1, 1)))
    assert mirrored.volume == pytest.approx(8)


@pytest.mark.parametrize(
    ("shape", "area", "volume"),
    [
        (sdf.sphere(2), 16 * math.pi, 32 / 3 * math.pi),
        (sdf.box(2), 24, 8),
        (sdf.torus(2, 0.5), 4 * math.pi**2, 2 * math.pi**2 * 0.5),
        (sdf.tetrahedron(1), 8 * math.sqrt(3), 8 / 3),
        (sdf.equilateral_triangle().extrude(1), 2 * math.sqrt(3) + 6, math.sqrt(3)),
        (sdf.box((1, 2, 3)).rotate(0.6, sdf.X).rotate(0.4, sdf.Y), 22, 6),
        (sdf.cylinder(1) & sdf.slab(z0=-1, z1=1), 6 * math.pi, 2 * math.pi),
    ],
)
def test_formulas_are_within_their_stated_error(shape, area, volume):
    found = bob.measure(shape)
    assert abs(found.area / area - 1) <= found.error
    assert abs(found.volume / volume - 1) <= found.error
    assert found.error < 3e-3
    assert found.unit is None


@pytest.mark.parametrize("camera", [bob.Camera(10, 5), bob.Camera(10, 5, 30, fov=60)])
def test_normals_of_formulas(camera):
    found = bob.pick(sdf.sphere(2), 50, 70, camera, size=SIZE)
    assert np.linalg.norm(found.point) == pytest.approx(2, rel=1e-5)
    assert np.allclose(found.normal, found.point / 2, atol=1e-5)
    assert found.face is None


def test_text_has_the_unit():
    wedge = bob.Mesh(CORNERS, SIDES)
    assert str(bob.measure(wedge)) == "3 x 4 x 5, area 37.36542, volume 10"
    assert str(bob.measure(bob.Scene(wedge, unit="in"), unit="cm")).startswith("7.62 x 10.16 x 12.7 cm, area 241.06")


def test_errors_of_one_line():
    wedge = bob.Mesh(CORNERS, SIDES)
    for value, argument in ((3, "shapes"), (None, "shapes")):
        with pytest.raises(TypeError, match=f"^{argument}: expected"):
            bob.measure(value)
    with pytest.raises(bob.InputError, match=r"^unit: expected a scene whose unit is known"):
        bob.measure(wedge, unit="mm")
    with pytest.raises(TypeError, match=r"^other: expected two picks"):
        bob.measure(wedge, wedge)
    with pytest.raises(bob.InputError, match=r"^row: expected an integer in 0..119"):
        bob.pick(wedge, 120, 0, size=SIZE)
    view = bob.View(tracer=lambda camera, pixels: bob.Samples(gray=np.zeros(len(pixels))), size=SIZE)
    with pytest.raises(bob.InputError, match=r"^pick: expected a view of a scene"):
        view.pick(0, 0)


def test_the_command_line_measures(tmp_path, capsys):
    from bobrossnet.command_line import cli

    points, triangles = _cube(2)
    pieces = [(("lower",), 6), (("upper",), 6)]
    bob.save_scene(bob.Scene(bob.Instance(bob.Mesh(points, triangles), pieces=pieces), unit="in"), tmp_path / "a.bob")
    assert cli.main(["measure", str(tmp_path / "a.bob")]) == 0
    first, second, *parts = capsys.readouterr().out.splitlines()
    assert first == "1 shape, 12 triangles: 2 x 2 x 2 in, area 24 in², volume 8 in³"
    assert second.endswith("the unit is in")
    assert [line.split()[0] for line in parts] == ["lower", "upper"]
    assert cli.main(["measure", str(tmp_path / "a.bob"), "--unit", "mm", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["volume"] == pytest.approx(8 * 25.4**3)
    assert found["unit"] == "mm"
    assert [part["closed"] for part in found["parts"]] == [False, False]
    assert cli.main(["measure", str(tmp_path / "a.bob"), "--only", "lower", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["area"] == pytest.approx(12)
    assert cli.main(["measure", str(tmp_path / "a.bob"), "--hide", "loewr"]) == 2
    assert capsys.readouterr().err == (
        "bobrossnet: error: part: expected one of the 2 parts, such as lower, got 'loewr'\n"
    )
    assert cli.main(["info", str(tmp_path / "a.bob"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [part["path"] for part in told["parts"]] == [["lower"], ["upper"]]
    assert [part["name"] for part in told["parts"]] == ["lower", "upper"]  # as measure and describe name them
    assert told["unit"] == "in"


# ---- Snapping --------------------------------------------------------------------------------------------


def pixel_of(scene, point, camera, size=SIZE):
    """Return the pixel of a point of the scene."""
    at = ((np.array([point], float) - scene.center) / scene.radius).astype(np.float32)
    row, column, _ = camera.core(scene.center, scene.radius).seen(*size, at)[0]
    return round(float(row)), round(float(column))


def snapped(scene, point, camera, off=(0, 0), snap=5, size=SIZE):
    row, column = pixel_of(scene, point, camera, size)
    return bob.pick(scene, row + off[0], column + off[1], camera, size=size, snap=snap)


def drilled_plate(sides=48):
    """Return a plate of 8 x 6 x 2 with a hole of radius 1.5 at (1, 0.5), as triangles: turned, moved and scaled."""
    plate = plate_with_hole(sides)
    turned = bob.Instance(plate, name="plate").scale(2.5).rotate(0.4, (1, 2, 3)).translate((100, -50, 20))
    return bob.Scene(turned, unit="mm"), turned.transform


def plate_with_hole(sides):
    """Return the plate in its own coordinates."""
    angles = 2 * np.pi * np.arange(sides) / sides
    hole = np.stack([1 + 1.5 * np.cos(angles), 0.5 + 1.5 * np.sin(angles)], axis=1)
    border = np.array([(-4, -3), (4, -3), (4, 3), (-4, 3)], float)
    flat = np.concatenate([border, hole])
    edges = [(i, (i + 1) % 4) for i in range(4)] + [(4 + i, 4 + (i + 1) % sides) for i in range(sides)]
    units = np.rint(flat * 4096).astype(np.int32) + 2**20
    inside = bob._core.triangulate(units, np.array(edges, np.int32))
    top, bottom = (np.column_stack([flat, np.full(len(flat), z)]) for z in (1.0, -1.0))
    count = len(flat)
    walls = [t for a, b in edges for t in ((a + count, b + count, b), (a + count, b, a))]
    flipped = np.asarray(inside)[:, ::-1] + count
    return bob.Mesh(np.concatenate([top, bottom]), np.concatenate([inside, flipped, walls]))


@pytest.mark.parametrize("camera", [bob.Camera(300, 50), bob.Camera(300, 50, 20, fov=60)])
def test_picks_snap_to_corners_middles_centres_and_edges(camera):
    scene, matrix = drilled_plate()

    def placed(*point):
        return matrix[:3, :3] @ point + matrix[:3, 3]

    for point, kind, radius in [
        ((-4, -3, 1), "corner", None),
        ((4, -3, 1), "corner", None),
        ((0, -3, 1), "middle", None),
        ((1, 0.5, 1), "center", 3.75),
    ]:
        for off in [(0, 0), (2, 1), (-1, 2)]:
            found = snapped(scene, placed(*point), camera, off)
            assert found.snapped == kind
            assert found.point == pytest.approx(placed(*point), abs=1e-6 * scene.radius)
            assert found.radius == (None if radius is None else pytest.approx(radius, rel=1e-6))
            assert found.part.name == "plate"
    found = snapped(scene, placed(-2, -3, 1), camera, snap=3)
    assert found.snapped == "edge"
    assert found.radius is None
    at = np.linalg.solve(matrix[:3, :3], found.point - matrix[:3, 3])
    assert at == pytest.approx((-2, -3, 1), abs=0.1)
    assert at[1:] == pytest.approx((-3, 1), abs=1e-6)
    found = snapped(scene, placed(2.5, 0.5, 1), camera, snap=2)
    assert (found.snapped, found.radius) == ("edge", pytest.approx(3.75, rel=1e-6))
    within = snapped(scene, placed(-3, 1.5, 1), camera)
    assert within.snapped is None
    assert bob.pick(scene, 0, 0, camera, size=SIZE, snap=5) is None
    a, b = (snapped(scene, placed(*point), camera) for point in [(-4, -3, 1), (1, 0.5, 1)])
    between = bob.measure(a, b)
    assert between.distance == pytest.approx(2.5 * math.hypot(5, 3.5), rel=1e-6)
    assert between.ends == ("corner", "centre of a circle, radius 3.75 mm")
    assert bob.measure(a, b, unit="cm").ends[1] == "centre of a circle, radius 0.375 cm"
    assert bob.measure(within, within).ends == ("point", "point")
    assert bob.measure(a).thickness is None
    pixel = pixel_of(scene, placed(-4, -3, 1), camera)
    view = bob.View(scene, size=SIZE)
    view.frame(camera, fraction=0.02)
    assert view.pick(*pixel, snap=4).snapped == "corner"


def test_circles_of_uneven_vertices_have_their_centre():
    """Most vertices lie in a twentieth of the circle, written with five digits."""
    angles = np.concatenate([np.linspace(0, 0.3, 200), np.linspace(0.3, 2 * np.pi, 14)[1:-1]])
    ring = np.round(np.column_stack([5 + np.cos(angles), np.sin(angles)]), 5)
    count = len(ring)
    vertices = np.concatenate([np.column_stack([ring, np.full(count, z)]) for z in (0, 1)] + [[(5, 0, 0), (5, 0, 1)]])
    sides = [(i, (i + 1) % count) for i in range(count)]
    walls = [t for a, b in sides for t in ((a, b, b + count), (a, b + count, a + count))]
    flat = [t for a, b in sides for t in ((b, a, 2 * count), (a + count, b + count, 2 * count + 1))]
    scene = bob.Scene(bob.Mesh(vertices, walls + flat))
    found = snapped(scene, (5, 0, 1), bob.Camera(30, 50), off=(1, 2))
    assert found.snapped == "center"
    assert found.radius == pytest.approx(1, abs=5e-6)
    assert found.point == pytest.approx((5, 0, 1), abs=5e-6)


def test_ends_of_tubes_have_their_centre():
    wire = bob.Instance(bob.polyline([(0, 0, 0), (4, 0, 0), (4, 3, 0)], 0.25)).scale(2).translate((1, 1, 1))
    scene = bob.Scene(wire, unit="mm")
    for end in [(1, 1, 1), (9, 7, 1)]:
        found = snapped(scene, end, bob.Camera(300, 50), off=(1, -2))
        assert (found.snapped, found.radius) == ("center", pytest.approx(0.5))
        assert found.point == pytest.approx(end, abs=1e-6)
    assert snapped(scene, (9, 1, 1), bob.Camera(300, 50)).snapped is None  # a bend is no end
    ends = [snapped(scene, end, bob.Camera(300, 50)) for end in [(1, 1, 1), (9, 7, 1)]]
    assert bob.measure(*ends).distance == pytest.approx(10)


def test_hidden_and_removed_corners_attract_nothing():
    plate = plate_with_hole(24)
    wall = bob.Instance(sdf.box((0.2, 20, 20)), name="wall").translate((8, 0, 0))
    camera = bob.Camera(0, 10)
    alone, behind = bob.Scene(plate), bob.Scene([plate, wall])
    corner = (4, 3, 1)
    assert snapped(alone, corner, camera).snapped == "corner"
    found = snapped(behind, corner, camera)
    assert (found.snapped, found.part.name) == (None, "wall")
    cut = alone.sectioned("x=0")
    for point, wanted in [(corner, None), ((-4, -3, 1), "corner")]:
        found = snapped(cut, point, bob.Camera(330, 30))
        assert (found and found.snapped) == wanted


def test_faces_of_a_solid_snap_exactly(cad):
    """Each border once, no seams; centres of holes also where the circle is two arcs."""
    scene, _ = cad
    camera, size = bob.Camera(300, 40), (240, 320)
    box = bob.Scene(scene.instances[0], unit="mm")
    corner = snapped(box, (1, 0, 3), camera, size=size)
    assert corner.snapped == "corner"
    assert corner.point == pytest.approx((1, 0, 3), abs=1e-9)
    assert snapped(box, (0.5, 0, 3), camera, size=size).snapped == "middle"
    drilled = bob.Scene(scene.part("drilled").scene.instances[6], unit="mm")
    centre = snapped(drilled, (5, 5, 10), camera, size=size)
    assert (centre.snapped, centre.radius) == ("center", pytest.approx(2, abs=1e-9))
    assert centre.point == pytest.approx((5, 5, 10), abs=1e-9)
    ball = bob.Scene(scene.instances[4])
    assert {snapped(ball, point, camera, size=size).snapped for point in [(0, -4, 0), (0, 0, 4), (4, 0, 0)]} == {None}
    cylinder = bob.Scene(scene.instances[1])
    rim = snapped(cylinder, (3 * math.cos(4), 3 * math.sin(4), 7), camera, size=size)
    assert (rim.snapped, rim.radius) == ("edge", pytest.approx(3, abs=1e-9))
    assert math.hypot(*rim.point[:2]) == pytest.approx(3, abs=1e-9)


# ---- Sections --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("made", ["formula", "mesh"])
def test_caps_of_sections_are_picked_and_measured(made):
    from bobrossnet.sdf import box

    shape = box(2) if made == "formula" else box(2).mesh(0.25)
    scene = bob.Scene(shape, section="x=0.25")
    found = bob.pick(scene, 120, 160, bob.Camera(azimuth=0, elevation=0), size=(240, 320))
    assert (found.section, found.face) == (0, None)
    assert np.allclose(found.point[0], 0.25, atol=1e-5)
    assert np.allclose(found.normal, (1, 0, 0))
    measured = bob.measure(found)
    assert measured.kind == "plane"
    assert measured.area is None
    assert np.isclose(measured.thickness, 1.25, atol=1e-4)
