"""Surfaces of formulas: periodic and algebraic ones, knots, waves on balls."""

# mypy: disable-error-code="no-any-return"
from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from bobrossnet import implicit
from bobrossnet.learn.shapes.copies import around
from bobrossnet.sdf.d3 import SDF3, X, Z, box, capped_cylinder, capsule, cylinder, rounded_box, slab, sphere, torus
from bobrossnet.tracing.scene import SceneLike

Rng = np.random.Generator
Field = Callable[[Any, Any, Any], Any]

# Periodic minimal surfaces, as sums of waves that approximate them (Schnering and Nesper, 1991).
_PERIODIC: dict[str, Field] = {
    "gyroid": lambda x, y, z: np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x),
    "schwarz_p": lambda x, y, z: np.cos(x) + np.cos(y) + np.cos(z),
    "schwarz_d": lambda x, y, z: np.cos(x) * np.cos(y) * np.cos(z) - np.sin(x) * np.sin(y) * np.sin(z),
    "neovius": lambda x, y, z: (np.cos(x) + np.cos(y) + np.cos(z)) * 0.75 + np.cos(x) * np.cos(y) * np.cos(z),
    "iwp": lambda x, y, z: (
        np.cos(x) * np.cos(y)
        + np.cos(y) * np.cos(z)
        + np.cos(z) * np.cos(x)
        - 0.5 * (np.cos(2 * x) + np.cos(2 * y) + np.cos(2 * z))
    ),
}

_GOLDEN = (1 + np.sqrt(5)) / 2


def _barth_sextic(x: Any, y: Any, z: Any) -> Any:
    g = _GOLDEN**2
    planes = (g * x * x - y * y) * (g * y * y - z * z) * (g * z * z - x * x)
    return -4 * planes + (1 + 2 * _GOLDEN) * (x * x + y * y + z * z - 1) ** 2


def _chmutov(x: Any, y: Any, z: Any) -> Any:
    return sum(8 * t**4 - 8 * t * t + 1 for t in (x, y, z))


def _genus_2(x: Any, y: Any, z: Any) -> Any:
    return 2 * y * (y * y - 3 * x * x) * (1 - z * z) + (x * x + y * y) ** 2 - (9 * z * z - 1) * (1 - z * z)


def _heart(x: Any, y: Any, z: Any) -> Any:
    return (x * x + 2.25 * y * y + z * z - 1) ** 3 - (x * x + 0.1125 * y * y) * z**3


def _clebsch(x: Any, y: Any, z: Any) -> Any:
    cubes = 81 * (x**3 + y**3 + z**3) - 189 * (x * x * (y + z) + y * y * (x + z) + z * z * (x + y))
    return cubes + 54 * x * y * z + 126 * (x * y + y * z + z * x) - 9 * (x * x + y * y + z * z) - 9 * (x + y + z) + 1


def _cayley(x: Any, y: Any, z: Any) -> Any:
    return x * x + y * y - x * x * z + y * y * z + z * z - 1


def _decocube(x: Any, y: Any, z: Any) -> Any:
    rings = [(a * a + b * b - 0.64) ** 2 + (c * c - 1) ** 2 for a, b, c in ((x, y, z), (y, z, x), (z, x, y))]
    return rings[0] * rings[1] * rings[2] - 0.02


def _tangle(x: Any, y: Any, z: Any) -> Any:
    return x**4 + y**4 + z**4 - 5 * (x * x + y * y + z * z) + 11.8


def _kummer(x: Any, y: Any, z: Any) -> Any:
    a, m = np.sqrt(2.0), 1.3
    planes = (1 - z - a * x) * (1 - z + a * x) * (1 + z + a * y) * (1 + z - a * y)
    return (x * x + y * y + z * z - m) ** 2 - (3 * m - 1) / (3 - m) * planes


