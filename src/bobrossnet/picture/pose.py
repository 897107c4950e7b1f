"""Poses of cameras as matrices, in the conventions of computer vision and of OpenGL."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bobrossnet.picture.camera import Camera
from bobrossnet.picture.order import Size

F64 = NDArray[np.float64]


class Pose(NamedTuple):
    """Place, direction and projection of a camera, in the scene's units.

    A point of the scene has the camera coordinates (x, y, z) = (`world_to_camera` @ (point, 1))[:3]. Its pixel
    (column + 1/2, row + 1/2) is the first two of `intrinsics` @ (x / z, y / z, 1), or of `intrinsics` @ (x, y, 1) for
    an orthographic camera.
    """

    intrinsics: F64
    """(3, 3): focal lengths in pixels and the principal point; for an orthographic camera pixels per unit of length."""
    world_to_camera: F64
    """(4, 4), OpenCV's convention: x right, y down, z forward."""
    is_orthographic: bool

    @property
    def camera_to_world(self) -> F64:
        """(4, 4), OpenGL's and nerfstudio's convention: x right, y up, z backward."""
        rotation, translation = self.world_to_camera[:3, :3], self.world_to_camera[:3, 3]
        result = np.eye(4)
        result[:3, :3] = rotation.T * (1, -1, -1)
        result[:3, 3] = -rotation.T @ translation
        return result


def pose_of(camera: Camera, center: ArrayLike, radius: float, size: Size) -> Pose:
    """Return the pose of a camera for pictures of a size, (height, width), of a scene's bounding sphere."""
    height, width = size
    right, up, toward, origin, pixel = camera.core(center, radius).pose(height, width)
    world_to_camera = np.eye(4)
    world_to_camera[:3, :3] = np.array([right, up, toward]) * np.array([[1], [-1], [-1]])
    world_to_camera[:3, 3] = -world_to_camera[:3, :3] @ (np.asarray(center, float) + radius * np.array(origin))
    focal = 1 / pixel if camera.fov else 1 / (pixel * radius)
    intrinsics = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    return Pose(intrinsics, world_to_camera, not camera.fov)
