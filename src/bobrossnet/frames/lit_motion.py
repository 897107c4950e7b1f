"""Light in pictures whose camera moves: paths outlive their frame on the surfaces that they lit."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.completion.guided import complete_guided, completed_gray
from bobrossnet.completion.network import Network
from bobrossnet.frames.frame import Frame
from bobrossnet.picture.camera import Camera, as_camera
from bobrossnet.picture.channels import Layout
from bobrossnet.picture.gbuffer import GBuffer, untraced_planes
from bobrossnet.picture.guides import Guides
from bobrossnet.picture.order import Size
from bobrossnet.tracing.light import LightLike, lights_of
from bobrossnet.tracing.lit import EDGE_RAYS, LitTracer
from bobrossnet.tracing.scene import Scene

HELD = Layout(_core.LightHistory.layout.names)
"""The channels of a history of light."""

MOVING_EDGE_RAYS = 2
"""Rays of first hits at edges, down and across a pixel, while the camera moves."""

LEAST = 0.005
"""Share of the pixels that a frame traces at least."""

PATHS = 16
"""Of a pixel, each time it is traced."""

NEWEST = 0.3
"""Weight of the last frame's times among those before."""


class MovingLight:
    """The light of a scene, frame by frame.

    Each frame finds the first surfaces at all pixels, reprojects earlier paths to them, traces new paths where they are
    missing, noisy or old, and completes the picture along the surfaces. The lights stay where the first camera
    has them.
    """

    def __init__(self, scene: Scene, size: Size, light: LightLike, ground: bool, seed: int, network: Network) -> None:
        self._scene, self.size, self._light, self._ground = scene, size, light, ground
        self._seed, self._network = seed, network
        self._moves = self._frames = 0
        self._is_coarse = False  # the first hits within pixels
        self._guides: Guides
        self._completing = self._pixel_seconds = 0.0
        self.forget()

    def forget(self) -> None:
        """Discard all samples."""
        self._history = _core.LightHistory(*self.size)
        self._camera: Camera | None = None
        self._lights: LightLike = None

    def frame(self, start: float, camera: Camera | None, budget: float, count: int | None) -> Frame:
        """Trace `count` pixels, or stop in time to complete the picture within `budget` seconds."""
        at_rest = self._camera is not None and camera in (None, self._camera)
        if not at_rest:
            self._move(camera or as_camera(None, self._scene))
        elif self._is_coarse:
            self._guides, self._is_coarse = self._tracer.guides(), False
        total = self.size[0] * self.size[1]
        if count is None:
            left = budget - self._completing - (time.perf_counter() - start)
            count = max(int(LEAST * total), int(left / self._pixel_seconds) if self._pixel_seconds else 0)
        tracing = time.perf_counter()
        pixels = self._history.next(min(count, total), (self._seed + self._frames) % 2**32, at_rest, *self._surfaces)
        self._frames += 1
        samples = self._tracer.into(self._history, pixels, PATHS, at_rest, self._surfaces)
        traced = time.perf_counter()
        if len(pixels):
            self._pixel_seconds = _blended(self._pixel_seconds, (traced - tracing) / len(pixels))
        frame = self._completed(start, pixels, None if at_rest else samples)
        self._completing = _blended(self._completing, time.perf_counter() - traced)
        return frame

    @property
    def _surfaces(self) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
        ground = self._guides.ground
        return self._guides.planes, None if ground is None else ground.planes

    def _move(self, camera: Camera) -> None:
        if self._lights is None:
            self._lights = lights_of(self._light, camera)
        self._moves += 1
        seed = (self._seed + self._moves) % 2**64
        self._tracer = LitTracer(self._scene, camera, self.size, self._lights, ground=self._ground, seed=seed)
        is_first = self._camera is None
        self._guides = self._tracer.guides(EDGE_RAYS if is_first else MOVING_EDGE_RAYS)
        self._is_coarse = not is_first
        self._camera = camera
        self._history.move(self._tracer.camera_in_core, *self._surfaces)
        self._planes = untraced_planes(self.size, HELD)
        self._frames = 0

    def _completed(self, start: float, pixels: NDArray[np.int32], samples: NDArray[np.float32] | None) -> Frame:
        """The frame; the samples of its pixels are the history's own where that has only this camera's."""
        planes = untraced_planes(self.size, HELD)
        self._history.write(*self._surfaces, planes)
        rows, columns = pixels.T
        traced = self._planes.copy()
        traced[:, rows, columns] = planes[:, rows, columns] if samples is None else samples.T
        traced[0, rows, columns] = 1
        self._planes = traced
        shown = GBuffer.from_stack(planes, HELD, self._guides, False)
        color = complete_guided(shown, "color")
        image = completed_gray(shown, color)
        gbuffer = GBuffer.from_stack(traced.view(), HELD, self._guides, False)
        return Frame(image, gbuffer, gbuffer.fraction, time.perf_counter() - start, self._network, shown, True, color)


def _blended(before: float, now: float) -> float:
    return now if before == 0 else before + NEWEST * (now - before)
