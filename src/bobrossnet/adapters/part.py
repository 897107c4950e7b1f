"""Parts: what readers of mesh files make, as the file stores it, and what is done to those of any format."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.surface import Surface
from bobrossnet.support.errors import InputError

# Instances can repeat one part without end; this many triangles and vertices still fit into a few GB.
MAX_ITEMS = 100_000_000

PIECE = 1 << 16
"""Rows that are worked on in one go, since Ctrl-C is noticed only afterwards: some milliseconds."""


def pieces(count: int) -> Iterator[slice]:
    """Slices of at most `PIECE` rows that are all of `count`; an empty one of none."""
    return (slice(start, start + PIECE) for start in range(0, max(count, 1), PIECE))


def converted(values: NDArray[Any], dtype: type) -> NDArray[Any]:
    """A copy of an array as another type."""
    result: NDArray[Any] = np.empty(values.shape, dtype)
    for rows in pieces(len(values)):
        result[rows] = values[rows]
    return result


def concatenated(arrays: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """At least one array's rows, and those of the others behind them."""
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


def lines_of(data: bytes) -> Iterator[bytes]:
    """The lines of a text, whatever they end with. They are not all in memory at once."""
    text = io.BytesIO(data)
    while some := text.read(1 << 20) + text.readline():
        yield from some.splitlines()


class Part(NamedTuple):
    """One mesh of a file, as it came: indices unchecked, numbers perhaps not finite.

    Missing normals are None for the whole part, NaN for single vertices; colours and alphas that are missing or not
    finite are 1.
    """

    vertices: NDArray[np.float64]  # (V, 3)
    triangles: NDArray[np.int64]  # (T, 3)
    normals: NDArray[np.float64] | None = None  # (V, 3)
    colors: NDArray[np.float64] | None = None  # (V, 3), linear RGB
    face_colors: NDArray[np.float64] | None = None  # (T, 3), linear RGB
    alphas: NDArray[np.float64] | None = None  # (V, 1)
    uv: NDArray[np.float64] | None = None  # (V, 2), of the surface's texture, from its top left on
    surface: Surface = Surface()


def fan(lengths: NDArray[np.int64], corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cut polygons into fans of triangles, (T, 3).

    Parameters
    ----------
    lengths : (n,) int64, 0 or above
        Corners of each polygon; those with fewer than 3 make no triangle.
    corners : (sum of lengths,) int64
        The corners of all polygons, one polygon after another.
    """
    if (lengths == 3).all():
        return corners.reshape(-1, 3)
    cuts = np.maximum(lengths - 2, 0)
    first = np.repeat(np.cumsum(lengths) - lengths, cuts)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(cuts) - cuts, cuts)
    triangles = np.empty((len(first), 3), np.int64)
    for rows in pieces(len(first)):
        a, b = first[rows], second[rows]
        triangles[rows] = np.stack([corners[a], corners[b], corners[b + 1]], axis=1)
    return triangles


def of_triangles(values: NDArray[Any], lengths: NDArray[np.int64]) -> NDArray[Any]:
    """What polygons have, (n, ...), for each triangle of their fans."""
    return values if (lengths == 3).all() else np.repeat(values, np.maximum(lengths - 2, 0), axis=0)


def rows_of(numbers: NDArray[Any], count: int) -> list[NDArray[np.int64]]:
    """The rows that have each of the numbers 0 to `count` - 1, ascending."""
    ends = np.cumsum(np.bincount(numbers, minlength=count))
    return np.split(np.argsort(numbers, kind="stable"), ends[:-1])


def placed(part: Part, matrix: NDArray[np.float64]) -> Part:
    """The part moved by a (4, 4) matrix that is multiplied from the left."""
    linear = matrix[:3, :3]
    mirrored = np.linalg.det(linear) < 0
    normals = part.normals
    if normals is not None:
        # The cofactors are det · inverse transpose, and exist where a part is pressed flat.
        a, b, c = linear.T
        cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
        normals = normals @ cofactors.T * (-1.0 if mirrored else 1.0)
    return part._replace(
        vertices=part.vertices @ linear.T + matrix[:3, 3],
        triangles=part.triangles[:, ::-1] if mirrored else part.triangles,  # the outside stays anticlockwise
        normals=normals,
    )


def counted(total: int, more: int) -> int:
    """`total + more`, unless that exceeds `MAX_ITEMS`: stops before a file of copies fills the memory."""
    if total + more > MAX_ITEMS:
        raise InputError(f"expected at most {MAX_ITEMS:,} triangles and vertices in all its parts, got more")
    return total + more
