"""Crossings of rays with the surfaces of a scene, one after the other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from bobrossnet.tracing.scene import Scene

APART = 2e-5
"""Step off a surface before the next ray, in radii of the shape: above the float32 of hits."""

MAX_CROSSINGS = 500
"""Surfaces on a ray."""


def crossings(
    scene: Scene, origins: NDArray[np.float64], directions: NDArray[np.float64]
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.float64]]]:
    """Yield, surface by surface, the indices of the rays that meet another one, (k,), and the points, (k, 3).

    Parameters
    ----------
    scene : Scene
    origins, directions : (n, 3)
        Directions have unit length.
    """
    alive, starts = np.arange(len(origins)), origins
    for _ in range(MAX_CROSSINGS):
        hits = scene.closest_hits(starts, directions[alive])
        met = hits.instance >= 0
        alive = alive[met]
        if not len(alive):
            return
        points = starts[met] + hits.distance[met, None] * directions[alive]
        yield alive, points
        starts = points + APART * scene.radius * directions[alive]
