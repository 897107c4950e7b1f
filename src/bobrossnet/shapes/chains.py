"""Polylines, joined from segments whose ends have numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core

Values = NDArray[np.float64]
Numbers = NDArray[np.intp]


class Chain(NamedTuple):
    """The numbers of successive ends; of a closed chain, the last is joined to the first."""

    ends: Numbers
    is_closed: bool


class Curve(NamedTuple):
    """A curve in a plane, as points on it and the points halfway between these."""

    points: Values  # (n, 2)
    middles: Values  # (n, 2), the last before the first point if it is closed; otherwise (n - 1, 2)
    is_closed: bool

    def length(self) -> float:
        """Return the length, extrapolated from chords and halves of them (Richardson)."""
        start, end = self._segments()
        chord = np.linalg.norm(end - start, axis=1)
        halves = np.linalg.norm(self.middles - start, axis=1) + np.linalg.norm(end - self.middles, axis=1)
        return float((4 * halves - chord).sum() / 3)

    def area(self) -> float:
        """Return the enclosed area, positive if anticlockwise; between chord and curve there is a parabola."""
        if not self.is_closed:
            return 0.0
        start, end = self._segments()
        center = self.points.mean(axis=0)
        polygon = _cross(start - center, end - center).sum() / 2
        return float(polygon + 2 / 3 * _cross(self.middles - start, end - start).sum())

    def turned(self) -> Curve:
        """Return the curve in the other direction."""
        middles = self.middles[::-1]
        if self.is_closed:  # the last one stays behind the last point
            middles = np.roll(middles, -1, axis=0)
        return Curve(self.points[::-1], middles, self.is_closed)

    def scaled(self, factor: float) -> Curve:
        """Return the curve scaled about the origin."""
        return Curve(factor * self.points, factor * self.middles, self.is_closed)

    def _segments(self) -> tuple[Values, Values]:
        if self.is_closed:
            return self.points, np.roll(self.points, -1, axis=0)
        return self.points[:-1], self.points[1:]


def straight(points: Values, is_closed: bool) -> Curve:
    """Return a polyline as a curve."""
    following = np.roll(points, -1, axis=0) if is_closed else points[1:]
    return Curve(points, (points[: len(following)] + following) / 2, is_closed)


def chained(segments: Numbers) -> list[Chain]:
    """Join segments (n, 2) at equal ends; where more than two meet, in any way."""
    count = int(segments.max(initial=-1)) + 1
    points, ends = _core.chained(count, np.ascontiguousarray(segments, np.uint32))
    chains = np.split(points.astype(np.intp), ends[:-1]) if len(ends) else []
    return [Chain(c[:-1], True) if c[0] == c[-1] else Chain(c, False) for c in chains]


def _cross(a: Values, b: Values) -> Values:
    product: Values = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return product
