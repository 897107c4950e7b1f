"""Procedural meshes to learn from: twenty-odd families of shapes, alone or assembled, each from its seed.

They stand in for real models, which are kept for testing: scans and creatures (blobs, metaballs, noise),
turned and cast parts (lathes, gears, plates, boolean solids), built things (furniture, buildings, trusses,
vehicles), plants, and what is thin (wires, sheets, glyphs). Each family returns a part of any size and place.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from bobrossnet.learn import parts
from bobrossnet.learn.parts import Array, Part, join, moved, rotation
from bobrossnet.shapes.mesh import Mesh

Rng = np.random.Generator


def procedural_mesh(seed: int) -> Mesh:
    """Return the mesh of a seed.

    Parameters
    ----------
    seed : int of at least 0

    Returns
    -------
    Mesh
        About 100 to 100,000 triangles; its bounding box centred on the origin, longest side 2.
    """
    rng = np.random.Generator(np.random.Philox(key=[seed, 0x5EED]))
    count = 1 if rng.random() < 0.6 else int(rng.integers(2, 9))
    part = finished(rng, some_family(rng)) if count == 1 else assembly(rng, count)
    if rng.random() < 0.15:
        part = deformed(rng, part)
    return Mesh(*parts.fitted(part))


def some_family(rng: Rng) -> Part:
    """Return a part of a random family, fitted."""
    family = list(FAMILIES)[int(rng.choice(len(FAMILIES), p=_WEIGHTS))]
    return parts.fitted(FAMILIES[family](rng))


def finished(rng: Rng, part: Part) -> Part:
    """Return the part stretched, and sometimes with a rough surface."""
    if rng.random() < 0.5:
        part = moved(part, np.diag(np.exp(rng.normal(0, 0.3, 3))))
    if len(part[0]) > 3000 and rng.random() < 0.25:
        part = parts.displaced(part, rng.uniform(0.004, 0.015) * parts.noise(rng, part[0], rng.uniform(8, 30)))
    return part


def assembly(rng: Rng, count: int) -> Part:
    """Return several parts, each set against a random place of those before."""
    placed = [some_family(rng)]
    repeated = some_family(rng)
    for _ in range(count - 1):
        part = repeated if rng.random() < 0.4 else some_family(rng)
        aligned = rng.random() < 0.6
        turn = rotation(int(rng.integers(3)), np.pi / 2 * rng.integers(4)) if aligned else parts.random_rotation(rng)
        stretch = np.diag(rng.uniform(0.5, 1.2, 3)) * rng.choice([0.25, 0.4, 0.6, 0.9])
        host = placed[int(rng.integers(len(placed)))][0]
        spot = host[int(rng.integers(len(host)))]
        placed.append(moved(part, turn @ stretch, spot))
    return join(placed)


def deformed(rng: Rng, part: Part) -> Part:
    """Return the part tapered, twisted or bent along a random axis."""
    vertices, triangles = parts.fitted(part)
    v = np.roll(vertices, int(rng.integers(3)), axis=1)
    kind = rng.integers(3)
    if kind == 0:
        v[:, :2] *= (1 + rng.uniform(-0.7, 0.7) * v[:, 2:]) / 1.2
    elif kind == 1:
        angle = rng.uniform(-1.5, 1.5) * v[:, 2]
        c, s = np.cos(angle), np.sin(angle)
        v = np.stack([c * v[:, 0] - s * v[:, 1], s * v[:, 0] + c * v[:, 1], v[:, 2]], 1)
    else:
        bend = rng.uniform(0.3, 1.2)
        radius = 1 / bend + v[:, 0]
        v = np.stack([radius * np.cos(bend * v[:, 2]), v[:, 1], radius * np.sin(bend * v[:, 2])], 1)
    return v, triangles


# ---- organic ----------------------------------------------------------------------------------------------


def blob(rng: Rng) -> Part:
    """A sphere under noise of several octaves: rocks, fruit, heads."""
    part = parts.sphere(int(rng.choice([48, 128, 192])))
    octaves = int(rng.integers(1, 5))
    ridged = rng.random() < 0.3
    amount = np.zeros(len(part[0]))
    for octave in range(octaves):
        wave = parts.noise(rng, part[0], 1.5 * 2.0**octave)
        amount += (1 - np.abs(wave) if ridged else wave) * 0.5**octave
    return parts.displaced(part, rng.uniform(0.05, 0.25) * amount)


def creature(rng: Rng) -> Part:
    """Capsules blended into a body with two sides alike: animals, characters, dolls."""
    x, y, z = parts.lattice(int(rng.choice([40, 56, 72])))
    limbs = int(rng.integers(3, 9))
    body = rng.uniform(-0.35, 0.35, 3) * (1, 0, 1)
    field = np.full(np.broadcast_shapes(x.shape, y.shape, z.shape), np.inf)
    blend = rng.uniform(0.02, 0.12)
    for limb in range(limbs):
        start = body + rng.uniform(-0.3, 0.3, 3) * (1, 0.3, 1)
        end = start + rng.normal(size=3) * rng.uniform(0.1, 0.5)
        start, end = np.clip(start, -0.7, 0.7), np.clip(end, -0.75, 0.75)
        thick, thin = rng.uniform(0.08, 0.24), rng.uniform(0.03, 0.15)
        for side in (1, -1) if limb else (1,):
            a, b = start * (1, side, 1), end * (1, side, 1)
            d = b - a
            along = ((x - a[0]) * d[0] + (y - a[1]) * d[1] + (z - a[2]) * d[2]) / max(float(d @ d), 1e-6)
            along = np.clip(along, 0, 1)
            gap = np.sqrt(
                (x - a[0] - along * d[0]) ** 2 + (y - a[1] - along * d[1]) ** 2 + (z - a[2] - along * d[2]) ** 2
            )
            capsule = gap - thick - (thin - thick) * along
            mix = np.clip(0.5 + 0.5 * (field - capsule) / blend, 0, 1)
            field = np.where(
                mix > 0,
                np.where(mix < 1, _mix(field, capsule, mix) - blend * mix * (1 - mix), capsule),
                field,
            )
    part = parts.isosurface(field)
    if rng.random() < 0.5:
        part = parts.displaced(part, rng.uniform(0.005, 0.02) * parts.noise(rng, part[0], rng.uniform(6, 25)))
    return part


def metaballs(rng: Rng) -> Part:
    """Balls that flow into each other, sometimes hollowed or cut: clay, bones, sponges."""
    x, y, z = parts.lattice(48)
    field = np.full((48, 48, 48), float(rng.uniform(0.6, 1.4)))
    for _ in range(int(rng.integers(3, 14))):
        cx, cy, cz = rng.uniform(-0.6, 0.6, 3)
        reach = rng.uniform(0.02, 0.12)
        sign = -1 if rng.random() < 0.85 else 1
        field = field + sign * reach / ((x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2 + 0.02)
    if rng.random() < 0.3:
        field = np.maximum(field, rng.uniform(-0.2, 0.3) - x - 0 * y)
    return parts.isosurface(field)


def lattice_solid(rng: Rng) -> Part:
    """A gyroid or a kin within a ball or a box: foams, printed infill, corals."""
    x, y, z = (axis * rng.uniform(4, 9) for axis in parts.lattice(64))
    wall = rng.uniform(0.2, 0.7)
    if rng.random() < 0.5:
        field = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    else:
        field = np.cos(x) + np.cos(y) + np.cos(z)
    field = np.abs(field) - wall if rng.random() < 0.6 else field
    u, v, w = parts.lattice(64)
    hull = (
        u * u + v * v + w * w - 0.9
        if rng.random() < 0.6
        else np.maximum(np.maximum(np.abs(u), np.abs(v)), np.abs(w)) - 0.9
    )
    return parts.isosurface(np.maximum(field, hull * 6))


def spiky(rng: Rng) -> Part:
    """A ball or an ellipsoid with many cones or knobs: viruses, cacti, maces."""
    count = int(rng.integers(15, 120))
    sides = int(rng.choice([4, 6, 12]))
    length, width = rng.uniform(0.1, 0.9), rng.uniform(0.03, 0.15)
    knob = rng.random() < 0.35
    if knob:
        thorn = join([parts.cylinder(width * 0.4, length, sides), moved(parts.sphere(12), width, (0, 0, length))])
    else:
        thorn = parts.cylinder(width, length, sides, 0.0)
    pieces = [parts.sphere(48)]
    height = 1 - 2 * (np.arange(count) + 0.5) / count
    turn = np.pi * (1 + 5**0.5) * np.arange(count)  # a Fibonacci spiral
    for z, angle in zip(height, turn, strict=True):
        pieces.append(
            moved(
                thorn,
                rotation(2, angle) @ rotation(1, np.arccos(z)) @ np.diag([1, 1, rng.uniform(0.6, 1)]),
                0.97 * np.array([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z]),
            )
        )
    return moved(join(pieces), np.diag(rng.uniform(0.6, 1.4, 3)))


def seashell(rng: Rng) -> Part:
    """A tube that winds and grows: shells, horns, tails."""
    t = np.linspace(0, rng.uniform(1, 5), 240)
    grow = np.exp(rng.uniform(0.2, 0.8) * (t - t[-1]))
    path = (
        np.stack([np.cos(2 * np.pi * t), np.sin(2 * np.pi * t), -rng.uniform(0.2, 2.5) * np.ones_like(t)], 1)
        * grow[:, None]
    )
    ribs = 1 + rng.uniform(0, 0.12) * np.sin(2 * np.pi * rng.integers(6, 25) * t)
    return parts.sweep(path, parts.round_outline(28) * rng.uniform(0.25, 0.55), grow * ribs)


def tree(rng: Rng) -> Part:
    """Branches that fork and thin out, with or without leaves: trees, corals, antlers."""
    pieces: list[Part] = []
    leaf_kind = int(rng.integers(4))
    spread, shrink = rng.uniform(0.3, 0.9), rng.uniform(0.6, 0.8)
    depth = int(rng.integers(3, 6))

    def branch(start: Array, direction: Array, length: float, radius: float, level: int) -> None:
        bend = direction + rng.normal(0, 0.15, 3)
        middle = start + direction * length / 2
        end = middle + bend / np.linalg.norm(bend) * length / 2
        pieces.append(
            parts.sweep(np.stack([start, middle, end]), parts.round_outline(8), np.array([1, 0.85, 0.7]) * radius)
        )
        if level == 0:
            if leaf_kind == 1:
                pieces.append(moved(parts.sphere(8), length * 0.6, end))
            elif leaf_kind == 2:
                pieces.append(moved(leaf(rng), parts.random_rotation(rng) * length * 0.5, end))
            return
        for _ in range(int(rng.integers(2, 4))):
            way = bend + rng.normal(0, spread, 3)
            branch(
                end,
                way / np.linalg.norm(way),
                length * shrink * rng.uniform(0.8, 1.1),
                radius * 0.65,
                level - 1,
            )

    branch(np.zeros(3), np.array([0, 0, 1.0]), 1.0, rng.uniform(0.04, 0.14), depth)
    return join(pieces)


def leaf(rng: Rng) -> Part:
    """A thin curved sheet, pointed at both ends."""
    u, v = np.linspace(0, 1, 12)[:, None], np.linspace(-1, 1, 5)[None]
    width = np.sin(np.pi * u) * rng.uniform(0.15, 0.4)
    return parts.grid(np.stack([width * v, u + 0 * v, rng.uniform(-0.6, 0.6) * u * u + 0.3 * width * np.abs(v)], -1))


def plant(rng: Rng) -> Part:
    """Leaves round a stem or in a pot: palms, pineapples, flowers."""
    pieces = [leaf(rng)]
    single = [moved(leaf(rng), rng.uniform(0.8, 1.6)) for _ in range(3)]
    count = int(rng.integers(6, 40))
    for i in range(count):
        tilt = rng.uniform(-0.2, 1.2)
        turn = rotation(2, 2.4 * i) @ rotation(0, tilt)
        pieces.append(moved(single[i % 3], turn, (0, 0, rng.uniform(0, 0.5))))
    if rng.random() < 0.6:
        pieces.append(moved(parts.cylinder(0.3, 0.6, 32, rng.uniform(1, 1.5)), offset=(0, 0, -0.6)))
    return join(pieces)


# ---- turned, swept, cast and cut --------------------------------------------------------------------------


def turned(rng: Rng) -> Part:
    """A profile on the lathe, smooth or with steps: vases, chess pieces, bottles, bolts, wheels."""
    knots = int(rng.integers(3, 12))
    radius = rng.uniform(0.1, 1, knots)
    height = np.linspace(0, rng.uniform(0.3, 3), knots)
    if rng.random() < 0.5:  # steps and cones
        twice = rng.random() < 0.6
        radius, height = (np.repeat(radius, 2)[:-1], np.repeat(height, 2)[1:]) if twice else (radius, height)
    else:  # a smooth profile through the knots
        t = np.linspace(0, knots - 1, 80)
        wave = np.interp(t, np.arange(knots), radius)
        kernel = np.hanning(17)
        radius = np.convolve(np.pad(wave, 8, mode="edge"), kernel / kernel.sum(), "valid")
        height = np.interp(t, np.arange(knots), height)
    profile = np.stack([radius, height], 1)
    if rng.random() < 0.5:  # an open vessel: the wall comes back down inside
        inside = profile[::-1] - (rng.uniform(0.02, 0.08), 0)
        inside[-1, 1] += 0.05
        profile = np.concatenate([profile, np.maximum(inside, (0.001, -9))])
    closed = np.concatenate([[[0, profile[0, 1]]], profile, [[0, profile[-1, 1]]]])
    part = parts.lathe(closed, int(rng.choice([6, 12, 48, 96])))
    if rng.random() < 0.35:  # a handle
        t = np.linspace(-np.pi / 2, np.pi / 2, 24)
        high = float(height[-1])
        path = np.stack([0.5 + 0.5 * np.cos(t), 0 * t, high * (0.5 + 0.35 * np.sin(t))], 1)
        part = join([part, parts.sweep(path, parts.round_outline(10) * 0.07)])
    return part


def tube(rng: Rng) -> Part:
    """Pipes and cables along smooth or angular paths, knots and springs."""
    kind = rng.integers(4)
    if kind == 0:
        p, q = [(2, 3), (3, 2), (2, 5), (3, 4), (5, 2), (1, 3)][int(rng.integers(6))]
        t = np.linspace(0, 2 * np.pi, 260, endpoint=False)
        r = 1 + 0.4 * np.cos(q * t)
        path = np.stack([r * np.cos(p * t), r * np.sin(p * t), 0.4 * np.sin(q * t)], 1)
        return parts.sweep(path, _section(rng) * rng.uniform(0.05, 0.25), closed=True)
    if kind == 1:
        t = np.linspace(0, float(rng.integers(3, 12)), 400)
        path = np.stack([np.cos(2 * np.pi * t), np.sin(2 * np.pi * t), t * rng.uniform(0.15, 0.6)], 1)
        return parts.sweep(path, _section(rng) * rng.uniform(0.03, 0.2))
    if kind == 2:
        pieces = []
        for _ in range(int(rng.integers(1, 7))):
            path = parts.smooth_path(rng, int(rng.integers(4, 8)), 120)
            taper = np.linspace(1, rng.uniform(0.1, 1), 120)
            pieces.append(parts.sweep(path, _section(rng) * rng.uniform(0.015, 0.15), taper))
        return join(pieces)
    corners = np.cumsum(
        np.eye(3)[rng.integers(3, size=8)] * rng.choice([-1, 1], 8)[:, None] * rng.uniform(0.3, 1, 8)[:, None],
        0,
    )
    pieces = [parts.rod(a, b, 0.1, 16) for a, b in pairwise(corners)]
    return join(pieces + [moved(parts.sphere(16), rng.uniform(0.1, 0.17), corner) for corner in corners])


def _section(rng: Rng) -> Array:
    """A tube's outline: round, square, flat or a star."""
    kind = rng.integers(5)
    if kind < 2:
        return parts.round_outline(18)
    if kind == 2:
        return parts.round_outline(4)
    if kind == 3:
        return parts.round_outline(14) * (1, rng.uniform(0.1, 0.4))
    return parts.round_outline(20) * np.where(np.arange(20) % 2, 1, 0.6)[:, None]


