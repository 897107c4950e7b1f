"""One picture as it converges: traced piece by piece, and completed for each frame."""

from __future__ import annotations

import time
from math import inf
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bobrossnet.completion.complete import complete
from bobrossnet.completion.display import displayed
from bobrossnet.completion.guided import complete_guided, completed_gray
from bobrossnet.completion.uncertainty import mean_error
from bobrossnet.frames.calls import Calls
from bobrossnet.frames.frame import Frame, enlarged
from bobrossnet.frames.planner import Planner
from bobrossnet.picture.channels import GIVEN, Layout
from bobrossnet.picture.gbuffer import GBuffer, untraced_planes
from bobrossnet.picture.guides import Guides
from bobrossnet.picture.light_shown import shown_to_orders
from bobrossnet.picture.order import Size, pixel_order
from bobrossnet.picture.samples import Samples, averaged, scatter
from bobrossnet.picture.sequence import PixelSequence, with_guesses
from bobrossnet.tracing.trace import BATCH, SceneTracer

AHEAD = (32, 128, 1024)
"""Pixels of the core's calls before the first frame. The first call is not timed: it fills caches."""


COMPLETING = 0.04
"""Share of the time that completing takes where nobody asks for frames of a certain length. A tracer of 17 us a pixel
takes 11 % more processor time at 640x480 with 0.06, 9 % with 0.045 and 7 % with 0.03, in 40, 31 and 19 frames."""


class Sequence(Protocol):
    """The order of the pixels."""

    @property
    def looks(self) -> bool:
        """As `PixelSequence.looks`."""

    @property
    def in_first_round(self) -> bool:
        """As `PixelSequence.in_first_round`."""

    def next(self, count: int, planes: NDArray[np.float32], layout: Layout) -> NDArray[np.int32]:
        """As `PixelSequence.next`."""


