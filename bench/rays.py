"""Rays for benchmarks, Embree to trace them, and cameras with equal views of different scenes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

import bobrossnet as bob

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]


def random_rays(count: int) -> tuple[F32, F32]:
    """Return origins and directions, (n, 3), of incoherent orthographic rays, the worst case for caches.

    Their directions are random, spread evenly over the disc of the unit sphere.
    """
    rng = np.random.default_rng(0)
    direction = rng.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    across = np.cross(direction, rng.normal(size=(count, 3)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    origin = across * np.sqrt(rng.random((count, 1))) - 1.2 * direction
    return origin.astype(np.float32), direction.astype(np.float32)


def camera_rays(camera: bob.Camera, size: tuple[int, int]) -> tuple[NDArray[np.int64], F32, F32]:
    """Return the pixels whose rays hit the unit sphere, row by row, (n,), and the rays.

    Origins, just outside the sphere, and directions are (n, 3) each.
    """
    pixels = np.indices(size, np.int32).reshape(2, -1).T
    return camera.core((0, 0, 0), 1).rays(*size, np.ascontiguousarray(pixels))


def build_embree(vertices: F32, triangles: NDArray[np.int32], device: Any = None) -> EmbreeScene:
    scene = EmbreeScene(device)
    TriangleMesh(scene, vertices, triangles)
    scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))  # builds the BVH
    return scene


def seen_alike(camera: bob.Camera, scene: bob.Scene, other: bob.Scene) -> bob.Camera:
    """Return a camera for another scene with the same view, region and scale, as an orthographic one without roll."""
    azimuth, elevation = np.radians((camera.azimuth, camera.elevation))
    right = np.array((-np.sin(azimuth), np.cos(azimuth), 0))
    toward = np.array((np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)))
    axes = np.stack([right, np.cross(toward, right)])
    pan = axes @ (scene.center - other.center) + scene.radius * np.array(camera.pan)
    return replace(camera, zoom=camera.zoom * other.radius / scene.radius, pan=tuple(pan / other.radius))
