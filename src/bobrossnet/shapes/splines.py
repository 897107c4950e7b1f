"""Shared by NURBS curves and surfaces: knots, weights and control points, with their checks.

Names and symbols follow Piegl and Tiller, *The NURBS Book* (second edition, 1997).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.shapes.affine import check_size
from bobrossnet.shapes.shape import frozen
from bobrossnet.support.errors import InputError, InputTypeError, check_array, check_finite

MAX_DEGREE = 9
"""The core's maximum degree."""

MAX_WEIGHT_RATIO = 1e10
"""Maximum ratio of weights: the core computes in float32, where smaller ones vanish."""

Values = NDArray[np.float64]


def check_control_points(name: str, value: Any, shape: tuple[int | None, ...]) -> Values:
    """Return `value` as frozen float64 control points; None in `shape` is any number from 2 on."""
    points = check_finite(name, check_array(name, value, shape))
    if min(points.shape[:-1]) < 2:
        raise InputError(f"{name}: expected at least 2{' x 2' * (len(shape) - 2)} points, got shape {points.shape}")
    check_size(name, points)
    return frozen(points, np.float64)


def check_knots(name: str, value: Any, count: int) -> Values:
    """Return `value` as a frozen float64 knot vector for `count` control points.

    It has n + p + 1 knots with a degree p in 1..9.
    """
    knots = check_finite(name, check_array(name, value, (None,)))
    check_size(name, knots)
    lowest, highest = count + 2, count + 1 + min(MAX_DEGREE, count - 1)
    if not lowest <= len(knots) <= highest:
        wanted = f"{lowest}" if lowest == highest else f"{lowest} to {highest}"
        raise InputError(
            f"{name}: expected {wanted} knots for {count} control points, one for each and degree + 1 more, "
            f"got {len(knots)}"
        )
    knots = frozen(knots, np.float64)
    steps = np.diff(knots)
    if steps.min() < 0:
        i = int(np.argmax(steps < 0))
        raise InputError(f"{name}: expected numbers that never decrease, got {knots[i]:.6g}, then {knots[i + 1]:.6g}")
    degree = degree_of(knots, count)
    low, high = domain_of(knots, degree)
    if low == high:
        raise InputError(
            f"{name}: expected a domain, {name}[{degree}] to {name}[{count}], that is not empty, got {low:.6g} at both"
        )
    too_often = knots[degree + 1 :] == knots[: -degree - 1]
    if too_often.any():
        value = knots[int(np.argmax(too_often))]
        raise InputError(
            f"{name}: expected a knot at most degree + 1 = {degree + 1} times, "
            f"got {value:.6g} {np.count_nonzero(knots == value)} times"
        )
    return knots


def check_weights(name: str, value: Any, shape: tuple[int, ...]) -> Values | None:
    """Return `value` as frozen float64 weights; None stays None."""
    if value is None:
        return None
    weights = check_array(name, value, shape, hint="one weight for each control point")
    check_above_zero(name, weights)
    if weights.max() / MAX_WEIGHT_RATIO > weights.min():
        raise InputError(
            f"{name}: expected weights within a factor of {MAX_WEIGHT_RATIO:g}, "
            f"got {weights.min():.6g} to {weights.max():.6g}"
        )
    return frozen(weights, np.float64)


def check_above_zero(name: str, array: NDArray[Any]) -> None:
    """Raise InputError unless all values are finite, above 0, and at most the maximum coordinate."""
    check_finite(name, array)
    check_size(name, array)
    if not (array > 0).all():
        at = [int(i) for i in np.argwhere(~(array > 0))[0]]
        raise InputError(f"{name}: expected numbers above 0, got {array[tuple(at)]:.6g} at {name}{at}")


def degree_of(knots: Values, count: int) -> int:
    """Return the degree p of `count` control points n, from n + p + 1 knots."""
    return len(knots) - count - 1


def domain_of(knots: Values, degree: int) -> tuple[float, float]:
    """Return the first and the last parameter."""
    return float(knots[degree]), float(knots[-degree - 1])


def with_weights(points: Values, weights: Values | None) -> Values:
    """Return control points, (..., N), with their weights appended, (..., N + 1)."""
    result = np.empty((*points.shape[:-1], points.shape[-1] + 1))
    result[..., :-1] = points
    result[..., -1] = 1 if weights is None else weights
    return result


def curve_derivatives(points: Values, weights: Values | None, knots: Values, u: Values) -> tuple[Values, Values]:
    """Return points C(u) and derivatives C'(u), (k, N) each, at parameters (k,) of a curve.

    The control points are (n, N). Equation 4.8 of *The NURBS Book*.
    """
    degree = degree_of(knots, len(points))
    spans, basis = _core.basis_derivatives(degree, knots, np.ascontiguousarray(u, np.float64), 1)
    w = np.ones(len(points)) if weights is None else weights / weights.max()
    homogeneous = np.concatenate([points * w[:, None], w[:, None]], axis=1)
    local = homogeneous[spans[:, None] - degree + np.arange(degree + 1)]  # (k, p + 1, N + 1)
    value, slope = np.moveaxis((basis[..., None] * local[:, None]).sum(axis=2), 1, 0)
    point = value[:, :-1] / value[:, -1:]
    return point, (slope[:, :-1] - slope[:, -1:] * point) / value[:, -1:]


@contextmanager
def place_in_errors(place: str) -> Iterator[None]:
    """Rename `knots` in error messages to `place.knots`."""
    try:
        yield
    except InputError as error:
        raise type(error)(f"{place}.{error}") from None


def check_tuple(name: str, value: Any, what: str) -> tuple[Any, ...]:
    """Return any iterable except text as a tuple."""
    try:
        if not isinstance(value, str | bytes):
            return tuple(value)
    except TypeError:
        pass
    raise InputTypeError(f"{name}: expected {what}, got {type(value).__name__}")
