"""Revolved, lofted and closed surfaces: vessels, hulls, bodies, blobs."""

from __future__ import annotations

import numpy as np

import bobrossnet as bob
from bobrossnet.learn.shapes.splines import parts
from bobrossnet.learn.shapes.splines.parts import Rng, Values
from bobrossnet.tracing.scene import SceneLike


def _profile(rng: Rng) -> Values:
    """Return (n, 2) radii and heights of a bowl, bottle, goblet, lamp or vase, from the foot's centre to the lip."""
    kind, height = rng.integers(5), rng.uniform(0.8, 2.6)
    if kind == 0:
        radii, height = [rng.uniform(0.2, 0.6), rng.uniform(0.5, 1), rng.uniform(0.9, 1.2), 1.2], rng.uniform(0.4, 1)
    elif kind == 1:
        neck = rng.uniform(0.1, 0.3)
        radii = [rng.uniform(0.4, 0.7)] * int(rng.integers(2, 4)) + [rng.uniform(0.3, 0.8), neck, neck, neck * 1.2]
    elif kind == 2:
        stem, cup = rng.uniform(0.04, 0.12), rng.uniform(0.35, 0.7)
        radii = [rng.uniform(0.3, 0.6), stem, stem, stem * rng.uniform(1, 3), stem, cup, cup, cup * rng.uniform(0.6, 1)]
    elif kind == 3:
        stem = rng.uniform(0.05, 0.2)
        radii = [0.6, 0.5, stem, stem * 2.5, stem, stem, rng.uniform(0.7, 1), rng.uniform(0.3, 0.5)]
    else:
        radii = list(rng.uniform(0.2, 0.9, int(rng.integers(4, 9))))
    heights = np.linspace(0, height, len(radii)) + np.append(0, rng.uniform(-0.04, 0.04, len(radii) - 1))
    return np.array([(0.0, 0.0), (radii[0] * 0.9, 0.0), *zip(radii, heights, strict=True)])


