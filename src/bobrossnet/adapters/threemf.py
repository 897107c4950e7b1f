"""3MF: a zip file of XML; objects, where they are built, and the colours of their triangles.

It is read here because trimesh 5.2 needs lxml and networkx for it, and walks every path through the
components, of which a file of a few lines can have 2ⁿ.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.part import Part, counted, placed
from bobrossnet.adapters.xml import read_xml
from bobrossnet.color import linear
from bobrossnet.errors import InputError

MAX_INSTANCES = 100_000

Key: TypeAlias = tuple[str, str]
"""The model file that an object is in, and its id there."""

Swatch: TypeAlias = tuple[str, str]
"""The id of a group of colours, and the number of one of these."""


class Instance(NamedTuple):
    key: Key
    matrix: NDArray[np.float64]  # (4, 4), multiplied from the left


class Object(NamedTuple):
    part: Part
    components: list[Instance]


def read_3mf(file: Path) -> list[Part]:
    """The meshes of what a 3MF builds, each where it is built.

    Raises
    ------
    InputError
        If there is no model in it, one that unpacks without end, an object that is missing, or too many.
    """
    from zipfile import BadZipFile

    try:
        return _read_parts(file)
    except (BadZipFile, zlib.error, OSError, EOFError, NotImplementedError) as error:
        raise InputError(f"expected a zip file that can be unpacked, got another ({error})") from error


def _read_parts(file: Path) -> list[Part]:
    from zipfile import ZipFile

    objects: dict[Key, Object] = {}
    items: list[Instance] = []
    with ZipFile(file) as archive:
        models = [info for info in archive.infolist() if info.filename.lower().endswith(".model")]
        unpacked = sum(info.file_size for info in models)
        # Coordinates shrink to a third or a tenth of their text; only a bomb shrinks to a hundredth.
        if unpacked > 1 << 26 and unpacked > 100 * file.stat().st_size:
            raise InputError(f"expected a 3MF model, got a zip file that unpacks to {unpacked:,} bytes")
        for info in models:
            with archive.open(info) as stream:
                items += _read_model(stream, info.filename.lower().strip("/"), objects)
    if not models:
        raise InputError("expected a 3MF with a 3D/3dmodel.model in it, got none")

    # What is built is placed; whatever it is made of is placed relative to it.
    parts: list[Part] = []
    visited = total = 0
    while items:
        key, matrix = items.pop()
        found = objects.get(key)
        if found is None:
            raise InputError(f"expected an object with id {key[1]}, found none")
        visited += 1
        if visited > MAX_INSTANCES:
            raise InputError("expected finitely many components, got too many; does one hold itself?")
        total = counted(total, len(found.part.triangles) + len(found.part.vertices))
        if len(found.part.vertices):
            parts.append(placed(found.part, matrix))
        items += [Instance(child, matrix @ relative) for child, relative in found.components]
    return parts


def _read_model(stream: IO[bytes], model: str, objects: dict[Key, Object]) -> list[Instance]:
    """Collect the objects of one model file into `objects`; return what it builds."""
    items: list[Instance] = []
    points: list[list[str]] = []
    corners: list[list[str]] = []
    components: list[Instance] = []
    ids: list[str] = []
    palette = _Palette()
    chosen: list[tuple[Swatch, ...]] = []  # of each triangle's corners
    of_object: list[Swatch] = []

    def start(name: str, get: dict[str, str]) -> None:
        kind = _local(name)
        if kind == "vertex":
            points.append(_values(kind, get, "x", "y", "z"))
        elif kind == "triangle":
            corners.append(_values(kind, get, "v1", "v2", "v3"))
            group, first = get.get("pid", of_object[-1][0] if of_object else ""), get.get("p1")
            own = of_object[-1:] if first is None else [(group, get.get(name, first)) for name in ("p1", "p2", "p3")]
            chosen.append(tuple(own))
        elif kind in ("component", "item"):
            path = next((value for key, value in get.items() if _local(key) == "path"), model)
            (number,) = _values(kind, get, "objectid")
            key = path.lower().strip("/"), number
            instance = Instance(key, _matrix(get.get("transform")))
            (components if kind == "component" else items).append(instance)
        elif kind == "object":
            ids.extend(_values(kind, get, "id"))
            of_object[:] = [(get.get("pid", ""), get.get("pindex", ""))]
        elif kind in ("basematerials", "colorgroup"):
            palette.start(get.get("id", ""))
        elif kind in ("base", "color"):
            palette.add(get.get("displaycolor" if kind == "base" else "color", ""))

    def end(name: str) -> None:
        if _local(name) == "object":
            part = Part(
                _numbers(points).reshape(-1, 3),
                _numbers(corners).astype(np.int64).reshape(-1, 3),
                face_colors=palette.of_triangles(chosen),
            )
            objects[model, ids.pop()] = Object(part, components.copy())
            for read in (points, corners, components, chosen):
                read.clear()

    read_xml(stream, start, end)
    return items


class _Palette:
    """The colours of a model, by the ids of their groups and their numbers there."""

    def __init__(self) -> None:
        self.colors: dict[Swatch, tuple[float, float, float]] = {}
        self.group, self.count = "", 0

    def start(self, group: str) -> None:
        """Begin a group."""
        self.group, self.count = group, 0

    def add(self, color: str) -> None:
        """Add a colour to the group: sRGB as #rrggbb or #rrggbbaa; white if it is another."""
        with suppress(InputError):
            self.colors[self.group, str(self.count)] = linear("color", color[:7])
        self.count += 1

    def of_triangles(self, chosen: Sequence[tuple[Swatch, ...]]) -> NDArray[np.float64] | None:
        """Linear RGB, (T, 3), each the mean of what its corners chose; None without colours."""
        if not self.colors:
            return None
        means = {
            swatches: np.mean([self.colors.get(swatch, (1, 1, 1)) for swatch in swatches or [("", "")]], axis=0)
            for swatches in set(chosen)
        }
        return np.array([means[swatches] for swatches in chosen]).reshape(-1, 3)


def _local(name: str) -> str:
    """A name without its namespace."""
    return name.rpartition("}")[2]


def _values(element: str, attributes: dict[str, str], *names: str) -> list[str]:
    try:
        return [attributes[name] for name in names]
    except KeyError as error:
        raise InputError(f"{element}: expected the attribute {error.args[0]}, got none") from error


def _numbers(words: Iterable[str | list[str]]) -> NDArray[np.float64]:
    try:
        return np.array(words, dtype=np.float64)
    except ValueError as error:
        raise InputError(f"expected numbers, got others ({error})") from error


def _matrix(text: str | None) -> NDArray[np.float64]:
    """Read the 12 numbers of a transform, which 3MF multiplies from the right."""
    matrix = np.eye(4)
    if text:
        numbers = _numbers(text.split())
        if len(numbers) != 12:
            raise InputError(f"transform: expected 12 numbers, got {len(numbers)}")
        matrix[:3] = numbers.reshape(4, 3).T
    return matrix
