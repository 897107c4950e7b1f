"""A picture that is complete from the first frame on and exact in the last."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bobrossnet.completion.network import Network, NetworkLike, complete, load_network
from bobrossnet.completion.uncertainty import mean_error
from bobrossnet.errors import InputError, InputTypeError, check_number
from bobrossnet.picture.camera import Camera
from bobrossnet.picture.channels import GIVEN, TRACED
from bobrossnet.picture.gbuffer import GBuffer, scatter, untraced_planes
from bobrossnet.picture.order import SizeLike, check_size, pixel_count
from bobrossnet.picture.sequence import PixelSequence
from bobrossnet.tracing.scene import SceneLike
from bobrossnet.tracing.trace import SceneTracer, Tracer, check_samples

MIN_TRACING = 0.25
"""Least time for tracing in a frame, as a share of the time for completing, so that every budget makes progress."""


@dataclass(frozen=True, slots=True)
class Frame:
    """One step of a converging picture."""

    image: NDArray[np.float32]
    """(H, W) in 0..1: traced pixels as traced, the others completed."""
    gbuffer: GBuffer
    """Everything traced so far."""
    fraction: float
    """Share of the pixels traced so far, 1 in the last frame."""
    seconds: float
    """What this frame took to trace and complete."""
    network: Network = field(repr=False, compare=False)
    """What completed it."""

    @property
    def error(self) -> float:
        """The mean absolute error of the image that is expected, in gray; in about nine of ten pictures the true one is
        below it. 0 in the last frame. Each use predicts it anew, which takes as long as two completions."""
        return mean_error(self.gbuffer, self.network)


def progressive(
    scene: SceneLike | None = None,
    camera: Camera | None = None,
    *,
    tracer: Tracer | None = None,
    size: SizeLike = (480, 640),
    frame_ms: float | None = None,
    fraction: float | None = None,
    until: float = 0,
    order: str = "default",
    seed: int = 0,
    model: NetworkLike = "default",
) -> Iterator[Frame]:
    """Trace step by step, with a complete picture after each step, until every pixel is exact.

    Pass a scene, or your own tracer. Arguments are checked, and one-off work (the scene's BVH, the network) is done,
    before this returns.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these, optional
    camera : Camera, optional
        How the scene is seen.
    tracer : callable, optional
        Instead of scene and camera: from pixels, (n, 2) int32 rows and columns, to `Samples` of the same length.
    size : (height, width) or "WIDTHxHEIGHT"
    frame_ms : float above 0, optional
        Time for each frame in milliseconds; the number of pixels adapts as it runs. 33 if neither this nor `fraction`
        is given. Each frame has to complete its picture, traces for at least a quarter of the time that takes, and
        traces at least as many pixels as are worth a call of the tracer; a budget below that is overrun.
    fraction : float in (0, 1], optional
        Share of the image that each frame adds, instead of `frame_ms`.
    until : float, at least 0
        End with the first frame whose `error` is at most this.
    order, seed
        In which order the pixels are traced, as in `trace`.
    model : str or path
        As in `complete`.

    Yields
    ------
    Frame
        The last one has every pixel traced, and its image is exactly what was traced, unless `until` ends it before.

    Raises
    ------
    InputError
        If an argument is out of range, or the tracer does not return what it was asked for.
    """
    size = check_size(size)
    if (scene is None) == (tracer is None):
        raise InputError(
            "progressive: expected either a scene or a tracer, got " + ("both" if scene is not None else "neither")
        )
    if tracer is None:
        assert scene is not None
        tracer = SceneTracer(scene, Camera() if camera is None else camera, size)
    elif camera is not None:
        raise InputError("camera: expected none beside a tracer, which has its own")
    elif not callable(tracer):
        raise InputTypeError(f"tracer: expected a callable, got {type(tracer).__name__}")
    if frame_ms is not None and fraction is not None:
        raise InputError("progressive: expected frame_ms or fraction, got both")
    picture = _Picture(tracer, PixelSequence(size, order, seed), load_network(model), check_number("until", until, 0))
    if fraction is not None:
        return _by_share(picture, pixel_count(fraction, size))
    return _by_time(picture, check_number("frame_ms", 33 if frame_ms is None else frame_ms, 0, above=True) / 1000)


class _Picture:
    """The picture so far, and the pixels still to come."""

    def __init__(self, tracer: Tracer, sequence: PixelSequence, network: Network, until: float) -> None:
        self.tracer, self.sequence, self.network, self.until = tracer, sequence, network, until
        self.layout = TRACED if isinstance(tracer, SceneTracer) else GIVEN
        self.planes = untraced_planes(sequence.size, self.layout)
        self.total = sequence.size[0] * sequence.size[1]
        self.traced = 0
        self.seconds_to_complete: list[float] = []  # of the last frames
        for _ in range(3):  # before anyone waits: the first run also allocates memory
            self.frame(0)
        self.finished = False

    @property
    def left(self) -> int:
        return self.total - self.traced

    def trace(self, count: int) -> int:
        """Call the tracer once, with as many pixels or as many as are decided; return how many those were."""
        pixels = self.sequence.next(min(count, self.left), self.planes, self.layout)
        scatter(check_samples(self.tracer(pixels), len(pixels)), pixels, self.planes, self.layout)
        self.traced += len(pixels)
        return len(pixels)

    def frame(self, start: float) -> Frame:
        traced = time.perf_counter()
        gbuffer = GBuffer.from_stack(self.planes.copy(), self.layout)
        image = complete(gbuffer, model=self.network)
        self.finished = self.left == 0 or (self.until > 0 and mean_error(gbuffer, self.network) <= self.until)
        now = time.perf_counter()
        self.seconds_to_complete = [*self.seconds_to_complete[-7:], now - traced]
        return Frame(image, gbuffer, self.traced / self.total, now - start, self.network)


def _by_share(picture: _Picture, count: int) -> Iterator[Frame]:
    while not picture.finished:
        start = time.perf_counter()
        until = min(picture.traced + count, picture.total)
        while picture.traced < until:
            picture.trace(until - picture.traced)
        yield picture.frame(start)


class _Pace:
    """How many pixels a call of the tracer can take in a given time, from what was measured.

    A call costs something, however few its pixels, and something for each: a line through the last calls, fitted with
    weights that fade. Within a frame each call is given half of the time that remains, so that an error of the
    estimate shrinks from call to call before it can overrun the frame, and so that the calls' sizes differ enough for
    the fit.
    """

    FIRST = 32  # pixels of the first call, when nothing is known: 1 ms of a tracer of 30,000 rays a second
    GROWTH = 8  # a call has at most this many times the pixels of the largest: small calls say little about a large one
    FADE = 0.8  # weight of the call before, against this one

    def __init__(self) -> None:
        self.sums = np.zeros(5)  # of 1, n, t, n * n and n * t
        self.largest = 0

    def measured(self, pixels: int, seconds: float) -> None:
        self.sums = self.FADE * self.sums + (1, pixels, seconds, pixels**2, pixels * seconds)
        self.largest = max(self.largest, pixels)

    def pixels_in(self, seconds: float) -> int:
        """How many pixels fit into a call of so many seconds; 0 if less than a call costs."""
        if not self.largest:
            return self.FIRST
        per_call, per_pixel = self._costs()
        return int(max(0, min((seconds - per_call) / per_pixel, self.GROWTH * self.largest)))

    def worthwhile(self) -> int:
        """How many pixels take as long as the call around them: with fewer, most of the time is lost."""
        per_call, per_pixel = self._costs()
        return int(max(1, min(per_call / per_pixel, self.GROWTH * self.largest)))

    def _costs(self) -> tuple[float, float]:
        """Seconds for a call and for each of its pixels."""
        weight, n, t, nn, nt = map(float, self.sums)
        spread = weight * nn - n * n
        per_pixel = (weight * nt - n * t) / spread if spread > 1e-6 * n * n else t / n
        per_pixel = max(per_pixel, 1e-10)
        per_call = (t - per_pixel * n) / weight
        return (per_call, per_pixel) if per_call >= 0 else (0.0, t / n)


def _by_time(picture: _Picture, budget: float) -> Iterator[Frame]:
    pace = _Pace()
    while not picture.finished:
        start = time.perf_counter()
        # The second longest of the last eight: one outlier does not make all frames short.
        to_complete = sorted(picture.seconds_to_complete)[-2]
        deadline = start + max(budget - to_complete, MIN_TRACING * to_complete)
        traced_before = picture.traced
        while picture.left:
            called = time.perf_counter()
            remaining = deadline - called
            last_call = remaining < 0.15 * budget
            wanted = min(picture.left, pace.pixels_in(remaining if last_call else remaining / 2))
            if wanted == 0:
                if picture.traced > traced_before:
                    break
                wanted = min(picture.left, pace.worthwhile())
            count = picture.trace(wanted)
            pace.measured(count, time.perf_counter() - called)
            if last_call and count == wanted:
                break
        yield picture.frame(start)
