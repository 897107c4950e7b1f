"""Rays that the benchmarks cast, and Embree to cast them with."""

from __future__ import annotations

from typing import Any

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

import bobrossnet as bob

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]


def random_rays(count: int) -> tuple[F32, F32]:
    """Origins and directions, (n, 3), of orthographic rays of random directions, spread evenly over the disc that the
    unit sphere fills: the worst case for caches, and no ray is like its neighbour."""
    rng = np.random.default_rng(0)
    direction = rng.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    across = np.cross(direction, rng.normal(size=(count, 3)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    origin = across * np.sqrt(rng.random((count, 1))) - 1.2 * direction
    return origin.astype(np.float32), direction.astype(np.float32)


def camera_axes(camera: bob.Camera) -> tuple[F64, F64, F64]:
    """Right, up, and towards the camera, (3,) each; of a camera without roll."""
    a, e = np.radians((camera.azimuth, camera.elevation))
    right = np.array((-np.sin(a), np.cos(a), 0))
    toward = np.array((np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)))
    return right, np.cross(toward, right), toward


def pixel_centers(size: tuple[int, int]) -> tuple[F64, F64]:
    """x to the right and y up, (n,) each, in radii of the bounding sphere, row by row; at zoom 1."""
    height, width = size
    row, column = np.indices(size).reshape(2, -1)
    scale = 2 / min(size)
    x = np.asarray((column + 0.5 - width / 2) * scale, np.float64)
    y = np.asarray((height / 2 - row - 0.5) * scale, np.float64)
    return x, y


def camera_rays(camera: bob.Camera, size: tuple[int, int]) -> tuple[F32, F32]:
    """Origins and directions, (n, 3), of every pixel's ray to the unit sphere, as core/picture/camera.h has them."""
    right, up, toward = camera_axes(camera)
    x, y = pixel_centers(size)
    origin = x[:, None] * right + y[:, None] * up + 1.2 * toward
    return origin.astype(np.float32), np.tile(-toward, (len(x), 1)).astype(np.float32)


def build_embree(vertices: F32, triangles: NDArray[np.int32], device: Any = None) -> EmbreeScene:
    scene = EmbreeScene(device)
    TriangleMesh(scene, vertices, triangles)
    scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))  # builds the BVH
    return scene
