"""Parts: the trees and names of files, scenes of some parts, and units."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from models import MODELS, needs_models

import bobrossnet as bob
from bobrossnet import sdf

CORNERS = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], float)
SIDES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
OBJ = "\n".join(
    [
        *(f"v {x} {y} {z}" for at in (0, 3, 6) for x, y, z in CORNERS + (at, 0, 0)),
        "f 1 3 2",
        "o housing",
        *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in SIDES[1:]),
        "g bolt",
        *(f"f {a + 5} {b + 5} {c + 5}" for a, b, c in SIDES),
        "o lid",
        *(f"f {a + 9} {b + 9} {c + 9}" for a, b, c in SIDES),
    ]
)


def tetrahedron(offset=(0, 0, 0), name=None, **held):
    return bob.Instance(bob.Mesh(CORNERS, SIDES), name=name, **held).translate(offset)


def paths(scene):
    return [str(part) for part in scene.parts.walk()]


@pytest.fixture
def machine(tmp_path):
    file = tmp_path / "machine.obj"
    file.write_text(OBJ)
    return bob.load(file)


def test_groups_of_an_obj_are_parts(machine):
    assert paths(machine) == ["unnamed", "housing", "housing/bolt", "lid"]
    assert len(machine.instances) == 1  # and the mesh is as before
    bolt = machine.part("bolt")
    assert bolt.extent.low.tolist() == [3, 0, 0]
    assert bolt.extent.size.tolist() == [1, 1, 1]
    assert [(own.start, own.stop) for own in bolt.own] == [(4, 8)]
    assert machine.part("housing")["bolt"] is bolt
    assert machine.part(2) is bolt
    assert machine.part(("housing", "bolt")) is bolt
    assert machine.part(bolt) is bolt


def test_materials_share_the_names_of_an_obj(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n")
    lines = OBJ.replace("g bolt", "usemtl blue\ng bolt").replace("o lid", "usemtl red\no lid")
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{lines}")
    scene = bob.load(tmp_path / "a.obj")
    assert paths(scene) == ["unnamed", "housing", "housing/bolt", "lid"]
    assert scene.part("bolt").color == (0, 0, 1)
    assert scene.part("lid").color == (1, 0, 0)


@needs_models
def test_nodes_of_a_gltf_are_parts():
    scene = bob.load(MODELS / "loader_originals/glb_nested/nested.glb")
    assert paths(scene) == ["block01", "block01/block02", "block01/block02/block03"]
    assert scene.unit == "m"
    with pytest.warns(bob.InputWarning):
        truck = bob.load(MODELS / "loader_originals/glb_material/CesiumMilkTruck.glb")
    body, first, second = truck.parts.walk()
    assert [body.name, first.name, second.name] == ["Cesium_Milk_Truck", "Wheels", "Wheels 2"]
    assert len(body.own) == 3  # materials
    assert np.allclose(first.extent.size, second.extent.size)


@needs_models
def test_objects_of_a_3mf_are_parts():
    scene = bob.load(MODELS / "loader_originals/3mf/counterXP.3MF")
    assert scene.unit == "mm"
    assert len(scene.parts) == 1
    screws = [part for part in scene.parts["counterXP"] if "SCREW" in part.name]
    assert len(screws) == 5
    assert len({part.name for part in screws}) == 5
    assert all(abs(part.extent.size[2] - 25.4) < 1e-4 for part in screws)


@needs_models
def test_layers_of_rhino_are_parts():
    pytest.importorskip("rhino3dm")
    scene = bob.load(MODELS / "nurbs/lightbulb.3dm")
    assert scene.unit == "mm"
    assert len(list(scene.parts.walk())) == 1 + len(scene.instances)
    assert scene.part("Default/brep 2").instances == (1,)


def test_assemblies_of_a_step_are_parts(tmp_path):
    pytest.importorskip("OCP")
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere
    from test_opencascade import Document, at, box

    document = Document()
    bolt = document.part(BRepPrimAPI_MakeSphere(2).Shape(), "bolt")
    plate = document.part(box(), "plate")
    inner, outer = document.assembly("inner"), document.assembly("outer")
    for x in (0, 50):
        document.tool.AddComponent(inner, bolt, at(x, 0, 0))
    document.tool.AddComponent(inner, plate, at(0, 0, 30))
    for angle in (0, math.pi / 2):
        document.tool.AddComponent(outer, inner, at(0, 0, 100 * angle, angle))
    scene = bob.load(document.write(tmp_path / "a.step"))
    below = ["bolt", "bolt 2", "plate"]
    both = [[f"outer/{name}", *(f"outer/{name}/{part}" for part in below)] for name in ("inner", "inner 2")]
    assert paths(scene) == ["outer", *both[0], *both[1]]
    assert scene.unit == "mm"
    # Both places of the assembly share the shapes.
    assert len({id(instance.shape) for instance in scene.instances}) == 2
    alone = scene.isolate("outer/inner 2/bolt 2")
    assert alone.instances[0].shape is scene.instances[0].shape
    low, high = alone.parts.extent
    assert np.allclose((low + high) / 2, (0, 50, 50 * math.pi), atol=1e-4)
    bob.save_scene(scene, tmp_path / "a.bob")
    again = bob.load(tmp_path / "a.bob")
    assert paths(again) == paths(scene)
    assert again.unit == "mm"


@pytest.mark.parametrize("unit", ["INCH", "M", "MM"])
def test_lengths_of_a_step_are_millimetres(tmp_path, unit):
    pytest.importorskip("OCP")
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.Interface import Interface_Static
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    writer = STEPControl_Writer()
    Interface_Static.SetCVal_s("write.step.unit", unit)
    try:
        writer.Transfer(BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape(), STEPControl_StepModelType.STEPControl_AsIs)
        writer.Write(str(tmp_path / "a.step"))
    finally:
        Interface_Static.SetCVal_s("write.step.unit", "MM")
    scene = bob.load(tmp_path / "a.step")
    assert scene.unit == "mm"
    assert np.allclose(scene.extent.size, (10, 20, 30))
    assert np.allclose(scene.converted("in").extent.size, np.array((10, 20, 30)) / 25.4)


@pytest.mark.parametrize(("word", "unit"), [("inch", "in"), ("micron", "um"), ("", "mm"), ("furlong", "mm")])
def test_units_of_a_3mf(tmp_path, word, unit):
    from zipfile import ZipFile

    namespace = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in CORNERS)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in SIDES)
    mesh = f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"
    stated = f'unit="{word}"' if word else ""
    with ZipFile(tmp_path / "a.3mf", "w") as archive:
        archive.writestr(
            "3D/3dmodel.model",
            f'<model {stated} xmlns="{namespace}"><resources><object id="1" name="wedge">{mesh}</object></resources>'
            '<build><item objectid="1"/><item objectid="1"/></build></model>',
        )
    scene = bob.load(tmp_path / "a.3mf")
    assert scene.unit == unit
    assert paths(scene) == ["wedge", "wedge 2"]


def test_files_of_several_units_are_in_the_first(tmp_path, machine):
    tree = bob.Scene(tetrahedron(name="a"), unit="in")
    both = bob.Scene([bob.Scene(tetrahedron(name="b"), unit="mm"), tree])
    assert both.unit == "mm"
    assert both.parts["a"].extent.size[0] == pytest.approx(25.4)
    assert bob.Scene(both, unit="m").parts["a"].extent.size[0] == pytest.approx(0.0254)
    bob.Mesh(CORNERS, SIDES).save(tmp_path / "a.glb")
    with pytest.warns(bob.InputWarning, match=r"machine\.obj: its lengths are taken as m, the unit of the other"):
        mixed = bob.load([tmp_path / "a.glb", tmp_path / "machine.obj"])
    assert mixed.unit == "m"
    with pytest.raises(bob.InputError, match="unit: expected a scene whose unit is known"):
        machine.converted("mm")
    with pytest.raises(bob.InputError, match="unit: expected one of nm, um, mm"):
        bob.Scene(tree, unit="furlong")


def test_scenes_of_one_tree_keep_their_names_apart(machine):
    assert paths(bob.Scene([machine, machine]))[4:] == ["unnamed 2", "housing 2", "housing 2/bolt", "lid 2"]
    assert paths(bob.Scene([tetrahedron(name="a"), tetrahedron(name="a"), tetrahedron()])) == ["a", "a 2", "mesh"]


def test_parts_are_hidden_and_isolated(machine):
    assert paths(machine.hide("housing")) == ["unnamed", "lid"]
    assert paths(machine.hide("bolt", "unnamed")) == ["housing", "lid"]
    bolt = machine.isolate("bolt")
    assert paths(bolt) == ["housing", "housing/bolt"]
    assert bolt.extent.low.tolist() == [3, 0, 0]
    assert len(bolt.instances[0].shape.triangles) == 4
    with pytest.raises(bob.InputError, match="parts: expected to keep at least one, got all"):
        machine.hide(*machine.parts)
    with pytest.raises(bob.InputError, match="parts: expected at least one"):
        machine.isolate()


def test_parts_apart_are_shaded_as_in_the_whole():
    sphere = sdf.sphere(1).mesh(0.1)
    halves = [(("a",), 500), (("b",), len(sphere.triangles) - 500)]
    whole = bob.Scene(bob.Instance(sphere, pieces=halves))
    camera, size = bob.Camera(), (90, 120)
    apart = whole.explode(0)
    assert len(apart.instances) == 2
    difference = np.abs(bob.trace(whole, camera, size=size).gray - bob.trace(apart, camera, size=size).gray)
    assert difference.max() < 1e-3


def test_parts_have_colors(machine):
    red = machine.color("housing/bolt", "#f00")
    assert red.part("bolt").color == (1, 0, 0)
    assert red.part("lid").color == (1, 1, 1)
    assert sorted(paths(red)) == sorted(paths(machine))
    colored = bob.Mesh(CORNERS, SIDES, face_colors=np.eye(4, 3))
    scene = bob.Scene(bob.Instance(colored, material=bob.Material(metallic=1), name="a")).highlight("a")
    assert not scene.instances[0].shape.is_colored
    assert scene.instances[0].material.metallic == 1
    grid = np.array([[(x, y, x * y) for y in (0, 1)] for x in (0, 1)], float)
    for shape in (bob.nurbs_surface(grid, (0, 0, 1, 1), (0, 0, 1, 1), color="#0f0"), bob.happy_tree()):
        assert not bob.Scene(shape).color(0, "blue").instances[0].shape.is_colored


def test_parts_move_apart(machine):
    scene = bob.Scene([tetrahedron(name="a"), tetrahedron((4, 2, 0), name="b")])
    apart = scene.explode(1)
    assert np.allclose(apart.part("b").extent.low - apart.part("a").extent.low, (8, 4, 0))
    along = scene.explode(1, "x")
    assert np.allclose(along.part("b").extent.low - along.part("a").extent.low, (8, 2, 0))
    assert apart.instances[0].shape is scene.instances[0].shape
    assert machine.explode(2, (1, 0, 0)).part("lid").extent.low[0] > machine.part("lid").extent.low[0]


def test_one_line_names_similar_parts(machine):
    with pytest.raises(bob.InputError, match="such as housing/bolt, got 'blot'"):
        machine.part("blot")
    alone = bob.Scene(bob.Instance(bob.happy_tree(), name="tree"))
    with pytest.raises(bob.InputError, match=r"^part: expected the only part, tree, got 'blot'"):
        alone.part("blot")
    twice = bob.Scene([machine, machine])
    with pytest.raises(bob.InputError, match="2 parts are called 'bolt': housing/bolt, housing 2/bolt"):
        twice.part("bolt")
    for which, kind in ((99, bob.InputError), (None, TypeError), (2.5, TypeError), (True, TypeError)):
        with pytest.raises(kind, match=r"^part: expected"):
            machine.part(which)
    with pytest.raises(bob.InputError, match=r"^axis: expected"):
        machine.explode(1, "w")


def test_pieces_are_all_of_a_shape():
    mesh = bob.Mesh(CORNERS, SIDES)
    for pieces in ([(("a",), 3)], [(("a",), 5)], [(("a",), 2), (("b",), None)]):
        with pytest.raises(bob.InputError, match="pieces: expected counts of all 4"):
            bob.Instance(mesh, pieces=pieces)
    for pieces in (3, [3], [("a", 4)], [((), 4)], [(("a",), "4")]):
        with pytest.raises(TypeError, match=r"^pieces: expected"):
            bob.Instance(mesh, pieces=pieces)


def test_a_tree_of_many_parts_is_quick():
    mesh = bob.Mesh(np.tile(CORNERS, (2500, 1)), np.concatenate([np.array(SIDES) + 4 * i for i in range(2500)]))
    pieces = [(("all", f"{i // 50}", f"{i % 50}"), 4) for i in range(2500)]
    scene = bob.Scene(bob.Instance(mesh, pieces=pieces))
    assert len(list(scene.parts.walk())) == 1 + 50 + 2500
    assert len(scene.hide("all/3").instances[0].shape.triangles) == 4 * 2450


def test_scenes_without_names_make_the_same_files(tmp_path):
    bob.save_scene(tetrahedron(name="a"), tmp_path / "a.bob")
    assert b'"parts"' not in (tmp_path / "a.bob").read_bytes()


def test_damaged_trees_are_refused(tmp_path):
    from safetensors.numpy import load

    from bobrossnet.adapters.container import layout, packed, sealed
    from bobrossnet.adapters.json import read_json

    data = packed(tetrahedron(name="a"))
    content = read_json(read_json(data[8 : 8 + int.from_bytes(data[:8], "little")])["__metadata__"]["scene"])
    damaged = [
        {"unit": "parsec", "has_front": False, "pieces": [[]]},
        {"unit": None, "has_front": False, "pieces": []},
        {"unit": None, "pieces": [[]]},
        {"unit": None, "has_front": 3, "pieces": [[]]},
        {"unit": None, "has_front": False, "pieces": [[[["a"], 3]]]},
        {"unit": None, "has_front": False, "pieces": [[["a", 4]]]},
        {"unit": None, "has_front": False, "pieces": [3]},
    ]
    for parts in damaged:
        (tmp_path / "a.bob").write_bytes(sealed(layout(content, load(data), "1", {"parts": parts})))
        with warnings.catch_warnings(), pytest.raises(bob.InputError, match=r"^a\.bob: "):
            bob.load(tmp_path / "a.bob")
