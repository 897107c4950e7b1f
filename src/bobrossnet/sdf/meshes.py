"""Meshes as shapes of the modelling language, by exact distances."""

from __future__ import annotations

import os

from bobrossnet import _core
from bobrossnet.sdf.d3 import SDF3
from bobrossnet.shapes import mesh as shapes
from bobrossnet.support.errors import InputError, check_number


class Mesh(shapes.Mesh):
    """A triangle mesh that converts to a shape of the language.

    >>> from bobrossnet.sdf import *
    >>> corners, triangles = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    >>> f = Mesh(corners, triangles).sdf().dilate(0.1) - sphere(0.5)
    >>> f([(0.1, 0.2, 1), (-1, 0, 0)]).round(3).tolist()
    [[0.073], [0.9]]

    Parameters
    ----------
    vertices, triangles, and the other parameters of `bobrossnet.Mesh`
    """

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> Mesh:
        """Read a mesh from a file, as `bobrossnet.load_mesh` does, with the same errors.

        Parameters
        ----------
        path : str or path
            Ends in .stl, .ply, .obj, .off, .glb, .gltf or .3mf.
        """
        from bobrossnet.adapters.files import load_mesh  # it also loads programs of this language

        read = load_mesh(path)
        mesh = cls.from_tensors(read.tensors_apart(), read.picture)
        assert isinstance(mesh, Mesh)
        return mesh

    def sdf(self, voxel_size: float | None = None, half_width: float | None = None) -> SDF3:
        """Return the mesh as a shape: the signed distance from its triangles, in the mesh's units.

        Distances are exact everywhere, for vertices rounded to 1e-7 of the mesh's size. Vertices
        within 1e-12 of the size are merged.
        Points with a nonzero winding number are inside, so parts may overlap. Colours, normals and textures are
        dropped.

        Parameters
        ----------
        voxel_size, half_width : number above 0, optional
            Grid options of fogleman/sdf, ignored here.

        Returns
        -------
        SDF3

        Raises
        ------
        InputError
            If the mesh is not closed, or triangles that share an edge are wound inconsistently: then the inside is
            undefined.
        """
        for name, value in (("voxel_size", voxel_size), ("half_width", half_width)):
            if value is not None:
                check_number(name, value, 0, above=True)
        try:
            return SDF3(_core.distance_to_mesh(shapes.rounded(self.vertices), self.triangles))
        except ValueError as error:
            raise InputError(f"mesh: {error}") from None


__all__ = ["Mesh"]
