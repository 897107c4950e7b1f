"""Shapes from outlines of lines and arcs: biarcs along Bézier curves, and the scaling to a requested size."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.sdf.d2 import SDF2
from bobrossnet.support.errors import InputError, check_number

Places: TypeAlias = NDArray[np.complex128]
"""Points in the plane, x + i y: rotation is multiplication."""

Outline: TypeAlias = NDArray[np.float64]
"""(n, 3): x, y and the bulge of the piece from each point to the next, from the last to the first.

The bulge is the tangent of a quarter of the arc's angle, positive anticlockwise, 0 for a line.
"""

MOST_PARTS = 64
"""Maximum number of parts of a curve: at a cusp, more parts come no closer to it."""

MOST_PIECES = 10_000
"""Maximum number of pieces of an outline, as for polygons: deriving bounds of larger formulas mostly fails."""

LARGEST_RADIUS = 10
"""Maximum radius of an arc, relative to the whole outline: larger arcs exceed float32's precision and become lines."""


def region(outlines: list[Outline], name: str) -> SDF2:
    """Make the shape of all points with a nonzero winding number in closed outlines. `name` begins error messages.

    Raises
    ------
    InputError
        If nothing is inside, or the formula grows too large.
    """
    pieces = sum(map(len, outlines))
    if pieces > MOST_PIECES:
        raise InputError(f"{name}: expected an outline of at most {MOST_PIECES} lines and arcs, got {pieces}")
    try:
        expression = _core.region(outlines)
    except _core.TooLargeError as error:
        raise InputError(f"{name}: {error}") from None
    if expression is None:
        raise InputError(f"{name}: expected an outline around something, got none")
    return SDF2(expression)


def fitted_size(name: str, own: tuple[float, float], width: Any, height: Any) -> tuple[float, float]:
    """Return the final width and height of a shape with a natural size, from given values or None.

    Proportions determine an omitted value; if both are omitted, the height is 1.
    """
    aspect = own[0] / own[1]
    high = 1.0 if height is None else check_number(f"{name}: height", height, 0, above=True)
    if width is None:
        return high * aspect, high
    wide = check_number(f"{name}: width", width, 0, above=True)
    return wide, wide / aspect if height is None else high


def arcs_along(curve: Places, tolerance: float, size: float) -> Outline:
    """Approximate a Bézier curve by biarcs: the fewest equal parts of its parameter, each of two smoothly joined arcs.

    Parameters
    ----------
    curve : (2,), (3,) or (4,) complex128
        The control points of a line, a parabola or a cubic.
    tolerance : float
        Maximum distance of the arcs from the curve.
    size : float
        Size of the whole outline.

    Returns
    -------
    (n, 3) float64
        An outline's rows, without the curve's end.
    """
    for parts in range(1, MOST_PARTS + 1):
        if len(curve) == 2:
            starts, bulges = curve[:1], np.zeros(1)
            break
        t = np.linspace(0, 1, parts + 1)
        places, directions = _at(curve, t), _directions(curve, t)
        starts, bulges = _two_arcs(places, directions)
        inner = (np.arange(16 * parts) + 0.5) / (16 * parts)
        if _distances(starts, curve[-1], bulges, _at(curve, inner).reshape(parts, 16)).max() <= tolerance:
            break
    return _without_large_radii(starts, np.append(starts[1:], curve[-1]), bulges, tolerance, LARGEST_RADIUS * size)


def _at(curve: Places, t: NDArray[np.float64]) -> Places:
    """Evaluate the curve by de Casteljau's algorithm."""
    points = [np.full(t.shape, point) for point in curve]
    while len(points) > 1:
        points = [a + t * (b - a) for a, b in pairwise(points)]
    return points[0]


def _directions(curve: Places, t: NDArray[np.float64]) -> Places:
    """Return unit tangents; where control points coincide, by central differences."""
    slope = _at(np.diff(curve), t)
    around = _at(curve, np.minimum(t + 1e-4, 1)) - _at(curve, np.maximum(t - 1e-4, 0))
    slope = np.where(np.abs(slope) > 1e-6 * np.abs(np.diff(curve)).max(), slope, around)
    return slope / np.abs(slope)


def _two_arcs(places: Places, directions: Places) -> tuple[Places, NDArray[np.float64]]:
    """Return the start points and bulges of biarcs from each point to the next, with these directions at their ends.

    Of all possible pairs, the one with equal tangent lengths.
    """
    a, b, from_a, to_b = places[:-1], places[1:], directions[:-1], directions[1:]
    chord, both = b - a, from_a + to_b
    bend = 1 - (from_a * to_b.conj()).real
    along = (chord * both.conj()).real
    with np.errstate(all="ignore"):  # impossible arcs become NaN, which is not near the curve
        root = np.sqrt(along**2 + 2 * bend * np.abs(chord) ** 2)
        length = np.abs(chord) ** 2 / (along + root)
        middle = (a + b + length * (from_a - to_b)) / 2
        bulges = [np.tan(np.angle((middle - a) / from_a) / 2), np.tan(np.angle(to_b / (b - middle)) / 2)]
    return np.stack([a, middle], axis=1).reshape(-1), np.stack(bulges, axis=1).reshape(-1)


def _distances(starts: Places, end: complex, bulges: NDArray[np.float64], points: Places) -> NDArray[np.float64]:
    """Return the distance of each row of points from its biarc; infinite if there is no biarc."""
    chords = np.append(starts[1:], end) - starts
    off = []
    with np.errstate(all="ignore"):
        for first in (0, 1):
            start, chord, bulge = (array[first::2, None] for array in (starts, chords, bulges))
            local = (points - start) / chord  # maps the chord to 0..1
            radius = (1 + bulge**2) / (4 * np.abs(bulge))
            center = 0.5 + 0.25j * (1 - bulge**2) / bulge
            straight = np.abs(bulge) < 1e-9
            off.append(np.abs(chord) * np.abs(np.where(straight, local.imag, np.abs(local - center) - radius)))
        onward = chords[::2, None] * np.exp(2j * np.arctan(bulges[::2, None]))  # tangent at the joint of the two arcs
        is_before = ((points - starts[1::2, None]) * onward.conj()).real < 0
    return np.nan_to_num(np.where(is_before, *off), nan=np.inf)


def _without_large_radii(
    starts: Places, ends: Places, bulges: NDArray[np.float64], tolerance: float, largest: float
) -> Outline:
    """Return the outline with arcs above the largest radius replaced by the fewest lines within the tolerance."""
    rows = []
    for start, end, bulge in zip(starts, ends, bulges, strict=True):
        length, radius = abs(end - start), math.inf
        if bulge:
            radius = length * (1 + bulge**2) / (4 * abs(bulge))
        if radius <= largest:
            rows.append((start.real, start.imag, bulge))
            continue
        lines = max(1, math.ceil(length / math.sqrt(8 * radius * tolerance))) if bulge else 1
        angle = 4 * math.atan(bulge)
        for i in range(lines):
            # Chords to points of an arc are proportional to the sines of half their angles.
            turn, half = angle * i / lines, angle / 2
            chord = np.exp(0.5j * (turn - angle)) * math.sin(turn / 2) / math.sin(half) if i else 0
            place = start + (end - start) * chord
            rows.append((place.real, place.imag, 0.0))
    return np.array(rows)
