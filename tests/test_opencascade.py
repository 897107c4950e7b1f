"""STEP and IGES: files written by OpenCascade are read, and compared with its own measurements."""

import math
import os
import re
import signal
import subprocess
import sys
import time
from collections import Counter
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from clocks import least
from models import MODELS
from nurbs_shapes import curve_points, inside
from processes import running

import bobrossnet as bob
from bobrossnet.adapters import files, reader
from bobrossnet.adapters.apart import call_apart
from bobrossnet.adapters.opencascade import read_iges, read_step

pytest.importorskip("OCP")

from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeVertex
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepGProp import BRepGProp
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakeRevol,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.collections import Array1_gp_Pnt, Array2_gp_Pnt
from OCP.Geom import Geom_BezierCurve, Geom_BezierSurface
from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.IGESCAFControl import IGESCAFControl_Writer
from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Compound, TopoDS_Face
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

HAMMER = MODELS / "nurbs" / "occt_hammer.iges"
RED, GREEN, BLUE = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.25, 0.25, 1.0)
X, Z = gp_Dir(1, 0, 0), gp_Dir(0, 0, 1)


class Document:
    """A STEP or IGES file under construction."""

    def __init__(self):
        self.document = TDocStd_Document(TCollection_ExtendedString("BinXCAF"))
        XCAFDoc_DocumentTool.SetLengthUnit_s(self.document, 0.001)
        self.tool = XCAFDoc_DocumentTool.ShapeTool_s(self.document.Main())
        self.colors = XCAFDoc_DocumentTool.ColorTool_s(self.document.Main())

    def named(self, label, name, color=None):
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name, True))
        if color is not None:
            self.paint(label, color)
        return label

    def part(self, shape, name, color=None):
        XCAFDoc_ShapeTool.SetAutoNaming_s(False)
        return self.named(self.tool.AddShape(shape, False), name, color)

    def paint(self, label, color):
        color = Quantity_Color(*color, Quantity_TypeOfColor.Quantity_TOC_RGB)
        self.colors.SetColor(label, color, XCAFDoc_ColorType.XCAFDoc_ColorSurf)

    def assembly(self, name):
        return self.named(self.tool.NewShape(), name)

    def write(self, path):
        if path.suffix == ".step":
            self.tool.UpdateAssemblies()
            writer = STEPCAFControl_Writer()
        else:
            writer = IGESCAFControl_Writer()
        assert writer.Transfer(self.document)
        assert writer.Write(str(path))
        return path


def explore(shape, kind):
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def at(x, y, z, angle=0.0):
    """Return a location: a rotation about z, then a translation."""
    place = gp_Trsf()
    place.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), Z), angle)
    place.SetTranslationPart(gp_Vec(x, y, z))
    return TopLoc_Location(place)


def cylinder(radius, height, x=0.0, y=0.0, z=0.0, along=Z):
    return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(x, y, z), along), radius, height).Shape()


def box(x=10.0, y=20.0, z=30.0):
    return BRepPrimAPI_MakeBox(x, y, z).Shape()


def cut(shape, tool):
    return BRepAlgoAPI_Cut(shape, tool).Shape()


def filleted():
    shape = box()
    fillet = BRepFilletAPI_MakeFillet(shape)
    for edge in explore(shape, TopAbs_ShapeEnum.TopAbs_EDGE):
        fillet.Add(1.5, TopoDS.Edge(edge))
    return fillet.Shape()


def revolved():
    """Return a Bezier curve revolved about an axis: closed, not an elementary surface."""
    points = Array1_gp_Pnt(1, 4)
    for i, (x, z) in enumerate([(3, 0), (8, 4), (1, 8), (4, 12)]):
        points.SetValue(i + 1, gp_Pnt(x, 0, z))
    edge = BRepBuilderAPI_MakeEdge(Geom_BezierCurve(points)).Edge()
    return BRepPrimAPI_MakeRevol(edge, gp_Ax1(gp_Pnt(0, 0, 0), Z)).Shape()


def of_degree_12():
    points = Array2_gp_Pnt(1, 13, 1, 3)
    for i in range(13):
        for j in range(3):
            points.SetValue(i + 1, j + 1, gp_Pnt(i, 3 * j, 3 * math.sin(2 * i) + j))
    return BRepBuilderAPI_MakeFace(Geom_BezierSurface(points), 1e-7).Face()


