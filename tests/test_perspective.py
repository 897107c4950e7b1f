"""Perspective cameras: projection of points, and pictures of shapes of every kind, from outside and inside.

The expected values come from a pinhole camera in numpy, float64, in the scene's units."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from models import MODELS, needs_models
from nurbs_shapes import sphere as nurbs_sphere
from nurbs_shapes import torus

import bobrossnet as bob
from bobrossnet.tracing.pixels import tiled_pixels
from bobrossnet.tracing.trace import SceneTracer

SIZE = (90, 120)
LIGHT = np.array([-0.3, 0.4, 1]) / np.linalg.norm([-0.3, 0.4, 1])


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


@dataclass
class Pinhole:
    """A camera as defined in docs/reference/camera.md."""

    eye: np.ndarray
    right: np.ndarray
    up: np.ndarray
    toward: np.ndarray
    side: float  # of a pixel, at a distance of 1
    size: tuple[int, int]
    center: np.ndarray
    radius: float

    @staticmethod
    def of(camera, size, center=(0, 0, 0), radius=1.0):
        center = np.array(center, float)
        height = size[0]
        half = np.tan(np.radians(camera.fov) / 2)
        if camera.position is None:
            a, e = np.radians((camera.azimuth, camera.elevation))
            toward = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
            x = np.array([-np.sin(a), np.cos(a), 0])
            eye = center + radius / np.sin(np.arctan(half * min(size) / height)) * toward
        else:
            eye = np.array(camera.position)
            toward = unit(eye - (center if camera.target is None else np.array(camera.target)))
            x = unit(np.cross(camera.up, toward))
        y, r = np.cross(toward, x), np.radians(camera.roll)
        right, up = np.cos(r) * x + np.sin(r) * y, np.cos(r) * y - np.sin(r) * x
        eye = eye + radius * (camera.pan[0] * right + camera.pan[1] * up)
        return Pinhole(eye, right, up, toward, 2 * half / (camera.zoom * height), size, center, radius)

    def directions(self):
        """Return directions from the eye through each pixel, (H, W, 3)."""
        height, width = self.size
        x = (np.arange(width) + 0.5 - width / 2) * self.side
        y = (height / 2 - 0.5 - np.arange(height)) * self.side
        return unit(x[None, :, None] * self.right + y[:, None, None] * self.up - self.toward)

    def seen(self, points):
        """Return rows and columns, (n, 2), NaN behind the camera."""
        offset = points - self.eye
        z = -offset @ self.toward
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = offset @ self.right / z / self.side, offset @ self.up / z / self.side
        height, width = self.size
        seen = np.column_stack([height / 2 - 0.5 - y, x + width / 2 - 0.5])
        seen[z <= 0] = np.nan
        return seen

    def depth(self, distance):
        """Return the depth, 0..1, of distances in the scene's units."""
        away = np.linalg.norm(self.eye - self.center) / self.radius
        nearest = max(0, away - 1)
        return np.clip(1 - (distance / self.radius - nearest) / (away + 1 - nearest), 0, 1)

    def on_screen(self, normals):
        """Return normals in the screen space of each pixel, (H, W, 3).

        It is the camera's axes, rotated by Rodrigues' formula so that z is along the pixel's ray.
        """
        camera = np.array([self.right, self.up, self.toward])
        eye = -self.directions() @ camera.T
        axis = np.cross(eye, (0, 0, 1))  # its length is the sine of the angle
        n = normals @ camera.T
        cos = eye[..., 2:]
        along = (axis * n).sum(axis=-1, keepdims=True)
        return n * cos + np.cross(axis, n) + axis * along / (1 + cos)

    def gray(self, normals):
        """Return the gray of white surfaces with these normals, (H, W)."""
        camera = np.array([self.right, self.up, self.toward])
        n, eye = normals @ camera.T, -self.directions() @ camera.T
        half = unit(LIGHT + eye)
        diffuse = np.maximum(0, n @ LIGHT)
        return np.clip(0.1 + 0.7 * diffuse + 0.2 * np.maximum(0, (n * half).sum(axis=-1)) ** 32, 0, 1)


def sphere_distance(eye, directions, center=(0, 0, 0), radius=1.0):
    """Return distances to the first surface in front of the eye, (H, W), and distances inside the silhouette."""
    offset = np.array(center) - eye
    middle = directions @ offset
    squared = radius**2 - (offset @ offset - middle**2)
    with np.errstate(invalid="ignore"):
        half = np.sqrt(squared)
    first = np.where(middle - half > 0, middle - half, middle + half)
    return np.where(first > 0, first, np.nan), squared / radius**2


