"""Completion without learning: pull-push by Gaussian means of coverage and of the surface's gray.

The traced pixels are counted over blocks of 2, 4, ... 64 pixels. From the coarsest level on, two pictures are upsampled
and corrected by the traced pixels of each block, or of the neighbouring blocks if it has no traced pixels. One picture
is the coverage, the share of surface pixels; the other is the gray of the surface alone. Their product keeps sharp
silhouettes: the transition between surface and background is in the coverage, which is sharpened.

Its sibling is core/completion/filling.cpp, step for step. Letters in shape comments as in pyramid.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import torch
from torch import Tensor
from torch.nn import functional

from bobrossnet.learn.networks.network import Network
from bobrossnet.learn.networks.paper import pad
from bobrossnet.learn.networks.pyramid import crop, upsample

LEVELS = 6  # blocks of the coarsest have 64 x 64 pixels
# Weight at which a Gaussian mean counts half. .15 gains .0002 of SSIM at 1 % of the pixels and loses .0007 at 5 %;
# .01 loses .001 at 1 %.
SOFTNESS = 0.05
# Slope of the picture's coverage at 1/2, relative to the filled coverage. 4 gives a lower mean error and a lower SSIM,
# by .0015 at 1 and 5 % of the pixels; 1 loses .03 and .002.
SHARPNESS = 2.0


class Filling(Network):
    """Complete the gray picture of a partial G-buffer without any weights.

    References
    ----------
    Kraus, *The pull-push algorithm revisited*, 2009; Knutsson and Westin, *Normalized and differential convolution*,
    1993, for means over known values.
    """

    inputs: ClassVar[str] = "mask,gray"

    @classmethod
    def from_settings(cls, settings: Mapping[str, Any]) -> Filling:
        """Return the filling; it has no settings."""
        return cls()

    def settings(self) -> Mapping[str, int | str]:
        """Return the arguments of `from_settings` for this network."""
        return {}

    def forward(self, gbuffer: Tensor) -> Tensor:
        """Return the gray picture, (N, 1, H, W), linear and not clamped.

        Parameters
        ----------
        gbuffer : (N, 2, H, W) float
            mask and gray, 0 where not traced; background is where gray is 0. Any H and W of at least 1.
        """
        mask, gray = gbuffer[:, :1], gbuffer[:, 1:]
        counts = [torch.cat([mask, mask * (gray != 0), gray], 1)]  # traced, on a surface, sum of gray
        for _ in range(LEVELS):
            counts.append(4 * functional.avg_pool2d(pad(counts[-1], 2), 2))

        filled = torch.zeros_like(counts[-1][:, :2])  # coverage and gray, (N, 2, h, w)
        for level in range(LEVELS, -1, -1):
            traced, shown, sum = torch.split(counts[level], 1, 1)
            if level < LEVELS:
                filled = crop(upsample(filled), traced.shape[-2:])
            filled = torch.cat([correct(filled[:, :1], traced, shown), correct(filled[:, 1:], shown, sum)], 1)

        coverage = 0.5 + SHARPNESS * (filled[:, :1] - 0.5)
        return filled[:, 1:] * coverage.clamp(0, 1)


def correct(expected: Tensor, count: Tensor, sum: Tensor) -> Tensor:
    """Correct the expected values of blocks by the residual of their pixels, or of the neighbouring blocks' pixels.

    Parameters
    ----------
    expected, count, sum : (N, 1, h, w)
        Expected value of each block, number of its known pixels, and their sum.
    """
    surprise = sum - count * expected
    here = surprise / count.clamp(min=1)
    around = gaussian(surprise) / (gaussian(count) + SOFTNESS)
    return expected + torch.where(count > 0, here, around)


def gaussian(x: Tensor) -> Tensor:
    """Smooth by a 3x3 kernel with weights 1, 2, 1 along each axis: (N, 1, h, w), zero padding."""
    kernel = x.new_tensor([[1, 2, 1], [2, 4, 2], [1, 2, 1]])[None, None] / 16
    return functional.conv2d(x, kernel, padding=1)