SHAPES = {
    "box": box(),
    "box, drilled across an edge": cut(box(), cylinder(3, 50, z=-10)),
    "cylinder": cylinder(5, 20),
    "cylinder, drilled across its seam": cut(cylinder(5, 20), cylinder(2, 40, x=-20, z=10, along=X)),
    "sphere": BRepPrimAPI_MakeSphere(7).Shape(),
    "sphere, drilled across its seam": cut(BRepPrimAPI_MakeSphere(7).Shape(), cylinder(2, 40, x=-20, z=1, along=X)),
    "torus": BRepPrimAPI_MakeTorus(10, 3).Shape(),
    "torus, drilled across its seams": cut(BRepPrimAPI_MakeTorus(10, 3).Shape(), cylinder(2, 40, x=10, z=-20)),
    "cone": BRepPrimAPI_MakeCone(5, 0, 10).Shape(),
    "filleted": filleted(),
    "revolved": revolved(),
    "revolved, drilled": cut(revolved(), cylinder(1.5, 40, x=-20, z=4, along=X)),
    "degree 12": of_degree_12(),
}


@pytest.fixture
def here(monkeypatch):
    """Read in this process, which has imported OpenCascade: a second less for each file."""
    monkeypatch.setattr("bobrossnet.adapters.apart._is_apart", True)
    monkeypatch.setattr("bobrossnet.adapters.occ.limit", lambda size: None)


@pytest.fixture(scope="module")
def read_back(tmp_path_factory):
    """Return the shapes read from a file, by name."""
    folder = tmp_path_factory.mktemp("cad")
    document = Document()
    for name, shape in SHAPES.items():
        document.part(shape, name)
    by_name = {}
    for instance in read_step(document.write(folder / "shapes.step")):
        by_name.setdefault(instance.name, []).append(instance)
    return by_name


def area_of(shape):
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, properties)
    return properties.Mass()


def size_of(shape):
    around = Bnd_Box()
    BRepBndLib.Add_s(shape, around)
    return around.SquareExtent() ** 0.5


def area(face, count=120):
    """Return the area of a trimmed face, by the midpoint rule over the bounding rectangle of its trims."""
    low, high = np.transpose(face.domain)
    if face.trims:
        points = np.concatenate([curve_points(curve) for loop in face.trims for curve in loop])
        low, high = np.maximum(low, points.min(axis=0)), np.minimum(high, points.max(axis=0))
    steps = (np.arange(count) + 0.5) / count
    u, v = np.meshgrid(*(low[:, None] + steps * (high - low)[:, None]), indexing="ij")
    by = face.derivatives(u, v, 1)
    density = np.linalg.norm(np.cross(by[..., 1, 0, :], by[..., 0, 1, :]), axis=-1)
    return (density * inside(face, u, v)).mean() * np.prod(high - low)


def faces_of(instances):
    return [face for instance in instances for face in instance.shape.faces]


@pytest.mark.parametrize("name", SHAPES)
def test_areas_are_those_of_opencascade(read_back, name):
    assert sum(map(area, faces_of(read_back[name]))) == pytest.approx(area_of(SHAPES[name]), rel=2e-3)


@pytest.mark.parametrize("name", [name for name in SHAPES if "drilled" in name])
def test_what_trims_leave_lies_on_the_shape(read_back, name):
    """It spans no hole."""
    shape = SHAPES[name]
    for i, face in enumerate(faces_of(read_back[name])):
        low, high = np.transpose(face.domain)
        u, v = np.random.default_rng(i).uniform(low, high, (60, 2)).T
        left = inside(face, u, v)
        for point in face.points(u[left], v[left]):
            vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*point)).Vertex()
            assert BRepExtrema_DistShapeShape(vertex, shape).Value() < 1e-5 * size_of(shape)


def test_trims_are_only_where_something_is_cut_off(read_back):
    trimmed = {name: [bool(face.trims) for face in faces_of(instances)] for name, instances in read_back.items()}
    assert trimmed["box"] == [False] * 6
    assert trimmed["filleted"] == [False] * 26
    assert trimmed["sphere"] == [False] * 2
    assert sorted(trimmed["cylinder"]) == [False, False, True, True]
    assert sum(trimmed["box, drilled across an edge"]) == 2


