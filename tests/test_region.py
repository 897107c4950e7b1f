"""Regions with outlines of lines and arcs: distances and sides compared with dense samples, and worked values."""

import numpy as np
import pytest

from bobrossnet import _core

SAMPLES = 401


def outline(*rows):
    return np.array(rows, float)


def sampled(loop):
    """Return points along an outline, (n, SAMPLES, 2) for n pieces."""
    pieces = []
    for (x, y, bulge), following in zip(loop, np.roll(loop, -1, axis=0), strict=True):
        a, b = complex(x, y), complex(*following[:2])
        t = np.linspace(0, 1, SAMPLES)
        angle = 4 * np.arctan(bulge)
        if angle:
            center = a + (b - a) / (1 - np.exp(1j * angle))
            places = center + (a - center) * np.exp(1j * angle * t)
        else:
            places = a + (b - a) * t
        pieces.append(np.stack([places.real, places.imag], axis=1))
    return np.array(pieces)


def winding(points, loop):
    """Return winding numbers, by the angles subtended by a fine polygon."""
    corners = sampled(loop)[:, :-1].reshape(-1, 2)[::4]
    seen = np.zeros(len(points))
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        u, v = a - points, b - points
        seen += np.arctan2(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], (u * v).sum(axis=1))
    return np.rint(seen / (2 * np.pi)).astype(int)


def at(f, points):
    return f(np.column_stack([points, np.zeros(len(points))]))


def boundary_samples(loops):
    """Return the samples with the inside on exactly one side, by the winding numbers on both sides."""
    kept = []
    for loop in loops:
        for piece in sampled(loop):
            middle = (piece[1:] + piece[:-1]) / 2
            along = piece[1:] - piece[:-1]
            across = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.hypot(*along.T)[:, None] * 1e-4
            left = sum(winding(middle + across, other) for other in loops) != 0
            right = sum(winding(middle - across, other) for other in loops) != 0
            kept.append(middle[left != right])
    return np.concatenate(kept)


def check(loops, seed, tolerance):
    f = _core.region(loops)
    rng = np.random.default_rng(seed)
    points = rng.uniform(-2, 2, (300, 2))
    boundary = boundary_samples(loops)
    away = np.array([np.hypot(*(boundary - p).T).min() for p in points])
    inside = sum(winding(points, loop) for loop in loops) != 0
    expected = np.where(inside, -away, away)
    clear = away > tolerance
    assert np.abs(at(f, points) - expected)[clear].max() < tolerance
    assert inside.any()
    assert not inside.all()


@pytest.mark.parametrize("seed", range(6))
def test_distances_are_those_of_outlines_sampled_finely(seed):
    """A star of random arcs and lines, without self-intersection."""
    rng = np.random.default_rng(seed)
    n = 7
    angle = 2 * np.pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n
    r = rng.uniform(0.8, 1.4, n)
    bulge = rng.choice([0, 0.15, -0.15, 0.1], n)
    check([np.column_stack([r * np.cos(angle), r * np.sin(angle), bulge])], seed, 4e-3)


@pytest.mark.parametrize("seed", range(4))
def test_outlines_that_cross_are_taken_together(seed):
    """Two overlapping triangles of random arcs, in either direction."""
    rng = np.random.default_rng(seed)
    loops = [np.column_stack([rng.uniform(-1.3, 1.3, (3, 2)), rng.choice([0, 0.4, -0.3], 3)]) for _ in range(2)]
    check(loops, seed, 4e-3)


SQUARE = outline((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0))
DISK = outline((-1, 0, 1), (1, 0, 1))
POINTS = np.array([(0, 0), (0.5, 0.25), (2, 0), (2, 2), (-3, 0.5), (0.9, -0.9), (0, -1.5)])


def test_a_square_and_a_disk():
    x, y = np.abs(POINTS.T) - 1
    square = np.where(np.maximum(x, y) < 0, np.maximum(x, y), np.hypot(np.maximum(x, 0), np.maximum(y, 0)))
    assert at(_core.region([SQUARE]), POINTS) == pytest.approx(square, abs=1e-12)
    assert at(_core.region([SQUARE[::-1]]), POINTS) == pytest.approx(square, abs=1e-12)
    assert at(_core.region([DISK]), POINTS) == pytest.approx(np.hypot(*POINTS.T) - 1, abs=1e-12)


def test_most_of_a_circle():
    """Three quarters of the unit circle, closed by a chord."""
    f = _core.region([outline((0, -1, 0), (-1, 0, -np.tan(3 * np.pi / 8)))])
    chord = np.sqrt(0.5)
    points = np.array([(0, 0), (2, 0), (0.6, 0.6), (-1, -1), (-0.9, -0.4)])
    across = (points @ (-1, -1)) * chord - chord  # beyond the chord
    expected = [-chord, 1, np.hypot(0.6, 0.6) - 1, across[3], np.hypot(0.1, 0.4)]
    assert at(f, points[:4]) == pytest.approx(expected[:4], abs=1e-12)
    assert at(f, points[4:])[0] == pytest.approx(across[4], abs=1e-12)


def test_a_hole_and_an_island_in_it():
    f = _core.region([3 * SQUARE, 2 * SQUARE[::-1], SQUARE])
    x = np.array([0, 0.9, 1.2, 1.9, 2.4, 2.6, 3.5])
    points = np.column_stack([x, np.zeros(len(x))])
    assert at(f, points) == pytest.approx([-1, -0.1, 0.2, 0.1, -0.4, -0.4, 0.5], abs=1e-12)


def test_overlaps_have_no_edges_inside():
    """Two overlapping squares, at a corner or a side, coincident ones, and two with a common side."""
    right = SQUARE + (1, 0, 0)
    assert at(_core.region([SQUARE, right]), np.array([(0.5, 0.0), (0, 0)])) == pytest.approx([-1, -1])
    assert at(_core.region([SQUARE, SQUARE]), POINTS) == pytest.approx(at(_core.region([SQUARE]), POINTS))
    beside = SQUARE + (2, 0, 0)
    assert at(_core.region([SQUARE, beside]), np.array([(1, 0), (1, 2), (1, -0.25)])) == pytest.approx([-1, 1, -0.75])


def test_squares_that_touch_at_a_corner():
    f = _core.region([SQUARE, SQUARE + (2, 2, 0)])
    points = np.array([(0.5, 0.5), (1.5, 1.5), (1.5, 0.5), (0.5, 1.5), (0.9, 1.1)])
    assert at(f, points) == pytest.approx([-0.5, -0.5, 0.5, 0.5, 0.1], abs=1e-12)


def test_far_from_the_origin_and_tiny():
    f = _core.region([SQUARE * (1e-6, 1e-6, 0) + (1e3, -1e3, 0)])
    points = np.array([(1e3, -1e3), (1e3 + 2e-6, -1e3)])
    assert at(f, points) == pytest.approx([-1e-6, 1e-6], rel=1e-6)


def test_nothing_inside_is_no_region():
    assert _core.region([]) is None
    assert _core.region([outline((0, 0, 0), (1, 1, 0))]) is None
    assert _core.region([SQUARE, SQUARE[::-1]]) is None
