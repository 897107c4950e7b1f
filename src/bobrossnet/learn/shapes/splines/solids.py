"""Closed solids of flat and extruded faces: brackets, letters, gears, houses, engines."""

from __future__ import annotations

import numpy as np

import bobrossnet as bob
from bobrossnet.learn.shapes.splines import parts
from bobrossnet.learn.shapes.splines.parts import Rng, Values
from bobrossnet.tracing.scene import SceneLike

_LETTERS = {
    "L": [(0, 0), (3, 0), (3, 1), (1, 1), (1, 4), (0, 4)],
    "T": [(1, 0), (2, 0), (2, 3), (3, 3), (3, 4), (0, 4), (0, 3), (1, 3)],
    "H": [(0, 0), (1, 0), (1, 1.5), (2, 1.5), (2, 0), (3, 0), (3, 4), (2, 4), (2, 2.5), (1, 2.5), (1, 4), (0, 4)],
    "E": [
        (0, 0),
        (3, 0),
        (3, 0.9),
        (1, 0.9),
        (1, 1.6),
        (2.5, 1.6),
        (2.5, 2.4),
        (1, 2.4),
        (1, 3.1),
        (3, 3.1),
        (3, 4),
        (0, 4),
    ],
    "U": [(0, 0), (3, 0), (3, 4), (2, 4), (2, 1), (1, 1), (1, 4), (0, 4)],
    "S": [
        (0, 0),
        (3, 0),
        (3, 2.4),
        (1, 2.4),
        (1, 3.1),
        (3, 3.1),
        (3, 4),
        (0, 4),
        (0, 1.6),
        (2, 1.6),
        (2, 0.9),
        (0, 0.9),
    ],
    "Z": [(0, 0), (3, 0), (3, 1), (1.3, 1), (3, 3), (3, 4), (0, 4), (0, 3), (1.7, 3), (0, 1)],
    "X": [(0, 0), (1, 0), (1.5, 1.2), (2, 0), (3, 0), (2.1, 2), (3, 4), (2, 4), (1.5, 2.8), (1, 4), (0, 4), (0.9, 2)],
}


def _within(rng: Rng, outline: bob.TrimCurve) -> bob.TrimCurve:
    """Return a smaller copy of an outline, scaled about its origin."""
    return bob.TrimCurve(outline.control_points * rng.uniform(0.3, 0.8), outline.knots, outline.weights)


def _tilted(rng: Rng, pieces: SceneLike) -> SceneLike:
    """Return flat pieces unchanged or tilted, since most cameras look from the side."""
    angle, axis = rng.uniform(0, np.pi / 2) * (rng.random() < 0.7), rng.normal(0, 1, 2)
    return [piece.rotate(angle, (*axis, 0)) for piece in bob.Scene(pieces).instances]


def bracket(rng: Rng) -> SceneLike:
    """Plates with bores and slots, stacked, or with a second plate upright."""
    height = rng.uniform(0.1, 0.6)
    outline = parts.random_outline(rng, 1.0)
    reach = 0.75 * np.linalg.norm(outline.control_points, axis=1).min()
    loops = [outline]
    if rng.random() < 0.4:
        loops.append(_within(rng, outline))
    else:
        holes, circle = int(rng.integers(2, 9)), rng.uniform(0.55, 0.8) * reach
        size = min(rng.uniform(0.05, 0.25), 0.8 * circle * np.sin(np.pi / holes), 0.4 * circle)
        loops += [parts.circle(size, circle * corner) for corner in parts.polygon(holes, rng.uniform(0, 6))]
        loops.append(parts.random_outline(rng, (circle - size) * rng.uniform(0.3, 0.9)))
    plate = bob.Instance(parts.extruded(loops, height))
    pieces = [plate]
    if rng.random() < 0.5:
        pieces.append(plate.scale((rng.uniform(0.5, 0.9),) * 2 + (rng.uniform(0.5, 3),)).translate((0, 0, height)))
    if rng.random() < 0.4:
        upright = [
            parts.rounded([(-0.6, 0), (0.6, 0), (0.6, 1.4), (-0.6, 1.4)], rng.uniform(0.1, 0.55)),
            parts.circle(rng.uniform(0.15, 0.4), (0, 0.8)),
        ]
        stood = bob.Instance(parts.extruded(upright, 0.2)).rotate(np.pi / 2, (1, 0, 0))
        pieces += [stood.translate((0, y, height)) for y in ([0.1] if rng.random() < 0.5 else [-0.4, 0.6])]
    if rng.random() < 0.3:
        studs = bob.Instance(parts.lathe([(0, -0.1), (0.09, -0.1), (0.09, rng.uniform(0.05, 0.4)), (0, 0.2)]))
        pieces += parts.around(studs.translate((1.15 * reach, 0, height)), int(rng.integers(3, 9)))
    return _tilted(rng, pieces)


