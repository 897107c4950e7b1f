"""The folders that an agent may read and write, the last picture it has seen, and parts by their names."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from bobrossnet.adapters.files import load
from bobrossnet.adapters.script import shape_of_script
from bobrossnet.measuring.picking import Pick, pick
from bobrossnet.picture.camera import Camera
from bobrossnet.picture.order import Size
from bobrossnet.support.errors import InputError, InputWarning
from bobrossnet.support.messages import one_line
from bobrossnet.support.paths import path_of
from bobrossnet.tracing.instance import Instance
from bobrossnet.tracing.parts import HIGHLIGHT, faces_colored
from bobrossnet.tracing.scene import Scene

MAX_SIDE = 2048
"""Pixels of a picture's longer side: more is lost on models that see."""

MAX_KEPT = 2
"""Files kept in memory: an agent compares one with another."""

MAX_ENTRIES = 2000
"""Maximum number of a folder's entries whose times are compared, to see whether a file has changed."""


@dataclass(frozen=True)
class LookedAt:
    """A view of a scene, and its place in a picture."""

    scene: Scene
    camera: Camera
    left: int
    top: int
    size: Size


@dataclass(frozen=True)
class Look:
    """A picture of one view or several, whose pixels can be picked."""

    size: Size
    views: tuple[LookedAt, ...]

    def pick(self, row: int, column: int, snap: float = 0) -> Pick | None:
        """Return the surface at a pixel, snapped as in `bobrossnet.pick`; None at the background."""
        height, width = self.size
        if not (0 <= row < height and 0 <= column < width):
            raise InputError(f"row, column: expected a pixel of {width}x{height}, got {row}, {column}")
        for view in self.views:
            own = row - view.top, column - view.left
            if 0 <= own[0] < view.size[0] and 0 <= own[1] < view.size[1]:
                return pick(view.scene, *own, view.camera, size=view.size, snap=snap)
        return None


def highlighted(scene: Scene, names: Sequence[str]) -> Scene:
    """Return the scene with some parts, or some triangles or faces "PART#NUMBER", in a colour that stands out."""
    parts, faces, known = [], [], {text for part in scene.parts.walk() for text in (part.name, str(part))}
    for name in names:
        part, sign, number = name.rpartition("#")
        if sign and number.isdecimal() and name not in known:
            faces.append(scene.part(part).primitive(int(number)))
        else:
            parts.append(scene.part(name))
    scene = faces_colored(scene, faces, HIGHLIGHT)
    return scene.highlight(*(part.path for part in parts)) if parts else scene


def check_folders(folders: Sequence[str | os.PathLike[str]]) -> list[Path]:
    """Return the real paths of folders; raise InputError if one of them is no folder."""
    paths = [Path(os.path.realpath(path_of(folder, "folder"))) for folder in folders]
    for path in paths:
        if not path.is_dir():
            raise InputError(f"{path}: expected a folder, got none")
    return paths


class Workspace:
    """Files below some folders.

    Parameters
    ----------
    folders : sequence of paths
        An agent may only use paths below these folders, after all links are followed.
    """

    def __init__(self, folders: Sequence[str | os.PathLike[str]]) -> None:
        self.folders = check_folders(folders)
        self.last: Look | None = None
        self._read: dict[tuple[Any, ...], tuple[Scene, list[str]]] = {}

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
        if script is not None:
            return _with_warnings(
                lambda: Scene(Instance(shape_of_script(script.encode("utf-8", "replace")), name="script"))
            )
        if file is not None and file.startswith("sample:"):
            return _with_warnings(lambda: load(file, up=up))
        path = self.path(file or "")
        key = (path, up, _state(path))
        if key not in self._read:  # readers of CAD files take a second or two to start
            found = _with_warnings(lambda: load(path, up=up))
            while len(self._read) >= MAX_KEPT:
                del self._read[next(iter(self._read))]
            self._read[key] = found
        return self._read[key]


def _state(path: Path) -> tuple[Any, ...]:
    """Return a value that changes with the file or its folder, which may hold its textures."""
    try:
        with os.scandir(path.parent) as entries:
            stats = [(entry.name, entry.stat()) for entry in islice(entries, MAX_ENTRIES)]
    except OSError:
        return (object(),)  # equal to no other
    return tuple(sorted((name, stat.st_mtime_ns, stat.st_size) for name, stat in stats))


def _with_warnings(made: Callable[[], Scene]) -> tuple[Scene, list[str]]:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", InputWarning)
        scene = made()
    return scene, [str(each.message) for each in told if isinstance(each.message, InputWarning)]
