"""Shapes from outlines of lines and arcs: arcs along Bézier curves, and how large a shape is made."""

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
"""Places in the plane, x + i y: turning is multiplication."""

Outline: TypeAlias = NDArray[np.float64]
"""(n, 3): x, y and the bulge of the piece from there to the next row's place, from the last to the first. The bulge is
the tangent of a quarter of an arc's angle, positive anticlockwise, 0 of a line."""

MOST_PARTS = 64
"""Of a curve: at a cusp arcs come no nearer to it."""

MOST_PIECES = 10_000
"""Of an outline, as of polygons: bounds of larger formulas are hardly found."""

LARGEST_RADIUS = 10
"""Of arcs, in sizes of what they are part of: float32 has no digits left for larger ones, which become lines."""


def region(outlines: list[Outline], name: str) -> SDF2:
    """The shape of what closed outlines wind around, in either direction. `name` begins messages.

    Raises
    ------
    InputError
        If nothing is inside, or its formula grows too large.
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
    """Width and height of what has a size of its own, where neither, one or both of them are given.

    What is not given follows from the proportions; without either, the height is 1.
    """
    aspect = own[0] / own[1]
    high = 1.0 if height is None else check_number(f"{name}: height", height, 0, above=True)
    if width is None:
        return high * aspect, high
    wide = check_number(f"{name}: width", width, 0, above=True)
    return wide, wide / aspect if height is None else high


def arcs_along(curve: Places, tolerance: float, size: float) -> Outline:
    """Arcs along a Bézier curve: each of as few equal parts of its parameter as will do becomes two that meet smoothly.

    Parameters
    ----------
    curve : (2,), (3,) or (4,) complex128
        The control points of a line, a parabola or a cubic.
    tolerance : float
        How far arcs may be from the curve.
    size : float
        Of what it is part of.

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
    """de Casteljau's algorithm."""
    points = [np.full(t.shape, point) for point in curve]
    while len(points) > 1:
        points = [a + t * (b - a) for a, b in pairwise(points)]
    return points[0]


def _directions(curve: Places, t: NDArray[np.float64]) -> Places:
    """Unit tangents. Where control points coincide, the way from just before to just after."""
    slope = _at(np.diff(curve), t)
    around = _at(curve, np.minimum(t + 1e-4, 1)) - _at(curve, np.maximum(t - 1e-4, 0))
    slope = np.where(np.abs(slope) > 1e-6 * np.abs(np.diff(curve)).max(), slope, around)
    return slope / np.abs(slope)


def _two_arcs(places: Places, directions: Places) -> tuple[Places, NDArray[np.float64]]:
    """Two arcs from each place to the next with these directions at their ends: where they start, and their bulges.

    Of all pairs that there are, the one whose tangents are equally long.
    """
    a, b, from_a, to_b = places[:-1], places[1:], directions[:-1], directions[1:]
    chord, both = b - a, from_a + to_b
    bend = 1 - (from_a * to_b.conj()).real
    along = (chord * both.conj()).real
    with np.errstate(all="ignore"):  # what can't be joined is NaN, and not near the curve
        root = np.sqrt(along**2 + 2 * bend * np.abs(chord) ** 2)
        length = np.abs(chord) ** 2 / (along + root)
        middle = (a + b + length * (from_a - to_b)) / 2
        bulges = [np.tan(np.angle((middle - a) / from_a) / 2), np.tan(np.angle(to_b / (b - middle)) / 2)]
    return np.stack([a, middle], axis=1).reshape(-1), np.stack(bulges, axis=1).reshape(-1)


def _distances(starts: Places, end: complex, bulges: NDArray[np.float64], points: Places) -> NDArray[np.float64]:
    """How far each row of points is from its two arcs; infinite where there are none."""
    chords = np.append(starts[1:], end) - starts
    off = []
    with np.errstate(all="ignore"):
        for first in (0, 1):
            start, chord, bulge = (array[first::2, None] for array in (starts, chords, bulges))
            local = (points - start) / chord  # the chord from 0 to 1
            radius = (1 + bulge**2) / (4 * np.abs(bulge))
            center = 0.5 + 0.25j * (1 - bulge**2) / bulge
            straight = np.abs(bulge) < 1e-9
            off.append(np.abs(chord) * np.abs(np.where(straight, local.imag, np.abs(local - center) - radius)))
        onward = chords[::2, None] * np.exp(2j * np.arctan(bulges[::2, None]))  # where the two meet
        is_before = ((points - starts[1::2, None]) * onward.conj()).real < 0
    return np.nan_to_num(np.where(is_before, *off), nan=np.inf)


def _without_large_radii(
    starts: Places, ends: Places, bulges: NDArray[np.float64], tolerance: float, largest: float
) -> Outline:
    """The rows of an outline in which arcs of larger radii are lines, as many as stay within the tolerance."""
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
            # The chords to points of an arc are as the sines of half of their angles.
            turn, half = angle * i / lines, angle / 2
            chord = np.exp(0.5j * (turn - angle)) * math.sin(turn / 2) / math.sin(half) if i else 0
            place = start + (end - start) * chord
            rows.append((place.real, place.imag, 0.0))
    return np.array(rows)
