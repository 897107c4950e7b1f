"""Triangle meshes."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import from_srgb, to_srgb
from bobrossnet.shapes.affine import UPRIGHT, mapped
from bobrossnet.shapes.picture import Picture, channels_of, picture_of
from bobrossnet.shapes.shape import Shape, check_tensors, frozen
from bobrossnet.support.atomic import check_writable, write_whole
from bobrossnet.support.errors import InputError, InputTypeError, brief, check_array, check_finite, check_number
from bobrossnet.support.messages import counted
from bobrossnet.support.threads import lazy

FORMATS = (".stl", ".ply", ".obj", ".glb")
"""File endings for saving meshes."""

WRAPS = ("repeat", "clamp", "mirror")
"""Wrap modes of a texture."""

MAX_TRIANGLES = 2**25
"""Maximum number of triangles of tessellated shapes: 1 GB."""

SAME = 1e-12
"""Distance of vertices that count as one, in sizes of the mesh. CAD systems write zeros as 1e-16 in one triangle and as
3e-16 in its neighbour. A larger one would be an error above that of rounding."""


class Mesh(Shape):
    """A triangle mesh.

    Parameters
    ----------
    vertices : (V, 3) numbers, finite
        Positions, in any unit; right-handed, z up.
    triangles : (T, 3) integers in 0..V-1
        Corners of each triangle, anticlockwise seen from outside (both sides are visible anyway).
    normals : (V, 3) numbers, optional
        Vertex normals of any length. If omitted, or where one is zero or not finite, the tracer smooths over edges with
        a dihedral angle below the crease angle (docs/reference/meshes.md) and keeps sharper edges sharp.
    colors, face_colors : (V, 3) and (T, 3) numbers in 0..1, or uint8, optional
        Colours of vertices, interpolated, and of triangles: linear RGB, or sRGB as uint8. They, the texture and the
        material's colour are multiplied. Vertex colours may have an alpha, (V, 4).
    uv : (V, 2) numbers, finite, optional
        Texture coordinates of each vertex: 0, 0 at the texture's top left, 1, 1 at its bottom right.
    texture : (H, W, 3) or (H, W, 4) uint8, optional
        sRGB, with or without alpha; row 0 at the top; needs `uv`. Sampled by mipmaps. Meshes given the same array share
        one copy of it.
    wrap : "repeat", "clamp" or "mirror", or two of these
        Continuation of the texture beyond its edges, horizontally and vertically.
    alpha_cutoff : number in 0..1
        With an alpha: where the texture's alpha times the vertices' is below it, the surface has a hole.

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
    """(V, 3), linear RGB."""
    face_colors: NDArray[np.float32] | None = None
    """(T, 3), linear RGB."""
    alphas: NDArray[np.float32] | None = None
    """Alpha of vertices, (V,)."""
    uv: NDArray[np.float32] | None = None
    picture: Picture | None = None
    """Texels of the texture, possibly shared by other meshes."""
    wrap: tuple[str, str] = ("repeat", "repeat")
    alpha_cutoff: float = 0.5

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
        alpha_cutoff: float = 0.5,
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
            self.colors, self.alphas = _linear(
                "colors", colors, len(points), "one colour per vertex", channels_of(colors)
            )
        if face_colors is not None:
            self.face_colors, _ = _linear("face_colors", face_colors, len(corners), "one colour per triangle")
        if (uv is None) != (texture is None):
            raise InputError(f"uv: expected uv and texture together, got {'texture' if uv is None else 'uv'} alone")
        if uv is not None:
            places = check_finite("uv", check_array("uv", uv, (len(points), 2), hint="one place per vertex"))
            self.uv = frozen(places, np.float32)
            self.picture = picture_of(texture)
            self.wrap = _wraps(wrap)
        self.alpha_cutoff = check_number("alpha_cutoff", alpha_cutoff, 0, 1)

    @classmethod
    def owning(
        cls,
        vertices: NDArray[np.float64],
        triangles: NDArray[np.int32],
        colors: NDArray[np.float32] | None = None,
        face_colors: NDArray[np.float32] | None = None,
    ) -> Mesh:
        """Make a mesh of valid arrays, without checks or a copy."""
        mesh = object.__new__(cls)
        vertices.flags.writeable = triangles.flags.writeable = False
        mesh.vertices, mesh.triangles, mesh.normals = vertices, triangles, None
        for array in (colors, face_colors):
            if array is not None:
                array.flags.writeable = False
        mesh.colors, mesh.face_colors = colors, face_colors
        return mesh

    @lazy
    def core(self) -> _core.Mesh:
        texture = None if self.picture is None else _core.Texture(self.picture.core, *self.wrap)
        cut = self.alphas, self.alpha_cutoff
        of_vertices = self.normals, self.colors, self.face_colors, self.uv
        return _core.Mesh(self.vertices, self.triangles, *of_vertices, texture, *cut)

    @property
    def texture(self) -> NDArray[np.uint8] | None:
        """(H, W, 3)."""
        return None if self.picture is None else self.picture.texels

    @property
    def texture_alpha(self) -> NDArray[np.uint8] | None:
        """(H, W)."""
        return None if self.picture is None else self.picture.alpha

    def digested(self) -> dict[str, NDArray[Any]]:
        if self.picture is None:
            return self.tensors()
        return self.tensors_apart() | {"picture": np.frombuffer(self.picture.digest, np.uint8)}

    @property
    def is_colored(self) -> bool:
        return not (self.colors is None and self.face_colors is None and self.picture is None)

    @property
    def has_alpha(self) -> bool:
        """Whether the mesh may have holes, where its alpha is below the cutoff."""
        return not (self.alphas is None and self.texture_alpha is None)

    def counts(self) -> dict[str, int]:
        return {"triangle": len(self.triangles)}

    def describe(self) -> dict[str, str]:
        computed = "computed: smooth up to the crease angle"
        return {
            "vertices": f"{len(self.vertices):,}",
            "triangles": f"{len(self.triangles):,}",
            "normals": computed if self.normals is None else "stored in the file",
            **({"colours": self._colors()} if self.is_colored else {}),
            **({"cut out": f"where alpha is below {self.alpha_cutoff:.6g}"} if self.has_alpha else {}),
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
        tensors = self.tensors_apart()
        if self.picture is not None:
            tensors["texture"] = self.picture.texels.reshape(-1, 3)
            if self.picture.alpha is not None:
                tensors["texture_alpha"] = self.picture.alpha.reshape(-1)
        return tensors

    def tensors_apart(self) -> dict[str, NDArray[Any]]:
        """The tensors without the picture's texels."""
        tensors: dict[str, NDArray[Any]] = {"vertices": self.vertices, "triangles": self.triangles}
        for name in ("normals", "colors", "face_colors", "alphas", "uv"):
            tensor = getattr(self, name)
            if tensor is not None:
                tensors[name] = tensor
        if self.picture is not None:
            wrap = [WRAPS.index(wrap) for wrap in self.wrap]
            tensors["texture_layout"] = np.array([*self.picture.texels.shape[:2], *wrap], np.int32)
        if self.has_alpha:
            tensors["alpha_cutoff"] = np.array([self.alpha_cutoff])
        return tensors

    @classmethod
    def from_tensors(cls, tensors: Mapping[str, NDArray[Any]], picture: Picture | None = None) -> Mesh:
        """Rebuild the mesh from `tensors`, or from `tensors_apart` and the picture."""
        optional = {"normals": "float32", "colors": "float32", "face_colors": "float32", "uv": "float32"}
        of_picture = {} if picture else {"texture": "uint8", "texture_alpha": "uint8"}
        others = {"texture_layout": "int32", "alphas": "float32", "alpha_cutoff": "float64"}
        check_tensors(tensors, {"vertices": "float64", "triangles": "int32"}, optional | of_picture | others)
        held: dict[str, Any] = dict(tensors)
        texture, alpha, layout, alphas, cutoff = (
            held.pop(name, None) for name in ("texture", "texture_alpha", "texture_layout", "alphas", "alpha_cutoff")
        )
        is_cut_out = alpha is not None or (picture is not None and picture.alpha is not None)
        if (cutoff is None) != (alphas is None and not is_cut_out):
            raise InputError("alpha_cutoff: expected alphas or texture_alpha together with it")
        if cutoff is not None:
            held["alpha_cutoff"] = float(check_array("alpha_cutoff", cutoff, (1,))[0])
        if alphas is not None:
            colors = check_array("colors", held.get("colors"), (None, 3))
            held["colors"] = np.column_stack([colors, check_array("alphas", alphas, (len(colors),))])
        if picture is not None or texture is not None or layout is not None or alpha is not None:
            if picture is None:
                texture = check_array("texture", texture, (None, 3))
            layout = check_array("texture_layout", layout, (4,))
            height, width, *wrap = map(int, layout)
            fits = height * width == len(texture) if picture is None else (height, width) == picture.texels.shape[:2]
            if not (height > 0 and width > 0 and fits and set(wrap) <= {0, 1, 2}):
                raise InputError(f"texture_layout: expected height, width and two of 0, 1, 2, got {layout.tolist()}")
            if picture is None:
                if alpha is not None:
                    alpha = frozen(check_array("texture_alpha", alpha, (len(texture),)), np.uint8)
                    alpha = alpha.reshape(height, width)
                picture = Picture(frozen(texture, np.uint8).reshape(height, width, 3), alpha)
            held |= {"texture": picture, "wrap": [WRAPS[i] for i in wrap]}
        return cls(held.pop("vertices"), held.pop("triangles"), **held)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self).from_tensors, (self.tensors_apart(), self.picture)  # copies share the picture

    def mesh(self, step: float | None = None) -> Mesh:
        """Return the mesh itself; `step` is ignored."""
        return self

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the mesh to a file, with its normals, and its colours if the format has colours.

        Parameters
        ----------
        path : str or path
            Ends in .stl or .ply (both binary), .obj or .glb. GLB is y-up by its specification, and the mesh is rotated
            to it; readers rotate it back. STL stores float32; the other formats store float32 normals. Colours are
            stored per vertex in 8 bits, linear in GLB, sRGB in PLY and OBJ; STL has no colours. Where triangles of
            different colours meet, vertices are duplicated. Textures and alpha are omitted.

        Raises
        ------
        InputError
            If the ending is unknown, or the file can't be written.

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
        assert not isinstance(content, dict)  # only glTF would be, in several files
        write_whole(path, content.encode() if isinstance(content, str) else content)

    def _with_colors_at_vertices(self) -> Mesh:
        """Replace triangle colours by vertex colours: a vertex is repeated for each colour of its triangles."""
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
        """Return the mesh rotated from y up to z up: (x, y, z) becomes (x, -z, y)."""
        turned = self.tensors_apart()
        turned["vertices"] = mapped(UPRIGHT, self.vertices)
        if self.normals is not None:
            turned["normals"] = np.asarray(mapped(UPRIGHT, self.normals), np.float32)
        return Mesh.from_tensors(turned, self.picture)

    def __repr__(self) -> str:
        return f"Mesh({len(self.vertices)} vertices, {counted(len(self.triangles), 'triangle')})"


