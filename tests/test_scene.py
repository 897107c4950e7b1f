"""Scenes of several shapes: placement, materials, and independence of order and threads."""

import copy
import hashlib
import itertools
import pickle
import signal
import time
from functools import partial

import numpy as np
import pytest
from clocks import least
from hypothesis import given, settings
from hypothesis import strategies as st
from models import MODELS, needs_models
from thread_counts import with_threads

import bobrossnet as bob
from bobrossnet.shapes.affine import mapped, rotation

SIZE = (90, 120)


def cube(shift=(0, 0, 0)):
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return bob.Mesh(corners + shift, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def ball(rings=24):
    """Return a sphere of unit radius, with exact normals."""
    u, v = np.meshgrid(np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings + 1), indexing="ij")
    points = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], axis=-1).reshape(-1, 3)
    i = (np.arange(rings)[:, None] * (2 * rings + 1) + np.arange(2 * rings)).reshape(-1, 1)
    triangles = np.concatenate([i + (0, 2 * rings + 1, 1), i + (1, 2 * rings + 1, 2 * rings + 2)])
    return bob.Mesh(points, triangles, points)


def faceted(mesh):
    """Return the mesh with separate normals for each face."""
    corners = mesh.vertices[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    triangles = np.arange(mesh.triangles.size).reshape(-1, 3)
    return bob.Mesh(corners.reshape(-1, 3), triangles, np.repeat(normals, 3, axis=0))


# ---- Order and threads -----------------------------------------------------------------------------------


def crowd():
    """Shapes that overlap, touch and coincide: two coincident cubes of different materials, balls of one shape."""
    red, blue = bob.Material(color="#ff0000"), bob.Material(color=(0, 0, 1), specular=1, shininess=3)
    one, round_one = cube(), ball()
    return [
        bob.Instance(one, material=red),
        bob.Instance(cube(), material=blue, name="the same place"),
        bob.Instance(one).translate((1, 0, 0)),
        bob.Instance(round_one, material=blue).scale(0.7).translate((0.5, 0.5, 1)),
        bob.Instance(round_one).scale((0.2, 1, 0.4)).rotate(1, (1, 1, 0)),
    ]


@settings(max_examples=15, deadline=None)
@given(st.permutations(range(5)), st.integers(0, 5))
def test_the_order_of_shapes_does_not_matter(order, nested):
    shapes = crowd()
    shuffled = [shapes[i] for i in order]
    shuffled = [bob.Scene(shuffled[:nested]), *shuffled[nested:]] if nested else shuffled
    assert bob.trace(shuffled, size=SIZE) == bob.trace(shapes, size=SIZE)


def test_closest_hits_name_the_instance_in_the_callers_order():
    far_and_near = [cube((0, 0, -5)), cube((0, 0, 5)), cube()]
    for order in itertools.permutations(range(3)):
        scene = bob.Scene([far_and_near[i] for i in order])
        distance, instance, triangle, *_ = scene.closest_hits(
            [[0.4, 0.5, 9], [0.4, 0.5, 9], [7, 7, 9]], [[0, 0, -1], [0, 1, 0], [0, 0, -1]]
        )
        assert instance.tolist() == [order.index(1), -1, -1]
        assert distance[0] == pytest.approx(3, rel=1e-6)
        assert (triangle >= 0).tolist() == [True, False, False]


def test_names_are_for_people_only():
    named = [bob.Instance(cube(), name="a"), bob.Instance(cube((0.5, 0, 0)), name="b")]
    assert bob.trace(named, size=SIZE) == bob.trace([instance.shape for instance in named], size=SIZE)


def test_threads_and_fractions_do_not_matter():
    pictures = with_threads((1, 2, 5), lambda: bob.trace(crowd(), size=(300, 400)))
    assert pictures[0] == pictures[1] == pictures[2]
    assert bob.trace(crowd(), size=(300, 400), fraction=0.1, seed=3) == pictures[0].sample(0.1, seed=3)


# ---- Places ----------------------------------------------------------------------------------------------


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_a_moved_shape_looks_like_moved_vertices(seed):
    rng = np.random.default_rng(seed)
    matrix = np.eye(4)
    matrix[:3, :3] = np.diag(rng.uniform(0.5, 2, 3)) @ rotation(rng.uniform(-4, 4), rng.normal(size=3))[:3, :3]
    matrix[:3, 3] = rng.normal(size=3) * 10
    mesh = faceted(cube())  # a non-uniform scale bends interpolated normals
    moved = faceted(bob.Mesh(mapped(matrix, mesh.vertices), mesh.triangles))
    by_matrix = bob.trace(bob.Instance(mesh, matrix), size=SIZE)
    by_vertices = bob.trace(moved, size=SIZE)
    assert (by_matrix.depth > 0).mean() > 0.05
    # Along an edge, rounding decides which face a ray hits.
    assert (np.abs(by_matrix.depth - by_vertices.depth) > 1e-5).mean() < 1e-3
    assert (np.abs(by_matrix.normal - by_vertices.normal) > 1e-5).mean() < 1e-3


def test_a_rigidly_moved_shape_has_the_same_normals_to_rounding():
    mesh = ball()
    instance = bob.Instance(mesh).scale(3).rotate(0.7, (1, 2, 3)).translate((5, -6, 7))
    moved = bob.Mesh(
        mapped(instance.transform, mesh.vertices), mesh.triangles, mesh.normals @ instance.transform[:3, :3].T
    )
    a, b = bob.trace(instance, size=SIZE), bob.trace(moved, size=SIZE)
    hit = (a.depth > 0) & (b.depth > 0)
    facing = hit & (np.linalg.norm(b.normal, axis=2) < 0.99)  # near silhouettes, rounding moves hits along the surface
    assert facing.mean() > 0.3
    assert np.abs(a.depth - b.depth)[hit].max() < 1e-5
    assert np.abs(a.normal - b.normal)[facing].max() < 1e-5


def test_transforms_are_the_modelling_language_s():
    at = bob.Instance(cube())

    def moved(instance, point):
        return mapped(instance.transform, np.array([point], float))[0].tolist()

    assert moved(at, (1, 2, 3)) == [1, 2, 3]
    assert moved(at.rotate(np.pi / 2), (1, 0, 0)) == pytest.approx([0, 1, 0])  # about z, anticlockwise from above
    assert moved(at.rotate(np.pi / 2, (2, 0, 0)), (0, 1, 0)) == pytest.approx([0, 0, 1])
    assert moved(at.rotate(degrees=30, vector=(0, 0, 3)), (1, 0, 0)) == pytest.approx([np.sqrt(3) / 2, 0.5, 0])
    assert moved(at.rotate(degrees=-90), (1, 0, 0)) == [0, -1, 0]  # exactly
    assert moved(at.rotate(degrees=450, vector=(0, -2, 0)), (1, 0, 0)) == [0, 0, 1]
    assert moved(at.scale((1, 2, 3)), (1, 1, 1)) == [1, 2, 3]
    assert moved(at.translate((1, 0, 0)).scale(2), (1, 1, 1)) == [4, 2, 2]  # one after the other
    assert moved(at.scale(2).translate((1, 0, 0)), (1, 1, 1)) == [3, 2, 2]
    assert moved(at, (1, 2, 3)) == [1, 2, 3]
    with pytest.raises(ValueError, match="read-only"):
        at.transform[0, 0] = 2


def test_turned_upright():
    scene = bob.Scene([bob.Instance(cube(), name="left"), cube((0, 5, 0))])
    turned = scene.turned_upright()
    low, high = turned.instances[1].shape.bounding_box(turned.instances[1].transform)
    assert (low.tolist(), high.tolist()) == ([0, -1, 5], [1, 0, 6])
    assert turned.instances[0].name == "left"
    merged = bob.trace([cube().turned_upright(), cube((0, 5, 0)).turned_upright()], size=SIZE)
    assert np.abs(bob.trace(turned, size=SIZE).stack() - merged.stack()).max() < 1e-5


def test_bounds_and_sphere_of_placed_shapes():
    scene = bob.Scene([bob.Instance(ball()).scale((1, 2, 3)), bob.Instance(cube()).translate((9, 0, 0))])
    assert scene.center == pytest.approx([4.5, 0, 0])
    assert scene.radius == pytest.approx(np.sqrt(5.5**2 + 2))


def test_two_meshes_are_not_smoothed_as_one():
    """Two plates at an angle of 20 degrees: smooth as one mesh, flat as two meshes."""
    slope = np.tan(np.radians(20))
    corners = [(0, -1, 0), (0, 1, 0), (-1, -1, -slope), (-1, 1, -slope), (1, -1, 0), (1, 1, 0)]
    left, right = [(0, 1, 3), (0, 3, 2)], [(0, 4, 5), (0, 5, 1)]
    apart = bob.trace([bob.Mesh(corners, left), bob.Mesh(corners, right)], bob.Camera(0, 90), size=(64, 64))
    joined = bob.trace(bob.Mesh(corners, left + right), bob.Camera(0, 90), size=(64, 64))
    lean = np.sin(np.radians(20))
    hit = apart.depth > 0
    flat = np.linalg.norm(apart.normal, axis=2)[hit]
    assert np.minimum(flat, np.abs(flat - lean)).max() < 1e-6
    bent = np.linalg.norm(joined.normal, axis=2)[hit]
    assert np.minimum(bent, np.abs(bent - lean)).max() > 0.1


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32), scale=st.floats(1e-9, 1e9), shift=st.floats(-1e6, 1e6))
def test_a_shape_alone_is_traced_in_its_own_coordinates(seed, scale, shift):
    """So its rays need no further rounding on their way to it."""
    rng = np.random.default_rng(seed)
    scene = bob.Scene(bob.Mesh((rng.normal(size=(30, 3)) + shift) * scale, np.arange(30).reshape(-1, 3)))
    assert np.array_equal(scene.core.to_shapes[0], np.eye(4)[:3])


