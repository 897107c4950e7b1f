"""Mesh files: one `Mesh` out of whatever a file holds, or one line that says why not.

STL, OFF and glTF are parsed by trimesh's readers, which hand over what the file stores and nothing they made
up. Three formats are read here, because trimesh 5.2 falls short on files that people have:

- PLY: it refuses polygons of mixed sizes and sees a point cloud where the faces are triangle strips; plyfile
  reads both, but is under the GPL.
- OBJ: it counts relative indices back from the end of the file rather than from the line they stand in, takes
  the invalid index 0 for the first vertex, and gives up a whole file for one bad face.
- 3MF: it needs lxml and networkx, and walks every path through the components, of which a file of a few lines
  can have 2ⁿ.
"""

from __future__ import annotations

import io
import json
import logging
import os
import re
import struct
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from bobrossnet.errors import InputError, InputTypeError, InputWarning
from bobrossnet.shapes.mesh import Mesh

# Instances can repeat one part without end; this many triangles and vertices still fit into a few GB.
MAX_ITEMS = 100_000_000
MAX_INSTANCES = 100_000
# Beyond this, squares and products of coordinates leave float64.
MAX_COORDINATE = 1e100


class Part(NamedTuple):
    """What a file stores of one mesh, as it came: indices unchecked, numbers perhaps not finite.

    Missing normals are None for the whole part, NaN for single vertices.
    """

    vertices: NDArray[np.float64]  # (V, 3)
    triangles: NDArray[np.int64]  # (T, 3)
    normals: NDArray[np.float64] | None = None  # (V, 3)


def load_mesh(path: str | os.PathLike[str]) -> Mesh:
    """Read a triangle mesh from a file.

    All parts of a file become one mesh, placed as the file places them. glTF is y-up by its specification
    and is turned to z-up; the other formats are taken as stored. Polygons are cut into fans of triangles.
    Vertices that no triangle uses are left out.

    Parameters
    ----------
    path : str or path
        A file whose name ends in one of `ENDINGS`, in any case.

    Returns
    -------
    Mesh, with normals only where the file stores normals.

    Raises
    ------
    InputError
        If there is no such file, or nothing in it can be drawn; one line that starts with the file's name.

    Warns
    -----
    InputWarning
        If triangles were left out because they touch a vertex that is missing or not finite.
    """
    try:
        file = Path(os.fsdecode(path))
    except TypeError as error:
        raise InputTypeError(f"path: expected a file name, got {type(path).__name__}") from error
    name = _line(file.name or str(file))
    reader = _reader(name, file)
    try:
        with _quiet():
            mesh, dropped, total = _clean(reader(file))
    except InputError as error:
        raise InputError(f"{name}: {_line(error)}") from error
    except MemoryError as error:
        raise InputError(f"{name}: expected a mesh that fits into memory, got a larger one") from error
    except RecursionError as error:
        raise InputError(f"{name}: expected a mesh, got data nested too deeply") from error
    except Exception as error:  # readers of other people's bytes raise all sorts
        reason = _line(f"{type(error).__name__}: {error}")
        raise InputError(f"{name}: expected a {_ending(file)} mesh, could not read it ({reason})") from error
    if dropped:
        warnings.warn(
            f"{name}: left out {dropped:,} of {total:,} triangles that touch a missing or non-finite vertex",
            InputWarning,
            stacklevel=2,
        )
    return mesh


def _reader(name: str, file: Path) -> Callable[[Path], list[Part]]:
    """Choose the reader for a file that exists and has something in it."""
    try:
        if not file.exists():
            raise InputError(f"{name}: expected a file, found nothing at {_line(file)}")
        if not file.is_file():
            raise InputError(f"{name}: expected a file, got a {'folder' if file.is_dir() else 'device'}")
        empty = file.stat().st_size == 0
    except (OSError, ValueError) as error:  # a name too long, a NUL in it, no permission
        if isinstance(error, InputError):
            raise
        raise InputError(f"{name}: expected a file, could not look at it ({_line(error)})") from error
    if _ending(file) not in READERS:
        raise InputError(f"{name}: expected one of {' '.join(ENDINGS)}, got {_ending(file) or 'no ending'}")
    if empty:
        raise InputError(f"{name}: expected a mesh, got an empty file")
    return READERS[_ending(file)]


def _ending(file: Path) -> str:
    return _line(file.suffix.lower())


