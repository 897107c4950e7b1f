"""Sheets: terrain, cloth, pierced plates, petals and leaves, ribbons, blades."""

from __future__ import annotations

import numpy as np

import bobrossnet as bob
from bobrossnet.learn.shapes.splines import parts
from bobrossnet.learn.shapes.splines.parts import Rng, Values
from bobrossnet.tracing.scene import SceneLike


def _grid(n: int, m: int) -> tuple[Values, Values]:
    """Return x and y of a grid over -1..1, each (n, m)."""
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, m), indexing="ij")
    return x, y


def _border(face: bob.Face) -> bob.TrimCurve:
    """Return the outline of a face's domain."""
    (u0, u1), (v0, v1) = face.domain
    return parts.smooth([(u0, v0), (u1, v0), (u1, v1), (u0, v1)], 1)


def _holes(rng: Rng, face: bob.Face, rows: int, columns: int) -> list[bob.TrimCurve]:
    """Return outlines in a grid over a face's domain, equal or different, with some omitted."""
    (u0, u1), (v0, v1) = face.domain
    step = np.array([(u1 - u0) / rows, (v1 - v0) / columns])
    alike = parts.random_outline(rng, rng.uniform(0.2, 0.45)) if rng.random() < 0.6 else None
    kept, shift = rng.uniform(0.6, 1), rng.choice([0, 0.25])
    loops = []
    for i in range(rows):
        for j in range(columns):
            if rng.random() > kept:
                continue
            outline = alike or parts.random_outline(rng, rng.uniform(0.2, 0.45))
            center = np.array([i + 0.5, j + 0.5 + (shift if i % 2 else -shift) * (columns > 2)])
            at = np.array([u0, v0]) + (outline.control_points + center) * step
            loops.append(bob.TrimCurve(at, outline.knots, outline.weights))
    return loops


def terrain(rng: Rng) -> SceneLike:
    """Hills over a square or a round outline, faceted, terraced or smooth, with balls, cones or posts."""
    n, m = (int(count) for count in rng.integers(6, 17, 2))
    x, y = _grid(n, m)
    z = rng.normal(0, rng.uniform(0.02, 0.12), (n, m))
    for _ in range(int(rng.integers(1, 7))):
        a, b = rng.uniform(-1, 1, 2)
        width = rng.uniform(0.15, 0.6)
        z += rng.normal(0, 0.5) * np.exp(-((x - a) ** 2 + (y - b) ** 2) / width**2)
    if rng.random() < 0.25:
        z = np.round(z * 6) / 6
    degrees = (int(rng.integers(1, 5)), int(rng.integers(1, 5)))
    weights = rng.uniform(0.3, 3, (n, m)) if rng.random() < 0.3 else None
    net = np.stack([x, y, z], axis=2)
    face = parts.surface(net, degrees, weights=weights)
    (u0, u1), (v0, v1) = face.domain
    if rng.random() < 0.4:
        outline = parts.random_outline(rng, 0.49, (0.5, 0.5))
        loop = bob.TrimCurve((u0, v0) + outline.control_points * (u1 - u0, v1 - v0), outline.knots, outline.weights)
        face = parts.surface(net, degrees, weights=weights, trims=[loop])
    pieces: list[bob.Shape | bob.Instance] = [bob.Brep([face])]
    if rng.random() < 0.6:
        things = [
            parts.ball(0.08),
            parts.lathe([(0, 0), (0.08, 0), (0.0, 0.3)]),
            parts.box((0.1, 0.1, 0.15)),
            parts.lathe([(0.02, -0.05), (0.02, 0.1), (0.12, 0.1), (0.1, 0.2), (0.0, 0.4)], 2),
        ]
        kinds = rng.integers(4, size=2)
        for _ in range(int(rng.integers(3, 40))):
            place = face.points(*(rng.uniform((u0, v0), (u1, v1)) * 0.7 + np.array([u0 + u1, v0 + v1]) * 0.15))
            thing = bob.Instance(things[kinds[rng.integers(2)]])
            pieces.append(thing.scale(rng.uniform(0.5, 1.6)).translate(place))
    return pieces


