"""NURBS with closed forms, and random ones."""

import numpy as np

import bobrossnet as bob

# A quarter of the unit circle is the rational quadratic with these control points and weights (The NURBS Book, 7.3).
CIRCLE = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)], float)
CIRCLE_WEIGHTS = np.array([1, np.sqrt(0.5)] * 4 + [1])
CIRCLE_KNOTS = np.array([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], float)

# Half of it, from (0, -1) by (1, 0) to (0, 1).
HALF = np.array([(0, -1), (1, -1), (1, 0), (1, 1), (0, 1)], float)
HALF_WEIGHTS = CIRCLE_WEIGHTS[:5]
HALF_KNOTS = np.array([0, 0, 0, 1, 1, 2, 2, 2], float)


def revolved(profile, weights, knots):
    """Revolve a curve (n, 2) of (radius, z) about z: v is the angle, four quarters in 0..4."""
    around = profile[:, None, :1] * CIRCLE
    points = np.concatenate([around, np.broadcast_to(profile[:, None, 1:], (*around.shape[:2], 1))], axis=2)
    return bob.Face(points, knots, CIRCLE_KNOTS, np.outer(weights, CIRCLE_WEIGHTS))


def sphere(radius=1.0, center=(0, 0, 0)):
    face = revolved(radius * HALF, HALF_WEIGHTS, HALF_KNOTS)
    return moved(face, center)


def torus(r1=0.7, r2=0.25):
    """Return a torus about z; `r1` is the radius of its spine."""
    return bob.Brep([revolved(r2 * CIRCLE + (r1, 0), CIRCLE_WEIGHTS, CIRCLE_KNOTS)])


def cylinder(radius=0.7, low=-0.6, high=0.4):
    """Return a cylinder about z, of three faces: the caps are squares trimmed by circles."""
    side = revolved(np.array([(radius, low), (radius, high)]), np.ones(2), [0, 0, 1, 1])
    circle = bob.TrimCurve(radius * CIRCLE, CIRCLE_KNOTS, CIRCLE_WEIGHTS)
    square = np.array([[(x, y) for y in (-1.0, 1.0)] for x in (-1.0, 1.0)])
    caps = [
        bob.Face(
            np.concatenate([square, np.full((2, 2, 1), z)], axis=2), [-1, -1, 1, 1], [-1, -1, 1, 1], None, [circle]
        )
        for z in (low, high)
    ]
    return bob.Brep([side, *caps])


def moved(face, offset):
    return bob.Brep([bob.Face(face.control_points + offset, face.knots_u, face.knots_v, face.weights, face.trims)])


def random_knots(rng, count, degree):
    """Return knots, clamped or not, some of them repeated."""
    inner = np.sort(rng.choice(np.arange(1, 9), count - degree - 1) / 2.0)
    if inner.size and np.unique(inner, return_counts=True)[1].max() > degree:
        inner = np.linspace(0.3, 4.6, count - degree - 1)
    if rng.random() < 0.3:
        return np.concatenate([-np.arange(degree, -1, -1.0), inner, 5 + np.arange(degree + 1.0)])
    return np.concatenate([np.zeros(degree + 1), inner, np.full(degree + 1, 5.0)])


def random_surface(rng, rational=None):
    """Return a wavy sheet over the unit square, of degrees up to 4; by default rational half of the time."""
    degrees = rng.integers(1, 5, 2)
    n, m = degrees + rng.integers(1, 5, 2)
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, m), indexing="ij")
    points = np.stack([x, y, 0.4 * rng.normal(size=(n, m))], axis=2)
    rational = rng.random() < 0.5 if rational is None else rational
    weights = rng.uniform(0.5, 2, (n, m)) if rational else None
    return bob.nurbs_surface(points, random_knots(rng, n, degrees[0]), random_knots(rng, m, degrees[1]), weights)


def geomdl_surface(face):
    """Return the same surface in geomdl, without trims."""
    from geomdl import NURBS

    surface = NURBS.Surface(normalize_kv=False)
    surface.degree_u, surface.degree_v = face.degree_u, face.degree_v
    weights = np.ones(face.control_points.shape[:2]) if face.weights is None else face.weights
    weighted = np.concatenate([face.control_points * weights[..., None], weights[..., None]], axis=2)
    surface.set_ctrlpts(weighted.reshape(-1, 4).tolist(), *weights.shape)
    surface.knotvector_u, surface.knotvector_v = face.knots_u.tolist(), face.knots_v.tolist()
    return surface


def curve_points(curve, count=33):
    """Return (n, 2) points along a trim curve, by de Boor's algorithm."""
    p, knots = curve.degree, curve.knots
    weights = np.ones(len(curve.control_points)) if curve.weights is None else curve.weights
    points = []
    for t in np.unique(np.concatenate([np.linspace(*curve.domain, count), knots[p:-p]])):
        k = min(max(int(np.searchsorted(knots, t, side="right")) - 1, p), len(weights) - 1)
        d = np.column_stack([curve.control_points * weights[:, None], weights])[k - p : k + 1]
        for r in range(1, p + 1):
            for j in range(p, r - 1, -1):
                low, high = knots[j + k - p], knots[j + 1 + k - r]
                a = (t - low) / (high - low)
                d[j] = (1 - a) * d[j - 1] + a * d[j]
        points.append(d[p, :2] / d[p, 2])
    return np.array(points)


def inside(face, u, v):
    """Return whether points are inside the trims, by crossings with polygons."""
    result = np.full(u.shape, not face.trims)
    for loop in face.trims:
        polygon = np.concatenate([curve_points(curve) for curve in loop])
        for (u0, v0), (u1, v1) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
            if v0 != v1:
                result ^= ((v0 > v) != (v1 > v)) & (u < u0 + (v - v0) * (u1 - u0) / (v1 - v0))
    return result
