"""Numbers of pixels for each call of a user's tracer."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.order import MAX_PIXELS
from bobrossnet.support.errors import check_integer


class CallSizes:
    """A small set of call sizes, since some tracers compile again for each new size.

    Parameters
    ----------
    batch : int above 0, optional
        The tracer's fixed size. If omitted, powers of two and their midpoints, where the pixel order permits.
    """

    def __init__(self, batch: object) -> None:
        self.batch = None if batch is None else check_integer("tracer.batch", batch, 1, MAX_PIXELS)

    def within(self, count: int, at_least: bool) -> int:
        """Return the largest size up to `count`; if there is no such size, the smallest if `at_least`, otherwise 0."""
        if self.batch is not None:
            return self.batch if at_least or count >= self.batch else 0
        if count < 2:
            return 1 if at_least else count
        power = 1 << (count.bit_length() - 1)
        return power + power // 2 if count >= power + power // 2 else power

    def padded(self, pixels: NDArray[Any]) -> NDArray[Any]:
        """Pad pixels or positions, (n, 2), to a whole batch by repeating the last one."""
        missing = 0 if self.batch is None else -len(pixels) % self.batch
        return np.concatenate([pixels, np.repeat(pixels[-1:], missing, axis=0)]) if missing else pixels
