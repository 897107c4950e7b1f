"""Shapes as meshes: closed, with the volume and genus of their closed forms, within the step's tolerance; files."""

import functools
import warnings

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from nurbs_shapes import CIRCLE, CIRCLE_KNOTS, CIRCLE_WEIGHTS, cylinder, sphere, torus
from thread_counts import with_threads

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.command_line import cli
from bobrossnet.sdf import d2, d3, write_binary_stl
from bobrossnet.sdf.d3 import X, Y, Z
from bobrossnet.shapes import mesh as mesh_module
from bobrossnet.shapes import shape as shape_module
from bobrossnet.shapes import tessellation, tube


def as_trimesh(mesh):
    return trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)


def check_closed(mesh, euler=None):
    """Check that each edge occurs once in either direction, no triangle is degenerate, and no vertex is unused."""
    t, count = mesh.triangles.astype(np.int64), len(mesh.vertices)
    start, end = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]).T
    forward, back = np.sort(start * count + end), np.sort(end * count + start)
    assert (np.diff(forward) > 0).all()
    assert np.array_equal(forward, back)
    assert (start != end).all()
    assert np.bincount(t.ravel(), minlength=count).all()
    if euler is not None:
        assert count - len(forward) // 2 + len(t) == euler
    return as_trimesh(mesh)


def csg():
    c = d3.cylinder(0.5)
    return (d3.sphere(1) & d3.box(1.5)) - (c.orient(X) | c.orient(Y) | c.orient(Z))


