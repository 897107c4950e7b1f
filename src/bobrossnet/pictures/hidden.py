"""Hidden edges: curves of shapes in space, where other surfaces lie in front of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.picture.camera import Camera
from bobrossnet.pictures.fitting import pixel_at_center
from bobrossnet.shapes.affine import mapped
from bobrossnet.shapes.edges import Segments, edges_of
from bobrossnet.shapes.shape import MAX_CELLS
from bobrossnet.tracing.scene import Scene

F32 = NDArray[np.float32]
Curves = tuple[F32, NDArray[np.int64]]
"""Points (n, 2), rows and columns, and the end of each curve among them."""

STEP = 3.0
"""Pixels of a curve's segment, which is within 1/30 of it from the curve."""

PLACE = 1.0
"""Pixels between places whose visibility is tested: gaps and dashes are longer."""

IN_FRONT = 0.5
"""A surface hides edges at this distance in pixels behind it. Visible edges lie under visible lines."""

MAX_PLACES = 2**22
"""Maximum number of places tested: a second or two of rays."""


def hidden_edges(scene: Scene, camera: Camera, size: tuple[int, int]) -> Curves:
    """Return the parts of edges behind surfaces, in the picture."""
    pixel = pixel_at_center(camera, *size) * scene.radius
    found: list[F32] = []
    segments_of: dict[tuple[int, float], Segments] = {}
    for instance in scene.instances:
        matrix = instance.transform
        low, high = instance.shape.bounding_box(np.eye(4))
        step = STEP * pixel / max(float(_core.singular_values(matrix)[0]), 1e-300)
        step = max(step, float((high - low).max()) / MAX_CELLS)
        key = id(instance.shape), step
        if key not in segments_of:
            segments_of[key] = edges_of(instance.shape, step)
        points, ends = segments_of[key]
        placed = np.asarray((mapped(matrix, points) - scene.center) / scene.radius, np.float32)
        found.append(placed[ends])
    return _hidden(np.concatenate([np.empty((0, 2, 3), np.float32), *found]), scene, camera, size)


def _hidden(segments: F32, scene: Scene, camera: Camera, size: tuple[int, int]) -> Curves:
    """Return the hidden parts of segments, (m, 2, 3) in the unit sphere, as curves in the picture."""
    core = camera.core(scene.center, scene.radius)
    # Rows and columns, NaN behind the camera, and segments outside the picture.
    seen = core.seen(*size, segments.reshape(-1, 3))[:, :2].reshape(-1, 2, 2)
    with np.errstate(invalid="ignore"):
        inside = ((seen.max(axis=1) > -1) & (seen.min(axis=1) < size)).all(axis=1)
    segments, seen = segments[inside], seen[inside]
    length = np.hypot(*(seen[:, 1] - seen[:, 0]).T)
    count = np.clip(np.ceil(length / PLACE), 1, 4 * max(size)).astype(np.int64)
    if count.sum() > MAX_PLACES:
        count = np.maximum(count * MAX_PLACES // count.sum(), 1)
    owner = np.repeat(np.arange(len(count)), count)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    share = (np.stack([number, number + 1], axis=1) / count[owner, None]).astype(np.float32)
    a, b = segments[owner, 0], segments[owner, 1]
    middle = a + share.mean(axis=1)[:, None] * (b - a)
    hidden = _behind(middle, scene, camera, size)
    owner, share = owner[hidden], share[hidden]
    parts = segments[owner, 0][:, None] + share[..., None] * (segments[owner, 1] - segments[owner, 0])[:, None]
    places = core.seen(*size, np.ascontiguousarray(parts.reshape(-1, 3)))[:, :2]
    places = places[np.isfinite(places).all(axis=1).reshape(-1, 2).all(axis=1).repeat(2)]
    # Ends that agree to a hundredth of a pixel are one.
    _, first, same = np.unique(np.rint(100 * places), axis=0, return_index=True, return_inverse=True)
    ends = same.reshape(-1, 2)
    ends = np.unique(np.sort(ends[ends[:, 0] != ends[:, 1]], axis=1), axis=0)
    return _core.joined(np.ascontiguousarray(places[first]), ends.astype(np.uint32), 0.05)


def _behind(points: F32, scene: Scene, camera: Camera, size: tuple[int, int]) -> NDArray[np.bool_]:
    """Return whether a surface is in front of each point, (n, 3) in the unit sphere."""
    core = camera.core(scene.center, scene.radius)
    places = core.seen(*size, points)
    known = np.isfinite(places).all(axis=1)
    result = np.zeros(len(points), bool)
    places = places[known]
    places[:, 2] = 1 if camera.fov else 1.001  # the nearest depth, and a little before it
    origins = core.points(*size, np.ascontiguousarray(places)).astype(np.float64)
    to_points = points[known] - origins
    distance = np.linalg.norm(to_points, axis=1)
    some = distance > 0
    hits = scene.closest_hits(origins[some] * scene.radius + scene.center, to_points[some])
    margin = IN_FRONT * pixel_at_center(camera, *size) + 1e-5
    indices = np.flatnonzero(known)[some]
    result[indices] = hits.distance / scene.radius < distance[some] - margin
    return result