def _line(text: object) -> str:
    """Any text as one line of at most 200 characters."""
    line = " ".join("".join(c if c.isprintable() else " " for c in str(text)).split())
    return line if len(line) <= 200 else line[:197] + "..."


@contextmanager
def _quiet() -> Iterator[None]:
    """Hold back trimesh's log and numpy's warnings about odd numbers: what fails becomes an error."""
    logger = logging.getLogger("trimesh")
    before, logger.disabled = logger.disabled, True
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            # numpy 1 warns and goes on with half the numbers of a text; numpy 2 raises.
            warnings.filterwarnings("error", message="string or file could not be read")
            yield
    finally:
        logger.disabled = before


# ---- From parts to a mesh --------------------------------------------------------------------------------


def _clean(parts: Sequence[Part]) -> tuple[Mesh, int, int]:
    """Join parts and keep what can be drawn: the mesh, how many triangles were dropped, of how many."""
    vertices, triangles, normals = _join(parts)
    total = len(triangles)
    if total == 0:
        got = f"a point cloud of {len(vertices):,} points" if len(vertices) else "none"
        raise InputError(f"expected triangles, got {got}")

    # Comparisons with NaN are false, so NaN is not usable either.
    usable: NDArray[np.bool_] = np.asarray((np.abs(vertices) <= MAX_COORDINATE).all(axis=1))
    kept = np.flatnonzero(np.all((triangles >= 0) & (triangles < len(vertices)), axis=1))
    kept = kept[np.all(usable[triangles[kept]], axis=1)]
    triangles = triangles[kept]
    if len(triangles) == 0:
        raise InputError(f"expected triangles, got {total:,} that all touch a missing or non-finite vertex")

    # Only what is drawn may count for the scene's bounding sphere.
    used = np.zeros(len(vertices), dtype=bool)
    used[triangles] = True
    renumbered = np.cumsum(used) - 1
    vertices, triangles = vertices[used], renumbered[triangles]
    faces = _face_normals(vertices, triangles)
    if not faces.any():
        raise InputError(f"expected triangles with an area, got {len(triangles):,} of zero area")
    if normals is not None:
        normals = _repaired(normals[used], triangles, faces)
    return Mesh(vertices, triangles, normals), total - len(triangles), total


def _join(parts: Sequence[Part]) -> Part:
    vertices, triangles, normals = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], [np.empty((0, 3))]
    start = 0
    for part in parts:
        # An index past the end of its part must not reach into the next one.
        inside = (part.triangles >= 0) & (part.triangles < len(part.vertices))
        triangles.append(np.where(inside, part.triangles + start, -1))
        vertices.append(part.vertices)
        stored = part.normals
        if stored is None or stored.shape != part.vertices.shape:
            stored = np.full(part.vertices.shape, np.nan)
        normals.append(stored)
        start += len(part.vertices)
    directions = np.concatenate(normals)
    return Part(
        np.concatenate(vertices),
        np.concatenate(triangles),
        None if np.isnan(directions).all() else directions,
    )


