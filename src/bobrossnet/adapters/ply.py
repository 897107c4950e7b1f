"""PLY, text and binary: vertices, their normals, polygons and triangle strips, their colours and a texture.

It is read here because trimesh 5.2 refuses polygons of mixed sizes, and sees a point cloud where the faces
are triangle strips; plyfile reads both, but is under the GPL.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.part import PIECE, Part, concatenated, converted, fan, lines_of, of_triangles, pieces
from bobrossnet.adapters.surface import Surface, texture_beside
from bobrossnet.color import from_srgb
from bobrossnet.support.errors import InputError

TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "int64": "i8", "uint64": "u8",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
CORNERS = ("vertex_indices", "vertex_index")
PLACES = "texcoord"
"""Of faces: where on the texture each corner is."""
PLACES_OF_VERTICES = (("u", "v"), ("s", "t"), ("texture_u", "texture_v"), ("texture_s", "texture_t"))
SRGB = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
LINEAR = ("color_0", "color_1", "color_2")
"""As Mitsuba writes its attributes."""
TEXTURE = re.compile(rb"[\r\n]comment[ \t]+TextureFile[ \t]+([^\r\n]+)")
ORDERS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}


class Property(NamedTuple):
    name: str
    dtype: np.dtype[Any]
    length: np.dtype[Any] | None  # the type of a list's length; None for a scalar
    full: float = 1  # how much of a colour is all of it


class Element(NamedTuple):
    name: str
    rows: int
    properties: list[Property]


class Column(NamedTuple):
    """One property of all rows: `lengths` (rows,) of the lists, their values one after another, and the largest value
    that a colour can have."""

    lengths: NDArray[np.int64]
    values: NDArray[Any]
    full: float = 1


Table: TypeAlias = dict[str, Column]


def read_ply(file: Path) -> list[Part]:
    """The one mesh of a PLY. Its texture stands for colours of vertices, and these for those of faces.

    Raises
    ------
    InputError
        If the header is invalid, the file is shorter than it says, or there are no vertices.
    """
    data = file.read_bytes()
    elements, body, text = _header(data)
    picture = TEXTURE.search(data, 0, body)
    # Whatever comes after the last of these, edges or materials, is of no use here.
    useful = [n for n, element in enumerate(elements) if element.name in ("vertex", "face", "tristrips")]
    elements = elements[: max(useful, default=-1) + 1]
    # Text becomes binary in which every number is a double, so that one reader does for both.
    data = _binary(data[body:], elements) if text else data[body:]
    tables: dict[str, Table] = {}
    at = 0
    for element in elements:
        table, at = _table(data, at, element)
        # Coordinates are single numbers, and corners are lists: whatever else has their names is something else.
        lists = {prop.name for prop in element.properties if prop.length is not None}
        tables[element.name] = {
            name: column for name, column in table.items() if (name in lists) == (name in (*CORNERS, PLACES))
        }

    vertex, face = tables.get("vertex", {}), tables.get("face", {})
    if not {"x", "y", "z"} <= vertex.keys():
        raise InputError("expected a PLY with vertices x, y, z, got none")
    triangles: list[NDArray[np.int64]] = []
    for name, cut in (("face", fan), ("tristrips", _unstripped)):
        corners = _corners(tables.get(name, {}))
        if corners is not None and len(corners.values):
            triangles.append(cut(corners.lengths, converted(corners.values, np.int64)))
    if len(triangles) != 1:
        triangles = [concatenated([np.empty((0, 3), np.int64), *triangles])]
    part = Part(
        _vectors(vertex, "x", "y", "z"),
        triangles[0],
        _vectors(vertex, "nx", "ny", "nz") if {"nx", "ny", "nz"} <= vertex.keys() else None,
        _colors(vertex),
    )
    laid = _with_places(part, vertex, face) if picture else None
    if picture and laid and (texture := texture_beside(file, picture[1])):
        return [laid._replace(colors=None, surface=Surface(texture=texture))]
    faces = _corners(face)
    if part.colors is None and faces is not None and (colors := _colors(face)) is not None:
        part = part._replace(face_colors=of_triangles(colors, faces.lengths))
    return [part]


def _corners(table: Table) -> Column | None:
    return next((table[name] for name in CORNERS if name in table), None)


def _colors(table: Table) -> NDArray[np.float64] | None:
    """Linear RGB, (rows, 3)."""
    for names in SRGB:
        if table.keys() >= {*names}:
            full = [table[name].full for name in names]
            return from_srgb(np.clip(_vectors(table, *names) / full, 0, 1))
    return _vectors(table, *LINEAR) if table.keys() >= {*LINEAR} else None


def _with_places(part: Part, vertex: Table, face: Table) -> Part | None:
    """The part with places on the texture, of vertices or of corners, each of which then has a vertex; None without."""
    for names in PLACES_OF_VERTICES:
        if vertex.keys() >= {*names}:
            return part._replace(uv=_upright(_vectors(vertex, *names)))
    corners, places = _corners(face), face.get(PLACES)
    if corners is None or places is None or (places.lengths != 2 * corners.lengths).any():
        return None
    vertices, uv = converted(corners.values, np.int64), places.values.astype(np.float64).reshape(-1, 2)
    if (vertices < 0).any() or (vertices >= len(part.vertices)).any():
        return None
    return part._replace(
        vertices=part.vertices[vertices],
        triangles=fan(corners.lengths, np.arange(len(uv))),
        normals=None if part.normals is None else part.normals[vertices],
        uv=_upright(uv),
    )


def _upright(uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Places that are counted from the bottom up, from the top down."""
    return uv * (1, -1) + (0, 1)