def letters(rng: Rng) -> SceneLike:
    """Words of thick letters, sharp or rounded, in a row, stacked or around."""
    names, count = list(_LETTERS), int(rng.integers(1, 7))
    cut, depth, kind = rng.choice([0, 0.15, 0.4, 0.5]), rng.uniform(0.3, 2), rng.integers(3)
    pieces = []
    for i in range(count):
        corners = np.array(_LETTERS[names[rng.integers(len(names))]], np.float64) - (1.5, 0)
        letter = bob.Instance(parts.extruded([parts.rounded(corners, cut) if cut else parts.smooth(corners, 1)], depth))
        upright = letter.rotate(np.pi / 2, (1, 0, 0))
        if kind == 0:
            pieces.append(upright.translate((3.5 * i, rng.uniform(-0.5, 0.5), 0)))
        elif kind == 1:
            pieces.append(letter.translate((0, -2, 0)).rotate(rng.uniform(0, 6)).translate((0, 0, depth * i)))
        else:
            pieces.append(upright.translate((0, -count * 0.65, 0)).rotate(2 * np.pi * i / count))
    return pieces


def _gear(rng: Rng, teeth: int, radius: float, height: float) -> list[bob.Instance]:
    """Return a gear about z with spline teeth, a bore, and optional openings or hub."""
    degree, depth = int(rng.integers(1, 4)), min(0.25, 3.5 / teeth)
    corners = parts.polygon(4 * teeth)
    corners *= np.tile([1, 1, 1 - depth, 1 - depth], teeth)[:, None] * radius
    inner = radius * (1 - depth)
    loops = [parts.smooth(corners, degree), parts.circle(inner * rng.uniform(0.1, 0.25))]
    if rng.random() < 0.6:
        spokes = int(rng.integers(3, 8))
        size = min(inner * 0.5 * np.sin(np.pi / spokes), inner * 0.22)
        window = parts.random_outline(rng, size)
        for i in range(spokes):
            angle = 2 * np.pi * i / spokes
            turn = np.array([(np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))])
            loops.append(bob.TrimCurve((window.control_points + (inner * 0.6, 0)) @ turn, window.knots, window.weights))
    pieces = [bob.Instance(parts.extruded(loops, height))]
    if rng.random() < 0.5:
        hub = inner * 0.33
        pieces.append(
            bob.Instance(
                parts.lathe([(hub * 0.6, -0.1), (hub, -0.1), (hub, height + 0.15), (hub * 0.6, height + 0.15)])
            )
        )
    return pieces


def gears(rng: Rng) -> SceneLike:
    """Gears with spline teeth, one or several on their axles."""
    pieces: list[bob.Shape | bob.Instance] = []
    place, module = np.zeros(3), rng.uniform(0.08, 0.14)
    previous, heading = 0.0, rng.uniform(0, 6)
    for _ in range(int(rng.integers(1, 5))):
        teeth, height = int(rng.integers(8, 33)), rng.uniform(0.1, 0.5)
        radius = teeth * module / 2
        if previous:
            heading += rng.uniform(-1.2, 1.2)
            place = place + (previous + radius) * 0.93 * np.array([np.cos(heading), np.sin(heading), 0])
        pieces += [part.rotate(rng.uniform(0, 1)).translate(place) for part in _gear(rng, teeth, radius, height)]
        if rng.random() < 0.6:
            pieces.append(bob.polyline([place - (0, 0, 0.4), place + (0, 0, rng.uniform(0.5, 1.2))], radius * 0.1))
        previous = radius
    if rng.random() < 0.4:
        pieces += [
            part.rotate(np.pi / 2, (1, 0, 0)).translate(place + (0, 0, 0.8)) for part in _gear(rng, 12, 0.8, 0.2)
        ]
    return _tilted(rng, pieces)


