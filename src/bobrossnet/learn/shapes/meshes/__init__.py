"""Procedural training meshes: over twenty families of shapes, single or assembled, each from a seed.

They replace real shapes, which are reserved for testing: scans and creatures (organic, plants), turned and cast parts
(geometric, mechanical), furniture and buildings (built), and thin or repetitive structures (patterns).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bobrossnet.learn.shapes.meshes import built, geometric, mechanical, organic, parts, patterns, plants
from bobrossnet.learn.shapes.meshes.parts import Part, Rng, join, moved, rotation
from bobrossnet.shapes.mesh import Mesh

# Relative weight of each family. A seed's mesh depends on every entry and on their order.
_FREQUENCY: dict[Callable[[Rng], Part], float] = {
    organic.blob: 1.5,
    organic.creature: 3,
    organic.metaballs: 1,
    geometric.lattice_solid: 0.5,
    organic.spiky: 1,
    organic.seashell: 1,
    plants.tree: 1,
    plants.plant: 1,
    geometric.turned: 1.5,
    geometric.tube: 1,
    mechanical.gear: 1,
    mechanical.flange: 1,
    geometric.boolean_solid: 2,
    geometric.ngon_solid: 1,
    organic.sheet: 0.7,
    built.furniture: 2,
    built.building: 1,
    patterns.truss: 1,
    mechanical.vehicle: 1,
    mechanical.robot_arm: 1,
    patterns.stack: 1,
    patterns.glyphs: 1,
    patterns.array: 1,
}
FAMILIES = {family.__name__: family for family in _FREQUENCY}
"""The families; each takes a generator and returns a part of any size and position."""
_CHANCES = np.array(list(_FREQUENCY.values())) / sum(_FREQUENCY.values())


def procedural_mesh(seed: int) -> Mesh:
    """Return the mesh of a seed.

    Parameters
    ----------
    seed : int of at least 0

    Returns
    -------
    Mesh
        About 100 to 100,000 triangles; the bounding box is centred on the origin, with a longest side of 2.
    """
    rng = np.random.Generator(np.random.Philox(key=[seed, 0x5EED]))
    count = 1 if rng.random() < 0.6 else int(rng.integers(2, 9))
    part = finished(rng, some_family(rng)) if count == 1 else assembly(rng, count)
    if rng.random() < 0.15:
        part = deformed(rng, part)
    return Mesh(*parts.fitted(part))


def some_family(rng: Rng) -> Part:
    """Return a part of a random family, fitted."""
    family = list(_FREQUENCY)[rng.choice(len(_FREQUENCY), p=_CHANCES)]
    return parts.fitted(family(rng))


def finished(rng: Rng, part: Part) -> Part:
    """Return the part non-uniformly scaled, sometimes with a rough surface."""
    if rng.random() < 0.5:
        part = moved(part, np.diag(np.exp(rng.normal(0, 0.3, 3))))
    if len(part[0]) > 3000 and rng.random() < 0.25:
        part = parts.displaced(part, rng.uniform(0.004, 0.015) * parts.noise(rng, part[0], rng.uniform(8, 30)))
    return part


def assembly(rng: Rng, count: int) -> Part:
    """Return several parts, each placed on a random point of the previous ones."""
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
