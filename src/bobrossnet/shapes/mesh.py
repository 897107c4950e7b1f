"""Triangle meshes."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.errors import InputError, InputTypeError, check_array, check_finite
from bobrossnet.shapes.affine import UPRIGHT, mapped
from bobrossnet.shapes.shape import Shape, check_tensors, frozen


class Mesh(Shape):
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

    kind = "mesh"

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
        self.vertices = frozen(points, np.float64)
        self.triangles = frozen(corners, np.int32)
        self.normals = None
        if normals is not None:
            hint = "one normal per vertex"
            self.normals = frozen(check_array("normals", normals, (len(points), 3), hint=hint), np.float32)

    @cached_property
    def core(self) -> _core.Mesh:
        return _core.Mesh(self.vertices, self.triangles, self.normals)

    def counts(self) -> dict[str, int]:
        return {"triangle": len(self.triangles)}

    def describe(self) -> dict[str, str]:
        computed = "computed: smooth up to the crease angle"
        return {
            "vertices": f"{len(self.vertices):,}",
            "triangles": f"{len(self.triangles):,}",
            "normals": computed if self.normals is None else "stored in the file",
        }

    def tensors(self) -> dict[str, NDArray[Any]]:
        tensors: dict[str, NDArray[Any]] = {"vertices": self.vertices, "triangles": self.triangles}
        return tensors if self.normals is None else {**tensors, "normals": self.normals}

    @classmethod
    def from_tensors(cls, tensors: Mapping[str, NDArray[Any]]) -> Mesh:
        check_tensors(tensors, {"vertices": "float64", "triangles": "int32"}, {"normals": "float32"})
        return cls(tensors["vertices"], tensors["triangles"], tensors.get("normals"))

    def turned_upright(self) -> Mesh:
        """The mesh with its y axis turned up to z: (x, y, z) becomes (x, -z, y)."""
        normals = None if self.normals is None else mapped(UPRIGHT, self.normals)
        return Mesh(mapped(UPRIGHT, self.vertices), self.triangles, normals)

    def __repr__(self) -> str:
        return f"Mesh({len(self.vertices)} vertices, {len(self.triangles)} triangles)"
