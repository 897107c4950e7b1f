"""Frames of light whose camera moves: the core decides about all of it, and has no clock."""

from __future__ import annotations

import time

import numpy as np

from bobrossnet import _core
from bobrossnet.color import luminance
from bobrossnet.completion.guided import completed_gray
from bobrossnet.completion.network import Network
from bobrossnet.frames.frame import Frame, enlarged, smaller
from bobrossnet.picture.camera import Camera, as_camera
from bobrossnet.picture.channels import Layout
from bobrossnet.picture.gbuffer import GBuffer, untraced_planes
from bobrossnet.picture.guides import Edges, Guides
from bobrossnet.picture.order import Size
from bobrossnet.tracing.light import LightLike, lights_of
from bobrossnet.tracing.lit import first_surfaces, lights_in_core
from bobrossnet.tracing.scene import Scene

HELD = Layout(_core.MovingLight.layout.names)
"""The channels of samples of light."""


class LitFrames:
    """The frames of a scene with lights, which stay where the first camera has them."""

    def __init__(self, scene: Scene, size: Size, light: LightLike, ground: bool, seed: int, network: Network) -> None:
        self._scene, self._size, self._light, self._ground = scene, size, light, ground
        self._seed, self._network = seed, network
        self._pace = _core.LightPace()
        self._moving: _core.MovingLight | None = None
        self._camera: Camera | None = None
        self._guides: Guides

    def forget(self) -> None:
        """Discard all samples, and the lights' places."""
        self._moving = self._camera = None

    close = forget  # no call outlives its frame

    def frame(self, start: float, camera: Camera | None, budget: float, count: int | None) -> Frame:
        """Trace `count` pixels, or stop in time to complete the picture within `budget` seconds.

        A moving picture without a count is smaller if first hits and completing would take too long; it is enlarged."""
        moving = self._turned_to(camera, None if count is not None else budget)
        size = moving.size
        tracing = time.perf_counter()
        total = size[0] * size[1]
        traced = moving.trace_next(self._pace.pixels(total, budget - (tracing - start)) if count is None else count)
        completing = time.perf_counter()
        self._pace.traced(traced, completing - tracing)
        is_enlarged = size != self._size
        picture = np.empty((4, *size), np.float32)
        moving.complete(is_enlarged, picture)
        planes, mask = untraced_planes(size, HELD), np.empty((1, *size), np.float32)
        moving.write(planes)
        moving.write_mask(mask)
        shown, own = (GBuffer.from_stack(each, HELD, self._guides, False) for each in (planes, planes * mask))
        fraction = own.fraction
        if not moving.is_at_rest:
            self._pace.shown(total, tracing - start + time.perf_counter() - completing)
        color, alpha = np.moveaxis(picture[:3], 0, -1), picture[3]
        if is_enlarged:
            color, alpha = enlarged(color, self._size), enlarged(alpha, self._size)
            fraction *= total / (self._size[0] * self._size[1])
        image = luminance(color) if is_enlarged else completed_gray(shown, color)
        end = time.perf_counter()
        self._pace.completed(end - completing)
        return Frame(image, own, fraction, end - start, self._network, shown, color, alpha)

    def _turned_to(self, camera: Camera | None, budget: float | None) -> _core.MovingLight:
        """Return the light as a camera sees it; the camera rests if it is the last frame's, or None.

        While it moves, the picture's size depends on the budget in seconds, if there is one."""
        moving = self._moving
        if moving is None or camera not in (None, self._camera):
            camera = camera or as_camera(None, self._scene)
            if moving is None:
                lights = lights_in_core(self._scene, lights_of(self._light, camera) or [], self._ground)
                moving = self._moving = _core.MovingLight(self._scene.core, lights, self._seed)
            self._camera = camera
            scale = 1.0 if budget is None else self._pace.scale(self._size[0] * self._size[1], budget)
            self._move(moving, smaller(self._size, scale))
        elif moving.is_at_rest:
            return moving
        else:
            if moving.size != self._size:
                self._move(moving, self._size)
            moving.rest()
        planes, at_edges, hits = moving.first_hits()
        self._guides = first_surfaces(planes, Edges(at_edges, hits), self._ground)
        return moving

    def _move(self, moving: _core.MovingLight, size: Size) -> None:
        assert self._camera is not None
        moving.move(self._camera.core(self._scene.center, self._scene.radius), *size)
