"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from bobrossnet.errors import InputError


def check_writable(path: str | os.PathLike[str]) -> Path:
    """Return `path` if a file can be written there, before time is spent on its content.

    Raises
    ------
    InputError
        If it is a folder, or its folder does not exist or is read-only.
    """
    path = Path(path)
    if path.is_dir():
        raise InputError(f"{path}: expected a file to write, got a folder")
    if not path.parent.is_dir():
        raise InputError(f"{path}: can't write it: there is no folder {path.parent}")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: can't write it: the folder {path.parent} is read-only")
    return path


def write_whole(path: str | os.PathLike[str], content: bytes) -> None:
    """Write a file under another name beside its place, then move it there.

    Anyone who reads `path` in the meantime, or after an interruption, finds the old content.

    Raises
    ------
    InputError
        If the folder does not exist or can't be written to.
    """
    path = Path(path)
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise InputError(f"{path}: can't write it: {error.strerror}") from error
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(temporary, 0o666 & ~umask)  # mkstemp's files are private
        os.replace(temporary, path)
    except OSError as error:
        os.unlink(temporary)
        raise InputError(f"{path}: can't write it: {error.strerror}") from error
    except BaseException:
        os.unlink(temporary)
        raise