def drapery(rng: Rng) -> SceneLike:
    """Cloth with folds: a curtain with its rod, a tablecloth, a flag or a tent."""
    kind = rng.integers(4)
    if kind == 0:
        waves = int(rng.integers(4, 14))
        t, s = np.linspace(-1, 1, 4 * waves + 1), np.linspace(0, 1, 6)[:, None]
        fold = np.sin(t * waves * np.pi) * rng.uniform(0.06, 0.2) * (0.4 + s) + rng.normal(0, 0.03, (6, len(t)))
        gather = 1 - rng.uniform(0, 0.5) * np.sin(np.pi * s)
        net = np.stack([t * gather, fold, 0.9 - rng.uniform(1.2, 2.2) * s + 0 * t], axis=2)
        pieces: list[bob.Shape | bob.Instance] = [bob.Brep([parts.surface(net)])]
        rod = parts.curve([(-1.2, 0, 0.95), (1.2, 0, 0.95)], 0.04)
        rings = bob.Instance(parts.torus(0.09, 0.015)).rotate(np.pi / 2, (0, 1, 0))
        pieces += [rod, *(rings.translate((a, 0, 0.92)) for a in np.linspace(-0.95, 0.95, waves))]
        return pieces
    if kind == 1:
        folds = int(rng.integers(4, 10))
        angle = np.arange(4 * folds) * np.pi / 2 / folds
        s = np.array([0.02, 0.5, 0.92, 1, 1.05, 1.1, 1.15])[:, None]
        drop = -rng.uniform(0.5, 1) * np.array([0, 0, 0, 0.08, 0.4, 0.7, 1])[:, None]
        swell = 1 + rng.uniform(0.1, 0.25) * np.sin(folds * angle) * np.clip(-drop, 0, 1) + rng.normal(0, 0.01, (7, 1))
        radius = s * swell
        net = np.stack([radius * np.cos(angle), radius * np.sin(angle), drop + 0 * angle], axis=2)
        leg = parts.lathe([(0, -1.3), (0.4, -1.3), (0.08, -1.2), (0.08, -0.05), (0.3, -0.02)], 1)
        things = [parts.ball(0.2), parts.lathe([(0, 0), (0.3, 0), (0.25, 0.2), (0.1, 0.6), (0.15, 0.7)], 3)]
        thing = bob.Instance(things[rng.integers(2)]).translate((rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4), 0.05))
        return [bob.Brep([parts.surface(net, (2, 3), (False, True))]), leg, thing]
    n, m = int(rng.integers(5, 10)), int(rng.integers(5, 14))
    x, y = _grid(n, m)
    if kind == 2:
        wave = rng.uniform(0.1, 0.35) * np.sin(rng.uniform(2, 6) * y + rng.uniform(0, 6) + x) * (y + 1.1) / 2
        net = np.stack([1.3 * y + 1.3, wave, x * 0.8 - 0.1 * (y + 1) ** 2], axis=2)
        pole = bob.polyline([(0, 0, -rng.uniform(2, 4)), (0, 0, 0.95)], 0.05)
        top = bob.Instance(parts.ball(0.1)).translate((0, 0, 1))
        return [bob.Brep([parts.surface(net, (3, int(rng.integers(2, 6))))]), pole, top]
    corners = rng.uniform(-0.4, 0.8, 4)
    z = (
        corners[0] * (1 - x) * (1 - y)
        + corners[1] * (1 + x) * (1 - y)
        + corners[2] * (1 - x) * (1 + y)
        + corners[3] * (1 + x) * (1 + y)
    ) / 4
    peak = rng.uniform(-0.4, 0.4, 2)
    z += rng.uniform(0.4, 1.2) * np.exp(-((x - peak[0]) ** 2 + (y - peak[1]) ** 2) * rng.uniform(4, 12))
    inward = 1 - 0.25 * np.cos(np.pi * x / 2), 1 - 0.25 * np.cos(np.pi * y / 2)
    tent = parts.surface(np.stack([x * inward[1], y * inward[0], z], axis=2), (3, 3))
    poles = [
        bob.polyline([(a, b, -0.8), tent.points(u, v)], 0.03)
        for (a, u) in zip((-1.0, 1.0), tent.domain[0], strict=True)
        for (b, v) in zip((-1.0, 1.0), tent.domain[1], strict=True)
    ]
    return [bob.Brep([tent]), *poles]