class PartialPicture:
    """The traced pixels of one camera, and the calls that trace the others.

    Parameters
    ----------
    calls : Calls
        Calls of this camera's tracer.
    size : (height, width)
    layout : Layout, optional
        Channels of the picture; by default the channels of its first samples.
    sequence : Sequence
    planner : Planner
        Chooses the network and the size of calls, and measures their cost.
    mode : str
        The planner's mode.
    turns : bool
        Whether to switch to the order `SQUARES` after the first round, if the planner predicts a lower error.
    expected : (C, H, W) float32 of the layout, optional
        Reprojected samples, shown at untraced pixels with mask 1. Traced samples overwrite them.
    guides : Guides, optional
        First surfaces of all pixels; the picture is then completed along them.
    enlarged_to : (height, width), optional
        Size of the frames' images, larger than the picture.
    is_patient : bool
        Whether frames after the first trace for longer than their budget, so that completing takes `COMPLETING` of the
        time of calls that wait for it.
    """

    def __init__(
        self,
        calls: Calls,
        size: Size,
        layout: Layout | None,
        sequence: Sequence,
        planner: Planner,
        mode: str,
        *,
        turns: bool = False,
        expected: NDArray[np.float32] | None = None,
        guides: Guides | None = None,
        enlarged_to: Size | None = None,
        is_patient: bool = False,
    ) -> None:
        self.calls, self.sequence, self.planner, self.mode = calls, sequence, planner, mode
        self._turns, self._is_patient = turns, is_patient
        self._completion = ""  # name of the network for this frame
        self.expected = expected
        self.guides = guides
        self.layout, self._by_samples = layout or GIVEN, layout is None
        self.planes = untraced_planes(size, self.layout)
        self.size, self._enlarged_to = size, enlarged_to
        self.total = size[0] * size[1]
        self._is_shared = False  # whether a frame holds the planes too
        self.traced = 0
        self._asked_for = 0  # pixels traced or in flight
        self._chosen = np.empty((0, 2), np.int32)  # the next pixels
        self._retraces = False  # for less noise, once all pixels are traced
        self._budget: float | None = None  # seconds for a frame
        self._passes: NDArray[np.int32] | None = None  # passes of each pixel, once they differ
        self.finished = False
        # Values of the core's tracer are display-referred, and its calls have any size.
        self.is_display_referred = isinstance(calls.tracer, SceneTracer)
        self.sizes = None if self.is_display_referred else self.calls.sizes

    @property
    def _known(self) -> float:
        """Share of the pixels that are traced or expected."""
        return self.traced / self.total if self.expected is None else float(self.expected[0].mean())

    @property
    def _left(self) -> int:
        return self.total - self._asked_for

    @property
    def _open(self) -> int:
        """Number of pixels that may be requested: the untraced ones; then, to reduce noise, all but those in flight."""
        if self._left or not (self._retraces and "variance" in self.layout.places):
            return self._left
        return self.total - sum(len(call.pixels) for call in self.calls.under_way)

    def _trace(self, count: int) -> int:
        """Call the tracer once with at most `count` pixels and wait; return their number."""
        while not self.calls.has_room:  # a call for an earlier camera is still running
            self._take()
        self._begin(count)
        return self._take()

    def _own_planes(self) -> None:
        """Copy the planes if a frame holds them."""
        if self._is_shared:
            self.planes, self._is_shared = self.planes.copy(), False

    def _begin(self, count: int) -> bool:
        """Call the tracer with at most `count` pixels; return whether the call is still running."""
        began = time.perf_counter()
        is_first = self._left > 0
        if is_first:
            pixels = self._next(min(count, self._left))
            self._asked_for += len(pixels)
        else:
            pixels = self._noisiest(min(count, self._open))
        return self.calls.begin(pixels, is_first, began)

    def take_returned(self) -> None:
        """Take the samples of all calls that have returned."""
        while self._take(0):
            pass

    def _take(self, timeout: float | None = None) -> int:
        """Take the samples of one call; return their number, 0 after a timeout or for a dropped call."""
        taken = self.calls.take(timeout)
        if taken is None:
            return 0
        taking = time.perf_counter()
        call, samples, came = taken
        if self._by_samples and self.traced == 0 and samples.layout != self.layout:
            self.layout = samples.layout
            self.planes = untraced_planes(self.size, self.layout)
        if call.is_first:
            self.traced += len(call.pixels)
        else:
            samples = self._averaged(samples, call.pixels)
        self._own_planes()  # calls also return between frames
        scatter(samples, call.pixels, self.planes, self.layout)
        if self.expected is not None:
            scatter(samples, call.pixels, self.expected, self.layout)
        if self.calls.in_flight == 1:
            seconds = came - call.began + time.perf_counter() - taking
            self.planner.core.traced(self.mode, call.asked, seconds, self.sequence.in_first_round)
        return len(call.pixels)

    def _next(self, count: int) -> NDArray[np.int32]:
        """Return at most `count` pixels of the sequence.

        Several calls share the rest of a round evenly, so they return at about the same time and the next round has
        all samples.
        """
        calls = self.calls
        if not len(self._chosen):
            self._turn_where_fast()
            shown = self._displayed()
            together = count if calls.in_flight == 1 else min(BATCH, self._left)
            if self.expected is not None:  # rounds of refreshing have any length
                together = min(count * calls.in_flight, self._left)
            self._chosen = self.sequence.next(together, shown.planes, shown.layout)
        if calls.in_flight > 1 and calls.sizes.batch is None:
            share = max(-(-len(self._chosen) // calls.in_flight), calls.turnover.worthwhile())
            count = self._call_size(min(count, share), at_least=True)
        pixels, self._chosen = self._chosen[:count], self._chosen[count:]
        return pixels

    def _turn_where_fast(self) -> None:
        """Switch to squares after the first round, if the planner predicts a lower error."""
        sequence = self.sequence
        if not (self._turns and sequence.in_first_round and sequence.looks):  # only at the end of the round
            return
        if self._budget is None or self.calls.in_flight > 1:
            return
        assert isinstance(sequence, PixelSequence)
        self._turns = False
        if self.planner.core.plan(self._budget, inf) != "adaptive":
            sequence.turn_to_squares(self.planes[0])
            self.mode = "squares"

    def _noisiest(self, count: int) -> NDArray[np.int32]:
        """Return the pixels of largest variance, (count, 2)."""
        variance = self.planes[self.layout.places["variance"]].ravel()
        if self.calls.under_way:
            rows, columns = self._under_way().T
            variance = variance.copy()
            variance[rows * self.planes.shape[2] + columns] = -1
        chosen = np.argpartition(variance, -count)[-count:]
        return np.stack(np.unravel_index(chosen, self.planes.shape[1:]), axis=-1).astype(np.int32)

    def _averaged(self, samples: Samples, pixels: NDArray[np.int32]) -> Samples:
        """Return running means: the earlier values of the pixels, with one more sample each."""
        row, column = pixels.T
        if self._passes is None:
            self._passes = np.ones(self.planes.shape[1:], np.int32)
        means = averaged(samples, pixels, self.planes, self.layout, self._passes[row, column])
        self._passes[row, column] += 1
        return means

    def _displayed(self) -> GBuffer:
        """Return the traced samples as pixel orders see them."""
        traced = GBuffer.from_stack(self.planes.view(), self.layout, self.guides, self.is_display_referred)
        if not self.sequence.looks:
            return traced
        shown = displayed(traced) if self.guides is None else shown_to_orders(traced)
        if not self.calls.under_way:
            return shown
        return GBuffer.from_stack(with_guesses(shown.planes, self._under_way()), shown.layout)

    def _under_way(self) -> NDArray[np.int32]:
        """Return the pixels of all calls in flight, (n, 2)."""
        return np.concatenate([call.pixels for call in self.calls.under_way])

    def trace_ahead(self) -> None:
        """Measure the core's cost per ray before the first frame: the first rays of a process are far slower."""
        if not isinstance(self.calls.tracer, SceneTracer):
            return
        for count in AHEAD:
            pixels = pixel_order(self.calls.tracer.size, count=min(count, self.total))
            start = time.perf_counter()
            self.calls.tracer(pixels)
            if count > AHEAD[0]:
                self.planner.core.traced(self.mode, len(pixels), time.perf_counter() - start, True)

    def warm_up(self, until: float = 0) -> None:
        """Complete the picture before the first frame: the first run also allocates memory."""
        for completion in self.planner.networks:
            self._completion = completion
            for _ in range(3):
                self._completed(0, until)
        self._is_shared = False

    def frame(self, start: float, count: int | None, budget: float, until: float = 0) -> Frame:
        """Trace on, and complete the picture.

        Parameters
        ----------
        start : float
            Time of `time.perf_counter` at the frame's start.
        count : int or None
            Number of pixels to trace; None for as many as the budget allows.
        budget : float
            Seconds for the frame, if there is no count.
        until : float
            The picture is `finished` when all pixels are traced or the predicted error is at most this.
        """
        self._own_planes()
        self._retraces = until > 0
        self._budget = budget if count is None else None
        known, core = self._known, self.planner.core
        if count is None:
            self._completion = core.completion(self.mode, known, budget)
            if self._is_patient and self.traced and self.calls.in_flight == 1:
                budget = max(budget, core.for_completing(self._completion) / COMPLETING)
        else:
            self._completion = core.completion(self.mode, min(1, known + count / self.total), inf)
        done = 0
        if self.calls.in_flight == 1:
            done = self._trace_for(start, budget) if count is None else self._trace_share(count)
        if self.calls.in_flight > 1:
            self._gather(start, count, budget, done)
        return self._completed(start, until)

    def _trace_share(self, count: int) -> int:
        """Trace `count` pixels, or all remaining ones, one call after the other."""
        done = 0
        while done < count and self._open and self.calls.in_flight == 1:
            done += self._trace(self.calls.sizes.batch or min(count - done, self._open))
        return done

    def _deadline(self, start: float, budget: float) -> float:
        """Return the time when tracing must stop, to leave time for completing."""
        return start + self.planner.core.for_tracing(self.mode, self._completion, budget)

    def _trace_for(self, start: float, budget: float) -> int:
        """Trace one call after the other, until just before the picture must be completed."""
        deadline, core = self._deadline(start, budget), self.planner.core
        done = 0
        while self._open and self.calls.in_flight == 1:
            called = time.perf_counter()
            remaining = deadline - called
            last_call = remaining < 0.15 * budget
            wanted = self._call_size(int(core.pixels_in(self.mode, remaining if last_call else remaining / 2)))
            if wanted == 0:
                if done:
                    break
                wanted = self._call_size(int(core.worthwhile(self.mode)), at_least=True)
            count = self._trace(wanted)
            done += count
            if last_call and count == wanted:
                break
        return done

    def _gather(self, start: float, count: int | None, budget: float, done: int) -> None:
        """Take samples of several calls, until `count` pixels returned or the picture must be completed.

        The maximum number of calls stays in flight, also at the end.
        """
        deadline = self._deadline(start, budget)
        goes_on = True  # false for calls that return samples directly
        while True:
            while came := self._take(0):  # first, so the next pixels depend on all samples
                done += came
            if done >= count if count is not None else done > 0 and time.perf_counter() >= deadline:
                break
            if self._open and self.calls.has_room:
                goes_on = self._begin(self._part_size(count, budget))
            elif self._open or self.calls.under_way:
                done += self._take(deadline - time.perf_counter() if count is None and done else None)
            else:
                return
        while goes_on and self._open and self.calls.has_room:
            goes_on = self._begin(self._part_size(count, budget))

    def _part_size(self, count: int | None, budget: float) -> int:
        """Return the maximum size of one of several calls, for a frame of `count` pixels or `budget` seconds."""
        if self.calls.sizes.batch is not None:
            return self.calls.sizes.batch
        if count is not None:
            return -(-count // self.calls.in_flight)
        # It returns within half a frame; a frame takes at least as long as completing.
        seconds = max(budget, self.planner.core.for_completing(self._completion))
        return self.calls.turnover.pixels_in(seconds / 2, self.calls.in_flight)

    def _call_size(self, count: int, at_least: bool = False) -> int:
        """Return the size of a call with time for `count` pixels: at most `count`, unless `at_least` forces a call."""
        return min(self._open, count if self.sizes is None else self.sizes.within(count, at_least))

    def _completed(self, start: float, until: float) -> Frame:
        traced = time.perf_counter()
        gbuffer, self._is_shared = self._gbuffer(self.planes.view()), True
        shown = gbuffer if self.expected is None else self._gbuffer(self.expected.copy())
        is_guided, network = self.guides is not None, self.planner.networks[self._completion]
        color = complete_guided(shown, "color") if is_guided and "color" in self.layout.places else None
        if color is not None:
            image = completed_gray(shown, color)
        else:
            image = complete_guided(shown, "gray") if is_guided else complete(shown, model=network)
        share = self.traced / self.total
        if self._enlarged_to is not None:
            image = enlarged(image, self._enlarged_to)
            share *= self.total / image.size
        is_all = self._open == 0 and not self.calls.under_way
        self.finished = is_all or (until > 0 and mean_error(gbuffer, network) <= until)
        now = time.perf_counter()
        if not is_all:
            self.planner.core.completed(self._completion, self.total, now - traced)
        return Frame(image, gbuffer, share, now - start, network, shown, color)

    def _gbuffer(self, planes: NDArray[np.float32]) -> GBuffer:
        return GBuffer.from_stack(planes, self.layout, self.guides, self.is_display_referred)
