"""Paths of files, as the doors of the package take them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, TypeGuard

from bobrossnet.support.errors import InputError, InputTypeError

PACKAGE = Path(__file__).parents[1]
VIEWER = (PACKAGE if (PACKAGE / "viewer/index.html").is_file() else PACKAGE.parents[1]) / "viewer"
"""The folder of the page and its gallery: in the package, or beside src where the package is editable."""

MAX_BYTES = 1 << 32
"""Of a file, and of all files that it names, together; the largest chunk that a GLB can have."""


def is_path(value: Any) -> TypeGuard[str | bytes | os.PathLike[Any]]:
    """Whether it is of a type that names files."""
    return isinstance(value, str | bytes | os.PathLike)


def path_of(value: Any, name: str = "path") -> Path:
    """Return a path from a str, bytes or path. `~` is the home folder, unless there is a file of the literal name."""
    if not is_path(value):
        raise InputTypeError(f"{name}: expected a file name, got {type(value).__name__}")
    try:
        path = os.fsdecode(value)
        os.fsencode(path)
    except (TypeError, ValueError):  # half of a character, or a path object that is none
        raise InputError(f"{name}: expected a file name, got {value!a:.100}") from None
    if path.startswith("~") and not os.path.lexists(path):
        path = os.path.expanduser(path)
    return Path(path)


def check_file(file: Path) -> None:
    """Refuse anything but a file that can be read as a whole.

    A pipe, for example, could keep its reader waiting for ever.
    """
    try:
        if not file.exists():
            raise InputError(f"expected a file, found nothing at {file}")
        if not file.is_file():
            raise InputError(f"expected a file, got a {'folder' if file.is_dir() else 'device'}")
        size = file.stat().st_size
        if size > MAX_BYTES:
            raise InputError(f"expected a file of at most {MAX_BYTES:,} bytes, got {size:,}")
    except InputError:
        raise
    except (OSError, ValueError) as error:  # a name too long, a NUL in it, no permission
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"expected a file, could not open it ({reason})") from error
