"""Implicit surfaces from the user's view, against closed forms and against samples of f in float64."""

import pickle
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from clocks import least
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from models import MODELS, needs_models
from thread_counts import with_threads

import bobrossnet as bob
from bobrossnet import _core, sdf
from bobrossnet.adapters.container import layout, sealed
from bobrossnet.sdf import X, Y, Z

SIZE = (90, 120)
CUBE = ((-1, -1, -1), (1, 1, 1))


# ---- Closed formulas -------------------------------------------------------------------------------------
#
# Convex solids are intersections of slabs, balls and cylinders. Each part returns where lines enter and leave it, and
# its normals there; `origin` and `direction` are (n, 3) float64, directions of unit length.


def dot(a, b):
    return (a * b).sum(axis=-1)


def scaled_by(t, a):
    return t[:, None] * a


def slab(axis, low, high):
    """Return the part between two planes."""
    axis = np.asarray(axis, float)

    def part(origin, direction):
        along, height = direction @ axis, origin @ axis
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.stack([(low - height) / along, (high - height) / along])
        normals = scaled_by(np.sign(along), np.broadcast_to(axis, origin.shape))
        return t.min(axis=0), t.max(axis=0), -normals, normals

    return part


def round_part(radius, axis=(0, 0, 0)):
    """Return a ball, or with an axis the cylinder about it."""
    across = np.eye(3) - np.outer(axis, axis)

    def part(origin, direction):
        o, d = origin @ across, direction @ across
        a, b = dot(d, d), dot(o, d)
        nearest = o - scaled_by(b / a, d)
        with np.errstate(invalid="ignore"):
            root = np.sqrt((radius**2 - dot(nearest, nearest)) / a)
        low, high = -b / a - root, -b / a + root
        into, out = ((o + scaled_by(t, d)) / radius for t in (low, high))
        beside = np.isnan(root)  # never entered, or left long ago
        return np.where(beside, np.inf, low), np.where(beside, -np.inf, high), into, out

    return part


def convex(*parts):
    def solid(origin, direction):
        enter, leave = np.full(len(origin), -np.inf), np.full(len(origin), np.inf)
        normal_in, normal_out = np.zeros_like(origin), np.zeros_like(origin)
        for part in parts:
            low, high, into, out = part(origin, direction)
            later, sooner = low > enter, high < leave
            enter, normal_in = np.where(later, low, enter), np.where(later[:, None], into, normal_in)
            leave, normal_out = np.where(sooner, high, leave), np.where(sooner[:, None], out, normal_out)
        outside = enter > 0
        t = np.where(outside, enter, leave)
        hit = (enter < leave) & (t > 0)
        return np.where(hit, t, np.inf), np.where(outside[:, None], normal_in, normal_out)

    return solid


def ring(r1, r2):
    """Return a torus about z: the roots of its quartic are the eigenvalues of a companion matrix."""

    def solid(origin, direction):
        near = -dot(origin, direction)
        o = origin + scaled_by(near, direction)  # from the line's point nearest the centre, to avoid cancellation
        c, flat_o, flat_d = dot(o, o) + r1**2 - r2**2, o * (1, 1, 0), direction * (1, 1, 0)
        # |p|^2 = t^2 + |o|^2 on the line, and (|p|^2 + r1^2 - r2^2)^2 = 4 r1^2 (x^2 + y^2) on the torus.
        quartic = [
            np.zeros(len(o)),
            2 * c - 4 * r1**2 * dot(flat_d, flat_d),
            -8 * r1**2 * dot(flat_o, flat_d),
            c**2 - 4 * r1**2 * dot(flat_o, flat_o),
        ]
        companion = np.zeros((len(o), 4, 4))
        companion[:, (1, 2, 3), (0, 1, 2)] = 1
        companion[:, 0] = -np.stack(quartic, axis=1)
        roots = np.linalg.eigvals(companion)
        t = roots.real + near[:, None]
        t[(np.abs(roots.imag) > 1e-9) | (t <= 0)] = np.inf
        t = t.min(axis=1)
        with np.errstate(invalid="ignore"):
            p = origin + scaled_by(t, direction)
            spine = p * (1, 1, 0)
            normal = (p - r1 * spine / np.linalg.norm(spine, axis=1, keepdims=True)) / r2
        return t, normal

    return solid


CUT = np.array((1, 2, 2)) / 3

SOLIDS = {
    "sphere": (sdf.sphere(1), convex(round_part(1))),
    "box": (
        sdf.box((1, 1.4, 0.6)),
        convex(slab((1, 0, 0), -0.5, 0.5), slab((0, 1, 0), -0.7, 0.7), slab((0, 0, 1), -0.3, 0.3)),
    ),
    "torus": (sdf.torus(0.7, 0.25), ring(0.7, 0.25)),
    "cylinder": (
        sdf.capped_cylinder(-0.6 * Z, 0.4 * Z, 0.7),
        convex(round_part(0.7, (0, 0, 1)), slab((0, 0, 1), -0.6, 0.4)),
    ),
    "sphere cut by a plane": (
        sdf.sphere(1) & sdf.plane(-CUT, CUT * 0.3),
        convex(round_part(1), slab(CUT, -np.inf, 0.3)),
    ),
    "sphere of a polynomial": (
        bob.implicit(lambda x, y, z: (x * x + y * y + z * z) ** 2 - 1, bounds=((-1.5,) * 3, (1.5,) * 3)),
        convex(round_part(1)),
    ),
    "sphere between two planes": (
        bob.implicit(lambda x, y, z: np.sqrt(x * x + y * y + z * z) - 1, bounds=((-2, -2, -0.5), (2, 2, 0.2))),
        convex(round_part(1), slab((0, 0, 1), -0.5, 0.2)),
    ),
}


