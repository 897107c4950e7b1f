"""Furniture and buildings."""

from __future__ import annotations

import numpy as np

from bobrossnet.learn.shapes.meshes import parts
from bobrossnet.learn.shapes.meshes.geometric import turned
from bobrossnet.learn.shapes.meshes.parts import Part, Rng, join, moved, ring, rotation


def furniture(rng: Rng) -> Part:
    """Tables, chairs, shelves, beds: boards on legs."""
    w, d, h = rng.uniform(0.6, 2, 3)
    board, leg = rng.uniform(0.03, 0.15), rng.uniform(0.03, 0.1)
    bevel = rng.choice([0, 0.02, 0.05])
    pieces = [moved(parts.box(w, d, board, bevel), offset=(0, 0, h))]
    leg_sides, splay = 12 if rng.random() < 0.4 else 4, rng.uniform(0.9, 1.2)
    for sx in (-1, 1):
        for sy in (-1, 1):
            top = np.array([sx * (w / 2 - leg), sy * (d / 2 - leg), h])
            pieces.append(parts.rod(top * (splay, splay, 0), top, leg, leg_sides))
    if rng.random() < 0.6:  # a back, of one board or of slats
        slats = int(rng.choice([1, 1, 3, 6]))
        slat = parts.box(board, d / slats * (1 if slats == 1 else 0.5), h, bevel)
        pieces += [moved(slat, offset=(-w / 2, d * ((i + 0.5) / slats - 0.5), 1.5 * h)) for i in range(slats)]
    for level in range(int(rng.integers(0, 4))):  # shelves or rungs
        shelf = parts.box(w * 0.95, d * rng.choice([0.05, 0.95]), board)
        pieces.append(moved(shelf, offset=(0, 0, h * (level + 0.5) / 4)))
    for _ in range(int(rng.integers(0, 5))):  # objects on it
        size = rng.uniform(0.1, 0.35)
        thing = parts.box(1, 1, 1, bevel) if rng.random() < 0.5 else moved(turned(rng), 0.7)
        at = rng.uniform(-0.4, 0.4) * w, rng.uniform(-0.4, 0.4) * d, h + board / 2 + size / 4
        pieces.append(moved(thing, size, at))
    if rng.random() < 0.3:  # a cushion
        pieces.append(moved(parts.box(w * 0.9, d * 0.9, 2 * board, board), offset=(0, 0, h + board)))
    return join(pieces)


def building(rng: Rng) -> Part:
    """Blocks with rows of windows, ledges, roofs and columns: houses, towers, circuit boards."""
    pieces: list[Part] = []
    for _ in range(int(rng.integers(1, 6))):
        pieces += _block(rng)
    if rng.random() < 0.4:
        column = parts.cylinder(0.06, rng.uniform(0.5, 2), 16)
        pieces += ring(column, rng.uniform(0.8, 1.4), int(rng.integers(4, 14)))
    if rng.random() < 0.5:  # the ground
        pieces.append(moved(parts.box(2.4, 2.4, 0.1), offset=(0, 0, -0.05)))
    return join(pieces)


def _block(rng: Rng) -> list[Part]:
    """One wing of a building: a box, slightly raised windows, a roof."""
    w, d, h = rng.uniform(0.3, 1, 3) * (1, 1, 2)
    at = np.array([*rng.uniform(-0.8, 0.8, 2), 0])
    block = [moved(parts.box(w, d, h, rng.choice([0, 0, 0.04])), offset=(0, 0, h / 2))]
    rows, columns = int(rng.integers(0, 7)), int(rng.integers(1, 6))
    front = parts.box(w / columns * 0.5, d * 1.04, h / max(rows, 1) * 0.55)
    side = parts.box(w * 1.04, d / columns * 0.5, h / max(rows, 1) * 0.55)
    for i in range(rows):
        for j in range(columns):
            z = h * (i + 0.5) / rows
            block.append(moved(front, offset=(w * ((j + 0.5) / columns - 0.5), 0, z)))
            block.append(moved(side, offset=(0, d * ((j + 0.5) / columns - 0.5), z)))
    top = rng.integers(4)  # a pyramid, a ledge, battlements or no top
    if top == 0:
        roof = parts.cylinder(0.75, rng.uniform(0.3, 1.2), 4, rng.choice([0, 0.3]))
        block.append(moved(moved(roof, rotation(2, np.pi / 4)), np.diag([w, d, 1.0]), (0, 0, h)))
    elif top == 1:
        block.append(moved(parts.box(w * 1.15, d * 1.15, 0.08), offset=(0, 0, h)))
    elif top == 2:
        merlon = parts.box(w / 7, d, 0.12)
        block += [moved(merlon, offset=(w * (i / 3 - 1) / 2.3, 0, h + 0.05)) for i in range(0, 7, 2)]
    return [moved(piece, offset=at) for piece in block]
