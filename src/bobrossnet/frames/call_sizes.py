"""With how many pixels other people's tracers are called."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.order import MAX_PIXELS
from bobrossnet.support.errors import check_integer


class CallSizes:
    """Few different numbers, as some tracers compile for each anew.

    Parameters
    ----------
    batch : int above 0, optional
        The tracer's own number; otherwise powers of two and those in the middle between them, as far as the order of
        pixels lets it.
    """

    def __init__(self, batch: object) -> None:
        self.batch = None if batch is None else check_integer("tracer.batch", batch, 1, MAX_PIXELS)

    def within(self, count: int, at_least: bool) -> int:
        """The largest of these up to `count`, or else 0, or if `at_least` the smallest."""
        if self.batch is not None:
            return self.batch if at_least or count >= self.batch else 0
        if count < 2:
            return 1 if at_least else count
        power = 1 << (count.bit_length() - 1)
        return power + power // 2 if count >= power + power // 2 else power

    def padded(self, pixels: NDArray[np.int32]) -> NDArray[np.int32]:
        """Pixels, (n, 2), to a whole batch: the last one is asked for again."""
        missing = 0 if self.batch is None else -len(pixels) % self.batch
        return np.concatenate([pixels, np.repeat(pixels[-1:], missing, axis=0)]) if missing else pixels


class Turnover:
    """How many pixels come in a given time where several calls are under way, as measured.

    How long a call takes is no measure of that: calls also wait for each other. So what counts is how many pixels of
    all calls came in what time: with c under way, each of n pixels comes after c n / rate seconds (Little, 1961).
    """

    FIRST = 32  # pixels of the first calls, when nothing is known
    GROWTH = 8  # a call has at most this many times the pixels of the largest
    TURNS = 2  # what came so many turns of all calls ago counts 1 / e of what comes now

    def __init__(self) -> None:
        self._pixels = self._seconds = 0.0  # that came, and what they took
        self._since = 0.0  # when the last one came, or when there were calls under way again
        self._count = 0
        self._fastest: dict[int, float] = {}  # seconds of the fastest call of each size

    def resumed(self, at: float) -> None:
        """A call began while no other was under way."""
        self._since = at

    def came(self, pixels: int, seconds: float, at: float, in_flight: int) -> None:
        """A call came at this time, so many seconds after it began."""
        fade = 1 - 1 / (self.TURNS * in_flight)
        self._pixels = fade * self._pixels + pixels
        self._seconds = fade * self._seconds + at - self._since
        self._since = at
        self._count += 1
        self._fastest[pixels] = min(seconds, self._fastest.get(pixels, seconds))

    def pixels_in(self, seconds: float, in_flight: int) -> int:
        """How many pixels a call has that comes after so many seconds; at least as many as are worth one."""
        if self._count < in_flight:
            return self.FIRST
        count = seconds * self._pixels / max(self._seconds, 1e-9) / in_flight
        return max(1, int(min(max(count, self.worthwhile()), self.GROWTH * max(self._fastest))))

    def worthwhile(self) -> int:
        """How many pixels take as long as the call around them, by the fastest calls of the fewest and the most pixels:
        those waited least. A line through all takes waiting for a call's own cost, and its calls grow without end: with
        16 workers and 32 calls under way from 24 pixels to 3,000, which came after 8 seconds."""
        if len(self._fastest) < 2:
            return 1
        (few, least), (many, most) = min(self._fastest.items()), max(self._fastest.items())
        if most <= least:
            return many
        return max(1, int(least * (many - few) / (most - least) - few))