def test_planes_reach_beyond_their_trims(read_back):
    for face in faces_of(read_back["cylinder"]):
        for loop in face.trims:
            points = np.concatenate([curve_points(curve) for curve in loop])
            low, high = np.transpose(face.domain)
            assert (low < points.min(axis=0) - 0.01).all()
            assert (high > points.max(axis=0) + 0.01).all()


def test_high_degrees_are_approximated(read_back):
    (face,) = faces_of(read_back["degree 12"])
    assert max(face.degree_u, face.degree_v) <= 9
    surface = BRep_Tool.Surface_s(TopoDS.Face(SHAPES["degree 12"]))
    u, v = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 1, 20), np.linspace(0, 1, 20)))
    expected = [[p.X(), p.Y(), p.Z()] for p in map(surface.Value, u.tolist(), v.tolist())]
    assert np.abs(face.points(u, v) - expected).max() < 1e-6 * size_of(SHAPES["degree 12"])


# ---- Names, colours, places ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def furniture(tmp_path_factory):
    """Boxes, red with a green face, twice in an assembly, and a ball coloured blue only by the assembly."""
    document = Document()
    shape = box()
    crate = document.part(shape, "Kästchen", RED)
    document.paint(document.tool.AddSubShape(crate, next(explore(shape, TopAbs_ShapeEnum.TopAbs_FACE))), GREEN)
    ball = document.part(BRepPrimAPI_MakeSphere(7).Shape(), "ball")
    room = document.assembly("room")
    document.tool.AddComponent(room, crate, at(100, 0, 0, math.pi / 2))
    document.tool.AddComponent(room, crate, at(0, 0, 40))
    document.paint(document.tool.AddComponent(room, ball, at(0, 50, 0)), BLUE)
    folder = tmp_path_factory.mktemp("furniture")
    return {suffix: document.write(folder / f"room{suffix}") for suffix in (".step", ".iges")}


