"""Joins the parts of a mesh file; keeps the drawable triangles and makes shapes of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.adapters.part import Part, concatenated, pieces, rows_of
from bobrossnet.adapters.surface import Surface
from bobrossnet.shapes.affine import MAX_COORDINATE
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import counted
from bobrossnet.tracing.instance import Instance, Piece
from bobrossnet.tracing.scene import MAX_INSTANCES

FIRST = 64
"""Triangles to look at first for an area: nearly always one has it."""

MAX_TILES = 1 << 12
"""Maximum number of repetitions of a texture from its origin."""


class Joined(NamedTuple):
    part: Part
    """All of the file."""
    surfaces: list[Surface]
    """The different ones."""
    surface: NDArray[np.int32] | None
    """(T,) index of each triangle's surface; None if there is one."""
    paths: tuple[tuple[str, ...], ...] = ()
    """Places in the tree of parts."""
    path: NDArray[np.int32] | None = None
    """(T,) index of each triangle's path; None if there is at most one."""
    unit: str | None = None

    def drawn(self) -> Joined:
        """Return the drawable triangles and their vertices.

        Raises
        ------
        InputError
            If no triangle is drawable.
        """
        vertices, triangles, *_ = self.part
        total = len(triangles)
        if total == 0:
            got = f"a point cloud of {counted(len(vertices), 'point')}" if len(vertices) else "none"
            raise InputError(f"expected triangles, got {got}")
        # Comparisons with NaN are false, so NaN is unusable.
        usable = np.ones(len(vertices), dtype=bool)
        for rows in pieces(len(vertices)):
            usable[rows] = (np.abs(vertices[rows]) <= MAX_COORDINATE).all(axis=1)
        drawn = np.ones(total, dtype=bool)
        for rows in pieces(total):
            corners = triangles[rows]
            drawn[rows] = ((corners >= 0) & usable[corners]).all(axis=1)
        if not drawn.any():
            raise InputError(f"expected triangles, got {total:,} that all touch a missing or non-finite vertex")
        kept = self.of(np.flatnonzero(drawn))
        if not _any_area(kept.part.vertices, kept.part.triangles):
            raise InputError(f"expected triangles with an area, got {len(kept.part.triangles):,} of zero area")
        normals = kept.part.normals
        return kept._replace(part=kept.part._replace(normals=None if normals is None else _unit(normals)))

    def of(self, triangles: NDArray[np.int64]) -> Joined:
        """Return some triangles and their vertices: other vertices must not affect the scene's bounding sphere."""
        part = self.part
        corners = concatenated([part.triangles[triangles[rows]] for rows in pieces(len(triangles))])
        used: NDArray[Any]
        if len(corners) < len(part.vertices) // 8:  # few: avoids work for each vertex of the whole
            used, corners = np.unique(corners, return_inverse=True)
            corners = corners.reshape(-1, 3)
        else:
            used = np.zeros(len(part.vertices), dtype=bool)
            for rows in pieces(len(corners)):
                used[corners[rows]] = True
            renumbered = np.cumsum(used) - 1
            for rows in pieces(len(corners)):
                corners[rows] = renumbered[corners[rows]]

        def some(values: NDArray[Any] | None, which: NDArray[Any]) -> NDArray[Any] | None:
            return None if values is None else values[which]

        return Joined(
            Part(
                part.vertices[used],
                corners,
                some(part.normals, used),
                some(part.colors, used),
                some(part.face_colors, triangles),
                some(part.alphas, used),
                some(part.uv, used),
            ),
            self.surfaces,
            some(self.surface, triangles),
            self.paths,
            some(self.path, triangles),
            self.unit,
        )

    def pieces(self) -> tuple[Piece, ...]:
        """Return the runs of triangles with one path."""
        if self.path is None:
            return tuple(Piece(path) for path in self.paths)
        ends = np.append(np.flatnonzero(np.diff(self.path)) + 1, len(self.path))
        counts = np.diff(ends, prepend=0)
        return tuple(Piece(self.paths[self.path[end - 1]], int(n)) for end, n in zip(ends, counts, strict=True))

    def instances(self, name: str) -> list[Instance]:
        """Return an instance for each surface; several are named as in the file, where it names them.

        Raises
        ------
        InputError
            If there are too many for a scene.
        """
        if len(self.surfaces) > MAX_INSTANCES:
            raise InputError(f"materials: expected at most {MAX_INSTANCES:,}, got {len(self.surfaces):,}")
        if self.surface is None:
            (surface,) = self.surfaces
            return [Instance(_mesh(self.part, surface), material=surface.material, name=name, pieces=self.pieces())]
        instances = []
        whole = self._replace(part=_with_normals(self.part))
        for surface, triangles in zip(self.surfaces, rows_of(self.surface, len(self.surfaces)), strict=True):
            if len(triangles):
                own = whole.of(triangles)
                mesh = _mesh(own.part, surface)
                named = surface.name or name
                instances.append(Instance(mesh, material=surface.material, name=named, pieces=own.pieces()))
        return instances

    def mesh(self) -> Mesh:
        """Return one mesh of all surfaces, with the materials' colours on its triangles."""
        colors = np.array([surface.material.color for surface in self.surfaces])
        part = self.part
        if (colors != 1).any():
            own = np.ones(part.triangles.shape) if part.face_colors is None else part.face_colors
            part = part._replace(face_colors=own * colors[0 if self.surface is None else self.surface])
        return _mesh(part, self.surfaces[0] if self.surface is None else Surface())


