"""Triangle meshes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.errors import InputError, InputTypeError, check_array, check_finite


class Mesh:
    """A triangle mesh.

    Parameters
    ----------
    vertices : (V, 3) numbers, finite
        Positions, in any unit; right-handed, z up.
    triangles : (T, 3) integers in 0..V-1
        Corners of each triangle, anticlockwise seen from outside (both sides are visible all the same).
    normals : (V, 3) numbers, optional
        Vertex normals of any length. Without them, or where one is zero or not finite, the tracer smooths over edges
        whose faces meet at less than the crease angle (CONVENTIONS.md) and leaves sharper edges sharp.

    Raises
    ------
    InputError
        If a shape, a value or an index is out of range; the message names it.
    """

    __slots__ = ("normals", "triangles", "vertices")

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    normals: NDArray[np.float32] | None

    def __init__(self, vertices: Any, triangles: Any, normals: Any = None) -> None:
        points = check_finite("vertices", check_array("vertices", vertices, (None, 3)))
        corners = check_array("triangles", triangles, (None, 3))
        if corners.dtype.kind not in "iu":
            raise InputTypeError(f"triangles: expected integers, got dtype {corners.dtype}")
        if len(corners) == 0:
            raise InputError("triangles: expected at least one triangle, got none")
        if corners.min() < 0 or corners.max() >= len(points):
            raise InputError(
                f"triangles: expected indices in 0..{len(points) - 1}, got {corners.min()}..{corners.max()}"
            )
        self.vertices = np.ascontiguousarray(points, dtype=np.float64)
        self.triangles = np.ascontiguousarray(corners, dtype=np.int32)
        self.normals = None
        if normals is not None:
            hint = "one normal per vertex"
            self.normals = np.ascontiguousarray(
                check_array("normals", normals, (len(points), 3), hint=hint), dtype=np.float32
            )

    def used_vertices(self) -> NDArray[np.float64]:
        """The vertices that a triangle uses, (n, 3)."""
        used = np.zeros(len(self.vertices), np.bool_)
        used[self.triangles] = True
        return self.vertices[used]

    def turned_upright(self) -> Mesh:
        """The mesh with its y axis turned up to z: (x, y, z) becomes (x, -z, y)."""
        turn = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
        return Mesh(self.vertices @ turn, self.triangles, None if self.normals is None else self.normals @ turn)

    def __repr__(self) -> str:
        return f"Mesh({len(self.vertices)} vertices, {len(self.triangles)} triangles)"
