"""Plants: a leaf, leaves around a stem, and forking trees."""

from __future__ import annotations

import numpy as np

from bobrossnet.learn.shapes.meshes import parts
from bobrossnet.learn.shapes.meshes.parts import Array, Part, Rng, join, moved, rotation


def leaf(rng: Rng) -> Part:
    """A thin curved sheet, pointed at both ends."""
    u, v = np.linspace(0, 1, 12)[:, None], np.linspace(-1, 1, 5)[None]
    width = np.sin(np.pi * u) * rng.uniform(0.15, 0.4)
    return parts.grid(np.stack([width * v, u + 0 * v, rng.uniform(-0.6, 0.6) * u * u + 0.3 * width * np.abs(v)], -1))


def plant(rng: Rng) -> Part:
    """Leaves around a stem or in a pot: palms, pineapples, flowers."""
    pieces = [leaf(rng)]
    single = [moved(leaf(rng), rng.uniform(0.8, 1.6)) for _ in range(3)]
    for i in range(int(rng.integers(6, 40))):
        tilt = rng.uniform(-0.2, 1.2)
        turn = rotation(2, 2.4 * i) @ rotation(0, tilt)  # 2.4 is the golden angle
        pieces.append(moved(single[i % 3], turn, (0, 0, rng.uniform(0, 0.5))))
    if rng.random() < 0.6:
        pieces.append(moved(parts.cylinder(0.3, 0.6, 32, rng.uniform(1, 1.5)), offset=(0, 0, -0.6)))
    return join(pieces)


def tree(rng: Rng) -> Part:
    """Forking, tapering branches, with or without leaves: trees, corals, antlers."""
    pieces: list[Part] = []
    leaf_kind = int(rng.integers(4))  # 1: balls, 2: leaves, others: bare
    spread, shrink = rng.uniform(0.3, 0.9), rng.uniform(0.6, 0.8)
    depth = int(rng.integers(3, 6))

    def branch(start: Array, direction: Array, length: float, radius: float, level: int) -> None:
        bend = direction + rng.normal(0, 0.15, 3)
        middle = start + direction * length / 2
        end = middle + bend / np.linalg.norm(bend) * length / 2
        taper = np.array([1, 0.85, 0.7]) * radius
        pieces.append(parts.sweep(np.stack([start, middle, end]), parts.round_outline(8), taper))
        if level == 0:
            if leaf_kind == 1:
                pieces.append(moved(parts.sphere(8), length * 0.6, end))
            elif leaf_kind == 2:
                pieces.append(moved(leaf(rng), parts.random_rotation(rng) * length * 0.5, end))
            return
        for _ in range(int(rng.integers(2, 4))):
            way = bend + rng.normal(0, spread, 3)
            way /= np.linalg.norm(way)
            branch(end, way, length * shrink * rng.uniform(0.8, 1.1), radius * 0.65, level - 1)

    branch(np.zeros(3), np.array([0, 0, 1.0]), 1.0, rng.uniform(0.04, 0.14), depth)
    return join(pieces)