PI = np.pi
SOLIDS = {
    "sphere": (d3.sphere(1), 4 / 3 * PI, 2, 1e-4),
    "box": (d3.box((1, 2, 3)), 6, 2, 1e-6),
    "turned box": (d3.box(1).rotate(0.5, (1, 2, 3)), 1, 2, 2e-4),
    "torus": (d3.torus(1, 0.25), 2 * PI**2 / 16, 0, 5e-4),
    "octahedron": (d3.octahedron(1), 4 / 3, 2, 2e-4),
    "cylinder": (d3.capped_cylinder(-Z, Z, 0.5), PI / 2, 2, 5e-4),
    "two balls": (d3.sphere(1) | d3.sphere(1).translate(3 * X), 8 / 3 * PI, 4, 5e-4),
    "hollow ball": (d3.sphere(1).shell(0.1), 4 / 3 * PI * (1.05**3 - 0.95**3), 4, 5e-4),
    "far and small": (d3.sphere(1e-3).translate((50, 60, 70)), 4 / 3 * PI * 1e-9, 2, 1e-4),
    "cut by bounds": (bob.implicit(lambda x, y, z: z, ((-1, -1, -1), (1, 1, 1))), 4, 2, 1e-5),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_formulas_become_closed_meshes_of_their_volume(name):
    shape, volume, euler, tolerance = SOLIDS[name]
    mesh = check_closed(shape.mesh(), euler)
    assert abs(mesh.volume / volume - 1) < tolerance


@pytest.mark.parametrize(
    ("shape", "step"), [(csg(), 0.02), (csg(), 0.1), (d3.octahedron(1), 0.1), (d3.torus(1, 0.3), 0.1)]
)
def test_meshes_are_nearer_than_the_step_both_ways(shape, step):
    mesh = shape.mesh(step)
    surface = as_trimesh(mesh)
    checked = np.concatenate([mesh.vertices, surface.triangles_center])
    # The formulas' values are lower bounds of distances, so points are also projected onto the surface by rays.
    scene = bob.Scene(shape)
    direction = np.random.default_rng(1).normal(size=(3000, 3))
    hits = scene.closest_hits(-3 * direction / np.linalg.norm(direction, axis=1, keepdims=True), direction)
    hit = np.isfinite(hits.distance)
    unit = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    on_surface = (-3 * unit + np.where(hit, hits.distance, 0)[:, None] * unit)[hit]
    meshed = bob.Scene(mesh).closest_hits(-3 * unit[hit], unit[hit])
    assert np.abs(shape(checked)).max() < 0.35 * step
    near = np.abs(meshed.distance - hits.distance[hit]) < step
    assert np.isfinite(meshed.distance).mean() > 0.98
    assert near.mean() > 0.95  # near silhouettes rays miss one surface and hit the other far behind
    assert np.abs(shape(on_surface)).max() < 1e-5


def test_sharp_edges_and_corners_stay_sharp():
    mesh = d3.box((1, 2, 3)).mesh(0.07)
    for corner in np.array(np.meshgrid(*([-s, s] for s in (0.5, 1, 1.5)))).reshape(3, -1).T:
        assert np.linalg.norm(mesh.vertices - corner, axis=1).min() < 1e-5
    normals = as_trimesh(mesh).face_normals
    assert np.abs(normals).max(axis=1).min() > 0.9999


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32), cells=st.integers(3, 24))
def test_whatever_the_formula_edges_have_two_triangles(seed, cells):
    """Waves much shorter than the step, so that signs are nearly random.

    All kinds of cells occur, also faces with two sheets on both sides.
    """
    rng = np.random.default_rng(seed)
    waves = [(rng.normal(size=3) * rng.uniform(1, 40), rng.uniform(0, 6)) for _ in range(4)]

    def f(x, y, z):
        return sum(np.sin(k[0] * x + k[1] * y + k[2] * z + phase) for k, phase in waves) + rng.uniform(-1, 1)

    shape = bob.implicit(f, ((-1, -1, -1), (1, 1, 1)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bob.InputWarning)  # for irregular formulas
        check_closed(shape.mesh(2 / cells))


def test_threads_make_no_difference():
    one, several = with_threads((1, bob.thread_count()), lambda: csg().mesh(0.05))
    assert np.array_equal(one.vertices, several.vertices)
    assert np.array_equal(one.triangles, several.triangles)


def test_bands_of_layers_are_joined():
    """Enough rows for the layers to be contoured in several bands."""
    check_closed(csg().mesh(1.5 / 200), -8)
    check_closed(d3.box((3, 3, 0.05)).rotate(0.4, X).mesh(3 / 250), 2)


# ---- Tubes and breps -----------------------------------------------------------------------------------------------


def test_edges_beside_jumps_stay_sharp():
    """Below its base a pyramid's formula is the distance from the rim, and jumps at the base."""
    mesh = check_closed(d3.pyramid(1).mesh(0.02), 2)
    assert mesh.area == pytest.approx(1 + 5**0.5, rel=3e-4)
    assert mesh.volume == pytest.approx(1 / 3, rel=1e-4)
    ball = lambda x, y, z: np.sqrt(x * x + y * y + z * z) - 0.8  # noqa: E731
    half = bob.implicit(lambda x, y, z: np.where(x + y / 2 < 0, ball(x, y, z), 1), ((-1, -1, -1), (1, 1, 1)))
    assert check_closed(half.mesh(0.05), 2).area == pytest.approx(3 * PI * 0.64, rel=3e-3)


def test_tubes_become_closed_meshes_of_their_volume():
    capsule = bob.polyline([(0, 0, 0), (0, 0, 2)], 0.5)
    volume = PI * 0.25 * 2 + 4 / 3 * PI * 0.125
    assert abs(check_closed(capsule.mesh(), 2).volume / volume - 1) < 1e-3
    ring = bob.nurbs_curve(np.c_[CIRCLE, np.zeros(9)], CIRCLE_KNOTS, CIRCLE_WEIGHTS, radius=0.25)
    volume = 2 * PI**2 * 0.25**2 + 4 / 3 * PI * 0.25**3  # the round ends lie inside the ring, and count twice
    assert abs(check_closed(ring.mesh(), 2).volume / volume - 1) < 2e-3


@pytest.mark.parametrize(
    "shape",
    [
        bob.polyline([(0, 0, 0), (2, 0, 0), (2, 2, 0)], [0.2, 0.1, 0.3]),
        bob.polyline([(0, 0, 0), (2, 0, 0), (0, 0, 0)], 0.2),  # back along itself
        bob.polyline([(0, 0, 0), (0.2, 0, 0), (2, 0, 0)], [0.5, 0.1, 0.1]),  # a ball within another
        bob.polyline([(0, 0, 0), (0, 0, 0), (1, 1, 1)], 0.01),  # a repeated point, and thinner than the step
        bob.nurbs_curve(
            [(0, 0, 0), (0, 0, 3), (0, 3, 3), (0, 3, 0)], [0, 0, 0, 0, 1, 1, 1, 1], radius=[0.1, 0.3, 0.1, 0.2]
        ),
    ],
)
def test_tubes_lie_on_their_surface_or_within(shape):
    mesh = shape.mesh()
    assert check_closed(mesh, 2).volume > 0
    # From far away towards each vertex: rays hit the surface there or earlier.
    scene = bob.Scene(shape)
    way = mesh.vertices - scene.center
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    hits = scene.closest_hits(mesh.vertices + 3 * scene.radius * way, -way)
    beyond = hits.distance - 3 * scene.radius
    assert (beyond < 1e-3 * scene.radius).mean() > 0.95  # the others graze it, and may miss or hit a surface behind


@pytest.mark.parametrize(
    ("shape", "volume", "euler"),
    [
        (sphere(), 4 / 3 * PI, 2),
        (torus(), 2 * PI**2 * 0.7 * 0.25**2, 0),
        (cylinder(), PI * 0.49, 2),
    ],
    ids=["sphere", "torus", "cylinder"],
)
@pytest.mark.parametrize("cells", [10, 37, 128])
def test_breps_of_closed_faces_are_closed(shape, volume, euler, cells):
    step = 2 / cells
    mesh = shape.mesh(step)
    checked = check_closed(mesh, euler)
    assert abs(checked.volume / volume - 1) < 8 / cells**1.5
    hits = bob.Scene(shape).closest_hits(checked.triangles_center + 0.1 * checked.face_normals, -checked.face_normals)
    far = np.abs(hits.distance - 0.1)
    assert np.quantile(far, 0.99) < 0.1 * step


def test_breps_keep_their_trims():
    square = np.array([[(x, y, 0) for y in (0.0, 1.0)] for x in (0.0, 1.0)])
    knots = [0, 0, 1, 1]
    outline, hole = [(0, 0), (1, 0), (1, 1), (0, 1)], [(0.6, 0.4), (0.9, 0.4), (0.9, 0.6), (0.6, 0.6)]
    circle = bob.TrimCurve(0.2 * CIRCLE + (0.3, 0.5), CIRCLE_KNOTS, CIRCLE_WEIGHTS)
    mesh = as_trimesh(bob.nurbs_surface(square, knots, knots, trims=[outline, hole, circle]).mesh(0.02))
    assert abs(mesh.area - (1 - 0.06 - PI * 0.04)) < 5e-4
    assert mesh.euler_number == -1
    assert np.linalg.norm(mesh.vertices[:, :2] - (0.3, 0.5), axis=1).min() > 0.2 - 1e-6
    for corner in [*outline, *hole]:
        assert np.linalg.norm(mesh.vertices[:, :2] - corner, axis=1).min() < 1e-9
    assert np.allclose(mesh.face_normals, (0, 0, 1))


def test_faces_of_a_cube_are_welded_and_turned_outwards():
    def side(axis, at, flip):
        u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
        corner = at * np.eye(3)[axis]
        grid = np.array([[corner + i * u + j * v for j in (0, 1)] for i in (0, 1)])
        return bob.Face(grid[::-1] if flip else grid, [0, 0, 1, 1], [0, 0, 2, 2])

    faces = [side(axis, at, flip) for flip, (axis, at) in enumerate((a, b) for a in range(3) for b in (0, 1))]
    mesh = check_closed(bob.Brep(faces).mesh(0.03), 2)
    assert mesh.volume == pytest.approx(1)
    open_box = as_trimesh(bob.Brep(faces[:5]).mesh(0.03))
    assert not open_box.is_watertight
    assert open_box.is_winding_consistent
    assert open_box.area == pytest.approx(5)


def test_a_face_whose_trims_cross_is_left_out():
    square = np.array([[(x, y, 0) for y in (0.0, 1.0)] for x in (0.0, 1.0)])
    good = bob.Face(square, [0, 0, 1, 1], [0, 0, 1, 1])
    bow = bob.Face(
        square + (0, 0, 1), [0, 0, 1, 1], [0, 0, 1, 1], trims=[[(0.1, 0.1), (0.9, 0.77), (0.9, 0.1), (0.13, 0.9)]]
    )
    with pytest.warns(bob.InputWarning, match="face 1: two edges cross in its trims: left out of the mesh"):
        mesh = bob.Brep([good, bow]).mesh(0.1)
    assert mesh.vertices[:, 2].max() == 0
    with (
        pytest.warns(bob.InputWarning),
        pytest.raises(bob.InputError, match="expected a face that can be triangulated"),
    ):
        bob.Brep([bow]).mesh(0.1)


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32), scale=st.sampled_from([60, 1000, 2**25]))
def test_triangulations_cover_what_their_edges_surround(seed, scale):
    rng = np.random.default_rng(seed)
    count = rng.integers(4, 40)
    angle = 2 * PI * (np.arange(count) + rng.uniform(size=count)) / count  # all around, otherwise edges may cross
    ring = 0.5 + np.c_[np.cos(angle), np.sin(angle)] * rng.uniform(0.2, 0.45, (len(angle), 1))
    whole = np.rint(np.concatenate([ring, rng.uniform(size=(rng.integers(0, 200), 2))]) * scale).astype(np.int32)
    points, number = np.unique(whole, axis=0, return_inverse=True)
    loop = number.reshape(-1)[: len(ring)].astype(np.int32)
    x, y = points[loop].astype(float).T
    area = abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2)
    try:
        triangles = _core.triangulate(points, np.stack([loop, np.roll(loop, -1)], axis=1))
    except ValueError:
        assert scale < 2**25  # on a coarse grid, edges may cross
        return
    a, b, c = (points[triangles[:, i]].astype(float) for i in range(3))
    doubled = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert (doubled > 0).all()
    if len(np.unique(loop)) == len(loop):
        assert doubled.sum() / 2 == pytest.approx(area, rel=1e-12)


