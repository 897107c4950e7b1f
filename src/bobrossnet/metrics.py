"""How close a picture is to its reference: SSIM, PSNR and FLIP, in numpy only."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.errors import InputError, InputTypeError, check_array, check_finite, shape_of

WINDOW = 11  # pixels, Gaussian; the values of Wang et al. 2004, for pictures in 0..1
SIGMA = 1.5
C1 = 0.01**2
C2 = 0.03**2

PIXELS_PER_DEGREE = 0.7 * 3840 / 0.7 * math.pi / 180
"""Of visual angle, FLIP's own: 67, a display 3840 pixels and 0.7 m wide, seen from 0.7 m."""
LARGEST_DIFFERENCE = 41.276098
"""Between green and blue, which no colours of sRGB exceed in FLIP's distance: HyAB after the Hunt effect, ^0.7."""

F32 = NDArray[np.float32]

TO_XYZ = np.array(
    [[10135552, 8788810, 4435075], [5226144, 17577620, 1774030], [1425312 / 3, 8788810 / 3, 70074185 / 3]], np.float32
) / np.float32(24577794)
"""From linear sRGB to XYZ, under D65; each row divided by its sum makes white 1."""


def ssim(image: Any, reference: Any) -> float:
    """Return the mean structural similarity of two pictures, 1 where they are equal.

    Parameters
    ----------
    image, reference : (H, W) floats in 0..1
        H and W of at least 11.

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
    >>> round(ssim(gray, black), 4)  # C1 / (0.1² + C1): on black, little is much
    0.0099
    """
    x, y = _pictures(image, reference)
    if min(x.shape) < WINDOW:
        raise InputError(f"image: expected at least {WINDOW}x{WINDOW} pixels, the SSIM window, got {x.shape}")
    # The two variances enter only as their sum, so four pictures need smoothing, not five.
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
        Of colours the squared error is the mean of all three.

    Examples
    --------
    >>> round(psnr(np.full((4, 4), 0.1), np.zeros((4, 4))), 6)
    20.0
    """
    x, y = _pictures(image, reference, colored=True)
    error = float(np.mean((x - y) ** 2))
    return -10 * math.log10(error) if error > 0 else math.inf


def flip(image: Any, reference: Any) -> float:
    """Return the mean difference that an eye sees between two pictures when they alternate: 0 none, 1 the most.

    LDR-FLIP under its default viewing conditions. Of gray pictures only lightness differs, and the method's terms for
    chroma drop out.

    Parameters
    ----------
    image, reference : (H, W) gray or (H, W, 3) colours, floats in 0..1
        Display-referred: they are taken as sRGB. What lies outside of 0..1 is clamped.

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
    Images*, 2020; the constants are those of its sections 4 and 5.

    Examples
    --------
    >>> black, white = np.zeros((8, 8)), np.ones((8, 8))
    >>> round(flip(white, black), 4)  # below 1, which is the difference between pure green and pure blue
    0.9674
    """
    pictures = np.stack(_pictures(image, reference, colored=True)).astype(np.float32)  # enough, and twice as fast
    light = _linear(np.clip(pictures, 0, 1))  # (2, H, W) or (2, H, W, 3)
    luminance = light if light.ndim == 3 else light @ TO_XYZ[1]  # (2, H, W), Y of XYZ, white 1

    # Colour: what the eye resolves, then the distance, compressed.
    if light.ndim == 3:
        seen = _filter(luminance, _sensitivity(), _sensitivity())
        lightness = _lightness(np.clip(seen, 0, 1))
        difference = np.abs(lightness[0] - lightness[1]) ** 0.7
    else:
        difference = _distance(*_hunted(_seen_colors(light))) ** 0.7
    knee = 0.4 * LARGEST_DIFFERENCE
    color = np.where(
        difference < knee,
        0.95 / knee * difference,
        0.95 + 0.05 * (difference - knee) / (LARGEST_DIFFERENCE - knee),
    )

    # Features: edges and points that only one of the two has.
    feature = np.zeros(luminance.shape[1:])
    blur, *derivatives = _feature_detectors()
    for derivative in derivatives:
        strength = np.hypot(_filter(luminance, blur, derivative), _filter(luminance, derivative, blur))
        feature = np.maximum(feature, np.abs(strength[0] - strength[1]))
    return float(np.mean(color ** (1 - np.sqrt(feature / math.sqrt(2))), dtype=np.float64))


def gaussian_window() -> NDArray[np.float64]:
    """Return the window's 11 weights along one axis, sum 1."""
    distance = np.arange(WINDOW) - WINDOW // 2
    weights = np.exp(-0.5 * (distance / SIGMA) ** 2)
    return np.asarray(weights / weights.sum())