def pierced(rng: Rng) -> SceneLike:
    """A sheet, pipe, dome or ring with a pattern of holes: a lantern, grate or screen."""
    kind = rng.integers(4)
    degree = int(rng.integers(2, 5))
    if kind == 0:
        n = int(rng.integers(4, 8))
        x, y = _grid(n, n)
        net = np.stack([x, y * rng.uniform(0.5, 1), rng.normal(0, rng.choice([0, 0.05, 0.15]), (n, n))], axis=2)
        face = parts.surface(net, (min(degree, n - 1), 3))
        rows, columns = (int(count) for count in rng.integers(2, 9, 2))
    elif kind == 3:
        face = parts.revolved(parts.CIRCLE * rng.uniform(0.2, 0.5) + (1, 0), parts.CIRCLE_KNOTS, parts.CIRCLE_WEIGHTS)
        rows, columns = int(rng.integers(4, 9)), int(rng.integers(8, 17))
    else:
        radii = rng.uniform(0.4, 1, int(rng.integers(3, 7))) if kind == 1 else np.array([0.95, 1, 1, 0.8, 0.15])
        heights = np.linspace(0, rng.uniform(0.8, 2), len(radii))
        face = parts.revolved(np.stack([radii, heights], 1), parts.clamped(len(radii), min(degree, len(radii) - 1)))
        rows, columns = int(rng.integers(2, 7)), int(rng.integers(6, 15))
    holes = _holes(rng, face, rows, columns)
    trimmed = (
        [[_border(face)], *([hole] for hole in holes)]
        if rng.random() < 0.85 or not holes
        else [[hole] for hole in holes]
    )
    sheet = bob.Brep([bob.Face(face.control_points, face.knots_u, face.knots_v, face.weights, trimmed)])
    inside = rng.integers(4) if kind in (1, 2) else 0
    if inside == 1:
        return [sheet, bob.Instance(parts.ball(0.3)).translate((0, 0, 0.4))]
    if inside == 2:
        return [sheet, bob.Instance(sheet).scale((0.7, 0.7, 0.9)).rotate(rng.uniform(0, 3))]
    if inside == 3:
        return [sheet, parts.lathe([(0, -0.1), (1.1, -0.1), (1.1, 0), (0, 0)])]
    return sheet


def flower(rng: Rng) -> SceneLike:
    """Rings of petals around a centre, on a stem with leaves."""

    def petal(length: float, width: float, lift: float, curl: float) -> bob.Brep:
        n, m = int(rng.integers(4, 7)), int(rng.integers(4, 6))
        s, t = np.linspace(0, 1, n)[:, None], np.linspace(-1, 1, m)
        breadth = width * np.sin(np.pi * np.clip(s, 0.04, 0.97) ** rng.uniform(0.6, 1.2)) ** rng.uniform(0.4, 1)
        ruffle = rng.normal(0, 0.03, (n, m)) + rng.uniform(-0.3, 0.6) * breadth * t**2
        net = [
            0.08 + length * s * np.cos(lift * s) + 0 * t,
            breadth * t,
            length * (np.sin(lift) * s + curl * s**2) + ruffle,
        ]
        return bob.Brep([parts.surface(np.stack(net, axis=2), (3, int(rng.integers(1, 4))))])

    pieces: list[bob.Shape | bob.Instance] = []
    count, lift = int(rng.integers(4, 13)), rng.uniform(0, 0.7)
    for layer in range(int(rng.integers(1, 5))):
        ray = petal(
            rng.uniform(0.7, 1) * 0.85**layer, rng.uniform(1, 2.2) / count, lift + 0.25 * layer, rng.uniform(-0.5, 0.3)
        )
        pieces += parts.around(ray, count, layer * np.pi / count)
    heart = bob.Instance(parts.ball()).scale((0.2, 0.2, rng.uniform(0.05, 0.2)))
    pieces.append(heart.translate((0, 0, 0.05)))
    if rng.random() < 0.5:
        for i in range(int(rng.integers(10, 40))):
            a, r = 2.399963 * i, 0.03 * np.sqrt(i)  # the golden angle
            foot = np.array([r * np.cos(a), r * np.sin(a), 0.1])
            pieces.append(bob.polyline([foot, foot * (1.8, 1.8, 1) + (0, 0, 0.25)], [0.008, 0.02]))
    if rng.random() < 0.7:
        bend, length = rng.uniform(-0.6, 0.6, 2), rng.uniform(0.8, 2)
        stem = np.array([(0, 0, 0), (0, 0, -0.4 * length), (*bend / 2, -0.7 * length), (*bend, -length)])
        pieces.append(parts.curve(stem, [0.05, 0.03, 0.03, 0.05]))
        leaf = bob.Instance(petal(rng.uniform(0.5, 0.9), 0.2, 0.5, -0.4))
        for _ in range(int(rng.integers(1, 5))):
            pieces.append(leaf.rotate(rng.uniform(0, 6)).translate((*bend * 0.4, -rng.uniform(0.5, 0.8) * length)))
    return pieces


