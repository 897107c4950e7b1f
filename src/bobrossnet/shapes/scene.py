"""Scenes: what a camera looks at."""

from __future__ import annotations

import os
from collections.abc import Iterable
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.errors import InputError, InputTypeError, check_array, check_finite
from bobrossnet.shapes.mesh import Mesh

Shape: TypeAlias = Mesh
SceneLike: TypeAlias = "Scene | Shape | Iterable[Scene | Shape]"


class Scene:
    """Shapes in one space, and the bounding sphere that cameras orbit.

    The sphere's centre is that of the axis-aligned bounding box; it reaches to the farthest vertex of a triangle.

    Parameters
    ----------
    shapes : Mesh, Scene, or an iterable of these

    Attributes
    ----------
    shapes : tuple of Mesh
    center : (3,) float64
    radius : float, above 0

    Raises
    ------
    InputError
        If there is no shape, or if all of it lies in one point.
    """

    def __init__(self, shapes: SceneLike) -> None:
        self.shapes = _meshes(shapes)
        if not self.shapes:
            raise InputError("shapes: expected at least one shape, got none")
        points = np.concatenate([mesh.used_vertices() for mesh in self.shapes])
        # In units of the largest coordinate, since squares of very large or very small ones leave float64's range.
        unit = float(np.abs(points).max()) or 1.0
        points = points / unit
        center = (points.min(axis=0) + points.max(axis=0)) / 2
        radius = float(np.sqrt(((points - center) ** 2).sum(axis=1).max()))
        if not radius * unit > 0:
            raise InputError("shapes: expected an extent above zero, got all vertices in one point")
        self.center: NDArray[np.float64] = center * unit
        self.radius = radius * unit

    def __repr__(self) -> str:
        return f"Scene({len(self.shapes)} shapes, {self.triangle_count} triangles, radius {self.radius:.6g})"

    @property
    def triangle_count(self) -> int:
        return sum(len(mesh.triangles) for mesh in self.shapes)

    def turned_upright(self) -> Scene:
        """The same scene with what is stored as y up, the habit of games and films, turned to z up."""
        return Scene([mesh.turned_upright() for mesh in self.shapes])

    @cached_property
    def core(self) -> _core.Mesh:
        """The scene in the core, built when first asked for.

        It is scaled to the unit sphere in float64 before it is rounded to float32, so that files far from their origin
        lose nothing.
        """
        with np.errstate(over="ignore"):  # vertices that no triangle uses may be anywhere
            vertices = [((mesh.vertices - self.center) / self.radius).astype(np.float32) for mesh in self.shapes]
        starts = np.cumsum([0, *(len(mesh.vertices) for mesh in self.shapes)])
        triangles = [mesh.triangles + np.int32(start) for mesh, start in zip(self.shapes, starts, strict=False)]
        normals = None
        if any(mesh.normals is not None for mesh in self.shapes):
            # A shape without normals among some with: zeros, and the core takes the crease rule there.
            normals = np.concatenate(
                [np.zeros((len(m.vertices), 3), np.float32) if m.normals is None else m.normals for m in self.shapes]
            )
        return _core.Mesh(np.concatenate(vertices), np.concatenate(triangles), normals)

    def closest_hits(self, origins: Any, directions: Any) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        """Cast rays of any origin and direction.

        Parameters
        ----------
        origins, directions : (n, 3) numbers, finite
            In the scene's units; directions of any length but zero.

        Returns
        -------
        distance : (n,) float64
            From the origin to the first triangle in front of it, in the scene's units; inf where there is none.
        triangle : (n,) int32
            Which one, counted through all shapes in order; -1 where there is none.
        """
        origins = check_finite("origins", check_array("origins", origins, (None, 3)))
        directions = check_finite("directions", check_array("directions", directions, (len(origins), 3)))
        length = np.linalg.norm(directions, axis=1, keepdims=True)
        if len(length) and length.min() == 0:
            raise InputError("directions: expected lengths above 0, got a direction of length 0")
        direction = directions / length
        origin = (origins - self.center) / self.radius
        # The core wants origins near the unit sphere: rays from afar start where they enter a sphere a little larger.
        along = (origin * direction).sum(axis=1)
        start = -along - np.sqrt(np.maximum(along**2 - (origin**2).sum(axis=1) + 1.01, 0))
        start = np.maximum(start, 0)
        origin = origin + start[:, None] * direction
        t = np.empty(len(origins), np.float32)
        triangle = np.empty(len(origins), np.int32)
        self.core.closest_hits(origin.astype(np.float32), direction.astype(np.float32), t, triangle)
        distance = np.where(triangle >= 0, (start + t) * self.radius, np.inf)
        return distance, triangle


def as_scene(scene: SceneLike) -> Scene:
    """A Scene from a scene, a shape or several shapes."""
    return scene if isinstance(scene, Scene) else Scene(scene)


def _meshes(shapes: SceneLike) -> tuple[Mesh, ...]:
    if isinstance(shapes, Mesh):
        return (shapes,)
    if isinstance(shapes, Scene):
        return shapes.shapes
    expected = "shapes: expected a Mesh or several"
    if isinstance(shapes, str | bytes | os.PathLike) or not isinstance(shapes, Iterable):
        hint = "; bobrossnet.load reads files" if isinstance(shapes, str | os.PathLike) else ""
        raise InputTypeError(f"{expected}, got {type(shapes).__name__}{hint}")
    result: list[Mesh] = []
    for shape in shapes:
        if not isinstance(shape, Mesh | Scene):
            raise InputTypeError(f"{expected}, got {type(shape).__name__} among them")
        result.extend(_meshes(shape))
    return tuple(result)