def test_triangulations_refuse_what_they_can_not_take():
    square = np.array([(0, 0), (9, 0), (9, 9), (0, 9)], np.int32)
    cases = [
        (np.append(square, [[0, 0]], axis=0), [(0, 1)], "there twice"),
        (square * 2**23, [(0, 1)], "out of range"),
        (square, [(0, 4)], "out of range"),
        (square, [(0, 2), (1, 3)], "cross"),
    ]
    for points, edges, message in cases:
        with pytest.raises(ValueError, match=message):
            _core.triangulate(points.astype(np.int32), np.array(edges, np.int32))


# ---- Files, scenes, the language and the command line --------------------------------------------------------------


@pytest.mark.parametrize("ending", ["stl", "ply", "obj", "glb", "STL"])
def test_files_hold_the_mesh(tmp_path, ending):
    mesh = bob.polyline([(1, 2, 3), (4, 4, 8)], [0.5, 0.2]).mesh(0.2)
    mesh.save(tmp_path / f"a.{ending}")
    read = bob.load_mesh(tmp_path / f"a.{ending}")
    assert len(read.triangles) == len(mesh.triangles)
    corners = [m.vertices[m.triangles] for m in (mesh, read)]
    assert np.allclose(*corners, atol=1e-5)


@pytest.mark.parametrize("ending", ["ply", "obj", "glb"])
def test_files_hold_normals(tmp_path, ending):
    ball = d3.sphere(1).mesh(0.2)
    ball = bob.Mesh(ball.vertices, ball.triangles, ball.vertices)
    ball.save(tmp_path / f"a.{ending}")
    read = bob.load_mesh(tmp_path / f"a.{ending}")
    assert read.normals is not None
    unit = read.normals / np.linalg.norm(read.normals, axis=1, keepdims=True)
    assert np.allclose(unit, read.vertices / np.linalg.norm(read.vertices, axis=1, keepdims=True), atol=1e-4)


