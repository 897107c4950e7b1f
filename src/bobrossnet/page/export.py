"""Writes the viewer's page to a folder, for any server."""

from __future__ import annotations

import shutil
from pathlib import Path

from bobrossnet.errors import InputError
from bobrossnet.page.files import Files


def export(files: Files, folder: Path) -> None:
    """Write the page to a folder, which any static server can show.

    Raises
    ------
    InputError
        If that can't be written.
    """
    try:
        for path, content in files.items():
            target = folder / path
            target.parent.mkdir(parents=True, exist_ok=True)
            if isinstance(content, bytes):
                target.write_bytes(content)
            else:
                shutil.copyfile(content, target)
    except OSError as error:
        raise InputError(f"{folder}: can't write the page there: {error.strerror}") from error