def _wall(rng: Rng, width: float, height: float, window: int) -> bob.Brep:
    """Return an upright wall above the x axis with rows of windows, framed or not."""
    columns, rows = max(int(width / rng.uniform(0.35, 0.8)), 1), max(int(height / rng.uniform(0.4, 0.9)), 1)
    step = np.array([width / columns, height / rows])
    loops = [parts.smooth([(0, 0), (width, 0), (width, height), (0, height)], 1)]
    size = step * rng.uniform(0.25, 0.4)
    for i in range(rows):
        for j in range(columns):
            center = step * (j + 0.5, i + 0.5)
            corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * size + center
            if window == 0:
                loops.append(parts.smooth(corners, 1))
            elif window == 1:
                loops.append(parts.rounded(corners, size.min() * 0.8))
            elif window == 2:
                loops.append(parts.circle(float(size.min()), center))
            else:
                loops += [parts.smooth(corners, 1), parts.smooth((corners - center) * 0.7 + center, 1)]
    net = [[(x, 0, z) for z in (0, height)] for x in (0, width)]
    return bob.Brep([bob.Face(net, [0, 0, width, width], [0, 0, height, height], None, [[loop] for loop in loops])])


def house(rng: Rng) -> SceneLike:
    """Towers and houses of flat walls with trimmed windows, on three to eight sides, stepped, with roofs."""
    pieces: list[bob.Shape | bob.Instance] = []
    for _ in range(int(rng.integers(1, 4))):
        sides, window = int(rng.choice([3, 4, 4, 4, 5, 6, 8])), int(rng.integers(4))
        radius, place = rng.uniform(0.7, 1.5), np.array([*rng.uniform(-1.5, 1.5, 2), 0]) * (len(pieces) > 0)
        low = 0.0
        for _ in range(int(rng.integers(1, 4))):
            height, width = rng.uniform(0.6, 2.2), 2 * radius * np.sin(np.pi / sides)
            wall = bob.Instance(_wall(rng, width, height, window))
            wall = wall.translate((-width / 2, -radius * np.cos(np.pi / sides), low))
            pieces += [part.translate(place) for part in parts.around(wall, sides, np.pi / sides + np.pi / 2)]
            rim = radius * rng.uniform(1, 1.15)
            base = parts.polygon(sides) * rim
            low += height
            slab = bob.Instance(parts.extruded([parts.smooth(base, 1)], 0.06))
            pieces.append(slab.translate(place + (0, 0, low)))
            low += 0.06
            radius *= rng.uniform(0.6, 0.95)
        roof = rng.integers(4)
        if roof == 0:
            corners = np.insert(np.concatenate([base, base[:1]]), 2, 0.0, axis=1)
            peak = np.broadcast_to([(0, 0, rng.uniform(0.5, 1.5))], corners.shape)
            spire = bob.Brep([parts.surface(np.stack([corners, peak + corners * 1e-3], axis=1), (1, 1))])
            pieces.append(bob.Instance(spire).translate(place + (0, 0, low)))
        elif roof == 1:
            dome = parts.lathe(
                [(rim * 0.8, 0), (rim * 0.9, 0.5), (0.3, 0.8), (0.1, 1), (0, 1.5)], int(rng.integers(2, 4))
            )
            pieces.append(bob.Instance(dome).translate(place + (0, 0, low)))
        elif roof == 2:
            pieces.append(
                bob.polyline([place + (0, 0, low), place + (0, 0, low + rng.uniform(0.5, 1.5))], [0.06, 0.02])
            )
    if rng.random() < 0.3:
        pieces.append(bob.Instance(parts.box((4, 4, 0.1))).translate((0, 0, -0.1)))
    return pieces


