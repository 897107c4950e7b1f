"""3MF as its specifications have it: packages, extensions, colours of corners and beam lattices."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest
from loaded import area_of, told

import bobrossnet as bob

CASES = Path(__file__).parent / "cases"
CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
MICROSOFT = "http://schemas.microsoft.com/3dmanufacturing/"
PREFIXES = {
    "m": MICROSOFT + "material/2015/02",
    "p": MICROSOFT + "production/2015/06",
    "s": MICROSOFT + "slice/2015/07",
    "b": MICROSOFT + "beamlattice/2017/02",
    "b2": MICROSOFT + "beamlattice/balls/2020/07",
    "d": MICROSOFT + "displacement/2022/07",
    "bo": "http://schemas.3mf.io/3dmanufacturing/booleanoperations/2023/07",
}
VERTICES = "<vertex x='0' y='0' z='0'/><vertex x='1' y='0' z='0'/><vertex x='0' y='1' z='0'/>"
MESH = f"<mesh><vertices>{VERTICES}</vertices><triangles><triangle v1='0' v2='1' v3='2'/></triangles></mesh>"
RELATIONS = (
    "<Relationships xmlns='http://schemas.openxmlformats.org/package/2006/relationships'><Relationship "
    "Target='{}' Id='r0' Type='http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel'/></Relationships>"
)


def model(resources: str, build: str = "<item objectid='1'/>", attributes: str = "") -> str:
    names = "".join(f" xmlns:{prefix}='{namespace}'" for prefix, namespace in PREFIXES.items())
    return f"<model xmlns='{CORE}'{names} {attributes}><resources>{resources}</resources><build>{build}</build></model>"


def package(folder: Path, parts: dict[str, str]) -> Path:
    with zipfile.ZipFile(folder / "a.3mf", "w") as archive:
        for name, text in parts.items():
            archive.writestr(name, text)
    return folder / "a.3mf"


@pytest.mark.parametrize("name", ["3mf-slices/box", "3mf-build-of-parts/box", "3mf-names/space"])
def test_a_cube(name: str) -> None:
    scene, warned = told(CASES / f"{name}.3mf")
    (instance,) = scene.instances
    assert isinstance(instance.shape, bob.Mesh)
    assert warned == []
    assert area_of(instance.shape) == pytest.approx(6)
    assert np.ptp(instance.shape.vertices, axis=0).tolist() == [1, 1, 1]


def test_unknown_extensions_are_refused() -> None:
    with pytest.raises(bob.InputError, match=r"^box.3mf: requiredextensions: .* got http://example.com/unknown$"):
        bob.load(CASES / "3mf-required/box.3mf")


def test_prefixes_of_extensions_are_those_declared(tmp_path: Path) -> None:
    """A prefix is the file's own choice; one that is not declared is unknown."""
    parts = {"3D/3dmodel.model": model(f"<object id='1'>{MESH}</object>", attributes="requiredextensions='m z'")}
    with pytest.raises(bob.InputError, match=r"got z$"):
        bob.load(package(tmp_path, parts))
    declared = {name: text.replace(" xmlns:m=", " xmlns:z='urn:q' xmlns:m=") for name, text in parts.items()}
    with pytest.raises(bob.InputError, match=r"got urn:q$"):
        bob.load(package(tmp_path, declared))
    material = {name: text.replace("'m z'", "'z'").replace("xmlns:m=", "xmlns:z=") for name, text in parts.items()}
    assert bob.load(package(tmp_path, material)).counts()["triangle"] == 1


def test_corners_blend() -> None:
    scene, warned = told(CASES / "3mf-colors-of-corners/box.3mf")
    (instance,) = scene.instances
    assert isinstance(instance.shape, bob.Mesh)
    assert warned == []
    assert area_of(instance.shape) == pytest.approx(6)
    assert instance.shape.colors is not None
    assert instance.shape.colors[instance.shape.triangles].tolist() == [np.eye(3).tolist()] * 12


def test_base_materials_do_not_blend(tmp_path: Path) -> None:
    colors = "<base name='a' displaycolor='#FF0000'/><base name='b' displaycolor='#0000FF'/>"
    mesh = MESH.replace("v3='2'", "v3='2' p1='1' p2='0'")
    resources = f"<basematerials id='5'>{colors}</basematerials><object id='1' pid='5' pindex='0'>{mesh}</object>"
    (instance,) = bob.load(package(tmp_path, {"3D/3dmodel.model": model(resources)})).instances
    assert isinstance(instance.shape, bob.Mesh)
    assert instance.shape.face_colors is not None
    assert instance.shape.face_colors.tolist() == [[0, 0, 1]]


