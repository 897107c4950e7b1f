"""Rays on NURBS: compared with fine meshes in Embree, with geomdl, and with Rhino's meshes of real models."""

import warnings
from itertools import pairwise

import numpy as np
import pytest
from models import MODELS, needs_models
from nurbs_shapes import cylinder, geomdl_surface, random_knots, sphere, torus
from scipy.ndimage import binary_dilation, binary_erosion

import bobrossnet as bob
from bobrossnet.shapes.affine import mapped

NURBS = MODELS / "nurbs"
FILES = sorted(file.name for file in NURBS.glob("*") if file.suffix != ".ply") if NURBS.is_dir() else []
NEEDS = {".3dm": "rhino3dm", ".iges": "OCP"}
WITH_MESHES = ["gear", "mech_part_a", "diner_mug", "rhino_logo", "solid_handle"]


def load(name):
    file = NURBS / name
    if file.suffix in NEEDS:
        pytest.importorskip(NEEDS[file.suffix])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bob.InputWarning)  # trims that a format can't express
        return bob.load(file)


# ---- Rays ------------------------------------------------------------------------------------------------


def unit_rows(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def rays_through(center, radius, seed, count):
    """Return rays from outside a sphere to points in its inner part."""
    rng = np.random.default_rng(seed)
    direction = unit_rows(rng.normal(size=(count, 3)))
    return center + radius * (rng.uniform(-0.6, 0.6, (count, 3)) - 2 * direction), direction


class EmbreeMesh:
    """A mesh in Embree, transformed like the scene's bounding sphere to the unit sphere."""

    def __init__(self, vertices, triangles, scene):
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self.center, self.radius = scene.center, scene.radius
        self.embree = EmbreeScene()
        TriangleMesh(self.embree, self._inside(vertices), np.ascontiguousarray(triangles, np.int32))

    def _inside(self, points):
        return ((points - self.center) / self.radius).astype(np.float32)

    def cast(self, origin, direction):
        """Return distances in radii, infinite for misses, and unit normals of the triangles."""
        found = self.embree.run(self._inside(origin), direction.astype(np.float32), output=True)
        hit = found["primID"] >= 0
        return np.where(hit, found["tfar"], np.inf), unit_rows(np.where(hit[:, None], found["Ng"], 1).astype(float))


def unexplained(scene, mesh, error, origin, direction):
    """Return the share of rays that hit a scene elsewhere than a mesh within `error` radii, and the unexplained ones.

    A difference is unexplained if all rays around it differ too: then no silhouette or edge causes it.
    """
    ours = scene.closest_hits(origin, direction).distance / scene.radius
    theirs, normal = mesh.cast(origin, direction)
    with np.errstate(invalid="ignore"):  # infinite less infinite
        slant = np.abs((normal * direction).sum(axis=1))
        same = (np.abs(ours - theirs) < 1e-5 + 3 * error / np.maximum(slant, 0.05)) | (ours == theirs)
        rest = np.flatnonzero(~same)
        rng = np.random.default_rng(1)
        aside = unit_rows(np.cross(direction[rest].repeat(64, axis=0), rng.normal(size=(64 * len(rest), 3))))
        aside *= rng.uniform(0, 8, (len(aside), 1)) * (error + 1e-6) * scene.radius
        around, _ = mesh.cast(origin[rest].repeat(64, axis=0) + aside, direction[rest].repeat(64, axis=0))
        expected = ours[rest, None]
        close = (np.abs(around.reshape(-1, 64) - expected) < 0.03) | (around.reshape(-1, 64) == expected)
    return len(rest) / len(origin), int((~close.any(axis=1)).sum())


def hits_by_face(scene, hits):
    """Yield the instance, the face, the ray indices, and their u and v, of hits on NURBS faces."""
    for i, instance in enumerate(scene.instances):
        if not isinstance(instance.shape, bob.Brep):
            continue
        on = np.flatnonzero(hits.instance == i)
        for k in np.unique(hits.primitive[on]):
            rays = on[hits.primitive[on] == k]
            face = instance.shape.faces[k]
            u, v = (np.clip(x[rays], *ends) for x, ends in zip((hits.u, hits.v), face.domain, strict=True))
            yield instance, face, rays, u, v


# ---- Random surfaces -------------------------------------------------------------------------------------


def random_surface(seed, weights=10):
    """Return a surface of degrees 1..9, with knots of any multiplicity up to the degree, clamped or not.

    Weights are within 1 / weights to weights, or omitted.
    """
    rng = np.random.default_rng(seed)
    degrees = rng.integers(1, 10, 2)
    n, m = degrees + rng.integers(1, 6, 2)
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, m), indexing="ij")
    points = np.stack([x, y, rng.normal(scale=0.5, size=(n, m))], axis=2) + rng.normal(scale=0.1, size=(n, m, 3))
    rational = weights ** rng.uniform(-1, 1, (n, m)) if rng.random() < 0.5 else None
    return bob.Face(points, random_knots(rng, n, degrees[0]), random_knots(rng, m, degrees[1]), rational)