def clear_of_edges(solid, origin, direction, distance):
    """Return the rays with the same view `distance` away on four sides: no silhouette and no edge is near."""
    t, normal = solid(origin, direction)
    one = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction), axis=1)])
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    clear = np.ones(len(origin), bool)
    for side in (one, -one, np.cross(one, direction), -np.cross(one, direction)):
        beside, normal_beside = solid(origin + distance * side, direction)
        clear &= np.isfinite(beside) == np.isfinite(t)
        with np.errstate(invalid="ignore"):
            clear &= ~np.isfinite(t) | (np.abs(normal_beside - normal).max(axis=1) < 0.05)
    return clear


def pixel_rays(scene, camera, size):
    """Return origins on the plane in front of the sphere, directions and screen axes: docs/reference/camera.md."""
    height, width = size
    azimuth, elevation, roll = np.radians([camera.azimuth, camera.elevation, camera.roll])
    toward = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0])
    up = np.cross(toward, right)
    right, up = np.cos(roll) * right + np.sin(roll) * up, np.cos(roll) * up - np.sin(roll) * right
    pixel = 2 * scene.radius / camera.zoom / min(size)
    row, column = np.mgrid[:height, :width].reshape(2, -1, 1) + 0.5
    origin = scene.center + scene.radius * toward
    origin = origin + (column - width / 2) * pixel * right + (height / 2 - row) * pixel * up
    return origin, np.broadcast_to(-toward, origin.shape), right, up


@pytest.mark.parametrize("name", SOLIDS)
@pytest.mark.parametrize("camera", [bob.Camera(), bob.Camera(200, -55, 30, 1.3), bob.Camera(0, 0), bob.Camera(90, 90)])
def test_pictures_are_the_closed_formula_s(name, camera):
    """Equal hits away from edges and silhouettes.

    Depths are within 2e-6 radii and normals within 1e-5, both divided by the cosine of incidence.
    """
    shape, solid = SOLIDS[name]
    scene = bob.Scene(shape)
    picture = bob.trace(scene, camera, size=(120, 160))
    origin, direction, right, up = pixel_rays(scene, camera, (120, 160))
    t, normal = solid(origin, direction)
    clear = clear_of_edges(solid, origin, direction, 1e-5)
    hit = picture.depth.reshape(-1) > 0
    assert clear.mean() > 0.98
    assert 0.03 < hit.mean() < 0.9
    assert np.array_equal(hit[clear], np.isfinite(t)[clear])
    both = clear & hit
    cosine = -dot(normal, direction)[both]
    assert cosine.min() > 0
    depth = 1 - t[both] / (2 * scene.radius)
    assert (np.abs(picture.depth.reshape(-1)[both] - depth) * cosine).max() < 2e-6
    on_screen = np.stack([normal @ right, normal @ up], axis=1)[both]
    assert (np.abs(picture.normal.reshape(-1, 2)[both] - on_screen).max(axis=1) * cosine).max() < 1e-5


CONCAVE = "polygon([(-1, -1), (1, -0.7), (0, 0), (0.9, 1.2)])"


@pytest.mark.parametrize(
    "script",
    [
        CONCAVE + ".extrude(1)",
        CONCAVE + ".translate((1.2, 0)).revolve()",
        "hexagon(1).extrude(1)",
        "sphere(1) - box(1)",
        "(box(1) | sphere(0.6)).k(0.1)",
        "sphere(1).repeat(1.5, (1, 1, 0))",
        "box(1).bend_linear(-Z, Z, X)",
        "torus(1, 0.3).shell(0.01)",
        "capped_cone(-Z, Z, 1, 0.3).twist(1) & sphere(2)",
        "pyramid(1)",
    ],
)
def test_normals_are_gradients(script):
    """Normals from differences of f in float64, slightly before the hit, except along edges."""
    shape, camera = evaluated(script), bob.Camera()
    check_normals(shape, camera, 1e-3)


def check_normals(shape, camera, edges):
    """`edges` is the tolerated share of hits so near an edge that its faces are confused."""
    scene = bob.Scene(shape)
    picture = bob.trace(scene, camera, size=(60, 80))
    origin, direction, right, up = pixel_rays(scene, camera, (60, 80))
    hit = picture.depth.reshape(-1) > 0
    t = 2 * scene.radius * (1 - picture.depth.reshape(-1)[hit].astype(float))
    before = origin[hit] + scaled_by(t - 1e-4 * scene.radius, direction[hit])
    step = 1e-6 * scene.radius * np.eye(3)
    gradient = np.stack([shape.expression(before + d) - shape.expression(before - d) for d in step], axis=1)
    normal = gradient / np.linalg.norm(gradient, axis=1, keepdims=True)
    normal *= -np.sign(dot(normal, direction[hit]))[:, None]
    on_screen = np.stack([normal @ right, normal @ up], axis=1)
    difference = np.abs(picture.normal.reshape(-1, 2)[hit] - on_screen).max(axis=1)
    assert (difference > 0.02).mean() < edges


def evaluated(script):
    return eval(script, {name: getattr(sdf, name) for name in sdf.__all__})


