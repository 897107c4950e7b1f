"""Parts that overlap: pairs of solids with a common volume."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from bobrossnet.measuring.crossings import crossings
from bobrossnet.tracing.parts import Extent, Part, only
from bobrossnet.tracing.scene import Scene

SIDE = 48
"""Rays along each side of the box that two parts share."""

SHIFT = 0.0137
"""Offset of rays from the middle of their cells, in cells: edges of symmetric shapes often lie in the middle."""

TOUCHING = 1e-4
"""Parts that overlap less only touch, in diagonals of the smaller box: above rounding and the tracer's steps."""

MAX_PAIRS = 500
"""Maximum number of pairs of parts with overlapping boxes to examine, at about 20 ms each."""


@dataclass(frozen=True, eq=False)
class Overlap:
    """The common volume of two parts."""

    parts: tuple[Part, Part]
    volume: float
    """In cubes of the unit, to about a percent."""
    depth: float
    """The largest length of a ray in both parts, along the shortest side of the box that they share."""


def overlaps(scene: Scene) -> tuple[list[Overlap], int]:
    """Return the overlaps of a scene's parts, by decreasing volume, and the number of pairs left unchecked.

    Only closed surfaces enclose a volume: rays that leave an open one without entering it again are ignored.
    """
    parts = [part for part in scene.parts.walk() if part.own]
    boxes = [part.extent for part in parts]
    pairs = [
        (i, j, shared)
        for i, j in combinations(range(len(parts)), 2)
        if (shared := _shared(boxes[i], boxes[j])) is not None
    ]
    alone: dict[int, Scene] = {}
    found = []
    for i, j, shared in pairs[:MAX_PAIRS]:
        for number in (i, j):
            if number not in alone:
                alone[number] = only(scene.sectioned(None), [parts[number]])
        volume, depth = _common(alone[i], alone[j], shared)
        smaller = min(float(np.linalg.norm(boxes[number].size)) for number in (i, j))
        if depth > TOUCHING * smaller:
            found.append(Overlap((parts[i], parts[j]), volume, depth))
    return sorted(found, key=lambda each: -each.volume), max(len(pairs) - MAX_PAIRS, 0)


def _shared(a: Extent, b: Extent) -> Extent | None:
    """Return the common box of two boxes, if it has a volume."""
    low, high = np.maximum(a.low, b.low), np.minimum(a.high, b.high)
    return Extent(low, high) if (low < high).all() else None


def _common(a: Scene, b: Scene, box: Extent) -> tuple[float, float]:
    """Return the common volume of two scenes within a box, and its largest length along the box's shortest side."""
    along = int(np.argmin(box.size))
    across, up = (along + 1) % 3, (along + 2) % 3
    places = (np.arange(SIDE) + 0.5 + SHIFT) / SIDE
    origins = np.empty((SIDE, SIDE, 3))
    origins[..., across] = box.low[across] + box.size[across] * places[:, None]
    origins[..., up] = box.low[up] + box.size[up] * places
    origins[..., along] = box.low[along]
    rays = origins.reshape(-1, 3)
    events = [_crossings(scene, rays, along) for scene in (a, b)]
    ray = np.concatenate([each[0] for each in events])
    place = np.concatenate([each[1] for each in events])
    step = np.concatenate([each[2] for each in events])
    owner = np.repeat([0, 1], [len(each[0]) for each in events])
    order = np.lexsort((place, ray))
    ray, place = ray[order], place[order]
    inside = [np.cumsum(np.where(owner == which, step, 0)[order]) for which in (0, 1)]  # each ray's steps add to 0
    both = (inside[0] > 0) & (inside[1] > 0)
    lengths = np.clip(place[1:], None, box.high[along]) - np.clip(place[:-1], box.low[along], None)
    lengths = np.where(both[:-1] & (ray[1:] == ray[:-1]), np.maximum(lengths, 0), 0)
    cell = float(box.size[across] * box.size[up]) / SIDE**2
    return float(lengths.sum()) * cell, float(lengths.max(initial=0))


def _crossings(
    scene: Scene, rays: NDArray[np.float64], axis: int
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int64]]:
    """Return where rays along an axis cross surfaces: ray, coordinate, and 1 where they enter, -1 where they leave."""
    origins = rays.copy()
    origins[:, axis] = scene.extent.low[axis] - scene.radius
    directions = np.broadcast_to(np.eye(3)[axis], rays.shape)
    found = [
        (which, points[:, axis], np.full(len(which), 1 - 2 * (number % 2)))
        for number, (which, points) in enumerate(crossings(scene, origins, directions))
    ]
    if not found:
        return np.empty(0, np.int64), np.empty(0), np.empty(0, np.int64)
    ray, place, steps = (np.concatenate(values) for values in zip(*found, strict=True))
    closed = np.bincount(ray, minlength=len(rays))[ray] % 2 == 0
    return ray[closed], place[closed], steps[closed]