def tessellated(face, cells=200):
    """Return vertices and triangles of about cells x cells cells between the face's knots, and their error."""
    axes = []
    for knots, (low, high) in zip((face.knots_u, face.knots_v), face.domain, strict=True):
        ends = np.unique(np.clip(knots, low, high))
        steps = 2 * -(-cells // (2 * (len(ends) - 1)))
        axes.append(np.unique(np.concatenate([np.linspace(a, b, 2 * steps + 1) for a, b in pairwise(ends)])))
    fine = face.points(axes[0][:, None], axes[1][None, :])
    points = fine[::2, ::2]
    n, m = points.shape[:2]
    a = (np.arange(n - 1)[:, None] * m + np.arange(m - 1)).reshape(-1)
    triangles = np.concatenate([np.stack([a, a + 1, a + m], 1), np.stack([a + 1, a + m + 1, a + m], 1)])
    halves = [
        (points[1:] + points[:-1]) / 2 - fine[1::2, ::2],
        (points[:, 1:] + points[:, :-1]) / 2 - fine[::2, 1::2],
        (points[1:, :-1] + points[:-1, 1:]) / 2 - fine[1::2, 1::2],
    ]
    return points.reshape(-1, 3), triangles, max(np.linalg.norm(half, axis=2).max() for half in halves)


@pytest.mark.parametrize("seed", range(24))
def test_random_surfaces_agree_with_fine_meshes_in_embree(seed):
    face = random_surface(seed, weights=2)
    scene = bob.Scene(bob.Brep([face]))
    vertices, triangles, error = tessellated(face)
    error /= scene.radius
    assert error < 5e-3
    mesh = EmbreeMesh(vertices, triangles, scene)
    share, wrong = unexplained(scene, mesh, error, *rays_through(scene.center, scene.radius, seed, 4000))
    assert share < 5e-3
    assert wrong == 0


def test_agreement_is_not_for_free():
    """Slightly displaced meshes, or meshes with a hole, are detected."""
    face = random_surface(2)
    scene = bob.Scene(bob.Brep([face]))
    vertices, triangles, error = tessellated(face)
    rays = rays_through(scene.center, scene.radius, 2, 4000)
    moved = EmbreeMesh(vertices + (0, 0, 2e-3), triangles, scene)
    assert unexplained(scene, moved, error / scene.radius, *rays)[0] > 0.1
    holed = EmbreeMesh(vertices, triangles[np.arange(len(triangles)) // 2000 != 20], scene)
    assert unexplained(scene, holed, error / scene.radius, *rays)[1] > 0


def test_edges_of_weights_far_apart_are_where_they_are():
    """Parameters are in float32, so hits may be displaced along the surface, but not off it."""
    points = np.array([[(-1, -1, 0.3), (-1, 1, -0.3)], [(1, -1, -0.3), (1, 1, 0.3)]])
    for ratio in (100, 1000):
        scene = bob.Scene(bob.nurbs_surface(points, [0, 0, 1, 1], [0, 0, 1, 1], [[1, ratio], [ratio, 1]]))
        origin, direction = rays_through(scene.center, scene.radius, 1, 100_000)
        hits = scene.closest_hits(origin, direction)
        for _, face, rays, u, v in hits_by_face(scene, hits):
            off = origin[rays] + hits.distance[rays, None] * direction[rays] - face.points(u, v)
            assert np.abs((off * face.normals(u, v)).sum(axis=1)).max() < 1e-5


@pytest.mark.parametrize("seed", range(12))
def test_hits_are_where_geomdl_says(seed):
    face = random_surface(seed)
    scene = bob.Scene(bob.Brep([face]))
    theirs = geomdl_surface(face)
    origin, direction = rays_through(scene.center, scene.radius, seed, 200)
    hits = scene.closest_hits(origin, direction)
    hit = np.flatnonzero(hits.instance == 0)[:30]
    assert len(hit) > 10
    points = origin[hit] + hits.distance[hit, None] * direction[hit]
    expected = np.array([theirs.evaluate_single((hits.u[i], hits.v[i])) for i in hit])
    assert np.linalg.norm(points - expected, axis=1).max() < 1e-5 * scene.radius


def test_a_face_that_is_a_line_is_not_there():
    line = np.linspace((-0.5, 0.1, 0.2), (0.7, 0.4, -0.3), 6)[:, None] + np.zeros((6, 4, 3))
    knots = [0, 0, 0, 0, 1, 2, 3, 3, 3, 3], [0, 0, 0, 1, 2, 2, 2]
    with pytest.raises(bob.InputError, match="faces: expected at least one face"):
        bob.Scene(bob.nurbs_surface(line, *knots))
    folded = np.sin(np.arange(6)[:, None] + 2 * np.arange(4))[..., None] * (1.2, 0.3, -0.5)
    both = bob.Brep([bob.Face(folded, *knots), *cylinder().faces])
    assert both.core.pieces < 1000


# ---- Closed shapes ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [sphere, torus, cylinder], ids=["sphere", "torus", "cylinder"])
def test_closed_shapes_leak_no_rays(make):
    rng = np.random.default_rng(5)
    n = 50_000
    direction = unit_rows(rng.normal(size=(n, 3)))
    angle, across = rng.uniform(0, 2 * np.pi, (2, n))
    r, z = {
        sphere: (0.999 * np.sin(across), 0.999 * np.cos(across)),
        torus: (0.7 + 0.2499 * np.cos(across), 0.2499 * np.sin(across)),
        cylinder: (0.6999 * np.sin(across), -0.1 + 0.4999 * np.cos(angle)),
    }[make]
    inside = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)
    hits = bob.Scene(make()).closest_hits(inside - 5 * direction, direction)
    assert (hits.distance < 5).all()


@needs_models
def test_the_teapot_s_body_leaks_no_rays():
    """From the sides and from below: there is a gap between its lid and its rim."""
    scene = load("newell_teapot.bpt")
    (brep,) = (instance.shape for instance in scene.instances)
    low, high = brep.bounding_box(np.eye(4))
    rng = np.random.default_rng(6)
    n = 50_000
    height = high[2] - low[2]
    inside = np.array([0, 0, low[2]]) + height * rng.uniform((-0.2, -0.2, 0.15), (0.2, 0.2, 0.5), (n, 3))
    direction = unit_rows(rng.normal(size=(n, 3)))
    direction[:, 2] = np.abs(direction[:, 2])
    hits = scene.closest_hits(inside - 3 * scene.radius * direction, direction)
    assert (hits.distance < 3 * scene.radius).all()


# ---- Real models -----------------------------------------------------------------------------------------


@needs_models
@pytest.mark.parametrize("name", FILES)
def test_hits_on_real_models_lie_on_their_faces(name):
    scene = load(name)
    picture = bob.trace(scene, size=(48, 48))
    assert picture.depth.any()
    origin, direction = rays_through(scene.center, scene.radius, 3, 3000)
    hits = scene.closest_hits(origin, direction)
    assert (hits.instance >= 0).mean() > 0.03
    for instance, face, rays, u, v in hits_by_face(scene, hits):
        points = origin[rays] + hits.distance[rays, None] * direction[rays]
        off = mapped(instance.transform, face.points(u, v)) - points
        assert np.linalg.norm(off, axis=1).max() < 1e-5 * scene.radius


def disc(radius):
    reach = np.arange(-int(radius), int(radius) + 1)
    return np.hypot(reach[:, None], reach[None, :]) <= radius


@needs_models
@pytest.mark.parametrize("name", WITH_MESHES)
def test_real_models_agree_with_their_render_meshes(name):
    """Rhino's meshes of these files are coarse: their depths, normals and silhouettes are close.

    They bridge gaps of 1e-3 radii between the trims of mech_part_a's faces.
    """
    scene = load(f"{name}.3dm")
    rendered = bob.load_mesh(NURBS / f"{name}.rendermesh.ply")
    mesh = EmbreeMesh(rendered.vertices, rendered.triangles, scene)
    share, wrong = unexplained(scene, mesh, 1e-3, *rays_through(scene.center, scene.radius, 1, 20_000))
    assert share < 3e-3
    assert wrong <= (20 if name == "mech_part_a" else 0)

    size = 512
    forward = unit_rows(np.array([[-0.6, 0.5, -0.45]]))[0]
    right = unit_rows(np.cross(forward, [(0, 0, 1)]))[0]
    up = np.cross(right, forward)
    x, y = np.meshgrid(*2 * [(np.arange(size) + 0.5) / size * 2 - 1])
    origin = scene.center + scene.radius * (x.reshape(-1, 1) * right + y.reshape(-1, 1) * up - 2 * forward)
    direction = np.tile(forward, (size * size, 1))
    hits = scene.closest_hits(origin, direction)
    ours = hits.distance / scene.radius
    theirs, normals = mesh.cast(origin, direction)
    both = np.isfinite(ours) & np.isfinite(theirs)
    assert both.mean() > 0.1
    assert np.median(np.abs(ours[both] - theirs[both])) < 1e-3
    cosines = []
    for instance, face, rays, u, v in hits_by_face(scene, hits):
        few = both[rays] & (rays % 17 == 0)
        normal = unit_rows(face.normals(u[few], v[few]) @ np.linalg.inv(instance.transform[:3, :3]))
        cosines.extend(np.abs((normal * normals[rays[few]]).sum(axis=1)))
    assert np.median(cosines) > np.cos(np.radians(3))
    seen, expected = (np.isfinite(t).reshape(size, size) for t in (ours, theirs))
    near = disc(1.5)
    for inner, outer in ((seen, expected), (expected, seen)):
        assert (binary_erosion(inner, near) & ~outer).sum() <= 3
        assert (inner & ~binary_dilation(outer, near)).sum() <= 3
