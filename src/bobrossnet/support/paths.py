"""Checks of file paths from users."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, TypeGuard

from bobrossnet.support.errors import InputError, InputTypeError

PACKAGE = Path(__file__).parents[1]
VIEWER = (PACKAGE if (PACKAGE / "viewer/index.html").is_file() else PACKAGE.parents[1]) / "viewer"
"""The folder of the page and its gallery: in the package, or next to src if the package is editable."""

MAX_BYTES = 1 << 32
"""Maximum bytes of a file together with all files it refers to; the largest chunk of a GLB."""


def is_path(value: Any) -> TypeGuard[str | bytes | os.PathLike[Any]]:
    """Return whether the value has a type of paths."""
    return isinstance(value, str | bytes | os.PathLike)


def path_of(value: Any, name: str = "path") -> Path:
    """Return a path from a str, bytes or path. `~` is the home folder, unless there is a file of the literal name."""
    if not is_path(value):
        raise InputTypeError(f"{name}: expected a file name, got {type(value).__name__}")
    try:
        path = os.fsdecode(value)
        os.fsencode(path)
        if not path:  # which would be the current folder
            raise ValueError
    except (TypeError, ValueError):  # an empty name, lone surrogates, or a broken path object
        raise InputError(f"{name}: expected a file name, got {value!a:.100}") from None
    if path.startswith("~") and not os.path.lexists(path):
        path = os.path.expanduser(path)
    return Path(path)


def check_file(file: Path) -> None:
    """Raise InputError unless the path is a regular file.

    A pipe, for example, could block its reader forever.
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
    except (OSError, ValueError) as error:  # name too long, NUL in the name, no permission
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"expected a file, could not open it ({reason})") from error