# By name: the polynomial, and the radius of a ball around its interesting part.
_ALGEBRAIC: dict[str, tuple[Field, float]] = {
    "tangle": (_tangle, 3.4),
    "barth_sextic": (_barth_sextic, 2.2),
    "chmutov": (_chmutov, 2),
    "genus_2": (_genus_2, 2.2),
    "heart": (_heart, 1.6),
    "clebsch": (_clebsch, 1.6),
    "cayley": (_cayley, 3),
    "decocube": (_decocube, 1.7),
    "kummer": (_kummer, 3),
}


def _envelope(rng: Rng) -> SDF3:
    """A solid about 2 wide, which other solids are cut from."""
    kind = rng.choice(["ball", "box", "capsule", "cylinder", "ring", "half"])
    if kind == "box":
        return rounded_box(rng.uniform(1, 2, 3), rng.choice([0.01, 0.2]))
    if kind == "capsule":
        return capsule(-Z * 0.6, Z * 0.6, rng.uniform(0.5, 0.8))
    if kind == "cylinder":
        return capped_cylinder(-Z * 0.8, Z * 0.8, rng.uniform(0.5, 1))
    if kind == "ring":
        return torus(1, rng.uniform(0.3, 0.5))
    return sphere(1) if kind == "ball" else sphere(1) & slab(z1=rng.uniform(0, 0.4))


def periodic_surface(rng: Rng) -> SceneLike:
    """A triply periodic minimal surface, as a sheet or one of its two sides, cut by a solid or filling its skin."""
    wave = _PERIODIC[rng.choice(list(_PERIODIC))]
    scale = rng.uniform(3, 11)
    stretch = rng.uniform(0.7, 1.4, 3) * scale if rng.random() < 0.4 else np.full(3, scale)
    phase, level = rng.uniform(0, 2 * np.pi, 3), rng.uniform(-0.4, 0.4)
    thick, graded = rng.uniform(0.1, 0.45), rng.choice([0, 0.3])
    sheet = rng.random() < 0.6

    def field(x: Any, y: Any, z: Any) -> Any:
        value = wave(*(s * t + p for s, t, p in zip(stretch, (x, y, z), phase, strict=True)))
        half = thick * (1 + graded * z)
        return (np.abs(value) - half if sheet else value - level + graded * z) / scale

    solid = implicit(field) & _envelope(rng)
    if rng.random() < 0.2:
        solid |= sphere(1).shell(0.06) & slab(x0=0)
    return solid


def algebraic_surface(rng: Rng) -> SceneLike:
    """A classic surface of low degree, with varied level and proportions, cut by a ball or a box."""
    polynomial, reach = _ALGEBRAIC[rng.choice(list(_ALGEBRAIC))]
    stretch = rng.uniform(0.8, 1.2, 3)
    level = rng.normal(0, 0.02)
    solid = implicit(lambda x, y, z: polynomial(stretch[0] * x, stretch[1] * y, stretch[2] * z) - level)
    return solid & (sphere(reach) if rng.random() < 0.7 else box(1.6 * reach))


def rock(rng: Rng) -> SceneLike:
    """A ball with waves, folds or ridges of several sizes, like a stone, a planet, a fruit or a brain."""
    count = int(rng.integers(2, 6))
    waves = [
        (rng.normal(0, 2, 3) * 1.7**octave, rng.uniform(0, 2 * np.pi), rng.uniform(0.1, 0.25) / 2**octave)
        for octave in range(count)
    ]
    kind, stretch = rng.choice(["smooth", "folded", "cells", "fruit"]), rng.uniform(0.7, 1.4, 3)
    petals, depth = int(rng.integers(3, 11)), rng.uniform(0.05, 0.2)
    fine = rng.uniform(5, 14)

    def field(x: Any, y: Any, z: Any) -> Any:
        height: Any = 0.0
        for (a, b, c), phase, high in waves:
            wave = np.sin(a * x + b * y + c * z + phase)
            height = height + high * (np.abs(wave) if kind == "folded" else wave)
        if kind == "cells":
            height = 0.3 * height + 0.5 * depth * np.sin(fine * x) * np.sin(fine * y) * np.sin(fine * z)
        elif kind == "fruit":
            height = 0.2 * height + depth * np.abs(np.cos(petals * np.arctan2(y, x) / 2)) * np.sqrt(x * x + y * y)
        x, y, z = stretch[0] * x, stretch[1] * y, stretch[2] * z
        return 0.5 * (np.sqrt(x * x + y * y + z * z) - 1 - height)

    solid = implicit(field, bounds=((-3, -3, -3), (3, 3, 3)))
    if rng.random() < 0.25:
        solid &= slab(z0=rng.uniform(-0.5, 0))
    return solid


