"""Fillings without a network, the baselines of every network: nearest, pull-push, Delaunay-linear, Telea.

Each takes the gray picture and its mask, (H, W), and returns (H, W) float32 with the traced pixels unchanged.
`nearest` and `delaunay_linear` need scipy and `telea` needs OpenCV; the extra `train` installs both.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.support.errors import InputError, check_array, check_finite, shape_of


def nearest(gray: Any, mask: Any) -> NDArray[np.float32]:
    """Give each untraced pixel the value of the nearest traced one.

    Parameters
    ----------
    gray : (H, W) numbers
        Only read where `mask` is not 0.
    mask : (H, W) numbers
        Not 0 where traced; at least one pixel is.

    Returns
    -------
    (H, W) float32; traced pixels are returned unchanged.
    """
    from scipy.ndimage import distance_transform_edt

    gray, known = _inputs(gray, mask)
    row, column = distance_transform_edt(~known, return_distances=False, return_indices=True)
    return np.ascontiguousarray(gray[row, column])


def pull_push(gray: Any, mask: Any) -> NDArray[np.float32]:
    """Fill in from a pyramid of averages over the traced pixels, coarse to fine, smoothly.

    Pull: each level halves the picture; a pixel is the mean of its known 2x2 children.
    Push: a pixel without a value takes it from the coarser level, interpolated bilinearly.

    Parameters
    ----------
    gray, mask : (H, W) numbers, as in `nearest`

    Returns
    -------
    (H, W) float32; traced pixels are returned unchanged.

    References
    ----------
    Kraus, *The pull-push algorithm revisited*, 2009.
    """
    gray, known = _inputs(gray, mask)
    levels = [(gray, known.astype(np.float32))]
    while levels[-1][0].size > 1:
        levels.append(_pull(*levels[-1]))
    filled = levels[-1][0]
    for value, weight in reversed(levels[:-1]):
        height, width = value.shape
        filled = weight * value + (1 - weight) * _upsample(filled)[:height, :width]
    return np.asarray(np.where(known, gray, filled), dtype=np.float32)


def delaunay_linear(gray: Any, mask: Any) -> NDArray[np.float32]:
    """Interpolate linearly over the Delaunay triangles of the traced pixels; nearest outside of their hull.

    Parameters
    ----------
    gray : (H, W) numbers, or (H, W, C) with each component interpolated separately
    mask : (H, W) numbers, as in `nearest`

    Returns
    -------
    As `gray`, float32; traced pixels are returned unchanged.
    """
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import QhullError

    gray, known = _inputs(gray, mask, components=len(shape_of(gray)) == 3)
    filled = (
        nearest(gray, known) if gray.ndim == 2 else np.stack([nearest(k, known) for k in np.moveaxis(gray, -1, 0)], -1)
    )
    unknown = np.argwhere(~known)
    if len(unknown) == 0:
        return filled
    try:
        interpolate = LinearNDInterpolator(np.argwhere(known), gray[known].astype(np.float64))
    except (QhullError, ValueError):  # fewer than three traced pixels, or all on one line: no triangle
        return filled
    values = interpolate(unknown)
    inside = np.isfinite(values).reshape(len(unknown), -1).all(1)
    filled[tuple(unknown[inside].T)] = values[inside]
    return filled


def telea(gray: Any, mask: Any) -> NDArray[np.float32]:
    """March from the traced pixels into the unknown, each pixel a mean of its known neighbours along their gradients.

    Parameters
    ----------
    gray, mask : (H, W) numbers, as in `nearest`
        Gray in 0..1; other values are clamped before the call of OpenCV.

    Returns
    -------
    (H, W) float32 in steps of 1/255; traced pixels are returned unchanged.

    References
    ----------
    Telea, *An image inpainting technique based on the fast marching method*, 2004, in OpenCV's implementation.
    """
    import cv2

    gray, known = _inputs(gray, mask)
    # In 8 bits: OpenCV adds gradients as if gray went to 255 and assumes unit steps, so floats in 0..1 give nonsense.
    # A radius of one pixel is the best of 1, 2, 3, 4 and 6 at every stage: mean SSIM 0.90, 0.95, 0.97 with 1;
    # 0.89, 0.89, 0.95 with 2; 0.88, 0.87, 0.94 with 3; from 5, 25 and 50 % of the pixels of 64 patches of 128x128 of
    # procedural shapes.
    known_8_bit = np.rint(np.clip(gray, 0, 1) * 255).astype(np.uint8)
    filled = cv2.inpaint(known_8_bit, (~known).astype(np.uint8), 1, cv2.INPAINT_TELEA)
    return np.where(known, gray, filled / np.float32(255))


FILLINGS: dict[str, Callable[[Any, Any], NDArray[np.float32]]] = {
    "nearest": nearest,
    "pull-push": pull_push,
    "delaunay-linear": delaunay_linear,
    "telea": telea,
}


def _pull(value: NDArray[np.float32], weight: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Halve a level by means weighted by coverage; a pixel with at least one known child has a value."""
    height, width = value.shape
    edge = ((0, height % 2), (0, width % 2))  # an odd row or column gets unknown neighbours
    weight = np.pad(weight, edge)
    weighted = np.pad(value, edge) * weight
    total = weight[::2, ::2] + weight[1::2, ::2] + weight[::2, 1::2] + weight[1::2, 1::2]
    total_value = weighted[::2, ::2] + weighted[1::2, ::2] + weighted[::2, 1::2] + weighted[1::2, 1::2]
    return total_value / np.maximum(total, 1e-20), np.minimum(total, 1)


def _upsample(value: NDArray[np.float32]) -> NDArray[np.float32]:
    """Double a level bilinearly: (H, W) → (2H, 2W), weights 9, 3, 3, 1 sixteenths, edges repeated."""
    for axis in (0, 1):
        value = np.moveaxis(value, axis, 0)
        before, after = np.concatenate([value[:1], value[:-1]]), np.concatenate([value[1:], value[-1:]])
        doubled = np.stack([0.75 * value + 0.25 * before, 0.75 * value + 0.25 * after], 1)
        value = np.moveaxis(doubled.reshape(-1, *value.shape[1:]).astype(np.float32, copy=False), 0, axis)
    return value


def _inputs(gray: Any, mask: Any, *, components: bool = False) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    known = check_finite("mask", check_array("mask", mask, (None, None))) != 0
    shape = (None, None, None) if components else (None, None)
    values = np.asarray(check_array("gray", gray, shape), dtype=np.float32)
    if values.shape[:2] != known.shape:
        raise InputError(f"gray: expected shape {known.shape} to match mask, got {values.shape}")
    if not known.any():
        raise InputError(f"mask: expected at least one traced pixel, got none of {known.size}")
    check_finite("gray", values[known])
    return np.where(known[..., None] if components else known, values, np.float32(0)), known