def gear(rng: Rng) -> Part:
    """Toothed or lobed wheels with a bore, a hub, spokes of holes, sometimes two that mesh."""
    teeth = int(rng.integers(6, 40))
    steps = 8
    phase = (np.arange(teeth * steps) % steps) / steps
    depth = rng.uniform(0.05, 0.25)
    shape = (
        np.clip(2.5 * np.abs(2 * phase - 1) - 0.75, 0, 1)
        if rng.random() < 0.7
        else 0.5 + 0.5 * np.cos(2 * np.pi * phase)
    )
    circle = parts.round_outline(teeth * steps)
    outer, bore, height = (
        circle * (1 - depth * shape)[:, None],
        rng.uniform(0.1, 0.65),
        rng.uniform(0.08, 0.7),
    )
    pieces = [parts.extrude(outer, circle * bore, height)]
    if rng.random() < 0.5:
        pieces.append(moved(parts.extrude(circle * (bore + 0.12), circle * bore, height * rng.uniform(1.2, 2.5))))
    if rng.random() < 0.4:
        pieces.append(moved(parts.cylinder(bore * 0.9, height * 4, 32), offset=(0, 0, -height)))
    if rng.random() < 0.4:
        pieces += _ring(rng, parts.cylinder(0.06, height * 1.2, 12), (bore + 1 - depth) / 2, int(rng.integers(3, 12)))
    if rng.random() < 0.25:
        pieces += [moved(piece, rotation(2, np.pi / teeth), (2 - depth, 0, 0)) for piece in list(pieces)]
    return join(pieces)