def _smooth(pictures: NDArray[np.float64]) -> NDArray[np.float64]:
    """Smooth (n, H, W) with the window, valid positions only: (n, H - 10, W - 10).

    Shifted sums, 23 of the 34 ms that `ssim` takes at 640x480. Products with band matrices, block by block,
    took 8 ms on an idle machine, but 1,600 ms on a busy one, where BLAS's threads wait for each other.
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


def _linear(gray: F32) -> F32:
    """sRGB's transfer function, from display-referred to linear."""
    return np.where(gray <= 0.04045, gray / 12.92, ((gray + 0.055) / 1.055) ** 2.4)


def _lightness(luminance: F32) -> F32:
    """L* of CIELAB, 0..100, of a luminance in 0..1."""
    delta = 6 / 29
    root = np.where(luminance > delta**3, np.cbrt(luminance), luminance / (3 * delta**2) + 4 / 29)
    return np.asarray(116 * root - 16)


def _seen_colors(light: F32) -> F32:
    """What the eye resolves of pictures, (2, H, W, 3) linear sRGB: the same, clamped to 0..1.

    Lightness and two differences of colours are smoothed each as widely as the eye's sensitivity to it says; that to
    blue against yellow is the sum of two Gaussians.
    """
    white = TO_XYZ.sum(1)
    x, y, z = np.moveaxis(light @ TO_XYZ.T / white, -1, 0)  # (2, H, W) each
    y_seen, red_green = _filter(y, _sensitivity(), _sensitivity()), x - y
    red_green = _filter(red_green, _sensitivity(0.0053), _sensitivity(0.0053))
    wide, narrow = _sensitivity(0.04, scaled=False), _sensitivity(0.025, scaled=False)
    shares = np.array([34.1 * math.sqrt(math.pi / 0.04), 13.5 * math.sqrt(math.pi / 0.025)])
    shares /= (shares * [wide.sum() ** 2, narrow.sum() ** 2]).sum()
    yellow_blue = y - z
    yellow_blue = shares[0] * _filter(yellow_blue, wide, wide) + shares[1] * _filter(yellow_blue, narrow, narrow)
    xyz = np.stack([y_seen + red_green, y_seen, y_seen - yellow_blue], -1) * white
    return np.asarray(np.clip(xyz @ np.linalg.inv(TO_XYZ.astype(float)).T, 0, 1), np.float32)


def _hunted(light: F32) -> F32:
    """CIELAB of linear sRGB, (..., 3), with less chroma the darker it is, as the Hunt effect has it."""
    x, y, z = (_lightness(plane) for plane in np.moveaxis(light @ TO_XYZ.T / TO_XYZ.sum(1), -1, 0))
    lightness = y
    return np.stack([lightness, 0.01 * lightness * 500 / 116 * (x - y), 0.01 * lightness * 200 / 116 * (y - z)], -1)


def _distance(one: F32, other: F32) -> F32:
    """HyAB: lightness apart, and the distance of chroma."""
    difference = one - other
    return np.asarray(np.abs(difference[..., 0]) + np.hypot(difference[..., 1], difference[..., 2]))


def _sensitivity(width: float = 0.0047, *, scaled: bool = True) -> NDArray[np.float64]:
    """The eye's contrast sensitivity, by default to luminance, as a Gaussian along one axis: 21 weights, of sum 1 if
    they are scaled."""
    radius = math.ceil(3 * math.sqrt(0.04 / (2 * math.pi**2)) * PIXELS_PER_DEGREE)  # of chroma's, the widest
    degrees = np.arange(-radius, radius + 1) / PIXELS_PER_DEGREE
    weights = np.exp(-(math.pi**2) / width * degrees**2)
    return np.asarray(weights / weights.sum() if scaled else weights)


def _feature_detectors() -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """A Gaussian along one axis and its first two derivatives, 19 weights each, as wide as edges that the eye detects.

    The Gaussian's sum is 1; that of a derivative's positive weights is 1, of its negative ones -1.
    """
    deviation = 0.5 * 0.082 * PIXELS_PER_DEGREE
    radius = math.ceil(3 * deviation)
    x = np.arange(-radius, radius + 1)
    gaussian = np.exp(-(x**2) / (2 * deviation**2))
    edge, point = (
        np.where(weights > 0, weights / weights[weights > 0].sum(), -weights / weights[weights < 0].sum())
        for weights in (-x * gaussian, (x**2 / deviation**2 - 1) * gaussian)
    )
    return gaussian / gaussian.sum(), edge, point


def _filter(pictures: F32, down: NDArray[np.float64], across: NDArray[np.float64]) -> F32:
    """Correlate (n, H, W) with a kernel along each axis, edges repeated: (n, H, W)."""
    for axis, kernel in ((1, down), (2, across)):
        margin = [(0, 0), (0, 0), (0, 0)]
        margin[axis] = (len(kernel) // 2, len(kernel) // 2)
        shifted = np.lib.stride_tricks.sliding_window_view(np.pad(pictures, margin, "edge"), len(kernel), axis)
        pictures = np.zeros_like(pictures)
        for offset, weight in enumerate(kernel):
            pictures += np.float32(weight) * shifted[..., offset]
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