def random_rays(rng, count):
    """Return rays around the unit sphere: from outside, inside and afar, towards it and away, of any length."""
    direction = rng.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    back = rng.choice([0.0, 0.3, 2.0, -2.0, 50.0], size=(count, 1))
    origin = rng.uniform(-0.8, 0.8, (count, 3)) - back * direction
    return origin, direction, 10.0 ** rng.uniform(-6, 6, (count, 1))


@pytest.mark.parametrize("name", ["sphere", "box", "torus", "cylinder", "sphere cut by a plane"])
@pytest.mark.parametrize(
    ("unit", "center"),
    [
        (1, (0, 0, 0)),
        (1e-3, (0, 0, 0)),
        (1e6, (0, 0, 0)),
        (1e-3, (6, -5, 3)),
        (1, (1e4, 0, -1e3)),
        (1e4, (0, 8e7, 9e6)),
    ],
)
def test_rays_meet_what_the_closed_formula_says(name, unit, center):
    """Distances within 3e-6 radii divided by the cosine, for any unit and any origin."""
    shape, solid = SOLIDS[name]
    placed = shape.scale(unit).translate(center)
    origin, direction, length = random_rays(np.random.default_rng(5), 4000)
    distance, instance, *_ = bob.Scene(placed).closest_hits(origin * unit + center, direction * length)
    t, normal = solid(origin, direction)
    clear = clear_of_edges(solid, origin, direction, 2e-5) & ~(t < 1e-5)  # nor where it starts on the surface
    assert clear.mean() > 0.99
    hit = np.isfinite(distance)
    assert np.array_equal(hit, instance == 0)
    assert np.array_equal(hit[clear], np.isfinite(t)[clear])
    both = clear & hit
    assert 0.2 < both.mean() < 0.8
    rounding = 4e-16 * np.abs(origin * unit + center).max() / unit  # of the placed origin
    error = np.abs(distance[both] / unit - t[both]) * np.abs(dot(normal[both], direction[both]))
    assert error.max() < 3e-6 + rounding


# ---- Completeness of roots -------------------------------------------------------------------------------

SAMPLES = 1000
RAYS = 40


class Sampled:
    """f along rays, densely evaluated in float64."""

    def __init__(self, shape, scene):
        low, high = (np.full(3, -np.inf), np.full(3, np.inf)) if shape.bounds is None else shape.bounds
        self.box, self.f, self.radius = (low, high), shape.expression, scene.radius

    def inside(self, points):
        """Return whether f < 0 beyond float64 rounding, inside the box; (...) bool of (..., 3)."""
        flat = points.reshape(-1, 3)
        with np.errstate(all="ignore"):
            negative = self.f(flat) < -1e-14
        return (negative & (flat > self.box[0]).all(axis=1) & (flat < self.box[1]).all(axis=1)).reshape(
            points.shape[:-1]
        )

    def touches(self, points, reach):
        """Return whether the surface is within `reach` of the points along an axis; float32 may take either side."""
        shifts = np.concatenate([np.eye(3), -np.eye(3)]) * reach
        around = self.inside(points[..., None, :] + shifts)
        return (around != self.inside(points)[..., None]).any(axis=-1)


