"""The built-in scene: a happy little tree on a hill."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bobrossnet.shapes.mesh import Mesh

Points = NDArray[np.float64]
Solid = tuple[Points, NDArray[np.int64]]
"""Vertices (V, 3) and triangles (T, 3) of a closed surface, or of many."""

SEED = 1942  # the year of Bob Ross's birth
CROWN_LEAVES = 8600
GRASS_BLADES = 3640
BOUGHS = 13


def happy_tree() -> Mesh:
    """Make a happy little tree on a hill: about 2 units high, z up, the same for every call.

    A leaning tree with roots, branches and leaves; three firs, for company; stones and grass. Every part is a
    closed surface: each edge is shared by exactly two triangles. Parts may stand inside each other.

    Returns
    -------
    Mesh of about 120,000 triangles, without normals.
    """
    rng = np.random.default_rng(SEED)
    bark, twigs = _branches(rng)
    solids = [_hill(), *bark, *_crown(rng, twigs)]
    for at, height in (((-0.42, 0.66), 0.74), ((-0.10, 0.80), 0.52), ((0.34, -0.70), 0.44)):
        solids += _fir(rng, _on_hill(*at), height)
    stones = ((0.62, -0.20), 0.11), ((0.70, -0.05), 0.065), ((0.10, 0.78), 0.07), ((-0.5, -0.55), 0.10)
    for at, size in stones:
        solids.append(_stone(rng, _on_hill(*at), size))
    solids.append(_grass(rng))
    return Mesh(*_joined(solids))


# ---- Ground ----------------------------------------------------------------------------------------------


def _height(x: Points, y: Points) -> Points:
    """How high the hill is at a place: a dome with a few soft waves in it."""
    r2 = x * x + y * y
    waves = 0.030 * np.sin(3.1 * x + 0.7) * np.cos(2.7 * y - 0.4) + 0.012 * np.sin(7.3 * x - 5.1 * y)
    return 0.44 * np.exp(-1.7 * r2) + waves - 0.16 * r2


def _on_hill(x: float, y: float) -> Points:
    return np.array([x, y, float(_height(np.array(x), np.array(y)))])


def _hill() -> Solid:
    """A round piece of land: the hill on top, a bowl of earth below."""
    around = np.linspace(0, 2 * np.pi, 120, endpoint=False)
    edge = 1.0 + 0.025 * np.sin(3 * around + 0.5) + 0.015 * np.sin(7 * around)

    def ring(share: float, lift: Points) -> Points:
        x, y = share * edge * np.cos(around), share * edge * np.sin(around)
        return np.stack([x, y, lift + _height(x, y)], axis=1)

    rings = []
    # From the bottom up: the bowl with its crags, the rounded rim, the hill to its top.
    for share in np.linspace(0.05, 0.985, 28):
        crags = 0.05 * np.sin(5 * around + 5 * share) * np.sin(9 * share)
        crags += 0.02 * np.sin(17 * around + 11 * share)
        bowl = -0.06 - 0.40 * (1 - share**2) ** 0.6 + crags * share * (1 - share**8)
        flat = _height(share * edge * np.cos(around), share * edge * np.sin(around))
        rings.append(ring(share, bowl - (1 - share**4) * (flat + 0.14)))
    for angle in np.linspace(-0.40 * np.pi, 0.40 * np.pi, 7):
        rings.append(ring(0.985 + 0.022 * np.cos(angle), 0.03 * np.sin(angle) - 0.03))
    for share in np.linspace(0.98, 0.02, 50):
        rings.append(ring(share, np.zeros_like(around)))
    return _closed(np.array(rings), _up(-0.60), _on_hill(0, 0))


def _stone(rng: np.random.Generator, at: Points, size: float) -> Solid:
    """A rounded, lumpy, somewhat flat boulder, sunk a little into the ground."""
    ball, triangles = _ball(14, 22)
    lumps = 1 + 0.16 * _noise(rng, ball, 2.2) + 0.05 * _noise(rng, ball, 6.0)
    return ball * lumps[:, None] * size * np.array([1.25, 1.0, 0.75]) + at + _up(0.25 * size), triangles


def _grass(rng: np.random.Generator) -> Solid:
    """Blades in tufts: thin three-sided pyramids that lean outward from the middle of their tuft."""
    tufts = 0.95 * np.sqrt(rng.random((GRASS_BLADES // 13, 1)))
    turn = 2 * np.pi * rng.random(tufts.shape)
    spread = 0.034 * rng.standard_normal((GRASS_BLADES // 13, 13, 2))
    x, y = tufts * np.cos(turn) + spread[..., 0], tufts * np.sin(turn) + spread[..., 1]
    back = np.minimum(1.0, 0.96 / np.hypot(x, y))  # nothing grows beyond the rim
    x, y = x * back, y * back
    feet = np.stack([x, y, _height(x, y) - 0.01], axis=-1).reshape(-1, 3)
    lean = np.concatenate([0.55 * spread, np.zeros((*spread.shape[:2], 1))], axis=-1).reshape(-1, 3)
    tall = (0.030 + 0.038 * rng.random((len(feet), 1))) * _up(1)
    side = _unit(rng.standard_normal((len(feet), 3)) * [1, 1, 0]) * 0.0065
    aside = np.cross(_up(1), side)
    corners = [feet + side, feet - 0.5 * side + aside, feet - 0.5 * side - aside, feet + tall + lean]
    return _repeated(np.stack(corners, axis=1), np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))


# ---- Wood ------------------------------------------------------------------------------------------------


def _branches(rng: np.random.Generator) -> tuple[list[Solid], Points]:
    """The trunk, its branches and theirs; and where they end, (n, 3)."""
    foot = _on_hill(0.0, -0.05) - _up(0.09)
    trunk = _curve(foot, foot + _vector(0.02, -0.06, 0.50), foot + _vector(-0.03, 0.10, 1.02), 40)
    solids = [_limb(trunk, 0.105, 0.036, flare=0.95, sides=40)]
    middle = _vector(0.0, 0.03, 1.13)
    ends = []
    for number in range(BOUGHS):
        # The golden angle keeps branches out of each other's light; together they fill a dome.
        turn = 2.39996 * number + 0.9
        lift = -0.30 + 1.28 * number / (BOUGHS - 1)
        level = np.sqrt(max(1 - lift**2, 0.0))
        out = _vector(np.cos(turn), np.sin(turn), 0.0)
        end = middle + (0.52 * level * out + _up(0.42 * lift)) * (0.92 + 0.16 * rng.random())
        start = trunk[int(39 * (0.44 + 0.50 * number / (BOUGHS - 1)))]
        bough = _curve(start, 0.5 * (start + end) + 0.12 * out - _up(0.06), end, 18)
        solids.append(_limb(bough, 0.036 - 0.014 * number / BOUGHS, 0.009, sides=14))
        ends.append(end)
        for share, way in ((8, 1.0), (12, -1.0)):
            aside = np.cross(out, _up(way))
            tip = bough[share] + (0.15 * aside + 0.10 * out) * level + _up(0.10 + 0.06 * rng.random())
            twig = _curve(bough[share], bough[share] + 0.09 * aside, tip, 10)
            solids.append(_limb(twig, 0.013, 0.005, sides=8))
            ends.append(tip)
    return solids, np.array(ends)


def _limb(path: Points, thick: float, thin: float, *, flare: float = 0.0, sides: int = 12) -> Solid:
    """A tube along `path` that tapers from `thick` to `thin`; `flare` spreads its foot into roots."""
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


def _curve(start: Points, middle: Points, end: Points, count: int) -> Points:
    """A quadratic Bézier curve, (count, 3)."""
    t = np.linspace(0, 1, count)[:, None]
    curve: Points = (1 - t) ** 2 * start + 2 * t * (1 - t) * middle + t**2 * end
    return curve


# ---- Leaves ----------------------------------------------------------------------------------------------


def _crown(rng: np.random.Generator, twigs: Points) -> list[Solid]:
    """A soft ball of foliage around the end of each twig, covered in leaves."""
    sizes = 0.135 + 0.075 * rng.random(len(twigs))
    flat = np.array([1.1, 1.1, 0.85])
    ball, triangles = _ball(11, 18)
    solids: list[Solid] = []
    for at, size in zip(twigs, sizes, strict=True):
        lumps = 0.78 + 0.10 * _noise(rng, ball + at, 3.0)
        solids.append((at + ball * lumps[:, None] * size * flat, triangles))

    # Leaves sit on the balls, more on the larger ones, and not where another ball hides them.
    which = rng.choice(len(twigs), size=3 * CROWN_LEAVES, p=sizes**2 / (sizes**2).sum())
    outward = _unit(rng.standard_normal((len(which), 3)))
    height = sizes[which, None] * (0.90 + 0.22 * rng.random((len(which), 1)))
    feet = twigs[which] + outward * height * flat
    away = np.linalg.norm((feet[:, None] - twigs) / flat, axis=-1) / sizes
    away[np.arange(len(which)), which] = np.inf
    seen = np.flatnonzero(away.min(axis=1) > 0.86)[:CROWN_LEAVES]
    solids.append(_leaves(rng, feet[seen], outward[seen]))
    return solids


def _leaves(rng: np.random.Generator, feet: Points, outward: Points) -> Solid:
    """A leaf at each of `feet`: a thin pointed lozenge, its flat side roughly outward, its tip hanging."""
    face = _unit(outward + 0.34 * rng.standard_normal(feet.shape))
    droop = rng.standard_normal(feet.shape) * 0.7 + outward * 0.5 + [0, 0, -0.5]
    along = _unit(np.cross(face, np.cross(droop, face)))
    across = np.cross(face, along)  # to the left, seen from outside
    size = 0.029 + 0.017 * rng.random((len(feet), 1))
    # Four corners: the vein from stem to tip lies above the two sides, so the leaf is folded along it.
    stem = feet - along * size + face * size * 0.10
    tip = feet + along * size * 1.25 - face * size * 0.15
    left = feet + across * size * 0.66 - face * size * 0.20
    right = feet - across * size * 0.66 - face * size * 0.20
    corners = np.stack([stem, tip, left, right], axis=1)
    return _repeated(corners, np.array([[0, 3, 1], [0, 1, 2], [0, 2, 3], [1, 3, 2]]))


def _fir(rng: np.random.Generator, foot: Points, height: float) -> list[Solid]:
    """A trunk and seven skirts of boughs, each a cone whose hem is cut into tips that hang."""
    path = _curve(foot - _up(0.04), foot + _up(0.1 * height), foot + _up(0.85 * height), 8)
    solids = [_limb(path, 0.045 * height, 0.01 * height, sides=12)]
    # A skirt from below the hem, out to it, and up to the tip: how far out, how far up.
    profile = (0.45, 0.10), (0.92, 0.015), (1.0, 0.0), (0.93, 0.055), (0.62, 0.28), (0.30, 0.62), (0.08, 0.93)
    tiers = 7
    for tier in range(tiers):
        share = tier / (tiers - 1)
        tips = 13 - tier
        around = np.linspace(0, 2 * np.pi, tips * 6, endpoint=False)
        lengths = np.repeat(0.85 + 0.3 * rng.random(tips), 6)
        tooth = (0.70 + 0.30 * np.abs(np.cos(0.5 * tips * around + tier)) ** 0.8) * lengths
        low, reach = (0.14 + 0.60 * share) * height, (0.30 - 0.215 * share) * height
        tall = (0.30 - 0.06 * share) * height
        outer = np.stack([np.cos(around), np.sin(around), np.zeros_like(around)], axis=1)
        rings = []
        for out, up in profile:
            # Tips hang lower the farther they reach.
            ragged = 1 + (tooth - 1) * out**2
            ring = outer * (reach * out * ragged)[:, None]
            ring[:, 2] = low + up * tall - 0.22 * reach * out**2 * (ragged - 0.8)
            rings.append(ring + foot)
        solids.append(_closed(np.array(rings), foot + _up(low + 0.12 * tall), foot + _up(low + tall)))
    return solids


# ---- Building blocks -------------------------------------------------------------------------------------


def _closed(rings: Points, first: Points, last: Points) -> Solid:
    """The surface through rings of points (n, m, 3), closed by a point at either end.

    Rings run anticlockwise seen from `last`, if the outside is to be outside.
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
    """The unit sphere."""
    up = np.linspace(-np.pi / 2, np.pi / 2, rings + 2)[1:-1, None]
    around = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    x, y = np.cos(up) * np.cos(around), np.cos(up) * np.sin(around)
    return _closed(np.stack([x, y, np.broadcast_to(np.sin(up), x.shape)], axis=-1), _up(-1), _up(1))