CAMERAS = [
    bob.Camera(fov=35),
    bob.Camera(200, -70, 33, 1, fov=60),
    bob.Camera(0, 90, fov=100, zoom=0.7),
    bob.Camera(30, 20, 10, 1.5, fov=20, pan=(0.25, -0.5)),
    bob.Camera(fov=0.1),
    bob.Camera(position=(2.5, -1, 1.5), target=(0.2, 0, 0), fov=50),
    bob.Camera(position=(2.5, -1, 1.5), fov=50, roll=40, zoom=2, pan=(0.1, 0.2)),
    bob.Camera(position=(300, 200, 100), up=(0, 1, 0), fov=0.5),
]
INSIDE = [
    bob.Camera(position=(0.3, 0.2, -0.1), target=(1, 0.5, 0), fov=35),
    bob.Camera(position=(0.3, 0.2, -0.1), target=(-1, 0.5, 0.3), fov=120),
    bob.Camera(position=(0, 0, 0.9), target=(0, 0, 1), up=(1, 0, 0), fov=90),
]


# ---- Projection ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("camera", CAMERAS + INSIDE, ids=str)
@pytest.mark.parametrize("size", [SIZE, (100, 40)], ids=str)
def test_points_are_seen_where_numpy_sees_them(camera, size):
    center, radius = np.array([1.0, 2, 3]), 5.0
    placed = {
        name: tuple(center + radius * np.array(value))
        for name in ("position", "target")
        if (value := getattr(camera, name)) is not None
    }
    camera = replace(camera, **placed)
    pinhole = Pinhole.of(camera, size, center, radius)
    points = np.random.default_rng(0).uniform(-0.57, 0.57, (1000, 3)).astype(np.float32)
    core = camera.core(center, radius)
    seen = core.seen(*size, points)
    in_scene = center + radius * points.astype(np.float64)
    expected = pinhole.seen(in_scene)
    assert np.array_equal(np.isnan(seen[:, :2]), np.isnan(expected))
    front = ~np.isnan(expected[:, 0])
    scale = np.maximum(size[0], np.abs(expected[front]))  # of the picture, or of the distance beyond it
    assert (np.abs(seen[front, :2] - expected[front]) / scale).max(initial=0) < 1e-6
    assert np.abs(seen[:, 2] - pinhole.depth(np.linalg.norm(in_scene - pinhole.eye, axis=1))).max() < 1e-6
    # And the inverse, where float32 resolves a fraction of a pixel.
    near = front & (np.abs(seen[:, :2]).max(axis=1) < 1000)
    assert np.abs(core.points(*size, np.ascontiguousarray(seen[near])) - points[near]).max(initial=0) < 1e-5


@pytest.mark.parametrize("camera", CAMERAS + INSIDE, ids=str)
def test_rays_go_from_the_camera_through_the_pixels(camera):
    pixels = np.indices(SIZE, np.int32).reshape(2, -1).T.copy()
    met, origins, directions = camera.core((0, 0, 0), 1).rays(*SIZE, pixels)
    pinhole = Pinhole.of(camera, SIZE)
    expected = pinhole.directions().reshape(-1, 3)
    assert np.abs(directions - expected[met]).max() < 1e-6
    from_eye = origins - pinhole.eye
    along = (from_eye * expected[met]).sum(axis=1)
    assert np.abs(from_eye - along[:, None] * expected[met]).max() < 1e-6
    assert along.min() > -1e-6
    _, within = sphere_distance(pinhole.eye, expected)
    ahead = -(expected @ pinhole.eye) + np.sqrt(np.maximum(within, 0)) > 0
    sure = np.abs(within) > 2e-3
    assert np.array_equal(np.isin(np.arange(len(pixels)), met)[sure], ((within > 0) & ahead)[sure])


def test_an_orbit_is_a_way_to_stand():
    eye = 2 * np.array([np.cos(0.5), np.sin(0.5), 0])  # 2 radii away, the bounding sphere's horizon is at 30 degrees
    scene = bob.Scene(bob.implicit(lambda x, y, z: x**2 + y**2 + z**2 - 1, ((-1, -1, -1), (1, 1, 1))))
    eye = scene.center + scene.radius * eye
    orbiting = bob.trace(scene, bob.Camera(np.degrees(0.5), 0, fov=60), size=SIZE)
    standing = bob.trace(scene, bob.Camera(position=eye, fov=60), size=SIZE)
    assert np.abs(orbiting.stack() - standing.stack()).max() < 1e-4


