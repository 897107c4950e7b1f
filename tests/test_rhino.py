"""Rhino's files: their objects, places, colours, and trims."""

import base64
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from models import MODELS, needs_models
from nurbs_shapes import curve_points, inside
from scipy.spatial import cKDTree

import bobrossnet as bob
from bobrossnet.adapters.apart import call_apart
from bobrossnet.adapters.opennurbs import brep_loops
from bobrossnet.adapters.rhino import face_trims, read_3dm, read_here, untrimmed

rhino3dm = pytest.importorskip("rhino3dm")

NURBS = MODELS / "nurbs"
WHITE = (1.0, 1.0, 1.0)
ORIGIN = rhino3dm.Point3d(0, 0, 0)


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch):
    """Processes take half a second to start, and ignore monkeypatches of a test."""
    monkeypatch.setattr(
        "bobrossnet.adapters.rhino.call_apart", lambda _module, _name, file: (read_here(Path(file)), [])
    )


class Model:
    """A Rhino file under construction."""

    def __init__(self):
        self.file = rhino3dm.File3dm()

    def layer(self, name, color=(0, 0, 0), visible=True, parent=None):
        layer = rhino3dm.Layer()
        layer.Name, layer.Color, layer.Visible = name, (*color, 255), visible
        if parent is not None:
            layer.ParentLayerId = self.file.Layers[parent].Id
        return self.file.Layers.Add(layer)

    def material(self, color):
        material = rhino3dm.Material()
        material.DiffuseColor = (*color, 255)
        return self.file.Materials.Add(material)

    def write(self, path):
        assert self.file.Write(str(path), 8)
        return path


def attributes(name="", layer=-1, visible=True, **others):
    made = rhino3dm.ObjectAttributes()
    made.Name, made.LayerIndex, made.Visible = name, layer, visible
    for key, value in others.items():
        setattr(made, key, value)
    return made


def box(x=1.0, y=2.0, z=3.0):
    return rhino3dm.Brep.CreateFromBox(rhino3dm.Box(rhino3dm.BoundingBox(0, 0, 0, x, y, z)))


def quad():
    mesh = rhino3dm.Mesh()
    for corner in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0)):
        mesh.Vertices.Add(*corner)
    mesh.Faces.AddFace(0, 1, 2, 3)
    mesh.Faces.AddFace(1, 4, 2)
    return mesh


def color(*rgb):
    return bob.Material("#" + "".join(f"{c:02x}" for c in rgb)).color