def superquadric(rng: Rng) -> SceneLike:
    """A super-ellipsoid or super-toroid, from pillow to star, alone or stacked, whole or as a skin cut open."""
    solid: SDF3 | None = None
    low = 0.0
    for _ in range(int(rng.integers(1, 4))):
        flat, upright = 2 / rng.uniform(0.25, 2.6, 2)
        size = rng.uniform(0.4, 1, 3)
        hole = rng.choice([0, 1.4])

        def field(x: Any, y: Any, z: Any, flat: float = flat, upright: float = upright, hole: float = hole) -> Any:
            around = (np.abs(x) ** flat + np.abs(y) ** flat) ** (1 / flat) - hole
            return (np.abs(around) ** upright + np.abs(z) ** upright) ** (1 / upright) - 1

        size = size / (1 + hole) * (1, 1, 1 + 0.5 * hole)
        part = implicit(field, bounds=((-3, -3, -1.1), (3, 3, 1.1))).scale(size) & slab(
            z0=-1.1 * size[2], z1=1.1 * size[2]
        )
        part &= box(9)
        part = part.translate(Z * (low + size[2]))
        solid = part if solid is None else solid | part
        low += 1.8 * size[2]
    assert solid is not None
    if rng.random() < 0.3:
        solid = solid.shell(0.06) & slab(x0=-0.2)
    return solid


def knot(rng: Rng) -> SceneLike:
    """A torus knot or link as a tube, a rope of strands or a ribbon."""
    strands, turns = int(rng.integers(1, 6)), int(rng.integers(1, 8))
    middle, aside = 1.0, rng.uniform(0.25, 0.5)
    thick = rng.uniform(0.35, 0.95) * min(np.pi * aside / strands, aside) * 0.6
    flat = rng.choice([1, 1, 2.2])

    def field(x: Any, y: Any, z: Any) -> Any:
        angle = turns * np.arctan2(y, x) / strands
        out = np.sqrt(x * x + y * y) - middle
        nearest: Any = None
        for strand in range(strands):
            phase = angle + 2 * np.pi * strand / strands
            radial, along = out * np.cos(phase) + z * np.sin(phase) - aside, z * np.cos(phase) - out * np.sin(phase)
            distance = np.sqrt((flat * radial) ** 2 + (along / flat) ** 2 + 1e-9)
            nearest = distance if nearest is None else np.minimum(nearest, distance)
        return 0.6 * (nearest - thick)

    reach = 1.05 * (middle + aside + flat * thick)
    solid = implicit(field) & capped_cylinder(-Z * reach, Z * reach, reach)
    if rng.random() < 0.2:
        solid |= torus(middle, rng.uniform(0.3, 0.8) * max(aside - thick, 0.08))
    return solid


