"""The built-in scene: a happy little tree on a hill."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bobrossnet.shapes.mesh import Mesh

F64 = NDArray[np.float64]
Solid = tuple[F64, NDArray[np.int64]]
"""Vertices (V, 3) and triangles (T, 3) of a closed surface, or of many."""

Clump = tuple[F64, float]
"""Centre and radius of a clump of leaves."""

SEED = 1942  # the year of Bob Ross's birth
# Sizes suit pictures of 640x480 completed from 5 % of their pixels, 4 or 5 pixels apart. With 8,600 leaves and 3,640
# blades of a few pixels these blurred, at an SSIM of 0.77; with leaves 15 to 25 pixels wide and fewer blades, the
# same network reached 0.84.
LEAVES = 32  # in a clump of radius 0.25
TUFTS = 24
BLADES = 6  # in a tuft
BOUGHS = 13
LOW_BOUGHS = ((2.2, 0.40, 0.52, 0.16, 0.15), (5.2, 0.30, 0.44, 0.13, 0.13))
"""Limbs below the crown: angle; start, as a share of the trunk; horizontal and vertical reach; size of the clump."""
GOLDEN_ANGLE = 2.39996  # its multiples never align


def happy_tree() -> Mesh:
    """Make a happy little tree on a hill: about 2.5 units high, z up, the same for every call.

    A tree with roots, branches and leaves, three firs, stones and grass. Every part is a closed surface: each edge is
    shared by exactly two triangles. Parts may intersect.

    Returns
    -------
    Mesh of about 125,000 triangles, without normals.
    """
    rng = np.random.default_rng(SEED)
    bark, clumps = _branches(rng)
    solids = [_hill(), *bark, *_crown(rng, clumps)]
    for at, height in (((-0.42, 0.66), 0.74), ((0.20, 0.72), 0.48), ((0.34, -0.70), 0.44)):
        solids += _fir(rng, _on_hill(*at), height)
    stones = ((0.62, -0.20), 0.11), ((0.70, -0.05), 0.065), ((0.50, 0.62), 0.07), ((-0.5, -0.55), 0.10)
    for at, size in stones:
        solids.append(_stone(rng, _on_hill(*at), size))
    solids += _grass(rng)
    return Mesh(*_joined(solids))


# ---- Ground ----------------------------------------------------------------------------------------------


def _height(x: F64, y: F64) -> F64:
    """Return the hill's height at a point: a dome with a few soft waves."""
    r2 = x * x + y * y
    waves = 0.030 * np.sin(3.1 * x + 0.7) * np.cos(2.7 * y - 0.4) + 0.012 * np.sin(7.3 * x - 5.1 * y)
    return 0.44 * np.exp(-1.7 * r2) + waves - 0.16 * r2


def _on_hill(x: float, y: float) -> F64:
    return np.array([x, y, float(_height(np.array(x), np.array(y)))])


def _hill() -> Solid:
    """Make a round piece of land: the hill on top, a bowl of earth below."""
    around = np.linspace(0, 2 * np.pi, 120, endpoint=False)
    edge = 1.0 + 0.025 * np.sin(3 * around + 0.5) + 0.015 * np.sin(7 * around)

    def ring(share: float, lift: F64) -> F64:
        x, y = share * edge * np.cos(around), share * edge * np.sin(around)
        return np.stack([x, y, lift + _height(x, y)], axis=1)

    rings = []
    # From bottom to top: the bowl with its crags, the rounded rim, the hill.
    for share in np.linspace(0.05, 0.985, 28):
        crags = 0.05 * np.sin(5 * around + 5 * share) * np.sin(9 * share)
        crags += 0.02 * np.sin(17 * around + 11 * share)
        bowl = -0.06 - 0.32 * (1 - share**2) ** 0.6 + crags * share * (1 - share**8)
        flat = _height(share * edge * np.cos(around), share * edge * np.sin(around))
        rings.append(ring(share, bowl - (1 - share**4) * (flat + 0.14)))
    rim = np.linspace(-0.40 * np.pi, 0.40 * np.pi, 7)
    rings += [ring(0.985 + 0.022 * np.cos(angle), 0.03 * np.sin(angle) - 0.03) for angle in rim]
    rings += [ring(share, np.zeros_like(around)) for share in np.linspace(0.98, 0.02, 50)]
    return _closed(np.array(rings), _up(-0.52), _on_hill(0, 0))


