"""Calls of a user's tracer, which returns samples or futures of samples."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.frames.call_sizes import CallSizes
from bobrossnet.frames.positions import Positions
from bobrossnet.picture.samples import Samples
from bobrossnet.support.errors import InputError, InputTypeError, check_integer
from bobrossnet.tracing.trace import Tracer, check_samples

MOST_IN_FLIGHT = 2**16


class SamplesFuture(Protocol):
    """A future of samples: the common interface of the futures of `concurrent.futures` and Dask."""

    def add_done_callback(self, callback: Callable[[Any], object], /) -> object: ...

    def result(self) -> Samples:
        """Return the samples, or raise the call's exception."""

    def cancel(self) -> object: ...

    def cancelled(self) -> bool: ...


AsyncTracer: TypeAlias = Callable[[NDArray[np.int32]], Samples | SamplesFuture]
"""Like `Tracer`, but its calls may run in other threads, in processes or on other machines."""


@dataclass(frozen=True, eq=False)
class Call:
    """One call of a tracer."""

    pixels: NDArray[np.int32]
    """(n, 2)"""
    asked: int
    """Number of pixels including the padding to a whole batch."""
    places: int
    """Number of samples that the tracer is asked for."""
    is_first: bool
    """Whether its pixels are traced for the first time."""
    began: float
    """Time when the choice of its pixels began, by `time.perf_counter`."""
    returned: Any
    future: SamplesFuture | None
    """The returned future, or None if it returned samples."""


class Calls:
    """The calls of a tracer in flight.

    Parameters
    ----------
    tracer : Tracer or AsyncTracer
        May have the attributes `batch` and `in_flight`.
    positions : Positions, optional
        Of several samples in each pixel; by default the tracer is asked for pixels.
    """

    def __init__(self, tracer: Tracer | AsyncTracer, positions: Positions | None = None) -> None:
        self.tracer = tracer
        self.positions = positions
        batch = getattr(tracer, "batch", None)
        self._filled = CallSizes(batch)  # calls in positions
        filled = self._filled.batch
        self.sizes = CallSizes(filled if positions is None or filled is None else positions.pixels_of(filled))
        self.turnover = _core.Turnover()
        told = getattr(tracer, "in_flight", None)
        self._is_told = told is not None
        self.in_flight = 1 if told is None else check_integer("tracer.in_flight", told, 1, MOST_IN_FLIGHT)
        """Maximum number of calls in flight. Unless the tracer states it, one until it first returns a future."""
        self.under_way: list[Call] = []
        """Calls whose samples have not been taken yet."""
        self._dropped: set[Call] = set()  # still running, with their samples discarded
        self._came: SimpleQueue[tuple[Call, float]] = SimpleQueue()  # and the time of return
        self._given: frozenset[str] | None = None  # channels of the first samples

    @property
    def has_room(self) -> bool:
        return len(self.under_way) + len(self._dropped) < self.in_flight

    def begin(self, pixels: NDArray[np.int32], is_first: bool, began: float) -> bool:
        """Call the tracer; return whether the call continues in the background."""
        if not (self.under_way or self._dropped):
            self.turnover.resumed(began)
        asked = self.sizes.padded(pixels)
        places: NDArray[Any] = asked if self.positions is None else self._filled.padded(self.positions.of(asked))
        places = places.view()
        places.flags.writeable = False  # pixels later index the arrays that receive the samples
        returned = self.tracer(places)
        call = Call(pixels, len(asked), len(places), is_first, began, returned, _future(returned))
        self.under_way.append(call)
        if call.future is None:
            self._came.put((call, time.perf_counter()))
            return False
        if not self._is_told:
            self.in_flight, self._is_told = os.cpu_count() or 1, True
        call.future.add_done_callback(lambda _: self._came.put((call, time.perf_counter())))
        return True

    def take(self, timeout: float | None = None) -> tuple[Call, Samples, float] | None:
        """Return the next finished call, its samples and its time of return.

        Returns None if no call finishes within `timeout` seconds, or if the finished call was dropped.

        Raises
        ------
        InputError
            If the samples do not match the request. Exceptions of the call are passed on.
        """
        while True:
            try:
                call, at = self._came.get(timeout=None if timeout is None else max(timeout, 0))
            except Empty:
                return None
            is_cancelled = call.future is not None and call.future.cancelled()
            if self.in_flight > 1 and not is_cancelled:
                self.turnover.returned(call.asked, at - call.began, at, self.in_flight)
            if call in self.under_way:
                break
            self._dropped.discard(call)
            timeout = 0
        self.under_way.remove(call)
        if is_cancelled:
            raise InputError("tracer: expected samples, got a future that was cancelled")
        samples = check_samples(call.returned if call.future is None else call.future.result(), call.places)
        self._check_given(samples.given)
        if self.positions is not None:
            samples = self.positions.mean(samples, call.asked)
        if call.asked > len(call.pixels):
            samples = Samples.from_values(samples.values[: len(call.pixels)], samples.layout)
        return call, samples, at

    def _check_given(self, given: frozenset[str]) -> None:
        """Raise InputError unless the samples have the same channels as the first ones."""
        if self._given is None:
            self._given = given
        for name in sorted(self._given ^ given):
            every, got = ("every", "none") if name in self._given else ("no", "some")
            raise InputError(f"{name}: expected it from {every} call of the tracer, as in the first, got {got}")

    def turn_to(self, tracer: Tracer | AsyncTracer) -> None:
        """Call another tracer from now on, with the same sizes and limits.

        Waiting calls are cancelled. Running calls count towards `in_flight` until they end; their samples are dropped.
        """
        for call in self.under_way:
            if call.future is not None:
                call.future.cancel()
                if not call.future.cancelled():
                    self._dropped.add(call)
        self.under_way = []
        self.tracer = tracer

    def close(self) -> None:
        """Cancel the waiting calls and wait for the running ones, until no call is in flight."""
        self.turn_to(self.tracer)
        while self._dropped:
            self.take()


def _future(returned: Any) -> SamplesFuture | None:
    """Return the returned value if it is a future, otherwise None."""
    if isinstance(returned, Samples):
        return None
    is_future = all(hasattr(returned, name) for name in ("add_done_callback", "result", "cancel", "cancelled"))
    if hasattr(returned, "__await__") and (not is_future or hasattr(returned, "get_loop")):
        # An asyncio loop may run in this very thread, where waiting would block it forever.
        if hasattr(returned, "close"):
            returned.close()  # a coroutine that never starts would warn
        raise InputTypeError(
            f"tracer: expected it to return bobrossnet.Samples or a concurrent future, got {type(returned).__name__}; "
            "asyncio.run_coroutine_threadsafe returns such a future"
        )
    return returned if is_future else None
