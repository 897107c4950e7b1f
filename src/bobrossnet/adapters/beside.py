"""Files named by a model, and which of them may be read.

Models may be untrusted, and their files go into scenes and pages that are passed on. So a name can only lead to regular
files in the model's folder and below it, wherever links point.
"""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path, PurePath

from bobrossnet.support.errors import InputError
from bobrossnet.support.paths import MAX_BYTES
from bobrossnet.support.threads import lazy


def find_beside(model: Path, name: str) -> str:
    """Resolve the path of a file named by a model.

    Raises
    ------
    InputError
        If the name leads out of the model's folder, to no file, or to anything but a regular file.
    """
    path = PurePath(name)
    try:
        # Checked before any access: for //server/name, Windows would contact that server and log in.
        # A backslash is part of a name here, but a separator of folders in OpenCascade.
        if not path.anchor and ".." not in path.parts and "\\" not in name:
            folder = os.path.realpath(model.parent)
            target = os.path.realpath(os.path.join(folder, name))
            if os.path.commonpath([folder, target]) == folder and os.path.isfile(target):
                return target
    except (OSError, ValueError):  # no permission, a name too long, a NUL
        pass
    raise InputError(f"expected its data in a file in or below its folder, found no such file: {name[:100]}")


class Beside:
    """Reads files named by a model.

    Parameters
    ----------
    model : path of the model
    """

    def __init__(self, model: Path) -> None:
        self.model = model
        self.left = MAX_BYTES

    def read(self, name: str) -> bytes:
        """Read a file. If its path leads to none, read that of the same name next to the model, in upper or lower case.

        Raises
        ------
        InputError
            If it is missing, or if the files of the model exceed `MAX_BYTES` together.
        """
        target = self._find(name)
        try:
            with open(target, "rb", opener=_opened) as file:
                size = os.fstat(file.fileno()).st_size
                self.left -= size
                if self.left < 0:
                    raise InputError(
                        f"expected files of at most {MAX_BYTES:,} bytes next to it, got more in {name[:100]}"
                    )
                return file.read(size)  # empty for a pipe and for files in /proc
        except OSError as error:
            raise InputError(f"expected its data in {name[:100]}, can't read it: {error.strerror}") from error

    def _find(self, name: str) -> str:
        try:
            return find_beside(self.model, name)
        except InputError:  # a path from another machine, perhaps under Windows
            last = name.replace("\\", "/").rpartition("/")[2]
            for own in (last, self._names.get(last.lower(), last)):
                with suppress(InputError):
                    return find_beside(self.model, own)
            raise

    @lazy
    def _names(self) -> dict[str, str]:
        """Names in the model's folder by their lower case."""
        with suppress(OSError):
            return {name.lower(): name for name in os.listdir(self.model.parent)}
        return {}


def _opened(path: str, flags: int) -> int:
    """Open a file without blocking, even if it has become a pipe or a link in the meantime."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0))
