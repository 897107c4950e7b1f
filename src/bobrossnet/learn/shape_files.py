"""Which files of a folder hold shapes, and a few of many."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

from bobrossnet.adapters import files
from bobrossnet.support.errors import InputWarning, check_integer

Item = TypeVar("Item")

BROKEN = "broken_odd"  # a folder of files that are wrong on purpose


def shape_files(place: str | os.PathLike[str]) -> list[Path]:
    """Return `adapters.files.shape_files` without those in a folder named `broken_odd` below the place."""
    base = Path(place)
    return [path for path in files.shape_files(base) if BROKEN not in path.relative_to(base).parts]


def spread(items: Sequence[Item], limit: int | None) -> Sequence[Item]:
    """Return at most `limit` items, evenly spread; all without it."""
    if limit is None or check_integer("limit", limit, 1, 2**31 - 1) >= len(items):
        return items
    return [items[i * (len(items) - 1) // max(limit - 1, 1)] for i in range(limit)]


def left_out(error: object, stacklevel: int) -> None:
    """Warn that a file is left out because of an error; `stacklevel` as of `warnings.warn`, called in its place."""
    warnings.warn(f"left out: {error}", InputWarning, stacklevel=stacklevel + 1)