def test_composites_are_mixtures(tmp_path: Path) -> None:
    """Colours mix in linear light; a composite whose shares sum to zero is white."""
    mesh = MESH.replace("v3='2'", "v3='2' pid='6' p1='0' p2='1' p3='2'")
    resources = (
        "<basematerials id='5'><base name='a' displaycolor='#FF0000'/><base name='b' displaycolor='#0000FF'/>"
        "</basematerials><m:compositematerials id='6' matid='5' matindices='1 0'>"
        "<m:composite values='0.25 0.75'/><m:composite values='2 2'/><m:composite values='0 0'/></m:compositematerials>"
        f"<object id='1'>{mesh}</object>"
    )
    scene, warned = told(package(tmp_path, {"3D/3dmodel.model": model(resources)}))
    (instance,) = scene.instances
    assert isinstance(instance.shape, bob.Mesh)
    assert warned == []
    assert instance.shape.colors is not None
    assert instance.shape.colors[instance.shape.triangles[0]].tolist() == [[0.75, 0, 0.25], [0.5, 0, 0.5], [1, 1, 1]]


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("3D/Objects/my%20part.model", "/3D/Objects/my part.model"),
        ("3D/Objects/my part.model", "/3D/Objects/my%20part.model"),
        ("3D/W%C3%BCrfel.model", "/3D/Würfel.model"),
        ("3D/Würfel.model", "/3D/w%c3%bcrfel.MODEL"),
        ("3d/100%25.model", "/3D/100%25.model"),
        ("3D\\Objects\\a.model", "/3D/Objects/./b/../a.model"),
    ],
)
def test_part_names(name: str, path: str, tmp_path: Path) -> None:
    """In any case, with and without percent-encoding; the parts' own builds do not count."""
    root = f"<object id='2'><components><component p:path='{path}' objectid='1'/></components></object>"
    parts = {
        "_rels/.rels": RELATIONS.format("/3D/Root%20Model.model"),
        "3D/another.model": model(f"<object id='7'>{MESH}</object>", "<item objectid='7'/>"),
        name: model(f"<object id='1'>{MESH}</object>", "<item objectid='1' transform='1 0 0 0 1 0 0 0 1 9 9 9'/>"),
        "3D/root model.model": model(root, "<item objectid='2'/>"),
    }
    (instance,) = bob.load(package(tmp_path, parts)).instances
    assert isinstance(instance.shape, bob.Mesh)
    assert sorted(instance.shape.vertices.tolist()) == [[0, 0, 0], [0, 1, 0], [1, 0, 0]]


def test_a_missing_model_is_named(tmp_path: Path) -> None:
    root = "<object id='2'><components><component p:path='/3D/gone.model' objectid='1'/></components></object>"
    file = package(tmp_path, {"3D/3dmodel.model": model(root, "<item objectid='2'/>")})
    with pytest.raises(bob.InputError, match=r"expected an object with id 1 in '/3D/gone.model', found none$"):
        bob.load(file)


def test_what_is_not_shown_is_one_warning(tmp_path: Path) -> None:
    resources = (
        "<m:translucentdisplayproperties id='8'/><m:multiproperties id='9' pids='5 8'/>"
        f"<object id='1' s:slicestackid='3' s:meshresolution='lowres'>{MESH}</object>"
        f"<object id='2'><bo:booleanshape objectid='1' operation='difference'/></object>"
    )
    scene, warned = told(package(tmp_path, {"3D/3dmodel.model": model(resources)}))
    assert scene.counts()["triangle"] == 1
    names = "display properties (1), multiproperties (1), slices of coarse meshes (1), Boolean operations (1)"
    assert warned == [f"a.3mf: left out {names}"]
    only = {"3D/3dmodel.model": model(resources, "<item objectid='2'/>")}
    with pytest.raises(bob.InputError, match=r"^a\.3mf: expected triangles, got none; left out display properties"):
        bob.load(package(tmp_path, only))


def test_meshes_with_displacements_are_shown_without(tmp_path: Path) -> None:
    mesh = MESH.replace("mesh>", "displacementmesh>").replace("<", "<d:").replace("<d:/", "</d:")
    parts = {"3D/3dmodel.model": model(f"<object id='1'>{mesh}</object>", attributes="requiredextensions='d'")}
    scene, warned = told(package(tmp_path, parts))
    assert scene.counts()["triangle"] == 1
    assert warned == ["a.3mf: left out displacements (1)"]


# ---- Beam lattices ---------------------------------------------------------------------------------------


def test_a_floor_and_beams() -> None:
    """Bars of radius 0.08 along all edges of a unit cube, whose outline is the ball around its corners."""
    scene, warned = told(CASES / "3mf-beams/floor-and-beams.3mf")
    floor, beams = scene.instances
    assert warned == []
    assert isinstance(floor.shape, bob.Mesh)
    assert isinstance(beams.shape, bob.Tube)
    assert area_of(floor.shape) == pytest.approx(1)
    assert len(beams.shape.control_points) == 24
    assert set(beams.shape.radii.tolist()) == {0.08}
    mesh = beams.shape.mesh()
    assert np.allclose([mesh.vertices.min(0), mesh.vertices.max(0)], [[-0.08] * 3, [1.08] * 3], atol=1e-3)
    assert np.allclose(scene.boxes[1], [[-0.08] * 3, [1.08] * 3], atol=1e-5)


