"""Meshes as shapes of the modelling language: the same pictures as the meshes', unions with other shapes, files."""

import pickle
import runpy
import sys

import numpy as np
import pytest
from models import MODELS, needs_models

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.sdf import SDF3, X, Y, box, capsule, slab, sphere, torus
from bobrossnet.sdf import Mesh as Word

TETRAHEDRON = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]


def made_of(shape, step):
    mesh = shape.mesh(step)
    return Word(mesh.vertices, mesh.triangles)


@pytest.fixture(scope="module")
def knot():
    """Return a mesh with a hole, saddles, sharp edges and a thin handle, away from the origin."""
    shape = (torus(1, 0.3) | capsule(-1.5 * X, 1.5 * X, 0.06)) - box(0.5).translate((0, 1, 0))
    return made_of(shape.translate((30, -20, 10)), 0.05)


def rays_at(shape, size=150):
    """Return parallel rays over the whole shape."""
    low, high = shape.bounding_box(np.eye(4))
    reach = np.linalg.norm(high - low) / 2
    towards = np.array((-0.3, 0.8, -0.5)) / np.linalg.norm((-0.3, 0.8, -0.5))
    right = np.cross(towards, (0, 0, 1)) / np.linalg.norm(np.cross(towards, (0, 0, 1)))
    up = np.cross(right, towards)
    steps = np.linspace(-reach, reach, size)
    across, along = (grid.reshape(-1, 1) for grid in np.meshgrid(steps, steps))
    origins = (low + high) / 2 - 3 * reach * towards + across * right + along * up
    return origins, np.broadcast_to(towards, origins.shape).copy(), reach


def assert_seen_alike(shape, mesh):
    origins, directions, reach = rays_at(mesh)
    ours = bob.Scene(shape).closest_hits(origins, directions).distance
    theirs = bob.Scene(mesh).closest_hits(origins, directions).distance
    hit = np.isfinite(theirs)
    assert 0.05 < hit.mean() < 0.95
    # The vertices of a formula are rounded to 1e-7 of its size.
    assert np.count_nonzero(np.isfinite(ours) != hit) <= 2
    hit &= np.isfinite(ours)
    np.testing.assert_allclose(ours[hit], theirs[hit], rtol=0, atol=3e-5 * reach)


# ---- Distances -------------------------------------------------------------------------------------------


def test_distances_of_a_tetrahedron():
    f = Word(*TETRAHEDRON).sdf()
    assert isinstance(f, SDF3)
    wanted = {
        (0.5, 0.5, -1): 1,  # below an edge
        (-3, -4, 0): 5,  # before a corner
        (0.2, 0.3, -0.25): 0.25,  # before a face
        (1, 1, 1): 2 / np.sqrt(3),
        (0.1, 0.2, 0.3): -0.1,
        (0, 0, 0): 0,
    }
    found = f(list(wanted))
    assert found.shape == (len(wanted), 1)
    np.testing.assert_allclose(found[:, 0], list(wanted.values()), atol=1e-7)


@pytest.mark.parametrize("scale", [1e-5, 1, 1e5])
def test_distances_are_in_the_units_of_the_mesh(scale):
    mesh = made_of(sphere(1), 0.2)
    f = Word(mesh.vertices * scale + (0, 0, 7 * scale), mesh.triangles).sdf()
    points = scale * np.array([(0, 0, 7), (0, 3, 7), (0, 0, 0)])
    np.testing.assert_allclose(f(points)[:, 0], scale * np.array([-1, 2, 6]), atol=0.01 * scale)
    np.testing.assert_allclose(f.bounding_box(np.eye(4))[1], scale * np.array([1, 1, 8]), atol=0.05 * scale)


def test_rounding_of_zeros_opens_no_mesh():
    """Zeros of 1e-16, other ones in each triangle, as CAD systems write them."""
    corners = np.array(TETRAHEDRON[0], float)[np.ravel(TETRAHEDRON[1])]
    corners[corners == 0] += np.random.default_rng(0).uniform(-1e-16, 1e-16, (corners == 0).sum())
    shape = Word(corners, np.arange(12).reshape(4, 3)).sdf()
    np.testing.assert_allclose(shape([(0.1, 0.2, 0.3), (-3, -4, 0)]), [[-0.1], [5]], atol=1e-7)


def test_winding_does_not_matter_and_parts_may_overlap():
    low = made_of(sphere(1), 0.1)
    turned = Word(low.vertices, low.triangles[:, ::-1])
    points = np.random.default_rng(0).uniform(-1.5, 1.5, (300, 3))
    np.testing.assert_allclose(turned.sdf()(points), low.sdf()(points), atol=1e-6)

    both = Word(
        np.concatenate([low.vertices, low.vertices + (0.5, 0, 0)]),
        np.concatenate([low.triangles, low.triangles + len(low.vertices)]),
    ).sdf()
    inside = low.sdf() | low.sdf().translate((0.5, 0, 0))
    clear = np.abs(inside(points)) > 1e-5
    np.testing.assert_array_equal((both(points) < 0)[clear], (inside(points) < 0)[clear])