def test_the_sphere_fits_into_the_shorter_side():
    ball = unit_ball("NURBS")
    for fov in (10, 60, 120):
        for size in ((60, 100), (100, 60)):
            seen = bob.trace(ball, bob.Camera(fov=fov), size=size).depth > 0
            assert 58 <= seen.any(axis=0).sum() <= 60
            assert 58 <= seen.any(axis=1).sum() <= 60


def test_zoom_is_a_longer_lens_and_pan_moves_the_camera(tree):
    camera = bob.Camera(fov=50)
    whole = bob.trace(tree, camera, size=(200, 160))
    part = bob.trace(tree, replace(camera, zoom=2), size=(100, 80))
    middle = whole.stack()[:, 50:150, 40:120]
    differ = np.abs(middle - part.stack()).max(axis=0) > 1e-3
    assert differ.mean() < 1e-3
    moved = Pinhole.of(replace(camera, pan=(0.3, -0.2)), SIZE, tree.center, tree.radius)
    target = moved.eye - moved.toward
    panned = bob.trace(tree, replace(camera, pan=(0.3, -0.2)), size=SIZE)
    placed = bob.trace(tree, bob.Camera(position=moved.eye, target=target, fov=50), size=SIZE)
    assert (np.abs(panned.stack() - placed.stack()).max(axis=0) > 1e-3).mean() < 2e-3


def test_a_narrow_view_from_afar_is_orthographic(tree):
    near_enough = bob.trace(tree, bob.Camera(fov=0.1), size=SIZE)
    orthographic = bob.trace(tree, bob.Camera(), size=SIZE)
    assert np.abs(near_enough.gray - orthographic.gray).mean() < 2e-3
    assert np.abs(near_enough.normal - orthographic.normal).mean() < 2e-3


def test_without_a_fov_nothing_is_in_perspective(tree):
    assert bob.Camera(fov=None) == bob.Camera(fov=0) == bob.Camera()
    panned = bob.trace(tree, bob.Camera(pan=(0.5, 0)), size=(64, 64))
    still = bob.trace(tree, bob.Camera(), size=(64, 64))
    differ = np.abs(panned.stack()[:, :, :48] - still.stack()[:, :, 16:]).max(axis=0) > 1e-3  # half a radius: 16 pixels
    assert differ.mean() < 0.01


# ---- Closed forms ----------------------------------------------------------------------------------------


def unit_ball(kind):
    """Return a ball of radius 1 around the origin, of each kind of shape that can be a ball."""
    if kind == "formula":
        return bob.implicit(lambda x, y, z: x**2 + y**2 + z**2 - 1, ((-1, -1, -1), (1, 1, 1)))
    if kind == "NURBS":
        return nurbs_sphere()
    if kind == "tube":  # the length does not matter
        return bob.polyline([(0, 0, -1e-6), (0, 0, 1e-6)], radius=1)
    return bob.Instance(bob.implicit(lambda x, y, z: x**2 + y**2 + 9 * z**2 - 1, ((-1, -1, -1), (1, 1, 1)))).scale(
        (1, 1, 3)
    )


KINDS = ("formula", "NURBS", "tube", "instance")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("camera", CAMERAS + INSIDE, ids=str)
def test_a_ball_is_its_closed_form(kind, camera):
    scene = bob.Scene(unit_ball(kind))
    picture = bob.trace(scene, camera, size=SIZE)
    pinhole = Pinhole.of(camera, SIZE, scene.center, scene.radius)
    directions = pinhole.directions()
    distance, within = sphere_distance(pinhole.eye, directions)
    seen, sure = ~np.isnan(distance), np.abs(within) > 2e-4
    assert np.array_equal((picture.gray > 0)[sure], seen[sure])
    clear = seen & (within > 0.02)
    assert clear.any()
    normal = pinhole.eye + distance[..., None] * directions  # of the unit ball
    normal = np.where((normal * directions).sum(axis=-1, keepdims=True) > 0, -normal, normal)
    # At grazing rays an error across the ray becomes one along it; from 300 radii away, rounding causes 2e-5 of these.
    assert np.abs(picture.depth - pinhole.depth(distance))[clear].max() < 2e-5
    screen = pinhole.on_screen(normal)
    assert screen[clear][:, 2].min() > 0
    assert np.abs(picture.normal - screen[..., :2])[clear].max() < 1e-4
    assert np.abs(picture.gray - pinhole.gray(normal))[clear].max() < 2e-4