def vessel(rng: Rng) -> SceneLike:
    """A vase, bowl, bottle, goblet or lamp, revolved or fluted, thin or thick, with optional handles, rings and lid."""
    profile = _profile(rng)
    outside = len(profile) - 1
    if rng.random() < 0.4:  # a wall with thickness
        inside = profile[:1:-1] * (1, 1) - (rng.uniform(0.03, 0.1), -0.02)
        profile = np.concatenate([profile, [(r, z) for r, z in inside if r > 0.03], [(0.0, 0.06)]])
    degree = int(rng.choice([1, 2, 3, 3, 4]))
    if rng.random() < 0.35:
        sides = int(rng.integers(5, 13)) * 2
        angle = np.arange(sides) * 2 * np.pi / sides + np.linspace(0, rng.choice([0, 1, 2]), len(profile))[:, None]
        swell = 1 + rng.uniform(0.05, 0.3) * np.tile([1, -1], sides // 2)
        radii = profile[:, :1] * swell
        heights = np.broadcast_to(profile[:, 1:], radii.shape)
        net = np.stack([radii * np.cos(angle), radii * np.sin(angle), heights], axis=2)
        body = parts.surface(net, (degree, int(rng.integers(1, 4))), (False, True))
    else:
        knots = parts.clamped(len(profile), degree, int(rng.integers(1, degree + 1)))
        body = parts.revolved(profile, knots, rng.uniform(0.5, 3, len(profile)) if rng.random() < 0.4 else None)
    pieces: list[bob.Shape | bob.Instance] = [bob.Brep([body])]
    (u0, u1), (v0, _) = body.domain
    share = outside / (len(profile) - 1)

    def at(height: float) -> Values:
        """Return (radius, height) of the outer side."""
        x, y, z = body.points(u0 + (u1 - u0) * share * height, v0)
        return np.array([np.hypot(x, y), z])

    if rng.random() < 0.5:
        low, high = at(rng.uniform(0.35, 0.55)), at(rng.uniform(0.75, 0.97))
        out = max(low[0], high[0]) + rng.uniform(0.15, 0.5)
        loop = np.array([low - (0.02, 0), (out, low[1]), (out, high[1] + rng.uniform(0, 0.3)), high - (0.02, 0)])
        handle = parts.curve(np.insert(loop, 1, 0.0, axis=1), rng.uniform(0.03, 0.08))
        pieces += parts.around(handle, int(rng.integers(1, 5)))
    if rng.random() < 0.4:
        for height in rng.uniform(0.25, 1, int(rng.integers(1, 6))):
            radius, z = at(height)
            thickness = rng.uniform(0.01, 0.05)
            if radius > 2 * thickness:
                pieces.append(bob.Instance(parts.torus(float(radius), thickness)).translate((0, 0, z)))
    if rng.random() < 0.25:
        radius, z = at(1.0)
        dome = [(radius * 1.05, 0.0), (radius, 0.25), (0.05, 0.2), (0.05, 0.3), (0.2, 0.4), (0.0, 0.45)]
        pieces.append(bob.Instance(parts.lathe(dome, 2)).translate((0, 0, z)))
    return pieces


def ship(rng: Rng) -> SceneLike:
    """A hull lofted from frames, its deck, cabins, funnels, and masts with sails."""
    length, beam, depth = rng.uniform(2.5, 5), rng.uniform(0.4, 0.8), rng.uniform(0.4, 0.8)
    stations, across = int(rng.integers(5, 9)), int(rng.integers(5, 9))
    s = np.linspace(0, 1, stations)[:, None]
    full = rng.uniform(0.3, 1) * (1 - s) + np.sin(np.pi * s ** rng.uniform(0.6, 1.1)) + 0.02
    half = beam * np.minimum(full, 1) * np.minimum(1, (1 - s) * 4 + 0.03)
    t = np.linspace(-1, 1, across)
    sheer = rng.uniform(0.1, 0.5) * (2 * s - 0.8) ** 2
    power = rng.uniform(0.35, 0.9)
    y = half * np.sign(t) * np.abs(t) ** power
    z = sheer * t**2 - depth * (1 - np.abs(t) ** rng.uniform(2, 5)) * (1 - 0.5 * s**4)
    x = length * (s - 0.5) + rng.uniform(0, 0.5) * s * t**2
    hull = parts.surface(np.stack([x + 0 * t, y, z], axis=2), (3, int(rng.integers(1, 4))))
    (u0, u1), (v0, v1) = hull.domain
    u = np.linspace(u0, u1, 24)
    edges = np.stack([hull.points(u, v0), hull.points(u, v1)], axis=1)
    deck = parts.surface(edges - (0, 0, rng.uniform(0, 0.1)), (1, 1))
    pieces: list[bob.Shape | bob.Instance] = [bob.Brep([hull, deck])]
    pieces += [parts.curve(edge + (0, 0, 0.01), 0.02) for edge in edges.transpose(1, 0, 2)]
    floor = float(edges[8:16, :, 2].min()) - 0.1
    if rng.random() < 0.6:
        size, place = (
            np.array([rng.uniform(0.15, 0.4) * length, beam * 0.9, rng.uniform(0.2, 0.4)]),
            rng.uniform(-0.3, 0),
        )
        for storey in range(int(rng.integers(1, 4))):
            cabin = parts.box(size * (0.75**storey, 0.85**storey, 1))
            pieces.append(bob.Instance(cabin).translate((place * length, 0, floor + storey * size[2])))
        funnel = parts.lathe([(0.0, 0), (0.12, 0), (0.1, 1.2), (0.09, 1.1)])
        pieces += [bob.Instance(funnel).translate((place * length + d, 0, floor)) for d in (0, 0.4)[: rng.integers(3)]]
    for place in rng.uniform(-0.35, 0.35, int(rng.integers(0, 4))):
        height = rng.uniform(1, 2.5)
        foot = np.array([place * length, 0, floor])
        pieces.append(bob.polyline([foot, foot + (0, 0, height)], [0.04, 0.02]))
        if rng.random() < 0.7:
            a, b = np.meshgrid(np.linspace(0, 1, 4), np.linspace(-1, 1, 4), indexing="ij")
            width = rng.uniform(0.4, 0.9) * (1 - rng.uniform(0, 0.6) * a)
            sail = np.stack([0.3 * (1 - b**2) * np.sin(3 * a) + 0.04, b * width, (0.25 + 0.7 * a) * height], axis=2)
            pieces.append(bob.Brep([parts.surface(sail + foot)]))
        else:
            pieces += [bob.polyline([foot + (0, 0, height), edges[i, j]], 0.012) for i in (2, 20) for j in (0, 1)]
    return pieces


def car(rng: Rng) -> SceneLike:
    """A body lofted from round sections, with wheels."""
    stations, length = int(rng.integers(6, 10)), rng.uniform(2, 4)
    s = np.linspace(0, 1, stations)
    roof = rng.uniform(0.4, 0.6) + rng.uniform(0.2, 0.7) * np.exp(-(((s - rng.uniform(0.4, 0.65)) / 0.22) ** 2))
    width = rng.uniform(0.5, 0.8) * (1 - 0.4 * np.abs(2 * s - 1) ** 4)
    roof[[0, -1]] *= 0.6
    section = parts.polygon(8, np.pi / 8)
    section = np.sign(section) * np.abs(section) ** rng.uniform(0.5, 1)
    y = width[:, None] * section[:, 0]
    z = 0.2 + roof[:, None] * (section[:, 1] + 1) / 2
    body = np.stack([np.broadcast_to(length * (s - 0.5)[:, None], y.shape), y, z], axis=2)
    ends = body[[0, -1]] * (1, 0.02, 1) + (0, 0, 0)
    ends[:, :, 2] = body[[0, -1], :, 2].mean(axis=1, keepdims=True)
    net = np.concatenate([ends[:1], body, ends[1:]])
    pieces: list[bob.Shape | bob.Instance] = [
        bob.Brep([parts.surface(net, (int(rng.integers(2, 4)), 3), (False, True))])
    ]
    radius, thickness = rng.uniform(0.2, 0.35), rng.uniform(0.05, 0.12)
    hub = parts.lathe([(0, -0.08), (radius * 0.8, -0.06), (radius * 0.8, 0.06), (0.05, 0.02), (0, 0.1)], 1)
    spokes = [bob.polyline([(0, 0, 0.05), (radius, 0, 0.05)], 0.025)]
    wheel = [bob.Instance(parts.torus(radius, thickness)), bob.Instance(hub)]
    wheel += parts.around(spokes[0], int(rng.integers(3, 8)))
    for place in np.linspace(-0.32, 0.32, int(rng.integers(2, 4))):
        for side in (-1, 1):
            offset = (place * length, side * width.max() * 0.95, radius)
            pieces += [part.rotate(-side * np.pi / 2, (1, 0, 0)).translate(offset) for part in wheel]
    if rng.random() < 0.5:
        pieces.append(parts.pipe([(-length / 2, y, 0.45) for y in (-0.5, 0.5)], 0.05, 0.1))
    if rng.random() < 0.7:
        top = float(roof.max())
        cabin = bob.Instance(parts.ball()).scale((length * rng.uniform(0.12, 0.25), width.max() * 0.7, top * 0.35))
        pieces.append(cabin.translate((length * rng.uniform(-0.15, 0.2), 0, top * 0.85)))
    lamp = bob.Instance(parts.lathe([(0, 0), (0.09, 0), (0.12, 0.1), (0.1, 0.25), (0, 0.3)], int(rng.integers(1, 3))))
    lamp = lamp.rotate(rng.choice([-1, 1]) * np.pi / 2, (0, 1, 0)).translate((length * 0.44, 0, 0.55))
    pieces += [lamp.translate((0, y, 0)) for y in (-0.25, 0.25)]
    if rng.random() < 0.3:
        rack = [(x * length, y, roof.max() + 0.35) for x, y in ((-0.2, -0.4), (0.2, -0.4), (0.2, 0.4), (-0.2, 0.4))]
        pieces.append(parts.ring(rack, 0.03, 1))
        pieces += [bob.polyline([place, place - np.array([0, 0, 0.6])], 0.03) for place in rack]
    return pieces


def still_life(rng: Rng) -> SceneLike:
    """Vessels and balls on a table or a tray, or vessels on shelves."""
    pieces: list[bob.Shape | bob.Instance] = []
    shelves = rng.random() < 0.4
    rows, columns = (int(rng.integers(2, 4)), int(rng.integers(2, 5))) if shelves else (int(rng.integers(1, 4)),) * 2
    kinds = [bob.Scene(vessel(rng)) for _ in range(int(rng.integers(2, 5)))]
    for row in range(rows):
        for column in range(columns):
            kind = kinds[rng.integers(len(kinds))]
            place = np.array([0, column, 1.1 * row] if shelves else [row, column, 0])
            place = place + rng.uniform(-0.12, 0.12, 3) * (1, 1, 0)
            size, turn = rng.uniform(0.4, 0.55) / kind.radius, rng.uniform(0, 6)
            pieces += [piece.scale(size).rotate(turn).translate(place) for piece in kind.instances]
    middle = (0, (columns - 1) / 2) if shelves else ((rows - 1) / 2, (columns - 1) / 2)
    if shelves:
        board = bob.Instance(parts.box((0.8, columns, 0.06)))
        pieces += [board.translate((*middle, 1.1 * row - 0.06)) for row in range(rows + 1)]
        side = bob.Instance(parts.box((0.8, 0.06, 1.1 * rows)))
        pieces += [side.translate((0, middle[1] + half * columns / 2, 0)) for half in (-1, 1)]
        return pieces
    top = parts.extruded([parts.random_outline(rng, 0.6 * rows + 0.4)], 0.08)
    pieces.append(bob.Instance(top).translate((*middle, -0.08)))
    for _ in range(int(rng.integers(0, 6))):
        radius = rng.uniform(0.08, 0.2)
        spot = rng.uniform(-0.4, 0.4, 2) * rows
        pieces.append(bob.Instance(parts.ball(radius)).translate((middle[0] + spot[0], middle[1] + spot[1], radius)))
    if rng.random() < 0.5:
        leg = bob.Instance(bob.polyline([(0.4 * rows, 0, -0.05), (0.45 * rows, 0, -rng.uniform(0.5, 1.2))], 0.05))
        pieces += [part.translate((*middle, 0)) for part in parts.around(leg, int(rng.integers(3, 6)), 0.4)]
    return pieces


def aircraft(rng: Rng) -> SceneLike:
    """A fuselage swept along a line, with wings, fins and engines."""
    length, radius = rng.uniform(2.5, 5), rng.uniform(0.2, 0.45)
    x = np.linspace(0, length, 8)
    path = np.stack([x, 0 * x, 0.2 * rng.uniform(-1, 1) * (x / length) ** 2], axis=1)
    scale = radius * np.array([0.03, 0.7, 1, 1, 1, 0.9, rng.uniform(0.3, 0.7), 0.05])
    pieces: list[bob.Shape | bob.Instance] = [bob.Brep([parts.swept(parts.polygon(8) * 1.2, path, scale)])]
    foil = np.array([(0, 0), (0.05, 0.12), (0.45, 0.14), (1, 0), (0.45, -0.03), (0.05, -0.08)])

    def wing(span: float, chord: float, sweep: float, rise: float) -> bob.Brep:
        t = np.linspace(0, 1, 4)[:, None]
        size = chord * (1 - rng.uniform(0.3, 0.8) * t)
        net = [foil[:, 0] * size + sweep * t * span, t * span + 0 * foil[:, 0], foil[:, 1] * size + rise * t * span]
        return bob.Brep([parts.surface(np.stack(net, axis=2), (int(rng.integers(1, 4)), 3), (False, True))])

    sweep = rng.uniform(-0.1, 0.8)
    main = bob.Instance(wing(rng.uniform(1, 2.5), rng.uniform(0.5, 1.2), sweep, rng.uniform(-0.1, 0.3)))
    tail = bob.Instance(wing(rng.uniform(0.4, 0.9), 0.5, 0.6, rng.uniform(0, 0.5))).translate((length * 0.83, 0, 0))
    for half in (main.translate((length * rng.uniform(0.25, 0.45), 0, 0)), tail):
        pieces += [half, half.scale((1, -1, 1))]
    pieces.append(tail.translate((-length * 0.83, 0, 0)).rotate(np.pi / 2, (1, 0, 0)).translate((length * 0.83, 0, 0)))
    engine = bob.Instance(parts.lathe([(0.02, -0.1), (0.12, 0), (0.2, 0.1), (0.2, 0.5), (0.1, 0.8), (0.05, 0.7)], 2))
    for place in rng.uniform(0.5, 1.2, int(rng.integers(0, 3))):
        pod = engine.rotate(np.pi / 2, (0, 1, 0)).translate((length * 0.35 + sweep * place, place, -0.15))
        pieces += [pod, pod.scale((1, -1, 1))]
    return pieces


def blob(rng: Rng) -> SceneLike:
    """A closed bicubic body, like a ball or a ring, with perturbed control points."""
    if rng.random() < 0.35:
        path = np.insert(parts.polygon(int(rng.integers(7, 14))), 2, 0.0, axis=1)
        path += rng.normal(0, 0.12, path.shape)
        section = parts.polygon(int(rng.integers(4, 9))) * rng.uniform(0.2, 0.4)
        section *= rng.uniform(0.6, 1.4, (len(section), 1))
        turns = np.arange(len(path)) * 2 * np.pi / len(path) * rng.integers(-2, 3)
        return bob.Brep([parts.swept(section, path, rng.uniform(0.7, 1.4, len(path)), turns, closed=True)])
    n, m = int(rng.integers(5, 11)), int(rng.integers(5, 15))
    polar = np.linspace(0, np.pi, n)[:, None]
    angle = np.arange(m) * 2 * np.pi / m
    radius = 1 + rng.uniform(0.1, 0.6) * rng.uniform(-1, 1, (n, m))
    radius[[0, -1]] = rng.uniform(0.6, 1.2, (2, 1))
    net = np.stack(
        [radius * np.sin(polar) * np.cos(angle), radius * np.sin(polar) * np.sin(angle), radius * np.cos(polar)], axis=2
    )
    degree = int(rng.choice([2, 3, 3, 4]))
    body = bob.Instance(bob.Brep([parts.surface(net * rng.uniform(0.6, 1.4, 3), (degree, degree), (False, True))]))
    return [body] + [
        body.scale(rng.uniform(0.2, 0.7))
        .rotate(rng.uniform(0, 6), rng.normal(0, 1, 3))
        .translate(rng.uniform(-0.6, 0.6, 3))
        for _ in range(int(rng.integers(0, 4)))
    ]


def toy(rng: Rng) -> SceneLike:
    """A symmetric robot of balls, rings, cones, boxes and rounded bars."""
    turned = [
        parts.ball(),
        parts.torus(0.8, rng.uniform(0.15, 0.35)),
        parts.lathe([(0, -1), (0.9, -1), (rng.uniform(0, 0.6), 1), (0, 1)]),
        parts.lathe([(0, -1), (0.8, -1), (0.8, -0.2), (0.4, 0), (0.8, 0.3), (0.8, 1), (0, 1)], int(rng.integers(1, 4))),
    ]
    body = bob.Instance(turned[rng.integers(1, 4)] if rng.random() < 0.6 else parts.box((1.5, 1.2, 1.8)))
    pieces = [body, bob.Instance(turned[rng.integers(4)]).scale(rng.uniform(0.4, 0.8)).translate((0, 0, 1.7))]
    pieces.append(bob.Instance(bob.polyline([(0, 0, -0.8), (0, 0, 1.7)], [0.3, 0.15])))
    eye = bob.Instance(turned[rng.integers(3)]).scale(rng.uniform(0.08, 0.2)).rotate(np.pi / 2, (0, 1, 0))
    sides = [eye.translate((0.6, 0.3, 1.9))]
    elbow = np.array([rng.uniform(-0.6, 0.9), rng.uniform(1.2, 2), rng.uniform(-0.8, 0.6)])
    hand = elbow + rng.uniform((0.2, -0.6, -0.8), (1.2, 0.3, 0.8))
    sides.append(bob.Instance(bob.polyline([(0, 0.5, 0.6), elbow, hand], rng.uniform(0.08, 0.2, 3))))
    joint = bob.Instance(turned[rng.integers(4)])
    sides += [joint.scale(rng.uniform(0.15, 0.35)).translate(place) for place in (elbow, hand)]
    sides.append(bob.Instance(bob.polyline([(0, 0, 0.6), (0, 0.7, 0.6)], 0.15)))
    sides.append(bob.Instance(bob.polyline([(0, 0, -0.8), (0, 0.3, -0.8)], 0.18)))
    stance = rng.uniform(0.3, 0.8)
    sides.append(bob.Instance(parts.pipe([(0, 0.3, -0.8), (0.2, stance, -1.6), (0, stance, -2.4)], 0.15, 0.3)))
    sides.append(bob.Instance(parts.box((0.9, 0.5, 0.3))).translate((0.2, stance, -2.6)))
    pieces += sides + [part.scale((1, -1, 1)) for part in sides]
    if rng.random() < 0.6:
        pieces += parts.around(
            bob.polyline([(0.2, 0, 2.2), (rng.uniform(0, 0.6), 0, 2.9)], [0.05, 0.02]), int(rng.integers(1, 7))
        )
    for _ in range(int(rng.integers(0, 5))):
        knob = bob.Instance(turned[rng.integers(4)]).scale(rng.uniform(0.08, 0.3))
        pieces.append(knob.translate((rng.uniform(0.5, 0.8), rng.uniform(-0.6, 0.6), rng.uniform(-0.7, 0.9))))
    return pieces
