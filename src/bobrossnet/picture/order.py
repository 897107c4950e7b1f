"""Pixel orders: sequences of an image's pixels for tracing."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.support.errors import (
    InputError,
    InputTypeError,
    brief,
    check_array,
    check_choice,
    check_integer,
    check_number,
)

Size: TypeAlias = tuple[int, int]
SizeLike: TypeAlias = Size | str
"""(height, width), or the text "WIDTHxHEIGHT"."""

MAX_PIXELS = 2**28
"""Maximum number of pixels, 16384 x 16384: the five float32 planes take 5.4 GB."""

FIXED_ORDERS = ("uniform", "lattice")
"""Orders that depend on the seed and the size alone."""

ADAPTIVE = "adaptive"
"""Name of the order that refines where traced pixels differ."""

SQUARES = "squares"
"""Name of the adaptive order for cheap rays: it subdivides squares of unequal pixels row by row, without the seed."""

PRIORITY = "priority"
"""Name of the variant of `SQUARES` that weights differences by area and starts with larger squares."""

ORDERS_BY_SIGHT = (ADAPTIVE, SQUARES, PRIORITY)
"""Orders that depend on the traced values."""

ORDERS = (*FIXED_ORDERS, *ORDERS_BY_SIGHT)

MAX_SEED = 2**64 - 1

DEFAULT_ORDER = ADAPTIVE
"""The order of the name "default", except in `trace`."""


def pixel_order(
    size: SizeLike, *, order: str = "lattice", seed: int = 0, start: int = 0, count: int | None = None
) -> NDArray[np.int32]:
    """Return pixels in an order that does not depend on traced values.

    Each order visits every pixel once, is a function of (seed, size) alone, and is nested: the first 5 % of the pixels
    are a prefix of the first 25 %.

    Parameters
    ----------
    size : (height, width) or "WIDTHxHEIGHT"
    order : "uniform" or "lattice"
        "uniform": at random, all sequences equally likely. "lattice": square lattices of a tile of 64 x 64 pixels,
        each half of the next, for smaller gaps; the seed does not move them.
    seed : int, 0..2**64 - 1
    start, count : int
        Part of the sequence; by default all of it.

    Returns
    -------
    (count, 2) int32, row and column
    """
    height, width = check_size(size)
    if check_order(order, seed) in ORDERS_BY_SIGHT:
        raise InputError(
            f"order: expected one that is known before anything is traced, {', '.join(FIXED_ORDERS)}, got {order!r}; "
            "trace, progressive and GBuffer.sample follow that"
        )
    total = height * width
    start = check_integer("start", start, 0, total)
    count = total - start if count is None else check_integer("count", count, 0, total - start)
    pixels = np.empty((count, 2), np.int32)
    _core.pixel_order(order, int(seed), height, width, start, pixels)
    return pixels


def check_size(size: Any) -> Size:
    """Return a valid image size as ints (height, width), also from a text such as "640x480"."""
    if isinstance(size, str):
        across, _, down = size.lower().partition("x")
        if not (across.isdecimal() and down.isdecimal()):
            raise InputError(f"size: expected WIDTHxHEIGHT such as 640x480, got {brief(size, of_type=False)}")
        if len(across) + len(down) > 100:  # beyond Python's limit of digits
            raise InputError(f"size: expected at most {MAX_PIXELS} pixels, got {brief(size, of_type=False)}")
        size = (int(down), int(across))
    try:
        height, width = size
    except Exception:
        raise InputTypeError(f'size: expected (height, width) or "WIDTHxHEIGHT", got {brief(size)}') from None
    height, width = (
        check_integer("height", height, 1, MAX_PIXELS),
        check_integer("width", width, 1, MAX_PIXELS),
    )
    if height * width > MAX_PIXELS:
        raise InputError(f"size: expected at most {MAX_PIXELS} pixels, got {height} x {width} = {height * width}")
    return height, width


def check_pixels(pixels: Any) -> NDArray[np.int32]:
    """Return rows and columns, (n, 2), in the core's dtype."""
    array = check_array("pixels", pixels, (None, 2))
    if array.dtype.kind not in "iu":
        raise InputTypeError(f"pixels: expected integers, a row and a column each, got dtype {array.dtype}")
    if not np.can_cast(array.dtype, np.int32):
        array = array.clip(None if array.dtype.kind == "u" else -1, MAX_PIXELS)  # outside stays outside
    return np.ascontiguousarray(array, np.int32)


def check_order(order: Any, seed: Any) -> str:
    """Return the name of an order, with "default" resolved; raise InputError for an unknown order or invalid seed."""
    check_choice("order", order, (*ORDERS, "default"))
    check_integer("seed", seed, 0, MAX_SEED)
    return DEFAULT_ORDER if order == "default" else str(order)


def pixel_count(fraction: Any, size: Size, name: str = "fraction") -> int:
    """Return the number of pixels of a fraction in (0, 1] of an image: the nearest integer, at least one."""
    number = fraction.rstrip(" %") if isinstance(fraction, str) else fraction
    try:
        percent = float(number)
    except (TypeError, ValueError, OverflowError):
        percent = 0
    hint = f"{percent:g} % is {percent / 100:g}" if 1 < percent <= 100 else ""
    return max(1, round(check_number(name, fraction, 0, 1, above=True, hint=hint) * size[0] * size[1]))
