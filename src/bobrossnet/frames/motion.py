"""Moving views: samples of earlier frames are reprojected."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from math import inf
from typing import NamedTuple, NoReturn, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.completion.network import NetworkLike
from bobrossnet.frames.calls import AsyncTracer, Calls, SamplesFuture
from bobrossnet.frames.frame import Frame, PartialPicture
from bobrossnet.frames.lit_motion import MovingLight
from bobrossnet.frames.planner import AUTO, ORDER_OF, Planner
from bobrossnet.measuring.picking import Pick, pick
from bobrossnet.picture.camera import Camera, CameraLike, as_camera, check_camera
from bobrossnet.picture.channels import Layout
from bobrossnet.picture.gbuffer import untraced_planes
from bobrossnet.picture.order import ADAPTIVE, SizeLike, check_order, check_size, pixel_count
from bobrossnet.picture.samples import Samples
from bobrossnet.picture.sequence import PixelSequence
from bobrossnet.support.errors import InputError, InputTypeError, check_number
from bobrossnet.support.threads import Turns
from bobrossnet.tracing.light import HEADLIGHT, LightLike, check_light
from bobrossnet.tracing.lit import shows_shadows
from bobrossnet.tracing.scene import SceneLike, as_scene
from bobrossnet.tracing.section import SectionLike
from bobrossnet.tracing.trace import SceneTracer, Tracer

CameraTracer: TypeAlias = Callable[[Camera, NDArray[np.int32]], Samples | SamplesFuture]
"""From a camera and pixels, (n, 2) int32 rows and columns, to one sample per pixel centre, or a future of samples."""

RESHADED = Layout(_core.remembered_layout(False).names)
"""Channels kept of scenes of the core; gray is recomputed from them for any camera."""

RESHADED_COLORED = Layout(_core.remembered_layout(True).names)
"""The same for scenes with colours."""


class View:
    """A scene seen by a camera that moves from frame to frame.

    Samples of earlier frames are reprojected: surfaces, which are shaded again, and background. They are shown at
    pixels that this camera has not traced. New rays go to disoccluded and doubtful pixels. A view at rest ends with
    every pixel exact, like `progressive`. Threads that share a view take turns.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these, optional
    size : (height, width) or "WIDTHxHEIGHT"
    tracer : callable, optional
        Instead of a scene: from a `Camera` and pixels, (n, 2) int32 rows and columns, read-only, to `Samples` of the
        same length. Their depth is over the unit sphere, which the camera sees. Their gray and colour are reprojected
        unchanged. It may return a future of its samples, and have the attributes `batch` and `in_flight`, as in
        `progressive`. When the camera moves, waiting calls are cancelled. Samples of running calls are dropped; these
        calls count as in flight until they end.
    model : str or path
        As in `progressive`.
    light, ground
        As in `render`. Light and its paths stay on their surfaces when the camera moves. "studio" is placed relative
        to the first frame's camera.
    section : Section, text such as "x=0", or up to six of them, optional
        As in `Scene`; by default the scene's.
    seed : int, 0..2**64 - 1

    Raises
    ------
    InputError
        If an argument is out of range.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> view = bob.View(bob.happy_tree(), size=(120, 160))
    >>> for azimuth in (30, 32, 34):
    ...     frame = view.frame(bob.Camera(azimuth=azimuth), fraction=0.05)
    >>> frame.image.shape, round(frame.fraction, 2)
    ((120, 160), 0.05)
    """

    def __init__(
        self,
        scene: SceneLike | None = None,
        *,
        size: SizeLike = (480, 640),
        tracer: CameraTracer | None = None,
        model: NetworkLike = AUTO,
        light: LightLike = None,
        ground: bool | None = None,
        section: SectionLike = None,
        seed: int = 0,
    ) -> None:
        if (scene is None) == (tracer is None):
            got = "both" if scene is not None else "neither"
            raise InputError(f"View: expected either a scene or a tracer, got {got}")
        if tracer is not None and not callable(tracer):
            raise InputTypeError(f"tracer: expected a callable, got {type(tracer).__name__}")
        self.size = check_size(size)
        if tracer is not None and section is not None:
            raise InputError("section: expected none with a tracer, which has its own scene")
        self._scene = None if scene is None else as_scene(scene, section)
        self._tracer = tracer
        self._layout: Layout | None = None  # for a user's tracer: known after its first call
        if self._scene is not None:
            self._layout = RESHADED_COLORED if self._scene.is_colored else RESHADED
        self._planner = Planner(self.size, model)
        check_order(ADAPTIVE, seed)
        self._seed = int(seed)
        self._lit = self._moving_light(light, ground)
        self._history: _core.History | None = None
        self._order = _core.RefreshOrder(*self.size)
        self._moves = 0
        self._camera = as_camera(None, self._scene)
        self._seen = self._seen_by(self._camera)
        self._calls = Calls(self._seen.tracer if tracer is None else tracer)  # type: ignore[arg-type]
        self._picture = self._unknown("adaptive")
        if self._lit is None:
            self._picture.trace_ahead()
            self._picture.warm_up()
        self._turns = Turns("View")

    def frame(
        self, camera: CameraLike | None = None, *, ms: float | None = None, fraction: float | None = None
    ) -> Frame:
        """Trace some pixels and complete the picture.

        Parameters
        ----------
        camera : Camera, optional
            By default the previous frame's, at first the default camera of the scene.
        ms : float above 0, optional
            Time for the frame in milliseconds, as `frame_ms` of `progressive`; 33 if neither this nor `fraction` is
            given. If it suffices for a dense picture, samples are not reprojected. If rays are fast, the picture is
            refined in squares, row by row, and complete if there is time for all pixels.
        fraction : float in (0, 1], optional
            Share of the pixels that this frame traces.

        Returns
        -------
        Frame
            `gbuffer` and `fraction` include only pixels traced with this camera; `image` also shows reprojected
            samples. `error` is predicted from the former.

        Raises
        ------
        InputError
            If an argument is out of range, or the tracer returns anything but its samples. Exceptions of the tracer
            propagate, also from a future; the next frame then starts without samples.
        """
        if ms is not None and fraction is not None:
            raise InputError("frame: expected ms or fraction, got both")
        budget = check_number("ms", 33 if ms is None else ms, 0, above=True) / 1000
        count = None if fraction is None else pixel_count(fraction, self.size)
        camera = None if camera is None else check_camera(camera)
        with self._turns:
            start = time.perf_counter()
            self._camera = camera or self._camera
            try:
                if self._lit is not None:
                    return self._lit.frame(start, camera, budget, count)
                return self._frame(start, camera, budget, count)
            except BaseException:  # requested pixels never returned
                self._restart()
                raise

    def _frame(self, start: float, camera: Camera | None, budget: float, count: int | None) -> Frame:
        if camera is not None and camera != self._seen.camera:
            self._move(camera, count, budget)
        return self._picture.frame(start, count, budget)

    def pick(self, row: int, column: int, *, snap: float = 0) -> Pick | None:
        """Return the surface at a pixel of the last frame, or before one as the default camera sees it; None where
        there is none.

        Parameters
        ----------
        row, column : int
            Pixel, from the picture's top left.
        snap : float
            Pixels within which the point snaps to corners, edges and centers, as in `bobrossnet.pick`.
        """
        if self._scene is None:
            raise InputError("pick: expected a view of a scene, got one of a tracer, whose surfaces are not known")
        return pick(self._scene, row, column, self._camera, size=self.size, snap=snap)

    def forget(self) -> None:
        """Discard all samples: for tracers whose shapes or lights have changed."""
        with self._turns:
            self._restart()

    def close(self) -> None:
        """Cancel waiting calls of the tracer, wait for running ones, and discard all samples."""
        with self._turns:
            self._restart()
            self._calls.close()

    def __reduce__(self) -> NoReturn:
        raise InputTypeError(
            "View: expected to stay where it was made, as its tracer may be at work; make another of the same scene"
        )

    def _moving_light(self, light: LightLike, ground: bool | None) -> MovingLight | None:
        """Return the light of the scene, or None for the headlight."""
        if self._scene is None:
            if light is not None or ground is not None:
                raise InputError("light: expected none with a tracer, which has its own")
            return None
        chosen = check_light(self._scene.light if light is None else light)
        stands = shows_shadows(self._scene, chosen, ground)
        if chosen is None or chosen == HEADLIGHT:
            return None
        network = next(iter(self._planner.networks.values()))
        return MovingLight(self._scene, self.size, chosen, stands, self._seed, network)

    def _restart(self) -> None:
        if self._lit is not None:
            self._lit.forget()
        self._history = None
        self._picture = self._unknown("adaptive")

    def _move(self, camera: Camera, count: int | None, budget: float) -> None:
        self._picture.take_what_came()
        seen, planner = self._seen_by(camera), self._planner.core
        parallax = _core.parallax(self._seen.in_core, seen.in_core, *self.size) if self._picture.traced else inf
        mode = planner.plan(budget, parallax) if count is None else planner.plan_pixels(count, parallax)
        self._layout = self._picture.layout
        self._moves += 1
        expecting = self._expecting(seen) if mode == "reproject" else None
        self._seen = seen
        self._picture = expecting or self._unknown("adaptive" if mode == "reproject" else mode)

    def _expecting(self, seen: _Seen) -> PartialPicture | None:
        """Return a picture of reprojected samples, or None if there are too few."""
        start = time.perf_counter()
        layout, planes = self._picture.layout, self._picture.planes
        if self._tracer is not None:
            depth = planes[layout.places["depth"]]
            if depth.min() < 0 or depth.max() > 1:
                got = f"{depth.min():g}..{depth.max():g}"
                raise InputError(f"depth: expected 0..1 over the unit sphere where a camera moves, got {got}")
        if self._history is None:
            self._history = _core.History(layout.core, *self.size)
        expected, off_center = untraced_planes(self.size, layout), np.empty(self.size, np.float32)
        self._history.add(self._seen.in_core, planes)
        scene = None if self._scene is None else self._scene.core
        if not self._history.expect(seen.in_core, expected, off_center, scene):
            return None
        self._order.begin((self._seed + self._moves) % 2**64)
        sequence = _Refreshing(self._order, expected, off_center)
        self._calls.turn_to(seen.tracer)
        self._planner.core.reprojected(expected[0].size, time.perf_counter() - start)
        return PartialPicture(self._calls, self.size, layout, sequence, self._planner, "reproject", expected=expected)

    def _unknown(self, mode: str) -> PartialPicture:
        """Return a picture without reprojected samples."""
        self._calls.turn_to(self._seen.tracer)
        sequence = PixelSequence(self.size, ORDER_OF[mode], self._seed)
        return PartialPicture(
            self._calls, self.size, self._layout, sequence, self._planner, mode, turns=mode == "adaptive"
        )

    def _seen_by(self, camera: Camera) -> _Seen:
        if self._scene is not None:
            tracer = SceneTracer(self._scene, camera, self.size, self._layout)
            return _Seen(camera, tracer, tracer.camera_in_core)
        assert self._tracer is not None
        return _Seen(camera, partial(self._tracer, camera), camera.core((0, 0, 0), 1))


class _Seen(NamedTuple):
    """A camera and its tracer."""

    camera: Camera
    tracer: Tracer | AsyncTracer
    in_core: _core.Camera


class _Refreshing:
    """The `Sequence` of a picture of reprojected samples, (C, H, W), overwritten by traced ones."""

    looks = True
    in_first_round = False

    def __init__(
        self, order: _core.RefreshOrder, picture: NDArray[np.float32], off_center: NDArray[np.float32]
    ) -> None:
        self._order, self._picture, self._off_center = order, picture, off_center

    def next(self, count: int, planes: NDArray[np.float32], layout: Layout) -> NDArray[np.int32]:
        return self._order.next(layout.core, planes, self._picture, self._off_center, count)
