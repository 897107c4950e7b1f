"""Triangle meshes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.atomic import check_writable, write_whole
from bobrossnet.errors import InputError, InputTypeError, check_array, check_finite
from bobrossnet.shapes.affine import UPRIGHT, mapped
from bobrossnet.shapes.shape import Shape, check_tensors, frozen

FORMATS = (".stl", ".ply", ".obj", ".glb")
"""The endings of files that meshes are written to."""

MAX_TRIANGLES = 2**25
"""Of the meshes of other shapes: a GB."""


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

    @classmethod
    def owning(cls, vertices: NDArray[np.float64], triangles: NDArray[np.int32]) -> Mesh:
        """A mesh that takes over arrays that are right, unchecked and without a copy."""
        mesh = object.__new__(cls)
        vertices.flags.writeable = triangles.flags.writeable = False
        mesh.vertices, mesh.triangles, mesh.normals = vertices, triangles, None
        return mesh

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

    def mesh(self, step: float | None = None) -> Mesh:
        """Itself, whatever the step."""
        return self

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the mesh to a file, with its normals if it has any and the format does.

        Parameters
        ----------
        path : str or path
            Ends in .stl or .ply (both binary), .obj or .glb. GLB is y-up by its specification, and the mesh is turned
            to that; readers turn it back. STL holds float32 alone, the others do so for normals.

        Raises
        ------
        InputError
            If the ending is another, or the file can't be written.

        Examples
        --------
        >>> import bobrossnet as bob
        >>> bob.happy_tree().save("tree.glb")  # doctest: +SKIP
        """
        ending = check_mesh_path(path).suffix.lower()[1:]
        import trimesh  # takes longer to import than the package

        upright = UPRIGHT.T if ending == "glb" else np.eye(4)
        normals = None if self.normals is None else mapped(upright, self.normals)
        vertices = self.vertices if ending != "glb" else mapped(upright, self.vertices)
        written = trimesh.Trimesh(vertices, self.triangles, vertex_normals=normals, process=False, validate=False)
        content = written.export(file_type=ending)
        assert not isinstance(content, dict)  # as glTF would be, in several files
        write_whole(path, content.encode() if isinstance(content, str) else content)

    def turned_upright(self) -> Mesh:
        """The mesh with its y axis turned up to z: (x, y, z) becomes (x, -z, y)."""
        normals = None if self.normals is None else mapped(UPRIGHT, self.normals)
        return Mesh(mapped(UPRIGHT, self.vertices), self.triangles, normals)

    def __repr__(self) -> str:
        return f"Mesh({len(self.vertices)} vertices, {len(self.triangles)} triangles)"


def check_mesh_path(path: str | os.PathLike[str]) -> Path:
    """Return the path of a mesh that can be written; raise InputError if its ending or its folder is none."""
    if Path(path).suffix.lower() not in FORMATS:
        got = Path(path).suffix or "none"
        raise InputError(f"{path}: expected a mesh's ending ({' '.join(FORMATS)}), got {got}")
    return check_writable(path)
