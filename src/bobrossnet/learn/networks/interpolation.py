"""Interpolation between agreeing traced pixels of the lattice, which `complete` blends with a network's picture.

Losses of the completed picture need it as tensors. Its sibling is core/completion/interpolation.cpp, step for step.
Letters in shape comments: N pictures, H and W their size, h and w of a lattice with one pixel in `step` along each
axis.
"""

from __future__ import annotations

from functools import lru_cache

import torch
from torch import Tensor
from torch.nn.functional import pad

MOST_CONTRAST = 0.15  # maximum contrast of corners, as in the core
LONGEST_PAIR = 4  # maximum distance in pixels of opposite corners that suffice as a pair, as in the core
FIRST = 21  # row and column of the coarsest lattice's first pixel, as in the core
COARSEST = 64  # step of the coarsest lattice
BLACK = -1.0  # contrast of background, which is not interpolated
UNKNOWN = float("inf")  # contrast of corners that disagree

Offsets = tuple[tuple[int, int], ...]  # rows and columns, opposite corners in pairs
DIAGONAL: Offsets = ((-1, -1), (1, 1), (-1, 1), (1, -1))
STRAIGHT: Offsets = ((-1, 0), (1, 0), (0, -1), (0, 1))


def interpolated(gray: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
    """Interpolate the lattice, from the coarsest squares down to pixels.

    Parameters
    ----------
    gray : (N, 1, H, W) in 0..1, 0 where not traced
    mask : (N, 1, H, W), 1 where traced

    Returns
    -------
    value : (N, 1, H, W), 0 where traced and where corners disagree
    weight : (N, 1, H, W) in 0..1, the weight of the value in the blend with a network's picture
    """
    traced = mask > 0
    contrast_of_traced = torch.where(traced & (gray == 0), BLACK, torch.where(traced, 0.0, UNKNOWN))
    step = COARSEST
    first = FIRST % step
    value = gray[..., first::step, first::step]  # (N, 1, h, w)
    contrast = contrast_of_traced[..., first::step, first::step]
    while step > 1:
        step //= 2
        first = FIRST % step
        at = (..., slice(first, None, step), slice(first, None, step))
        value, contrast = _refine(value, contrast, gray[at], contrast_of_traced[at], step)
    used = (contrast < UNKNOWN) & ~traced
    weight = torch.where(used, 1 - contrast.clamp(min=0) / MOST_CONTRAST, 0.0)
    return torch.where(used, value, 0.0), weight


def blend(image: Tensor, value: Tensor, weight: Tensor) -> Tensor:
    """Blend a network's picture with interpolated values by their weight, all (N, 1, H, W)."""
    return image + (value - image) * weight


def _refine(
    value: Tensor, contrast: Tensor, traced: Tensor, traced_contrast: Tensor, step: int
) -> tuple[Tensor, Tensor]:
    """Return the next finer lattice's values and contrasts, (N, 1, h, w), from a lattice's and its traced pixels."""
    phase = (FIRST % (2 * step) - FIRST % step) // step  # of the coarser lattice in this one
    h, w = traced.shape[-2:]
    fine_value, fine_contrast = traced.clone(), traced_contrast.clone()
    coarse, between = slice(phase, None, 2), slice(1 - phase, None, 2)
    fine_value[..., coarse, coarse] = value
    fine_contrast[..., coarse, coarse] = contrast
    for rows, columns, offsets in (
        (between, between, DIAGONAL),
        (between, coarse, STRAIGHT),
        (coarse, between, STRAIGHT),
    ):
        values = _neighbours(fine_value, rows, columns, offsets)  # (4, N, 1, h', w')
        contrasts = _neighbours(fine_contrast, rows, columns, offsets)
        present = _present(h, w, rows.start, columns.start, offsets, fine_value.device)
        new_value, new_contrast = _mean_of_corners(values, contrasts, present, step <= LONGEST_PAIR)
        known = traced_contrast[..., rows, columns] < UNKNOWN
        fine_value[..., rows, columns] = torch.where(known, traced[..., rows, columns], new_value)
        fine_contrast[..., rows, columns] = torch.where(known, traced_contrast[..., rows, columns], new_contrast)
    return fine_value, fine_contrast


def _neighbours(plane: Tensor, rows: slice, columns: slice, offsets: Offsets) -> Tensor:
    """Return four neighbours of every second pixel: (N, 1, h, w) → (4, N, 1, h', w'), 0 outside."""
    padded = pad(plane, (1, 1, 1, 1))
    h, w = plane.shape[-2:]
    return torch.stack(
        [padded[..., 1 + y + rows.start : 1 + y + h : 2, 1 + x + columns.start : 1 + x + w : 2] for y, x in offsets]
    )


@lru_cache(maxsize=256)
def _present(h: int, w: int, row: int, column: int, offsets: Offsets, device: torch.device) -> Tensor:
    """Return a mask of the neighbours inside the lattice, (4, 1, 1, h', w')."""
    there = torch.ones(1, 1, h, w, device=device)
    return _neighbours(there, slice(row, None, 2), slice(column, None, 2), offsets) > 0


def _mean_of_corners(values: Tensor, contrasts: Tensor, present: Tensor, by_pairs: bool) -> tuple[Tensor, Tensor]:
    """Return value and contrast between four corners, (4, N, 1, h', w') → (N, 1, h', w') each."""
    worst = torch.where(present, contrasts, BLACK).amax(0)
    low, high = torch.where(present, values, UNKNOWN).amin(0), torch.where(present, values, -UNKNOWN).amax(0)
    mean = torch.where(present, values, 0.0).sum(0) / present.sum(0)
    most = torch.maximum(worst, high - low)
    if by_pairs:
        means = (values[0::2] + values[1::2]) / 2
        of_pairs = torch.maximum(torch.maximum(contrasts[0::2], contrasts[1::2]), (values[0::2] - values[1::2]).abs())
        first = of_pairs[0] <= of_pairs[1]
        off = (means[0] - means[1]).abs()
        chosen, other = torch.where(first, of_pairs[0], of_pairs[1]), torch.where(first, of_pairs[1], of_pairs[0])
        all_present = present.all(0)
        mean = torch.where(all_present, torch.where(first, means[0], means[1]), mean)
        most = torch.where(all_present, torch.maximum(chosen, off - other / 2), most)
    known = worst < UNKNOWN
    used = known & (1 - most / MOST_CONTRAST > 0)
    black = worst < 0
    contrast = torch.where(black, BLACK, torch.where(used, most, UNKNOWN))
    return torch.where(used & ~black, mean, 0.0), contrast