def check_sureness(shape, seed, rays=RAYS, rounding=3e-6):
    """Check for no sign change before a hit, one at it, and none on rays that miss.

    `rounding` is the displacement of the surface, in radii, that float32 may cause. Thinner walls are ignored.
    """
    scene = bob.Scene(shape)
    sampled, radius = Sampled(shape, scene), scene.radius
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=(rays, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    origin = scene.center + radius * (rng.uniform(-0.6, 0.6, (rays, 3)) - rng.choice([0, 1.5], (rays, 1)) * direction)
    distance = scene.closest_hits(origin, direction).distance
    hit = np.isfinite(distance)

    end = np.where(hit, distance - 3e-5 * radius, 3.5 * radius)
    share = (np.arange(SAMPLES) + rng.random((rays, SAMPLES))) / SAMPLES
    t = np.maximum(end, 0)[:, None] * share
    points = origin[:, None] + t[..., None] * direction[:, None]
    inside = sampled.inside(points)
    crossed = inside != sampled.inside(origin)[:, None]
    for ray in np.flatnonzero(crossed.any(axis=1)):
        seen = sampled.touches(points[ray][crossed[ray]], rounding * radius)
        starts_on_it = sampled.touches(origin[ray], rounding * radius)
        where = f"{origin[ray]} {direction[ray]}, hit at {distance[ray]}"
        assert seen.all() or starts_on_it, f"ray {where}: f changes its sign before that"

    at = origin[hit] + scaled_by(distance[hit], direction[hit])
    step = 1e-5 * radius * direction[hit]
    changes = sampled.inside(at - step) != sampled.inside(at + step)
    grazes = ~changes
    grazes[grazes] = sampled.touches(at[grazes], rounding * radius)
    assert (changes | grazes).all(), f"rays {origin[hit][~(changes | grazes)]} hit where f keeps its sign"
    return hit.mean()


def numbers(low, high):
    return st.floats(low, high).map(lambda x: round(x, 3))


def call(name, *arguments):
    return st.tuples(*arguments).map(lambda values: f"{name}({', '.join(map(str, values))})")


SIZES = numbers(0.2, 1)
VECTORS = st.tuples(*[numbers(-1, 1)] * 3)
AXES = st.sampled_from(["X", "Y", "Z", "(1, 1, 0)", "(1, -2, 3)"])
PRIMITIVES = st.one_of(
    call("sphere", SIZES),
    call("box", SIZES),
    call("box", st.tuples(SIZES, SIZES, SIZES)),
    call("rounded_box", st.just(1), numbers(0.05, 0.4)),
    call("wireframe_box", SIZES, numbers(0.02, 0.2)),
    call("torus", SIZES, numbers(0.03, 0.2)),
    call("capsule", VECTORS, st.just((0, 0, 2)), SIZES),
    call("capped_cylinder", st.just("-X"), st.just("Y"), SIZES),
    call("rounded_cylinder", SIZES, st.just(0.1), SIZES),
    call("capped_cone", st.just("-Z"), st.just("Z"), SIZES, numbers(0, 1)),
    call("rounded_cone", SIZES, SIZES, numbers(1, 2)),
    call("ellipsoid", st.tuples(SIZES, SIZES, SIZES)),
    call("pyramid", SIZES),
    call("tetrahedron", SIZES),
    call("octahedron", SIZES),
    call("dodecahedron", SIZES),
    call("icosahedron", SIZES),
    st.tuples(SIZES, numbers(0.2, 1)).map(lambda p: f"hexagon({p[0]}).extrude({p[1]})"),
    numbers(0.3, 1).map(lambda r: f"(rounded_x({r}, 0.1) & d2.circle(1)).revolve(0.7)"),
    st.lists(st.tuples(numbers(0, 1), numbers(0, 1)), min_size=3, max_size=6, unique=True)
    .filter(lambda corners: np.ptp(corners, axis=0).min() > 0.1)
    .map(lambda corners: f"(polygon({corners}) & d2.circle(1.5)).extrude(0.8)"),
)


def operations(shapes):
    one = [
        VECTORS.map(lambda v: f".translate({v})"),
        st.tuples(numbers(-3, 3), AXES).map(lambda v: f".rotate({v[0]}, {v[1]})"),
        numbers(0.3, 3).map(lambda s: f".scale({s})"),
        st.just(".scale((1, 2, 0.5))"),
        st.sampled_from([".shell(0.001)", ".shell(0.002)", ".shell(0.05)"]),
        numbers(0, 0.2).map(lambda r: f".dilate({r})"),
        numbers(0.01, 0.1).map(lambda r: f".erode({r})"),
        st.just(".elongate((0.2, 0.1, 0))"),
        numbers(-2, 2).map(lambda k: f".twist({k})"),
        numbers(-0.5, 0.5).map(lambda k: f".bend({k})"),
        st.integers(2, 7).map(lambda n: f".circular_array({n}, 1)"),
        st.just(".repeat(1.5, (1, 1, 0))"),
        AXES.map(lambda axis: f".orient({axis})"),
        st.just(".bend_linear(-Z, Z, X, ease.in_out_quad)"),
    ]
    changed = st.tuples(shapes, st.one_of(*one)).map(lambda p: f"({p[0]}){p[1]}")
    joined = st.tuples(shapes, st.sampled_from("|&-"), shapes, st.sampled_from(["", ".k(0.1)", ".k(0.3)"])).map(
        lambda p: f"({p[0]}) {p[1]} ({p[2]}){p[3]}"
    )
    return st.one_of(changed, joined)


SCRIPTS = st.recursive(PRIMITIVES, operations, max_leaves=4)


def traceable(make):
    """Return the shape, or None if it has no surface or no bounds; other tests cover these."""
    try:
        shape = make()
        bob.Scene(shape)
    except bob.InputError:
        return None
    return shape


steady = settings(
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)


@settings(steady, max_examples=120)
@given(SCRIPTS)
def test_no_ray_passes_through_what_scripts_make(script):
    shape = traceable(lambda: evaluated(script))
    if shape is not None:
        check_sureness(shape, 7)


TERMS = st.one_of(
    st.sampled_from(["x", "y", "z", "x*x", "z*z", "x**3", "x*y", "y*z", "x**4 + y**4 + z**4", "x*x + y*y + z*z"]),
    st.tuples(
        st.sampled_from(["sin", "cos", "tanh", "exp", "abs", "arctan"]), numbers(0.5, 6), st.sampled_from("xyz")
    ).map(lambda p: f"np.{p[0]}({p[1]} * {p[2]})"),
    numbers(-1.5, 1.5).map(str),
)


def combinations(terms):
    return st.one_of(
        st.tuples(terms, st.sampled_from("+-*"), terms).map(lambda p: f"({p[0]}) {p[1]} ({p[2]})"),
        st.tuples(st.sampled_from(["np.minimum", "np.maximum", "np.hypot", "np.arctan2"]), terms, terms).map(
            lambda p: f"{p[0]}({p[1]}, {p[2]})"
        ),
        st.tuples(terms, terms, terms).map(lambda p: f"np.where({p[0]} < 0, {p[1]}, {p[2]})"),
        terms.map(lambda t: f"np.sqrt(0.01 + ({t}) ** 2)"),
        terms.map(lambda t: f"abs({t}) - 0.001"),
    )


FORMULAS = st.recursive(TERMS, combinations, max_leaves=6)


@settings(steady, max_examples=150)
@given(FORMULAS)
def test_no_ray_passes_through_what_formulas_make(formula):
    function = eval(f"lambda x, y, z: {formula} + 0 * x", {"np": np})
    shape = traceable(lambda: bob.implicit(function, bounds=((-1.5, -1, -1), (1.5, 1, 1.2))))
    if shape is not None:
        check_sureness(shape, 7)


@pytest.mark.parametrize(
    "script",
    [
        "sphere(1).shell(0.001)",
        "box(1).shell(0.001).rotate(0.4, (1, 2, 3))",
        "torus(1, 0.3).shell(0.001) - box(0.7)",
        "(sphere(1) & box(1.5)).shell(0.001).twist(0.2)",
        "polygon([(-1, -1), (1, -0.7), (0.9, 1.2)]).extrude(1)",
        CONCAVE + ".extrude(1)",
        CONCAVE + ".translate((1.2, 0)).revolve()",
    ],
)
def test_no_ray_passes_through_thin_shells_and_sharp_outlines(script):
    assert check_sureness(evaluated(script), 3, rays=300) > 0.3


# ---- Where formulas have no value ------------------------------------------------------------------------


def hits(shape, origin, direction):
    """Return the coordinate of a ray's hit on `direction`'s axis, or None for a miss."""
    distance = bob.Scene(shape).closest_hits([origin], [direction]).distance[0]
    axis = np.argmax(np.abs(direction))
    return None if np.isinf(distance) else pytest.approx(origin[axis] + distance * np.sign(direction[axis]), abs=1e-5)


@pytest.mark.parametrize(
    ("formula", "from_right", "from_left"),
    [
        # Along x through the centre of the cube from -1 to 1. Where f changes from NaN, there is no surface.
        (lambda x, y, z: np.sqrt(x) - 0.5, 0.25, 0.25),
        (lambda x, y, z: np.log(x + 0.5), 0.5, 0.5),
        (lambda x, y, z: 1 / x, -1, -1),  # nor at the pole at 0: the cube's end is visible through it
        (lambda x, y, z: 1 / x - 2, 1, -1),
        (lambda x, y, z: -1 / x, 1, 1),
        (lambda x, y, z: np.where(x > 0, np.sqrt(x), 0) + y * y + z * z - 0.5, 0.25, -1),
        (lambda x, y, z: np.where(x > 0, np.log(x), -1), 1, -1),
        (lambda x, y, z: np.where(np.sqrt(x) - 2 < 0, x * x + y * y + z * z - 0.25, 1), 0.5, 0.5),
        (lambda x, y, z: np.maximum(np.sqrt(x), 0.5) - 0.7, 0.49, 0.49),
        (lambda x, y, z: np.minimum(x * x - 0.25, np.inf), 0.5, -0.5),
        (lambda x, y, z: np.maximum(x * x - 0.25, -np.inf), 0.5, -0.5),
        (lambda x, y, z: np.exp(1000 * x) - 1, 0, -1),
        (lambda x, y, z: np.arcsin(3 * x) - 0.5, np.sin(0.5) / 3, np.sin(0.5) / 3),
        (lambda x, y, z: np.sqrt(x - 0.2) * 0 - 0.5, 1, 1),
        (lambda x, y, z: np.tan(2 * x), 1, 0),
    ],
)
def test_no_value_is_no_surface(formula, from_right, from_left):
    shape = bob.implicit(formula, bounds=CUBE)
    assert hits(shape, (3, 0.001, 0.002), (-1, 0, 0)) == from_right
    assert hits(shape, (-3, 0.001, 0.002), (1, 0, 0)) == from_left
    bob.trace(shape, size=(40, 40))


@pytest.mark.parametrize(
    "formula",
    [
        lambda x, y, z: np.sqrt(-1 - x * x),
        lambda x, y, z: x * 0 + np.nan,
        lambda x, y, z: x * 0 + np.inf,
        lambda x, y, z: np.log(-1 - x * x) - np.inf,
    ],
)
def test_formulas_without_values_are_refused(formula):
    with np.errstate(all="ignore"), pytest.raises(bob.InputError) as error:
        bob.Scene(bob.implicit(formula, bounds=CUBE))
    assert "\n" not in str(error.value)


@settings(steady, max_examples=60)
@given(
    st.recursive(
        TERMS,
        lambda terms: st.one_of(
            combinations(terms),
            st.tuples(st.sampled_from(["np.sqrt", "np.log", "1 / ", "np.arcsin", "np.tan", "np.exp"]), terms).map(
                lambda p: f"{p[0]}({p[1]})"
            ),
            st.tuples(st.sampled_from(["np.minimum", "np.maximum"]), terms, st.sampled_from(["np.inf", "-np.inf"])).map(
                lambda p: f"{p[0]}({p[1]}, {p[2]})"
            ),
        ),
        max_leaves=5,
    )
)
def test_wild_formulas_are_traced_or_refused(formula):
    """For any formula: hits lie in the box, and normals point at the viewer."""
    with np.errstate(all="ignore"):
        shape = traceable(lambda: bob.implicit(eval(f"lambda x, y, z: {formula} + 0 * x", {"np": np}), bounds=CUBE))
    if shape is None:
        return
    picture = bob.trace(shape, size=(15, 20))
    assert np.isfinite(picture.stack()).all()
    assert (np.linalg.norm(picture.normal, axis=2) <= 1 + 1e-6).all()
    origin, direction, _ = random_rays(np.random.default_rng(1), 200)
    distance = bob.Scene(shape).closest_hits(origin, direction).distance
    hit = np.isfinite(distance)
    assert np.abs(origin[hit] + scaled_by(distance[hit], direction[hit])).max(initial=0) < 1 + 1e-5


# ---- Bounds ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("shape", "low", "high"),
    [
        (sdf.sphere(1), (-1, -1, -1), (1, 1, 1)),
        (sdf.sphere(1e-3, (0.2, 0, -0.1)), (0.199, -0.001, -0.101), (0.201, 0.001, -0.099)),
        (sdf.sphere(3e6, (5e6, 0, 0)), (2e6, -3e6, -3e6), (8e6, 3e6, 3e6)),
        (sdf.box((1, 2, 3)), (-0.5, -1, -1.5), (0.5, 1, 1.5)),
        (sdf.box((8, 0.5, 0.1)).translate((7, 0, 0)), (3, -0.25, -0.05), (11, 0.25, 0.05)),
        (sdf.torus(2, 0.3), (-2.3, -2.3, -0.3), (2.3, 2.3, 0.3)),
        (sdf.box(1).rotate(np.pi / 4), (-(0.5**0.5), -(0.5**0.5), -0.5), (0.5**0.5, 0.5**0.5, 0.5)),
        (sdf.sphere(1) | sdf.sphere(0.1, (10, 0, 0)), (-1, -1, -1), (10.1, 1, 1)),
        (sdf.sphere(1) & sdf.plane(Z), (-1, -1, 0), (1, 1, 1)),
        (sdf.capsule(-X, 2 * Y, 0.2), (-1.2, -0.2, -0.2), (0.2, 2.2, 0.2)),
        (bob.implicit(lambda x, y, z: x**2 / 4 + y**2 + z**2 / 9 - 1), (-2, -1, -3), (2, 1, 3)),
        (bob.implicit(lambda x, y, z: np.exp(x * x + y * y + z * z) - np.e), (-1, -1, -1), (1, 1, 1)),
        (sdf.sphere(1).shell(0.001), (-1.0005,) * 3, (1.0005,) * 3),
    ],
)
def test_bounds_and_sphere_hug_the_surface(shape, low, high):
    """The derived box contains the surface, with a margin of at most 1.5 % of the size; likewise the sphere."""
    low, high = np.array(low, float), np.array(high, float)
    size = (high - low).max()
    found_low, found_high = shape.bounding_box(np.eye(4))
    assert (found_low <= low + 1e-6 * size).all()
    assert (found_high >= high - 1e-6 * size).all()
    assert max((low - found_low).max(), (found_high - high).max()) < 0.015 * size