def test_a_small_shape_far_from_the_centre():
    """A ball of a thousandth of the scene, zoomed in to fill the picture."""
    specks = [bob.Mesh([[x, x, x], [x, x, x + 1e-9], [x, x + 1e-9, x]], [[0, 1, 2]]) for x in (-1.0, 1.0)]
    tiny = bob.Instance(ball()).scale(1e-3)
    alone, within = (
        bob.trace(tiny, size=(64, 64)),
        bob.trace([*specks, tiny], bob.Camera(zoom=np.sqrt(3) * 1e3), size=(64, 64)),
    )
    hit = (alone.depth > 0) & (within.depth > 0)
    assert (alone.depth > 0).mean() == pytest.approx((within.depth > 0).mean(), abs=0.01)
    facing = hit & (np.linalg.norm(alone.normal, axis=2) < 0.9)
    assert np.abs(alone.normal - within.normal)[facing].max() < 1e-3


@needs_models
def test_a_scene_of_instances_agrees_with_embree():
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    bunny, rng = bob.load_mesh(MODELS / "scans/stanford_bunny.ply"), np.random.default_rng(1)
    scene = bob.Scene(
        bob.Instance(bunny)
        .scale(rng.uniform(0.5, 2))
        .rotate(rng.uniform(0, 7), rng.normal(size=3))
        .translate(rng.normal(size=3) / 5)
        for _ in range(6)
    )
    embree = EmbreeScene()
    vertices = [(mapped(i.transform, bunny.vertices) - scene.center) / scene.radius for i in scene.instances]
    starts = [n * len(bunny.vertices) for n in range(6)]
    TriangleMesh(
        embree,
        np.concatenate(vertices).astype(np.float32),
        np.concatenate([bunny.triangles + n for n in starts]).astype(np.int32),
    )
    direction = rng.normal(size=(20_000, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    origin = rng.uniform(-0.5, 0.5, direction.shape) - 2 * direction
    found = embree.run(origin.astype(np.float32), direction.astype(np.float32), output=True)
    distance, instance, triangle, *_ = scene.closest_hits(origin * scene.radius + scene.center, direction)
    theirs, ours = found["primID"] >= 0, instance >= 0
    assert ours.mean() > 0.2
    assert (ours != theirs).mean() <= 2e-4
    both = ours & theirs
    difference = np.abs(distance[both] / scene.radius - found["tfar"][both])
    assert (difference > 1e-5).mean() <= 1e-3
    number = instance[both] * len(bunny.triangles) + triangle[both]
    assert (number != found["primID"][both]).mean() < 1e-3


# ---- Sharing ---------------------------------------------------------------------------------------------


def test_instances_share_the_core_shape():
    shape = ball()
    many = bob.Scene(bob.Instance(shape).translate((i, 0, 0)) for i in range(20))
    assert many.core.bytes == bob.Scene(shape).core.bytes == shape.core.bytes
    assert all(instance.shape.core is shape.core for instance in many.instances)


def test_shapes_in_many_places_reach_as_far_as_in_one():
    rng = np.random.default_rng(5)
    sphere = bob.implicit(lambda x, y, z: x * x + y * y + z * z - 1)
    vase = bob.nurbs_surface(
        [[(x, y, x * y / 2) for y in range(4)] for x in range(4)], [0] * 4 + [1] * 4, [0] * 4 + [1] * 4
    )
    for shape in (
        ball(),
        sphere,
        vase,
        bob.nurbs_curve([(0, 0, 0), (0, 2, 3), (1, 0, 0)], [0, 0, 0, 1, 1, 1], radius=0.1),
    ):
        maps = np.tile(np.eye(4), (20, 1, 1))
        maps[:, :3] += rng.uniform(-0.4, 0.4, (20, 3, 4)) * (1, 1, 1, 20)
        fresh = [pickle.loads(pickle.dumps(shape)) for _ in maps]  # each in one place
        many, apart = bob.Scene(map(bob.Instance, [shape] * 20, maps)), bob.Scene(map(bob.Instance, fresh, maps))
        assert np.array_equal(many.boxes, apart.boxes)
        assert many.radius == apart.radius == max(s.radius(m, many.center) for s, m in zip(fresh, maps, strict=True))
        assert bob.trace(many, size=SIZE) == bob.trace(apart, size=SIZE)


@pytest.mark.measures
@pytest.mark.parametrize("kind", ["mesh", "formula"])
def test_100_000_places_are_a_matter_of_seconds(kind):
    shape = cube() if kind == "mesh" else bob.implicit(lambda x, y, z: abs(x**3) + y**4 + z**4 - 1)
    places = [
        bob.Instance(shape, rotation(i, (1, i % 7, i % 5))).translate((i % 50, i // 50 % 50, i)) for i in range(1000)
    ]
    start = time.perf_counter()
    scene = bob.Scene(places * 100)
    assert len(scene.boxes) == 100_000
    bob.trace(scene, size=(30, 40))  # coincident instances aren't hit
    assert time.perf_counter() - start < 10


def test_scenes_of_too_many_instances_are_refused_at_once():
    shape = cube()
    with pytest.raises(bob.InputError, match=r"^shapes: expected at most 100,000 in a scene, got more$"):
        bob.Scene(itertools.repeat(shape))


def test_arranging_can_be_interrupted():
    def interrupt(signum, frame):
        raise InterruptedError

    shape = bob.implicit(lambda x, y, z: abs(x**3) + y**4 + z**4 - 1)
    places = [bob.Instance(shape, rotation(0.001 * i, (1, i % 7, i % 5))) for i in range(20_000)]

    def arrange_for_ever():
        while True:
            bob.Scene(places).core  # noqa: B018

    def stopping(after):
        start = time.perf_counter()
        signal.setitimer(signal.ITIMER_REAL, after)
        with pytest.raises(InterruptedError):
            arrange_for_ever()
        return time.perf_counter() - start - after

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        for after in (0.02, 0.06, 0.1):
            assert least(partial(stopping, after), 2) < 2
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_shapes_do_not_change():
    vertices = np.eye(3)
    mesh = bob.Mesh(vertices, [[0, 1, 2]])
    before = bob.trace(mesh, size=(16, 16))
    vertices *= (3, 1, 1)
    assert bob.trace(mesh, size=(16, 16)) == before
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0] = 7


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda mesh: pickle.loads(pickle.dumps(mesh))])
def test_traced_shapes_can_be_copied(copied):
    mesh = ball()
    picture = bob.trace(mesh, size=(16, 16))
    assert bob.trace(copied(mesh), size=(16, 16)) == picture
    assert copied(mesh).digest == mesh.digest != cube().digest


def test_traced_scenes_can_be_copied():
    scene = bob.Scene(crowd())
    picture = bob.trace(scene, size=(16, 16))
    for again in (copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        assert bob.trace(again, size=(16, 16)) == picture


def test_digests_are_what_files_rely_on():
    """SHA-256 of the kind and each tensor with its name, dtype and shape; of that, the transform and the material."""
    shapes = [cube(), ball(), bob.nurbs_surface(np.arange(12.0).reshape(2, 2, 3) ** 2, [0, 0, 1, 1], [0, 0, 1, 1])]
    shapes += [bob.polyline([(0, 0, 0), (0, 0, 1)], 0.1), bob.implicit(lambda x, y, z: x * x + y * y + z * z - 1)]
    for shape in shapes:
        digest = hashlib.sha256(shape.kind.encode())
        for name, tensor in sorted(shape.tensors().items()):
            digest.update(f"{name} {tensor.dtype.str} {tensor.shape}".encode() + tensor.tobytes())
        assert shape.digest == digest.digest()
        material = bob.Material((0.1, 0.2, 0.3))
        instance = bob.Instance(shape, material=material).rotate(1)
        numbers = (*material.color, material.ambient, material.diffuse, material.specular, material.shininess)
        seen = np.array([*instance.transform.ravel(), *numbers])
        assert instance.digest() == hashlib.sha256(shape.digest + seen.tobytes()).digest()


def test_scenes_wait_for_the_first_ray_before_they_build():
    mesh = ball()
    scene = bob.Scene([mesh, bob.Instance(mesh).scale(2)])
    assert scene.radius == pytest.approx(2)
    assert mesh.core.bytes == 0
    assert scene.core.bytes == mesh.core.bytes > 0


# ---- Materials -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "material",
    [
        bob.Material(),
        bob.Material(color=(0.5, 0.2, 0.9)),
        bob.Material(color="#336699", ambient=0, diffuse=1, specular=0.5, shininess=4),
        bob.Material(color=(1, 1, 1), ambient=1, diffuse=1, specular=1),
        bob.Material(color=(0, 0, 0), specular=0),
    ],
    ids=repr,
)
def test_gray_is_the_formula(material):
    picture = bob.trace(bob.Instance(ball(), material=material), size=SIZE)
    hit = picture.depth > 0
    assert not picture.gray[~hit].any()
    hit &= np.linalg.norm(picture.normal, axis=2) < 0.99  # z is imprecise near the horizon
    x, y = picture.normal[hit].astype(float).T
    normal = np.stack([x, y, np.sqrt(1 - x * x - y * y)], axis=1)
    light = np.array([-0.3, 0.4, 1]) / np.linalg.norm([-0.3, 0.4, 1])
    half = (light + (0, 0, 1)) / np.linalg.norm(light + (0, 0, 1))
    luminance = np.dot(material.color, (0.2126, 0.7152, 0.0722))
    gray = luminance * (material.ambient + material.diffuse * np.maximum(0, normal @ light))
    gray += material.specular * np.maximum(0, normal @ half) ** material.shininess
    assert np.abs(picture.gray[hit] - np.clip(gray, 0, 1)).max() < 1e-5


def test_only_the_shade_depends_on_the_material():
    white, dark = (
        bob.trace(cube(), size=SIZE),
        bob.trace(bob.Instance(cube(), material=bob.Material("#202020")), size=SIZE),
    )
    assert np.array_equal(white.depth, dark.depth)
    assert np.array_equal(white.normal, dark.normal)
    assert bob.trace(bob.Instance(cube(), material=bob.Material()), size=SIZE) == white
    assert (dark.gray[white.depth > 0] < white.gray[white.depth > 0]).all()


def test_colours():
    assert bob.Material().color == bob.Material("#ffffff").color == (1, 1, 1)
    assert bob.Material("#FF0000").color == (1, 0, 0)
    # Worked values of IEC 61966-2-1: 128 is 0.2159 linear, 5 lies on the linear segment.
    assert bob.Material("#800005").color == pytest.approx((0.21586, 0, 5 / 255 / 12.92), abs=1e-5)
    assert bob.Material(color=np.array([0.25, 0.5, 1])).color == (0.25, 0.5, 1)


# ---- Bad input -------------------------------------------------------------------------------------------

SINGULAR = np.diag([1.0, 0, 1, 1])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: bob.Material("rot"), "color: expected #rrggbb, a CSS name or 3 numbers, got 'rot'"),
        (lambda: bob.Material("#12345"), "color: expected #rrggbb"),
        (lambda: bob.Material((1, 1)), "color: expected #rrggbb, a CSS name or 3 numbers, got (1, 1)"),
        (lambda: bob.Material(7), "color: expected #rrggbb, a CSS name or 3 numbers, got 7"),
        (lambda: bob.Material((1, 1, 2)), "color: expected a number in [0, 1], got 2"),
        (lambda: bob.Material((1, 1, float("nan"))), "color: expected a number in [0, 1], got nan"),
        (lambda: bob.Material(ambient=-1), "ambient: expected a number in [0, 1], got -1"),
        (lambda: bob.Material(diffuse="much"), "diffuse: expected a number, got str 'much'"),
        (lambda: bob.Material(specular=2), "specular: expected a number in [0, 1], got 2"),
        (lambda: bob.Material(shininess=1e9), "shininess: expected a number in [0, 10000], got 1e+09"),
        (lambda: bob.Instance("bunny.ply"), "shape: expected a shape, got str"),
        (lambda: bob.Instance(bob.Scene(cube())), "shape: expected a shape, got Scene"),
        (lambda: bob.Instance(cube(), material="#ff0000"), "material: expected a Material, got str"),
        (lambda: bob.Instance(cube(), name=3), "name: expected a string, got int"),
        (lambda: bob.Instance(cube(), np.eye(3)), "transform: expected shape (4, 4), got (3, 3)"),
        (lambda: bob.Instance(cube(), SINGULAR), "transform: expected a map that keeps all three dimensions"),
        (lambda: bob.Instance(cube(), np.eye(4) * 2), "transform: expected an affine map, whose last row is"),
        (lambda: bob.Instance(cube(), np.full((4, 4), np.inf)), "transform: expected finite numbers"),
        (lambda: bob.Instance(cube()).scale(0), "factor: expected a map that keeps all three dimensions"),
        (lambda: bob.Instance(cube()).scale((1, 2)), "factor: expected shape (3,), got (2,)"),
        (lambda: bob.Instance(cube()).scale("big"), "factor: expected a number, got str 'big'"),
        (lambda: bob.Instance(cube()).translate(1), "offset: expected shape (3,), got ()"),
        (lambda: bob.Instance(cube()).rotate("half"), "angle: expected a number, got str 'half'"),
        (lambda: bob.Instance(cube()).rotate(), "angle: expected radians or degrees=, got neither"),
        (lambda: bob.Instance(cube()).rotate(1, degrees=3), "angle: expected radians or degrees=, got both"),
        (lambda: bob.Instance(cube()).rotate(degrees="half"), "degrees: expected a number, got str 'half'"),
        (lambda: bob.Instance(cube()).rotate(1, (0, 0, 0)), "vector: expected an axis of a length above 0"),
        (lambda: bob.Instance(cube()).transformed(SINGULAR), "matrix: expected a map"),
        (lambda: bob.Scene([]), "shapes: expected at least one shape, got none"),
        (lambda: bob.Scene([[], [[]]]), "shapes: expected at least one shape, got none"),
        (lambda: bob.Scene([cube(), 3]), "shapes: expected a shape or several, got int among them"),
        (lambda: bob.Scene([["nothing.ply"]]), "nothing.ply: expected a file, found nothing at nothing.ply"),
        (
            lambda: bob.Scene(bob.Mesh((2 * np.eye(3) - 1) * 1.7e308, [[0, 1, 2]])),
            "shapes: expected a radius that float64",
        ),
        (lambda: bob.Scene(bob.Mesh(np.eye(3) * 1e-320, [[0, 1, 2]])), "shapes: expected a radius that float64"),
    ],
)
def test_bad_arguments_are_named(make, message):
    with pytest.raises(bob.InputError) as error:
        make()
    assert str(error.value).startswith(message)
    assert "\n" not in str(error.value)


def test_points_among_shapes_are_no_error():
    point = bob.Mesh(np.full((3, 3), 0.5), [[0, 1, 2]])
    assert bob.trace([cube(), point], size=SIZE) == bob.trace(cube(), size=SIZE)
    low, high = point.bounding_box(np.eye(4))
    assert low.tolist() == high.tolist() == [0.5, 0.5, 0.5]
    assert point.radius(np.eye(4), low) == 0
