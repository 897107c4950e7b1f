"""Colours: parsing, the sRGB transfer function, and luminance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.support.errors import InputError, InputTypeError, brief, check_number

Color: TypeAlias = str | Sequence[float]
"""sRGB as "#rrggbb", "#rgb" or a CSS color name, or three numbers of linear RGB, 0..1."""

LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Rec. 709 luminance weights of linear red, green and blue."""


def from_srgb(values: Any) -> NDArray[np.float64]:
    """Decode sRGB values in 0..1 to linear values in 0..1 (IEC 61966-2-1)."""
    values = np.asarray(values, np.float64)
    linear: NDArray[np.float64] = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    return linear


def from_8_bit(values: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Decode sRGB values in 0..255 to linear values in 0..1, of the same shape."""
    linear: NDArray[np.float32] = from_srgb(np.arange(256) / 255).astype(np.float32)[values]
    return linear


def to_srgb(values: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
    """Encode linear values as sRGB, clamped to 0..1; the inverse of `from_srgb`."""
    values = np.clip(values, 0, 1, dtype=np.float32)
    return np.where(values <= 0.0031308, 12.92 * values, 1.055 * values ** np.float32(1 / 2.4) - 0.055)


def hex_color(rgb: Any) -> str:
    """Return linear RGB as "#rrggbb"."""
    red, green, blue = np.rint(255 * to_srgb(np.asarray(rgb, np.float32))).astype(int).tolist()
    return f"#{red:02x}{green:02x}{blue:02x}"


def luminance(rgb: Any) -> NDArray[Any]:
    """Return the luminance of linear RGB, (..., 3); bit-identical for every array shape, unlike a library's sum."""
    values = np.asarray(rgb)
    red, green, blue = np.array(LUMINANCE, values.dtype)
    sums: NDArray[Any] = red * values[..., 0] + green * values[..., 1] + blue * values[..., 2]
    return sums


def linear(name: str, color: Color) -> tuple[float, float, float]:
    """Convert a user's colour to linear RGB; `name` is the argument's name in error messages."""
    if isinstance(color, str):
        rgb = _core.linear_color(color) if color.isascii() else None
        if rgb is None:
            raise InputError(f"{name}: expected #rrggbb, a CSS name or 3 numbers, got {brief(color, of_type=False)}")
        return rgb[0], rgb[1], rgb[2]
    try:
        red, green, blue = color
    except Exception:
        raise InputTypeError(
            f"{name}: expected #rrggbb, a CSS name or 3 numbers, got {brief(color, of_type=False)}"
        ) from None
    return check_number(name, red, 0, 1), check_number(name, green, 0, 1), check_number(name, blue, 0, 1)
