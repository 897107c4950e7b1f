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


class Turnover:
    """Measured throughput of a tracer with several calls in flight.

    The duration of one call is no measure of throughput, since calls also wait for each other. Instead this measures
    the rate, in pixels per second, over all calls. With c calls in flight, a call of n pixels returns after c n / rate
    seconds (Little, 1961).
    """

    FIRST = 32  # pixels of a first call, before any measurement
    GROWTH = 8  # a call has at most this factor times the pixels of the largest so far
    TURNS = 2  # time constant of the exponential decay, in rounds of all calls in flight

    def __init__(self) -> None:
        self._pixels = self._seconds = 0.0  # decayed sums: pixels returned, seconds taken
        self._since = 0.0  # time of the last return, or of the first call after an idle period
        self._count = 0
        self._fastest: dict[int, float] = {}  # seconds of the fastest call of each size

    def resumed(self, at: float) -> None:
        """Note that a call began while no other was in flight."""
        self._since = at

    def came(self, pixels: int, seconds: float, at: float, in_flight: int) -> None:
        """Note that a call returned at time `at`, `seconds` after it began."""
        fade = 1 - 1 / (self.TURNS * in_flight)
        self._pixels = fade * self._pixels + pixels
        self._seconds = fade * self._seconds + at - self._since
        self._since = at
        self._count += 1
        self._fastest[pixels] = min(seconds, self._fastest.get(pixels, seconds))

    def pixels_in(self, seconds: float, in_flight: int) -> int:
        """Return the number of pixels of a call that takes `seconds`, at least `worthwhile()`."""
        if self._count < in_flight:
            return self.FIRST
        count = seconds * self._pixels / max(self._seconds, 1e-9) / in_flight
        return max(1, int(min(max(count, self.worthwhile()), self.GROWTH * max(self._fastest))))

    def worthwhile(self) -> int:
        """Return the number of pixels that takes as long as the fixed cost of a call.

        Both costs come from the fastest calls of the smallest and the largest size, which waited least. A fit through
        all calls mistakes waiting for fixed cost and lets calls grow without bound: with 16 workers and 32 calls in
        flight, from 24 pixels to 3,000, which returned after 8 seconds.
        """
        if len(self._fastest) < 2:
            return 1
        (few, least), (many, most) = min(self._fastest.items()), max(self._fastest.items())
        if most <= least:
            return many
        return max(1, int(least * (many - few) / (most - least) - few))
