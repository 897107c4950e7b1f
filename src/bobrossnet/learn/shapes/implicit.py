"""Implicit surfaces to learn from: blends, swarms and periodic surfaces, smooth and organic."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bobrossnet.sdf import sphere
from bobrossnet.shapes.scene import SceneLike

Rng = np.random.Generator


def blob(rng: Rng) -> SceneLike:
    """A few spheres that run into each other."""
    solid = sphere(rng.uniform(0.4, 0.8))
    for _ in range(int(rng.integers(2, 7))):
        solid = solid.union(sphere(rng.uniform(0.2, 0.6)).translate(rng.normal(0, 0.5, 3)), k=rng.uniform(0.05, 0.4))
    return solid


FAMILIES: dict[str, Callable[[Rng], SceneLike]] = {family.__name__: family for family in (blob,)}