def _ring(rng: Rng, part: Part, radius: float, count: int) -> list[Part]:
    """Return copies of a part in a ring about z."""
    return [moved(moved(part, offset=(radius, 0, 0)), rotation(2, 2 * np.pi * i / count)) for i in range(count)]


def flange(rng: Rng) -> Part:
    """Plates with holes, alone, at right angles, or stacked on posts: brackets, perforated sheets, boards."""
    holes = int(rng.integers(1, 9)), int(rng.integers(1, 9))
    thickness = rng.uniform(0.05, 0.5)
    first = parts.plate(holes, rng.uniform(0.1, 0.45), thickness, int(rng.choice([6, 24, 36])))
    pieces = [first]
    if rng.random() < 0.4:
        pieces.append(
            moved(
                parts.plate((holes[0], int(rng.integers(1, 4))), rng.uniform(0.1, 0.45), thickness),
                rotation(0, np.pi / 2),
                (0, -0.5 + thickness, 0.5),
            )
        )
    if rng.random() < 0.3:
        gap = rng.uniform(0.5, 2)
        pieces.append(moved(first, offset=(0, 0, gap)))
        pieces += [
            moved(parts.cylinder(0.1, gap, 12), offset=(x, y, 0)) for x in (0, holes[0] - 1) for y in (0, holes[1] - 1)
        ]
    if rng.random() < 0.4:
        peg = some_fastener(rng)
        for x in range(holes[0]):
            for y in range(holes[1]):
                if rng.random() < 0.5:
                    pieces.append(moved(peg, offset=(x, y, 0)))
    return join(pieces)