def lattice(attributes: str = "", beams: str = "", more: str = "") -> str:
    """A mesh without triangles, whose three points are ends of beams."""
    return (
        f"<mesh><vertices>{VERTICES}</vertices><triangles/><b:beamlattice radius='0.1' minlength='0.001' {attributes}>"
        f"<b:beams>{beams}</b:beams>{more}</b:beamlattice></mesh>"
    )


def test_radii_colors_and_places_of_beams(tmp_path: Path) -> None:
    beams = "<b:beam v1='0' v2='1'/><b:beam v1='1' v2='2' r1='0.2'/><b:beam v1='2' v2='0' r1='.1' r2='.3' p1='1'/>"
    resources = (
        "<m:colorgroup id='5'><m:color color='#FF0000'/><m:color color='#0000FF'/></m:colorgroup>"
        f"<object id='1' pid='5' pindex='0'>{lattice(beams=beams)}</object>"
    )
    parts = {"3D/3dmodel.model": model(resources, "<item objectid='1' transform='2 0 0 0 2 0 0 0 2 7 0 0'/>")}
    scene, warned = told(package(tmp_path, parts))
    red, blue = scene.instances
    assert warned == []
    assert (red.material.color, blue.material.color) == ((1, 0, 0), (0, 0, 1))
    assert isinstance(red.shape, bob.Tube)
    assert isinstance(blue.shape, bob.Tube)
    assert red.shape.radii.tolist() == [0.1, 0.1, 0.2, 0.2]
    assert blue.shape.radii.tolist() == [0.1, 0.3]
    assert red.transform.tolist() == [[2, 0, 0, 7], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]]


@pytest.mark.parametrize(
    ("attributes", "radii"),
    [
        ("", [0.1, 0.1]),
        ("b2:ballmode='none' b2:ballradius='.4'", [0.1, 0.1]),
        ("b2:ballmode='mixed' b2:ballradius='.4'", [0.1, 0.1, 0.4, 0.4]),
        ("ballmode='all' ballradius='.3'", [0.1, 0.1, 0.3, 0.3, 0.3, 0.3]),
    ],
)
def test_balls(attributes: str, radii: list[float], tmp_path: Path) -> None:
    mesh = lattice(attributes, "<b:beam v1='0' v2='1'/>", "<b2:balls><b2:ball vindex='1'/></b2:balls>")
    text = model(f"<object id='1'>{mesh}</object>")
    scene, warned = told(package(tmp_path, {"3D/3dmodel.model": text}))
    (instance,) = scene.instances
    assert warned == []
    assert isinstance(instance.shape, bob.Tube)
    assert instance.shape.radii.tolist() == radii


def test_beams_that_are_not_shown(tmp_path: Path) -> None:
    beams = (
        "<b:beam v1='0' v2='1' cap1='butt'/><b:beam v1='0' v2='3'/><b:beam v1='0' v2='-1'/><b:beam v1='1' v2='1'/>"
        "<b:beam v1='0' v2='2' r1='0'/>"
    )
    attributes = "clippingmode='inside' clippingmesh='3'"
    parts = {"3D/3dmodel.model": model(f"<object id='1'>{lattice(attributes, beams)}</object>")}
    scene, warned = told(package(tmp_path, parts))
    assert scene.counts() == {"shape": 1, "tube": 1}
    missing = "beams without a vertex or a radius (3), flat ends of beams (1), clippings of beam lattices (1)"
    assert warned == [f"a.3mf: left out {missing}"]
    with pytest.raises(bob.InputError, match=r"^a\.3mf: expected triangles, .* formulas, which bobrossnet\.load"):
        bob.load_mesh(tmp_path / "a.3mf")


def test_beams_trace_as_single_tubes() -> None:
    from bobrossnet.shapes.tube import segments

    random = np.random.default_rng(1)
    ends, radii = random.uniform(-1, 1, (30, 2, 3)), random.uniform(0.03, 0.1, (30, 2))
    ends[::5, 1], radii[::5, 1] = ends[::5, 0], radii[::5, 0]  # balls
    tube = segments(ends, radii)
    single = [bob.polyline([a, b + (0, 0, 1e-9)], r) for (a, b), r in zip(ends, radii, strict=True)]
    one, all_of_them = (bob.trace(scene, size=(100, 100)) for scene in (tube, single))
    assert np.array_equal(one.alpha, all_of_them.alpha)
    assert np.allclose(one.gray, all_of_them.gray, atol=1e-3)
    mesh = tube.mesh()
    edges = np.sort(mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert set(np.unique(edges, axis=0, return_counts=True)[1].tolist()) == {2}
    parts = [part.mesh(step=2 / 64) for part in single]
    a, b = area_of(tube.mesh(step=2 / 64)), sum(map(area_of, parts))
    assert a == pytest.approx(b, rel=1e-3)
