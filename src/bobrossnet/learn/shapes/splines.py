"""NURBS to learn from: vessels, hulls, patches, tubes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import bobrossnet as bob
from bobrossnet.shapes.scene import SceneLike

Rng = np.random.Generator


def sail(rng: Rng) -> SceneLike:
    """A bicubic patch over a square, its control points lifted."""
    n = int(rng.integers(4, 8))
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n), indexing="ij")
    control_points = np.stack([x, y, rng.normal(0, 0.4, (n, n))], 2)
    knots = np.concatenate([np.zeros(4), np.arange(1, n - 3), np.full(4, n - 3.0)])
    return bob.nurbs_surface(control_points, knots, knots)


FAMILIES: dict[str, Callable[[Rng], SceneLike]] = {family.__name__: family for family in (sail,)}