def _stone(rng: np.random.Generator, at: F64, size: float) -> Solid:
    """Make a rounded, lumpy, flattish boulder, sunk slightly into the ground."""
    ball, triangles = _ball(14, 22)
    lumps = 1 + 0.16 * _noise(rng, ball, 2.2) + 0.05 * _noise(rng, ball, 6.0)
    return ball * lumps[:, None] * size * np.array([1.25, 1.0, 0.75]) + at + _up(0.25 * size), triangles


def _grass(rng: np.random.Generator) -> list[Solid]:
    """Make tufts of broad blades that lean outwards."""
    solids: list[Solid] = []
    for place in range(TUFTS):
        # Evenly over the land, with some jitter, inside the rim.
        share = 0.22 + 0.68 * np.sqrt((place + rng.random()) / TUFTS)
        turn = GOLDEN_ANGLE * place + 0.5 * rng.standard_normal()
        foot = _on_hill(share * np.cos(turn), share * np.sin(turn)) - _up(0.01)
        turns = 2 * np.pi * (np.arange(BLADES) + 0.6 * rng.random(BLADES)) / BLADES
        out = np.stack([np.cos(turns), np.sin(turns), np.zeros(BLADES)], axis=1)
        along = _unit((0.15 + 0.45 * rng.random((BLADES, 1))) * out + _up(1))
        half = 0.055 + 0.035 * rng.random((BLADES, 1))
        solids.append(_leaves(foot + 0.85 * half * along, along, out, 0.24 * half, slim=1 / 0.24, plump=0.45))
    return solids


# ---- Wood ------------------------------------------------------------------------------------------------


def _branches(rng: np.random.Generator) -> tuple[list[Solid], list[Clump]]:
    """Make the trunk and its boughs, and return the clumps of leaves on these."""
    foot = _on_hill(0.0, -0.05) - _up(0.09)
    trunk = _curve(foot, foot + _vector(0.03, -0.10, 0.55), foot + _vector(-0.03, 0.12, 1.15), 40)
    solids = [_limb(trunk, 0.115, 0.036, flare=0.95, sides=40)]
    middle = _vector(0.0, 0.03, 1.37)
    clumps: list[Clump] = [(middle, 0.30)]
    for number in range(BOUGHS):
        # Away from each other's shade; together they fill a dome.
        turn = GOLDEN_ANGLE * number + 0.9
        lift = -0.28 + 1.23 * number / (BOUGHS - 1)
        level = np.sqrt(max(1 - lift**2, 0.0))
        out = _vector(np.cos(turn), np.sin(turn), 0.0)
        end = middle + (0.60 * level * out + _up(0.35 * lift)) * (0.92 + 0.16 * rng.random())
        start = trunk[int(39 * (0.52 + 0.44 * number / (BOUGHS - 1)))]
        bough = _curve(start, 0.5 * (start + end) + 0.12 * out - _up(0.06), end, 18)
        solids.append(_limb(bough, 0.036, 0.012, sides=14))
        clumps.append((end, 0.22 + 0.07 * rng.random()))
    for turn, share, reach, rise, size in LOW_BOUGHS:
        out = reach * _vector(np.cos(turn), np.sin(turn), 0.0)
        start = trunk[int(39 * share)]
        end = start + out + _up(rise)
        bough = _curve(start, start + 0.75 * out + _up(0.2 * rise), end, 18)
        solids.append(_limb(bough, 0.040, 0.014, sides=14))
        clumps += [(end, size), (0.35 * start + 0.65 * end + _up(0.07), 0.75 * size)]
    return solids, clumps


