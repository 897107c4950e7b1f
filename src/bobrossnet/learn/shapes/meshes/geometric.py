"""Plain geometry: turned profiles, swept tubes, solids cut from solids, minimal surfaces, facets."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from bobrossnet.learn.shapes.meshes import parts
from bobrossnet.learn.shapes.meshes.parts import Array, Part, Rng, join, moved


def turned(rng: Rng) -> Part:
    """A profile on the lathe, smooth or with steps: vases, chess pieces, bottles, bolts, wheels."""
    knots = int(rng.integers(3, 12))
    radius = rng.uniform(0.1, 1, knots)
    height = np.linspace(0, rng.uniform(0.3, 3), knots)
    if rng.random() < 0.5:  # cones, or steps
        if rng.random() < 0.6:
            radius, height = np.repeat(radius, 2)[:-1], np.repeat(height, 2)[1:]
    else:  # a smooth profile through the knots
        t = np.linspace(0, knots - 1, 80)
        wave = np.interp(t, np.arange(knots), radius)
        kernel = np.hanning(17)
        radius = np.convolve(np.pad(wave, 8, mode="edge"), kernel / kernel.sum(), "valid")
        height = np.interp(t, np.arange(knots), height)
    profile = np.stack([radius, height], 1)
    if rng.random() < 0.5:  # an open vessel: the wall returns on the inside
        inside = profile[::-1] - (rng.uniform(0.02, 0.08), 0)
        inside[-1, 1] += 0.05
        profile = np.concatenate([profile, np.maximum(inside, (0.001, -9))])
    closed = np.concatenate([[[0, profile[0, 1]]], profile, [[0, profile[-1, 1]]]])
    part = parts.lathe(closed, int(rng.choice([6, 12, 48, 96])))
    if rng.random() < 0.35:  # a handle
        t = np.linspace(-np.pi / 2, np.pi / 2, 24)
        high = float(height[-1])
        path = np.stack([0.5 + 0.5 * np.cos(t), 0 * t, high * (0.5 + 0.35 * np.sin(t))], 1)
        part = join([part, parts.sweep(path, parts.round_outline(10) * 0.07)])
    return part


def tube(rng: Rng) -> Part:
    """Pipes and cables along smooth or angular paths, knots and springs."""
    return (_knot, _spring, _cables, _pipes)[rng.integers(4)](rng)


def _knot(rng: Rng) -> Part:
    """A closed torus knot."""
    p, q = [(2, 3), (3, 2), (2, 5), (3, 4), (5, 2), (1, 3)][int(rng.integers(6))]
    t = np.linspace(0, 2 * np.pi, 260, endpoint=False)
    r = 1 + 0.4 * np.cos(q * t)
    path = np.stack([r * np.cos(p * t), r * np.sin(p * t), 0.4 * np.sin(q * t)], 1)
    return parts.sweep(path, _section(rng) * rng.uniform(0.05, 0.25), closed=True)


def _spring(rng: Rng) -> Part:
    """A helix of 3 to 11 turns."""
    t = np.linspace(0, float(rng.integers(3, 12)), 400)
    path = np.stack([np.cos(2 * np.pi * t), np.sin(2 * np.pi * t), t * rng.uniform(0.15, 0.6)], 1)
    return parts.sweep(path, _section(rng) * rng.uniform(0.03, 0.2))


def _cables(rng: Rng) -> Part:
    """Up to six loose, tapering cables."""
    pieces = []
    for _ in range(int(rng.integers(1, 7))):
        path = parts.smooth_path(rng, int(rng.integers(4, 8)), 120)
        taper = np.linspace(1, rng.uniform(0.1, 1), 120)
        pieces.append(parts.sweep(path, _section(rng) * rng.uniform(0.015, 0.15), taper))
    return join(pieces)


def _pipes(rng: Rng) -> Part:
    """A pipe with right-angled bends, and a ball at each bend."""
    way = np.eye(3)[rng.integers(3, size=8)] * rng.choice([-1, 1], 8)[:, None]
    corners = np.cumsum(way * rng.uniform(0.3, 1, 8)[:, None], 0)
    pieces = [parts.rod(a, b, 0.1, 16) for a, b in pairwise(corners)]
    return join(pieces + [moved(parts.sphere(16), rng.uniform(0.1, 0.17), corner) for corner in corners])


def _section(rng: Rng) -> Array:
    """A tube's outline: round, square, flat or a star."""
    kind = rng.integers(5)
    if kind < 2:
        return parts.round_outline(18)
    if kind == 2:
        return parts.round_outline(4)
    if kind == 3:
        return parts.round_outline(14) * (1, rng.uniform(0.1, 0.4))
    return parts.round_outline(20) * np.where(np.arange(20) % 2, 1, 0.6)[:, None]


def boolean_solid(rng: Rng) -> Part:
    """Boxes, balls and cylinders, united and subtracted on a fine lattice: castings, housings, sockets."""
    x, y, z = parts.lattice(64)
    field = np.full((64, 64, 64), np.inf)
    for step in range(int(rng.integers(2, 9))):
        cx, cy, cz = rng.uniform(-0.5, 0.5, 3) * (step > 0)
        sx, sy, sz = rng.uniform(0.15, 0.8 if step == 0 else 0.5, 3)
        kind = rng.integers(3)
        if kind == 0:
            solid = np.maximum(np.maximum(np.abs(x - cx) - sx, np.abs(y - cy) - sy), np.abs(z - cz) - sz)
        elif kind == 1:
            solid = np.sqrt((x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2) - sx
        else:
            along = int(rng.integers(3))
            a, b, c = [(x - cx, y - cy, z - cz), (y - cy, z - cz, x - cx), (z - cz, x - cx, y - cy)][along]
            solid = np.maximum(np.sqrt(a * a + b * b) - sx * 0.7, np.abs(c) - sy * 1.6)
        cut = step > 0 and rng.random() < 0.6
        field = np.maximum(field, -solid) if cut else np.minimum(field, solid)
    return parts.isosurface(field)


def lattice_solid(rng: Rng) -> Part:
    """A gyroid or a similar surface within a ball or a box: foams, printed infill, corals."""
    x, y, z = (axis * rng.uniform(4, 9) for axis in parts.lattice(64))
    wall = rng.uniform(0.2, 0.7)
    if rng.random() < 0.5:
        field = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    else:
        field = np.cos(x) + np.cos(y) + np.cos(z)
    field = np.abs(field) - wall if rng.random() < 0.6 else field
    u, v, w = parts.lattice(64)
    ball = rng.random() < 0.6
    hull = u * u + v * v + w * w if ball else np.maximum(np.maximum(np.abs(u), np.abs(v)), np.abs(w))
    return parts.isosurface(np.maximum(field, (hull - 0.9) * 6))


def ngon_solid(rng: Rng) -> Part:
    """Few large facets: cut stones, low-poly animals, crates, folded paper."""
    part = parts.sphere(int(rng.integers(4, 14)))
    vertices = part[0] * (1 + rng.uniform(0, 0.35) * parts.noise(rng, part[0], 2.0))[:, None]
    power = rng.choice([0.3, 1, 1, 2])
    return np.sign(vertices) * np.abs(vertices) ** power, part[1]
