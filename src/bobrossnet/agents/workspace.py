"""The folders that an agent may read and write, and the last picture it has seen."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from bobrossnet.adapters.files import load
from bobrossnet.adapters.script import shape_of_script
from bobrossnet.measuring.picking import Pick, pick
from bobrossnet.picture.camera import Camera
from bobrossnet.support.errors import InputError, InputWarning
from bobrossnet.support.messages import one_line
from bobrossnet.tracing.instance import Instance
from bobrossnet.tracing.scene import Scene

MAX_SIDE = 2048
"""Pixels of a picture's longer side: more is lost on models that see."""


@dataclass(frozen=True)
class Look:
    """A picture of one view, whose pixels can be picked."""

    scene: Scene
    camera: Camera
    size: tuple[int, int]

    def pick(self, row: int, column: int) -> Pick | None:
        """The surface at a pixel; None where there is none."""
        height, width = self.size
        if not (0 <= row < height and 0 <= column < width):
            raise InputError(f"row, column: expected a pixel of {width}x{height}, got {row}, {column}")
        return pick(self.scene, row, column, self.camera, size=self.size)


class Workspace:
    """Files below some folders.

    Parameters
    ----------
    folders : sequence of paths
        Every path of an agent leads below one of these, after all links are followed.
    """

    def __init__(self, folders: Sequence[str | os.PathLike[str]]) -> None:
        self.folders = [Path(os.path.realpath(folder)) for folder in folders]
        for folder in self.folders:
            if not folder.is_dir():
                raise InputError(f"{folder}: expected a folder, got none")
        self.last: Look | None = None

    def path(self, name: str) -> Path:
        """The real path of a file, relative to the first folder.

        Raises
        ------
        InputError
            If it lies elsewhere.
        """
        try:
            path = Path(os.path.realpath(self.folders[0] / name))
        except ValueError:
            raise InputError(f"file: expected a file name, got {name!a:.100}") from None
        if not any(path.is_relative_to(folder) for folder in self.folders):
            allowed = ", ".join(map(str, self.folders))
            raise InputError(f"file: expected a path below {allowed}, got {one_line(name)}")
        return path

    def scene(self, file: str | None, script: str | None, up: str = "z") -> tuple[Scene, list[str]]:
        """The scene of a file or of the text of a script, and its warnings."""
        if (file is None) == (script is None):
            raise InputError("file, script: expected one of them")
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", InputWarning)
            if script is not None:
                scene = Scene(Instance(shape_of_script(script.encode("utf-8", "replace")), name="script"))
            elif file is not None and file.startswith("sample:"):
                scene = load(file, up=up)
            else:
                scene = load(self.path(file or ""), up=up)
        return scene, [str(each.message) for each in told if isinstance(each.message, InputWarning)]