def ribbon(rng: Rng) -> SceneLike:
    """Ribbons: helices, spirals, twisted rings or double staircases, some with rungs."""
    kind = rng.integers(4)
    turns = rng.uniform(1.5, 5)
    count = int(turns * 8) + 2
    t = np.linspace(0, 1, count)[:, None]
    angle = 2 * np.pi * turns * t
    degree = int(rng.integers(1, 5))
    if kind < 2:
        height, w = rng.uniform(1, 3), np.linspace(0, 1, 3)
        inner, outer = rng.uniform(0.1, 0.7), rng.uniform(0.8, 1.2)
        taper = 1 - rng.uniform(0, 0.8) * t
        radius = (inner + (outer - inner) * w) * taper
        rise = height * t + rng.uniform(-0.3, 0.3) * w
        net = np.stack([radius * np.cos(angle), radius * np.sin(angle), rise], axis=2)
        band = bob.Instance(bob.Brep([parts.surface(net, (degree, 2))]))
        pieces: list[bob.Shape | bob.Instance] = list(parts.around(band, int(rng.integers(1, 4))))
        if rng.random() < 0.6:
            pieces.append(bob.polyline([(0, 0, -0.2), (0, 0, height + 0.3)], inner * rng.uniform(0.2, 0.6)))
        if kind == 1:
            rail = net[:, -1] + (0, 0, rng.uniform(0.15, 0.4))
            pieces.append(parts.curve(rail, 0.03))
            pieces += [
                bob.polyline([a, b], 0.012) for a, b in zip(net[1:-1, -1] * (0.97, 0.97, 1), rail[1:-1], strict=True)
            ]
        return pieces
    if kind == 2:  # a twisted ring: a Moebius strip for an odd number of half turns
        half_turns, sides = int(rng.integers(0, 6)), 24
        angle = np.arange(sides + 1) * 2 * np.pi / sides
        ring = np.stack([np.cos(angle), np.sin(angle), 0.2 * np.sin(rng.integers(0, 4) * angle)], axis=1)
        tilt = half_turns * angle / 2
        across = np.stack([np.cos(tilt) * np.cos(angle), np.cos(tilt) * np.sin(angle), np.sin(tilt)], axis=1)
        w = np.linspace(-1, 1, 3)[:, None, None] * rng.uniform(0.15, 0.45)
        return bob.Brep([parts.surface(np.swapaxes(ring + w * across, 0, 1), (3, 2))])
    section = parts.star(4, 0.5) if rng.random() < 0.5 else parts.polygon(8) * (0.15, 1)
    path = np.concatenate([np.cos(angle), np.sin(angle), t * rng.uniform(1, 3)], axis=1)
    path[:, :2] *= rng.uniform(0.3, 1) + rng.uniform(-0.25, 0.6) * t
    size = rng.uniform(0.1, 0.3) * (1.05 - t[:, 0] * rng.uniform(0, 0.9))
    return bob.Brep([parts.swept(section, path, size, angle[:, 0] * rng.uniform(-1, 1))])


def impeller(rng: Rng) -> SceneLike:
    """Blades around a hub: a propeller, fan or turbine, sometimes in a ring or on a disc."""
    count, hub = int(rng.integers(2, 17)), rng.uniform(0.1, 0.4)
    s, t = np.linspace(0, 1, 5)[:, None], np.linspace(-1, 1, 4)
    width = (
        rng.uniform(0.6, 1.6) * np.sqrt(1 / count) * (1 - rng.uniform(-0.3, 0.7) * s) * np.sin(np.pi * (0.2 + 0.65 * s))
    )
    pitch = rng.uniform(0.3, 1.2) - rng.uniform(-0.3, 0.6) * s
    skew, camber = rng.uniform(-0.6, 0.6) * s**2, rng.uniform(0, 0.12) * (1 - t**2)
    radius = hub * 0.8 + (1 - hub * 0.8) * s
    across = width * t * np.cos(pitch) - camber * np.sin(pitch) + skew
    net = np.stack([radius * np.cos(across), radius * np.sin(across), width * t * np.sin(pitch) + camber], axis=2)
    blade = bob.Brep([parts.surface(net, (3, int(rng.integers(1, 4))))])
    pieces: list[bob.Shape | bob.Instance] = list(parts.around(blade, count))
    nose = [(0, -0.3), (hub, -0.3), (hub, 0.2), (hub * 0.8, rng.uniform(0.2, 0.6)), (0, rng.uniform(0.4, 0.8))]
    pieces.append(parts.lathe(nose, int(rng.integers(1, 4))))
    if rng.random() < 0.35:
        shroud = [(1.03, -0.3), (1.1, -0.35), (1.15, 0), (1.1, 0.35), (1.03, 0.3), (1.02, 0)]
        pieces.append(parts.lathe(shroud, 2))
    elif rng.random() < 0.4:
        pieces.append(parts.lathe([(hub, -0.25), (1.05, -0.25), (1.05, -0.3), (hub, -0.3)]))
    if rng.random() < 0.4:
        pieces.append(bob.polyline([(0, 0, -0.2), (0, 0, -rng.uniform(0.8, 2))], hub * 0.4))
    return pieces
