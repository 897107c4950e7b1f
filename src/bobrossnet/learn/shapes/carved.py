"""Solids cut out of solids: machined parts with holes, pockets, slots and rounded edges."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bobrossnet.sdf import X, Y, Z, box, cylinder
from bobrossnet.shapes.scene import SceneLike

Rng = np.random.Generator


def drilled_block(rng: Rng) -> SceneLike:
    """A block with bores along its axes."""
    solid = box(rng.uniform(0.8, 2, 3))
    for axis in (X, Y, Z):
        if rng.random() < 0.7:
            solid -= cylinder(rng.uniform(0.1, 0.35)).orient(axis)
    return solid


FAMILIES: dict[str, Callable[[Rng], SceneLike]] = {family.__name__: family for family in (drilled_block,)}