# ---- Pictures --------------------------------------------------------------------------------------------


def test_a_mesh_and_its_formula_look_alike(knot):
    f = knot.sdf()
    assert_seen_alike(f, knot)
    assert f.unresolved_rays < 20  # along edges


def test_other_words_apply_to_meshes(knot):
    f = knot.sdf()
    moved = (f.translate((-30, 20, -10)).scale(2).rotate(0.4, Y)).translate((1, 2, 3))
    c, s = np.cos(0.4), np.sin(0.4)
    turn = np.array([(c, 0, s), (0, 1, 0), (-s, 0, c)])
    theirs = Word((knot.vertices - (30, -20, 10)) * 2 @ turn.T + (1, 2, 3), knot.triangles)
    assert_seen_alike(moved, theirs)

    low = made_of(sphere(1), 0.1)
    points = np.random.default_rng(1).uniform(-2, 2, (500, 3))
    d, b = low.sdf()(points), box(1.2)(points)
    for shape, wanted in (
        (low.sdf() | box(1.2), np.minimum(d, b)),
        (low.sdf() & box(1.2), np.maximum(d, b)),
        (box(1.2) - low.sdf(), np.maximum(b, -d)),
        (low.sdf().dilate(0.2), d - 0.2),
        (low.sdf().erode(0.2), d + 0.2),
        (low.sdf().shell(0.2), np.abs(d) - 0.1),
    ):
        np.testing.assert_allclose(shape(points), wanted, atol=1e-12)


@pytest.mark.parametrize("kind", ["cut", "shell", "smooth", "repeated"])
def test_the_first_root_along_each_ray_is_seen(knot, kind):
    f = knot.sdf().translate((-30, 20, -10))
    shape = {
        "cut": lambda: f - sphere(0.4).translate((1, 0, 0.2)) - sphere(0.3).translate((-1, 0, 0.2)),
        "shell": lambda: f.shell(0.02) & slab(z1=0.05),
        "smooth": lambda: f.union(sphere(0.5), k=0.3) - slab(z0=0.1).k(0.05),
        "repeated": lambda: f.scale(0.4).repeat(1.5, (1, 1, 0)),
    }[kind]()
    origins, directions, reach = rays_at(shape, 15)
    hits = bob.Scene(shape).closest_hits(origins, directions).distance
    for origin, direction, t in zip(origins, directions, hits, strict=True):
        along = np.linspace(0, min(t, 6 * reach) - 1e-5 * reach, 1500)
        assert (shape(origin + along[:, None] * direction) > -1e-6 * reach).all()
    hit = np.isfinite(hits)
    assert hit.mean() > 0.05
    after = origins[hit] + (hits[hit, None] + 1e-5 * reach) * directions[hit]
    assert (shape(after)[:, 0] < 1e-5 * reach).all()
    before = origins[hit] + (hits[hit, None] - 1e-5 * reach) * directions[hit]
    assert (shape(before)[:, 0] > -1e-5 * reach).all()


def test_meshes_of_meshes(knot):
    made = knot.sdf().dilate(0.05).mesh(0.05)
    np.testing.assert_allclose(knot.sdf()(made.vertices), 0.05, atol=0.025)  # half a step


@needs_models
@pytest.mark.parametrize(
    "name", ["mechanical/fandisk.ply", "mechanical/rod_assembly.ply", "animals/spot_cow.ply", "scans/fertility.ply"]
)
def test_real_meshes_and_their_formulas_look_alike(name):
    mesh = Word.from_file(MODELS / name)
    assert_seen_alike(mesh.sdf(), mesh)


# ---- Programs for fogleman/sdf ---------------------------------------------------------------------------


def test_programs_with_meshes_run(tmp_path, monkeypatch):
    sphere(10).mesh(1).save(tmp_path / "ball.stl")
    (tmp_path / "program.py").write_text(
        "from bobrossnet.sdf import *\n"
        "import sys\n"
        "f = Mesh.from_file(sys.argv[1]).sdf(voxel_size=0.25, half_width=1)\n"
        "f = f.erode(0.25).shell(0.5) & slab(y0=0)\n"
        "f.save('out.stl', step=0.25)\n"
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["program.py", "ball.stl"])
    runpy.run_path("program.py", run_name="__main__")
    hollow = bob.load_mesh("out.stl")
    distances = np.linalg.norm(hollow.vertices, axis=1)
    rim = np.abs(hollow.vertices[:, 1]) < 1e-3
    assert rim.any()
    assert hollow.vertices[:, 1].min() > -1e-3
    assert (distances > 9.3).all()
    assert ((np.abs(distances - 10) < 0.1) | (np.abs(distances - 9.5) < 0.1))[~rim].all()


