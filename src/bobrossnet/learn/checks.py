"""Checks of arguments that need no library of learning, whose imports take seconds."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from bobrossnet.metrics import WINDOW
from bobrossnet.picture.order import Size, SizeLike, check_order, check_size
from bobrossnet.support.atomic import check_writable
from bobrossnet.support.errors import InputError

BUILD = "bobrossnet dataset build"

INDEX = "zarr.json"
"""The index of a data set, in its folder."""

MAX_SHAPES = 1_000_000

MAX_SEED = 2**32 - 1

MAX_VIEWS = 1000
"""Maximum number of pictures of a file."""

MAX_COUNT = 2**31 - 1

MAX_FRAMES = 10_000

FIGURE_NAMES = ("2.1", "4.1", "4.2", "4.3", "5.1", "5.2", "6.1", "6.2", "6.3", "6.4", "stability")
"""Figures in the report's order, by number; then further ones, by name."""


def is_dataset(place: str | os.PathLike[str]) -> bool:
    """Return whether a folder has the index of a data set."""
    return (Path(place) / INDEX).exists()


def check_dataset(place: str | os.PathLike[str]) -> None:
    """Raise InputError unless a folder has the index of a data set."""
    if not is_dataset(place):
        raise InputError(f"{place}: expected a data set, got none; {BUILD} makes one")


def check_weights_path(path: str | os.PathLike[str]) -> Path:
    """Return `path` if a weight file can be written there."""
    return check_writable(path, "a weight file", [".safetensors"])


def check_measured(size: SizeLike) -> Size:
    """Return the size of pictures that are measured; raise InputError if the SSIM window does not fit."""
    height, width = check_size(size)
    if min(height, width) < WINDOW:
        raise InputError(f"size: expected at least {WINDOW}x{WINDOW} pixels, the SSIM window, got {width}x{height}")
    return height, width


def check_figures(only: Sequence[str] | None) -> list[str]:
    """Return the names of the requested figures, all if `only` is None, in the order of `FIGURE_NAMES`.

    Raises
    ------
    InputError
        If a name is unknown.
    """
    for name in only or ():
        if name not in FIGURE_NAMES:
            raise InputError(f"only: expected some of {', '.join(FIGURE_NAMES)}, got {name!r}")
    return [name for name in FIGURE_NAMES if only is None or name in only]


def check_orders(orders: Sequence[str]) -> tuple[str, ...]:
    """Return the names of pixel orders if there is at least one, and all are known and different."""
    names = tuple(check_order(order, 0) for order in orders)
    if not names or len(set(names)) < len(names):
        raise InputError(f"orders: expected one or more, each once, got {', '.join(orders) or 'none'}")
    return names