def grid(face, count=48):
    """Return parameters off the borders, (n, m), and the area in (u, v) of each sample.

    At least `count` along each axis, equally many in each span.
    """

    def along(knots, low, high):
        ends = np.unique(np.clip(knots, low, high))
        each = -(-count // (len(ends) - 1))
        steps = np.diff(ends)[:, None] * np.ones(each) / each
        return np.ravel(ends[:-1, None] + steps * (np.arange(each) + 0.5)), np.ravel(steps)

    (u, du), (v, dv) = along(face.knots_u, *face.domain[0]), along(face.knots_v, *face.domain[1])
    return *np.meshgrid(u, v, indexing="ij"), np.outer(du, dv)


# ---- Visible objects, and their look ---------------------------------------------------------------------


def test_objects_have_names_and_places(tmp_path):
    model = Model()
    layer = model.layer("Body")
    model.file.Objects.AddBrep(box(), attributes("box", layer))
    model.file.Objects.AddMesh(quad(), attributes("", layer))
    model.file.Objects.AddSphere(rhino3dm.Sphere(ORIGIN, 2.0))
    cylinder = rhino3dm.Cylinder(rhino3dm.Circle(1.0), 5.0)
    model.file.Objects.AddExtrusion(rhino3dm.Extrusion.CreateCylinderExtrusion(cylinder, True, True), attributes())
    model.file.Objects.AddPoint(ORIGIN)
    model.file.Objects.AddTextDot("here", ORIGIN)
    model.file.Objects.AddCircle(rhino3dm.Circle(1.0))
    scene = bob.load(model.write(tmp_path / "things.3dm"))
    assert [(i.name, i.shape.kind) for i in scene.instances] == [
        ("box", "brep"),
        ("Body", "mesh"),
        ("Body", "brep"),
        ("things.3dm", "brep"),
    ]
    found, mesh, sphere, extrusion = (instance.shape for instance in scene.instances)
    assert len(found.faces) == 6
    np.testing.assert_allclose(np.array(found.bounding_box(np.eye(4))), [(0, 0, 0), (1, 2, 3)], atol=1e-5)
    np.testing.assert_array_equal(mesh.triangles, [(0, 1, 2), (1, 4, 2), (0, 2, 3)])
    u, v, _ = grid(sphere.faces[0])
    np.testing.assert_allclose(np.linalg.norm(sphere.faces[0].points(u, v), axis=-1), 2, atol=1e-12)
    assert [len(face.trims) for face in extrusion.faces] == [0, 1, 1]  # the caps are cut from squares


def test_colors_of_vertices_stand_for_those_of_objects(tmp_path):
    model, painted = Model(), quad()
    colors = [(200, 30, 30), (30, 200, 30), (30, 30, 200), (90, 90, 90), (255, 255, 255)]
    for red, green, blue in colors:
        painted.VertexColors.Add(red, green, blue)
    layer = model.layer("Body", color=(10, 200, 200))
    model.file.Objects.AddMesh(painted, attributes("painted", layer))
    model.file.Objects.AddMesh(quad(), attributes("plain", layer))
    painted, plain = bob.load(model.write(tmp_path / "painted.3dm")).instances
    np.testing.assert_allclose(painted.shape.colors, [color(*rgb) for rgb in colors], atol=1e-6)
    assert painted.material.is_white
    assert plain.shape.colors is None
    assert plain.material.color == color(10, 200, 200)


def test_what_is_hidden_is_left_out(tmp_path):
    model = Model()
    shown, off = model.layer("shown"), model.layer("off", visible=False)
    below = model.layer("below", parent=off)
    for name, layer, visible in (("a", shown, True), ("b", off, True), ("c", below, True), ("d", shown, False)):
        model.file.Objects.AddBrep(box(), attributes(name, layer, visible))
    assert [i.name for i in read_3dm(model.write(tmp_path / "x.3dm"))] == ["a"]


def test_colours_are_those_of_materials_or_of_lines(tmp_path):
    model = Model()
    red, black, painted = model.layer("red", (200, 10, 20)), model.layer("black"), model.layer("painted", (200, 10, 20))
    green, soot = model.material((5, 120, 6)), model.material((0, 0, 0))
    model.file.Layers[painted].RenderMaterialIndex = green
    source = rhino3dm.ObjectColorSource
    of_object = {"MaterialSource": rhino3dm.ObjectMaterialSource.MaterialFromObject}
    lines, paint = color(200, 10, 20), color(5, 120, 6)
    found = [
        (attributes(layer=red), lines),
        (attributes(layer=black), WHITE),
        (attributes(layer=painted), paint),
        (attributes(layer=red, ColorSource=source.ColorFromObject, ObjectColor=(1, 90, 3, 255)), color(1, 90, 3)),
        (attributes(layer=red, ColorSource=source.ColorFromObject, ObjectColor=(0, 0, 0, 255)), WHITE),
        (attributes(layer=red, ColorSource=source.ColorFromObject, ObjectColor=(64, 0, 0, 255)), WHITE),
        (attributes(layer=red, MaterialIndex=green, **of_object), paint),
        (attributes(layer=red, MaterialIndex=green), lines),  # the layer's material applies, but the layer lacks one
        (attributes(layer=painted, **of_object), lines),  # and the reverse
        (attributes(layer=red, MaterialIndex=soot, **of_object), (0, 0, 0)),
        (attributes(layer=painted, ColorSource=source.ColorFromMaterial), paint),
        (attributes(layer=red, ColorSource=source.ColorFromMaterial), WHITE),
        (attributes(layer=red, ColorSource=source.ColorFromParent), lines),
        (attributes(layer=-1), WHITE),
    ]
    for made, _ in found:
        model.file.Objects.AddBrep(box(), made)
    colors = [i.material.color for i in read_3dm(model.write(tmp_path / "x.3dm"))]
    np.testing.assert_allclose(colors, [expected for _, expected in found])


def block(model, name, *items):
    """Add a block of (geometry, attributes); return its id."""
    geometry, found = zip(*items, strict=True)
    number = model.file.InstanceDefinitions.Add(name, "", "", "", ORIGIN, geometry, found)
    return model.file.InstanceDefinitions.FindIndex(number).Id


def test_blocks_are_resolved(tmp_path):
    model = Model()
    layer = model.layer("l", (90, 90, 90))
    parent = rhino3dm.ObjectColorSource.ColorFromParent
    inner = block(
        model, "inner", (box(), attributes("box", layer, ColorSource=parent)), (quad(), attributes("q", layer))
    )
    turn = rhino3dm.Transform.Rotation(np.pi / 2, rhino3dm.Vector3d(0, 0, 1), ORIGIN)
    outer = block(model, "outer", (rhino3dm.InstanceReference(inner, turn), attributes("", layer, ColorSource=parent)))
    blue = attributes("", layer, ColorSource=rhino3dm.ObjectColorSource.ColorFromObject, ObjectColor=(0, 0, 255, 255))
    for x in (10, 20):
        move = rhino3dm.Transform.Translation(x, 0, 0)
        model.file.Objects.AddInstanceObject(rhino3dm.InstanceReference(outer, move), blue)
    found = read_3dm(model.write(tmp_path / "x.3dm"))
    assert [i.name for i in found] == ["box", "q", "box", "q"]
    assert found[0].shape is found[2].shape
    np.testing.assert_allclose([i.material.color for i in found[:2]], [color(0, 0, 255), color(90, 90, 90)])
    np.testing.assert_allclose(found[2].transform @ (1, 0, 0, 1), (20, 1, 0, 1), atol=1e-12)


def test_blocks_lend_materials(tmp_path):
    model = Model()
    layer = model.layer("l", (90, 90, 90))
    of = rhino3dm.ObjectMaterialSource
    lent = attributes("lent", layer, MaterialSource=of.MaterialFromParent)
    own = attributes("own", layer, MaterialSource=of.MaterialFromObject, MaterialIndex=model.material((1, 90, 3)))
    number = block(model, "b", (box(), lent), (box(), own))
    for material in (model.material((0, 0, 255)), -1):
        placed = attributes("", layer, MaterialSource=of.MaterialFromObject, MaterialIndex=material)
        model.file.Objects.AddInstanceObject(rhino3dm.InstanceReference(number, rhino3dm.Transform(1.0)), placed)
    found = read_3dm(model.write(tmp_path / "x.3dm"))
    colors = [i.material.color for i in found]
    np.testing.assert_allclose(colors, [color(0, 0, 255), color(1, 90, 3), color(90, 90, 90), color(1, 90, 3)])


def test_blocks_without_end_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("bobrossnet.adapters.rhino.MAX_IN_BLOCKS", 1000)
    model = Model()
    layer = model.layer("l")
    inner = block(model, "0", (box(), attributes("", layer)))
    for level in range(40):
        reference = rhino3dm.InstanceReference(inner, rhino3dm.Transform.Identity())
        inner = block(model, f"{level + 1}", (reference, attributes("", layer)), (reference, attributes("", layer)))
    reference = rhino3dm.InstanceReference(inner, rhino3dm.Transform.Identity())
    model.file.Objects.AddInstanceObject(reference, attributes("", layer))
    with pytest.raises(bob.InputError, match=r"^x\.3dm: expected at most 1,000 objects in blocks, got more"):
        bob.load(model.write(tmp_path / "x.3dm"))


# ---- Trims -----------------------------------------------------------------------------------------------


def test_a_disk_is_cut_out_of_a_plane(tmp_path):
    model = Model()
    circle = rhino3dm.Circle(rhino3dm.Point3d(3, 4, 0), 2.0).ToNurbsCurve()
    model.file.Objects.AddBrep(rhino3dm.Brep.CreateTrimmedPlane(rhino3dm.Plane.WorldXY(), circle), None)
    (instance,) = read_3dm(model.write(tmp_path / "x.3dm"))
    (face,) = instance.shape.faces
    u, v = np.concatenate([curve_points(curve) for curve in face.trims[0]]).T
    points = face.points(u, v)
    np.testing.assert_allclose(np.linalg.norm(points - (3, 4, 0), axis=1), 2, atol=1e-12)


def line(*points):
    """Return a polyline in (u, v), as rhino3dm's object."""
    return rhino3dm.Polyline([rhino3dm.Point3d(*point, 0) for point in points]).ToNurbsCurve()


def revolution():
    profile = line((1, 0), (2, 1), (1.5, 3))
    axis = rhino3dm.Line(ORIGIN, rhino3dm.Point3d(0, 1, 0))
    return rhino3dm.RevSurface.Create(profile, axis, 0.5, 5.0)


def plane():
    domain = rhino3dm.Interval(0, 6)
    return rhino3dm.PlaneSurface(rhino3dm.Plane.WorldXY(), domain, domain)


def of_degree_11():
    curve = rhino3dm.NurbsCurve(3, False, 12, 12)
    for i in range(12):
        curve.Points[i] = rhino3dm.Point4d(0.6 + i / 4, 0.3 + i % 2, 0, 1)
    for i in range(22):
        curve.Knots[i] = float(i > 10)
    return curve


@pytest.mark.parametrize(
    ("surface", "curve"),
    [
        (revolution(), line((0.5, 0.1), (4.5, 1.9))),
        (revolution(), line((1, 0.1), (1, 1.9), (3, 0.3))),
        (plane(), line((1, 0.1), (1, 1.9), (3, 0.3))),
        (plane(), of_degree_11()),
    ],
)
def test_trims_follow_the_nurbs_form_of_a_surface(surface, curve):
    """A surface of revolution has other parameters than its NURBS form; the trims pass through the same points."""
    face = untrimmed(surface.ToNurbsSurface())
    ((trim,),) = face_trims([[curve]], surface, face)
    along = np.linspace(curve.Domain.T0, curve.Domain.T1, 2000)
    want = [surface.PointAt(p.X, p.Y) for p in map(curve.PointAt, along)]
    u, v = curve_points(trim, 2000).T
    got = face.points(u, v)
    far = max(cKDTree(got).query([(p.X, p.Y, p.Z) for p in want])[0])
    assert far < 1e-2


class Changed:
    """A brep with a patched archive."""

    def __init__(self, archive, data):
        self.archive = {**archive, "data": base64.b64encode(data).decode()}

    def Encode(self):  # noqa: N802
        return self.archive


def test_a_trim_may_be_a_part_of_a_curve_and_backwards():
    archive = box().Encode()
    data = bytearray(base64.b64decode(archive["data"]))
    whole = brep_loops(box())[0][0][1]
    # Trim 1: its index and its curve's, and the range of the curve; its direction follows at byte 84.
    key = struct.pack("<2i2d", 1, 1, whole.Domain.T0, whole.Domain.T1)
    assert data.count(key) == 1
    row = data.index(key)
    middle = (whole.Domain.T0 + whole.Domain.T1) / 2
    data[row + 16 : row + 24] = struct.pack("<d", middle)
    data[row + 84] = 1
    part = brep_loops(Changed(archive, data))[0][0][1]
    for got, want in ((part.PointAtStart, whole.PointAt(middle)), (part.PointAtEnd, whole.PointAtStart)):
        np.testing.assert_allclose((got.X, got.Y), (want.X, want.Y))


def test_unknown_archives_are_refused():
    archive = box().Encode()
    data = base64.b64decode(archive["data"])
    for length in range(0, len(data) - 3000, 97):
        with pytest.raises(bob.InputError, match=r"^expected an openNURBS brep, could not read it"):
            brep_loops(Changed(archive, data[:length]))
    version = data.index(struct.pack("<I", 0x0002FFFC)) + 12
    with pytest.raises(bob.InputError, match="expected version 3, got 4"):
        brep_loops(Changed(archive, data[:version] + b"\x40" + data[version + 1 :]))


def test_faces_whose_trims_cannot_be_read_are_shown_whole(tmp_path, monkeypatch):
    def unreadable(brep):
        raise bob.InputError("expected a brep, got another")

    model = Model()
    model.file.Objects.AddBrep(box(), None)
    model.file.Objects.AddBrep(box(), None)
    monkeypatch.setattr("bobrossnet.adapters.rhino.brep_loops", unreadable)
    with pytest.warns(bob.InputWarning, match=r"^x\.3dm: trims of 12 of 12 faces can't be read: shown whole$"):
        found = read_3dm(model.write(tmp_path / "x.3dm"))
    assert [len(i.shape.faces) for i in found] == [6, 6]


def test_faces_of_too_high_a_degree_are_left_out(tmp_path):
    surface = rhino3dm.NurbsSurface.Create(3, False, 11, 2, 11, 2)
    for i in range(11):
        for j in range(2):
            surface.Points[i, j] = rhino3dm.Point4d(i, j, 0, 1)
    for i in range(20):
        surface.KnotsU[i] = float(i > 9)
    for i in range(2):
        surface.KnotsV[i] = float(i)
    model = Model()
    model.file.Objects.AddSurface(surface, None)
    with pytest.raises(bob.InputError, match=r"^x\.3dm: expected surfaces or meshes, got knots_u: expected .*"):
        bob.load(model.write(tmp_path / "x.3dm"))
    model.file.Objects.AddBrep(box(), None)
    with pytest.warns(bob.InputWarning, match=r"^x\.3dm: left out 1 of 7 faces \(knots_u: expected .*\)$"):
        assert len(read_3dm(model.write(tmp_path / "x.3dm"))) == 1


# ---- Real files ------------------------------------------------------------------------------------------


@needs_models
@pytest.mark.parametrize(
    ("name", "faces", "trimmed"),
    [
        ("camera", 32, 17),  # of 119 and 69, the others on hidden layers
        ("gear", 128, 124),
        ("human_head", 10, 0),
        ("lightbulb", 110, 16),
        ("mech_part_a", 41, 33),
        ("rhino_teapot", 97, 49),
        ("t_joint", 18, 11),
        ("terrain", 1, 1),
        ("untrimmed_surfaces", 141, 8),
    ],
)
def test_real_files_have_their_faces_and_trims(name, faces, trimmed):
    found = [face for i in read_3dm(NURBS / f"{name}.3dm") for face in i.shape.faces]
    assert (len(found), sum(bool(face.trims) for face in found)) == (faces, trimmed)


@needs_models
@pytest.mark.parametrize("name", ["diner_mug", "mech_part_a", "rhino_logo", "solid_handle"])
def test_trimmed_faces_are_where_rhinos_own_mesh_is(name):
    """Rhino's display mesh lies inside the trims, and has the same area."""
    mesh = trimesh.load(NURBS / f"{name}.rendermesh.ply", process=False)
    size = np.linalg.norm(np.ptp(mesh.vertices, axis=0))
    on_mesh = cKDTree(trimesh.sample.sample_surface(mesh, 200_000, seed=0)[0])
    area = 0.0
    for face in (face for i in read_3dm(NURBS / f"{name}.3dm") for face in i.shape.faces):
        u, v, around = grid(face)
        left = inside(face, u, v)
        by = face.derivatives(u[left], v[left], 1)
        area += np.linalg.norm(np.cross(by[:, 1, 0], by[:, 0, 1]), axis=-1) @ around[left]
        assert on_mesh.query(by[:, 0, 0])[0].max(initial=0) < 0.01 * size
    assert area == pytest.approx(mesh.area, rel=0.01)


# ---- Errors ----------------------------------------------------------------------------------------------


def test_files_without_surfaces_say_what_they_hold(tmp_path):
    model = Model()
    off = model.layer("off", visible=False)
    model.file.Objects.AddBrep(box(), attributes("", off))
    for _ in range(2):
        model.file.Objects.AddCircle(rhino3dm.Circle(1.0))
    with pytest.raises(bob.InputError, match=r"^x\.3dm: expected surfaces or meshes, got curve \(2\), hidden \(1\)$"):
        bob.load(model.write(tmp_path / "x.3dm"))
    with pytest.raises(bob.InputError, match=r"^y\.3dm: expected surfaces or meshes, got none$"):
        bob.load(Model().write(tmp_path / "y.3dm"))


def test_damaged_files_are_refused(tmp_path):
    model = Model()
    model.file.Objects.AddBrep(box(), None)
    whole = model.write(tmp_path / "whole.3dm").read_bytes()
    file = tmp_path / "x.3dm"
    for length in (1, 10, 31, 32, 33, 100, *range(200, len(whole) - 200, len(whole) // 40)):
        file.write_bytes(whole[:length])
        with pytest.raises(bob.InputError, match=r"^x\.3dm: [^\n]*$"):
            bob.load(file)
    file.write_bytes(b"solid of another kind")
    with pytest.raises(
        bob.InputError, match=r"^x\.3dm: expected a Rhino file, got something else or an incomplete file$"
    ):
        bob.load(file)


def test_files_are_read_in_a_process_of_their_own(tmp_path, monkeypatch):
    model = Model()
    model.file.Objects.AddBrep(box(), attributes("a"))
    model.file.Objects.AddMesh(rhino3dm.Mesh(), attributes("of nothing"))
    file = model.write(tmp_path / "x.3dm")
    with pytest.warns(bob.InputWarning) as here:
        (expected,) = read_3dm(file)
    monkeypatch.setattr("bobrossnet.adapters.rhino.call_apart", call_apart)
    with pytest.warns(bob.InputWarning) as apart:
        (found,) = read_3dm(file)
    assert found.digest() == expected.digest()
    assert found.name == "a"
    assert [str(w.message) for w in apart] == [str(w.message) for w in here]
    file.write_bytes(file.read_bytes()[:1000])
    with pytest.raises(bob.InputError, match=r"^x\.3dm: expected a Rhino file"):
        bob.load(file)


@pytest.mark.skipif(sys.platform != "linux", reason="memory is only limited under Linux")
def test_memory_is_limited():
    code = "from bobrossnet.support.machine import limit_memory; limit_memory(2**28); bytearray(2**{})"
    assert subprocess.run([sys.executable, "-c", code.format(26)]).returncode == 0
    done = subprocess.run([sys.executable, "-c", code.format(29)], capture_output=True, text=True)
    assert "MemoryError" in done.stderr


def test_rhino3dm_may_be_missing(tmp_path, monkeypatch):
    file = Model().write(tmp_path / "x.3dm")
    monkeypatch.setitem(sys.modules, "rhino3dm", None)
    with pytest.raises(bob.InputError) as error:
        bob.load(file)
    assert str(error.value) == "x.3dm: reading .3dm files needs rhino3dm: pip install 'bobrossnet[cad]'"
