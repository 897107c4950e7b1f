"""All pixels of a picture, in the order that is fastest to trace; and their rays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.camera import Camera
from bobrossnet.picture.order import Size
from bobrossnet.shapes.affine import Point


def tiled_pixels(size: Size) -> NDArray[np.int32]:
    """Return all pixels, (H * W, 2) int32, in 8x8 tiles: successive rays visit the same parts of a BVH."""
    height, width = size
    inside = np.arange(8, dtype=np.int32)
    rows = np.arange(0, height, 8, dtype=np.int32)[:, None, None, None] + inside[:, None]
    columns = np.arange(0, width, 8, dtype=np.int32)[None, :, None, None] + inside
    tiles = np.empty((-(-height // 8), -(-width // 8), 8, 8, 2), np.int32)  # (tile row, tile column, row, column, 2)
    tiles[..., 0], tiles[..., 1] = rows, columns
    pixels = tiles.reshape(-1, 2)
    if height % 8 == 0 and width % 8 == 0:
        return pixels
    return pixels[(pixels[:, 0] < height) & (pixels[:, 1] < width)]


def pixel_rays(
    camera: Camera, center: Point, radius: float, size: Size, pixels: NDArray[np.int32]
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the rays of pixels (n, 2) that meet a sphere: indices (k,), origins and directions (k, 3)."""
    rays, origins, directions = camera.core(center, radius).rays(*size, pixels)
    return rays, origins * radius + center, directions.astype(np.float64)
