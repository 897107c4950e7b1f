"""Solids repeated in a circle."""

from __future__ import annotations

import numpy as np

from bobrossnet.sdf.d3 import SDF3


def around(solid: SDF3, count: int, radius: float = 0.0) -> SDF3:
    """Return `count` copies of a solid, translated along x by a radius and rotated about the z axis.

    Unlike `circular_array`, which folds space, each copy is a separate solid: bounds can be derived, and a few copies
    trace faster.
    """
    moved = solid.translate((radius, 0, 0))
    return moved.union(*(moved.rotate(2 * np.pi * i / count) for i in range(1, count))) if count > 1 else moved
