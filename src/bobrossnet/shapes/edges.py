"""Edges of shapes as curves in space: borders of faces, creases and open boundaries of meshes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.shapes.nurbs import Brep
from bobrossnet.shapes.shape import Shape
from bobrossnet.shapes.splines import Values
from bobrossnet.shapes.tessellation import WELD, border, packed, points_at, welded


class Segments(NamedTuple):
    """Straight pieces of edges."""

    points: Values  # (n, 3), in the shape's units
    ends: NDArray[np.intp]  # (m, 2), indices of points


def edges_of(shape: Shape, step: float) -> Segments:
    """Return the edges of a shape, without silhouettes; empty if a shape has no curves for them, such as a formula.

    Parameters
    ----------
    shape : Shape
    step : number above 0
        Length of the segments of curves, in the shape's units; they are within 1/30 of it.
    """
    if isinstance(shape, Brep):
        return _borders(shape, step)
    if isinstance(shape, Mesh):
        return _creases(shape)
    return Segments(np.empty((0, 3)), np.empty((0, 2), np.intp))


def _borders(brep: Brep, step: float) -> Segments:
    """Return the borders of faces, each once, without seams between pieces of one face."""
    numbers = np.arange(len(brep.faces)) if brep.face_numbers is None else brep.face_numbers
    points, following, owner, count = [], [], [], 0
    for face, number in zip(brep.faces, numbers.tolist(), strict=True):
        for loop in border(face, step):
            points.append(points_at(face, loop))
            following.append(count + np.roll(np.arange(len(loop)), -1))
            owner.append(np.full(len(loop), number))
            count += len(loop)
    space, of = np.concatenate(points), np.concatenate(owner)
    same = welded(space, max(2 * brep.tolerance, WELD * step))
    ends = np.sort(np.stack([same, same[np.concatenate(following)]], axis=1), axis=1)
    kept = ends[:, 0] != ends[:, 1]
    ends, of = ends[kept], of[kept]
    key, first, edge = np.unique(packed(ends), return_index=True, return_inverse=True)
    # A seam has one face on both sides.
    low, high = np.full(len(key), of.max(initial=0)), np.zeros(len(key), of.dtype)
    np.minimum.at(low, edge, of)
    np.maximum.at(high, edge, of)
    is_seam = (np.bincount(edge, minlength=len(key)) > 1) & (low == high)
    return Segments(space, ends[first[~is_seam]])


def _creases(mesh: Mesh) -> Segments:
    """Return edges between triangles where the shading normal jumps, and edges of a single triangle."""
    points, number = np.unique(mesh.vertices, axis=0, return_inverse=True)
    corners = number.reshape(-1)[mesh.triangles]
    normals = np.asarray(mesh.core.corner_normals(), np.float64).reshape(-1, 3, 3)
    sides = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    middle = np.concatenate([normals[:, a] + normals[:, b] for a, b in ((0, 1), (1, 2), (2, 0))])
    middle /= np.maximum(np.linalg.norm(middle, axis=1, keepdims=True), 1e-30)
    kept = sides[:, 0] != sides[:, 1]
    sides, middle = np.sort(sides[kept], axis=1), middle[kept]
    key = packed(sides)
    order = np.argsort(key, kind="stable")
    key, sides, middle = key[order], sides[order], middle[order]
    first = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]]))
    count = np.diff(np.append(first, len(key)))
    other = np.minimum(first + 1, len(key) - 1)
    cosine = (middle[first] * middle[other]).sum(axis=1)
    is_edge = (count != 2) | (cosine < np.cos(np.radians(_core.CREASE_OF_EDGES)))
    return Segments(points, sides[first[is_edge]])