def rounded(vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return vertices rounded to `SAME`, so that vertices of one place are equal."""
    step = SAME * max(float(np.ptp(vertices, axis=0).max()), 1e-300)
    return np.rint(vertices / step) * step + 0.0


def _linear(
    name: str, colors: Any, count: int, hint: str, channels: int = 3
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
    """Convert a user's `count` colours to linear RGB, and the alpha if there are four channels."""
    array = check_finite(name, check_array(name, colors, (count, channels), hint=hint))
    if array.dtype == np.uint8:
        array = array / 255
        array[:, :3] = from_srgb(array[:, :3])
    elif array.size and not (array.min() >= 0 and array.max() <= 1):
        raise InputError(f"{name}: expected numbers in 0..1, or uint8, got {array.min():g}..{array.max():g}")
    return frozen(array[:, :3], np.float32), frozen(array[:, 3], np.float32) if channels == 4 else None


def _wraps(wrap: Any) -> tuple[str, str]:
    """Return the horizontal and vertical wrap modes."""
    both = (wrap, wrap) if isinstance(wrap, str) else wrap
    if not isinstance(both, Sequence) or len(both) != 2 or not all(one in WRAPS for one in both):
        raise InputError(f"wrap: expected {', '.join(WRAPS)}, or two of these, got {brief(wrap)}")
    across, down = both
    return across, down


def check_mesh_path(path: str | os.PathLike[str]) -> Path:
    """Return the path of a mesh to write; raise InputError for an unknown ending or a missing folder."""
    return check_writable(path, "a mesh", FORMATS)