def _face_normals(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """Cross products of two sides, (T, 3), in units of the largest extent: twice the area long."""
    extent = float(np.max(np.ptp(vertices, axis=0))) or 1.0
    corners = ((vertices - vertices[0]) / extent)[triangles]
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _repaired(
    normals: NDArray[np.float64], triangles: NDArray[np.int64], faces: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """Unit normals; a vertex without a usable one takes the mean of its faces', weighted by their area."""
    length = np.linalg.norm(normals, axis=1)
    bad = ~((length > 0) & np.isfinite(length))
    if bad.all():
        return None
    if bad.any():
        means = np.zeros_like(normals)
        for corner in range(3):
            np.add.at(means, triangles[:, corner], faces)
        normals = np.where(bad[:, None], means, normals)
        length = np.linalg.norm(normals, axis=1)
    # A vertex of nothing but zero-area triangles is never seen; any direction will do.
    normals[~(length > 0)] = (0.0, 0.0, 1.0)
    unit: NDArray[np.float64] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return unit


def _placed(part: Part, matrix: NDArray[np.float64]) -> Part:
    """The part moved by a (4, 4) matrix that is multiplied from the left."""
    linear = matrix[:3, :3]
    mirrored = np.linalg.det(linear) < 0
    normals = part.normals
    if normals is not None:
        # The cofactors are det · inverse transpose, and exist where a part is pressed flat.
        a, b, c = linear.T
        cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
        normals = normals @ cofactors.T * (-1.0 if mirrored else 1.0)
    return Part(
        part.vertices @ linear.T + matrix[:3, 3],
        part.triangles[:, ::-1] if mirrored else part.triangles,  # the outside stays anticlockwise
        normals,
    )


def _counted(total: int, more: int) -> int:
    """Add to the count of triangles and vertices; stop before a file of copies fills the memory."""
    if total + more > MAX_ITEMS:
        raise InputError(f"expected at most {MAX_ITEMS:,} triangles and vertices in all its parts, got more")
    return total + more


def _fan(lengths: NDArray[np.int64], corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Polygons of `lengths` corners each, one after another in `corners`, as triangles (T, 3)."""
    cuts = np.maximum(lengths - 2, 0)
    first = np.repeat(np.cumsum(lengths) - lengths, cuts)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(cuts) - cuts, cuts)
    return np.stack([corners[first], corners[second], corners[second + 1]], axis=1)


def _unstripped(strip: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangle strips, ended by -1, as triangles (T, 3)."""
    index = np.arange(len(strip))
    start = np.maximum.accumulate(np.where(strip < 0, index + 1, 0))
    triangles = np.stack([strip[:-2], strip[1:-1], strip[2:]], axis=1)
    odd = (index - start)[:-2] % 2 == 1  # every second triangle of a strip turns the other way
    triangles[odd] = triangles[odd][:, [1, 0, 2]]
    a, b, c = triangles.T
    # Repeated corners steer a strip round a bend; they are not meant to be seen.
    shown: NDArray[np.int64] = triangles[(triangles >= 0).all(axis=1) & (a != b) & (b != c) & (c != a)]
    return shown


# ---- PLY -------------------------------------------------------------------------------------------------

PLY_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "int64": "i8", "uint64": "u8",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip


class _Property(NamedTuple):
    name: str
    dtype: np.dtype[Any]
    length: np.dtype[Any] | None  # the type of a list's length; None for a scalar


class _Element(NamedTuple):
    name: str
    rows: int
    properties: list[_Property]


class _Column(NamedTuple):
    """One property of all rows: `lengths` (rows,) of the lists, and their values one after another."""

    lengths: NDArray[np.int64]
    values: NDArray[Any]


def _read_ply(file: Path) -> list[Part]:
    data = file.read_bytes()
    elements, body, text = _ply_header(data)
    # Text becomes binary in which every number is a double, so that one reader does for both.
    data = _ply_binary(data[body:], elements) if text else data[body:]
    tables: dict[str, dict[str, _Column]] = {}
    at = 0
    for element in elements:
        if tables and not any(e.name in ("vertex", "face", "tristrips") for e in elements[len(tables) :]):
            break  # only edges, materials and the like are left
        tables[element.name], at = _ply_table(data, at, element)

    vertex = tables.get("vertex", {})
    if not {"x", "y", "z"} <= vertex.keys():
        raise InputError("expected a PLY with vertices x, y, z, got none")
    vertices = _ply_vectors(vertex, "x", "y", "z")
    normals = _ply_vectors(vertex, "nx", "ny", "nz") if {"nx", "ny", "nz"} <= vertex.keys() else None
    triangles = [np.empty((0, 3), np.int64)]
    for name, cut in (("face", _fan), ("tristrips", _ply_strips)):
        table = tables.get(name, {})
        corners = table.get("vertex_indices", table.get("vertex_index"))
        if corners is not None and len(corners.values):
            triangles.append(cut(corners.lengths, corners.values.astype(np.int64)))
    return [Part(vertices, np.concatenate(triangles), normals)]


def _ply_header(data: bytes) -> tuple[list[_Element], int, bool]:
    """The elements that are declared, where the body starts, and whether it is text."""
    if not data.startswith(b"ply"):
        raise InputError(f"expected a PLY, which starts with 'ply', got {data[:8]!r}")
    end = re.compile(rb"[\r\n]end_header[ \t]*(?:\r\n|\n|\r|\Z)").search(data, 0, 1 << 20)
    if end is None:
        raise InputError("expected a PLY header that ends in end_header, got none")
    form, elements = "", list[_Element]()
    for words in (line.split() for line in data[: end.start()].decode("latin-1").splitlines()):
        if words[:1] == ["format"] and len(words) > 1:
            form = words[1]
        elif words[:1] == ["element"] and len(words) == 3:
            elements.append(_Element(words[1], int(words[2]), []))
        elif words[:1] == ["property"] and elements and len(words) in (3, 5):
            *length, dtype = [np.dtype(_ply_type(word, form)) for word in words[1:-1] if word != "list"]
            elements[-1].properties.append(_Property(words[-1], dtype, length[0] if length else None))
    elements = [element for element in elements if element.properties]
    if form not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise InputError(f"expected a PLY of format ascii or binary, got {form or 'none'}")

    # A list takes at least its length; a number in a text at least a digit and a space.
    text = form == "ascii"
    smallest = sum(
        e.rows * sum(2 if text else (p.length or p.dtype).itemsize for p in e.properties) for e in elements
    )
    left = len(data) - end.end()
    if smallest > left + text or any(e.rows < 0 for e in elements):
        declared = ", ".join(f"{e.rows:,} {e.name}" for e in elements)
        raise InputError(f"expected {declared}, got only {left:,} bytes to hold them")
    return elements, end.end(), text


def _ply_type(word: str, form: str) -> str:
    if word not in PLY_TYPES:
        raise InputError(f"expected a PLY type such as float or int, got {word}")
    return "<f8" if form == "ascii" else (">" if form == "binary_big_endian" else "<") + PLY_TYPES[word]


def _ply_binary(text: bytes, elements: list[_Element]) -> bytes:
    """The numbers that the header declares, as doubles. A line may hold more; some writers do that."""
    lines = (words for words in map(bytes.split, text.splitlines()) if words)
    kept: list[bytes] = []
    for element in elements:
        lists = [prop.length is not None for prop in element.properties]
        for row in range(element.rows):
            words, end = next(lines, []), len(lists)
            if any(lists):
                end = 0
                for is_list in lists:
                    end += 1 + (max(int(words[end]), 0) if is_list and end < len(words) else 0)
            if len(words) < end:
                raise InputError(f"expected {element.rows:,} {element.name}, got {row:,} and a bit")
            kept += words[:end]
    return np.array(kept, dtype="<f8").tobytes()


def _ply_table(data: bytes, at: int, element: _Element) -> tuple[dict[str, _Column], int]:
    """All rows of an element from byte `at` on, and where the next element starts."""
    if element.rows == 0:
        none = _Column(np.empty(0, np.int64), np.empty(0))
        return {prop.name: none for prop in element.properties}, at
    try:
        table = _ply_even_rows(data, at, element)
        return table if table is not None else _ply_uneven_rows(data, at, element)
    except (ValueError, struct.error) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"expected {element.rows:,} {element.name}, the file ends before them") from error


def _ply_even_rows(data: bytes, at: int, element: _Element) -> tuple[dict[str, _Column], int] | None:
    """The fast way, if all rows have lists as long as the first row's; None if they have not."""
    fields: list[tuple[str, Any] | tuple[str, Any, tuple[int]]] = []
    offset = at
    for number, prop in enumerate(element.properties):
        if prop.length is None:
            fields.append((f"values{number}", prop.dtype, (1,)))
            offset += prop.dtype.itemsize
        else:
            length = _ply_length(data, offset, prop.length)
            fields += [(f"length{number}", prop.length), (f"values{number}", prop.dtype, (length,))]
            offset += prop.length.itemsize + length * prop.dtype.itemsize
    row = offset - at
    if at + element.rows * row > len(data):
        return None
    rows = np.frombuffer(data, np.dtype(fields), element.rows, at)
    table = {}
    for number, prop in enumerate(element.properties):
        values = rows[f"values{number}"]
        if prop.length is not None and (rows[f"length{number}"] != values.shape[1]).any():
            return None
        lengths = np.full(element.rows, values.shape[1], np.int64)
        table[prop.name] = _Column(lengths, values.reshape(-1))
    return table, at + element.rows * row


def _ply_uneven_rows(data: bytes, at: int, element: _Element) -> tuple[dict[str, _Column], int]:
    lengths: list[list[int]] = [[] for _ in element.properties]
    values: list[list[NDArray[Any]]] = [[] for _ in element.properties]
    for _ in range(element.rows):
        for number, prop in enumerate(element.properties):
            length = 1
            if prop.length is not None:
                length = _ply_length(data, at, prop.length)
                at += prop.length.itemsize
            none = np.empty(0, prop.dtype)
            values[number].append(np.frombuffer(data, prop.dtype, length, at) if length else none)
            lengths[number].append(length)
            at += length * prop.dtype.itemsize
    return {
        prop.name: _Column(np.array(lengths[number], np.int64), np.concatenate(values[number]))
        for number, prop in enumerate(element.properties)
    }, at


def _ply_length(data: bytes, at: int, dtype: np.dtype[Any]) -> int:
    length = float(np.frombuffer(data, dtype, 1, at)[0])
    if not 0 <= length <= len(data):
        raise InputError(f"expected a list no longer than the file, got one of {length:g}")
    return int(length)


def _ply_vectors(table: dict[str, _Column], *names: str) -> NDArray[np.float64]:
    return np.stack([table[name].values.astype(np.float64) for name in names], axis=1)


def _ply_strips(lengths: NDArray[np.int64], corners: NDArray[np.int64]) -> NDArray[np.int64]:
    return _unstripped(np.insert(corners, np.cumsum(lengths), -1))


# ---- OBJ -------------------------------------------------------------------------------------------------


def _read_obj(file: Path) -> list[Part]:
    points: list[list[bytes]] = []
    normals: list[list[bytes]] = []
    lengths: list[int] = []
    corners: list[int] = []
    corner_of: dict[tuple[int, int], int] = {}  # (point, normal) → vertex of the mesh
    seen: dict[bytes, int] = {}  # the same, by the word in the file

    def index(word: bytes, count: int) -> int:
        """Count from 0; -1 if there is no such item. Below 0 counts back from the last one read so far."""
        number = int(word)
        return number - 1 if number > 0 else max(count + number, -1) if number < 0 else -1

    for line in re.sub(rb"\\\r?\n", b" ", file.read_bytes()).splitlines():
        words = line.split()
        kind = words[0] if words else b""
        if kind == b"v":
            points.append(words[1:4] if len(words) >= 4 else [b"nan"] * 3)
        elif kind == b"vn":
            normals.append(words[1:4] if len(words) >= 4 else [b"nan"] * 3)
        elif kind == b"f":
            if b"#" in line:
                words = line.partition(b"#")[0].split()
            for word in words[1:]:
                corner = seen.get(word)
                if corner is None:
                    fields = word.split(b"/")
                    normal = index(fields[2], len(normals)) if len(fields) == 3 and fields[2] else -1
                    key = (index(fields[0], len(points)), normal)
                    corner = corner_of.setdefault(key, len(corner_of))
                    if b"-" not in word:
                        seen[word] = corner
                corners.append(corner)
            lengths.append(len(words) - 1)

    at, towards = (np.array(list(corner_of), dtype=np.int64).reshape(-1, 2)).T
    triangles = _fan(np.array(lengths, np.int64), np.array(corners, np.int64))
    return [Part(
        _picked(points, at) if len(triangles) else _numbers(points),
        triangles,
        _picked(normals, towards) if (towards >= 0).any() else None,
    )]  # fmt: skip


def _numbers(rows: list[list[bytes]]) -> NDArray[np.float64]:
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _picked(rows: list[list[bytes]], at: NDArray[np.int64]) -> NDArray[np.float64]:
    """Rows as numbers, (n, 3); NaN where there is no such row."""
    numbers = np.concatenate([_numbers(rows), [[np.nan] * 3]])
    picked: NDArray[np.float64] = numbers[np.where((at >= 0) & (at < len(rows)), at, -1)]
    return picked


# ---- STL and OFF -----------------------------------------------------------------------------------------


def _read_stl(file: Path) -> list[Part]:
    from trimesh.exchange.stl import load_stl

    size = file.stat().st_size
    with file.open("rb") as stream:
        head = stream.read(84)
        declared = int.from_bytes(head[80:84], "little")
        if size != 84 + 50 * declared and not head.lstrip().lower().startswith(b"solid"):
            raise InputError(f"expected an STL of 84 + 50·n bytes for n triangles, got {size:,} bytes")
        stream.seek(0)
        loaded: dict[str, Any] = load_stl(stream)
    solids = loaded["geometry"].values() if "geometry" in loaded else [loaded]
    return [_welded(_part(solid)) for solid in solids if "vertices" in solid]


def _welded(part: Part) -> Part:
    """The part with vertices at the same place made one: STL repeats them for every triangle."""
    rows = np.ascontiguousarray(part.vertices + 0.0)  # -0 and 0 are the same place
    places = rows.view(np.dtype((np.void, 24))).ravel()  # one item per row: ten times faster than axis=0
    _, first, inverse = np.unique(places, return_index=True, return_inverse=True)
    return Part(rows[first], inverse.reshape(-1)[part.triangles])


def _read_off(file: Path) -> list[Part]:
    from trimesh.exchange.off import load_off

    with file.open("rb") as stream:
        return [_part(load_off(stream))]


def _part(stored: dict[str, Any]) -> Part:
    """What a trimesh reader hands over; it has `vertex_normals` only where the file has them."""
    normals = stored.get("vertex_normals")
    return Part(
        np.asarray(stored["vertices"], dtype=np.float64).reshape(-1, 3),
        np.asarray(stored["faces"]).astype(np.int64).reshape(-1, 3),
        None if normals is None else np.asarray(normals, dtype=np.float64),
    )


# ---- glTF ------------------------------------------------------------------------------------------------

Z_UP = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])  # (x, y, z) → (x, -z, y)
GLTF_DRAWN = (4, 5)  # the primitive modes that trimesh turns into triangles: triangles and strips


