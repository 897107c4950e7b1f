"""Tubes: pipes, springs, wickerwork, frames, cables, trees, knots, chairs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.learn.shapes.splines import parts
from bobrossnet.learn.shapes.splines.parts import Rng, Values
from bobrossnet.tracing.scene import SceneLike


def pipes(rng: Rng) -> SceneLike:
    """Pipes on a grid with round bends, flanges and tanks."""
    pieces: list[bob.Shape | bob.Instance] = []
    cells = int(rng.integers(2, 6))
    taken: set[tuple[int, ...]] = set()
    steps = np.concatenate([np.eye(3, dtype=int), -np.eye(3, dtype=int)])
    for _ in range(int(rng.integers(1, 8))):
        at = rng.integers(0, cells, 3)
        corners = [at]
        radius = rng.uniform(0.08, 0.28)
        for _ in range(int(rng.integers(3, 14))):
            free = [p for p in at + steps if (p >= 0).all() and (p < cells).all() and tuple(p) not in taken]
            if not free:
                break
            at = free[rng.integers(len(free))]
            taken.add(tuple(at.tolist()))
            corners.append(at)
        if len(corners) < 2:
            continue
        path = np.array(corners, np.float64)
        turns = np.append(True, np.append(np.any(np.diff(path, 2, axis=0), axis=1), True))
        pieces.append(parts.pipe(path[turns], radius, rng.uniform(max(0.3, 1.2 * radius), 0.5)))
        flange = parts.lathe([(0, -0.06), (radius * 1.6, -0.06), (radius * 1.6, 0.06), (0, 0.06)])
        for end, after in ((path[0], path[1]), (path[-1], path[-2])):
            along = after - end
            turned = bob.Instance(flange)
            if along[2] == 0:
                turned = turned.rotate(np.pi / 2, (-along[1], along[0], 0))
            pieces.append(turned.translate(end))
    if rng.random() < 0.4 or not pieces:
        tank = parts.lathe([(0, -0.1), (0.8, 0), (0.8, 0.6), (0.8, 1.6), (0.8, 2.2), (0, 2.3)], int(rng.integers(1, 4)))
        pieces.append(bob.Instance(tank).translate((-1, rng.uniform(0, cells), 0)))
    return pieces


def spring(rng: Rng) -> SceneLike:
    """Coils: straight, conical or barrel-shaped, in a row or nested, sometimes between plates."""
    pieces: list[bob.Shape | bob.Instance] = []
    count = int(rng.integers(1, 4))
    apart, height = bool(rng.random() < 0.4), rng.uniform(1, 3)
    for i in range(count):
        turns = rng.uniform(3, 12)
        t = np.linspace(0, 1, int(turns * 8) + 1)
        radius = (0.6 if apart else 0.9 - 0.25 * i) * (
            1 + rng.uniform(-0.5, 0.3) * t + rng.uniform(-0.3, 0.3) * np.sin(np.pi * t)
        )
        angle = 2 * np.pi * turns * t
        path = np.stack([radius * np.cos(angle), radius * np.sin(angle), height * t], axis=1)
        wire = min(rng.uniform(0.03, 0.12), 0.42 * height / turns)
        pieces.append(bob.Instance(parts.curve(path, wire)).translate((1.5 * i * apart, 0, 0)))
    if rng.random() < 0.5:
        plate = bob.Instance(parts.extruded([parts.random_outline(rng, 1.3)], 0.12))
        plate = plate.scale((count if apart else 1, 1, 1)).translate((0.75 * (count - 1) * apart, 0, 0))
        pieces += [plate.translate((0, 0, -0.12)), plate.translate((0, 0, height))][: rng.integers(1, 3)]
    if rng.random() < 0.3:
        pieces.append(bob.polyline([(0, 0, -0.2), (0, 0, height + 0.4)], rng.uniform(0.05, 0.15)))
    return pieces


def basket(rng: Rng) -> SceneLike:
    """Wickerwork or wire on a surface of revolution: staves, hoops or a weave, with an optional handle or floor."""
    staves, hoops = int(rng.integers(6, 22)) * 2, int(rng.integers(3, 13))
    height, wire = rng.uniform(0.6, 2), rng.uniform(0.015, 0.04)
    lower, middle, upper = rng.uniform(0.4, 1, 3)
    weave = wire * 1.1 if rng.random() < 0.6 else 0.0
    twist = rng.choice([0, 0, 1.5])

    def form(s: Values, angle: Values, out: Values | float = 0.0) -> Values:
        """Return points at heights s, 0..1, and angles, offset outwards."""
        r = lower * (1 - s) ** 2 + 2 * middle * s * (1 - s) + upper * s**2 + out
        return np.stack([r * np.cos(angle), r * np.sin(angle), height * s], axis=1)

    s = np.linspace(0, 1, 6)
    pieces: list[bob.Shape | bob.Instance] = []
    for turn in (twist, -twist)[: 2 if twist else 1]:
        stave = parts.curve(form(s, turn * s), wire)
        pieces += parts.around(stave, staves // (2 if twist else 1))
    angle = np.arange(staves) * 2 * np.pi / staves
    for i in range(hoops + 1):
        wave = weave * np.cos(np.pi * (np.arange(staves) + i))
        pieces.append(parts.ring(form(np.full(staves, i / hoops), angle, wave), wire))
    pieces.append(parts.ring(form(np.full(12, 1.0), np.arange(12) * np.pi / 6), wire * 2))
    if rng.random() < 0.5:
        top = height * rng.uniform(1.5, 2.2)
        handle = [(-upper, 0, height), (-upper, 0, top), (upper, 0, top), (upper, 0, height)]
        pieces.append(parts.curve(handle, wire * 2))
    if rng.random() < 0.5:
        pieces.append(bob.Brep([parts.flat([parts.circle(lower)])]))
    if rng.random() < 0.4:
        for _ in range(int(rng.integers(2, 7))):
            fruit = bob.Instance(parts.ball(rng.uniform(0.15, 0.3)))
            pieces.append(fruit.translate((*rng.uniform(-0.3, 0.3, 2), rng.uniform(0.25, 0.8) * height)))
    return pieces


def scaffold(rng: Rng) -> SceneLike:
    """A frame of straight or bent bars over a lattice: a scaffold, crane, dome or cage, with balls at its joints."""
    pieces: list[bob.Shape | bob.Instance] = []
    counts = rng.integers(2, 5, 3) if rng.random() < 0.5 else np.array([2, 2, rng.integers(4, 9)])
    wire, kept, crossed = rng.uniform(0.02, 0.07), rng.uniform(0.7, 1), rng.random() < 0.6
    bend, taper, twist = rng.uniform(-0.15, 0.15, 2), rng.uniform(0, 0.8), rng.choice([0, rng.uniform(-1, 1)])
    middle = (counts - 1) / 2

    def place(cell: NDArray[Any]) -> Values:
        """Return the position of a lattice joint: higher ones are narrower, more twisted and more bent."""
        x, y, z = cell - middle
        s = cell[2] / (counts[2] - 1)
        size, angle = 1 - taper * s, twist * s * 2
        turned = size * np.array([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)])
        return np.append(turned + bend * z**2, z)

    joints = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3)
    steps = [(1, 0, 0), (0, 1, 0), (0, 0, 1)] + [(1, 0, 1), (0, 1, 1), (-1, 0, 1), (0, -1, 1)][
        :: rng.integers(1, 3)
    ] * crossed
    for joint in joints:
        for step in steps:
            end = joint + step
            if (end >= 0).all() and (end < counts).all() and rng.random() < kept:
                thin = 1.0 if sum(np.abs(step)) == 1 else 0.6
                pieces.append(bob.polyline([place(joint), place(end)], wire * thin))
    if rng.random() < 0.5 or not pieces:
        ball = bob.Instance(parts.ball(wire * rng.uniform(1.5, 4)))
        pieces += [ball.translate(place(joint)) for joint in joints]
    if rng.random() < 0.4:
        plank = bob.Instance(parts.box((counts[0] - 1, 0.4, 0.05)))
        for level in range(1, int(counts[2])):
            pieces.append(
                plank.scale((1 - taper * level / (counts[2] - 1), 1, 1)).translate(place(np.append(middle[:2], level)))
            )
    return pieces


def bicycle(rng: Rng) -> SceneLike:
    """Two or three wheels with spokes, a frame of tubes, handlebars, a saddle."""
    radius, reach = rng.uniform(0.4, 0.75), rng.uniform(1.5, 2.4)
    thickness, wire = rng.uniform(0.02, 0.08), rng.uniform(0.03, 0.07)
    wheel = [
        bob.Instance(parts.torus(radius, thickness)),
        bob.Instance(bob.polyline([(0, 0, -0.1), (0, 0, 0.1)], 0.05)),
    ]
    spokes = int(rng.integers(3, 25))
    wheel += parts.around(
        bob.polyline([(0, 0, 0.06 * rng.integers(0, 2)), (radius, 0, 0)], 0.008 + 0.04 / spokes), spokes
    )
    rear, front = np.array([0, 0, radius]), np.array([reach, 0, radius])
    pieces: list[bob.Shape | bob.Instance] = []
    places = [rear, front] if rng.random() < 0.75 else [rear + (0, 0.5, 0), rear - (0, 0.5, 0), front]
    for place in places:
        pieces += [part.rotate(np.pi / 2, (1, 0, 0)).translate(place) for part in wheel]
    if len(places) == 3:
        pieces.append(bob.polyline(places[:2], wire))
    head = np.array([reach * rng.uniform(0.7, 0.9), 0, radius * 2 + rng.uniform(0.2, 0.5)])
    seat = np.array([reach * rng.uniform(0.15, 0.35), 0, head[2] + rng.uniform(-0.3, 0.1)])
    crank = np.array([reach * rng.uniform(0.35, 0.5), 0, radius * rng.uniform(0.7, 1.1)])
    for a, b in ((rear, crank), (rear, seat), (crank, seat), (crank, head), (seat * 0.8 + crank * 0.2, head)):
        pieces.append(bob.polyline([a, b], wire))
    top = head + (-0.05, 0, rng.uniform(0.15, 0.5))
    pieces.append(parts.pipe([front, head, top], wire, 0.2))
    sweep = rng.uniform(-0.4, 0.3)
    pieces.append(
        parts.pipe([top + (sweep, y, z) for y, z in ((-0.5, 0.1), (-0.3, 0), (0.3, 0), (0.5, 0.1))], wire, 0.1)
    )
    pieces.append(bob.polyline([top, top + (sweep, 0, 0)], wire))
    saddle = bob.Instance(parts.ball()).scale((0.28, 0.14, 0.06)).translate(seat + (0, 0, 0.14))
    pieces += [bob.polyline([seat, seat + (0, 0, 0.1)], wire), saddle]
    disc = bob.Instance(parts.extruded([parts.smooth(parts.star(18, 0.15) * 0.2, 2), parts.circle(0.1)], 0.03))
    pieces.append(disc.rotate(np.pi / 2, (1, 0, 0)).translate(crank + (0, 0.08, 0)))
    if rng.random() < 0.5:
        angle = np.linspace(-0.6, 2.8, 8)[:, None]
        arc = (radius + thickness + 0.06) * np.concatenate([np.cos(angle), 0 * angle, np.sin(angle)], axis=1)
        guard = np.stack([arc + (0, y, 0) for y in (-0.1, 0.1)], axis=1)
        pieces += [bob.Instance(bob.Brep([parts.surface(guard, (3, 1))])).translate(place) for place in places]
    return pieces


def cables(rng: Rng) -> SceneLike:
    """Loose cables between two sockets, a rope of strands, or a tangle."""
    pieces: list[bob.Shape | bob.Instance] = []
    count, kind = int(rng.integers(3, 16)), rng.integers(3)
    if kind == 0:
        for i in range(count):
            a, b = (
                np.array([-1.5, (i - count / 2) * 0.2, 0]),
                np.array([1.5, (rng.integers(count) - count / 2) * 0.2, 0]),
            )
            middle = [a + (0.6, 0, 0), *rng.normal(0, 0.4, (int(rng.integers(2, 5)), 3)), b - (0.6, 0, 0)]
            pieces.append(parts.curve([a, *middle, b], rng.uniform(0.03, 0.08)))
        socket = bob.Instance(parts.box((0.3, 0.2 * count + 0.2, 0.5))).translate((0, -0.1, -0.25))
        return [*pieces, socket.translate((-1.6, 0, 0)), socket.translate((1.6, 0, 0))]
    if kind == 1:
        strands, turns, bend = int(rng.integers(2, 7)), rng.uniform(1, 5), rng.uniform(-1, 1)
        t = np.linspace(0, 1, int(turns * 8) + 2)
        frayed = 0.2 + rng.uniform(0, 0.7) * np.maximum(0, t - rng.uniform(0.6, 0.9)) * 4
        for i in range(strands):
            angle = 2 * np.pi * (turns * t + i / strands)
            path = [frayed * np.cos(angle), frayed * np.sin(angle) + bend * np.sin(3 * t), 3 * t]
            pieces.append(parts.curve(np.stack(path, axis=1), 0.19 * np.sin(np.pi / strands) + 0.02))
        return pieces
    wire = rng.uniform(0.03, 0.1)
    for _ in range(int(rng.integers(1, 5))):
        ball = rng.normal(0, 1, (int(rng.integers(8, 30)), 3))
        pieces.append(parts.ring(ball / np.linalg.norm(ball, axis=1, keepdims=True) * rng.uniform(0.7, 1.2), wire))
    return pieces


def branches(rng: Rng) -> SceneLike:
    """A tree or coral of tapering, bent tubes, with optional fruit or leaves."""
    pieces: list[bob.Shape | bob.Instance] = []
    spread, bend = rng.uniform(0.35, 0.9), rng.uniform(0.05, 0.25)
    fork, shrink, lift = int(rng.integers(2, 4)), rng.uniform(0.6, 0.8), rng.uniform(0, 0.4)
    levels = int(rng.integers(4, 7 if fork == 2 else 5))
    tips: list[Values] = []

    def grow(foot: Values, along: Values, length: float, radius: float, level: int) -> None:
        end = foot + along * length
        knee = foot + along * length / 2 + rng.normal(0, bend * length, 3)
        pieces.append(
            parts.curve([foot, foot + along * length * 0.2, knee, end], [radius, radius, radius * 0.8, radius * 0.68])
        )
        if level == 0:
            tips.append(end)
            return
        for _ in range(fork):
            turned = along + rng.normal(0, spread, 3) + (0, 0, lift)
            turned /= np.linalg.norm(turned)
            grow(end, turned, length * rng.uniform(0.85, 1.1) * shrink, radius * 0.68, level - 1)

    grow(np.zeros(3), np.array([0, 0, 1.0]), 1.0, rng.uniform(0.06, 0.16), levels - 1)
    ornament = rng.integers(4)
    if ornament == 1:
        pieces += [bob.Instance(parts.ball(rng.uniform(0.04, 0.14))).translate(tip) for tip in tips]
    elif ornament == 2:
        s, t = np.linspace(0, 1, 4)[:, None], np.linspace(-1, 1, 3)
        net = [s + 0 * t, 0.4 * t * np.sin(np.pi * np.clip(s, 0.05, 0.95)), 0.15 * t**2 - 0.2 * s**2]
        leaf = bob.Instance(bob.Brep([parts.surface(np.stack(net, axis=2), (3, 2))]))
        for tip in tips:
            for _ in range(2):
                turned = leaf.scale(rng.uniform(0.15, 0.4)).rotate(rng.uniform(-1, 1), (0, 1, 0))
                pieces.append(turned.rotate(rng.uniform(0, 6)).translate(tip))
    if rng.random() < 0.4:
        pot = [(0, -0.3), (0.3, -0.3), (0.45, 0.2), (0.5, 0.2), (0.5, 0.3), (0.4, 0.3), (0.38, 0.15), (0, 0.15)]
        pieces.append(parts.lathe(pot))
    return pieces


def knot(rng: Rng) -> SceneLike:
    """Torus knots or Lissajous knots, of round tubes or of swept stars and bands."""
    kind = rng.integers(3)
    if kind < 2:
        p, q = ((2, 3), (3, 2), (2, 5), (3, 4), (5, 2), (3, 5), (1, 6), (2, 7))[rng.integers(8)]
        count = 14 * max(p, q)
        t = np.arange(count) * 2 * np.pi / count
        radius = 1 + rng.uniform(0.3, 0.5) * np.cos(q * t)
        path = np.stack([radius * np.cos(p * t), radius * np.sin(p * t), rng.uniform(0.3, 0.6) * np.sin(q * t)], axis=1)
    else:
        a, b, c = ((3, 2, 7), (3, 4, 7), (3, 5, 7), (2, 3, 5))[rng.integers(4)]
        t = np.arange(96) * 2 * np.pi / 96
        phases = rng.uniform(0.2, 1.3, 2)
        path = np.stack([np.cos(a * t + phases[0]), np.cos(b * t + phases[1]), 0.6 * np.cos(c * t)], axis=1)
    thickness = rng.uniform(0.04, 0.13)
    if rng.random() < 0.5:
        pieces: list[bob.Shape] = [parts.ring(path, thickness, int(rng.integers(1, 5)))]
        if rng.random() < 0.3:
            pieces += [parts.ring(path + rng.normal(0, 0.05, 3), thickness / 2)]
        return pieces
    section = (
        parts.star(int(rng.integers(3, 6)), rng.uniform(0, 0.6))
        if rng.random() < 0.6
        else parts.polygon(8) * (0.3, 1.5)
    )
    turns = 2 * np.pi * rng.integers(-6, 7) * np.arange(len(path)) / len(path)
    return bob.Brep([parts.swept(section, path, thickness * 1.4, turns, closed=True)])


def chair(rng: Rng) -> SceneLike:
    """A chair, stool or bench of bent tubes with a curved seat and back."""
    width, depth = rng.uniform(0.8, 2.2), rng.uniform(0.8, 1.1)
    height, back, wire = rng.uniform(0.6, 1.1), rng.uniform(0.6, 1.5), rng.uniform(0.025, 0.06)
    lean, w, kind = rng.uniform(0, 0.35), width / 2, rng.integers(3)
    pieces: list[bob.Shape | bob.Instance] = []
    for y in (-w, w):
        if kind == 0:  # four legs
            pieces += [
                parts.pipe([(0, y, 0), (0.05, y, height), (-lean, y, height + back)], wire, 0.2),
                parts.pipe([(depth, y, 0), (depth, y, height), (0, y, height)], wire, 0.2),
            ]
        elif kind == 1:  # one bent cantilever tube
            pieces.append(
                parts.pipe(
                    [(0, y, 0), (depth, y, 0), (depth, y, height), (0, y, height), (-lean, y, height + back)],
                    wire,
                    0.25,
                )
            )
        else:  # arms
            pieces += [
                parts.pipe([(0, y, 0), (0, y, height), (-lean, y, height + back)], wire, 0.1),
                parts.pipe([(depth, y, 0), (depth, y, height + 0.45), (0, y, height + 0.45)], wire, 0.3),
            ]
    bars = [(0, height), (depth, height), (-lean, height + back)] + ([(0, 0), (depth, 0)] if kind == 1 else [])
    pieces += [bob.polyline([(x, -w, z), (x, w, z)], wire) for x, z in bars]
    s, t = np.linspace(0, 1, 4)[:, None], np.linspace(-1, 1, 4)
    sag = rng.uniform(0, 0.15) * (1 - t**2) * np.sin(np.pi * s)
    if rng.random() < 0.7:
        seat = np.stack([s * depth + 0 * t, w * t + 0 * s, height + wire - sag], axis=2)
        pieces.append(bob.Brep([parts.surface(seat, (3, 3))]))
    else:
        pieces += [bob.polyline([(x, -w, height), (x, w, height)], wire) for x in np.linspace(0, depth, 8)]
    style = rng.integers(3)
    if style == 0:
        low, high = sorted(rng.uniform(0.1, 1, 2))
        rise = low + (high + 0.1 - low) * s
        rest = np.stack([-lean * rise - 2 * sag, w * t + 0 * s, height + back * rise + 0 * t], axis=2)
        face = parts.surface(rest)
        cut = parts.random_outline(rng, 0.3, (0.5, 0.5))
        loops = [parts.smooth([(0, 0), (1, 0), (1, 1), (0, 1)], 1), cut]
        pieces.append(
            bob.Brep([parts.surface(rest, trims=[[loop] for loop in loops])])
            if rng.random() < 0.5
            else bob.Brep([face])
        )
    elif style == 1:
        for y in np.linspace(-w, w, int(rng.integers(4, 12)))[1:-1]:
            pieces.append(bob.polyline([(0, y, height), (-lean, y, height + back)], wire * 0.6))
    else:
        for a in np.linspace(0.2, 0.9, int(rng.integers(2, 6))):
            pieces.append(
                parts.curve(
                    [
                        (-lean * a, -w, height + back * a),
                        (-lean * a - 0.15, 0, height + back * a),
                        (-lean * a, w, height + back * a),
                    ],
                    wire * 0.8,
                )
            )
    if rng.random() < 0.4:
        table = parts.extruded([parts.random_outline(rng, 0.8)], 0.06)
        pieces += [
            bob.Instance(table).translate((depth + 1.1, 0, height + 0.3)),
            *(
                leg.translate((depth + 1.1, 0, 0))
                for leg in parts.around(bob.polyline([(0.5, 0, 0), (0.2, 0, height + 0.3)], wire), 3)
            ),
        ]
    return pieces
