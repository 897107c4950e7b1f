"""3MF: a zip file of XML; objects, where they are built, the colours of their triangles, and their textures.

It is read here because trimesh 5.2 needs lxml and networkx for it, and walks every path through the
components, of which a file of a few lines can have 2ⁿ.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.part import Part, counted, placed
from bobrossnet.adapters.surface import Pictures, Surface, Texture
from bobrossnet.adapters.xml import read_xml
from bobrossnet.color import linear
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import one_line, warn_of

if TYPE_CHECKING:
    from zipfile import ZipFile

MAX_INSTANCES = 100_000

Key: TypeAlias = tuple[str, str]
"""The model file that an object is in, and its id there."""

Swatch: TypeAlias = tuple[str, str]
"""The id of a group of colours, and the number of one of these."""


class Instance(NamedTuple):
    key: Key
    matrix: NDArray[np.float64]  # (4, 4), multiplied from the left


class Object(NamedTuple):
    parts: list[Part]
    components: list[Instance]


def read_3mf(file: Path) -> list[Part]:
    """The meshes of what a 3MF builds, each where it is built.

    A texture that can't be read is left out, with a warning.

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
        _check_unpacked("a 3MF model", sum(info.file_size for info in models), file)
        textures = _Textures(file, archive)
        for info in models:
            with archive.open(info) as stream:
                items += _read_model(stream, info.filename.lower().strip("/"), objects, textures)
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
        for part in found.parts:
            total = counted(total, len(part.triangles) + len(part.vertices))
            if len(part.vertices):
                parts.append(placed(part, matrix))
        items += [Instance(child, matrix @ relative) for child, relative in found.components]
    return parts


def _check_unpacked(what: str, unpacked: int, file: Path) -> None:
    # Coordinates shrink to a third or a tenth of their text, pictures not at all; only a bomb shrinks to a hundredth.
    if unpacked > 1 << 26 and unpacked > 100 * file.stat().st_size:
        raise InputError(f"expected {what}, got a zip file that unpacks to {unpacked:,} bytes")


class _Textures(dict[str, Texture | None]):
    """Pictures in a 3MF, by their paths in it; None, with a warning, where one can't be read."""

    def __init__(self, file: Path, archive: ZipFile) -> None:
        super().__init__()
        self.file, self.archive, self.pictures, self.unpacked = file, archive, Pictures(), 0
        self.names = {info.filename.lower().strip("/"): info for info in archive.infolist()}

    def __missing__(self, path: str) -> Texture | None:
        texture = None
        try:
            info = self.names.get(path.lower().strip("/"))
            if info is None:
                raise InputError("expected a picture in the file, found none of that name")
            _check_unpacked("pictures", self.unpacked + info.file_size, self.file)
            self.unpacked += info.file_size
            texture = Texture(self.pictures.decoded(self.archive.read(info)))
        except InputError as error:
            warn_of(self.file, f"texture {one_line(path) or 'without a path'} was left out: {error}")
        self[path] = texture
        return texture


def _read_model(stream: IO[bytes], model: str, objects: dict[Key, Object], textures: _Textures) -> list[Instance]:
    """Collect the objects of one model file into `objects`; return what it builds."""
    items: list[Instance] = []
    points: list[list[str]] = []
    corners: list[list[str]] = []
    components: list[Instance] = []
    ids: list[str] = []
    palette = _Palette(textures)
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
        elif kind == "texture2d":
            palette.pictures[get.get("id", "")] = get.get("path", ""), _wrap(get, "u"), _wrap(get, "v")
        elif kind == "texture2dgroup":
            palette.start(get.get("id", ""), get.get("texid", ""))
        elif kind == "tex2coord":
            palette.add_place(_values(kind, get, "u", "v"))

    def end(name: str) -> None:
        if _local(name) == "object":
            vertices = _numbers(points).reshape(-1, 3)
            triangles = _numbers(corners).astype(np.int64).reshape(-1, 3)
            objects[model, ids.pop()] = Object(palette.parts(vertices, triangles, chosen), components.copy())
            for read in (points, corners, components, chosen):
                read.clear()

    read_xml(stream, start, end)
    return items