def joined(parts: Sequence[Part]) -> Joined:
    """Join all parts of a file; an index outside its part's vertices becomes -1."""
    triangles = [np.empty((0, 3), np.int64)]
    start = 0
    for part in parts:
        for rows in pieces(len(part.triangles)):
            corners = part.triangles[rows]
            # An index past the end of its part must not reach into the next one.
            inside = (corners >= 0) & (corners < len(part.vertices))
            triangles.append(np.where(inside, corners + start, -1))
        start += len(part.vertices)
    part = Part(
        concatenated([np.empty((0, 3)), *(part.vertices for part in parts)]),
        concatenated(triangles),
        _field(parts, "normals", "vertices", 3, np.nan),
        _colors(_field(parts, "colors", "vertices", 3, 1)),
        _colors(_field(parts, "face_colors", "triangles", 3, 1)),
        _colors(_field(parts, "alphas", "vertices", 1, 1)),
        _on_texture(_field(parts, "uv", "vertices", 2, 0)),
    )
    shown = [part.surface if part.uv is not None else part.surface._replace(texture=None) for part in parts]
    places: dict[tuple[Any, ...], int] = {}
    surfaces: list[Surface] = []
    numbers = []
    for surface in shown:
        numbers.append(places.setdefault(surface.look, len(places)))
        if len(places) > len(surfaces):
            surfaces.append(surface)
    of_triangles = None
    if len(surfaces) > 1:
        of_triangles = np.repeat(np.array(numbers, np.int32), [len(part.triangles) for part in parts])
    return Joined(part, surfaces or [Surface()], of_triangles, *_paths(parts), getattr(parts, "unit", None))


def _paths(parts: Sequence[Part]) -> tuple[tuple[tuple[str, ...], ...], NDArray[np.int32] | None]:
    """Return the different paths of all parts, and the index of each triangle's path."""
    shown = [part for part in parts if len(part.triangles)]
    if not shown or not all(part.runs for part in shown):
        return (), None
    places: dict[tuple[str, ...], int] = {}
    runs = [(places.setdefault(path, len(places)), count) for part in shown for path, count in part.runs]
    numbers = np.repeat(*np.array(runs, np.int32).T) if len(places) > 1 else None
    return tuple(places), numbers


def _field(parts: Sequence[Part], name: str, like: str, width: int, fill: float) -> NDArray[np.float64] | None:
    """Return a field of all parts, `fill` for parts without it; None if all parts lack it."""
    fields = []
    for part in parts:
        shape, field = (len(getattr(part, like)), width), getattr(part, name)
        fields.append(field if field is not None and field.shape == shape else np.full(shape, fill))
    any_stored = any(field is getattr(part, name) for part, field in zip(parts, fields, strict=True))
    return concatenated(fields) if any_stored else None


def _colors(values: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
    """Clamp colours or alphas to 0..1; return None if all are 1."""
    if values is None:
        return None
    values = np.clip(np.nan_to_num(values, nan=1), 0, 1)
    return None if (values == 1).all() else values


def _on_texture(uv: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
    """Replace places on a texture by 0, 0 if they are not finite or beyond the precision of float32."""
    return None if uv is None else np.where((np.abs(uv) <= MAX_TILES).all(axis=1, keepdims=True), uv, 0)


def _mesh(part: Part, surface: Surface) -> Mesh:
    colors, cutoff, held = part.colors, surface.alpha_cutoff, dict[str, Any]()
    if surface.texture is not None:
        held |= {"uv": part.uv, "texture": surface.picture, "wrap": surface.texture.wrap}
    if cutoff is not None:
        held["alpha_cutoff"] = cutoff
        if part.alphas is not None:
            colors = np.hstack([np.ones((len(part.vertices), 3)) if colors is None else colors, part.alphas])
    return Mesh(part.vertices, part.triangles, part.normals, colors=colors, face_colors=part.face_colors, **held)


def _with_normals(part: Part) -> Part:
    """Return the part with the computed normals of shading, one vertex per corner.

    So the surface is smooth across materials even if the file has no normals.
    """
    if part.normals is not None and part.normals.any(axis=1).all():
        return part
    normals = None if part.normals is None else part.normals.astype(np.float32)
    shaded = _core.Mesh(part.vertices, part.triangles.astype(np.int32), normals)
    corners = part.triangles.reshape(-1)
    return part._replace(
        vertices=part.vertices[corners],
        triangles=np.arange(len(corners)).reshape(-1, 3),
        normals=shaded.corner_normals().reshape(-1, 3).astype(np.float64),
        colors=None if part.colors is None else part.colors[corners],
        alphas=None if part.alphas is None else part.alphas[corners],
        uv=None if part.uv is None else part.uv[corners],
    )


def _any_area(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> bool:
    """Return whether any triangle has an area, in units of the largest extent."""
    extent = float(np.max(np.ptp(vertices, axis=0))) or 1.0
    for rows in (slice(FIRST), *pieces(len(triangles))):
        a, b, c = (vertices[triangles[rows, corner]] for corner in range(3))
        if np.cross((b - a) / extent, (c - a) / extent).any():
            return True
    return False


def _unit(normals: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Normalize normals, 0 for unusable ones; return None if all are unusable."""
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    usable = (length > 0) & np.isfinite(length)
    return np.where(usable, normals / np.where(usable, length, 1), 0) if usable.any() else None