def some_fastener(rng: Rng) -> Part:
    """A bolt, a pin or a stud."""
    head = moved(parts.cylinder(0.3, 0.15, int(rng.choice([6, 24]))), offset=(0, 0, 0.4))
    return join([parts.cylinder(0.15, rng.uniform(0.5, 1.5), 16), head])


def boolean_solid(rng: Rng) -> Part:
    """Boxes, balls and cylinders joined and cut, on a fine lattice: castings, housings, sockets."""
    x, y, z = parts.lattice(64)
    field = np.full((64, 64, 64), np.inf)
    for step in range(int(rng.integers(2, 9))):
        cx, cy, cz = rng.uniform(-0.5, 0.5, 3) * (step > 0)
        sx, sy, sz = rng.uniform(0.15, 0.8 if step == 0 else 0.5, 3)
        kind = rng.integers(3)
        if kind == 0:
            solid = np.maximum(np.maximum(np.abs(x - cx) - sx, np.abs(y - cy) - sy), np.abs(z - cz) - sz)
        elif kind == 1:
            solid = np.sqrt((x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2) - sx
        else:
            along = rng.integers(3)
            a, b, c = [(x - cx, y - cy, z - cz), (y - cy, z - cz, x - cx), (z - cz, x - cx, y - cy)][int(along)]
            solid = np.maximum(np.sqrt(a * a + b * b) - sx * 0.7, np.abs(c) - sy * 1.6)
        cut = step > 0 and rng.random() < 0.6
        field = np.maximum(field, -solid) if cut else np.minimum(field, solid)
    return parts.isosurface(field)


def ngon_solid(rng: Rng) -> Part:
    """Few large facets: cut stones, low-poly animals, crates, paper models."""
    part = parts.sphere(int(rng.integers(4, 14)))
    vertices = part[0] * (1 + rng.uniform(0, 0.35) * parts.noise(rng, part[0], 2.0))[:, None]
    power = rng.choice([0.3, 1, 1, 2])
    return np.sign(vertices) * np.abs(vertices) ** power, part[1]


def sheet(rng: Rng) -> Part:
    """Thin curved surfaces: cloth, flags, hulls, terrain."""
    n = int(rng.choice([40, 120]))
    u, v = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n), indexing="ij")
    flat = np.stack([u, v, 0 * u], -1).reshape(-1, 3)
    height = np.zeros(n * n)
    kind = rng.integers(3)
    for octave in range(6 if kind == 0 else 2):  # terrain, cloth, or a dome
        height += rng.uniform(0.5, 1) * parts.noise(rng, flat, 1.5 * 2.0**octave) * 0.45**octave
    points = flat + height[:, None] * (0, 0, rng.uniform(0.05, 0.4))
    if kind == 2:
        points[:, 2] -= rng.uniform(0.3, 1) * (flat**2).sum(1)
    return parts.grid(points.reshape(n, n, 3))


