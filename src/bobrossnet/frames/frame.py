"""One picture as it converges: traced piece by piece, and completed for each frame."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, field
from math import inf
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bobrossnet.completion.complete import complete, completed_color
from bobrossnet.completion.display import displayed
from bobrossnet.completion.guided import complete_guided, completed_gray, guided_alpha, smoothed
from bobrossnet.completion.network import Network
from bobrossnet.completion.uncertainty import mean_error
from bobrossnet.frames.calls import Calls
from bobrossnet.frames.planner import Planner
from bobrossnet.picture.channels import GIVEN, Layout
from bobrossnet.picture.gbuffer import GBuffer, untraced_planes
from bobrossnet.picture.guides import Guides
from bobrossnet.picture.light_shown import shown_to_orders
from bobrossnet.picture.order import Size, pixel_order
from bobrossnet.picture.samples import Samples, scatter
from bobrossnet.picture.sequence import PixelSequence, with_guesses
from bobrossnet.pictures.background import Background, picture_of
from bobrossnet.pictures.rendered import Picture
from bobrossnet.tracing.trace import BATCH, SceneTracer

AHEAD = (32, 128, 1024)
"""Pixels of the core's calls before the first frame. The first one says nothing: what it needs comes into memory."""


@dataclass(frozen=True, slots=True, repr=False)
class Frame:
    """One step of a converging picture. In a notebook it shows itself; `save` writes it."""

    image: NDArray[np.float32]
    """(H, W): traced pixels as traced, the others completed; in 0..1 unless more was traced."""
    gbuffer: GBuffer
    """Everything traced so far."""
    fraction: float
    """Share of the pixels traced so far, 1 in the last frame."""
    seconds: float
    """What this frame took to trace and complete."""
    network: Network = field(repr=False, compare=False)
    """What completed it."""
    shown: GBuffer = field(repr=False, compare=False)
    """What the image was completed from: everything traced so far, and what earlier cameras' samples let expect."""
    is_guided: bool = field(default=False, repr=False, compare=False)
    """Whether guides completed it, rather than the network."""
    guided_color: NDArray[np.float32] | None = field(default=None, repr=False, compare=False)
    """The color that guides completed along with the image."""

    @property
    def color(self) -> NDArray[np.float32]:
        """(H, W, 3), linear RGB in the image's range, completed along with the image. Each use computes it anew."""
        if self.is_guided:
            return complete_guided(self.shown, "color") if self.guided_color is None else self.guided_color.copy()
        return self.shown.color.copy() if self.shown.mask.all() else completed_color(self.shown, self.image)

    @property
    def alpha(self) -> NDArray[np.float32]:
        """(H, W), how much of each pixel is covered, completed; 1 where light comes from behind all surfaces. Each use
        computes it anew."""
        missed = (self.shown.mask > 0) & (self.shown.depth == 0)
        if (self.shown.gray[missed] > 0).any():
            return np.ones_like(self.image)
        if self.is_guided:
            return guided_alpha(self.shown)
        return complete(self.shown, self.network, channel="alpha")

    def picture(self, background: Background = None) -> Picture:
        """The frame as people see it, on a background as `render` takes it: the same look as the final picture's."""
        if self.is_guided and self.shown.guides is not None and self.shown.guides.edges is not None:
            return picture_of(*smoothed(self.shown, self.color), background)
        return picture_of(self.color, self.alpha, background)

    def save(self, path: str | os.PathLike[str], background: Background = None) -> None:
        """Write the frame's picture; the format follows the ending, as of `Picture.save`."""
        self.picture(background).save(path)

    def _repr_png_(self) -> bytes:
        return self.picture()._repr_png_()

    def __repr__(self) -> str:
        height, width = self.image.shape
        return f"Frame({height} x {width}, {100 * self.fraction:.4g} % traced, {1000 * self.seconds:.3g} ms)"

    @property
    def error(self) -> float:
        """The mean absolute error of the image that is expected, in gray; in about nine of ten pictures the true one is
        below it. 0 in the last frame. Each use predicts it anew, which takes as long as two completions."""
        return mean_error(self.gbuffer, self.network)


class Sequence(Protocol):
    """Which pixels are traced next."""

    @property
    def looks(self) -> bool:
        """As `PixelSequence.looks`."""

    @property
    def in_first_round(self) -> bool:
        """As `PixelSequence.in_first_round`."""

    def next(self, count: int, planes: NDArray[np.float32], layout: Layout) -> NDArray[np.int32]:
        """As `PixelSequence.next`."""


