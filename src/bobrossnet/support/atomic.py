"""Atomic writes: files are written whole or not at all."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterable
from pathlib import Path

from bobrossnet.support.errors import InputError
from bobrossnet.support.paths import path_of

PATIENCE = 1.0
"""Seconds to wait for programs that have the replaced file open."""


def check_writable(path: str | os.PathLike[str], what: str = "", endings: Iterable[str] = ()) -> Path:
    """Return `path` if a file can be written there; checked before any time is spent on the content.

    Parameters
    ----------
    path : str or path
    what : str
        Kind of content, such as "a picture"; if empty, any ending is allowed.
    endings : iterable of str
        Endings of its formats, in lower case.

    Raises
    ------
    InputError
        If the ending is not listed, the path is a folder or a device, its name is too long, or its folder does not
        exist or is read-only.
    """
    path = path_of(path)
    if what and path.suffix.lower() not in (known := [*endings]):
        raise InputError(f"{path}: expected {what}'s ending ({' '.join(known)}), got {path.suffix or 'none'}")
    place = _place(path)
    if not place.parent.is_dir():
        raise InputError(f"{path}: can't write it: there is no folder {place.parent}")
    if not os.access(place.parent, os.W_OK):
        raise InputError(f"{path}: can't write it: the folder {place.parent} is read-only")
    return path


def check_folder(path: str | os.PathLike[str], name: str) -> Path:
    """Return `path` if it is a folder or can become one.

    Raises
    ------
    InputError
        If a file is in its place, or it can't be written to.
    """
    folder = path_of(path, name)
    there = next((place for place in (folder, *folder.parents) if place.exists()), None)
    if there is not None and not there.is_dir():
        raise InputError(f"{name}: expected a folder to write to, got {folder}, where {there} is a file")
    if there is not None and not os.access(there, os.W_OK):
        raise InputError(f"{name}: expected a folder to write to, got {folder}, where {there} is read-only")
    return folder


def write_whole(path: str | os.PathLike[str], content: bytes) -> None:
    """Write a temporary file in the same folder, then move it into place.

    Readers of `path` in the meantime, or after an interrupt, find the old content. A link is kept, and its target is
    written.

    Raises
    ------
    InputError
        If the folder does not exist or can't be written to.
    """
    path = path_of(path)
    place = _place(path)
    temporary = place.with_name(f".bobrossnet-{os.urandom(8).hex()}")  # the name may already be at the limit
    try:
        try:
            with temporary.open("xb") as file:
                file.write(content)
            replace(temporary, place)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(f"{path}: can't write it: {error.strerror}") from error


def replace(temporary: Path, place: Path) -> None:
    """Move a file over another. Windows refuses while a program has it open, as virus scanners briefly do.

    Raises
    ------
    InputError
        If a program keeps the file open.
    OSError
        If the move fails for another reason.
    """
    until = time.monotonic() + PATIENCE
    while True:
        try:
            temporary.replace(place)
            return
        except PermissionError as error:
            if sys.platform != "win32":
                raise
            if time.monotonic() > until:
                raise InputError(f"{place}: can't write it: another program has it open; close it there") from error
        time.sleep(0.02)


def _place(path: Path) -> Path:
    """Return the path with links resolved, of a file that may not exist yet."""
    place = path  # a deleted working folder has no real path
    try:
        place = Path(os.path.realpath(path))
        place.lstat()
    except (FileNotFoundError, NotADirectoryError):
        return place
    except OSError as error:  # a name that is too long
        raise InputError(f"{path}: can't write it: {error.strerror}") from error
    except ValueError as error:  # a NUL in the name
        raise InputError(f"path: can't write to {str(path)!a:.100}: {error}") from error
    if not place.is_file():
        what = "folder" if place.is_dir() else "link to itself" if place.is_symlink() else "device"
        raise InputError(f"{path}: expected a file to write, got a {what}")
    return place