class _Beside(dict[str, bytes]):
    """Files beside a glTF, by the names in it."""

    def __init__(self, gltf: Path) -> None:
        super().__init__()
        self.folder = gltf.parent

    def __missing__(self, uri: str) -> bytes:
        file = self.folder / unquote(uri)
        if not file.is_file():
            raise InputError(f"expected its data in {_line(uri)[:100]} beside it, found no such file")
        return file.read_bytes()


def _read_gltf(file: Path) -> list[Part]:
    from trimesh.exchange.gltf import load_gltf

    tree = json.loads(file.read_bytes())
    _prepare_gltf(tree)
    stream = io.BytesIO(json.dumps(tree).encode())
    return _gltf_parts(load_gltf(stream, _Beside(file), skip_materials=True))


def _read_glb(file: Path) -> list[Part]:
    from trimesh.exchange.gltf import load_glb

    data = file.read_bytes()
    if data[:4] != b"glTF" or len(data) < 20:
        raise InputError(f"expected a GLB, which starts with 'glTF', got {data[:4]!r}")
    _, version, size, length, _ = struct.unpack("<5I", data[:20])
    if size > len(data) or 20 + length > size:
        raise InputError(f"expected {max(size, 20 + length):,} bytes, as its head says, got {len(data):,}")
    tree = json.loads(data[20 : 20 + length])
    _prepare_gltf(tree)
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length : size]
    head = struct.pack("<4s4I", b"glTF", version, 20 + len(text) + len(rest), len(text), 0x4E4F534A)
    stream = io.BytesIO(head + text + rest)
    return _gltf_parts(load_glb(stream, _Beside(file), skip_materials=True))


