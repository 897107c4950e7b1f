"""Frames of a moving camera, under the headlight or by a user's tracer: samples of earlier frames are reprojected."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from math import inf
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.frames.calls import AsyncTracer, Calls, SamplesFuture
from bobrossnet.frames.frame import Frame, smaller
from bobrossnet.frames.partial_picture import PartialPicture
from bobrossnet.frames.planner import ORDER_OF, Planner
from bobrossnet.picture.camera import Camera
from bobrossnet.picture.channels import Layout
from bobrossnet.picture.gbuffer import untraced_planes
from bobrossnet.picture.order import Size
from bobrossnet.picture.samples import Samples
from bobrossnet.picture.sequence import PixelSequence
from bobrossnet.support.errors import InputError
from bobrossnet.tracing.scene import Scene
from bobrossnet.tracing.trace import SceneTracer, Tracer

CameraTracer: TypeAlias = Callable[[Camera, NDArray[np.int32]], Samples | SamplesFuture]
"""Maps a camera and pixels, (n, 2) int32 rows and columns, to a sample per pixel centre, or a future of samples."""

RESHADED = Layout(_core.remembered_layout(False).names)
"""Channels kept of scenes of the core; gray is recomputed from them for any camera."""

RESHADED_COLORED = Layout(_core.remembered_layout(True).names)
"""The same for scenes with colours."""


class TracedFrames:
    """The frames of a scene, or of a user's tracer, from a first camera on."""

    def __init__(self, source: Scene | CameraTracer, size: Size, camera: Camera, planner: Planner, seed: int) -> None:
        self._size, self.planner, self._seed = size, planner, seed
        self._scene = source if isinstance(source, Scene) else None
        self._tracer = None if isinstance(source, Scene) else source
        self._layout: Layout | None = None  # for a user's tracer: known after its first call
        if self._scene is not None:
            self._layout = RESHADED_COLORED if self._scene.is_colored else RESHADED
        self._history: _core.History | None = None
        self._order = _core.RefreshOrder(*size)
        self._moves = 0
        self._scale = 1.0  # divisor of the picture's size
        self._seen = self._seen_by(camera, size)
        self._calls = Calls(self._seen.tracer if self._tracer is None else self._tracer)  # type: ignore[arg-type]
        self.picture = self._new_picture("adaptive")
        """The picture under the last camera."""
        self.picture.trace_ahead()
        self.picture.warm_up()

    def frame(self, start: float, camera: Camera | None, budget: float, count: int | None) -> Frame:
        """Trace `count` pixels, or stop in time to complete the picture within `budget` seconds."""
        if camera is not None and camera != self._seen.camera:
            self._move(camera, count, budget)
        elif self._scale > 1:
            self._begin(self._seen.camera, 1.0, count, budget, inf)
        return self.picture.frame(start, count, budget)

    def forget(self) -> None:
        """Discard all samples."""
        self._resize(1.0)
        self._seen = self._seen_by(self._seen.camera, self._size)
        self.picture = self._new_picture("adaptive")

    def close(self) -> None:
        """Cancel waiting calls of the tracer, wait for running ones, and discard all samples."""
        self.forget()
        self._calls.close()

    def _move(self, camera: Camera, count: int | None, budget: float) -> None:
        """Begin the picture of another camera: if a scene's frames have a budget of time alone, in the size for it."""
        self.picture.take_returned()
        parallax = inf
        if self.picture.traced:
            parallax = _core.parallax(self._seen.in_core, self._in_core(camera), *self._size)
        scale = 1.0
        if count is None and self._scene is not None:
            scale = self.planner.core.scale(self._size[0] * self._size[1], self._scale, budget, parallax)
        self._begin(camera, scale, count, budget, parallax if scale == self._scale else inf)

    def _begin(self, camera: Camera, scale: float, count: int | None, budget: float, parallax: float) -> None:
        """Begin a picture, its height and width divided by `scale`."""
        self._layout = self.picture.layout
        if scale != self._scale:
            self._resize(scale)
        seen, planner = self._seen_by(camera, self._picture_size), self.planner.core
        mode = planner.plan(budget, parallax) if count is None else planner.plan_pixels(count, parallax)
        self._moves += 1
        reprojected = self._reprojected(seen) if mode == "reproject" else None
        self._seen = seen
        self.picture = reprojected or self._new_picture("adaptive" if mode == "reproject" else mode)

    @property
    def _picture_size(self) -> Size:
        return smaller(self._size, self._scale)

    def _resize(self, scale: float) -> None:
        """Set the size of the next pictures, and discard samples of earlier ones."""
        self._scale, self._history = scale, None
        height, width = self._picture_size
        self._order = _core.RefreshOrder(height, width)
        self.planner.core.resize(height * width)

    def _reprojected(self, seen: _Seen) -> PartialPicture | None:
        """Return a picture of reprojected samples, or None if there are too few."""
        start = time.perf_counter()
        layout, planes = self.picture.layout, self.picture.planes
        if self._tracer is not None:
            depth = planes[layout.places["depth"]]
            if depth.min() < 0 or depth.max() > 1:
                got = f"{depth.min():g}..{depth.max():g}"
                raise InputError(f"depth: expected 0..1 over the unit sphere where a camera moves, got {got}")
        if self._history is None:
            self._history = _core.History(layout.core, *self.picture.size)
        size = self.picture.size
        expected, off_center = untraced_planes(size, layout), np.empty(size, np.float32)
        self._history.add(self._seen.in_core, planes)
        scene = None if self._scene is None else self._scene.core
        if not self._history.expect(seen.in_core, expected, off_center, scene):
            return None
        self._order.begin((self._seed + self._moves) % 2**64)
        sequence = _Refreshing(self._order, expected, off_center)
        self._calls.turn_to(seen.tracer)
        self.planner.core.reprojected(expected[0].size, time.perf_counter() - start)
        return PartialPicture(
            self._calls,
            size,
            layout,
            sequence,
            self.planner,
            "reproject",
            expected=expected,
            enlarged_to=self._enlarged_to,
        )

    def _new_picture(self, mode: str) -> PartialPicture:
        """Return a picture without reprojected samples."""
        self._calls.turn_to(self._seen.tracer)
        size, turns = self._picture_size, mode == "adaptive"
        sequence = PixelSequence(size, ORDER_OF[mode], self._seed)
        return PartialPicture(
            self._calls, size, self._layout, sequence, self.planner, mode, turns=turns, enlarged_to=self._enlarged_to
        )

    @property
    def _enlarged_to(self) -> Size | None:
        return self._size if self._scale > 1 else None

    def _seen_by(self, camera: Camera, size: Size) -> _Seen:
        if self._scene is not None:
            return _Seen(camera, SceneTracer(self._scene, camera, size, self._layout), self._in_core(camera))
        assert self._tracer is not None
        return _Seen(camera, partial(self._tracer, camera), self._in_core(camera))

    def _in_core(self, camera: Camera) -> _core.Camera:
        if self._scene is None:
            return camera.core((0, 0, 0), 1)
        return camera.core(self._scene.center, self._scene.radius)


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
