"""Tubes: NURBS curves with a radius."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.shapes.affine import MAX_COORDINATE
from bobrossnet.shapes.mesh import MAX_TRIANGLES, Mesh
from bobrossnet.shapes.shape import Shape, check_tensors, frozen
from bobrossnet.shapes.splines import (
    Values,
    check_above_zero,
    check_control_points,
    check_knots,
    check_weights,
    curve_derivatives,
    degree_of,
    domain_of,
    with_weights,
)
from bobrossnet.support.errors import InputError, check_array, check_number, shape_of
from bobrossnet.support.threads import lazy


class Tube(Shape):
    """The volume swept by a ball along a NURBS curve; its ends are round.

    Parameters
    ----------
    control_points : (n, 3) numbers, finite
        In the shape's unit, not multiplied by weights; at least two that differ.
    knots : (n + p + 1,) numbers, non-decreasing
        A complete knot vector, as in *The NURBS Book*; the degree p, 1..9, follows from the lengths. It need not be
        clamped: the domain is knots[p] to knots[n].
    radius : number above 0, or (n,) of them
        Radius of the ball, in the shape's unit: one for all, or one for each control point, interpolated by the curve
        like the coordinates.
    weights : (n,) numbers above 0, optional
        Within a factor of 1e10.

    Attributes
    ----------
    radii : (n,) float64
        The radius of each control point.

    Raises
    ------
    InputError
        If a shape or a value is out of range; the message names it.
    """

    kind = "tube"

    control_points: Values
    knots: Values
    radii: Values
    weights: Values | None

    def __init__(self, control_points: Any, knots: Any, radius: Any, weights: Any = None) -> None:
        self.control_points = _check_path("control_points", control_points)
        count = len(self.control_points)
        self.knots = check_knots("knots", knots, count)
        self.radii = _radii(radius, count)
        self.weights = check_weights("weights", weights, (count,))

    @property
    def degree(self) -> int:
        return degree_of(self.knots, len(self.control_points))

    @property
    def domain(self) -> tuple[float, float]:
        """The first and the last parameter."""
        return domain_of(self.knots, self.degree)

    @lazy
    def core(self) -> _core.Tube:
        balls = np.concatenate([self.control_points, self.radii[:, None]], axis=1)
        return _core.Tube(with_weights(balls, self.weights), self.knots)

    def mesh(self, step: float | None = None) -> Mesh:
        """Tessellate the surface between circles on it, with exact vertices.

        Parameters
        ----------
        step : number above 0, optional
            Maximum distance between circles, and between their vertices; by default 1/128 of the tube's longest side.
            Both are smaller where the curve bends or the tube is thin: circles have at least 12 vertices, and turn by
            at most 15° from one to the next.

        Returns
        -------
        Mesh
            Closed, with every edge in exactly two triangles, anticlockwise seen from outside. Where the radius exceeds
            the curve's radius of curvature, or the tube meets itself, the mesh intersects itself.

        Raises
        ------
        InputError
            If the step is below 1/4000 of the longest side, or there would be more than 33 million triangles.
        """
        step = self.check_step(step)
        parts = [Circles(curve, step) for curve in self._curves()]
        check_count(sum(len(part.center) * part.corners for part in parts), step)
        vertices = [part.vertices() for part in parts]
        first = np.cumsum([0, *map(len, vertices[:-1])])
        triangles = [part.triangles() + start for part, start in zip(parts, first, strict=True)]
        return Mesh.owning(np.concatenate(vertices), np.concatenate(triangles).astype(np.int32))

    def _curves(self) -> Iterator[Tube]:
        """The tube where its curve jumps, at knots of degree + 1, as tubes that do not."""
        p, count = self.degree, len(self.control_points)
        balls = np.concatenate([self.control_points, self.radii[:, None]], axis=1)
        jumps = np.flatnonzero(self.knots[p + 1 : count - p] == self.knots[2 * p + 1 : count]) + p + 1
        jumps = jumps[(balls[jumps - 1] != balls[jumps]).any(axis=1)]
        for low, high in pairwise([0, *jumps, count]):
            own = slice(low, high)
            weights = None if self.weights is None else self.weights[own]
            yield Tube._of(self.control_points[own], self.knots[low : high + p + 1], self.radii[own], weights)

    @classmethod
    def _of(cls, control_points: Values, knots: Values, radii: Values, weights: Values | None) -> Tube:
        """A tube of arrays that are checked, and may be a single ball."""
        tube = cls.__new__(cls)
        tube.control_points, tube.knots, tube.radii, tube.weights = control_points, knots, radii, weights
        return tube

    def describe(self) -> dict[str, str]:
        low, high = self.radii.min(), self.radii.max()
        return {
            "control points": f"{len(self.control_points):,}, {'not ' * (self.weights is None)}rational",
            "degree": f"{self.degree}",
            "thickness": f"radius {low:.6g}" + f" to {high:.6g}" * bool(low < high),
            "pieces": f"{self.core.pieces:,}, {self.core.bytes / 2**20:.1f} MiB",
        }

    def tensors(self) -> dict[str, NDArray[Any]]:
        tensors = {"control_points": self.control_points, "knots": self.knots, "radii": self.radii}
        return tensors if self.weights is None else {**tensors, "weights": self.weights}

    @classmethod
    def from_tensors(cls, tensors: Mapping[str, NDArray[Any]]) -> Tube:
        required = dict.fromkeys(("control_points", "knots", "radii"), "float64")
        check_tensors(tensors, required, {"weights": "float64"})
        radii = check_array("radii", tensors["radii"], (None,))
        return cls(tensors["control_points"], tensors["knots"], radii, tensors.get("weights"))

    def counts(self) -> dict[str, int]:
        return {"tube": 1}

    def __repr__(self) -> str:
        return f"Tube({len(self.control_points)} control points, degree {self.degree})"


def nurbs_curve(control_points: Any, knots: Any, weights: Any = None, *, radius: Any) -> Tube:
    """Make a `Tube` of a NURBS curve, with the parameters of `Tube`."""
    return Tube(control_points, knots, radius, weights)


def polyline(points: Any, radius: Any) -> Tube:
    """Straight tubes from point to point, round at the ends and corners.

    Parameters
    ----------
    points : (n, 3) numbers, finite
        At least two that differ. The curve's parameter is i at points[i].
    radius : number above 0, or (n,) of them
        One for all, or one for each point, linear between them.

    Returns
    -------
    Tube, of degree 1

    Raises
    ------
    InputError
        If a shape or a value is out of range; the message names it.
    """
    path = _check_path("points", points)
    last = len(path) - 1
    return Tube(path, [0, *range(last + 1), last], radius)


def segments(points: Values, radii: Values) -> Tube:
    """Straight tubes apart from each other, round at both ends, as one curve that jumps.

    Parameters
    ----------
    points : (n, 2, 3) float64
        Two ends of each; where they are equal, it is a ball.
    radii : (n, 2) float64, above 0
    """
    count = len(points)
    return Tube._of(
        frozen(points.reshape(-1, 3), np.float64),
        frozen(np.repeat(np.arange(count + 1.0), 2), np.float64),
        frozen(radii.reshape(-1), np.float64),
        None,
    )


def check_count(corners: float, step: float) -> None:
    """Raise InputError if circles of that many corners in all make too many triangles."""
    if 2 * corners > MAX_TRIANGLES:
        raise InputError(f"step: expected a larger one than {step:g}, which makes more than {MAX_TRIANGLES} triangles")


class Circles:
    """The circles along which a moving ball touches the tube that it sweeps, as polygons with equal numbers of corners.

    A ball of radius r at c touches it where the direction from c is at right angles to the motion of its surface: on
    the circle of radius r sqrt(1 - s^2) around c - r s t, where t is the unit tangent and s = dr/ds along the curve. At
    the ends and at corners the ball stays, and the circle turns over it.
    """

    def __init__(self, tube: Tube, step: float) -> None:
        self.step = step
        self.corners = max(12, int(np.ceil(2 * np.pi * tube.radii.max() / step)))
        self.turn = min(np.radians(15), step / tube.radii.max())
        center, radius, tangent, slope = self._balls(tube)
        start, end = (self._cap(center[i], radius[i], tangent[i], slope[i], side) for i, side in ((0, -1), (-1, 1)))
        self.center, self.radius, self.tangent, self.slope = (
            np.concatenate(parts) for parts in zip(start, (center, radius, tangent, slope), end, strict=True)
        )
        check_count(self.corners * len(self.center), step)

    def _balls(self, tube: Tube) -> tuple[Values, Values, Values, Values]:
        """Return centres, radii, tangents and slopes along the curve, densely enough; at corners the tangent turns."""
        balls = np.concatenate([tube.control_points, tube.radii[:, None]], axis=1)
        u0, u1 = tube.domain
        knots = np.unique(tube.knots[(u0 <= tube.knots) & (tube.knots <= u1)])
        parts: list[tuple[Values, Values, Values, Values]] = []
        for low, high in pairwise(knots):
            # Inside the span, since at its ends the derivatives are one-sided.
            inset = 1e-9 * (high - low)
            u = np.linspace(low + inset, high - inset, 65)
            for _ in range(2):  # the second time densely enough
                point, by = curve_derivatives(balls, tube.weights, tube.knots, u)
                speed = np.linalg.norm(by[:, :3], axis=1)
                tangent = by[:, :3] / np.where(speed > 0, speed, 1)[:, None]
                length = np.linalg.norm(np.diff(point[:, :3], axis=0), axis=1)
                turn = _angle(tangent[1:], tangent[:-1])
                cost = np.cumsum([0, *np.maximum(length / self.step, turn / self.turn)])
                check_count(self.corners * cost[-1], self.step)
                wanted = max(2, int(np.ceil(cost[-1])) + 1)
                u = np.interp(np.linspace(0, cost[-1], wanted), cost, u) if cost[-1] > 0 else u[[0, -1]]
            keep = speed > 1e-12 * speed.max()
            if not keep.any():
                continue
            slope = np.clip(by[:, 3] / np.where(keep, speed, 1), -1, 1)
            part = tuple(values[keep] for values in (point[:, :3], point[:, 3], tangent, slope))
            if parts:
                parts.append(self._turn(parts[-1], part))
            parts.append(part)
        if not parts:  # a ball that only grows
            largest = balls[[int(np.argmax(tube.radii))]]
            parts.append((largest[:, :3], largest[:, 3], np.array([[0.0, 0.0, 1.0]]), np.zeros(1)))
        center, radius, tangent, slope = (np.concatenate(values) for values in zip(*parts, strict=True))
        return center, radius, tangent, slope

    def _turn(self, before: Any, after: Any) -> tuple[Values, Values, Values, Values]:
        """Return the circles at a kink, which turn on the ball between two spans."""
        (center, radius, a, s), (b, t) = (values[-1] for values in before), (after[2][0], after[3][0])
        angle = float(_angle(a[None], b[None])[0])
        count = int(np.ceil(max(angle, abs(np.arcsin(s) - np.arcsin(t))) / self.turn))
        share = np.linspace(0, 1, count + 1)[1:-1] if count > 1 else np.empty(0)
        side = b - (a @ b) * a
        if np.linalg.norm(side) < 1e-9:
            side = _across(a)  # back the way it came, on any side; or straight on
        side = side / np.linalg.norm(side)
        tangent = np.cos(angle * share)[:, None] * a + np.sin(angle * share)[:, None] * side
        slope = np.sin(np.arcsin(s) + share * (np.arcsin(t) - np.arcsin(s)))
        return np.tile(center, (len(share), 1)), np.full(len(share), radius), tangent, slope

    def _cap(
        self, center: Values, radius: float, tangent: Values, slope: float, side: int
    ) -> tuple[Values, Values, Values, Values]:
        """Return the circles of a round end, between its pole and its circle; the slope is 1 at the pole."""
        first, pole = np.arcsin(slope), -side * np.pi / 2
        count = max(1, int(np.ceil(abs(pole - first) / self.turn)))
        angles = (first + (pole - first) * np.linspace(0, 1, count + 1))[1:]
        slopes = np.sin(angles)[:: -1 if side < 0 else 1]
        return np.tile(center, (count, 1)), np.full(count, radius), np.tile(tangent, (count, 1)), slopes

    def vertices(self) -> Values:
        """The first pole, the circles' corners, and the last pole."""
        x = _frames(self.center, self.tangent)
        y = np.cross(self.tangent, x)
        angle = 2 * np.pi * np.arange(self.corners) / self.corners
        middle = self.center - (self.radius * self.slope)[:, None] * self.tangent
        around = x[:, None] * np.cos(angle)[:, None] + y[:, None] * np.sin(angle)[:, None]
        across = self.radius * np.sqrt(np.maximum(1 - self.slope**2, 0))
        rings = middle[:, None] + across[:, None, None] * around
        return np.concatenate([middle[:1], rings[1:-1].reshape(-1, 3), middle[-1:]])

    def triangles(self) -> NDArray[np.int32]:
        n, rings = self.corners, len(self.center) - 2
        here = np.arange(n, dtype=np.int32)
        there = np.roll(here, -1)
        first = np.stack([np.zeros(n, np.int32), there + 1, here + 1], axis=1)
        base = 1 + n * np.arange(rings - 1, dtype=np.int32)[:, None]
        a, b, c, d = base + here, base + there, base + n + here, base + n + there
        sides = np.stack([np.stack([a, b, d], axis=-1), np.stack([a, d, c], axis=-1)], axis=2).reshape(-1, 3)
        last, pole = 1 + n * (rings - 1), 1 + n * rings
        end = np.stack([last + here, last + there, np.full(n, pole)], axis=1)
        return np.concatenate([first, sides, end]).astype(np.int32)