# ---- built ------------------------------------------------------------------------------------------------


def furniture(rng: Rng) -> Part:
    """Tables, chairs, shelves, beds: boards on legs."""
    w, d, h = rng.uniform(0.6, 2, 3)
    board, leg = rng.uniform(0.03, 0.15), rng.uniform(0.03, 0.1)
    bevel = rng.choice([0, 0.02, 0.05])
    pieces = [moved(parts.box(w, d, board, bevel), offset=(0, 0, h))]
    round_legs, splay = rng.random() < 0.4, rng.uniform(0.9, 1.2)
    for sx in (-1, 1):
        for sy in (-1, 1):
            top = np.array([sx * (w / 2 - leg), sy * (d / 2 - leg), h])
            pieces.append(
                parts.sweep(
                    np.stack([top * (splay, splay, 0), top]),
                    parts.round_outline(12 if round_legs else 4) * leg,
                )
            )
    if rng.random() < 0.6:  # a back, of one board or of slats
        slats = int(rng.choice([1, 1, 3, 6]))
        for i in range(slats):
            y = d * ((i + 0.5) / slats - 0.5)
            pieces.append(
                moved(
                    parts.box(board, d / slats * (1 if slats == 1 else 0.5), h, bevel),
                    offset=(-w / 2, y, 1.5 * h),
                )
            )
    for level in range(int(rng.integers(0, 4))):  # shelves or rungs
        shelf = parts.box(w * 0.95, d * rng.choice([0.05, 0.95]), board)
        pieces.append(moved(shelf, offset=(0, 0, h * (level + 0.5) / 4)))
    for _ in range(int(rng.integers(0, 5))):  # things on it
        size = rng.uniform(0.1, 0.35)
        thing = parts.box(1, 1, 1, bevel) if rng.random() < 0.5 else moved(turned(rng), 0.7)
        pieces.append(
            moved(
                thing,
                size,
                (rng.uniform(-0.4, 0.4) * w, rng.uniform(-0.4, 0.4) * d, h + board / 2 + size / 4),
            )
        )
    if rng.random() < 0.3:
        pieces.append(moved(parts.box(w * 0.9, d * 0.9, 2 * board, board), offset=(0, 0, h + board)))  # a cushion
    return join(pieces)