def test_radii_are_of_the_surface_and_not_of_its_box():
    for shape, radius in (
        (sdf.sphere(1), 1),
        (sdf.torus(1, 0.25), 1.25),
        (sdf.box((1, 2, 3)), np.sqrt(14) / 2),
        (sdf.octahedron(2), 2),
        (sdf.capped_cylinder(-Z, Z, 0.5), np.sqrt(1.25)),
        (sdf.sphere(1e6, (3e6, 0, 0)), 1e6),
    ):
        assert radius * (1 - 1e-6) <= bob.Scene(shape).radius <= radius * 1.025


def test_placed_bounds_are_those_of_the_placed_surface():
    placed = bob.Instance(sdf.sphere(1)).scale((1, 2, 3)).rotate(np.pi / 2, X).translate((0, 0, 10))
    low, high = placed.shape.bounding_box(placed.transform)
    assert low == pytest.approx((-1, -3, 8), abs=0.05)
    assert high == pytest.approx((1, 3, 12), abs=0.05)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: sdf.plane(), "shape: expected an expression that is bounded"),
        (lambda: sdf.cylinder(1), "shape: expected an expression that is bounded"),
        (lambda: sdf.slab(z0=-1, z1=1), "shape: expected an expression that is bounded"),
        (lambda: sdf.sphere(1).negate(), "shape: expected an expression that is bounded"),
        (lambda: sdf.sphere(1).repeat(3), "shape: expected an expression that is bounded"),
        (
            lambda: bob.implicit(lambda x, y, z: np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)),
            "shape: expected an expression that is bounded",
        ),
        (lambda: bob.implicit(lambda x, y, z: x * x + y * y + z * z + 1), "shape: expected a formula that is negative"),
        (lambda: sdf.sphere(1) & sdf.sphere(1, (3, 0, 0)), "shape: expected a formula that is negative"),
        (lambda: sdf.sphere(1).erode(1.5), "shape: expected a formula that is negative"),
        (lambda: sdf.sphere(1e3, (0, 0, 3e9)), "shape: expected a formula that is negative somewhere within 1e9"),
        (lambda: bob.Implicit(sdf.sphere(1).expression, ((3, 3, 3), (4, 4, 4))), "shape: expected a surface within"),
        (
            lambda: bob.implicit(lambda x, y, z: x * x + y * y + z * z - 1, bounds=((1e6,) * 3, (2e6,) * 3)),
            "shape: expected a surface within",
        ),
    ],
)
def test_shapes_without_bounds_or_surface_are_refused(make, message):
    shape = make()
    for use in (bob.Scene, bob.trace, lambda shape: shape.describe()):
        with pytest.raises(bob.InputError) as error:
            use(shape)
        assert str(error.value).startswith(message)
        assert "\n" not in str(error.value)


