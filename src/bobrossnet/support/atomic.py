"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterable
from pathlib import Path

from bobrossnet.support.errors import InputError
from bobrossnet.support.paths import path_of

PATIENCE = 1.0
"""Seconds for which a program may have a file open that is replaced."""


def check_writable(path: str | os.PathLike[str], what: str = "", endings: Iterable[str] = ()) -> Path:
    """Return `path` if a file can be written there, before time is spent on its content.

    Parameters
    ----------
    path : str or path
    what, endings
        What is written, such as "a picture", and the endings that its formats have, in lower case; any without `what`.

    Raises
    ------
    InputError
        If its ending is another, it is a folder or a device, its name is too long, or its folder does not exist or is
        read-only.
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


def write_whole(path: str | os.PathLike[str], content: bytes) -> None:
    """Write a file under another name beside its place, then move it there.

    Anyone who reads `path` in the meantime, or after an interruption, finds the old content. A link stays one: what it
    points to is written.

    Raises
    ------
    InputError
        If the folder does not exist or can't be written to.
    """
    path = path_of(path)
    place = _place(path)
    temporary = place.with_name(f".bobrossnet-{os.urandom(8).hex()}")  # the file's own may be as long as names can be
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
    """Move a file over another. Windows refuses while a program has that open, as scanners of viruses have for moments.

    Raises
    ------
    InputError
        If a program keeps it open.
    OSError
        If it can't be moved for another reason.
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
    """Where the file really lies or is to lie."""
    place = path  # a working folder that was removed has no real path
    try:
        place = Path(os.path.realpath(path))
        place.lstat()
    except (FileNotFoundError, NotADirectoryError):
        return place
    except OSError as error:  # a name too long
        raise InputError(f"{path}: can't write it: {error.strerror}") from error
    except ValueError as error:  # a NUL in it
        raise InputError(f"path: can't write to {str(path)!a:.100}: {error}") from error
    if not place.is_file():
        what = "folder" if place.is_dir() else "link to itself" if place.is_symlink() else "device"
        raise InputError(f"{path}: expected a file to write, got a {what}")
    return place
