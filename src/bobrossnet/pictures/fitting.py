"""Cameras fitted to a scene: the silhouette fills the picture."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.camera import Camera, CameraLike, orbiting
from bobrossnet.picture.channels import Layout
from bobrossnet.picture.order import SizeLike, check_size
from bobrossnet.shapes.affine import mapped
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.support.errors import check_number
from bobrossnet.tracing.light import LightLike
from bobrossnet.tracing.lit import shows_shadows
from bobrossnet.tracing.pixels import tiled_pixels
from bobrossnet.tracing.scene import Scene, SceneLike, as_scene
from bobrossnet.tracing.trace import SceneTracer

MARGIN, MARGIN_WITH_SHADOWS = 0.05, 0.13
"""Margin at each border, as a share of the picture; shadows extend beyond the silhouette."""

LOOKS = 2
"""Traced pictures for shapes other than meshes: one of the whole sphere, and one of the silhouette alone."""

SHORTER = 128
"""Pixels of these pictures along the shorter side."""

STEPS = 4
"""Iterations in perspective, where near points move more than far ones; each leaves a small part of the error."""

MAX_VERTICES = 4_000_000
"""Maximum number of projected vertices; scenes with more are traced as well."""


def margin_of(scene: Scene, light: LightLike, ground: bool | None) -> float:
    """Return the margin around a scene's silhouette in this light."""
    return MARGIN_WITH_SHADOWS if shows_shadows(scene, light, ground) else MARGIN


def fitted(
    scene: SceneLike, camera: CameraLike | None = None, *, size: SizeLike = (480, 640), margin: float = MARGIN
) -> Camera:
    """Return the camera with a zoom and pan that fit the silhouette to the picture.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these
    camera : Camera, optional
        An orbiting camera; its zoom and pan are ignored.
    size : (height, width), or "WIDTHxHEIGHT"
        Size of the picture.
    margin : float in 0..0.45
        Free margin at each border, as a share of the picture.

    Returns
    -------
    Camera
        Exact for meshes. In other shapes, details thinner than a hundredth of the picture may be missed; if no ray hits
        them, the zoom is 1.

    Raises
    ------
    InputError
        If an argument is out of range, or the camera has a position.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> flat = bob.Mesh([(0, 0, 0), (4, 0, 0), (0, 4, 0)], [(0, 1, 2)])
    >>> bob.fitted(flat, bob.Camera(azimuth=60, elevation=10)).zoom > 1
    True
    """
    scene = as_scene(scene)
    height, width = check_size(size)
    check_number("margin", margin, 0, 0.45)
    camera = replace(orbiting(camera, scene), zoom=1.0, pan=(0.0, 0.0))
    points, is_all = _vertices(scene)
    if not is_all:
        scale = SHORTER / min(height, width)
        looked = max(round(height * scale), 1), max(round(width * scale), 1)
        for _ in range(LOOKS):
            points = np.concatenate([points, _seen_points(scene, camera, looked)])
            camera = _around(points, scene, camera, looked, margin)
    return _around(points, scene, camera, (height, width), margin)


def _vertices(scene: Scene) -> tuple[NDArray[np.float32], bool]:
    """Return the vertices of meshes, in the unit sphere, and whether they cover the whole scene."""
    vertices = [np.empty((0, 3), np.float32)]
    left = MAX_VERTICES
    for instance in scene.instances:
        shape = instance.shape
        left -= len(shape.vertices) if isinstance(shape, Mesh) else left + 1
        if left < 0:
            return vertices[0], False
        assert isinstance(shape, Mesh)
        placed = mapped(instance.transform, shape.vertices)
        vertices.append(np.asarray((placed - scene.center) / scene.radius, np.float32))
    return np.concatenate(vertices), True


def _seen_points(scene: Scene, camera: Camera, size: tuple[int, int]) -> NDArray[np.float32]:
    """Return the hit points of a picture's rays, in the unit sphere."""
    pixels = tiled_pixels(size)
    values = SceneTracer(scene, camera, size, Layout("mask,depth"))(pixels).values
    hit = values[:, 0] > 0
    places = np.column_stack([pixels[hit], values[hit, 1]]).astype(np.float32)
    return camera.core(scene.center, scene.radius).points(*size, places)


def _around(points: NDArray[np.float32], scene: Scene, camera: Camera, size: tuple[int, int], margin: float) -> Camera:
    """Return the camera with a zoom and pan that fit the points to the picture."""
    if len(points) == 0:
        return camera
    rows, columns = size
    for _ in range(STEPS if camera.fov else 1):
        places = camera.core(scene.center, scene.radius).seen(rows, columns, points)[:, :2]
        (top, left), (bottom, right) = np.nanmin(places, axis=0), np.nanmax(places, axis=0) + 1
        pixel = pixel_at_center(camera, rows, columns)
        pan = (
            camera.pan[0] + float((left + right) / 2 - columns / 2) * pixel,
            camera.pan[1] - float((top + bottom) / 2 - rows / 2) * pixel,
        )
        high, wide = max(bottom - top, 1e-3), max(right - left, 1e-3)
        times = float((1 - 2 * margin) * min(rows / high, columns / wide))
        camera = replace(camera, zoom=min(max(camera.zoom * times, 1e-3), 1e6), pan=pan)
    return camera


def pixel_at_center(camera: Camera, rows: int, columns: int) -> float:
    """Return a pixel's side at the bounding sphere's centre, in radii (core/picture/camera.h)."""
    shorter = min(rows, columns)
    if not camera.fov:
        return 2 / (camera.zoom * shorter)
    high = math.tan(math.radians(camera.fov) / 2)
    sphere = high * shorter / rows
    return 2 * high / (camera.zoom * rows) * math.hypot(1, sphere) / sphere