def test_bounds_cut_solids():
    """The cut is a face of the solid, and the remaining part has tighter bounds."""
    half = bob.Implicit(sdf.sphere(1).expression, ((-2, -2, -2), (0.25, 2, 2)))
    full = bob.trace(half, bob.Camera(0, 0), size=(64, 64))
    assert np.abs(full.normal[32, 32]).max() < 1e-6
    scene = bob.Scene(half)
    assert hits(half, (5, 0.1, 0.2), (-1, 0, 0)) == 0.25
    assert scene.center == pytest.approx((-0.375, 0, 0), abs=0.01)
    disk = (full.depth > 0) & (np.linalg.norm(full.normal, axis=2) < 1e-6)
    share = np.pi * (1 - 0.25**2) / (2 * scene.radius) ** 2
    assert disk.mean() == pytest.approx(share, rel=0.03)
    assert np.ptp(full.depth[disk]) < 1e-5


def test_a_box_inside_the_solid_is_seen_as_a_box():
    solid = bob.Implicit(sdf.sphere(9).expression, ((-1, -1, -1), (1, 1, 1)))
    assert hits(solid, (0.3, 5, 0.2), (0, -1, 0)) == 1
    assert bob.Scene(solid).radius == pytest.approx(np.sqrt(3), rel=0.015)


