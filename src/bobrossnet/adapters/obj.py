"""OBJ: points, normals and polygons; materials, curves and texture coordinates are passed over.

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

from bobrossnet.adapters.messages import one_line
from bobrossnet.adapters.part import Part, concatenated, fan, lines_of, pieces
from bobrossnet.errors import InputError

INDEX = re.compile(rb"[-+]?[0-9]+")
MOST = 1 << 31  # beyond any file's
FAR = 20  # digits of which nothing can be read but that it is as far


def read_obj(file: Path) -> list[Part]:
    """All groups of an OBJ as one part: a vertex for each pair of point and normal that some corner names.

    Raises
    ------
    InputError
        If a number isn't one.
    """
    points: list[list[bytes]] = []
    normals: list[list[bytes]] = []
    lengths, corners = array("q"), array("q")
    corner_of: dict[tuple[int, int], int] = {}  # (point, normal) → vertex of the part
    seen: dict[bytes, int] = {}  # the same, by the word in the file: most words come six times
    for line in lines_of(re.sub(rb"\\\r?\n", b" ", file.read_bytes())):
        words = line.partition(b"#")[0].split()
        kind = words[0] if words else b""
        if kind in (b"v", b"vn"):
            (points if kind == b"v" else normals).append(words[1:4] if len(words) >= 4 else [b"nan"] * 3)
        elif kind == b"f":
            for word in words[1:]:
                corner = seen.get(word)
                if corner is None:
                    point, _, normal = (*word.split(b"/"), b"", b"")[:3]
                    key = _index(point, len(points)), _index(normal or b"0", len(normals))
                    corner = corner_of.setdefault(key, len(corner_of))
                    if b"-" not in word:  # a relative index means something else on the next line
                        seen[word] = corner
                corners.append(corner)
            lengths.append(len(words) - 1)

    at, towards = np.fromiter(chain.from_iterable(corner_of), np.int64).reshape(-1, 2).T
    triangles = fan(np.array(lengths, np.int64), np.array(corners, np.int64))
    return [Part(
        _picked(points, at) if len(triangles) else _numbers(points),
        triangles,
        _picked(normals, towards) if len(_numbers(normals)) and (towards >= 0).any() else None,
    )]  # fmt: skip


def _index(word: bytes, count: int) -> int:
    """Count from 0; -1 if there is no such item. Below 0 counts back from the last one read so far."""
    if not INDEX.fullmatch(word):
        raise InputError(f"expected corners of faces such as 3, 3/1 or 3//2, got {one_line(word.decode('latin-1'))!r}")
    number = int(word) if len(word) < FAR else MOST
    return min(number, MOST) - 1 if number >= 0 else max(count + number, -1)


def _numbers(rows: list[list[bytes]]) -> NDArray[np.float64]:
    try:
        return concatenated([np.array(rows[some], dtype=np.float64).reshape(-1, 3) for some in pieces(len(rows))])
    except ValueError as error:
        raise InputError(f"expected numbers, got others ({error})") from error


def _picked(rows: list[list[bytes]], at: NDArray[np.int64]) -> NDArray[np.float64]:
    """Rows as numbers, (n, 3); NaN where there is no such row."""
    numbers = np.concatenate([_numbers(rows), [[np.nan] * 3]])
    picked: NDArray[np.float64] = numbers[np.where((at >= 0) & (at < len(rows)), at, -1)]
    return picked
