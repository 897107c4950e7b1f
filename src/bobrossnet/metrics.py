"""Image quality metrics: SSIM and PSNR in numpy, FLIP by its authors' package."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.support.errors import InputError, InputTypeError, check_array, check_finite, shape_of

WINDOW = 11  # pixels, Gaussian; the values of Wang et al. 2004, for pictures in 0..1
SIGMA = 1.5
C1 = 0.01**2
C2 = 0.03**2


def ssim(image: Any, reference: Any) -> float:
    """Return the mean structural similarity of two pictures; equal pictures score 1.

    Parameters
    ----------
    image, reference : (H, W) floats in 0..1
        Both sides at least 11 pixels.

    Returns
    -------
    float of at most 1
        Mean over the positions where the whole 11x11 Gaussian window (σ 1.5) lies inside the picture.

    Raises
    ------
    InputError
        If the shapes differ or are too small, or a value is not finite.

    References
    ----------
    Wang, Bovik, Sheikh, Simoncelli, *Image quality assessment*, 2004.

    Examples
    --------
    >>> black, gray = np.zeros((16, 16)), np.full((16, 16), 0.1)
    >>> round(ssim(gray, black), 4)  # C1 / (0.1² + C1): over black, a small difference weighs much
    0.0099
    """
    x, y = _pictures(image, reference)
    if min(x.shape) < WINDOW:
        raise InputError(f"image: expected at least {WINDOW}x{WINDOW} pixels, the SSIM window, got {x.shape}")
    # SSIM needs only the sum of the two variances, so four smoothed pictures suffice, not five.
    mean_x, mean_y, square, product = _smooth(np.stack([x, y, x * x + y * y, x * y]))  # (H-10, W-10) each
    mean_square, mean_product = mean_x * mean_x + mean_y * mean_y, mean_x * mean_y
    variance, covariance = square - mean_square, product - mean_product
    numerator = (2 * mean_product + C1) * (2 * covariance + C2)
    return float(np.mean(numerator / ((mean_square + C1) * (variance + C2))))


def psnr(image: Any, reference: Any) -> float:
    """Return the peak signal-to-noise ratio in dB of two pictures in 0..1; infinite where they are equal.

    Parameters
    ----------
    image, reference : (H, W) or (H, W, 3) floats in 0..1
        The squared error of a colour is the mean over its three components.

    Examples
    --------
    >>> round(psnr(np.full((4, 4), 0.1), np.zeros((4, 4))), 6)
    20.0
    """
    x, y = _pictures(image, reference, colored=True)
    error = float(np.mean((x - y) ** 2))
    return -10 * math.log10(error) if error > 0 else math.inf


def flip(image: Any, reference: Any) -> float:
    """Return the mean FLIP error: the difference seen when two pictures alternate, from 0 (equal) to 1.

    LDR-FLIP under its default viewing conditions, computed by `flip-evaluator`, which `bobrossnet[train]` installs.

    Parameters
    ----------
    image, reference : (H, W) gray or (H, W, 3) colours, floats in 0..1
        Display-referred, interpreted as sRGB. Values outside 0..1 are clamped.

    Returns
    -------
    float in 0..1

    Raises
    ------
    InputError
        If the shapes differ, or a value is not finite.

    References
    ----------
    Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, *FLIP: A Difference Evaluator for Alternating
    Images*, 2020.

    Examples
    --------
    >>> black, white = np.zeros((8, 8)), np.ones((8, 8))
    >>> round(flip(white, black), 4)  # below 1, the difference between pure green and pure blue
    0.9674
    """
    try:
        from flip_evaluator import evaluate
    except ImportError:
        raise InputError("flip: this needs flip-evaluator: pip install 'bobrossnet[train]'") from None
    gray_or_color = _pictures(image, reference, colored=True)
    shown, wanted = (np.float32(np.clip(p if p.ndim == 3 else p[..., None].repeat(3, 2), 0, 1)) for p in gray_or_color)
    return float(evaluate(wanted, shown, "LDR", applyMagma=False)[1])


def gaussian_window() -> NDArray[np.float64]:
    """Return the window's 11 weights along one axis, sum 1."""
    distance = np.arange(WINDOW) - WINDOW // 2
    weights = np.exp(-0.5 * (distance / SIGMA) ** 2)
    return np.asarray(weights / weights.sum())


def _smooth(pictures: NDArray[np.float64]) -> NDArray[np.float64]:
    """Smooth (n, H, W) with the window at valid positions only: (n, H - 10, W - 10).

    Sums of shifted pictures take 23 of the 34 ms of `ssim` at 640x480. Products with band matrices, block by
    block, took 8 ms on an idle machine but 1,600 ms on a busy one, where BLAS threads wait for each other.
    """
    half = gaussian_window()[: WINDOW // 2 + 1]  # symmetric
    for axis in (1, 2):
        shifted = np.lib.stride_tricks.sliding_window_view(pictures, WINDOW, axis)  # a view, (n, ., ., 11)
        smoothed = half[-1] * shifted[..., WINDOW // 2]
        for offset, weight in enumerate(half[:-1]):
            pair = shifted[..., offset] + shifted[..., WINDOW - 1 - offset]
            pair *= weight
            smoothed += pair
        pictures = smoothed
    return pictures


def _pictures(image: Any, reference: Any, *, colored: bool = False) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    pictures = []
    for name, value in (("image", image), ("reference", reference)):
        shape = (None, None, 3) if colored and len(shape_of(value)) == 3 else (None, None)
        array = check_finite(name, check_array(name, value, shape))
        if array.dtype.kind != "f":
            raise InputTypeError(f"{name}: expected floats in 0..1, got dtype {array.dtype}; divide bytes by 255")
        if array.size == 0:
            raise InputError(f"{name}: expected at least one pixel, got shape {array.shape}")
        pictures.append(array.astype(np.float64))
    if pictures[0].shape != pictures[1].shape:
        raise InputError(f"image: expected shape {pictures[1].shape} to match reference, got {pictures[0].shape}")
    return pictures[0], pictures[1]