def _vectors(table: Table, *names: str) -> NDArray[np.float64]:
    return np.stack([table[name].values.astype(np.float64) for name in names], axis=1)


def _unstripped(lengths: NDArray[np.int64], corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangle strips, which end with their list or at a -1 within it, as triangles (T, 3)."""
    strip = np.insert(corners, np.cumsum(lengths), -1)
    index = np.arange(len(strip))
    start = np.maximum.accumulate(np.where(strip < 0, index + 1, 0))
    triangles = np.stack([strip[:-2], strip[1:-1], strip[2:]], axis=1)
    odd = (index - start)[:-2] % 2 == 1  # every second triangle of a strip turns the other way
    triangles[odd] = triangles[odd][:, [1, 0, 2]]
    a, b, c = triangles.T
    # Repeated corners steer a strip round a bend; they are not meant to be seen.
    shown: NDArray[np.int64] = triangles[(triangles >= 0).all(axis=1) & (a != b) & (b != c) & (c != a)]
    return shown


# ---- Header ----------------------------------------------------------------------------------------------


def _header(data: bytes) -> tuple[list[Element], int, bool]:
    """The elements that are declared, where the body starts, and whether it is text."""
    if not data.startswith(b"ply"):
        raise InputError(f"expected a PLY, which starts with 'ply', got {data[:8]!r}")
    end = re.compile(rb"[\r\n]end_header[ \t]*(?:\r\n|\n|\r|\Z)").search(data, 0, 1 << 20)
    if end is None:
        raise InputError("expected a PLY header that ends in end_header, got none")
    form, elements = "", list[Element]()
    for words in (line.split() for line in re.split("\r\n|\r|\n", data[: end.start()].decode("latin-1"))):
        if words[:1] == ["format"] and len(words) > 1:
            form = words[1]
        elif words[:1] == ["element"] and len(words) == 3:
            elements.append(Element(words[1], _integer(words[2]), []))
        elif words[:1] == ["property"] and elements and len(words) == 5 and words[1] == "list":
            elements[-1].properties.append(Property(words[4], _dtype(words[3], form), _dtype(words[2], form)))
        elif words[:1] == ["property"] and elements and len(words) == 3:
            full = 1 if TYPES.get(words[1], "f")[0] == "f" else float(np.iinfo(TYPES[words[1]]).max)
            elements[-1].properties.append(Property(words[2], _dtype(words[1], form), None, full))
    elements = [element for element in elements if element.properties]
    if form not in ORDERS:
        raise InputError(f"expected a PLY of format ascii or binary, got {form or 'none'}")

    # A list takes at least its length; a number in a text at least a digit and a space, but for the last.
    text = form == "ascii"
    smallest = sum(e.rows * sum(2 if text else (p.length or p.dtype).itemsize for p in e.properties) for e in elements)
    left = len(data) - end.end()
    if smallest > left + text or any(e.rows < 0 for e in elements):
        declared = ", ".join(f"{e.rows:,} {e.name}" for e in elements)
        raise InputError(f"expected {declared}, got only {left:,} bytes to hold them")
    return elements, end.end(), text


def _integer(word: str) -> int:
    if not re.fullmatch("[-+]?[0-9]{1,18}", word):
        raise InputError(f"expected a whole number, got {word[:40]!r}")
    return int(word)


def _dtype(word: str, form: str) -> np.dtype[Any]:
    if word not in TYPES:
        raise InputError(f"expected a PLY type such as float or int, got {word}")
    return np.dtype(ORDERS.get(form, "<") + ("f8" if form == "ascii" else TYPES[word]))


# ---- Body ------------------------------------------------------------------------------------------------


def _binary(text: bytes, elements: list[Element]) -> bytes:
    """The numbers that the header declares, as doubles. A line may hold more; some writers do that."""
    lines = (words for words in map(bytes.split, lines_of(text)) if words)
    kept: list[bytes] = []
    numbers: list[bytes] = []
    for element in elements:
        lists = [prop.length is not None for prop in element.properties]
        for row in range(element.rows):
            words, end = next(lines, []), len(lists)
            if any(lists):
                end = 0
                for is_list in lists:
                    end += 1 + (max(_integer(words[end].decode("latin-1")), 0) if is_list and end < len(words) else 0)
            if len(words) < end:
                raise InputError(f"expected {element.rows:,} {element.name}, got {row:,} and a bit")
            kept += words[:end]
            if len(kept) >= PIECE:
                numbers.append(_doubles(kept))
                kept.clear()
    return b"".join([*numbers, _doubles(kept)])


def _doubles(words: list[bytes]) -> bytes:
    try:
        return np.array(words, dtype="<f8").tobytes()
    except ValueError as error:
        raise InputError(f"expected numbers, got others ({error})") from error


def _table(data: bytes, at: int, element: Element) -> tuple[Table, int]:
    """All rows of an element from byte `at` on, and where the next element starts."""
    if element.rows == 0:
        none = Column(np.empty(0, np.int64), np.empty(0))
        return {prop.name: none for prop in element.properties}, at
    try:
        return _even_rows(data, at, element) or _uneven_rows(data, at, element)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"expected {element.rows:,} {element.name}, but the file ends before them") from error


def _even_rows(data: bytes, at: int, element: Element) -> tuple[Table, int] | None:
    """The fast way, if all rows have lists as long as the first row's; None if they have not."""
    fields: list[tuple[str, Any] | tuple[str, Any, tuple[int]]] = []
    offset = at
    for number, prop in enumerate(element.properties):
        length = 1
        if prop.length is not None:
            length = _length(data, offset, prop.length)
            fields.append((f"length{number}", prop.length))
            offset += prop.length.itemsize
        fields.append((f"values{number}", prop.dtype, (length,)))
        offset += length * prop.dtype.itemsize
    end = at + element.rows * (offset - at)
    if end > len(data):
        return None
    rows = np.frombuffer(data, np.dtype(fields), element.rows, at)
    table = {}
    for number, prop in enumerate(element.properties):
        values = rows[f"values{number}"]
        if prop.length is not None and (rows[f"length{number}"] != values.shape[1]).any():
            return None
        lengths = np.full(element.rows, values.shape[1], np.int64)
        table[prop.name] = Column(lengths, values.reshape(-1), prop.full)
    return table, end


def _uneven_rows(data: bytes, at: int, element: Element) -> tuple[Table, int]:
    lengths: list[list[int]] = [[] for _ in element.properties]
    values: list[list[NDArray[Any]]] = [[] for _ in element.properties]
    for _ in range(element.rows):
        for number, prop in enumerate(element.properties):
            length = 1
            if prop.length is not None:
                length = _length(data, at, prop.length)
                at += prop.length.itemsize
            none = np.empty(0, prop.dtype)
            values[number].append(np.frombuffer(data, prop.dtype, length, at) if length else none)
            lengths[number].append(length)
            at += length * prop.dtype.itemsize
    return {
        prop.name: Column(np.array(lengths[number], np.int64), _joined(values[number]), prop.full)
        for number, prop in enumerate(element.properties)
    }, at


def _joined(arrays: list[NDArray[Any]]) -> NDArray[Any]:
    """A great many arrays as one, rows of them at a time."""
    return concatenated([np.concatenate(arrays[rows]) for rows in pieces(len(arrays))])


def _length(data: bytes, at: int, dtype: np.dtype[Any]) -> int:
    length = float(np.frombuffer(data, dtype, 1, at)[0])
    if not 0 <= length <= len(data):
        raise InputError(f"expected a list no longer than the file, got one of {length:,.15g}")
    return int(length)