def test_a_scene_is_one_mesh_of_shapes_in_their_places():
    ball = d3.sphere(1)
    mirrored = bob.Instance(ball, np.diag([-2.0, 2, 2, 1])).translate((5, 0, 0))
    mesh = bob.Scene([ball, mirrored, d3.box(1).mesh().mesh()]).mesh(0.1)
    checked = check_closed(mesh)
    volumes = sorted(part.volume for part in checked.split())
    assert volumes == pytest.approx([1, 4 / 3 * PI, 8 * 4 / 3 * PI], rel=3e-3)


def test_steps_and_paths_that_can_not_be_are_named(tmp_path, monkeypatch):
    curve = bob.polyline([(0, 0, 0), (0, 0, 2)], 0.5)
    cases = [
        (lambda: d3.sphere(1).mesh(0), "step: expected a number of at least 0.0005"),
        (lambda: d3.sphere(1).mesh(1e-5), "4000 steps are the most along a side"),
        (lambda: d3.sphere(1).mesh("1"), "step: expected a number, got str '1'"),
        (lambda: curve.mesh(1e-6), "4000 steps are the most along a side"),
        (lambda: sphere().mesh(-1), "step: expected a number of at least"),
        (lambda: bob.Scene(d3.sphere(1)).mesh(-1), "step: expected a number above 0, got -1"),
        (lambda: d3.plane().mesh(), "shape: expected "),
        (
            lambda: d3.sphere(1).mesh().save("out.png"),
            r"out.png: expected a mesh's ending \(.stl .ply .obj .glb\), got .png",
        ),
        (lambda: d3.sphere(1).mesh().save(tmp_path / "no/out.stl"), "there is no folder"),
        (lambda: d3.sphere(1).save("out.xyz"), r"out.xyz: expected the ending of a mesh or a picture \(.stl"),
        (lambda: d3.sphere(1).show_slice(), "show_slice: expected a plane, x=, y= or z=, got none"),
    ]
    for make, message in cases:
        with pytest.raises(bob.InputError, match=message):
            make()
    for module in (mesh_module, tessellation, tube):
        monkeypatch.setattr(module, "MAX_TRIANGLES", 1000)
    for shape in (curve, sphere()):
        with pytest.raises(bob.InputError, match="which makes more than 1000 triangles"):
            shape.mesh()