def _prepare_gltf(tree: dict[str, Any]) -> None:
    """Refuse what trimesh would read wrongly or never finish, and take out what isn't a shape."""
    nodes, accessors = tree.get("nodes", []), tree.get("accessors", [])
    total = 0
    for primitive in (p for mesh in tree.get("meshes", []) for p in mesh["primitives"]):
        mode = primitive.get("mode", 4)
        if mode == 6:
            raise InputError("expected triangles or strips, got a triangle fan")
        used = [primitive["attributes"]["POSITION"], primitive.get("indices")] if mode in GLTF_DRAWN else []
        for accessor in (accessors[index] for index in used if index is not None):
            if "bufferView" not in accessor or "sparse" in accessor:
                how = ", ".join(primitive.get("extensions", {})) or "sparse data"
                raise InputError(
                    f"expected plain vertices and indices, got {how}; export without compression"
                )
            if accessor.get("normalized"):
                raise InputError("expected positions in floating point, got quantised ones")
            # Counted before they are read: many small primitives can share one large accessor.
            total = _counted(total, int(accessor["count"]))
    for accessor in accessors:
        if "bufferView" not in accessor:
            accessor["count"] = 0  # trimesh would allocate as many zeros as the file asks for

    # The specification wants trees; a node in several places could be reached in 2ⁿ ways, or for ever.
    children = [child for node in nodes for child in node.get("children", [])]
    scenes = tree.setdefault("scenes", [{"nodes": sorted(set(range(len(nodes))) - set(children))}])
    roots = scenes[tree.get("scene", 0)].get("nodes", [])
    if len(set(children)) < len(children) or not set(children).isdisjoint(roots):
        raise InputError("expected nodes that form a tree, got one with two parents or inside itself")
    for node in nodes:
        node.pop("camera", None)  # trimesh drops a camera's node, and with it the place of its children


