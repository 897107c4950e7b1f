"""Shape files of a folder, and an evenly spread subset of them."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

from bobrossnet.adapters import files
from bobrossnet.learn.checks import MAX_COUNT
from bobrossnet.support.errors import InputWarning, check_integer

Item = TypeVar("Item")

BROKEN = "broken_odd"  # a folder of deliberately broken files


def shape_files(place: str | os.PathLike[str]) -> list[Path]:
    """Return `adapters.files.shape_files` without the files in subfolders named `broken_odd`."""
    base = Path(place)
    return [path for path in files.shape_files(base) if BROKEN not in path.relative_to(base).parts]


def spread(items: Sequence[Item], limit: int | None) -> Sequence[Item]:
    """Return at most `limit` items, evenly spread; all items if None."""
    if limit is None or check_integer("limit", limit, 1, MAX_COUNT) >= len(items):
        return items
    return [items[i * (len(items) - 1) // max(limit - 1, 1)] for i in range(limit)]


def left_out(error: object, stacklevel: int) -> None:
    """Warn that a file is omitted because of an error; `stacklevel` as in `warnings.warn`, called from here."""
    warnings.warn(f"left out: {error}", InputWarning, stacklevel=stacklevel + 1)
