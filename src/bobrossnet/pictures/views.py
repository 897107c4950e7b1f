"""Views of a scene with depth, normals, instances and camera matrices: data for learning and measuring."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import asin, degrees, pi, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.picture.camera import Camera, as_camera
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.order import Size, SizeLike, check_size
from bobrossnet.picture.pose import Pose, pose_of
from bobrossnet.pictures.background import Background
from bobrossnet.pictures.rendering import PATHS_OF_SAMPLE, check_picture, finished, light_to_be_seen
from bobrossnet.support.errors import InputError, InputTypeError, brief, check_choice, check_integer, each_of
from bobrossnet.tracing.light import HEADLIGHT, LightLike, check_light
from bobrossnet.tracing.lit import lit_tracer
from bobrossnet.tracing.pixels import tiled_pixels
from bobrossnet.tracing.scene import Scene, SceneLike, as_scene
from bobrossnet.tracing.trace import trace

CHANNELS = ("color", "depth", "normal", "instance")

FOV = 40.0
"""Degrees of the cameras that `views` places."""

MAX_VIEWS = 100_000


@dataclass(frozen=True, eq=False)
class PosedView:
    """One view of a scene. Channels that were not requested are None; pixels without a surface hold 0."""

    camera: Camera
    size: Size
    pose: Pose
    """Camera matrices: `pose.intrinsics`, `pose.world_to_camera` (OpenCV), `pose.camera_to_world` (OpenGL)."""
    color: NDArray[np.uint8] | None
    """(H, W, 4): sRGB with antialiased edges, and coverage, 0..255."""
    depth: NDArray[np.float32] | None
    """(H, W): distance along the camera's z axis at pixel centres, in the scene's units."""
    normal: NDArray[np.float32] | None
    """(H, W, 3): unit normals in the scene's coordinates, on the camera's side of the surface."""
    instance: NDArray[np.int32] | None
    """(H, W): index into `Scene.instances`; -1 without a surface."""
    mask: NDArray[np.bool_]
    """(H, W): whether the ray through the pixel's centre meets a surface."""

    def points(self) -> NDArray[np.float32]:
        """Return the surface points at all pixels, (H, W, 3) in the scene's coordinates; NaN without a surface.

        Raises
        ------
        InputError
            If the view has no depth.
        """
        if self.depth is None:
            raise InputError("points: expected a view with the channel depth, got one without")
        height, width = self.size
        x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        seen = np.stack([x, y, np.ones_like(x)], axis=-1) @ np.linalg.inv(self.pose.intrinsics).T
        depth = self.depth.astype(np.float64)
        if not self.pose.is_orthographic:
            seen *= depth[..., None]
        seen[..., 2] = depth
        rotation, translation = self.pose.world_to_camera[:3, :3], self.pose.world_to_camera[:3, 3]
        points: NDArray[np.float32] = ((seen - translation) @ rotation).astype(np.float32)
        points[~self.mask] = np.nan
        return points


def views(
    scene: SceneLike,
    cameras: int | Iterable[Camera | str] = 24,
    channels: Sequence[str] = CHANNELS,
    *,
    size: SizeLike = (480, 640),
    samples: int = 4,
    background: Background = None,
    light: LightLike = None,
    ground: bool | None = None,
) -> Iterator[PosedView]:
    """Render views of a scene with depth, normals, instances and camera matrices, one after the other.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these
    cameras : int, or iterable of Camera or names of views
        A number places perspective cameras evenly around the scene, the same ones each time.
    channels : sequence of "color", "depth", "normal", "instance"
    size, samples, background, light, ground
        As in `render`, for the colour.

    Returns
    -------
    iterator of PosedView

    Raises
    ------
    InputError
        If an argument is out of range, before the first view.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> for view in bob.views(bob.happy_tree(), cameras=2, size="160x120"):
    ...     view.color.shape, view.depth.shape, view.pose.intrinsics.shape
    ((120, 160, 4), (120, 160), (3, 3))
    ((120, 160, 4), (120, 160), (3, 3))
    """
    scene, size = as_scene(scene), check_size(size)
    check_picture(samples, background, size)
    light = check_light(light)
    chosen = check_channels(channels)
    if isinstance(cameras, int | np.integer) and not isinstance(cameras, bool):
        placed = around(int(cameras))
    elif isinstance(cameras, Camera | str):
        raise InputTypeError("cameras: expected a number or several cameras, got one; put it in a list")
    else:
        placed = [as_camera(each, scene) for each in each_of("cameras", cameras, "a number or several cameras")]

    def made() -> Iterator[PosedView]:
        for camera in placed:
            surfaces = trace(scene, camera, size=size, light=HEADLIGHT)
            color = None
            if "color" in chosen:
                lit = lit_tracer(scene, camera, size, light, ground, paths=PATHS_OF_SAMPLE * samples)
                gbuffer = surfaces if lit is None else light_to_be_seen(lit)
                look: dict[str, Any] = {"samples": samples, "background": background, "model": "default"}
                color = finished(gbuffer, scene, camera, **look).rgba
            yield _posed(scene, camera, chosen, surfaces, color)

    return made()


