"""The sequence of traced pixels of an order, handed out piece by piece."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.picture.channels import Layout
from bobrossnet.picture.guides import Guides
from bobrossnet.picture.order import ADAPTIVE, PRIORITY, SQUARES, Size, check_order, pixel_order


class PixelSequence:
    """The sequence of pixels to trace. Every order ends with all of them.

    Parameters
    ----------
    size : (height, width)
    order, seed
        As in `trace`.
    guides : Guides, optional
        Channels of all pixels: the adaptive order also visits surfaces that differ from all traced neighbours.

    Raises
    ------
    InputError
        If the order or the seed is invalid.
    """

    def __init__(self, size: Size, order: str, seed: int, guides: Guides | None = None) -> None:
        self.size, self.order, self.seed = size, check_order(order, seed), int(seed)
        self.done = 0
        """Number of pixels handed out."""
        self._rounds: _core.RoundOrder | None = None
        """The core's adaptive order; None for orders that do not depend on traced values."""
        if self.order == ADAPTIVE:
            known = () if guides is None else (guides.layout.core, guides.planes)
            self._rounds = _core.AdaptiveOrder(self.seed, *size, *known)
        elif self.order in (SQUARES, PRIORITY):
            self._rounds = _core.SquaresOrder(*size, by_priority=self.order == PRIORITY)
        self._round = np.empty((0, 2), np.int32)  # rest of the current round
        self._begun = 0  # number of rounds begun

    def turn_to_squares(self, mask: NDArray[np.float32]) -> None:
        """Continue in the order `SQUARES` where a round ends; `mask`, (H, W), is not 0 at pixels handed out."""
        self._rounds = _core.SquaresOrder(*self.size, mask)
        self.order = SQUARES

    @property
    def in_first_round(self) -> bool:
        """Whether the pixels handed out last belong to the first round of an order with rounds."""
        return self._begun == 1

    @property
    def looks(self) -> bool:
        """Whether the next pixels depend on the traced values."""
        return self._rounds is not None and not len(self._round)

    def next(self, count: int, planes: NDArray[np.float32], layout: Layout) -> NDArray[np.int32]:
        """Return the next pixels.

        Parameters
        ----------
        count : int, from 1 to the number of pixels left
        planes : (C, H, W) of the layout
            Traced values of all pixels handed out before, read by adaptive orders.

        Returns
        -------
        (n, 2) int32, row and column
            `count` pixels, or fewer but at least one, where later pixels depend on the values of these.
        """
        if self._rounds is None:
            pixels = pixel_order(self.size, order=self.order, seed=self.seed, start=self.done, count=count)
        else:
            if not len(self._round):
                self._round = self._rounds.next(layout.core, planes)
                self._begun += 1
            pixels, self._round = self._round[:count], self._round[count:]
        self.done += len(pixels)
        return pixels


def places_in_sequence(planes: NDArray[np.float32], layout: Layout, order: str, seed: int) -> NDArray[np.int32]:
    """Return each pixel's place in the sequence of a whole picture, (H, W), from 0.

    Places below n are the first n pixels.

    Parameters
    ----------
    planes : (C, H, W) of the layout
        Values of the whole picture.
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


def with_guesses(planes: NDArray[np.float32], pixels: NDArray[np.int32]) -> NDArray[np.float32]:
    """Return planes, (C, H, W) with the mask first, with guesses at pixels in flight, (n, 2).

    The guess is the value of a nearby traced pixel. Without it, an adaptive order takes these pixels for background:
    SSIM at 5 % of the happy tree with 17 calls of 24 pixels in flight is 0.917 without guesses, 0.940 with them.
    """
    guessed = planes.copy()
    row, column = pixels.T
    guessed[:, row, column] = planes.reshape(len(planes), -1)[:, _near(planes[0], row, column)]
    return guessed


def _near(mask: NDArray[np.float32], row: NDArray[np.int32], column: NDArray[np.int32]) -> NDArray[np.int64]:
    """Return the index of a nearby traced pixel for each place, or 0 if no pixel is traced.

    It lies in the smallest square of a quadtree that has a pixel with a nonzero mask.
    """
    known = np.where(mask != 0, np.arange(mask.size).reshape(mask.shape), -1)  # the last traced pixel of each square
    found = known[row, column]
    while (found < 0).any() and known.size > 1:
        known = np.pad(known, [(0, side % 2) for side in known.shape], constant_values=-1)
        known = np.maximum(
            np.maximum(known[::2, ::2], known[1::2, ::2]), np.maximum(known[::2, 1::2], known[1::2, 1::2])
        )
        row, column = row // 2, column // 2
        found = np.where(found < 0, known[row, column], found)
    return np.maximum(found, 0)