class PartialPicture:
    """What one camera sees so far, and the pixels still to come.

    Parameters
    ----------
    calls : Calls
        Of a tracer of this one camera.
    size : (height, width)
    layout : Layout, optional
        What it is to find; by default what its first samples have.
    sequence : Sequence
    planner : Planner
        Says what completes it and how large calls are, and learns what all costs.
    mode : str
        How its pixels are chosen, as the planner has it.
    turns : bool
        Whether it turns to the order `SQUARES` after its first round where the planner expects more of that.
    expected : (C, H, W) float32 of the layout, optional
        What to show where nothing was traced yet and its mask is 1. What is traced is written over it.
    guides : Guides, optional
        What is known of all pixels, along which the picture is completed instead.
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
    ) -> None:
        self.calls, self.sequence, self.planner, self.mode = calls, sequence, planner, mode
        self._turns = turns
        self._completion = ""  # what completes the frame
        self.expected = expected
        self.guides = guides
        self.layout, self._by_samples = layout or GIVEN, layout is None
        self.planes = untraced_planes(size, self.layout)
        self.total = size[0] * size[1]
        self._is_shared = False  # the planes, with a frame
        self.traced = 0
        self._asked_for = 0  # at least once: those that were traced, and those under way
        self._decided = np.empty((0, 2), np.int32)  # pixels that come next
        self._again = False
        self._budget: float | None = None  # of a frame in seconds
        self._passes: NDArray[np.int32] | None = None  # how often each pixel was traced, once that is not the same
        self.finished = False
        # The core's tracer finds what displays show, and takes any number of pixels.
        self.is_display_referred = isinstance(calls.tracer, SceneTracer)
        self.sizes = None if self.is_display_referred else self.calls.sizes

    @property
    def _known(self) -> float:
        """The share of the pixels that was traced, or is expected."""
        return self.traced / self.total if self.expected is None else float(self.expected[0].mean())

    @property
    def _left(self) -> int:
        return self.total - self._asked_for

    @property
    def _open(self) -> int:
        """How many pixels may be asked for: those that are left, and then, if noise is to fall, all of them again but
        those under way."""
        if self._left or not (self._again and "variance" in self.layout.places):
            return self._left
        return self.total - sum(len(call.pixels) for call in self.calls.under_way)

    def _trace(self, count: int) -> int:
        """Call the tracer once and wait for it; return how many pixels, at most so many, it had."""
        while not self.calls.has_room:  # a call for a camera before runs on
            self._take()
        self._begin(count)
        return self._take()

    def _own_planes(self) -> None:
        """What is traced is written to planes that no frame has."""
        if self._is_shared:
            self.planes, self._is_shared = self.planes.copy(), False

    def _begin(self, count: int) -> bool:
        """Call the tracer with so many pixels, or fewer where fewer are decided; return whether the call goes on."""
        began = time.perf_counter()
        is_first = self._left > 0
        if is_first:
            pixels = self._next(min(count, self._left))
            self._asked_for += len(pixels)
        else:
            pixels = self._noisiest(min(count, self._open))
        return self.calls.begin(pixels, is_first, began)

    def take_what_came(self) -> None:
        """Take what calls have found until now."""
        while self._take(0):
            pass

    def _take(self, timeout: float | None = None) -> int:
        """Take what came of a call; return how many pixels, 0 where nothing comes in so many seconds, or only what was
        dropped."""
        taken = self.calls.take(timeout)
        if taken is None:
            return 0
        taking = time.perf_counter()
        call, samples, came = taken
        if self._by_samples and self.traced == 0 and samples.layout != self.layout:
            self.layout = samples.layout
            self.planes = untraced_planes((self.planes.shape[1], self.planes.shape[2]), self.layout)
        if call.is_first:
            self.traced += len(call.pixels)
        else:
            samples = self._averaged(samples, call.pixels)
        self._own_planes()  # also between frames
        scatter(samples, call.pixels, self.planes, self.layout)
        if self.expected is not None:
            scatter(samples, call.pixels, self.expected, self.layout)
        if self.calls.in_flight == 1:
            seconds = came - call.began + time.perf_counter() - taking
            self.planner.core.traced(self.mode, call.asked, seconds, self.sequence.in_first_round)
        return len(call.pixels)

    def _next(self, count: int) -> NDArray[np.int32]:
        """The next pixels in the sequence, at most so many. Of several calls each has a share of what is left of a
        round, so that all end at about the same time: the next round is decided by what came until then."""
        calls = self.calls
        if not len(self._decided):
            self._turn_where_fast()
            shown = self._displayed()
            together = count if calls.in_flight == 1 else min(BATCH, self._left)
            if self.expected is not None:  # rounds are as long as one wishes
                together = min(count * calls.in_flight, self._left)
            self._decided = self.sequence.next(together, shown.planes, shown.layout)
        if calls.in_flight > 1 and calls.sizes.batch is None:
            share = max(-(-len(self._decided) // calls.in_flight), calls.turnover.worthwhile())
            count = self._call(min(count, share), at_least=True)
        pixels, self._decided = self._decided[:count], self._decided[count:]
        return pixels

    def _turn_where_fast(self) -> None:
        """Turn to the order of squares after the first round, if the planner expects more of that."""
        sequence = self.sequence
        if not (self._turns and sequence.in_first_round) or self._budget is None or self.calls.in_flight > 1:
            return
        assert isinstance(sequence, PixelSequence)
        self._turns = False
        if self.planner.core.plan(self._budget, inf) != "adaptive":
            sequence.turn_to_squares(self.planes[0])
            self.mode = "squares"

    def _noisiest(self, count: int) -> NDArray[np.int32]:
        """The pixels of the largest variance, (count, 2)."""
        variance = self.planes[self.layout.places["variance"]].ravel()
        if self.calls.under_way:
            rows, columns = self._under_way().T
            variance = variance.copy()
            variance[rows * self.planes.shape[2] + columns] = -1
        chosen = np.argpartition(variance, -count)[-count:]
        return np.stack(np.unravel_index(chosen, self.planes.shape[1:]), axis=-1).astype(np.int32)

    def _averaged(self, samples: Samples, pixels: NDArray[np.int32]) -> Samples:
        """The means of what was found at pixels before and of one more sample of each."""
        row, column = pixels.T
        if self._passes is None:
            self._passes = np.ones(self.planes.shape[1:], np.int32)
        passes = self._passes[row, column][:, None]
        values = samples.in_layout(self.layout)
        for name in ("gray", "color", "shadow", "variance"):
            if name in self.layout.places:
                before = self.planes[self.layout.places[name], row, column].T
                # Variances are of means: of the sum of independent ones, by its count squared.
                weights = (passes, 1) if name != "variance" else (passes**2 / (passes + 1), 1 / (passes + 1))
                place = self.layout.places[name]
                values[:, place] = (weights[0] * before + weights[1] * values[:, place]) / (passes + 1)
        self._passes[row, column] += 1
        return Samples.from_values(values, self.layout)

    def _displayed(self) -> GBuffer:
        """What was traced, as the orders of pixels are to look at it."""
        traced = GBuffer.from_stack(self.planes.view(), self.layout, self.guides, self.is_display_referred)
        if not self.sequence.looks:
            return traced
        shown = displayed(traced) if self.guides is None else shown_to_orders(traced)
        if not self.calls.under_way:
            return shown
        return GBuffer.from_stack(with_guesses(shown.planes, self._under_way()), shown.layout)

    def _under_way(self) -> NDArray[np.int32]:
        """The pixels of all calls that are under way, (n, 2)."""
        return np.concatenate([call.pixels for call in self.calls.under_way])

    def trace_ahead(self) -> None:
        """Learn what a first round takes the core before anyone waits: its first rays seem far slower than they are."""
        if not isinstance(self.calls.tracer, SceneTracer):
            return
        for count in AHEAD:
            pixels = pixel_order(self.calls.tracer.size, count=min(count, self.total))
            start = time.perf_counter()
            self.calls.tracer(pixels)
            if count > AHEAD[0]:
                self.planner.core.traced(self.mode, len(pixels), time.perf_counter() - start, True)

    def warm_up(self, until: float = 0) -> None:
        """Complete it before anyone waits: the first run also allocates memory."""
        for completion in self.planner.networks:
            self._completion = completion
            for _ in range(3):
                self._frame(0, until)
        self._is_shared = False

    def frame(self, start: float, count: int | None, budget: float, until: float = 0) -> Frame:
        """Trace on, and complete the picture.

        Parameters
        ----------
        start : float
            When the frame began, of `time.perf_counter`.
        count : int or None
            How many pixels to trace, or as many as there is time for.
        budget : float
            Seconds for the frame, where there is no count.
        until : float
            The picture is `finished` with all pixels, or where the expected error is at most this.
        """
        self._own_planes()
        self._again = until > 0
        self._budget = budget if count is None else None
        known, core = self._known, self.planner.core
        if count is None:
            self._completion = core.completion(self.mode, known, budget)
        else:
            self._completion = core.completion(self.mode, min(1, known + count / self.total), inf)
        done = 0
        if self.calls.in_flight == 1:
            done = self._trace_for(start, budget) if count is None else self._trace_share(count)
        if self.calls.in_flight > 1:
            self._gather(start, count, budget, done)
        return self._frame(start, until)

    def _trace_share(self, count: int) -> int:
        """Trace so many pixels, or all that are left, one call after the other."""
        done = 0
        while done < count and self._open and self.calls.in_flight == 1:
            done += self._trace(self.calls.sizes.batch or min(count - done, self._open))
        return done

    def _deadline(self, start: float, budget: float) -> float:
        """Until when a frame may trace, so that there is time to complete the picture."""
        return start + self.planner.core.for_tracing(self.mode, self._completion, budget)

    def _trace_for(self, start: float, budget: float) -> int:
        """Trace as many pixels as leave time to complete the picture, one call after the other."""
        deadline, core = self._deadline(start, budget), self.planner.core
        done = 0
        while self._open and self.calls.in_flight == 1:
            called = time.perf_counter()
            remaining = deadline - called
            last_call = remaining < 0.15 * budget
            wanted = self._call(int(core.pixels_in(self.mode, remaining if last_call else remaining / 2)))
            if wanted == 0:
                if done:
                    break
                wanted = self._call(int(core.worthwhile(self.mode)), at_least=True)
            count = self._trace(wanted)
            done += count
            if last_call and count == wanted:
                break
        return done

    def _gather(self, start: float, count: int | None, budget: float, done: int) -> None:
        """Take what comes of several calls, until so many pixels came, or until there is just time to complete the
        picture. As many calls as may be are under way all the time, and still are at the end."""
        deadline = self._deadline(start, budget)
        goes_on = True  # as calls do that have not returned samples at once
        while True:
            while came := self._take(0):  # first, so that the next pixels are chosen by all that is known
                done += came
            if done >= count if count is not None else done > 0 and time.perf_counter() >= deadline:
                break
            if self._open and self.calls.has_room:
                goes_on = self._begin(self._part(count, budget))
            elif self._open or self.calls.under_way:
                done += self._take(deadline - time.perf_counter() if count is None and done else None)
            else:
                return
        while goes_on and self._open and self.calls.has_room:
            goes_on = self._begin(self._part(count, budget))

    def _part(self, count: int | None, budget: float) -> int:
        """How many pixels one of several calls is to have at most, where a frame has so many, or so many seconds."""
        if self.calls.sizes.batch is not None:
            return self.calls.sizes.batch
        if count is not None:
            return -(-count // self.calls.in_flight)
        # It comes within half a frame; frames are never shorter than completing.
        seconds = max(budget, self.planner.core.for_completing(self._completion))
        return self.calls.turnover.pixels_in(seconds / 2, self.calls.in_flight)

    def _call(self, count: int, at_least: bool = False) -> int:
        """How many pixels a call is to have that has time for so many: as many or fewer, but a call's own number at
        least where there has to be one."""
        return min(self._open, count if self.sizes is None else self.sizes.within(count, at_least))

    def _frame(self, start: float, until: float) -> Frame:
        traced = time.perf_counter()
        gbuffer, self._is_shared = self._gbuffer(self.planes.view()), True
        shown = gbuffer if self.expected is None else self._gbuffer(self.expected.copy())
        is_guided, network = self.guides is not None, self.planner.networks[self._completion]
        color = complete_guided(shown, "color") if is_guided and "color" in self.layout.places else None
        if color is not None:
            image = completed_gray(shown, color)
        else:
            image = complete_guided(shown, "gray") if is_guided else complete(shown, model=network)
        is_all = self._open == 0 and not self.calls.under_way
        self.finished = is_all or (until > 0 and mean_error(gbuffer, network) <= until)
        now = time.perf_counter()
        if not is_all:
            self.planner.core.completed(self._completion, self.total, now - traced)
        return Frame(image, gbuffer, self.traced / self.total, now - start, network, shown, is_guided, color)

    def _gbuffer(self, planes: NDArray[np.float32]) -> GBuffer:
        return GBuffer.from_stack(planes, self.layout, self.guides, self.is_display_referred)