def chain(rng: Rng) -> SceneLike:
    """Chained links, in a row, in a ring, or as mail."""
    wire, long = rng.uniform(0.06, 0.13), rng.uniform(0, 0.3)
    link = torus(0.35, wire).elongate((long, 0, 0))
    pitch = 2 * (0.35 + long - wire) * rng.uniform(0.93, 0.99)
    turned = link.rotate(np.pi / 2, X)
    kind = rng.choice(["row", "ring", "mail"])
    if kind == "ring":
        count = int(rng.integers(5, 13))
        radius = 2 * count * pitch / (2 * np.pi)
        flat = around(link.rotate(np.pi / 2), count, radius)
        return flat | around(turned.rotate(np.pi / 2), count, radius).rotate(np.pi / count)
    count = int(rng.integers(1, 4))
    row = link.repeat((2 * pitch, 0, 0), count=(count, 0, 0))
    row |= turned.repeat((2 * pitch, 0, 0), count=(count, 0, 0)).translate(X * pitch)
    if kind == "row":
        return row
    lean = rng.uniform(0.3, 0.6)
    ring = torus(0.35, min(wire, 0.09))
    one = ring.rotate(lean, X).repeat((0.8, 0.9, 0), count=(count, count, 0))
    two = ring.rotate(-lean, X).repeat((0.8, 0.9, 0), count=(count, count, 0), padding=0)
    return one | two.translate((0.4, 0.45, 0))


def cage(rng: Rng) -> SceneLike:
    """Thin bars on a surface of revolution: hoops, ribs or spirals around a ball, an egg, a cone or a waist."""
    ribs, hoops, thick = int(rng.integers(3, 17)), int(rng.integers(2, 9)), rng.uniform(0.02, 0.06)
    twist, waist, tall = rng.choice([0, 0, 1, 3]) * rng.uniform(0.5, 1), rng.uniform(-0.6, 0.6), rng.uniform(0.6, 1.3)
    both = rng.random() < 0.5

    def field(x: Any, y: Any, z: Any) -> Any:
        around, out = np.arctan2(y, x), np.sqrt(x * x + y * y)
        surface = out - (0.75 + waist * (z / tall) ** 2 - 0.2 * z / tall)
        wide = out / ribs
        bars = np.abs(np.sin(0.5 * ribs * (around + twist * z))) * 2 * wide
        if both:
            other = np.abs(np.sin(0.5 * ribs * (around - twist * z))) * 2 * wide
        else:
            other = np.abs(np.sin(np.pi * hoops * (z / tall + 1) / 2)) * 2 * tall / (np.pi * hoops)
        return 0.5 * (np.sqrt(surface * surface + np.minimum(bars, other) ** 2 + 1e-9) - thick)

    return implicit(field) & (cylinder(1.6) & slab(z0=-tall - thick, z1=tall + thick))


def snail(rng: Rng) -> SceneLike:
    """A tube with a spiral axis and growing radius, like snails and ammonites (Raup, 1966), with or without ribs."""
    growth, rise, ribs = rng.uniform(0.08, 0.2), rng.choice([0, rng.uniform(0.5, 1.6)]), int(rng.integers(8, 30))
    ratio = np.exp(2 * np.pi * growth)  # radius from one turn to the next
    tube = (ratio - 1) / (ratio + 1) * rng.uniform(0.8, 1.05)
    depth, wall = rng.choice([0, 0.08]), rng.uniform(0.75, 0.92)

    def field(x: Any, y: Any, z: Any) -> Any:
        around = np.arctan2(y, x)
        nearest: Any = None
        for turn in range(4):
            angle = around - 2 * np.pi * turn
            middle = np.exp(growth * angle)
            out, up = np.sqrt(x * x + y * y) - middle, z - rise * (1 - middle)
            size = tube * middle * (1 - depth * np.abs(np.sin(0.5 * ribs * angle)))
            distance = np.sqrt(out * out + up * up)
            if turn == 0:  # open at the mouth
                distance = np.where(
                    angle > np.pi - 0.6, np.abs(distance - 0.5 * (1 + wall) * size) + 0.5 * (1 + wall) * size, distance
                )
            nearest = distance - size if nearest is None else np.minimum(nearest, distance - size)
        return 0.6 * nearest

    reach = 3.5
    return implicit(field, bounds=((-reach, -reach, -reach), (reach, reach, reach)))


FAMILIES: dict[str, Callable[[Rng], SceneLike]] = {
    family.__name__: family
    for family in (periodic_surface, algebraic_surface, rock, superquadric, knot, chain, cage, snail)
}
