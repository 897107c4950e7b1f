"""Triangle meshes."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.atomic import check_writable, write_whole
from bobrossnet.color import from_srgb, to_srgb
from bobrossnet.errors import InputError, InputTypeError, check_array, check_finite
from bobrossnet.shapes.affine import UPRIGHT, mapped
from bobrossnet.shapes.shape import Shape, check_tensors, frozen

FORMATS = (".stl", ".ply", ".obj", ".glb")
"""The endings of files that meshes are written to."""

WRAPS = ("repeat", "clamp", "mirror")
"""What may lie beyond a texture's edges."""

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
    colors, face_colors : (V, 3) and (T, 3) numbers in 0..1, or uint8, optional
        Of vertices, blended between them, and of triangles: linear RGB, or sRGB as uint8. They and the texture are
        multiplied, as is the material's colour.
    uv : (V, 2) numbers, finite, optional
        Where on the texture each vertex is: 0, 0 at its top left, 1, 1 at its bottom right.
    texture : (H, W, 3) uint8, optional
        sRGB, row 0 at the top; comes with `uv`. Seen from afar, smaller pictures made of it are taken.
    wrap : "repeat", "clamp" or "mirror", or two of these
        What lies beyond the texture's edges, across and down.

    Raises
    ------
    InputError
        If a shape, a value or an index is out of range; the message names it.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> corners, triangles = [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]
    >>> rgb = bob.Mesh(corners, triangles, colors=[(1, 0, 0), (0, 1, 0), (0, 0, 1)])
    >>> bob.trace(rgb, bob.Camera(elevation=90), size=(40, 40)).channels
    ('mask', 'gray', 'depth', 'normal', 'color', 'albedo')
    """

    kind = "mesh"

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    normals: NDArray[np.float32] | None
    colors: NDArray[np.float32] | None = None
    """Linear RGB."""
    face_colors: NDArray[np.float32] | None = None
    """Linear RGB."""
    uv: NDArray[np.float32] | None = None
    texture: NDArray[np.uint8] | None = None
    wrap: tuple[str, str] = ("repeat", "repeat")

    def __init__(
        self,
        vertices: Any,
        triangles: Any,
        normals: Any = None,
        *,
        colors: Any = None,
        face_colors: Any = None,
        uv: Any = None,
        texture: Any = None,
        wrap: str | Sequence[str] = "repeat",
    ) -> None:
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
        if colors is not None:
            self.colors = _linear("colors", colors, len(points), "one colour per vertex")
        if face_colors is not None:
            self.face_colors = _linear("face_colors", face_colors, len(corners), "one colour per triangle")
        if (uv is None) != (texture is None):
            raise InputError(f"uv: expected uv and texture together, got {'texture' if uv is None else 'uv'} alone")
        if uv is not None:
            places = check_finite("uv", check_array("uv", uv, (len(points), 2), hint="one place per vertex"))
            self.uv = frozen(places, np.float32)
            texels = check_array("texture", texture, (None, None, 3), hint="red, green and blue last")
            if texels.dtype != np.uint8 or texels.size == 0:
                raise InputTypeError(
                    f"texture: expected uint8 of at least one texel, got {texels.dtype} {texels.shape}"
                )
            self.texture = frozen(texels, np.uint8)
            across, down = (wrap, wrap) if isinstance(wrap, str) else wrap
            if across not in WRAPS or down not in WRAPS:
                raise InputError(f"wrap: expected {', '.join(WRAPS)}, or two of these, got {wrap!r}")
            self.wrap = (across, down)

    @classmethod
    def owning(
        cls,
        vertices: NDArray[np.float64],
        triangles: NDArray[np.int32],
        colors: NDArray[np.float32] | None = None,
        face_colors: NDArray[np.float32] | None = None,
    ) -> Mesh:
        """A mesh that takes over arrays that are right, unchecked and without a copy."""
        mesh = object.__new__(cls)
        vertices.flags.writeable = triangles.flags.writeable = False
        mesh.vertices, mesh.triangles, mesh.normals = vertices, triangles, None
        for array in (colors, face_colors):
            if array is not None:
                array.flags.writeable = False
        mesh.colors, mesh.face_colors = colors, face_colors
        return mesh

    @cached_property
    def core(self) -> _core.Mesh:
        texture = None if self.texture is None else _core.Texture(self.texture, *self.wrap)
        return _core.Mesh(self.vertices, self.triangles, self.normals, self.colors, self.face_colors, self.uv, texture)

    @property
    def is_colored(self) -> bool:
        return not (self.colors is None and self.face_colors is None and self.texture is None)

    def counts(self) -> dict[str, int]:
        return {"triangle": len(self.triangles)}

    def describe(self) -> dict[str, str]:
        computed = "computed: smooth up to the crease angle"
        return {
            "vertices": f"{len(self.vertices):,}",
            "triangles": f"{len(self.triangles):,}",
            "normals": computed if self.normals is None else "stored in the file",
            **({"colours": self._colors()} if self.is_colored else {}),
        }

    def _colors(self) -> str:
        texture = "" if self.texture is None else f"a texture of {self.texture.shape[1]} x {self.texture.shape[0]}"
        parts = (
            texture,
            "vertices" if self.colors is not None else "",
            "faces" if self.face_colors is not None else "",
        )
        return "of " + ", ".join(filter(None, parts))

    def tensors(self) -> dict[str, NDArray[Any]]:
        tensors: dict[str, NDArray[Any]] = {"vertices": self.vertices, "triangles": self.triangles}
        for name in ("normals", "colors", "face_colors", "uv"):
            tensor = getattr(self, name)
            if tensor is not None:
                tensors[name] = tensor
        if self.texture is not None:
            tensors["texture"] = self.texture.reshape(-1, 3)
            wrap = [WRAPS.index(wrap) for wrap in self.wrap]
            tensors["texture_layout"] = np.array([*self.texture.shape[:2], *wrap], np.int32)
        return tensors

    @classmethod
    def from_tensors(cls, tensors: Mapping[str, NDArray[Any]]) -> Mesh:
        optional = {"normals": "float32", "colors": "float32", "face_colors": "float32", "uv": "float32"}
        of_texture = {"texture": "uint8", "texture_layout": "int32"}
        check_tensors(tensors, {"vertices": "float64", "triangles": "int32"}, {**optional, **of_texture})
        held: dict[str, Any] = dict(tensors)
        if of_texture.keys() & held.keys():
            texture = check_array("texture", held.get("texture"), (None, 3))
            layout = check_array("texture_layout", held.pop("texture_layout", None), (4,))
            height, width, *wrap = map(int, layout)
            if not (height > 0 and width > 0 and height * width == len(texture) and set(wrap) <= {0, 1, 2}):
                raise InputError(f"texture_layout: expected height, width and two of 0, 1, 2, got {layout.tolist()}")
            held |= {"texture": texture.reshape(height, width, 3), "wrap": [WRAPS[i] for i in wrap]}
        return cls(held.pop("vertices"), held.pop("triangles"), **held)

    def mesh(self, step: float | None = None) -> Mesh:
        """Itself, whatever the step."""
        return self

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the mesh to a file, with its normals and its colours if it has any and the format does.

        Parameters
        ----------
        path : str or path
            Ends in .stl or .ply (both binary), .obj or .glb. GLB is y-up by its specification, and the mesh is turned
            to that; readers turn it back. STL holds float32 alone, the others do so for normals. Colours are those of
            vertices, 8 bits, linear in GLB, sRGB in PLY and OBJ; STL has none. Where triangles of several colours meet,
            vertices are written once for each. Textures are left out.

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

        mesh = self if ending == "stl" else self._with_colors_at_vertices()
        upright = UPRIGHT.T if ending == "glb" else np.eye(4)
        normals = None if mesh.normals is None else mapped(upright, mesh.normals)
        vertices = mesh.vertices if ending != "glb" else mapped(upright, mesh.vertices)
        colors = None if ending == "stl" else mesh.colors
        if colors is not None:
            colors = np.rint(255 * (colors if ending == "glb" else to_srgb(colors))).astype(np.uint8)
        written = trimesh.Trimesh(
            vertices, mesh.triangles, vertex_normals=normals, vertex_colors=colors, process=False, validate=False
        )
        content = written.export(file_type=ending)
        assert not isinstance(content, dict)  # as glTF would be, in several files
        write_whole(path, content.encode() if isinstance(content, str) else content)

    def _with_colors_at_vertices(self) -> Mesh:
        """The same without colours of triangles: a vertex stands once for each colour of the triangles around it."""
        if self.face_colors is None:
            return self
        palette, color = np.unique(self.face_colors, axis=0, return_inverse=True)
        corners = self.triangles * np.int64(len(palette)) + color.reshape(-1, 1)
        used, triangles = np.unique(corners, return_inverse=True)
        vertex, color = np.divmod(used, len(palette))
        colors = palette[color] if self.colors is None else palette[color] * self.colors[vertex]
        normals = None if self.normals is None else self.normals[vertex]
        return Mesh(self.vertices[vertex], triangles.reshape(-1, 3), normals, colors=colors)

    def turned_upright(self) -> Mesh:
        """The mesh with its y axis turned up to z: (x, y, z) becomes (x, -z, y)."""
        turned = self.tensors()
        turned["vertices"] = mapped(UPRIGHT, self.vertices)
        if self.normals is not None:
            turned["normals"] = np.asarray(mapped(UPRIGHT, self.normals), np.float32)
        return Mesh.from_tensors(turned)

    def __repr__(self) -> str:
        return f"Mesh({len(self.vertices)} vertices, {len(self.triangles)} triangles)"


def _linear(name: str, colors: Any, count: int, hint: str) -> NDArray[np.float32]:
    """Linear RGB of what users give, one for each of `count`."""
    array = check_finite(name, check_array(name, colors, (count, 3), hint=hint))
    if array.dtype == np.uint8:
        array = from_srgb(array / 255)
    elif array.size and not (array.min() >= 0 and array.max() <= 1):
        raise InputError(f"{name}: expected numbers in 0..1, or uint8, got {array.min():g}..{array.max():g}")
    return frozen(array, np.float32)


def check_mesh_path(path: str | os.PathLike[str]) -> Path:
    """Return the path of a mesh that can be written; raise InputError if its ending or its folder is none."""
    return check_writable(path, "a mesh", FORMATS)