def _limb(path: F64, thick: float, thin: float, *, flare: float = 0.0, sides: int = 12) -> Solid:
    """Make a tube along `path`, tapered from `thick` to `thin`; `flare` spreads its foot into roots."""
    along = np.linspace(0, 1, len(path))[:, None]
    around = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    foot = np.exp(-along / 0.08)
    roots = flare * foot * (1 + 0.75 * np.cos(5 * around + 0.6))
    furrows = 0.05 * np.sin(9 * around + 5 * along) * (flare > 0)
    radius = (thick + (thin - thick) * along**0.8) * (1 + roots + furrows)
    ahead = _unit(np.gradient(path, axis=0))
    right = _unit(np.cross(ahead, [0.3, 1.0, 0.1]))
    up = np.cross(ahead, right)
    rings = (
        path[:, None]
        + radius[..., None] * np.cos(around)[:, None] * right[:, None]
        + radius[..., None] * np.sin(around)[:, None] * up[:, None]
    )
    return _closed(rings, path[0], path[-1] + ahead[-1] * thin)


def _curve(start: F64, middle: F64, end: F64, count: int) -> F64:
    """Return points on a quadratic Bézier curve, (count, 3)."""
    t = np.linspace(0, 1, count)[:, None]
    curve: F64 = (1 - t) ** 2 * start + 2 * t * (1 - t) * middle + t**2 * end
    return curve


# ---- Leaves ----------------------------------------------------------------------------------------------


def _crown(rng: np.random.Generator, clumps: list[Clump]) -> list[Solid]:
    """Make clumps of foliage: balls, shingled with plump hanging leaves with raised tips."""
    flat = np.array([1.1, 1.1, 0.9])
    ball, triangles = _ball(12, 20)
    middles, sizes = np.array([at for at, _ in clumps]), np.array([size for _, size in clumps])
    solids: list[Solid] = []
    for number, (at, size) in enumerate(clumps):
        solids.append((at + ball * size * flat * 0.86, triangles))
        outward = _spread(rng, round(LEAVES * (size / 0.25) ** 1.2))
        face = _unit(outward + 0.16 * rng.standard_normal(outward.shape))
        hang = 0.45 * rng.standard_normal(outward.shape) - _up(1)
        along = _unit(_unit(np.cross(face, np.cross(hang, face))) + 0.34 * face)
        width = (0.085 + 0.025 * rng.random((len(outward), 1))) * (size / 0.25) ** 0.4
        leaf = at + outward * flat * size * 0.86
        # Skip leaves hidden inside another clump.
        away = np.linalg.norm((leaf[:, None] - middles) / flat, axis=-1) / sizes
        away[:, number] = np.inf
        seen = away.min(axis=1) > 0.76
        solids.append(_leaves(leaf[seen], along[seen], face[seen], width[seen], slim=1.42, plump=0.50))
    return solids


def _leaves(middle: F64, along: F64, face: F64, width: F64, *, slim: float, plump: float) -> Solid:
    """Make pointed leaves around `middle` (n, 3).

    `along` points from stem to tip, `face` roughly along the flat side's normal, and `width` (n, 1) is half the width.
    A leaf is `slim` times longer than wide and `plump` times thicker than wide.
    """
    across = _unit(np.cross(face, along))
    axes = np.stack([along, across, np.cross(along, across)], axis=1) * width[:, None]
    around = np.linspace(0, 2 * np.pi, 10, endpoint=False)
    # From stem to tip: position along the leaf, width.
    profile = (-0.94, 0.34), (-0.72, 0.70), (-0.36, 0.96), (0.06, 0.98), (0.46, 0.74), (0.80, 0.33)
    rings = [
        np.stack([np.full(10, slim * x), wide * np.cos(around), plump * wide * np.sin(around)], axis=1)
        for x, wide in profile
    ]
    leaf, triangles = _closed(np.array(rings), _vector(-slim, 0, 0), _vector(slim, 0, 0))
    return _repeated(middle[:, None] + leaf @ axes, triangles)