def engine(rng: Rng) -> SceneLike:
    """Finned cylinders on a housing, with bolts, pipes, pulleys and hoses."""
    pieces: list[bob.Shape | bob.Instance] = []
    count, pitch = int(rng.integers(1, 5)), rng.uniform(0.8, 1)
    length = count * pitch + 0.3
    outline = parts.rounded(
        parts.polygon(int(rng.integers(4, 8)), np.pi / 2) * rng.uniform(0.5, 0.8), rng.uniform(0.1, 0.3)
    )
    case = bob.Instance(parts.extruded([outline], length)).rotate(np.pi / 2, (0, 1, 0)).translate((-length / 2, 0, 0))
    pieces.append(case)
    fins, radius = int(rng.integers(3, 10)), rng.uniform(0.2, 0.3)
    profile: list[tuple[float, float]] = [(radius, 0.0)]
    for i in range(fins):
        z = 0.15 + 0.9 * i / fins
        profile += [(radius, z), (radius + 0.12, z), (radius + 0.12, z + 0.4 / fins), (radius, z + 0.4 / fins)]
    profile += [(radius, 1.15), (radius * 0.8, 1.3), (0, 1.3)]
    cylinder = bob.Instance(parts.lathe(profile)).translate((0, 0, 0.35))
    banks: list[float] = [(0,), (-0.6, 0.6), (-1.57, 1.57)][rng.integers(3)]  # type: ignore[assignment]
    for i in range(count):
        x = (i - (count - 1) / 2) * pitch
        pieces += [cylinder.rotate(angle, (1, 0, 0)).translate((x, 0, 0)) for angle in banks]
        bend = rng.uniform(0.15, 0.35)
        ends: Values = np.array([(x, 0, 1.2), (x, 0.8, 1.3), (x, 1.0, -0.4), (length * 0.8, 1.0, -0.4)])
        turned = [
            np.array(
                [
                    p[0],
                    p[1] * np.cos(banks[0]) - p[2] * np.sin(banks[0]),
                    p[1] * np.sin(banks[0]) + p[2] * np.cos(banks[0]),
                ]
            )
            for p in ends
        ]
        pieces.append(parts.pipe(turned, rng.uniform(0.06, 0.1), bend))
    wheel = parts.lathe(
        [(0, 0), (0.5, 0), (0.5, 0.05), (0.42, 0.1), (0.5, 0.15), (0.5, 0.2), (0.15, 0.2), (0.1, 0.3), (0, 0.3)]
    )
    pulley = bob.Instance(wheel).rotate(-np.pi / 2, (0, 1, 0))
    pieces.append(pulley.translate((-length / 2, 0, 0)))
    if rng.random() < 0.6:
        other = np.array([-length / 2, rng.uniform(-0.9, -0.7), rng.uniform(0.4, 0.9)])
        pieces.append(pulley.scale((1, 0.5, 0.5)).translate(other))
        pieces.append(bob.polyline([other, other + (0.35, 0, 0), (0.35 - length / 2, 0, 0)], 0.07))
        far = np.arctan2(other[2], other[1]) + np.linspace(-np.pi / 2, np.pi / 2, 9)
        half = np.stack([0 * far - 0.13, np.cos(far), np.sin(far)], axis=1)
        belt = np.concatenate([other + half * (1, 0.25, 0.25), half * (1, -0.47, -0.47) - (length / 2, 0, 0)])
        pieces.append(bob.polyline(np.concatenate([belt, belt[:1]]), 0.035))
    bolt = parts.extruded([parts.smooth(parts.polygon(6) * 0.07, 1)], 0.08)
    placed = bob.Instance(bolt).rotate(np.pi / 2, (0, 1, 0))
    pieces += [placed.translate((length / 2, *corner)) for corner in parts.polygon(int(rng.integers(4, 10))) * 0.35]
    return pieces
