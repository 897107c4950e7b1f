"""Organic and soft shapes: blobs, creatures, clay, thorns, shells, cloth. Leaves and trees are in plants.py."""

from __future__ import annotations

import numpy as np

from bobrossnet.learn.shapes.meshes import parts
from bobrossnet.learn.shapes.meshes.parts import Part, Rng, join, moved, rotation


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
    """Capsules blended into a bilaterally symmetric body: animals, characters, dolls."""
    x, y, z = parts.lattice(int(rng.choice([40, 56, 72])))
    limbs = int(rng.integers(3, 9))
    body = rng.uniform(-0.35, 0.35, 3) * (1, 0, 1)
    field = np.full(np.broadcast_shapes(x.shape, y.shape, z.shape), 9.0)  # far outside
    blend = rng.uniform(0.02, 0.12)
    for limb in range(limbs):
        start = body + rng.uniform(-0.3, 0.3, 3) * (1, 0.3, 1)
        end = start + rng.normal(size=3) * rng.uniform(0.1, 0.5)
        start, end = np.clip(start, -0.7, 0.7), np.clip(end, -0.75, 0.75)
        thick, thin = rng.uniform(0.08, 0.24), rng.uniform(0.03, 0.15)
        for side in (1, -1) if limb else (1,):  # the first is the trunk
            a, b = start * (1, side, 1), end * (1, side, 1)
            d = b - a
            along = ((x - a[0]) * d[0] + (y - a[1]) * d[1] + (z - a[2]) * d[2]) / max(float(d @ d), 1e-6)
            along = np.clip(along, 0, 1)
            dx, dy, dz = x - a[0] - along * d[0], y - a[1] - along * d[1], z - a[2] - along * d[2]
            capsule = np.sqrt(dx**2 + dy**2 + dz**2) - thick - (thin - thick) * along
            mix = np.clip(0.5 + 0.5 * (field - capsule) / blend, 0, 1)  # the smooth minimum of the two
            field = field * (1 - mix) + capsule * mix - blend * mix * (1 - mix)
    part = parts.isosurface(field)
    if rng.random() < 0.5:
        part = parts.displaced(part, rng.uniform(0.005, 0.02) * parts.noise(rng, part[0], rng.uniform(6, 25)))
    return part


def metaballs(rng: Rng) -> Part:
    """Blended balls, sometimes hollowed or cut: clay, bones, sponges."""
    x, y, z = parts.lattice(48)
    field = np.full((48, 48, 48), float(rng.uniform(0.6, 1.4)))
    for _ in range(int(rng.integers(3, 14))):
        cx, cy, cz = rng.uniform(-0.6, 0.6, 3)
        reach = rng.uniform(0.02, 0.12)
        sign = -1 if rng.random() < 0.85 else 1
        field = field + sign * reach / ((x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2 + 0.02)
    if rng.random() < 0.3:
        field = np.maximum(field, rng.uniform(-0.2, 0.3) - x)
    return parts.isosurface(field)


def spiky(rng: Rng) -> Part:
    """A ball or an ellipsoid with many cones or knobs: viruses, cacti, maces."""
    count = int(rng.integers(15, 120))
    sides = int(rng.choice([4, 6, 12]))
    length, width = rng.uniform(0.1, 0.9), rng.uniform(0.03, 0.15)
    if rng.random() < 0.35:
        thorn = join([parts.cylinder(width * 0.4, length, sides), moved(parts.sphere(12), width, (0, 0, length))])
    else:
        thorn = parts.cylinder(width, length, sides, 0.0)
    pieces = [parts.sphere(48)]
    height = 1 - 2 * (np.arange(count) + 0.5) / count
    turn = np.pi * (1 + 5**0.5) * np.arange(count)  # a Fibonacci spiral
    for z, angle in zip(height, turn, strict=True):
        outwards = rotation(2, angle) @ rotation(1, np.arccos(z)) @ np.diag([1, 1, rng.uniform(0.6, 1)])
        radius = np.sqrt(1 - z * z)
        pieces.append(moved(thorn, outwards, 0.97 * np.array([radius * np.cos(angle), radius * np.sin(angle), z])))
    return moved(join(pieces), np.diag(rng.uniform(0.6, 1.4, 3)))


def seashell(rng: Rng) -> Part:
    """A growing spiral tube: shells, horns, tails."""
    t = np.linspace(0, rng.uniform(1, 5), 240)
    grow = np.exp(rng.uniform(0.2, 0.8) * (t - t[-1]))
    drop = -rng.uniform(0.2, 2.5) * np.ones_like(t)
    path = np.stack([np.cos(2 * np.pi * t), np.sin(2 * np.pi * t), drop], 1) * grow[:, None]
    ribs = 1 + rng.uniform(0, 0.12) * np.sin(2 * np.pi * rng.integers(6, 25) * t)
    return parts.sweep(path, parts.round_outline(28) * rng.uniform(0.25, 0.55), grow * ribs)


def sheet(rng: Rng) -> Part:
    """Thin curved surfaces: cloth, flags, hulls, terrain."""
    n = int(rng.choice([40, 120]))
    u, v = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n), indexing="ij")
    flat = np.stack([u, v, 0 * u], -1).reshape(-1, 3)
    height = np.zeros(n * n)
    kind = rng.integers(3)  # terrain, cloth, or a dome
    for octave in range(6 if kind == 0 else 2):
        height += rng.uniform(0.5, 1) * parts.noise(rng, flat, 1.5 * 2.0**octave) * 0.45**octave
    points = flat + height[:, None] * (0, 0, rng.uniform(0.05, 0.4))
    if kind == 2:
        points[:, 2] -= rng.uniform(0.3, 1) * (flat**2).sum(1)
    return parts.grid(points.reshape(n, n, 3))
