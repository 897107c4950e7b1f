"""Repetitive structures: rods, boxes, strokes on a board, copies of one part."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bobrossnet.learn.shapes.meshes import parts
from bobrossnet.learn.shapes.meshes.geometric import ngon_solid, turned
from bobrossnet.learn.shapes.meshes.mechanical import fastener, flange, robot_arm
from bobrossnet.learn.shapes.meshes.parts import Part, Rng, join, moved, ring, rotation
from bobrossnet.learn.shapes.meshes.plants import leaf


def truss(rng: Rng) -> Part:
    """Rods between points: towers, ladders, fences, cages, wire frames, molecules."""
    kind = (_tower, _cage, _molecule, _fence)[rng.integers(4)]
    return join(kind(rng, rng.uniform(0.008, 0.06)))


def _tower(rng: Rng, thick: float) -> list[Part]:
    """A tower or a beam of 3 to 5 sides, with diagonals."""
    levels, corners = int(rng.integers(3, 9)), int(rng.integers(3, 6))
    waist = rng.uniform(0.3, 1)
    outline = parts.round_outline(corners) * 0.5
    rings = [np.c_[outline * (1 + (waist - 1) * i / levels), np.full(corners, 0.5 * i)] for i in range(levels + 1)]
    pieces = []
    for i in range(levels):
        low, high = rings[i], rings[i + 1]
        for j in range(corners):
            k = (j + 1) % corners
            pieces += [parts.rod(a, b, thick) for a, b in ((low[j], high[j]), (high[j], high[k]), (low[j], high[k]))]
    return pieces


def _cage(rng: Rng, thick: float) -> list[Part]:
    """Hoops along the meridians and some parallels of a ball."""
    count = int(rng.integers(4, 16))
    hoop = parts.torus(1, thick, 64, 8)
    meridians = [moved(hoop, rotation(2, np.pi * i / count) @ rotation(0, np.pi / 2)) for i in range(count)]
    return meridians + [moved(hoop, np.sqrt(1 - z * z), (0, 0, z)) for z in rng.uniform(-0.95, 0.95, 4)]


def _molecule(rng: Rng, thick: float) -> list[Part]:
    """Balls, with sticks to the nearest two."""
    points = rng.uniform(-1, 1, (int(rng.integers(5, 25)), 3))
    ball = moved(parts.sphere(16), rng.uniform(0.06, 0.2))
    pieces = [moved(ball, offset=point) for point in points]
    for point in points:
        near = np.argsort(((points - point) ** 2).sum(1))[1:3]  # [0] is the ball itself
        pieces += [parts.rod(point, points[j], thick) for j in near]
    return pieces


def _fence(rng: Rng, thick: float) -> list[Part]:
    """A grating of vertical and horizontal bars, sometimes two."""
    count = int(rng.integers(5, 25))
    pieces = [parts.rod(np.array([x, 0, -1]), np.array([x, 0, 1]), thick) for x in np.linspace(-1, 1, count)]
    across = int(rng.integers(2, count))
    pieces += [parts.rod(np.array([-1, 0, z]), np.array([1, 0, z]), thick) for z in np.linspace(-0.9, 0.9, across)]
    if rng.random() < 0.5:
        pieces = [moved(piece, offset=(0, y, 0)) for piece in pieces for y in (-0.4, 0.4)]
    return pieces


def stack(rng: Rng) -> Part:
    """Boxes on boxes at odd angles, books, crates, bricks, stairs."""
    pieces: list[Part] = []
    kind = rng.integers(3)  # a pile, stairs or a heap
    z = 0.0
    for i in range(int(rng.integers(3, 20))):
        w, d, h = rng.uniform(0.3, 1, 3) * (1, 1, 0.4)
        if kind == 0:
            turn = rotation(2, rng.uniform(0, 0.8))
            pieces.append(moved(parts.box(w, d, h, 0.02), turn, (*rng.uniform(-0.1, 0.1, 2), z + h / 2)))
        elif kind == 1:
            pieces.append(moved(parts.box(0.4, 1.2, 0.15 * (i + 1)), offset=(0.4 * i, 0, 0.075 * (i + 1))))
        else:
            pieces.append(moved(parts.box(w, d, h), parts.random_rotation(rng), rng.uniform(-0.7, 0.7, 3)))
        z += h
    return join(pieces)


def glyphs(rng: Rng) -> Part:
    """Small square strokes raised on a board: lettering, circuits, keyboards, mazes, carved reliefs."""
    rows, columns = int(rng.integers(6, 48)), int(rng.integers(6, 64))
    kind = rng.integers(3)
    if kind == 0:  # noise
        picture = rng.random((rows, columns)) < rng.uniform(0.2, 0.6)
    elif kind == 1:  # letters: random 5x3 patterns with gaps
        letters = rng.random((max(rows // 6, 1), max(columns // 4, 1), 5, 3)) < 0.6
        cells = np.pad(letters, ((0, 0), (0, 0), (0, 1), (0, 1)))
        picture = cells.transpose(0, 2, 1, 3).reshape(letters.shape[0] * 6, -1)
    else:  # keys
        i, j = np.mgrid[:rows, :columns]
        step = int(rng.integers(2, 5))
        picture = (i % step > 0) & (j % step > 0)
    picture[0, 0] = True  # never empty
    size = 2 / max(picture.shape)
    height = rng.uniform(0.5, 4) * size
    relief = parts.bitmap(picture, size, height)
    if rng.random() < 0.25:
        return relief
    w, d = (picture.shape[0] + 2) * size, (picture.shape[1] + 2) * size
    board = parts.box(w * 1.05, d * 1.05, height * 2, rng.choice([0, 0.03]))
    return join([relief, moved(board, offset=(w / 2, d / 2, -height))])


def array(rng: Rng) -> Part:
    """Copies of one part, in a grid or a ring: chess boards, key caps, fans, flowers, chandeliers."""
    kinds: list[Callable[[Rng], Part]] = [turned, ngon_solid, flange, robot_arm, leaf, stack, fastener]
    part = parts.fitted(kinds[rng.integers(len(kinds))](rng))
    if rng.random() < 0.5:
        count = int(rng.integers(3, 14))
        tilted = moved(part, rotation(1, rng.uniform(0, np.pi)))
        return join([*ring(tilted, rng.uniform(1, 4), count), parts.cylinder(rng.uniform(0.5, 3), 0.3, 48)])
    nx, ny = int(rng.integers(2, 6)), int(rng.integers(1, 6))
    gap = rng.uniform(1.6, 3)
    pieces = [
        moved(part, rotation(2, rng.integers(4) * np.pi / 2), (gap * i, gap * j, 0))
        for i in range(nx)
        for j in range(ny)
    ]
    floor = parts.box(gap * nx, gap * ny, 0.2, 0.05)
    return join([*pieces, moved(floor, offset=(gap * (nx - 1) / 2, gap * (ny - 1) / 2, -1))])