def building(rng: Rng) -> Part:
    """Blocks with rows of windows, ledges, roofs and columns: houses, towers, circuit boards."""
    pieces: list[Part] = []
    for _ in range(int(rng.integers(1, 6))):
        w, d, h = rng.uniform(0.3, 1, 3) * (1, 1, 2)
        at = np.array([*rng.uniform(-0.8, 0.8, 2), 0])
        block = [moved(parts.box(w, d, h, rng.choice([0, 0, 0.04])), offset=(0, 0, h / 2))]
        rows, columns = int(rng.integers(0, 7)), int(rng.integers(1, 6))
        pane = parts.box(w / columns * 0.5, d * 1.04, h / max(rows, 1) * 0.55)
        side = parts.box(w * 1.04, d / columns * 0.5, h / max(rows, 1) * 0.55)
        for i in range(rows):
            for j in range(columns):
                z = h * (i + 0.5) / rows
                block.append(moved(pane, offset=(w * ((j + 0.5) / columns - 0.5), 0, z)))
                block.append(moved(side, offset=(0, d * ((j + 0.5) / columns - 0.5), z)))
        top = rng.integers(4)
        if top == 0:
            roof = parts.cylinder(0.75, rng.uniform(0.3, 1.2), 4, rng.choice([0, 0.3]))
            block.append(moved(moved(roof, rotation(2, np.pi / 4)), np.diag([w, d, 1.0]), (0, 0, h)))
        elif top == 1:
            block.append(moved(parts.box(w * 1.15, d * 1.15, 0.08), offset=(0, 0, h)))
        elif top == 2:
            block += [
                moved(parts.box(w / 7, d, 0.12), offset=(w * (i / 3 - 1) / 2.3, 0, h + 0.05)) for i in range(0, 7, 2)
            ]
        pieces += [moved(piece, offset=at) for piece in block]
    if rng.random() < 0.4:
        pieces += _ring(
            rng,
            parts.cylinder(0.06, rng.uniform(0.5, 2), 16),
            rng.uniform(0.8, 1.4),
            int(rng.integers(4, 14)),
        )
    if rng.random() < 0.5:
        pieces.append(moved(parts.box(2.4, 2.4, 0.1), offset=(0, 0, -0.05)))
    return join(pieces)


