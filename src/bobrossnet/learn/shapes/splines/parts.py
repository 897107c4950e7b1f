"""Building blocks of NURBS families: knots, outlines, revolved, extruded, lofted and swept faces, and tubes.

Sections and symbols refer to *The NURBS Book* by Piegl and Tiller. An outline is a closed plane curve, a `TrimCurve`:
the trim of a flat face, the section of an extrusion.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob

Rng = np.random.Generator
Values = NDArray[np.float64]

# The unit circle in four quarters, from 0 to 4: rational and quadratic (section 7.3).
CIRCLE = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)], np.float64)
CIRCLE_WEIGHTS = np.array([1, np.sqrt(0.5)] * 4 + [1])
CIRCLE_KNOTS = np.array([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], np.float64)

LINE = np.array([0.0, 0, 1, 1])
"""The knots of a straight line."""


# ---- Knots -----------------------------------------------------------------------------------------------


def clamped(count: int, degree: int, repeated: int = 1) -> Values:
    """Return knots for `count` control points, from 0 to at most count - degree, inner ones `repeated` times."""
    inner = np.arange(1, count - degree)
    inner = (inner - 1) // repeated * repeated + 1
    return np.concatenate([np.zeros(degree + 1), inner, np.full(degree + 1, float(count - degree))])


def _knots(count: int, degree: int, closed: bool) -> Values:
    """Return knots for `count` control points; closed: unclamped, for the result of `_wrapped`."""
    return np.arange(-degree, count + degree + 1, dtype=np.float64) if closed else clamped(count, degree)


def _wrapped(points: Values, degree: int, axis: int) -> Values:
    """Append the first control points after the last, so that the curve closes smoothly."""
    count = points.shape[axis]
    return np.take(points, np.arange(count + degree), axis=axis, mode="wrap")


# ---- Outlines --------------------------------------------------------------------------------------------


def circle(radius: float | Sequence[float] = 1.0, center: Any = (0.0, 0.0)) -> bob.TrimCurve:
    """Return a circle, or an ellipse for two radii."""
    return bob.TrimCurve(CIRCLE * radius + np.asarray(center), CIRCLE_KNOTS, CIRCLE_WEIGHTS)


def smooth(corners: Any, degree: int = 3) -> bob.TrimCurve:
    """Return the closed B-spline of control points (n, 2); degree 1 gives their polygon."""
    corners = np.asarray(corners, np.float64)
    return bob.TrimCurve(_wrapped(corners, degree, 0), _knots(len(corners), degree, True))


def _bends(corners: Values, cut: float) -> tuple[Values, Values, Values]:
    """Round the inner corners of a polyline by arcs of degree 2 (section 7.3).

    Parameters
    ----------
    corners : (n + 2, d)
    cut : maximum distance from a corner to the start of its arc; at most half a side

    Returns
    -------
    (n, 3, d) and (n, 3): control points and weights of the arcs; (n, d) midpoints of the following sides
    """
    before, at, after = corners[:-2], corners[1:-1], corners[2:]
    there, back = before - at, after - at
    reach = np.minimum(np.minimum(np.linalg.norm(there, axis=1), np.linalg.norm(back, axis=1)) * 0.499, cut)[:, None]
    there /= np.linalg.norm(there, axis=1, keepdims=True)
    back /= np.linalg.norm(back, axis=1, keepdims=True)
    weight = np.sqrt(np.maximum((1 - np.sum(there * back, axis=1)) / 2, 1e-3))  # the sine of half the corner's angle
    arcs = np.stack([at + there * reach, at, at + back * reach], axis=1)
    ones = np.ones_like(weight)
    return arcs, np.stack([ones, weight, ones], axis=1), (at + after) / 2


def rounded(corners: Any, cut: float) -> bob.TrimCurve:
    """Return a polygon (n, 2) with its corners rounded by arcs, starting `cut` before them."""
    corners = np.asarray(corners, np.float64)
    arcs, weights, middles = _bends(np.concatenate([corners[-1:], corners, corners[:1]]), cut)
    points = np.concatenate([arcs, middles[:, None]], axis=1).reshape(-1, 2)
    all_weights = np.concatenate([weights, np.ones((len(weights), 1))], axis=1).ravel()
    knots = np.concatenate([[0], np.repeat(np.arange(2 * len(corners) + 1), 2), [2 * len(corners)]])
    return bob.TrimCurve(np.concatenate([points, points[:1]]), knots, np.append(all_weights, 1))


def polygon(sides: int, turn: float = 0.0) -> Values:
    """Return the corners of a regular polygon in the unit circle, (sides, 2)."""
    angle = np.arange(sides) * 2 * np.pi / sides + turn
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def star(points: int, depth: float, turn: float = 0.0) -> Values:
    """Return the corners of a star in the unit circle, (2 points, 2)."""
    corners = polygon(2 * points, turn)
    corners[1::2] *= 1 - depth
    return corners


def random_outline(rng: Rng, size: float = 1.0, center: Any = (0.0, 0.0)) -> bob.TrimCurve:
    """Return a round, rounded, angular, starry or wavy outline within a circle."""
    sides, turn = int(rng.integers(3, 9)), rng.uniform(0, 6)
    kind = rng.integers(6)
    if kind == 0:
        return circle(size, center)
    if kind == 1:
        return circle((size, size * rng.uniform(0.3, 0.9)), center)
    if kind == 2:
        return rounded(polygon(sides, turn) * size + np.asarray(center), size * rng.uniform(0.1, 0.7))
    if kind == 3:
        return smooth(polygon(sides, turn) * size + np.asarray(center), 1)
    corners = star(sides, rng.uniform(0.2, 0.6), turn) if kind == 4 else polygon(sides + 3, turn)
    if kind == 5:
        corners *= rng.uniform(0.5, 1, (len(corners), 1))
    return smooth(corners * size + np.asarray(center), int(rng.integers(1, 5)))


# ---- Faces -----------------------------------------------------------------------------------------------


def surface(
    control_points: Any,
    degrees: tuple[int, int] = (3, 3),
    closed: tuple[bool, bool] = (False, False),
    weights: Values | None = None,
    trims: Any = None,
) -> bob.Face:
    """Return the face of a net (n, m, 3), optionally closed along u or v; parameters count control points."""
    net = np.asarray(control_points, np.float64)
    knots = [_knots(net.shape[axis], degrees[axis], closed[axis]) for axis in (0, 1)]
    for axis in (0, 1):
        if closed[axis]:
            net = _wrapped(net, degrees[axis], axis)
            weights = None if weights is None else _wrapped(weights, degrees[axis], axis)
    return bob.Face(net, knots[0], knots[1], weights, trims)


def revolved(profile: Any, knots: Any, weights: Any = None) -> bob.Face:
    """Return the surface of revolution about z (section 8.5) of a curve of (n, 2) radii and heights. v is the angle."""
    profile = np.asarray(profile, np.float64)
    around = profile[:, None, :1] * CIRCLE
    net = np.concatenate([around, np.broadcast_to(profile[:, None, 1:], (*around.shape[:2], 1))], axis=2)
    along = np.ones(len(profile)) if weights is None else weights
    return bob.Face(net, knots, CIRCLE_KNOTS, np.outer(along, CIRCLE_WEIGHTS))


def lathe(profile: Any, degree: int = 1) -> bob.Brep:
    """Revolve a clamped curve of (n, 2) radii and heights about z, to a solid or vessel."""
    return bob.Brep([revolved(profile, clamped(len(profile), degree))])


def ball(radius: float = 1.0) -> bob.Brep:
    """Return an exact sphere."""
    half = np.array([(0, -1), (1, -1), (1, 0), (1, 1), (0, 1)])
    return bob.Brep([revolved(radius * half, [0, 0, 0, 1, 1, 2, 2, 2], CIRCLE_WEIGHTS[:5])])


def torus(radius: float, thickness: float) -> bob.Brep:
    """Return an exact torus about z; `thickness` is the radius of its tube."""
    return bob.Brep([revolved(CIRCLE * thickness + (radius, 0), CIRCLE_KNOTS, CIRCLE_WEIGHTS)])


def flat(loops: Sequence[bob.TrimCurve], z: float = 0.0) -> bob.Face:
    """Return the plane at z trimmed by outlines, with the even-odd rule; its parameters are x and y."""
    points = np.concatenate([loop.control_points for loop in loops])
    low, high = points.min(axis=0) - 0.01, points.max(axis=0) + 0.01
    net = [[(x, y, z) for y in (low[1], high[1])] for x in (low[0], high[0])]
    knots = [np.repeat([low[axis], high[axis]], 2) for axis in (0, 1)]
    return bob.Face(net, knots[0], knots[1], None, [[loop] for loop in loops])


def extruded(loops: Sequence[bob.TrimCurve], height: float) -> bob.Brep:
    """Extrude outlines, with the even-odd rule, from z = 0 to a height (section 8.3)."""
    faces = [flat(loops), flat(loops, height)]
    for loop in loops:
        wall = [np.insert(loop.control_points, 2, z, axis=1) for z in (0.0, height)]
        weights = None if loop.weights is None else np.stack([loop.weights] * 2, axis=1)
        faces.append(bob.Face(np.stack(wall, axis=1), loop.knots, LINE, weights))
    return bob.Brep(faces, tolerance=1e-5)


def box(size: Any) -> bob.Brep:
    """Return a box of three lengths, centred above the origin."""
    x, y, z = (float(length) for length in size)
    return extruded([smooth([(-x / 2, -y / 2), (x / 2, -y / 2), (x / 2, y / 2), (-x / 2, y / 2)], 1)], z)


def swept(section: Any, path: Any, scale: Any = 1.0, twist: Any = 0.0, closed: bool = False) -> bob.Face:
    """Sweep a closed section along a path, with minimal rotation, bicubic (section 10.4).

    Parameters
    ----------
    section : (m, 2)
    path : (n, 3)
    scale, twist : number or (n,), of the section at each point; twist in radians
    closed : whether the path is closed
    """
    section, path = np.asarray(section, np.float64), np.asarray(path, np.float64)
    along = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0) if closed else np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along[0], np.eye(3)[np.argmin(np.abs(along[0]))])
    sides = []
    for direction in along:
        side = side - direction * (side @ direction)
        side /= np.linalg.norm(side)
        sides.append(side)
    x = np.array(sides)
    y = np.cross(along, x)
    if closed:  # distributes the frame's rotation after one turn over the path
        end = x[-1] - along[0] * (x[-1] @ along[0])
        twist = twist - np.arctan2(end @ y[0], end @ x[0]) * np.arange(len(path)) / len(path)
    angle = np.broadcast_to(twist, len(path))
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    x, y = x * cosine + y * sine, y * cosine - x * sine
    size = np.broadcast_to(scale, len(path))[:, None, None]
    net = path[:, None] + size * (section[None, :, :1] * x[:, None] + section[None, :, 1:] * y[:, None])
    return surface(net, closed=(closed, True))


# ---- Tubes -----------------------------------------------------------------------------------------------


def curve(points: Any, radius: Any, degree: int = 3) -> bob.Tube:
    """Return the tube of a clamped B-spline curve."""
    return bob.nurbs_curve(points, clamped(len(points), min(degree, len(points) - 1)), radius=radius)


def ring(points: Any, radius: float, degree: int = 3) -> bob.Tube:
    """Return the tube of a smoothly closed B-spline curve."""
    points = np.asarray(points, np.float64)
    return bob.nurbs_curve(_wrapped(points, degree, 0), _knots(len(points), degree, True), radius=radius)


def pipe(corners: Any, radius: float, bend: float) -> bob.Tube:
    """Return a tube with straight segments, and arcs that start `bend` before the corners."""
    corners = np.asarray(corners, np.float64)
    if len(corners) == 2:
        return bob.polyline(corners, radius)
    arcs, weights, middles = _bends(corners, bend)
    first = (corners[0] + arcs[0, 0]) / 2
    points = np.concatenate([arcs, middles[:, None]], axis=1).reshape(-1, 3)
    points = np.concatenate([[corners[0], first], points[:-1], [(arcs[-1, 2] + corners[-1]) / 2, corners[-1]]])
    inner = np.concatenate([weights, np.ones((len(weights), 1))], axis=1).ravel()[:-1]
    spans = (len(points) - 1) // 2
    knots = np.concatenate([[0], np.repeat(np.arange(spans + 1), 2), [spans]])
    return bob.nurbs_curve(points, knots, np.concatenate([[1, 1], inner, [1, 1]]), radius=radius)


def around(shape: bob.Shape | bob.Instance, count: int, phase: float = 0.0) -> list[bob.Instance]:
    """Return `count` instances of a shape, evenly rotated about z."""
    placed = shape if isinstance(shape, bob.Instance) else bob.Instance(shape)
    return [placed.rotate(phase + 2 * np.pi * i / count) for i in range(count)]