def _angle(a: Values, b: Values) -> Values:
    """Return the angles between unit vectors, (k,); accurate for small angles, unlike the arc cosine."""
    angle: Values = 2 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    return angle


def _across(direction: Values) -> Values:
    """Return a vector perpendicular to another."""
    axis = np.eye(3)[int(np.argmin(np.abs(direction)))]
    across: Values = np.cross(direction, axis)
    return across


def _frames(center: Values, tangent: Values) -> Values:
    """Return unit vectors perpendicular to the tangents with minimal rotation from one to the next.

    By double reflection (Wang et al., "Computation of rotation minimizing frames", 2008).
    """
    x = np.empty_like(tangent)
    x[0] = _across(tangent[0]) / np.linalg.norm(_across(tangent[0]))
    for i in range(len(tangent) - 1):
        along = center[i + 1] - center[i]
        square = along @ along
        moved, turned = x[i], tangent[i]
        if square > 0:
            moved = moved - 2 / square * (along @ moved) * along
            turned = turned - 2 / square * (along @ turned) * along
        mirror = tangent[i + 1] - turned
        square = mirror @ mirror
        if square > 0:
            moved = moved - 2 / square * (mirror @ moved) * mirror
        moved = moved - (moved @ tangent[i + 1]) * tangent[i + 1]
        x[i + 1] = moved / np.linalg.norm(moved)
    return x


def _check_path(name: str, value: Any) -> Values:
    points = check_control_points(name, value, (None, 3))
    if (points == points[0]).all():
        raise InputError(f"{name}: expected at least two that differ, got {points[0].tolist()} {len(points)} times")
    return points


def _radii(value: Any, count: int) -> Values:
    if not shape_of(value):
        return frozen(np.full(count, check_number("radius", value, 0, MAX_COORDINATE, above=True)), np.float64)
    radii = check_array("radius", value, (count,), hint="one radius, or one for each control point")
    check_above_zero("radius", radii)
    return frozen(radii, np.float64)
