"""The pixels of an order, piece by piece as they are traced."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.picture.channels import Layout
from bobrossnet.picture.order import ADAPTIVE, Size, check_order, pixel_order


class PixelSequence:
    """Which pixels are traced next. Every order ends with all of them.

    Parameters
    ----------
    size : (height, width)
    order, seed
        As in `trace`.

    Raises
    ------
    InputError
        If there is no such order, or no such seed.
    """

    def __init__(self, size: Size, order: str, seed: int) -> None:
        self.size, self.order, self.seed = size, check_order(order, seed), int(seed)
        self.done = 0
        """How many were handed out."""
        self._adaptive = _core.AdaptiveOrder(self.seed, *size) if self.order == ADAPTIVE else None
        self._round = np.empty((0, 2), np.int32)  # what is left of it

    @property
    def looks(self) -> bool:
        """Whether the next pixels depend on what those before show."""
        return self._adaptive is not None and not len(self._round)

    def next(self, count: int, planes: NDArray[np.float32], layout: Layout) -> NDArray[np.int32]:
        """The next pixels.

        Parameters
        ----------
        count : int, above 0 and at most as many as are left
        planes : (C, H, W) of the layout
            What all pixels handed out before show; an order that depends on it looks there.

        Returns
        -------
        (n, 2) int32, row and column
            `count` of them, or fewer, but at least one, where what comes after depends on what they show.
        """
        if self._adaptive is None:
            pixels = pixel_order(self.size, order=self.order, seed=self.seed, start=self.done, count=count)
        else:
            if not len(self._round):
                self._round = self._adaptive.next(layout.core, planes)
            pixels, self._round = self._round[:count], self._round[count:]
        self.done += len(pixels)
        return pixels


def places_in_sequence(planes: NDArray[np.float32], layout: Layout, order: str, seed: int) -> NDArray[np.int32]:
    """Return the place of each pixel of a whole picture in the sequence, (H, W), 0 for the first: those below n are its
    first n.

    Parameters
    ----------
    planes : (C, H, W) of the layout
        Of the whole picture.
    order, seed
        As in `trace`.
    """
    size = (planes.shape[1], planes.shape[2])
    sequence = PixelSequence(size, order, seed)
    places = np.empty(size, np.int32)
    while (done := sequence.done) < places.size:
        rows, columns = sequence.next(places.size - done, planes, layout).T
        places[rows, columns] = np.arange(done, sequence.done)
    return places
