"""A picture that is complete from the first frame on and exact in the last."""

from __future__ import annotations

import time
from collections.abc import Iterator

from bobrossnet.completion.complete import GUIDED
from bobrossnet.completion.network import NetworkLike
from bobrossnet.frames.calls import AsyncTracer, Calls
from bobrossnet.frames.choice import choice_of
from bobrossnet.frames.frame import Frame, Pace, PartialPicture
from bobrossnet.picture.camera import Camera
from bobrossnet.picture.guides import check_guides
from bobrossnet.picture.order import Size, SizeLike, check_size, pixel_count
from bobrossnet.picture.sequence import PixelSequence
from bobrossnet.support.errors import InputError, InputTypeError, check_number
from bobrossnet.tracing.light import LightLike
from bobrossnet.tracing.lit import lit_tracer
from bobrossnet.tracing.scene import SceneLike
from bobrossnet.tracing.trace import SceneTracer, Tracer


def progressive(
    scene: SceneLike | None = None,
    camera: Camera | None = None,
    *,
    tracer: Tracer | AsyncTracer | None = None,
    size: SizeLike | None = None,
    frame_ms: float | None = None,
    fraction: float | None = None,
    first: float | None = None,
    until: float = 0,
    order: str = "default",
    seed: int = 0,
    model: NetworkLike = "default",
    light: LightLike = None,
    ground: bool | None = None,
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
        Instead of scene and camera: from pixels, (n, 2) int32 rows and columns, read-only, to `Samples` of the same
        length. It may have attributes: `size`, of its picture; `batch`, how many pixels each call is to have, the last
        of which repeats where fewer are left; and a method `guides()`, which returns `Guides` of all pixels, or a dict
        of its arguments: it is called once, and the picture is completed along them (those of the core's `SceneTracer`
        cost as much as all pixels, and are for the model "guided" alone). It may return a future of its samples
        instead, as `concurrent.futures` and Dask have them; then its attribute `in_flight` says how many calls may be
        under way at once, by default as many as this machine has cores. Where the iterator is closed before its end,
        calls that wait are cancelled, and those that run are waited for.
    size : (height, width) or "WIDTHxHEIGHT", optional
        By default the tracer's own, or (480, 640).
    frame_ms : float above 0, optional
        Time for each frame in milliseconds; the number of pixels adapts as it runs. 33 if neither this nor `fraction`
        is given. Each frame has to complete its picture, traces for at least a quarter of the time that takes, and
        traces at least as many pixels as are worth a call of the tracer; a budget below that is overrun.
    fraction : float in (0, 1], optional
        Share of the image that each frame adds, instead of `frame_ms`; or more, by what came of several calls.
    first : float in (0, 1], optional
        Share of the image that the first frame traces, whatever time it takes: before that there is little to see.
        With 1 it has all pixels, which `adapters.oidn.denoise` takes the noise out of.
    until : float, at least 0
        End with the first frame whose `error` is at most this. If a tracer's samples have a variance, pixels are traced
        again after the last one, those of the largest variance first, until it is.
    order, seed
        In which order the pixels are traced, as in `trace`; where `frame_ms` has time for many rays, "default" is
        "adaptive" in its first round alone, and then divides squares whose pixels differ, row by row, which is faster.
    model : str or path
        As in `complete`; or "auto", for each frame the cheapest that is as good: the default, and from 5 % of adaptive
        pixels on the filling. Light is completed along first hits instead.
    light, ground
        As in `render`. A pixel that is traced has 16 paths of light; with `until`, pixels are traced again.

    Yields
    ------
    Frame
        The last one has every pixel traced, and its image is exactly what was traced, unless `until` ends it before, or
        samples have a variance.

    Raises
    ------
    InputError
        If an argument is out of range, or the tracer does not return what it was asked for. What the tracer raises
        comes through, here or in a future.
    """
    if (scene is None) == (tracer is None):
        raise InputError(
            "progressive: expected either a scene or a tracer, got " + ("both" if scene is not None else "neither")
        )
    if tracer is not None:
        if camera is not None:
            raise InputError("camera: expected none beside a tracer, which has its own")
        if not callable(tracer):
            raise InputTypeError(f"tracer: expected a callable, got {type(tracer).__name__}")
    size = _size_of(tracer, size)
    guides, name = None, model if isinstance(model, str) else None
    lit = None
    if tracer is None:
        assert scene is not None
        camera = Camera() if camera is None else camera
        lit = lit_tracer(scene, camera, size, light, ground, seed=seed)
        tracer = lit or SceneTracer(scene, camera, size)
    elif light is not None or ground is not None:
        raise InputError("light: expected none beside a tracer, which has its own")
    follows = name == GUIDED or (name == "default" and not isinstance(tracer, SceneTracer))
    if lit is not None or (scene is None and follows):
        guides = check_guides(tracer.guides(), size) if hasattr(tracer, "guides") else None
    if frame_ms is not None and fraction is not None:
        raise InputError("progressive: expected frame_ms or fraction, got both")
    layout = tracer.layout if isinstance(tracer, SceneTracer) else None
    choice = choice_of("default" if name == GUIDED and guides is not None else model, order)
    count = None if fraction is None else pixel_count(fraction, size)
    at_first = count if first is None else pixel_count(first, size, "first")
    sequence = PixelSequence(size, order, seed, guides)
    if at_first == size[0] * size[1]:  # nothing to choose, and no round to wait for
        sequence = PixelSequence(size, "lattice", seed)
    pace = Pace()
    squares_pace = Pace(pace.completed) if order == "default" and guides is None else None
    picture = PartialPicture(Calls(tracer), size, layout, sequence, choice, pace, Pace(), squares_pace, guides=guides)
    until = check_number("until", until, 0)
    budget = check_number("frame_ms", 33 if frame_ms is None else frame_ms, 0, above=True) / 1000
    if squares_pace is not None and count is None:
        picture.trace_ahead()
    picture.warm_up(until)
    return _frames(picture, at_first, count, budget, until)


def _size_of(tracer: Tracer | AsyncTracer | None, size: SizeLike | None) -> Size:
    """The picture's size as it was asked for, or as the tracer has it."""
    own = None if tracer is None else getattr(tracer, "size", None)
    if own is None:
        return check_size((480, 640) if size is None else size)
    own = check_size(own)
    if size is not None and check_size(size) != own:
        raise InputError(f"size: expected the tracer's own, {own}, or none, got {check_size(size)}")
    return own


def _frames(
    picture: PartialPicture, first: int | None, count: int | None, budget: float, until: float
) -> Iterator[Frame]:
    """Frames of so many pixels each, or of so many seconds."""
    try:
        yield picture.frame(time.perf_counter(), first, budget, until)
        while not picture.finished:
            yield picture.frame(time.perf_counter(), count, budget, until)
    finally:
        picture.calls.close()