def check_channels(channels: Sequence[str]) -> tuple[str, ...]:
    """Return names of channels; raise InputError for unknown or repeated ones."""
    chosen = (channels,) if isinstance(channels, str) else tuple(each_of("channels", channels, "names of channels"))
    for name in chosen:
        check_choice("channels", name, CHANNELS)
    if not chosen or len(set(chosen)) < len(chosen):
        raise InputError(f"channels: expected some of {', '.join(CHANNELS)}, got {brief(channels, of_type=False)}")
    return chosen


def around(count: int) -> list[Camera]:
    """Return cameras spread evenly over the sphere around a scene, along a Fibonacci spiral."""
    count = check_integer("cameras", count, 1, MAX_VIEWS)
    turn = pi * (3 - sqrt(5))
    heights = [1 - (2 * i + 1) / count for i in range(count)]
    return [
        Camera(azimuth=degrees(i * turn) % 360, elevation=degrees(asin(height)), fov=FOV)
        for i, height in enumerate(heights)
    ]


def _posed(
    scene: Scene, camera: Camera, channels: tuple[str, ...], surfaces: GBuffer, color: NDArray[np.uint8] | None
) -> PosedView:
    """Return the channels of a view from its first surfaces."""
    mask = surfaces.alpha > 0
    size = (mask.shape[0], mask.shape[1])
    pose, core = pose_of(camera, scene.center, scene.radius, size), camera.core(scene.center, scene.radius)
    instance = None
    if "instance" in channels:
        instance = _instances(scene, core, size) if len(scene.instances) > 1 else np.zeros(size, np.int32)
        instance[~mask] = -1
    places = np.argwhere(mask).astype(np.float32, order="C")
    depth = normal = None
    if "depth" in channels:
        on_surface = core.points(*size, np.hstack([places, surfaces.depth[mask][:, None]]))
        forward, offset = pose.world_to_camera[2, :3], pose.world_to_camera[2, 3]
        depth = np.zeros(size, np.float32)
        depth[mask] = on_surface @ (scene.radius * forward) + (forward @ scene.center + offset)
    if "normal" in channels:
        seen = surfaces.normal[mask]
        z = np.sqrt(np.maximum(1 - (seen**2).sum(axis=1, keepdims=True), 0))
        normal = np.zeros((*size, 3), np.float32)
        normal[mask] = core.in_scene(*size, np.hstack([seen, z]), places)
    return PosedView(camera, size, pose, color, depth, normal, instance, mask)


def _instances(scene: Scene, core: _core.Camera, size: Size) -> NDArray[np.int32]:
    """Return the first instance at each pixel, (H, W), -1 where there is none."""
    pixels = tiled_pixels(size)
    which, origins, directions = core.rays(*size, pixels)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    found, primitive = np.empty(len(which), np.int32), np.empty(len(which), np.int32)
    t, u, v = np.empty(len(which), np.float32), np.empty(len(which)), np.empty(len(which))
    scene.core.closest_hits(origins, directions, t, found, primitive, u, v)
    instances = np.full(size, -1, np.int32)
    instances[tuple(pixels[which].T)] = found
    return instances
