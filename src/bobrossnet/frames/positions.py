"""Several samples in each pixel of a user's tracer, for smooth edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.samples import Samples, grid_side
from bobrossnet.support.errors import InputError

LIGHT = ("gray", "color")
"""Channels that are averaged. The other channels come from the sample nearest to the pixel's centre: a mean of depths
lies on no surface."""


class Positions:
    """A grid of positions in each pixel.

    Parameters
    ----------
    samples : 1, 4, 9, 16, 25, 36, 49 or 64
        As in `render`.
    """

    def __init__(self, samples: int) -> None:
        side = grid_side(samples)
        steps = (np.arange(side) + 0.5) / side - 0.5
        self._offsets = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
        self._nearest = side // 2 * (side + 1)

    def __len__(self) -> int:
        return len(self._offsets)

    def pixels_of(self, batch: int) -> int:
        """Return the number of pixels whose positions fit into a tracer's batch."""
        if batch < len(self):
            raise InputError(f"samples: expected at most the tracer's batch, {batch}, got {len(self)}")
        return batch // len(self)

    def of(self, pixels: NDArray[np.int32]) -> NDArray[np.float64]:
        """Return the positions of pixels, (n * samples, 2) rows and columns, pixel after pixel."""
        positions: NDArray[np.float64] = (pixels[:, None] + self._offsets).reshape(-1, 2)
        return positions

    def mean(self, samples: Samples, pixels: int) -> Samples:
        """Return one sample for each of the first `pixels` pixels; further samples are padding."""
        several = samples.values[: pixels * len(self)].reshape(pixels, len(self), -1)
        values = several[:, self._nearest].copy()
        for name in LIGHT:
            if (place := samples.layout.places.get(name)) is not None:
                values[:, place] = several[:, :, place].mean(axis=1)
        if (place := samples.layout.places.get("variance")) is not None:
            values[:, place] = several[:, :, place].mean(axis=1) / len(self)  # of a mean of independent samples
        mean = Samples.from_values(values, samples.layout)
        mean.given = samples.given
        return mean
