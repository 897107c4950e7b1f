"""Tubes: NURBS curves with a thickness."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.errors import InputError, check_array, check_number
from bobrossnet.shapes.affine import MAX_COORDINATE
from bobrossnet.shapes.shape import Shape, check_tensors, frozen
from bobrossnet.shapes.splines import (
    Values,
    check_above_zero,
    check_control_points,
    check_knots,
    check_weights,
    degree_of,
    domain_of,
    with_weights,
)


class Tube(Shape):
    """What a ball sweeps as it moves along a NURBS curve; its ends are round.

    Parameters
    ----------
    control_points : (n, 3) numbers, finite
        In the unit of the shape, not multiplied by weights; at least two that differ.
    knots : (n + p + 1,) numbers that never decrease
        A complete knot vector, as in *The NURBS Book*; the degree p, 1..9, follows. It need not be clamped: the curve
        runs from knots[p] to knots[n].
    radius : number above 0, or (n,) of them
        The ball's, in the unit of the shape: one for all, or one for each control point, which the curve blends as it
        does their coordinates.
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

    @cached_property
    def core(self) -> _core.Tube:
        balls = np.concatenate([self.control_points, self.radii[:, None]], axis=1)
        return _core.Tube(with_weights(balls, self.weights), self.knots)

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
    """A NURBS curve as a shape: a `Tube`, whose parameters these are."""
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


def _check_path(name: str, value: Any) -> Values:
    points = check_control_points(name, value, (None, 3))
    if (points == points[0]).all():
        raise InputError(f"{name}: expected at least two that differ, got {points[0].tolist()} {len(points)} times")
    return points


def _radii(value: Any, count: int) -> Values:
    if np.ndim(value) == 0:
        return frozen(np.full(count, check_number("radius", value, 0, MAX_COORDINATE, above=True)), np.float64)
    radii = check_array("radius", value, (count,), hint="one radius, or one for each control point")
    check_above_zero("radius", radii)
    return frozen(radii, np.float64)