def _gltf_parts(loaded: dict[str, Any]) -> list[Part]:
    world = {loaded["base_frame"]: Z_UP}
    parts: list[Part] = []
    total = 0
    for edge in loaded["graph"]:  # parents come before their children
        matrix = world[edge["frame_from"]] @ edge["matrix"]
        world[edge["frame_to"]] = matrix
        stored = loaded["geometry"].get(edge.get("geometry"), {})
        if "faces" in stored:
            total = _counted(total, len(stored["faces"]) + len(stored["vertices"]))
            parts.append(_placed(_part(stored), matrix))
    return parts


# ---- 3MF -------------------------------------------------------------------------------------------------


class _Object(NamedTuple):
    part: Part
    components: list[tuple[tuple[str, str], NDArray[np.float64]]]  # (model, id) of the object, (4, 4) matrix


def _read_3mf(file: Path) -> list[Part]:
    from zipfile import ZipFile

    objects: dict[tuple[str, str], _Object] = {}
    items: list[tuple[tuple[str, str], NDArray[np.float64]]] = []
    with ZipFile(file) as archive:
        models = [info for info in archive.infolist() if info.filename.lower().endswith(".model")]
        unpacked = sum(info.file_size for info in models)
        # Coordinates shrink to a third or a tenth of their text; only a bomb shrinks to a hundredth.
        if unpacked > 1 << 26 and unpacked > 100 * file.stat().st_size:
            raise InputError(f"expected a 3MF model, got a zip file that unpacks to {unpacked:,} bytes")
        for info in models:
            with archive.open(info) as stream:
                items += _3mf_model(stream, info.filename.lower().strip("/"), objects)
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
        total = _counted(total, len(found.part.triangles) + len(found.part.vertices))
        if len(found.part.vertices):
            parts.append(_placed(found.part, matrix))
        items += [(child, matrix @ placed) for child, placed in found.components]
    return parts