@pytest.mark.usefixtures("here")
def test_parts_of_an_assembly_keep_names_colors_and_places(furniture):
    instances = read_step(furniture[".step"])
    crates = [instance for instance in instances if instance.name == "Kästchen"]
    for crate in crates:
        assert Counter(face.color for face in crate.shape.faces) == {RED: 5, GREEN: 1}
        assert crate.material.is_white
    assert crates[0].shape is crates[1].shape
    turned = [[0, -1, 0, 100], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    assert np.allclose(crates[0].transform, turned)
    assert np.allclose(crates[1].transform[:3, 3], [0, 0, 40])
    (ball,) = [instance for instance in instances if instance.name == "ball"]
    assert ball.material.color == BLUE
    assert not ball.shape.is_colored
    assert np.allclose(ball.transform[:3, 3], [0, 50, 0])


@pytest.mark.usefixtures("here")
def test_iges_keeps_colors_and_places(furniture):
    instances = read_iges(furniture[".iges"])
    count = Counter(face.color or i.material.color for i in instances for face in i.shape.faces)
    assert count == {RED: 10, GREEN: 2, BLUE: 2}
    assert sum(map(area, faces_of(instances))) == pytest.approx(2 * 2200 + 4 * math.pi * 49, rel=2e-3)
    crates = [face for face in faces_of(instances) if face.color in (RED, GREEN)]
    points = np.concatenate([face.control_points.reshape(-1, 3) for face in crates])
    assert np.allclose([points.min(axis=0), points.max(axis=0)], [[0, 0, 0], [100, 20, 70]])


@pytest.mark.usefixtures("here")
def test_faces_without_a_color_have_that_of_their_place(tmp_path):
    document = Document()
    shape = box()
    crate = document.part(shape, "crate")
    document.paint(document.tool.AddSubShape(crate, next(explore(shape, TopAbs_ShapeEnum.TopAbs_FACE))), GREEN)
    room = document.assembly("room")
    for i, color in enumerate((RED, BLUE, None)):
        place = document.tool.AddComponent(room, crate, at(0, 0, 40 * i))
        if color:
            document.paint(place, color)
    instances = read_step(document.write(tmp_path / "room.step"))
    assert [Counter(face.color for face in i.shape.faces) for i in instances] == [
        {GREEN: 1, color: 5} for color in (RED, BLUE, None)
    ]
    mesh = instances[0].shape.mesh(5)
    edges = np.sort(mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()  # closed, as it was not in parts
    assert {tuple(color) for color in mesh.face_colors} == {RED, GREEN}


@pytest.mark.usefixtures("here")
def test_faces_of_triangles_are_meshes_next_to_those_with_surfaces():
    """A drilled block with surfaces, and one of 12 triangles."""
    triangles, drilled = read_step(Path(__file__).parent / "cases/step-tessellated/solid-and-triangles.step")
    assert isinstance(triangles.shape, bob.Mesh)
    assert len(triangles.shape.triangles) == 12
    assert triangles.shape.normals is not None
    a, b, c = np.moveaxis(triangles.shape.vertices[triangles.shape.triangles], 1, 0)
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(2200)
    block, hole = 2200 - 2 * math.pi * 9, 2 * math.pi * 3 * 30
    assert sum(map(area, faces_of([drilled]))) == pytest.approx(block + hole, rel=2e-3)


@pytest.mark.usefixtures("here")
def test_faces_of_triangles_keep_colors_and_places(tmp_path):
    shape = box()
    BRepMesh_IncrementalMesh(shape, 1)
    builder, compound = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(compound)
    bare = []
    for face in explore(shape, TopAbs_ShapeEnum.TopAbs_FACE):
        bare.append(TopoDS_Face())
        builder.MakeFace(bare[-1], BRep_Tool.Triangulation_s(TopoDS.Face(face), TopLoc_Location()))
        builder.Add(compound, bare[-1])
    document = Document()
    crate = document.part(compound, "crate", RED)
    room = document.assembly("room")
    document.tool.AddComponent(room, crate, at(100, 0, 0, math.pi / 2))
    document.tool.AddComponent(room, crate, at(0, 0, 40))
    STEPCAFControl_Writer()  # which knows the settings
    usual = [
        (f"write.step.{name}", Interface_Static.IVal_s(f"write.step.{name}")) for name in ("schema", "tessellated")
    ]
    Interface_Static.SetIVal_s("write.step.schema", 5)  # AP242
    Interface_Static.SetIVal_s("write.step.tessellated", 1)
    try:
        file = document.write(tmp_path / "room.step")
    finally:
        for setting in usual:
            Interface_Static.SetIVal_s(*setting)
    scene = bob.Scene(read_step(file))
    assert {instance.material.color for instance in scene.instances} == {RED}
    mesh = scene.mesh()
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(2 * 2200)
    assert np.allclose([mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)], [[0, 0, 0], [100, 20, 70]])


@pytest.mark.usefixtures("here")
def test_what_is_hidden_is_left_out(tmp_path):
    document = Document()
    document.part(box(), "seen", (0.0, 0.0, 0.0))
    document.colors.SetVisibility(document.part(box(), "hidden"), False)
    (seen,) = read_step(document.write(tmp_path / "x.step"))
    assert seen.name == "seen"
    assert seen.material.color == (0, 0, 0)


def test_nothing_is_printed(furniture, capfd):
    read_iges(furniture[".iges"])
    assert capfd.readouterr() == ("", "")


# ---- Files that can't be read ----------------------------------------------------------------------------


def refused(path):
    with pytest.raises(bob.InputError) as caught:
        bob.load(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_readers_collect_no_cycles():
    """The collector of cycles takes a fifth of a reader's time."""
    assert not call_apart("gc", "isenabled")


def test_readers_import_little_of_the_package():
    """Its own imports take 0.2 s."""
    modules = call_apart("greedy", "imported")
    assert "bobrossnet.adapters.apart" in modules
    assert "bobrossnet.pictures" not in modules


def test_each_cad_format_has_a_reader():
    assert {*reader.MODULES} == {*files.CAD_READERS}


STARTED = """
import sys
sys.argv[0] = "bobrossnet"
import bobrossnet
from bobrossnet.adapters import reader
from bobrossnet.command_line import cli
(early,) = reader._early.values()
status = cli.main()
print(status, len(reader._early), early.returncode)
"""


@pytest.mark.parametrize(("arguments", "told"), [([], "0 0 0"), (["--nonsense"], "2 1 None")])
def test_the_command_starts_the_reader_before_its_imports(furniture, arguments, told):
    command = [sys.executable, "-c", STARTED, "info", str(furniture[".step"]), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == told


def test_unused_readers_end(furniture):
    reader.start_early(["info", "missing.step", str(furniture[".step"])])
    (early,) = reader._early.values()
    reader._end_early()
    assert early.returncode is not None
    assert not reader._early


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux copies processes safely")
@pytest.mark.skipif(os.cpu_count() == 1, reason="needs two cores")
def test_two_processes_convert_faces():
    calls = call_apart("greedy", "shared", "")
    assert [i for i, _ in calls] == [*range(20)]
    assert len({process for i, process in calls if i % 2}) == 1
    assert len({process for _, process in calls}) == 2
    with pytest.raises(bob.InputError, match="crashed"):
        call_apart("greedy", "shared", "crash")


@pytest.mark.parametrize("suffix", [".stp", ".igs"])
@pytest.mark.parametrize("content", [b"\x00solid nothing\n" * 20, b"x", b"ISO-10303-2" + b"S" * 72 + b"\n"])
def test_other_files_are_refused_at_once(tmp_path, monkeypatch, suffix, content):
    monkeypatch.delattr("bobrossnet.adapters.opencascade.call_apart")
    path = tmp_path / f"x{suffix}"
    path.write_bytes(content)
    kind = "STEP file, which begins with ISO-10303-21" if suffix == ".stp" else "IGES file"
    assert refused(path).startswith(f"x{suffix}: expected a{'n' if kind.startswith('I') else ''} {kind}")


def test_iges_that_ends_early_is_refused_at_once(furniture, tmp_path, monkeypatch):
    monkeypatch.delattr("bobrossnet.adapters.opencascade.call_apart")
    whole = furniture[".iges"].read_bytes()
    for share in (0.01, 0.2, 0.8, 0.999):
        (tmp_path / "cut.iges").write_bytes(whole[: int(share * len(whole))])
        assert "ends before" in refused(tmp_path / "cut.iges")


@pytest.mark.parametrize(("suffix", "damage"), [(".step", b""), (".iges", b"\n" + b" " * 72 + b"T      1\n")])
def test_files_of_which_a_part_is_missing_are_refused(furniture, tmp_path, suffix, damage):
    """OpenCascade crashes on one of the files."""
    whole = furniture[suffix].read_bytes()
    path = tmp_path / f"cut{suffix}"
    path.write_bytes(whole[: int(0.8 * len(whole))] + damage)
    assert refused(path).startswith(f"cut{suffix}: expected ")


@pytest.mark.usefixtures("here")
def test_curves_alone_are_refused(tmp_path):
    document = Document()
    document.part(BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(1, 2, 3)).Edge(), "line")
    assert refused(document.write(tmp_path / "x.step")) == "x.step: expected faces, got curves (1)"


def test_a_crash_is_an_error():
    with pytest.raises(bob.InputError, match="crashed"):
        call_apart("os", "abort")


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has these limits")
def test_readers_stop_at_what_a_file_may_cost():
    with pytest.raises(MemoryError):
        call_apart("greedy", "eat", "1000")
    with pytest.raises(bob.InputError, match="longer"):
        call_apart("greedy", "spin", "1000")
    assert call_apart("greedy", "eat", str(10**7)) > 10**8  # larger files may take more


NEVER_DONE = """
import sys
from bobrossnet.command_line import cli
from bobrossnet.adapters import apart, opencascade
opencascade.call_apart = lambda *_: apart.call_apart("signal", "pause")
sys.exit(cli.main(["info", sys.argv[1]]))
"""


def parent_and_state(pid):
    """Return a process' parent and state, or None if it does not exist."""
    try:
        state, parent = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[:2]
    except OSError:
        return None
    return int(parent), state


def within_seconds(find):
    """Return the first true result of `find`."""
    for _ in range(500):
        if found := find():
            return found
        time.sleep(0.01)
    raise AssertionError("found nothing")


@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_stopping_ends_the_reader(tmp_path, stop):
    path = tmp_path / "x.step"
    path.write_text("ISO-10303-21;")
    command = [sys.executable, "-c", NEVER_DONE, str(path)]

    def children(process):
        pids = [int(folder.name) for folder in Path("/proc").glob("[0-9]*")]
        return [pid for pid in pids if (parent_and_state(pid) or (0,))[0] == process.pid]

    def stopping():
        with running(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            (child,) = within_seconds(partial(children, process))
            process.send_signal(stop)
            start = time.monotonic()
            output, errors = process.communicate(timeout=20)
            took = time.monotonic() - start
            assert within_seconds(lambda: (parent_and_state(child) or (0, "Z"))[1] == "Z")  # dead, perhaps unreaped
        assert output == ""
        if stop != signal.SIGKILL:
            assert process.returncode == 130
            assert errors == "bobrossnet: interrupted\n"
        return took

    assert least(stopping, 5) < 5


@pytest.fixture(scope="module")
def in_parts(tmp_path_factory):
    """Return an assembly of two files: the one to read refers to the other, wall.stp."""
    folder = tmp_path_factory.mktemp("parts")
    document = Document()
    room = document.assembly("room")
    document.tool.AddComponent(room, document.part(box(), "wall"), TopLoc_Location())
    document.tool.UpdateAssemblies()
    writer = STEPCAFControl_Writer()
    assert writer.Transfer(document.document, STEPControl_StepModelType.STEPControl_AsIs, str(folder) + "/")
    assert writer.Write(str(folder / "room.step"))
    assert (folder / "wall.stp").is_file()
    return {"room": (folder / "room.step").read_text(), "wall": (folder / "wall.stp").read_text()}


def naming(text, name):
    """Return the assembly with another name for its part."""
    return re.sub(r"'[^']*wall\.stp'", lambda _: f"'{name}'", text)


def test_the_limits_hold_for_an_assembly(in_parts, tmp_path, monkeypatch):
    from bobrossnet.adapters.occ import read_assembly

    limits = []
    monkeypatch.setattr("bobrossnet.adapters.occ.limit", limits.append)
    files = [tmp_path / "room.stp", tmp_path / "wall.stp"]
    files[0].write_text(naming(in_parts["room"], "wall.stp"))
    files[1].write_text(in_parts["wall"])
    read_assembly("STEP", str(files[0]))
    room, wall = (file.stat().st_size for file in files)
    assert limits == [room, room + wall]


def test_parts_in_files_beside_an_assembly_are_read(in_parts, tmp_path):
    for name in ("wall.stp", "sub/wall.stp"):
        file = tmp_path / "room.step"
        file.write_text(naming(in_parts["room"], name))
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(in_parts["wall"])
        (instance,) = read_step(file)
        assert len(instance.shape.faces) == 6


@pytest.mark.usefixtures("here")
def test_parts_elsewhere_are_not_read(in_parts, tmp_path):
    folder = tmp_path / "model"
    (folder / "sub").mkdir(parents=True)
    (tmp_path / "wall.stp").write_text(in_parts["wall"])
    (folder / "link.stp").symlink_to("../wall.stp")
    os.mkfifo(folder / "pipe.stp")
    (folder / r"..\wall.stp").write_text(in_parts["wall"])  # OpenCascade would take it for ../wall.stp
    (folder / "sub/room.stp").write_text(naming(in_parts["room"], "../../wall.stp"))
    names = ["../wall.stp", f"{tmp_path}/wall.stp", "link.stp", "pipe.stp", r"..\\wall.stp", "sub/room.stp"]
    for name in names:
        file = folder / "room.step"
        file.write_text(naming(in_parts["room"], name))
        assert "in or below its folder, found no such file: " in refused(file)


def test_errors_of_the_other_process_are_raised_here():
    assert call_apart("os.path", "basename", "a/b") == "b"
    with pytest.raises(RuntimeError, match=r"FileNotFoundError: .*nowhere"):
        call_apart("os", "listdir", "/nowhere")


def test_without_opencascade_the_error_says_what_to_install(furniture, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert refused(furniture[".step"]) == (
        "room.step: reading .step files needs OpenCascade: pip install 'bobrossnet[cad]'"
    )


def test_opencascade_is_only_imported_where_a_file_is_read():
    script = "import bobrossnet, sys; sys.exit(any(name.partition('.')[0] == 'OCP' for name in sys.modules))"
    subprocess.run([sys.executable, "-c", script], check=True)


@pytest.mark.skipif(not HAMMER.is_file(), reason=f"no model at {HAMMER}")
def test_the_hammer_of_opencascade():
    (hammer,) = read_iges(HAMMER)
    assert len(hammer.shape.faces) == 45
    assert hammer.name == "occt_hammer.iges"