def _fir(rng: np.random.Generator, foot: F64, height: float) -> list[Solid]:
    """Make a trunk and five skirts of boughs, each a cone with a hem of hanging tips."""
    path = _curve(foot - _up(0.04), foot + _up(0.1 * height), foot + _up(0.85 * height), 8)
    solids = [_limb(path, 0.045 * height, 0.01 * height, sides=12)]
    # A skirt from below the hem, outwards, and up to the tip: radius, height.
    profile = (0.45, 0.10), (0.92, 0.015), (1.0, 0.0), (0.93, 0.055), (0.62, 0.28), (0.30, 0.62), (0.08, 0.93)
    tiers = 5
    for tier in range(tiers):
        share = tier / (tiers - 1)
        tips = 10 - tier
        around = np.linspace(0, 2 * np.pi, tips * 6, endpoint=False)
        lengths = np.repeat(0.85 + 0.3 * rng.random(tips), 6)
        tooth = (0.70 + 0.30 * np.abs(np.cos(0.5 * tips * around + tier)) ** 0.8) * lengths
        low, reach = (0.14 + 0.60 * share) * height, (0.30 - 0.215 * share) * height
        tall = (0.30 - 0.06 * share) * height
        outer = np.stack([np.cos(around), np.sin(around), np.zeros_like(around)], axis=1)
        rings = []
        for out, up in profile:
            # Longer tips hang lower.
            ragged = 1 + (tooth - 1) * out**2
            ring = outer * (reach * out * ragged)[:, None]
            ring[:, 2] = low + up * tall - 0.22 * reach * out**2 * (ragged - 0.8)
            rings.append(ring + foot)
        solids.append(_closed(np.array(rings), foot + _up(low + 0.12 * tall), foot + _up(low + tall)))
    return solids


# ---- Building blocks -------------------------------------------------------------------------------------


def _closed(rings: F64, first: F64, last: F64) -> Solid:
    """Close rings of points (n, m, 3) to a surface, by a point at either end.

    Rings run anticlockwise seen from `last`, so that the outside faces out.
    """
    n, m = rings.shape[:2]
    here = np.arange(n * m).reshape(n, m)
    right = np.roll(here, -1, axis=1)
    a, b, c, d = (part.ravel() for part in (here[:-1], right[:-1], right[1:], here[1:]))
    triangles = np.concatenate(
        [
            np.stack([a, b, c], axis=1),
            np.stack([a, c, d], axis=1),
            np.stack([right[0], here[0], np.full(m, n * m)], axis=1),
            np.stack([here[-1], right[-1], np.full(m, n * m + 1)], axis=1),
        ]
    )
    return np.concatenate([rings.reshape(-1, 3), [first, last]]), triangles


def _ball(rings: int, sides: int) -> Solid:
    """Make the unit sphere."""
    up = np.linspace(-np.pi / 2, np.pi / 2, rings + 2)[1:-1, None]
    around = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    x, y = np.cos(up) * np.cos(around), np.cos(up) * np.sin(around)
    return _closed(np.stack([x, y, np.broadcast_to(np.sin(up), x.shape)], axis=-1), _up(-1), _up(1))


def _repeated(corners: F64, triangles: NDArray[np.int64]) -> Solid:
    """Make many copies of a small solid; `corners` (n, k, 3) are the vertices of each."""
    n, k = corners.shape[:2]
    return corners.reshape(-1, 3), (triangles + k * np.arange(n)[:, None, None]).reshape(-1, 3)


def _spread(rng: np.random.Generator, count: int) -> F64:
    """Return directions spread evenly over the sphere, slightly jittered, (count, 3)."""
    n = np.arange(count) + 0.5
    z = 1 - 2 * n / count
    level, turn = np.sqrt(1 - z * z), GOLDEN_ANGLE * n + 2 * np.pi * rng.random()
    even = np.stack([level * np.cos(turn), level * np.sin(turn), z], axis=1)
    return _unit(even + 0.10 * rng.standard_normal(even.shape))


def _noise(rng: np.random.Generator, points: F64, frequency: float) -> F64:
    """Evaluate a smooth bumpy field at `points`, (n,) in about -1..1: a few plane waves in random directions."""
    waves = _unit(rng.standard_normal((7, 3))) * frequency * (0.7 + 0.6 * rng.random((7, 1)))
    field: F64 = np.sin(points @ waves.T + 2 * np.pi * rng.random(7)).sum(axis=1) / 3.0
    return field


def _vector(x: float, y: float, z: float) -> F64:
    return np.array([x, y, z], dtype=np.float64)


def _up(z: float) -> F64:
    return _vector(0.0, 0.0, z)


def _unit(vectors: F64) -> F64:
    unit: F64 = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return unit


def _joined(solids: Sequence[Solid]) -> Solid:
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in solids])
    triangles = [faces + start for (_, faces), start in zip(solids, starts[:-1], strict=True)]
    return np.concatenate([vertices for vertices, _ in solids]), np.concatenate(triangles)