def truss(rng: Rng) -> Part:
    """Rods between points: towers, ladders, fences, cages, wire models, molecules."""
    kind = rng.integers(4)
    thick = rng.uniform(0.008, 0.06)
    pieces: list[Part] = []
    if kind == 0:  # a tower or a beam with diagonals
        levels, corners = int(rng.integers(3, 9)), int(rng.integers(3, 6))
        waist = rng.uniform(0.3, 1)
        ring = [
            np.c_[parts.round_outline(corners) * 0.5 * (1 + (waist - 1) * i / levels), np.full(corners, 0.5 * i)]
            for i in range(levels + 1)
        ]
        for i in range(levels):
            for j in range(corners):
                k = (j + 1) % corners
                ends = [
                    (ring[i][j], ring[i + 1][j]),
                    (ring[i + 1][j], ring[i + 1][k]),
                    (ring[i][j], ring[i + 1][k]),
                ]
                pieces += [parts.rod(a, b, thick) for a, b in ends]
    elif kind == 1:  # a cage of hoops
        count = int(rng.integers(4, 16))
        hoop = parts.torus(1, thick, 64, 8)
        pieces += [moved(hoop, rotation(2, np.pi * i / count) @ rotation(0, np.pi / 2)) for i in range(count)]
        pieces += [moved(hoop, np.sqrt(1 - z * z), (0, 0, z)) for z in rng.uniform(-0.95, 0.95, 4)]
    elif kind == 2:  # balls and sticks
        points = rng.uniform(-1, 1, (int(rng.integers(5, 25)), 3))
        ball = moved(parts.sphere(16), rng.uniform(0.06, 0.2))
        pieces += [moved(ball, 1.0, point) for point in points]
        for i, point in enumerate(points):
            near = np.argsort(((points - point) ** 2).sum(1))[1:3]
            pieces += [parts.rod(point, points[j], thick) for j in near if i != j]
    else:  # a fence or a grating
        count = int(rng.integers(5, 25))
        pieces += [parts.rod(np.array([x, 0, -1]), np.array([x, 0, 1]), thick) for x in np.linspace(-1, 1, count)]
        across = int(rng.integers(2, count))
        pieces += [parts.rod(np.array([-1, 0, z]), np.array([1, 0, z]), thick) for z in np.linspace(-0.9, 0.9, across)]
        if rng.random() < 0.5:
            pieces = [moved(piece, offset=(0, y, 0)) for piece in pieces for y in (-0.4, 0.4)]
    return join(pieces)


def vehicle(rng: Rng) -> Part:
    """A body, a cabin and wheels or rotors: cars, planes, carts, quadrotors."""
    length, width, height = rng.uniform(1.5, 3), rng.uniform(0.6, 1.2), rng.uniform(0.25, 0.7)
    smooth = rng.random() < 0.4
    body = (
        moved(parts.sphere(64), np.diag([length / 2, width / 2, height]))
        if smooth
        else parts.box(length, width, height, rng.uniform(0, 0.2))
    )
    pieces = [
        body,
        moved(
            parts.box(length * rng.uniform(0.2, 0.6), width * 0.85, height, rng.uniform(0.02, 0.15)),
            offset=(rng.uniform(-0.3, 0.3), 0, height * 0.8),
        ),
    ]
    radius = rng.uniform(0.2, 0.45)
    wheel = join(
        [
            parts.torus(radius, radius * 0.35, 32, 12),
            moved(parts.cylinder(radius * 0.9, 0.16, 24), offset=(0, 0, -0.08)),
            _spoked(rng, radius),
        ]
    )
    axles = int(rng.integers(0, 4))
    for i in range(axles):
        x = length * (0.8 * i / max(axles - 1, 1) - 0.4)
        pieces += [moved(wheel, rotation(0, np.pi / 2), (x, side * width / 2, -height / 2)) for side in (-1, 1)]
    if rng.random() < 0.5:  # wings and a fin
        wing = moved(
            parts.box(length * 0.25, 2.5 * width, 0.05),
            np.eye(3) + rng.uniform(-0.3, 0.3) * np.eye(3)[[1, 0, 2]] * 0.3,
        )
        pieces += [wing, moved(parts.box(0.3, 0.04, 0.7), offset=(-length / 2, 0, height))]
    if rng.random() < 0.3:  # rotors
        blade = join([moved(parts.box(1, 0.08, 0.015), rotation(2, np.pi / 2 * i)) for i in range(2)])
        at = [(x, y) for x in (-0.8, 0.8) for y in (-0.8, 0.8)] if rng.random() < 0.5 else [(0.0, 0.0)]
        for x, y in at:
            pieces.append(moved(blade, rotation(2, rng.uniform(0, 3)), (x, y, height + 0.5)))
            pieces.append(parts.rod(np.array([x * 0.5, y * 0.3, 0]), np.array([x, y, height + 0.5]), 0.04))
    return join(pieces)


def _spoked(rng: Rng, radius: float) -> Part:
    return join(_ring(rng, moved(parts.box(radius, radius * 0.15, 0.22)), radius * 0.4, int(rng.integers(3, 9))))


def robot_arm(rng: Rng) -> Part:
    """Links and joints in a chain: arms, legs, lamps, cranes."""
    pieces = [parts.cylinder(0.5, 0.25, 32, rng.uniform(0.5, 1))]
    at, radius = np.array([0, 0, 0.25]), rng.uniform(0.1, 0.3)
    turn = np.eye(3)
    for _ in range(int(rng.integers(2, 7))):
        length = rng.uniform(0.3, 1.2)
        kind = rng.integers(3)
        if kind == 0:
            link = parts.cylinder(radius * 0.7, length, 24, rng.uniform(0.6, 1))
        elif kind == 1:
            link = moved(parts.box(radius * 1.2, radius, length, radius * 0.3), offset=(0, 0, length / 2))
        else:
            link = join(
                [
                    moved(parts.box(radius * 0.2, radius, length), offset=(x, 0, length / 2))
                    for x in (-radius / 2, radius / 2)
                ]
            )
        joint = moved(parts.cylinder(radius, radius * 2, 32), rotation(1, np.pi / 2), (-radius, 0, 0))
        pieces += [moved(joint, turn, at), moved(link, turn, at)]
        at = at + turn @ (0, 0, length)
        turn = turn @ rotation(int(rng.integers(3)), rng.uniform(-1.2, 1.2))
        radius *= rng.uniform(0.75, 1)
    pieces += [
        moved(parts.box(radius * 0.3, radius * 0.5, radius * 3), turn, at + turn @ (side * radius, 0, radius))
        for side in (-1, 1)
    ]
    return join(pieces)