@pytest.mark.parametrize("kind", ["mesh", "formula", "NURBS"])
@pytest.mark.parametrize("camera", INSIDE, ids=str)
def test_a_camera_inside_a_box_sees_its_walls(kind, camera):
    half = np.array([1.0, 0.8, 1.2])
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    if kind == "mesh":
        box = bob.Mesh(corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    elif kind == "formula":
        box = bob.sdf.box(2 * half)
    else:
        ends = [0, 0, 1, 1]
        box = bob.Brep([bob.Face(corners[[[a, b], [d, c]]], ends, ends) for a, b, c, d in quads])
    scene = bob.Scene(box)
    picture = bob.trace(scene, camera, size=SIZE)
    pinhole = Pinhole.of(camera, SIZE, scene.center, scene.radius)
    directions = pinhole.directions()
    walls = (np.sign(directions) * half - pinhole.eye) / directions  # (H, W, 3) distances
    distance, axis = walls.min(axis=2), walls.argmin(axis=2)
    normal = -np.sign(directions) * np.eye(3)[axis]
    ordered = np.sort(walls, axis=2)
    flat = ordered[..., 1] - ordered[..., 0] > 1e-3  # not near an edge
    assert (picture.gray >= 0.1 - 1e-6).all()
    assert np.abs(picture.depth - pinhole.depth(distance))[flat].max() < 1e-5
    assert np.abs(picture.normal - pinhole.on_screen(normal)[..., :2])[flat].max() < 1e-5
    assert np.abs(picture.gray - pinhole.gray(normal))[flat].max() < 1e-5


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_behind_the_camera_is_seen(kind):
    """Between two balls, inside the bounds of a ball but outside it, and facing away from everything."""
    ball = unit_ball(kind)
    left, right = bob.Instance(ball) if not isinstance(ball, bob.Instance) else ball, ball
    right = (bob.Instance(right) if not isinstance(right, bob.Instance) else right).scale(2).translate((6, 0, 0))
    scene = bob.Scene([left, right])
    for toward, center, radius in (((1, 0, 0), (6, 0, 0), 2), ((-1, 0, 0), (0, 0, 0), 1)):
        camera = bob.Camera(position=(2.5, 0.1, 0), target=np.array((2.5, 0.1, 0)) + toward, fov=70)
        picture = bob.trace(scene, camera, size=SIZE)
        pinhole = Pinhole.of(camera, SIZE, scene.center, scene.radius)
        distance, within = sphere_distance(pinhole.eye, pinhole.directions(), center, radius)
        sure = np.abs(within) > 2e-3
        assert np.array_equal((picture.gray > 0)[sure], ~np.isnan(distance)[sure])
        clear = (within > 0.05) & ~np.isnan(distance)
        assert np.abs(picture.depth - pinhole.depth(distance))[clear].max() < 1e-4
    away = bob.Camera(position=(-1.5, 0, 0), target=(-9, 0, 0), fov=100)
    assert not bob.trace(scene, away, size=SIZE).gray.any()


def test_a_camera_within_a_formulas_bounds_sees_what_is_before_it():
    """Parallel sheets; those behind the camera are nearer than those in front of it."""
    sheets = bob.implicit(lambda x, y, z: (x + 0.5) * (x + 0.2) * (x - 0.1) * (x - 0.6), ((-1, -1, -1), (1, 1, 1)))
    scene = bob.Scene(sheets)
    for position, toward, wall in (
        (0.15, 1, 0.6),
        (0.05, 1, 0.1),
        (0.05, -1, -0.2),
        (-0.19, -1, -0.2),
        (-0.21, -1, -0.5),
    ):
        camera = bob.Camera(position=(position, 0, 0), target=(position + toward, 0, 0), fov=30)
        depth = bob.trace(scene, camera, size=(20, 20)).depth
        pinhole = Pinhole.of(camera, (20, 20), scene.center, scene.radius)
        distance = (wall - position) / pinhole.directions()[..., 0]
        assert np.abs(depth - pinhole.depth(distance)).max() < 1e-5


def test_where_and_how_large_a_scene_is_does_not_matter(tree):
    camera = bob.Camera(position=(2, 1, 1), target=(0, 0, 0.5), fov=40)
    reference = bob.trace(tree, camera, size=SIZE)
    for scale, offset in ((1e-6, 0), (1e9, 5e9), (1, 300)):
        moved = bob.Scene([each.scale(scale).translate((offset, 0, 0)) for each in tree.instances])
        there = replace(camera, position=np.array(camera.position) * scale + (offset, 0, 0))
        there = replace(there, target=np.array(camera.target) * scale + (offset, 0, 0))
        assert (np.abs(bob.trace(moved, there, size=SIZE).stack() - reference.stack()).max(axis=0) > 1e-3).mean() < 2e-3


# ---- Other tracers ---------------------------------------------------------------------------------------


@needs_models
@pytest.mark.parametrize(
    "file", ["scans/stanford_bunny.ply", "architecture/conference_room.ply", "scans/armadillo.ply"]
)
def test_agrees_with_embree(file):
    """Only rays within rounding of a silhouette may differ: at most 1 in 10,000.

    Depths are within 1e-5 radii, except for faces nearly edge-on.
    """
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    scene = bob.load(MODELS / file)
    mesh = scene.instances[0].shape
    embree = EmbreeScene()
    TriangleMesh(embree, ((mesh.vertices - scene.center) / scene.radius).astype(np.float32), mesh.triangles)
    size = (240, 320)
    pixels = tiled_pixels(size)
    within = scene.center + scene.radius * np.array([0.1, 0.2, 0.1])
    for camera in (
        bob.Camera(fov=35),
        bob.Camera(200, 45, fov=60, roll=10),
        bob.Camera(position=within, target=scene.center, fov=90),
        bob.Camera(position=within, target=within + (1, 0.2, 0.1), fov=120),
    ):
        core = camera.core(scene.center, scene.radius)
        met, origin, direction = core.rays(*size, pixels)
        found = embree.run(origin, direction, output=True)
        samples = SceneTracer(scene, camera, size)(pixels)
        theirs = np.zeros(len(pixels), bool)
        theirs[met] = found["primID"] >= 0
        assert theirs.mean() > 0.02
        assert (samples.hit != theirs).mean() <= 1e-4
        both = samples.hit[met] & theirs[met]
        points = origin + found["tfar"][:, None] * direction
        expected = core.seen(*size, np.ascontiguousarray(points[both], np.float32))[:, 2]
        difference = np.abs(samples.depth[met][both] - expected)
        assert (difference > 1e-5).mean() <= 1e-3
        assert np.median(difference) < 1e-6


# ---- Other uses of pictures ------------------------------------------------------------------------------


@pytest.mark.parametrize("camera", [bob.Camera(fov=35), bob.Camera(position=(1.2, 0.4, 2), target=(0, 0, 1.5), fov=80)])
def test_samples_say_where_their_points_are(tree, camera):
    full = bob.trace(tree, camera, size=SIZE)
    core = camera.core(tree.center, tree.radius)
    row, column = np.nonzero(full.depth > 0)
    at = np.column_stack([row, column, full.depth[row, column]]).astype(np.float32)
    points = tree.center + tree.radius * core.points(*SIZE, at).astype(np.float64)
    pinhole = Pinhole.of(camera, SIZE, tree.center, tree.radius)
    direction = pinhole.directions()[row, column]
    hits = tree.closest_hits(np.broadcast_to(pinhole.eye, direction.shape), direction)
    error = np.linalg.norm(points - (pinhole.eye + hits.distance[:, None] * direction), axis=1) / tree.radius
    assert np.mean(error > 1e-5) < 1e-3  # except rays within rounding of an edge


def test_a_part_is_a_sample_of_the_whole_in_every_order(tree):
    camera = bob.Camera(fov=60)
    full = bob.trace(tree, camera, size=SIZE)
    for order in ("adaptive", "lattice", "uniform"):
        assert bob.trace(tree, camera, size=SIZE, fraction=0.05, order=order) == full.sample(0.05, order=order)


@pytest.mark.parametrize("camera", [bob.Camera(fov=35), bob.Camera(fov=60), bob.Camera(position=(1.2, 0.4, 2), fov=80)])
def test_completion_works_as_in_orthographic_pictures(tree, camera):
    def quality(camera):
        full = bob.trace(tree, camera, size=(192, 256))
        return bob.ssim(bob.complete(full.sample(0.1, order="adaptive")), full.gray)

    assert quality(camera) > quality(bob.Camera()) - 0.03


def test_progressive_pictures_end_exact(tree):
    camera = bob.Camera(position=(2, 1, 1), target=(0, 0, 1), fov=60)
    *_, last = bob.progressive(tree, camera, size=(60, 80), fraction=0.3)
    assert np.array_equal(last.image, bob.trace(tree, camera, size=(60, 80)).gray)


@pytest.mark.parametrize("kind", ["mesh", *KINDS, "several"])
@pytest.mark.parametrize("camera", [bob.Camera(fov=90), *INSIDE[:2]], ids=str)
def test_a_pixel_does_not_depend_on_its_neighbours(kind, camera):
    """Rays of one packet share work."""
    shapes = {
        "mesh": lambda: bob.happy_tree(),
        "several": lambda: [torus(), bob.Instance(torus()).rotate(1.5, (1, 0, 0)), bob.sdf.sphere(0.3)],
        "NURBS": torus,
    }
    scene = bob.Scene(shapes.get(kind, lambda: unit_ball(kind))())
    full = bob.trace(scene, camera, size=SIZE)
    assert full.gray.any()
    pixels = np.random.default_rng(0).integers(0, SIZE, (300, 2)).astype(np.int32)
    samples = SceneTracer(scene, camera, SIZE)(pixels)
    at = pixels[:, 0], pixels[:, 1]
    for name in ("gray", "depth", "normal"):
        assert np.array_equal(getattr(samples, name)[samples.hit], getattr(full, name)[at][samples.hit])
    assert not full.gray[at][~samples.hit].any()


# ---- Errors ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"fov": 190}, r"fov: expected degrees in \[0.1, 175\], or 0, which is orthographic, got 190"),
        ({"fov": -35}, "fov: expected degrees"),
        ({"fov": float("nan")}, "fov: expected a finite number"),
        ({"fov": "wide"}, "fov: expected a number, got str 'wide'"),
        ({"pan": 3}, r"pan: expected shape \(2,\)"),
        ({"pan": (0, float("inf"))}, "pan: expected finite numbers"),
        ({"position": (1, 2, 3)}, "position: expected a fov above 0 with it, such as fov=35"),
        ({"position": (1, 2), "fov": 35}, r"position: expected shape \(3,\), got \(2,\)"),
        ({"position": (1, 2, 3), "target": (1, 2, 3), "fov": 35}, "target: expected another place than the position"),
        ({"position": (1, 2, 3), "azimuth": 0, "fov": 35}, "azimuth: expected none with a position, got 0"),
        ({"position": (1, 2, 3), "elevation": 5, "fov": 35}, "elevation: expected none with a position"),
        ({"target": (1, 2, 3), "fov": 35}, "target: expected none without a position"),
        ({"up": (1, 2, 3)}, "up: expected none without a position"),
        ({"position": (0, 0, 3), "target": (0, 0, 0), "fov": 35}, r"up: .* such as \(0, 1, 0\), got \(0, 0, 1\)"),
        ({"position": (0, 3, 0), "target": (0, 0, 0), "up": (0, 2, 0), "fov": 35}, r"up: .* such as \(0, 0, 1\)"),
        ({"position": (3, 0, 0), "target": (0, 0, 0), "up": (0, 0, 0), "fov": 35}, "up: expected a direction"),
    ],
)
def test_mistakes_are_told_in_one_line(arguments, message):
    with pytest.raises(bob.InputError, match=message) as caught:
        bob.Camera(**arguments)
    assert "\n" not in str(caught.value)


def test_mistakes_that_only_a_scene_shows():
    ball = bob.Scene(unit_ball("formula"))
    for position, message in (
        (
            (*ball.center,),
            "target: expected another place than the position, got .*, the centre of the bounding sphere",
        ),
        ((0, 0, 5), "up: expected a direction across the line of sight"),
        ((1e8, 0, 0), "position: expected at most 1,000,000 radii from the scene, whose bounding sphere has centre"),
    ):
        with pytest.raises(bob.InputError, match=message):
            bob.trace(ball, bob.Camera(position=position, fov=35), size=SIZE)


def test_a_camera_says_what_counts():
    assert str(bob.Camera()) == "Camera(azimuth=30.0, elevation=20.0)"
    camera = bob.Camera(position=np.array((1, 2, 3)), fov=35)
    assert str(camera) == "Camera(fov=35.0, position=(1.0, 2.0, 3.0))"
    assert eval(str(camera), {"Camera": bob.Camera}) == camera