def _repeated(corners: Points, triangles: NDArray[np.int64]) -> Solid:
    """Many copies of one small solid; `corners` (n, k, 3) are the vertices of each."""
    n, k = corners.shape[:2]
    return corners.reshape(-1, 3), (triangles + k * np.arange(n)[:, None, None]).reshape(-1, 3)


def _noise(rng: np.random.Generator, points: Points, frequency: float) -> Points:
    """A smooth bumpy field at `points`, (n,) in about -1..1: a few plane waves in random directions."""
    waves = _unit(rng.standard_normal((7, 3))) * frequency * (0.7 + 0.6 * rng.random((7, 1)))
    field: Points = np.sin(points @ waves.T + 2 * np.pi * rng.random(7)).sum(axis=1) / 3.0
    return field


def _vector(x: float, y: float, z: float) -> Points:
    return np.array([x, y, z], dtype=np.float64)


def _up(z: float) -> Points:
    return _vector(0.0, 0.0, z)


def _unit(vectors: Points) -> Points:
    unit: Points = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return unit


def _joined(solids: Sequence[Solid]) -> Solid:
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in solids])
    triangles = [faces + start for (_, faces), start in zip(solids, starts[:-1], strict=True)]
    return np.concatenate([vertices for vertices, _ in solids]), np.concatenate(triangles)
