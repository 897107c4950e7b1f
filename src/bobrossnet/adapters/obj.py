"""OBJ: points, normals, texture coordinates and polygons, their materials and colours; curves are passed over.

It is read here because trimesh 5.2 counts relative indices back from the end of the file rather than from
the line they stand in, takes the invalid index 0 for the first vertex, and gives up a whole file for one bad
face.
"""

from __future__ import annotations

import re
from array import array
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.mtl import read_mtl
from bobrossnet.adapters.part import Part, concatenated, fan, lines_of, of_triangles, pieces, rows_of
from bobrossnet.adapters.surface import Surface
from bobrossnet.color import from_srgb
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import one_line

INDEX = re.compile(rb"[-+]?[0-9]+")
LIBRARY = re.compile(rb"^[ \t]*mtllib[ \t]+([^\r\n]*)", re.MULTILINE)
MOST = 1 << 31  # beyond any file's
FAR = 20  # digits of which nothing can be read but that it is as far
NONE = [b"nan"] * 3


def read_obj(file: Path) -> list[Part]:
    """All groups of an OBJ, a part for each material: a vertex for each pair of point and normal that some corner
    names, and where there is a texture, for each place on it.

    Raises
    ------
    InputError
        If a number isn't one.
    """
    data = re.sub(rb"\\\r?\n", b" ", file.read_bytes())
    libraries = [name.strip() for name in LIBRARY.findall(data)]
    surfaces = read_mtl(file, libraries) if libraries and b"usemtl" in data else {}
    textured = any(surface.texture for surface in surfaces.values())

    points: list[list[bytes]] = []
    colors: dict[int, list[bytes]] = {}  # by point
    normals: list[list[bytes]] = []
    places: list[list[bytes]] = []
    lengths, corners, materials = array("q"), array("q"), array("q")
    corner_of: dict[tuple[int, int, int], int] = {}  # (point, normal, place on a texture) → vertex of the part
    seen: dict[bytes, int] = {}  # the same, by the word in the file: most words come six times
    names: dict[bytes, int] = {b"": 0}  # of materials, in the order in which faces have them
    material = 0
    for line in lines_of(data):
        words = line.partition(b"#")[0].split()
        kind = words[0] if words else b""
        if kind in (b"v", b"vn"):
            if len(words) >= 7 and kind == b"v":
                colors[len(points)] = words[4:7]
            (points if kind == b"v" else normals).append(words[1:4] if len(words) >= 4 else NONE)
        elif kind == b"vt" and textured:
            places.append([*words[1:3], *NONE][:2])
        elif kind == b"usemtl" and surfaces:
            material = names.setdefault(line.partition(b"usemtl")[2].strip(), len(names))
        elif kind == b"f":
            for word in words[1:]:
                corner = seen.get(word)
                if corner is None:
                    point, place, normal = (*word.split(b"/"), b"", b"")[:3]
                    key = (
                        _index(point, len(points)),
                        _index(normal or b"0", len(normals)),
                        _index(place or b"0", len(places)) if textured else -1,
                    )
                    corner = corner_of.setdefault(key, len(corner_of))
                    if b"-" not in word:  # a relative index means something else on the next line
                        seen[word] = corner
                corners.append(corner)
            lengths.append(len(words) - 1)
            materials.append(material)

    at, towards, on = np.fromiter(chain.from_iterable(corner_of), np.int64).reshape(-1, 3).T
    sizes = np.array(lengths, np.int64)
    triangles = fan(sizes, np.array(corners, np.int64))
    whole = Part(
        _picked(points, at) if len(triangles) else _numbers(points),
        triangles,
        _picked(normals, towards) if len(_numbers(normals)) and (towards >= 0).any() else None,
        _colors(colors, at) if colors else None,
    )
    if not surfaces:
        return [whole]
    uv = _picked(places, on, 2) * (1, -1) + (0, 1)  # an OBJ counts from the bottom up
    rows = rows_of(of_triangles(np.array(materials, np.int64), sizes), len(names))
    return [
        _of_surface(whole, own, uv, surfaces.get(name, Surface()))
        for name, own in zip(names, rows, strict=True)
        if len(own)
    ]


def _of_surface(whole: Part, triangles: NDArray[np.int64], uv: NDArray[np.float64], surface: Surface) -> Part:
    """The triangles of one surface, and what they use."""
    used, corners = np.unique(whole.triangles[triangles], return_inverse=True)
    return Part(
        whole.vertices[used],
        corners.reshape(-1, 3),
        None if whole.normals is None else whole.normals[used],
        None if whole.colors is None else whole.colors[used],
        uv=None if surface.texture is None else uv[used],
        surface=surface,
    )


def _colors(colors: dict[int, list[bytes]], at: NDArray[np.int64]) -> NDArray[np.float64] | None:
    """Linear RGB of points that have three more numbers; None if these are no colours, which are in 0..1."""
    srgb = _numbers([*colors.values()])
    if (srgb < 0).any() or (srgb > 1).any():
        return None
    linear = np.ones((max(int(at.max(initial=0)), *colors) + 1, 3))
    linear[[*colors]] = from_srgb(srgb)
    return linear[at]


def _index(word: bytes, count: int) -> int:
    """Count from 0; -1 if there is no such item. Below 0 counts back from the last one read so far."""
    if not INDEX.fullmatch(word):
        raise InputError(f"expected corners of faces such as 3, 3/1 or 3//2, got {one_line(word.decode('latin-1'))!r}")
    number = int(word) if len(word) < FAR else MOST
    return min(number, MOST) - 1 if number >= 0 else max(count + number, -1)


def _numbers(rows: list[list[bytes]], width: int = 3) -> NDArray[np.float64]:
    try:
        return concatenated([np.array(rows[some], dtype=np.float64).reshape(-1, width) for some in pieces(len(rows))])
    except ValueError as error:
        raise InputError(f"expected numbers, got others ({error})") from error


def _picked(rows: list[list[bytes]], at: NDArray[np.int64], width: int = 3) -> NDArray[np.float64]:
    """Rows as numbers, (n, width); NaN where there is no such row."""
    numbers = np.concatenate([_numbers(rows, width), [[np.nan] * width]])
    picked: NDArray[np.float64] = numbers[np.where((at >= 0) & (at < len(rows)), at, -1)]
    return picked
