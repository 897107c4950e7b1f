"""Files that belong to a model: which of those that it names may be read.

A model can come from a stranger, and what is read for it goes into scenes and pages that are passed on. So a name leads
only to regular files in the model's own folder and below it, wherever links point.
"""

from __future__ import annotations

import os
from pathlib import Path, PurePath

from bobrossnet.support.errors import InputError
from bobrossnet.support.paths import MAX_BYTES


def find_beside(model: Path, name: str) -> str:
    """The real path of a file that a model names.

    Raises
    ------
    InputError
        If the name leads out of the model's folder, to anything but a regular file, or nowhere.
    """
    path = PurePath(name)
    try:
        # Judged before the disk is asked: of //server/name, Windows would ask that server, and log in there.
        # A backslash is part of a name here, but to OpenCascade it separates folders.
        if not path.anchor and ".." not in path.parts and "\\" not in name:
            folder = os.path.realpath(model.parent)
            target = os.path.realpath(os.path.join(folder, name))
            if os.path.commonpath([folder, target]) == folder and os.path.isfile(target):
                return target
    except (OSError, ValueError):  # no permission, a name too long, a NUL in it
        pass
    raise InputError(f"expected its data in a file in or below its folder, found no such file: {name[:100]}")


class Beside:
    """Reads the files that a model names.

    Parameters
    ----------
    model : path of the model
    """

    def __init__(self, model: Path) -> None:
        self.model = model
        self.left = MAX_BYTES

    def read(self, name: str) -> bytes:
        """What a file holds.

        Raises
        ------
        InputError
            If it can't be found, or if the files of the model are larger than `MAX_BYTES` together.
        """
        target = find_beside(self.model, name)
        try:
            with open(target, "rb", opener=_opened) as file:
                size = os.fstat(file.fileno()).st_size
                self.left -= size
                if self.left < 0:
                    raise InputError(
                        f"expected files of at most {MAX_BYTES:,} bytes next to it, got more in {name[:100]}"
                    )
                return file.read(size)  # which is nothing of a pipe, and of what the system makes up in /proc
        except OSError as error:
            raise InputError(f"expected its data in {name[:100]}, can't read it: {error.strerror}") from error


def _opened(path: str, flags: int) -> int:
    """Open a file without a wait for whoever writes to it, should it have become a pipe or a link in the meantime."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0))
