"""Solids repeated in a circle."""

from __future__ import annotations

import numpy as np

from bobrossnet.sdf.d3 import SDF3


def around(solid: SDF3, count: int, radius: float = 0.0) -> SDF3:
    """Return `count` copies of a solid, moved outwards along x by a radius and turned around the z axis.

    Unlike `circular_array`, which folds space, each is a separate solid: bounds can be found, and a few of them are
    traced faster.
    """
    moved = solid.translate((radius, 0, 0))
    return moved.union(*(moved.rotate(2 * np.pi * i / count) for i in range(1, count))) if count > 1 else moved
