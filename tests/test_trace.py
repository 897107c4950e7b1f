"""The tracer against Embree and itself; cameras and scenes."""

import io

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from models import MODELS, needs_models
from thread_counts import with_threads

import bobrossnet as bob
from bobrossnet.support.errors import InputError
from bobrossnet.tracing.pixels import tiled_pixels

SIZE = (90, 120)


def cube():
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return bob.Mesh(corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def test_part_equals_sample_of_the_whole(tree):
    full = bob.trace(tree, bob.Camera(75, 10), size=SIZE)
    assert full.fraction == 1
    for fraction in (0.0001, 0.05, 0.25, 0.9999):
        part = bob.trace(tree, bob.Camera(75, 10), size=SIZE, fraction=fraction, seed=5)
        assert part == full.sample(fraction, seed=5)
        assert part.mask.sum() == max(1, round(fraction * SIZE[0] * SIZE[1]))


def test_fractions_are_nested(tree):
    small = bob.trace(tree, size=SIZE, fraction=0.05)
    large = bob.trace(tree, size=SIZE, fraction=0.25)
    assert (large.mask[small.mask > 0] == 1).all()


def test_any_pixels_can_be_traced(tree):
    full = bob.trace(tree, size=SIZE)
    pixels = np.array([[0, 0], [45, 60], [89, 119], [45, 60]], np.int32)
    samples = bob.SceneTracer(tree, bob.Camera(), SIZE)(pixels)
    assert np.array_equal(samples.gray, full.gray[pixels[:, 0], pixels[:, 1]])
    assert np.array_equal(samples.normal, full.normal[pixels[:, 0], pixels[:, 1]])


def test_pixels_may_be_any_integers_inside(tree):
    tracer = bob.SceneTracer(tree, bob.Camera(), SIZE)
    pixels = np.argwhere(np.eye(4, 6))
    expected = tracer(np.ascontiguousarray(pixels, np.int32)).values
    for same in (pixels, np.asfortranarray(pixels.astype(np.uint8)), pixels.tolist()):
        assert np.array_equal(tracer(same).values, expected)
    assert len(tracer(np.empty((0, 2), np.int64))) == 0


@pytest.mark.parametrize(
    ("pixels", "message"),
    [
        ([[0, 0], [5, 120]], r"expected each at least \(0, 0\) and below \(90, 120\), got \(5, 120\)"),
        ([[-1, 3]], r"got \(-1, 3\)"),
        (np.array([[2**32, 3]]), r"pixels: expected each at least"),
        (np.array([[2**64 - 1, 3]], np.uint64), r"pixels: expected each at least"),
        ([[0.5, 1.0]], "pixels: expected integers, a row and a column each, got dtype float64"),
        ([1, 2], r"pixels: expected shape \(n, 2\), got \(2,\)"),
    ],
)
def test_no_other_pixels(tree, pixels, message):
    with pytest.raises(InputError, match=message):
        bob.SceneTracer(tree, bob.Camera(), SIZE)(pixels)


def test_threads_do_not_matter(tree):
    pictures = with_threads((1, 2, 7), lambda: bob.trace(tree, size=SIZE))
    assert pictures[0] == pictures[1] == pictures[2]


def test_conventions_of_the_gbuffer(tree):
    full = bob.trace(tree, size=SIZE)
    missed = full.depth == 0
    assert 0.2 < missed.mean() < 0.9
    assert not full.gray[missed].any()
    assert not full.normal[missed].any()
    assert full.gray.max() <= 1
    assert full.gray[~missed].min() >= 0.1 - 1e-6  # the ambient term
    assert full.depth.max() <= 1
    assert (np.linalg.norm(full.normal, axis=2) <= 1 + 1e-6).all()


def test_normals_and_depth_of_a_cube_seen_from_its_axes():
    # Along an axis, its face is at half its edge from the centre: 1/2 of a radius of sqrt(3)/2.
    for camera in (
        bob.Camera(0, 0),
        bob.Camera(90, 0),
        bob.Camera(0, 90),
        bob.Camera(180, 0),
        bob.Camera(0, -90),
    ):
        full = bob.trace(cube(), camera, size=(64, 64))
        middle = (full.depth[32, 32], *full.normal[32, 32])
        assert middle == pytest.approx(((1 + 1 / np.sqrt(3)) / 2, 0, 0), abs=1e-5)
        # The face covers 1 / radius = 1.1547 of the 2 radii of the shorter side.
        assert np.sqrt((full.depth > 0).mean()) == pytest.approx(1 / np.sqrt(3), abs=1 / 64)


def test_zoom_and_the_shorter_side():
    for size in ((60, 100), (100, 60)):
        seen = bob.trace(cube(), bob.Camera(0, 0), size=size).depth > 0
        zoomed = bob.trace(cube(), bob.Camera(0, 0, zoom=0.5), size=size).depth > 0
        assert seen.any(axis=0).sum() == pytest.approx(60 / np.sqrt(3), abs=1)
        assert zoomed.any(axis=0).sum() == pytest.approx(30 / np.sqrt(3), abs=1)


@needs_models
@pytest.mark.parametrize(
    "file",
    [
        "scans/stanford_bunny.ply",
        "scans/armadillo.ply",
        "mechanical/satellite_fm1.ply",
        "architecture/conference_room.ply",
        "scans/happy_buddha.ply",
    ],
)
def test_agrees_with_embree(file):
    """Hits and depths of rays from everywhere.

    Only rays within rounding of a silhouette may differ: at most 1 in 10,000. Depths are within 1e-5 radii: float32 in
    either tracer, and more only for faces nearly edge-on.
    """
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    scene = bob.load(MODELS / file)
    mesh = scene.instances[0].shape
    unit = ((mesh.vertices - scene.center) / scene.radius).astype(np.float32)
    embree = EmbreeScene()
    TriangleMesh(embree, unit, mesh.triangles)

    rng = np.random.default_rng(0)
    n = 30_000
    direction = rng.normal(size=(n, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    offset = rng.uniform(-0.7, 0.7, (n, 3))
    origin = offset - 2 * direction
    found = embree.run(origin.astype(np.float32), direction.astype(np.float32), output=True)

    distance, _, triangle, *_ = scene.closest_hits(origin * scene.radius + scene.center, direction)
    theirs, ours = found["primID"] >= 0, triangle >= 0
    assert ours.mean() > 0.05
    assert (ours != theirs).mean() <= 1e-4
    both = ours & theirs
    difference = np.abs(distance[both] / scene.radius - found["tfar"][both])
    assert (difference > 1e-5).mean() <= 1e-3
    assert np.median(difference) < 1e-6


def soup(seed, count):
    rng = np.random.default_rng(seed)
    center = rng.normal(size=(count, 1, 3))
    vertices = (center + rng.normal(scale=0.3, size=(count, 3, 3))).reshape(-1, 3)
    return vertices, np.arange(3 * count).reshape(-1, 3)


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**32),
    count=st.integers(1, 200),
    scale=st.floats(1e-12, 1e12),
    shift=st.floats(-1e3, 1e3),
)
def test_where_and_how_large_a_scene_is_does_not_matter(seed, count, scale, shift):
    """A scene translated by a thousand radii and scaled by 10^12 looks the same, except at edges within rounding."""
    vertices, triangles = soup(seed, count)
    reference = bob.trace(bob.Mesh(vertices, triangles), size=(40, 40))
    moved = bob.trace(bob.Mesh((vertices + shift) * scale, triangles), size=(40, 40))
    assert (np.abs(reference.depth - moved.depth) > 1e-4).mean() < 0.01


def test_closest_hits_in_scene_units():
    distance, instance, triangle, u, v = bob.Scene(cube()).closest_hits(
        [[0.5, 0.5, 1e6], [0.5, 0.5, 0.5], [5, 5, 5]], [[0, 0, -7], [1, 0, 0], [0, 0, 1]]
    )
    assert distance[:2] == pytest.approx([1e6 - 1, 0.5], rel=1e-6)
    assert np.isinf(distance[2])
    assert instance.tolist() == [0, 0, -1]
    assert triangle[2] == -1
    assert (u[2], v[2]) == (0, 0)
    corners = cube().vertices[cube().triangles[triangle[:2]]]
    weights = np.stack([u, v, 1 - u - v], axis=1)[:2]
    assert (weights[..., None] * corners).sum(axis=1) == pytest.approx(np.array([[0.5, 0.5, 1], [1, 0.5, 0.5]]))


@pytest.mark.parametrize("length", [1e-320, 1e-170, 1.0, 1e160, 1.7e308])
def test_closest_hits_of_directions_of_any_length(length):
    directions = np.array([(0, 0, -1), (0, 0.125, -1), (0, 0.25, -1)]) * length
    distance = bob.Scene(cube()).closest_hits([(0.5, 0.5, 4)] * 3, directions).distance
    assert distance == pytest.approx([3, 3 * np.hypot(1, 0.125), np.inf], rel=1e-4)  # 1e-320 has few digits


def test_several_shapes_make_one_scene():
    near, far = cube(), bob.Mesh(cube().vertices + (3, 0, 0), cube().triangles)
    scene = bob.Scene([near, far])
    assert scene.center == pytest.approx((2, 0.5, 0.5))
    assert scene.radius == pytest.approx(np.sqrt(4 + 0.25 + 0.25))
    merged = bob.Mesh(
        np.concatenate([near.vertices, far.vertices]), np.concatenate([near.triangles, far.triangles + 8])
    )
    assert np.abs(bob.trace(scene, size=SIZE).stack() - bob.trace(merged, size=SIZE).stack()).max() < 1e-5
    assert bob.trace([bob.Scene(near), far], size=SIZE) == bob.trace(scene, size=SIZE)
    assert bob.trace([near, far], size=SIZE) != bob.trace(near, size=SIZE)


def test_unused_vertices_do_not_count():
    vertices = np.concatenate([cube().vertices, [[1e60, 0, 0]]])
    far = bob.Mesh(vertices, cube().triangles)
    assert bob.Scene(far).radius == bob.Scene(cube()).radius
    assert bob.trace(far, size=SIZE) == bob.trace(cube(), size=SIZE)


def test_stored_normals_shade():
    tilted = bob.Mesh(cube().vertices, cube().triangles, np.tile((1.0, 1, 1), (8, 1)))
    seen = bob.trace(tilted, bob.Camera(0, 0), size=(32, 32)).normal[16, 16]
    assert seen == pytest.approx((1 / np.sqrt(3), 1 / np.sqrt(3)), abs=1e-6)


def test_shapes_among_which_one_has_normals():
    smooth = bob.Mesh(cube().vertices, cube().triangles, cube().vertices - 0.5)
    flat = bob.Mesh(cube().vertices + (0, 3, 0), cube().triangles)
    full = bob.trace([smooth, flat], bob.Camera(0, 0), size=(64, 64))
    assert np.abs(full.normal[:, :32]).max() > 0.3
    assert not full.normal[:, 32:].any()


def test_turned_upright():
    mesh = bob.Mesh([[0, 0, 0], [0, 2, 0], [1, 0, 0]], [[0, 1, 2]], [[0, 1, 0]] * 3).turned_upright()
    assert mesh.vertices[1].tolist() == [0, 0, 2]
    assert mesh.normals[0].tolist() == [0, 0, 1]


@pytest.mark.parametrize("size", [(1, 1), (8, 8), (9, 17), (480, 640)])
def test_tiled_pixels_are_all_pixels(size):
    pixels = tiled_pixels(size)
    assert len(np.unique(pixels[:, 0] * size[1] + pixels[:, 1])) == len(pixels) == size[0] * size[1]


def test_progress_ends_at_one(tree):
    shares = []
    bob.trace(tree, size=(600, 1000), progress=shares.append)
    assert len(shares) > 1
    assert shares == sorted(shares)
    assert shares[-1] == 1


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: bob.Camera(azimuth=float("nan")), "azimuth: expected a finite number, got nan"),
        (lambda: bob.Camera(azimuth=1e39), "azimuth: expected a number in [-1e+06, 1e+06], got 1e+39"),
        (lambda: bob.Camera(roll=-1.1e6), "roll: expected a number in [-1e+06, 1e+06], got -1.1e+06"),
        (lambda: bob.Camera(elevation=91), "elevation: expected a number in [-90, 90], got 91"),
        (lambda: bob.Camera(zoom=0), "zoom"),
        (lambda: bob.Camera(zoom="2"), "zoom: expected a number, got str '2'"),
        (lambda: bob.trace(cube(), camera=(30, 20)), "camera: expected a Camera, got tuple"),
        (
            lambda: bob.trace("nothing.ply"),
            "nothing.ply: expected a file, found nothing at nothing.ply",
        ),
        (lambda: bob.trace([cube(), None]), "shapes: expected a shape or several, got NoneType among them"),
        (lambda: bob.trace([]), "shapes: expected at least one shape, got none"),
        (lambda: bob.trace(None), "shapes: expected a shape or several, got NoneType"),
        (lambda: bob.trace(cube(), size=(0, 10)), "height"),
        (lambda: bob.trace(cube(), fraction=0), "fraction: expected a number in (0, 1], got 0"),
        (lambda: bob.trace(cube(), fraction=5), "fraction: expected a number in (0, 1], got 5; 5 % is 0.05"),
        (lambda: bob.trace(cube(), fraction="5%"), "fraction: expected a number, got str '5%'; 5 % is 0.05"),
        (lambda: bob.ssim(bob.trace(cube(), size=(20, 20)), 0), "image: expected an array of numbers, got GBuffer"),
        (lambda: bob.trace(cube(), fraction=5), "fraction"),
        (lambda: bob.trace(cube(), order="zigzag"), "order"),
        (lambda: bob.load(3), "source: expected a path, a shape or several, got int"),
        (lambda: bob.load(io.StringIO("solid")), "source: expected a path, a shape or several, got an open file"),
        (lambda: bob.Scene(io.BytesIO(b"solid")), "shapes: expected a shape or several, got an open file"),
        (lambda: bob.load([]), "shapes: expected at least one shape, got none"),
        (lambda: bob.load(bob.happy_tree(), up="w"), "up: expected one of auto, x, y, z, -x, -y, -z, got 'w'"),
        (lambda: bob.Mesh(np.zeros((4, 2)), [[0, 1, 2]]), "vertices: expected shape (n, 3), got (4, 2)"),
        (
            lambda: bob.Mesh(np.ma.masked_equal(np.eye(3), 1), [[0, 1, 2]]),
            "vertices: expected numbers everywhere, got masked values",
        ),
        (
            lambda: bob.Mesh([[0, 0, np.inf]] * 3, [[0, 1, 2]]),
            "vertices: expected finite numbers, got 3 of 9",
        ),
        (lambda: bob.Mesh(np.eye(3), [[0, 1, 3]]), "triangles: expected indices in 0..2, got 0..3"),
        (lambda: bob.Mesh(np.eye(3), [[0, -1, 2]]), "triangles: expected indices in 0..2, got -1..2"),
        (lambda: bob.Mesh(np.eye(3), [[0.0, 1, 2]]), "triangles: expected integers, got dtype float64"),
        (lambda: bob.Mesh(np.eye(3), np.zeros((0, 3), int)), "triangles: expected at least one triangle"),
        (lambda: bob.Mesh(np.eye(3), [[0, 1, 2]], np.eye(2)), "normals: expected shape (3, 3), got (2, 2)"),
        (lambda: bob.Scene(bob.Mesh(np.ones((3, 3)), [[0, 1, 2]])), "shapes: expected an extent above zero"),
        (
            lambda: bob.Scene(cube()).closest_hits([[0, 0, 0]], [[0, 0, 0]]),
            "directions: expected lengths above 0",
        ),
        (
            lambda: bob.Scene(cube()).closest_hits([[0, 0, np.nan]], [[0, 0, 1]]),
            "origins: expected finite numbers",
        ),
    ],
)
def test_bad_arguments_are_named(make, message):
    with pytest.raises(bob.InputError) as error:
        make()
    assert str(error.value).startswith(message)


def test_extreme_coordinates():
    for scale in (1e-300, 1e300):
        assert bob.Scene(bob.Mesh(cube().vertices * scale, cube().triangles)).radius == pytest.approx(
            np.sqrt(3) / 2 * scale
        )