# ---- Errors ----------------------------------------------------------------------------------------------


def test_meshes_that_have_no_inside_are_refused():
    corners, triangles = TETRAHEDRON
    for changed, what in (
        (triangles[1:], "expected a closed mesh, got one with 3 edges where it is open"),
        (
            [*triangles[1:], (0, 1, 2)],
            "expected triangles that all wind the same way, got 3 edges between two that don't",
        ),
        ([(0, 0, 1)], "expected a closed mesh, got no triangles"),
    ):
        with pytest.raises(bob.InputError) as error:
            Word(corners, changed).sdf()
        assert str(error.value) == f"mesh: {what}"
    with pytest.raises(bob.InputError, match=r"^voxel_size: expected a number above 0, got 0"):
        Word(corners, triangles).sdf(0)
    with pytest.raises(bob.InputError, match=r"^none.stl: "):
        Word.from_file("none.stl")


def test_seams_of_equal_vertices_are_closed():
    corners, triangles = (np.array(each) for each in TETRAHEDRON)
    seamed = Word(corners[triangles].reshape(-1, 3), np.arange(12).reshape(-1, 3))
    assert seamed.sdf().expression == Word(corners, triangles).sdf().expression


# ---- Files -----------------------------------------------------------------------------------------------


def test_formulas_with_meshes_are_equal_where_meshes_are():
    mesh = made_of(sphere(1), 0.2)
    f, same, other = mesh.sdf(), made_of(sphere(1), 0.2).sdf(), made_of(sphere(1), 0.25).sdf()
    assert f.expression == same.expression
    assert hash(f.expression) == hash(same.expression)
    assert f.expression != other.expression
    assert f.digest == same.digest != other.digest
    again = pickle.loads(pickle.dumps((f - box(1)).expression))
    assert again == (f - box(1)).expression


def test_scenes_with_meshes_in_formulas_are_written(tmp_path):
    ball = made_of(sphere(1), 0.25)
    colored = ball.sdf().color("#c33") - sphere(0.4).translate(X).color("#39c")
    scene = bob.Scene([colored, bob.Instance(ball.sdf() | box(1).translate(X)).translate(4 * X)])
    bob.save_scene(scene, tmp_path / "a.bob")
    bob.save_scene(bob.load(tmp_path / "a.bob"), tmp_path / "b.bob")
    assert (tmp_path / "a.bob").read_bytes() == (tmp_path / "b.bob").read_bytes()
    again = bob.load(tmp_path / "a.bob")
    assert bob.trace(again, size=(60, 80)) == bob.trace(scene, size=(60, 80))
    assert b'"version":"3"' in (tmp_path / "a.bob").read_bytes()[:400]


@pytest.mark.parametrize(
    ("changed", "what"),
    [
        (
            {"mesh_sizes": np.array([[4, 5]], np.uint32)},
            "formula: expected as many vertices and triangles as the meshes",
        ),
        ({"mesh_sizes": np.zeros((0, 2), np.uint32)}, "formula: expected as many vertices and triangles as the meshes"),
        ({"mesh_vertices": np.full((4, 3), np.nan, np.float32)}, "formula: expected vertices in -1..1"),
        ({"mesh_triangles": np.full((4, 3), 4, np.uint32)}, "formula: expected corners among the vertices"),
        ({"mesh_triangles": np.tile(np.uint32([0, 1, 2]), (4, 1))}, "formula: expected triangles that all wind"),
        ({"values": None}, "formula: node 3: expected the place of a mesh"),
        ({"mesh_sizes": None}, "formula: expected the sizes, vertices and triangles of meshes together"),
    ],
)
def test_arrays_that_hold_no_mesh_are_refused(changed, what):
    graph = _core.Graph()
    f = Word(*TETRAHEDRON).sdf().expression
    plain = graph.expression(graph.substitute(f, graph.x(), graph.y(), graph.z()))
    assert plain == f
    tensors = bob.Implicit(f).tensors()
    place = list(tensors["ops"]).index(30)
    for name, value in changed.items():
        if name == "values":
            tensors["values"] = np.where(np.arange(len(f)) == place, 1, tensors["values"])
            what = what.replace("3", str(place))
        elif value is None:
            del tensors[name]
        else:
            tensors[name] = value
    with pytest.raises(bob.InputError) as error:
        bob.Implicit.from_tensors(tensors)
    assert str(error.value).startswith(what)