def stack(rng: Rng) -> Part:
    """Boxes on boxes at odd angles, books, crates, bricks, stairs."""
    pieces: list[Part] = []
    kind = rng.integers(3)
    z = 0.0
    for i in range(int(rng.integers(3, 20))):
        w, d, h = rng.uniform(0.3, 1, 3) * (1, 1, 0.4)
        if kind == 0:
            pieces.append(
                moved(
                    parts.box(w, d, h, 0.02),
                    rotation(2, rng.uniform(0, 0.8)),
                    (*rng.uniform(-0.1, 0.1, 2), z + h / 2),
                )
            )
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
    if kind == 0:
        picture = rng.random((rows, columns)) < rng.uniform(0.2, 0.6)
    elif kind == 1:  # letters: random 5x3 patterns, apart
        letters = rng.random((max(rows // 6, 1), max(columns // 4, 1), 5, 3)) < 0.6
        picture = (
            np.pad(letters, ((0, 0), (0, 0), (0, 1), (0, 1))).transpose(0, 2, 1, 3).reshape(letters.shape[0] * 6, -1)
        )
    else:
        i, j = np.mgrid[:rows, :columns]
        step = int(rng.integers(2, 5))
        picture = (i % step > 0) & (j % step > 0)
    picture[0, 0] = True
    size = 2 / max(picture.shape)
    height = rng.uniform(0.5, 4) * size
    relief = parts.bitmap(picture, size, height)
    w, d = (picture.shape[0] + 2) * size, (picture.shape[1] + 2) * size
    if rng.random() < 0.25:
        return relief
    return join(
        [
            relief,
            moved(
                parts.box(w * 1.05, d * 1.05, height * 2, rng.choice([0, 0.03])),
                offset=(w / 2, d / 2, -height),
            ),
        ]
    )


def array(rng: Rng) -> Part:
    """One part many times, in a grid or a ring: chess boards, key caps, fans, flowers, chandeliers."""
    kinds: list[Callable[[Rng], Part]] = [turned, ngon_solid, flange, robot_arm, leaf, stack, some_fastener]
    part = parts.fitted(kinds[int(rng.integers(len(kinds)))](rng))
    if rng.random() < 0.5:
        count = int(rng.integers(3, 14))
        turned_part = moved(part, rotation(1, rng.uniform(0, np.pi)))
        return join([*_ring(rng, turned_part, rng.uniform(1, 4), count), parts.cylinder(rng.uniform(0.5, 3), 0.3, 48)])
    nx, ny = int(rng.integers(2, 6)), int(rng.integers(1, 6))
    gap = rng.uniform(1.6, 3)
    pieces = [
        moved(part, rotation(2, rng.integers(4) * np.pi / 2), (gap * i, gap * j, 0))
        for i in range(nx)
        for j in range(ny)
    ]
    floor = parts.box(gap * nx, gap * ny, 0.2, 0.05)
    return join([*pieces, moved(floor, offset=(gap * (nx - 1) / 2, gap * (ny - 1) / 2, -1))])


def _mix(a: Array, b: Array, t: Array) -> Array:
    return np.where(np.isfinite(a), a, b) * (1 - t) + b * t


FAMILIES: dict[str, Callable[[Rng], Part]] = {
    function.__name__: function
    for function in (
        blob, creature, metaballs, lattice_solid, spiky, seashell, tree, plant, turned, tube, gear, flange,
        boolean_solid, ngon_solid, sheet, furniture, building, truss, vehicle, robot_arm, stack, glyphs,
        array,
    )
}  # fmt: skip
"""Each takes a generator and returns a part of any size and place."""

_COMMON = {
    "creature": 3.0,
    "blob": 1.5,
    "furniture": 2.0,
    "turned": 1.5,
    "boolean_solid": 2.0,
    "lattice_solid": 0.5,
    "sheet": 0.7,
}
_WEIGHTS = np.array([_COMMON.get(name, 1.0) for name in FAMILIES])
_WEIGHTS /= _WEIGHTS.sum()