# ---- Scenes ----------------------------------------------------------------------------------------------


def knot():
    """Return a shape with edges, blends and a cavity."""
    return (sdf.box(1).k(0.1) | sdf.torus(0.6, 0.2).orient(X)) - sdf.cylinder(0.2)


def crowd():
    one = knot()
    triangle = bob.Mesh([[-2, -2, -0.6], [3, -2, -0.6], [0, 3, -0.6]], [[0, 1, 2]])
    return [
        bob.Instance(triangle, material=bob.Material("#808080")),
        bob.Instance(one),
        bob.Instance(one, material=bob.Material("#ff4020"))
        .scale((0.5, 1, 0.7))
        .rotate(0.7, (1, 2, 3))
        .translate((1, 1, 0.4)),
        bob.Instance(knot()),  # equal to the second, in the same place
        bob.Instance(sdf.sphere(0.3)).translate((0, 0, 0.7)),
    ]


@pytest.mark.parametrize(
    ("placed", "words"),
    [
        (lambda i: i.translate((3, -1, 2)), lambda f: f.translate((3, -1, 2))),
        (lambda i: i.rotate(0.8, (1, 2, 3)), lambda f: f.rotate(0.8, (1, 2, 3))),
        (lambda i: i.scale(7), lambda f: f.scale(7)),
        (lambda i: i.scale((1, 2, 0.5)), lambda f: f.scale((1, 2, 0.5))),
        (
            lambda i: i.scale((1, 2, 0.5)).rotate(-2, Y).translate((100, 0, 5)),
            lambda f: f.scale((1, 2, 0.5)).rotate(-2, Y).translate((100, 0, 5)),
        ),
    ],
)
def test_an_instance_looks_like_the_moved_formula(placed, words):
    """Hits, depths and normals of rays; along edges and silhouettes, rounding decides."""
    by_matrix, by_formula = bob.Scene(placed(bob.Instance(knot()))), bob.Scene(words(knot()))
    assert by_matrix.radius == pytest.approx(by_formula.radius, rel=0.02)
    rng = np.random.default_rng(2)
    direction = rng.normal(size=(5000, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    origin = by_matrix.center + by_matrix.radius * (rng.uniform(-0.6, 0.6, (5000, 3)) - 2 * direction)
    a, b = (scene.closest_hits(origin, direction).distance / by_matrix.radius for scene in (by_matrix, by_formula))
    both = np.isfinite(a) & np.isfinite(b)
    assert both.mean() > 0.2
    assert (np.isfinite(a) != np.isfinite(b)).sum() <= 2
    assert (np.abs(a[both] - b[both]) > 2e-5).mean() < 2e-3


def test_the_same_picture_from_a_matrix_and_from_a_formula():
    """Next to a mesh much larger than both, so that the scene's sphere is the same."""
    frame = bob.Mesh([[-5, -5, -5], [5, 5, 5], [5, 5, 5.001]], [[0, 1, 2]])
    a = bob.trace([frame, bob.Instance(knot()).rotate(0.8, (1, 2, 3)).scale(2)], bob.Camera(zoom=4), size=SIZE)
    b = bob.trace([frame, knot().rotate(0.8, (1, 2, 3)).scale(2)], bob.Camera(zoom=4), size=SIZE)
    assert (a.depth > 0).mean() > 0.2
    assert (np.abs(a.depth - b.depth) > 1e-5).mean() < 1e-3
    assert (np.abs(a.normal - b.normal).max(axis=2) > 1e-4).mean() < 3e-3


def test_neither_order_nor_threads_matter():
    shapes = crowd()
    pictures = [
        bob.trace([shapes[i] for i in order], size=SIZE)
        for order in ((0, 1, 2, 3, 4), (4, 3, 2, 1, 0), (2, 0, 3, 4, 1))
    ]
    assert pictures[0] == pictures[1] == pictures[2]
    # Building the cells uses this number of threads, too.
    assert with_threads((1, 2, 5), lambda: bob.trace(crowd(), size=SIZE)) == [pictures[0]] * 3


@pytest.mark.parametrize("shapes", [knot, crowd, lambda: sdf.sphere(1).shell(0.001) - sdf.box(1.2)])
def test_a_ray_s_hit_depends_on_that_ray_alone(shapes):
    """So a part is a sample of the whole, to the bit, in any packet of rays."""
    scene = bob.Scene(shapes())
    full = bob.trace(scene, size=SIZE)
    for fraction, seed in ((0.0001, 0), (0.01, 1), (0.3, 2), (0.999, 3)):
        assert bob.trace(scene, size=SIZE, fraction=fraction, seed=seed) == full.sample(fraction, seed=seed)
    rng = np.random.default_rng(0)
    pixels = np.stack([rng.integers(0, SIZE[0], 37), rng.integers(0, SIZE[1], 37)], axis=1).astype(np.int32)
    samples = bob.SceneTracer(scene, bob.Camera(), SIZE)(pixels)
    assert np.array_equal(samples.gray, full.gray[tuple(pixels.T)])
    assert np.array_equal(samples.normal, full.normal[tuple(pixels.T)])


def test_progressive_ends_with_the_exact_picture():
    frames = list(bob.progressive(crowd(), size=SIZE, fraction=0.2))
    full = bob.trace(crowd(), size=SIZE)
    assert frames[-1].gbuffer == full
    assert np.array_equal(frames[-1].image, full.gray)


@pytest.mark.parametrize("copied", [lambda x: pickle.loads(pickle.dumps(x))])
@pytest.mark.parametrize(
    "make",
    [knot, lambda: bob.implicit(lambda x, y, z: x + y * y - z, bounds=CUBE), lambda: bob.Implicit(knot().expression)],
)
def test_shapes_can_be_pickled(copied, make):
    shape = make()
    picture = bob.trace(shape, size=(32, 32))
    again = pickle.loads(pickle.dumps(shape))
    assert type(again) is type(shape)
    assert again.digest == shape.digest
    assert bob.trace(again, size=(32, 32)) == picture


def test_scene_files_hold_implicit_surfaces(tmp_path):
    cut = bob.implicit(lambda x, y, z: x + y * y - np.sin(3 * z), bounds=((-1, -1, -1), (1, 1, 1)))
    scene = bob.Scene([*crowd(), bob.Instance(cut, name="cut").translate((0, 0, 2))])
    bob.save_scene(scene, tmp_path / "a.bob")
    again = bob.load(tmp_path / "a.bob")
    assert bob.trace(again, size=SIZE) == bob.trace(scene, size=SIZE)
    assert np.array_equal(again.instances[-1].shape.bounds, cut.bounds)
    assert [i.shape.digest for i in again.instances] == [i.shape.digest for i in scene.instances]
    assert again.instances[1].shape is again.instances[2].shape is again.instances[3].shape
    bob.save_scene(again, tmp_path / "b.bob")
    assert (tmp_path / "a.bob").read_bytes() == (tmp_path / "b.bob").read_bytes()


def write_formula(path, **changed):
    tensors = {f"0.{name}": tensor for name, tensor in knot().tensors().items()}
    tensors |= {f"0.{name}": tensor for name, tensor in changed.items()}
    instance = {"shape": 0, "transform": np.eye(4).tolist(), "name": None}
    instance["material"] = {"color": [1, 1, 1], "ambient": 0.1, "diffuse": 0.7, "specular": 0.2, "shininess": 32}
    scene = {"shapes": ["implicit"], "instances": [instance]}
    path.write_bytes(sealed(layout(scene, {name: tensor for name, tensor in tensors.items() if tensor is not None})))


def test_damaged_formulas_are_refused(tmp_path):
    file = tmp_path / "a.bob"
    write_formula(file)
    bob.load(file)
    good = knot().tensors()
    ops, operands, values = (good[name].copy() for name in ("ops", "operands", "values"))
    later, op = operands.copy(), ops.copy()
    later[-1] = len(ops) + 3
    op[3] = 250
    for changed in (
        {"ops": None},
        {"values": None},
        {"ops": op},
        {"operands": later},
        {"operands": operands[:-1]},
        {"operands": operands.astype(np.int32)},
        {"values": values[:-1] if len(values) else np.ones(3)},
        {"values": values.astype(np.float32)},
        {"ops": ops[:0], "operands": operands[:0], "values": values[:0]},
        {"bounds": np.zeros((2, 3))},
        {"bounds": np.zeros((3, 2))},
        {"bounds": np.array([[0, 0, 0], [1, 1, np.nan]])},
        {"surprise": values},
    ):
        write_formula(file, **changed)
        with pytest.raises(bob.InputError) as error:
            bob.load(file)
        assert str(error.value).startswith("a.bob: shapes[0]: "), changed
        assert "\n" not in str(error.value)


# ---- Files -----------------------------------------------------------------------------------------------

EXAMPLES = Path(__file__).parents[1] / "examples"


@needs_models
@pytest.mark.parametrize("name", ["colonnade", "hi", "prospero", "quarter", "tanglecube"])
def test_no_ray_passes_through_other_people_s_formulas(name):
    shape = bob.load(MODELS / f"implicit/{name}.vm").instances[0].shape
    check_sureness(shape, 1, rays=60)
    check_normals(shape, bob.Camera(), 3e-3)


@pytest.mark.parametrize("name", ["gear", "tower", "vase"])
def test_no_ray_passes_through_the_examples(name):
    shape = bob.load(EXAMPLES / f"{name}.sdf").instances[0].shape
    check_sureness(shape, 1, rays=60)
    check_normals(shape, bob.Camera(), 3e-3)


# ---- Interruptions ---------------------------------------------------------------------------------------


def nested_sines():
    """Return a formula with slow evaluations."""
    graph = _core.Graph()
    value = graph.x()
    for _ in range(100_000):
        value = graph.unary("sin", graph.binary("add", value, graph.y()))
    return graph.expression(value)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="there are no alarms on this system")
@pytest.mark.parametrize(
    "build",
    [lambda f: _core.Implicit(f, np.array([(-1.0, -1, -1), (1, 1, 1)])), _core.find_bounds],
    ids=["cells", "bounds"],
)
def test_building_can_be_interrupted(build):
    def alarm(*_):
        raise KeyboardInterrupt

    formula = nested_sines()
    handler = signal.signal(signal.SIGALRM, alarm)

    def stopping():
        start = time.perf_counter()
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        with pytest.raises(KeyboardInterrupt):
            build(formula)
        return time.perf_counter() - start

    try:
        assert least(stopping, 2) < 2
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, handler)