class _Palette:
    """The colours of a model, and places on its textures, by the ids of their groups and their numbers there."""

    def __init__(self, textures: _Textures) -> None:
        self.textures = textures
        self.pictures: dict[str, tuple[str, str, str]] = {}
        """Path and how they wrap, by the ids of textures."""
        self.picture_of: dict[str, str] = {}
        """Ids of textures, by groups of places on them."""
        self.colors: dict[Swatch, tuple[float, float, float]] = {}
        self.places: dict[Swatch, list[str]] = {}
        self.group, self.count = "", 0

    def start(self, group: str, picture: str | None = None) -> None:
        """Begin a group, of colours or of places on a texture."""
        self.group, self.count = group, 0
        if picture is not None:
            self.picture_of[group] = picture

    def add(self, color: str) -> None:
        """Add a colour to the group: sRGB as #rrggbb or #rrggbbaa; white if it is another."""
        with suppress(InputError):
            self.colors[self.group, str(self.count)] = linear("color", color[:7])
        self.count += 1

    def add_place(self, place: list[str]) -> None:
        """Add a place on its texture to the group."""
        self.places[self.group, str(self.count)] = place
        self.count += 1

    def parts(
        self, vertices: NDArray[np.float64], triangles: NDArray[np.int64], chosen: Sequence[tuple[Swatch, ...]]
    ) -> list[Part]:
        """An object in a part for each of its textures, and one for the rest."""
        if not self.picture_of:
            return [Part(vertices, triangles, face_colors=self.of_triangles(chosen))]
        rows_of: dict[str | None, list[int]] = {None: []}
        for row, swatches in enumerate(chosen):
            rows_of.setdefault(self.picture_of.get(swatches[0][0]) if swatches else None, []).append(row)
        parts = []
        points = np.vstack([vertices, np.full(3, np.nan)])
        for picture, rows in rows_of.items():
            own, looks = triangles[rows], [chosen[row] for row in rows]
            if picture is None:
                parts.append(Part(vertices, own, face_colors=self.of_triangles(looks)))
            else:
                parts.append(self._laid(points, own, looks, picture))
        return parts

    def _laid(
        self,
        points: NDArray[np.float64],
        triangles: NDArray[np.int64],
        chosen: Sequence[tuple[Swatch, ...]],
        picture: str,
    ) -> Part:
        """A part on a texture, whose corners are vertices of their own; the last of the points stands for any that is
        missing."""
        path, *wrap = self.pictures.get(picture, ("", "repeat", "repeat"))
        texture = self.textures[path]
        none = ["nan", "nan"]
        uv = _numbers([self.places.get(swatch, none) for own in chosen for swatch in (own * 3)[:3]]).reshape(-1, 2)
        corners = triangles.reshape(-1)
        return Part(
            points[np.where((corners >= 0) & (corners < len(points)), corners, -1)],
            np.arange(len(corners)).reshape(-1, 3),
            uv=uv * (1, -1) + (0, 1),  # a 3MF counts from the bottom up
            surface=Surface(texture=texture and texture._replace(wrap=(wrap[0], wrap[1]))),
        )

    def of_triangles(self, chosen: Sequence[tuple[Swatch, ...]]) -> NDArray[np.float64] | None:
        """Linear RGB, (T, 3), each the mean of what its corners chose; None without colours."""
        if not self.colors:
            return None
        means = {
            swatches: np.mean([self.colors.get(swatch, (1, 1, 1)) for swatch in swatches or [("", "")]], axis=0)
            for swatches in set(chosen)
        }
        return np.array([means[swatches] for swatches in chosen]).reshape(-1, 3)


def _wrap(texture: dict[str, str], axis: str) -> str:
    """How a texture wraps along an axis. What has none there is taken to go on as it ends."""
    style = texture.get(f"tilestyle{axis}", "wrap")
    return {"mirror": "mirror", "clamp": "clamp", "none": "clamp"}.get(style, "repeat")


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