def _3mf_model(stream: Any, model: str, objects: dict[tuple[str, str], _Object]) -> list[Any]:
    """Collect the objects of one model file into `objects`; return what it builds."""
    from xml.etree.ElementTree import iterparse

    items: list[Any] = []
    points: list[tuple[str, ...]] = []
    corners: list[tuple[str, ...]] = []
    components: list[Any] = []
    for _, element in iterparse(stream):
        get = element.attrib
        kind = element.tag.rpartition("}")[2]
        if kind == "vertex":
            points.append((get["x"], get["y"], get["z"]))
        elif kind == "triangle":
            corners.append((get["v1"], get["v2"], get["v3"]))
        elif kind in ("component", "item"):
            path = next((value for key, value in get.items() if key.rpartition("}")[2] == "path"), model)
            target = (path.lower().strip("/"), get["objectid"])
            (components if kind == "component" else items).append((target, _3mf_matrix(get.get("transform"))))
        elif kind == "object":
            part = Part(
                np.array(points, dtype=np.float64).reshape(-1, 3),
                np.array(corners, dtype=np.float64).astype(np.int64).reshape(-1, 3),
            )
            objects[model, get["id"]] = _Object(part, components)
            points, corners, components = [], [], []
        element.clear()
    return items


def _3mf_matrix(text: str | None) -> NDArray[np.float64]:
    """Read the 12 numbers of a transform, which 3MF multiplies from the right."""
    matrix = np.eye(4)
    if text:
        matrix[:3] = np.array(text.split(), dtype=np.float64).reshape(4, 3).T
    return matrix


# ---- The table of endings --------------------------------------------------------------------------------

READERS: dict[str, Callable[[Path], list[Part]]] = {
    ".ply": _read_ply,
    ".obj": _read_obj,
    ".stl": _read_stl,
    ".off": _read_off,
    ".glb": _read_glb,
    ".gltf": _read_gltf,
    ".3mf": _read_3mf,
}
ENDINGS = tuple(READERS)
