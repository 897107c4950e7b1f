"""Free placement: pixels of a picture on demand, within a budget, their time not counted."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.picture.order import Size, check_pixels, pixel_count
from bobrossnet.support.errors import InputError

F32: TypeAlias = NDArray[np.float32]


class Ask:
    """A tracer that looks pixels up in a picture.

    Parameters
    ----------
    full : GBuffer with every pixel traced
    share : of the pixels that may be asked for
    """

    def __init__(self, full: bob.GBuffer, share: float) -> None:
        self._planes, self._layout = full.planes, full.layout
        self._asked = np.zeros(full.size, np.bool_)
        self.size: Size = full.size
        self.budget = pixel_count(share, full.size)
        """Maximum number of distinct pixels."""
        self.seconds = 0.0
        """Processor time within the calls."""

    def __call__(self, pixels: NDArray[np.int32]) -> bob.Samples:
        """Return the samples of pixels, (n, 2) rows and columns. InputError beyond the budget."""
        start = time.process_time()
        row, column = check_pixels(pixels).T
        self._asked[row, column] = True
        if (asked := np.count_nonzero(self._asked)) > self.budget:
            raise InputError(f"pixels: expected at most {self.budget} distinct ones, got {asked}")
        values = np.ascontiguousarray(self._planes[:, row, column].T)
        depth = values[:, self._layout.places["depth"].start]
        values[:, 0] = depth > 0  # in samples the mask is whether the ray hit
        samples = bob.Samples.from_values(values, self._layout)
        self.seconds += time.process_time() - start
        return samples


Placement: TypeAlias = Callable[[Ask], F32]
"""Asks for pixels and returns the picture, (H, W)."""