def test_what_is_thinner_than_the_step_is_told():
    dust = functools.reduce(lambda a, b: a | b, (d3.sphere(0.01).translate(p) for p in np.eye(3)))
    with pytest.raises(bob.InputError, match="step: expected less than the shape's thickness"):
        dust.mesh(0.2)


def test_the_lattice_of_the_core_takes_the_most_cells():
    assert shape_module.MAX_CELLS < 4096
    flat = d3.box((1, 1e-3, 1e-3))
    check_closed(flat.mesh(1.02 / shape_module.MAX_CELLS), 2)


def test_programs_for_fogleman_sdf_write_meshes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    program = (
        "from bobrossnet.sdf import *\nf = sphere(1) & box(1.5)\nc = cylinder(0.5)\n"
        "f -= c.orient(X) | c.orient(Y) | c.orient(Z)\n"
        "f.save('out.stl', step=0.05, verbose=False, sparse=True)\nsave('out.ply', f, samples=2**15)\n"
        "points = generate(f, step=(0.05, 0.1, 0.1), workers=2, batch_size=32)\n"
        "write_binary_stl('points.stl', points)\n"
    )
    names = {}
    exec(program, names)
    assert as_trimesh(bob.load_mesh("out.stl")).volume == pytest.approx(0.9888, rel=2e-3)
    points = names["points"]
    assert points.shape[1] == 3
    assert len(points) == 3 * len(bob.load_mesh("out.stl").triangles)
    assert (tmp_path / "points.stl").read_bytes()[80:] == (tmp_path / "out.stl").read_bytes()[80:]
    with pytest.raises(bob.InputError, match="points: expected three for each triangle, got 4"):
        write_binary_stl("points.stl", np.zeros((4, 3)))
    low, high = csg().bounding_box(np.eye(4))
    step = (np.prod(high - low) / 2**15) ** (1 / 3)
    assert len(bob.load_mesh("out.ply").triangles) == len(csg().mesh(step).triangles)
    half = d3.sphere(1).generate(0.05, ((-2, -2, 0), (2, 2, 2)))
    assert half[:, 2].min() == pytest.approx(0, abs=1e-5)


def test_slices_are_of_distances(monkeypatch):
    f = d3.box((1, 2, 3))
    distances, extent, axes = f.sample_slice(w=5, h=7, y=0.5, bounds=((-1, -2, -3), (1, 2, 3)))
    assert distances.shape == (5, 7)
    assert (extent, axes) == ((-3, 3, -1, 1), "ZX")
    x, z = np.meshgrid(np.linspace(-1, 1, 5), np.linspace(-3, 3, 7), indexing="ij")
    assert np.allclose(distances, f(np.stack([x, np.full_like(x, 0.5), z], axis=-1).reshape(-1, 3)).reshape(5, 7))
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    shown = []
    monkeypatch.setattr(plt, "show", lambda: shown.append(plt.gcf().axes[0].images[0]))
    f = d2.circle(1).extrude(2)
    f.show_slice(z=0, w=20, h=30)
    assert shown[0].get_array().shape == (20, 30)
    plt.close("all")
    f.show_slice(z=0, w=20, h=30, abs=True)
    assert np.array_equal(shown[1].get_array(), np.abs(shown[0].get_array()))
    assert shown[0].get_array().min() < -0.5
    plt.close("all")


def test_the_command_writes_meshes(tmp_path, capsys):
    script = tmp_path / "part.sdf"
    script.write_text("f = box((1, 2, 3)) - cylinder(0.2)\n")
    out = tmp_path / "part.ply"
    assert cli.main(["mesh", str(script), "-o", str(out), "--step", "0.05"]) == 0
    assert "triangles of 1 shape" in capsys.readouterr().out
    assert as_trimesh(bob.load_mesh(out)).volume == pytest.approx(6 - 3 * PI * 0.04, rel=1e-3)
    assert cli.main(["mesh", str(script), "--up", "y", "-o", str(out)]) == 0
    assert bob.load_mesh(out).vertices.max(axis=0) == pytest.approx((0.5, 1.5, 1), abs=1e-3)
    assert cli.main(["mesh", str(script), "-o", str(tmp_path / "part.xyz")]) == 2
    assert "part.xyz: expected a mesh's ending" in capsys.readouterr().err
