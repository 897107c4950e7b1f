"""Progressive pictures: complete from the first frame on, exact in the last."""

from __future__ import annotations

import time
from collections.abc import Iterator

from bobrossnet.completion.complete import GUIDED
from bobrossnet.completion.network import NetworkLike
from bobrossnet.frames.calls import AsyncTracer, Calls
from bobrossnet.frames.frame import Frame
from bobrossnet.frames.partial_picture import PartialPicture
from bobrossnet.frames.planner import Planner
from bobrossnet.frames.positions import Positions
from bobrossnet.picture.camera import CameraLike, as_camera
from bobrossnet.picture.guides import Guides, check_guides
from bobrossnet.picture.order import Size, SizeLike, check_size, pixel_count
from bobrossnet.picture.sequence import PixelSequence
from bobrossnet.support.errors import InputError, InputTypeError, check_number
from bobrossnet.tracing.light import LightLike
from bobrossnet.tracing.lit import lit_tracer
from bobrossnet.tracing.scene import SceneLike, as_scene
from bobrossnet.tracing.section import SectionLike
from bobrossnet.tracing.trace import SceneTracer, Tracer


def progressive(
    scene: SceneLike | None = None,
    camera: CameraLike | None = None,
    *,
    tracer: Tracer | AsyncTracer | None = None,
    size: SizeLike | None = None,
    frame_ms: float | None = None,
    fraction: float | None = None,
    first: float | None = None,
    until: float = 0,
    order: str = "default",
    seed: int = 0,
    samples: int = 1,
    model: NetworkLike = "default",
    light: LightLike = None,
    ground: bool | None = None,
    section: SectionLike = None,
) -> Iterator[Frame]:
    """Trace step by step, with a complete picture after each step, until every pixel is exact.

    Pass a scene, or your own tracer. The arguments are checked and one-off work (the scene's BVH, the network) is done
    before this returns.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these, optional
    camera : Camera, optional
        The view of the scene.
    tracer : callable, optional
        Used instead of a scene and camera. Maps pixels, (n, 2) int32 rows and columns, read-only, to `Samples` of the
        same length, or to a future of them, as in `concurrent.futures` and Dask. Optional attributes: `size`, the
        picture's size; `batch`, the fixed number of pixels of each call (the last pixel is repeated where fewer
        remain); `in_flight`, the maximum number of concurrent calls if it returns futures, by default the number of
        cores; and a method `guides()`, called once, which returns `Guides` of all pixels or a dict of the arguments
        of `Guides`: the picture is then completed along them. The guides of the core's `SceneTracer` cost a full
        trace and serve the model "guided" alone. Closing the iterator early cancels waiting calls and
        waits for running ones.
    size : (height, width) or "WIDTHxHEIGHT", optional
        By default the tracer's size, or (480, 640).
    frame_ms : float above 0, optional
        Time for each frame in milliseconds; the number of pixels adapts. 33 if both this and `fraction` are omitted;
        frames of your own tracer then become longer, so that completing adds less than a tenth to its time.
        Each frame completes its picture, traces for at least a quarter of the completion's time, and traces enough
        pixels to repay the fixed cost of a call. A smaller budget is overrun.
    fraction : float in (0, 1], optional
        Share of the image that each frame adds, instead of `frame_ms`. Concurrent calls that return together may
        add more.
    first : float in (0, 1], optional
        Share of the image that the first frame traces, whatever time it takes; with too few pixels there is little to
        see. With 1, the first frame has all pixels, ready for `adapters.oidn.denoise`.
    until : float, at least 0
        Stop at the first frame with an `error` of at most this value. If the samples have a variance, pixels are traced
        again after all have been traced, in decreasing order of variance, until then.
    order, seed
        Order in which pixels are traced, as in `trace`. Where `frame_ms` has time for many rays, "default" is
        "adaptive" in its first round only, and then subdivides squares with different pixels row by row, which is
        faster.
    samples : 1, 4, 9, 16, 25, 36, 49 or 64
        Samples of your own tracer in each pixel, on an n x n grid. Above 1, the tracer is asked for positions instead
        of pixels, (m, 2) float64 rows and columns, where integers are pixel centres. Light is averaged over each pixel;
        depth, normal, albedo and hit are those next to its centre. `batch` then counts positions. `render` antialiases
        scenes.
    model : str or path
        As in `complete`; or "auto", for each frame the default or the filling, whichever has less error in its time.
        Under another light than the headlight, pictures are completed along first hits instead.
    light, ground
        As in `render`. Each traced pixel takes 16 light paths; with `until`, pixels are traced again.
    section : Section, text such as "x=0", or up to six of them, optional
        As in `Scene`; by default the scene's.

    Yields
    ------
    Frame
        In the last frame every pixel is traced and the image is exactly the samples, unless `until` ends it early or
        the samples have a variance.

    Raises
    ------
    InputError
        If an argument is out of range, or the tracer returns samples that do not match the request. Exceptions of the
        tracer or of its futures are passed on.
    """
    if (scene is None) == (tracer is None):
        raise InputError(
            "progressive: expected either a scene or a tracer, got " + ("both" if scene is not None else "neither")
        )
    if tracer is not None:
        if camera is not None:
            raise InputError("camera: expected none with a tracer, which has its own")
        if not callable(tracer):
            raise InputTypeError(f"tracer: expected a callable, got {type(tracer).__name__}")
    positions = Positions(samples)
    if tracer is None and len(positions) > 1:
        raise InputError("samples: expected 1 with a scene, got more; render antialiases scenes")
    size = _size_of(tracer, size)
    guides, name = None, model if isinstance(model, str) else None
    lit = None
    if tracer is None:
        assert scene is not None
        scene = as_scene(scene, section)
        camera = as_camera(camera, scene)
        lit = lit_tracer(scene, camera, size, light, ground, seed=seed)
        tracer = lit or SceneTracer(scene, camera, size)
    elif light is not None or ground is not None:
        raise InputError("light: expected none with a tracer, which has its own")
    elif section is not None:
        raise InputError("section: expected none with a tracer, which has its own scene")
    follows = name == GUIDED or (name == "default" and not isinstance(tracer, SceneTracer))
    steps: Iterator[Guides] = iter(())
    if lit is not None:
        steps = lit.guides_in_steps()
        guides = next(steps)
    elif scene is None and follows:
        guides = check_guides(tracer.guides(), size) if hasattr(tracer, "guides") else None
    if frame_ms is not None and fraction is not None:
        raise InputError("progressive: expected frame_ms or fraction, got both")
    layout = tracer.layout if isinstance(tracer, SceneTracer) else None
    planner = Planner(size, "default" if name == GUIDED and guides is not None else model, order)
    count = None if fraction is None else pixel_count(fraction, size)
    at_first = count if first is None else pixel_count(first, size, "first")
    until = check_number("until", until, 0)
    if at_first == size[0] * size[1] or until > 0:  # the first picture may be the last
        guides = [guides, *steps][-1]
    sequence = PixelSequence(size, order, seed, guides)
    if at_first == size[0] * size[1]:  # no choice of pixels, and no second round
        sequence = PixelSequence(size, "lattice", seed)
    turns = order == "default" and guides is None and count is None
    picture = PartialPicture(
        Calls(tracer, positions if len(positions) > 1 else None),
        size,
        layout,
        sequence,
        planner,
        "adaptive",
        turns=turns,
        guides=guides,
        is_patient=frame_ms is None and scene is None,
    )
    budget = check_number("frame_ms", 33 if frame_ms is None else frame_ms, 0, above=True) / 1000
    if turns:
        picture.trace_ahead()
    if guides is None:  # else no network completes it
        picture.warm_up(until)
    return _frames(picture, at_first, count, budget, until, steps)


def _size_of(tracer: Tracer | AsyncTracer | None, size: SizeLike | None) -> Size:
    """Return the requested picture size, or the tracer's."""
    own = None if tracer is None else getattr(tracer, "size", None)
    if own is None:
        return check_size((480, 640) if size is None else size)
    own = check_size(own)
    if size is not None and check_size(size) != own:
        raise InputError(f"size: expected the tracer's own, {own}, or none, got {check_size(size)}")
    return own


def _frames(
    picture: PartialPicture,
    first: int | None,
    count: int | None,
    budget: float,
    until: float,
    guides: Iterator[Guides],
) -> Iterator[Frame]:
    """Yield frames, each with `count` more pixels or a budget in seconds; `guides` replace the picture's after the
    first."""
    try:
        yield picture.frame(time.perf_counter(), first, budget, until)
        picture.guides = next(guides, picture.guides)
        while not picture.finished:
            yield picture.frame(time.perf_counter(), count, budget, until)
    finally:
        picture.calls.close()
