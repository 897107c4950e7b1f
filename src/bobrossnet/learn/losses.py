"""The losses by name, the report's five and one similar to FLIP, and the SSIM in most of them.

A loss takes raw network outputs, unbounded, and references in 0..1. Letters in shape comments: N pictures, H and W
their size.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import torch
from torch import Tensor

from bobrossnet.metrics import C1, C2, gaussian_window

LEAK = 0.01
"""Share of the excess beyond 0..1 that the SSIM losses still see.

A patch may be mostly exactly black, where SSIM punishes an offset of 0.01 like a wrong picture. Displayed pictures
are clamped, so the losses clamp too, and the network may answer "at most 0" for black: after 250 steps the SSIM
at 5 % was .71 instead of .44 (AdamW, ssim+l2, raw output, same start and batches). Without a leak, a network with
only negative answers has no gradient; with 0.1 the offset would matter again.
"""

VISIBLE = 0.001
"""Scale in sRGB, about a quarter of an 8-bit step, below which differences are squared.

The slope of a power of 0.7 is unbounded at 0.
"""

LARGEST_DIFFERENCE = 41.276098
"""FLIP's distance between green and blue, the maximum over sRGB: HyAB after the Hunt effect, ^0.7."""

DARKEST = 0.003
"""Offset of linear light that makes the curve's slope at black equal to sRGB's, 13."""


def l1(image: Tensor, reference: Tensor) -> Tensor:
    """Return the mean absolute difference of each picture: two (N, 1, H, W) → (N,)."""
    return (image - reference).abs().mean((1, 2, 3))


def l2(image: Tensor, reference: Tensor) -> Tensor:
    """Return the mean squared difference of each picture: two (N, 1, H, W) → (N,)."""
    return (image - reference).square().mean((1, 2, 3))


def ssim(image: Tensor, reference: Tensor) -> Tensor:
    """Return the mean structural similarity of each picture, in the same steps as `bobrossnet.metrics.ssim`.

    Parameters
    ----------
    image, reference : (N, 1, H, W) float, meant for 0..1
        Both sides at least 11 pixels. Not clamped here.

    Returns
    -------
    (N,) float32 in -1..1, up to rounding
        Equal pictures score 1.
    """
    x, y = image.float(), reference.float()
    smooth = _smooth(torch.stack([x, y, x * x + y * y, x * y]))  # (4, N, 1, H-10, W-10)
    mean_x, mean_y, square, product = smooth.unbind()
    mean_square, mean_product = mean_x * mean_x + mean_y * mean_y, mean_x * mean_y
    variance, covariance = square - mean_square, product - mean_product
    numerator = (2 * mean_product + C1) * (2 * covariance + C2)
    return torch.mean(numerator / ((mean_square + C1) * (variance + C2)), (1, 2, 3))


def dissimilarity(image: Tensor, reference: Tensor) -> Tensor:
    """Return 1 − SSIM of each picture: two (N, 1, H, W) → (N,), in 0..2.

    The picture is clamped to 0..1, as when displayed, except for a hundredth of the excess; see `LEAK`.
    """
    shown = torch.lerp(image.clamp(0, 1), image, LEAK)
    return 1 - ssim(shown, reference)


def visible(image: Tensor, reference: Tensor) -> Tensor:
    """Return the visible difference of each picture, two (N, 1, H, W) → (N,): FLIP without the eye's filters.

    In the units of FLIP, with sRGB 0..1 as lightness 0..100: (100 |difference|)^0.7, scaled by 0.95 / 0.4 / 41.28. So
    small differences over large areas matter, which L1 and SSIM mostly ignore, and dark ones as well as bright ones.
    The picture is clamped as in `dissimilarity`.
    """
    inside = image.clamp(0, 1)
    difference = _encoded(inside) - _encoded(reference)
    seen = (difference.square() + VISIBLE**2) ** 0.35 - VISIBLE**0.7
    scale = 0.95 / 0.4 * 100**0.7 / LARGEST_DIFFERENCE
    by_pixel: Tensor = scale * seen + LEAK * (image - inside).abs()
    return by_pixel.mean((1, 2, 3))


LOSSES: dict[str, Callable[[Tensor, Tensor], Tensor]] = {
    "l1": l1,
    "l2": l2,
    "ssim": dissimilarity,
    "ssim+l1": lambda image, reference: dissimilarity(image, reference) + l1(image, reference),
    "ssim+l2": lambda image, reference: dissimilarity(image, reference) + l2(image, reference),
    "ssim+visible": lambda image, reference: dissimilarity(image, reference) + visible(image, reference),
}
"""Each takes pictures and their references, (N, 1, H, W), and returns (N,), non-negative, and 0 for equal pictures."""

OF_REPORT = ("l1", "l2", "ssim", "ssim+l1", "ssim+l2")
"""The losses that the report compares."""


def _encoded(gray: Tensor) -> Tensor:
    """Encode linear light by about sRGB's curve, with a finite slope everywhere: (0..1) → about 0..1."""
    encoded: Tensor = (gray + DARKEST) ** (1 / 2.4)
    return encoded


def _smooth(pictures: Tensor) -> Tensor:
    """Smooth (..., H, W) with the window at valid positions only: (..., H - 10, W - 10)."""
    height, width = pictures.shape[-2:]
    rows, columns = _band(height, pictures.device), _band(width, pictures.device)
    return rows @ pictures @ columns.T


@lru_cache(maxsize=8)
def _band(size: int, device: torch.device) -> Tensor:
    """Return the band matrix that smooths a column, (size - 10, size): faster in training than a convolution."""
    window = torch.tensor(gaussian_window(), dtype=torch.float32)
    band = torch.zeros(size - len(window) + 1, size)
    for offset, weight in enumerate(window):
        band[:, offset:].fill_diagonal_(weight.item())
    return band.to(device)
