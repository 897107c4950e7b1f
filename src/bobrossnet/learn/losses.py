"""The five losses of the report, by name, and the SSIM that three of them are made of.

Letters in shape comments: N pictures, H and W their size.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import torch
from torch import Tensor

from bobrossnet.metrics import C1, C2, gaussian_band

LEAK = 0.01


def l1(image: Tensor, reference: Tensor) -> Tensor:
    """Return the mean absolute difference of each picture, (N, 1, H, W) → (N,)."""
    return (image - reference).abs().mean((1, 2, 3))


def l2(image: Tensor, reference: Tensor) -> Tensor:
    """Return the mean squared difference of each picture, (N, 1, H, W) → (N,)."""
    return (image - reference).square().mean((1, 2, 3))


def ssim(image: Tensor, reference: Tensor) -> Tensor:
    """Return the mean structural similarity of each picture; `bobrossnet.metrics.ssim` step for step.

    Parameters
    ----------
    image, reference : (N, 1, H, W) float32 in 0..1
        H and W of at least 11.

    Returns
    -------
    (N,) float32 of at most 1
    """
    x, y = image.float(), reference.float()
    mean_x, mean_y, square, product = _smooth(torch.stack([x, y, x * x + y * y, x * y]))  # (N, 1, H-10, W-10) each
    mean_square, mean_product = mean_x * mean_x + mean_y * mean_y, mean_x * mean_y
    variance, covariance = square - mean_square, product - mean_product
    numerator = (2 * mean_product + C1) * (2 * covariance + C2)
    return (numerator / ((mean_square + C1) * (variance + C2))).mean((1, 2, 3))


def dissimilarity(image: Tensor, reference: Tensor) -> Tensor:
    """Return 1 − SSIM of each picture as it's shown, in 0..1: (N, 1, H, W) → (N,), in 0..2."""
    shown = torch.lerp(image.clamp(0, 1), image, LEAK)
    return 1 - ssim(shown, reference)


LOSSES: dict[str, Callable[[Tensor, Tensor], Tensor]] = {
    "l1": l1,
    "l2": l2,
    "ssim": dissimilarity,
    "ssim+l1": lambda image, reference: dissimilarity(image, reference) + l1(image, reference),
    "ssim+l2": lambda image, reference: dissimilarity(image, reference) + l2(image, reference),
}
"""Each takes (N, 1, H, W) pictures in 0..1 and their references, and returns (N,), 0 where they are equal."""


def _smooth(pictures: Tensor) -> Tensor:
    """Smooth (..., H, W) with the window, valid positions only: (..., H - 10, W - 10)."""
    height, width = pictures.shape[-2:]
    rows, columns = _band(height, pictures.device), _band(width, pictures.device)
    return rows @ pictures @ columns.T


@lru_cache(maxsize=8)
def _band(size: int, device: torch.device) -> Tensor:
    return torch.tensor(gaussian_band(size), dtype=torch.float32, device=device)
