"""Parts: meshes as files of any format store them, and operations on them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.surface import Surface
from bobrossnet.tracing.instance import Instance, Piece

PIECE = 1 << 16
"""Rows of one numpy call, some milliseconds: Ctrl-C takes effect only between calls."""


def pieces(count: int) -> Iterator[slice]:
    """Return slices of at most `PIECE` rows that cover `count`; at least one."""
    return (slice(start, start + PIECE) for start in range(0, max(count, 1), PIECE))


def converted(values: NDArray[Any], dtype: type) -> NDArray[Any]:
    """Return a copy of an array as another type."""
    result: NDArray[Any] = np.empty(values.shape, dtype)
    for rows in pieces(len(values)):
        result[rows] = values[rows]
    return result


def concatenated(arrays: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Concatenate the rows of at least one array."""
    result: NDArray[Any] = np.empty(
        (sum(map(len, arrays)), *arrays[0].shape[1:]), np.result_type(*{array.dtype for array in arrays})
    )
    at = 0
    for array in arrays:
        for rows in pieces(len(array)):
            some = array[rows]
            result[at : at + len(some)] = some
            at += len(some)
    return result


MAX_DEPTH = 32
"""Maximum depth of a tree of parts; deeper names are left out: paths in a tree of depth n take n² memory."""

Item = TypeVar("Item")


class Found(list[Item]):
    """The parts or instances of a file, and its unit. Next to parts, there may be placed shapes other than meshes."""

    def __init__(self, items: Iterable[Item] = (), unit: str | None = None, shapes: Sequence[Instance] = ()) -> None:
        super().__init__(items)
        self.unit = unit
        self.shapes = shapes


class Names:
    """Names in a tree of parts; siblings have different names."""

    def __init__(self) -> None:
        self._counts: dict[tuple[str, ...], int] = {}

    def path(self, parent: tuple[str, ...], name: str) -> tuple[str, ...]:
        """Return a new path below a parent's; a second part of a name becomes "name 2"."""
        first = path = (*parent[: MAX_DEPTH - 1], name)
        while path in self._counts:
            self._counts[first] += 1
            path = (*first[:-1], f"{name} {self._counts[first]}")
        self._counts[path] = 1
        return path


class Part(NamedTuple):
    """One mesh as the file stores it: indices are unchecked, numbers may not be finite.

    Missing normals are None for the whole part, NaN for single vertices; colours and alphas that are missing or not
    finite are 1.
    """

    vertices: NDArray[np.float64]  # (V, 3)
    triangles: NDArray[np.int64]  # (T, 3)
    normals: NDArray[np.float64] | None = None  # (V, 3)
    colors: NDArray[np.float64] | None = None  # (V, 3), linear RGB
    face_colors: NDArray[np.float64] | None = None  # (T, 3), linear RGB
    alphas: NDArray[np.float64] | None = None  # (V, 1)
    uv: NDArray[np.float64] | None = None  # (V, 2), 0, 0 at the texture's top left
    surface: Surface = Surface()
    runs: tuple[Piece, ...] = ()  # names of all triangles; empty without names


def rows_of(numbers: NDArray[Any], count: int) -> list[NDArray[np.int64]]:
    """Return the rows of each number from 0 to `count` - 1, ascending."""
    ends = np.cumsum(np.bincount(numbers, minlength=count))
    return np.split(np.argsort(numbers, kind="stable"), ends[:-1])


def placed(part: Part, matrix: NDArray[np.float64]) -> Part:
    """Return the part transformed by a (4, 4) matrix, multiplied from the left."""
    linear = matrix[:3, :3]
    mirrored = np.linalg.det(linear) < 0
    normals = part.normals
    if normals is not None:
        # The cofactors are det · inverse transpose; they exist for singular matrices, too.
        a, b, c = linear.T
        cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
        normals = normals @ cofactors.T * (-1.0 if mirrored else 1.0)
    return part._replace(
        vertices=part.vertices @ linear.T + matrix[:3, 3],
        triangles=part.triangles[:, ::-1] if mirrored else part.triangles,  # keeps the outside anticlockwise
        normals=normals,
    )
