"""Faces of NURBS that are planes, cylinders, spheres, cones or tori, from their points and normals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bobrossnet.shapes.affine import Matrix, Point, mapped
from bobrossnet.shapes.nurbs import Face

PLACES = np.array([0.03, 0.21, 0.5, 0.72, 0.96])
"""Points of each span between knots, along either parameter: uneven, so that no symmetry hides a deviation."""

MAX_SPANS = 12
"""Along either parameter; of more, some."""

SAME = 1e-7
"""Largest deviation of points, in sizes of the face, and of normals: CAD systems write 7 digits at least."""


@dataclass(frozen=True, eq=False)
class Surface:
    """The shape of a face, in the scene."""

    kind: str
    """plane, cylinder, sphere, cone, torus, or freeform for any other."""
    center: Point | None = None
    """(3,) of a sphere or torus, or a point of the axis: a cone's apex."""
    axis: Point | None = None
    """(3,) unit vector of a cylinder, cone or torus; a plane's normal."""
    radius: float | None = None
    """Radius of a cylinder, a sphere or a torus' tube."""
    major_radius: float | None = None
    """Radius of a torus' centre line."""
    half_angle: float | None = None
    """Half the angle of a cone, in degrees."""

    def same_as(self, other: Surface, size: float) -> bool:
        """Whether two faces lie on one surface; planes do not count."""
        if self.kind != other.kind or self.kind in ("freeform", "plane"):
            return False
        near = 10 * SAME * size
        numbers = ((self.radius, other.radius), (self.major_radius, other.major_radius))
        if any(a is not None and b is not None and abs(a - b) > near for a, b in numbers):
            return False
        assert self.center is not None
        assert other.center is not None
        offset = other.center - self.center
        if self.axis is None or other.axis is None:
            return bool(np.linalg.norm(offset) <= near)
        if np.linalg.norm(np.cross(self.axis, other.axis)) > 10 * SAME:
            return False
        if self.kind == "cylinder":
            offset = offset - (offset @ self.axis) * self.axis
        return bool(np.linalg.norm(offset) <= near)


def recognised(face: Face, matrix: Matrix) -> Surface:
    """Return the shape of a face that is placed by a matrix."""
    u, v = (_places(knots, degree) for knots, degree in ((face.knots_u, face.degree_u), (face.knots_v, face.degree_v)))
    by = face.derivatives(*np.meshgrid(u, v, indexing="ij"), 1).reshape(-1, 2, 2, 3)
    linear = matrix[:3, :3].T
    points = mapped(matrix, by[:, 0, 0])
    normals = np.cross(_unit(by[:, 1, 0] @ linear), _unit(by[:, 0, 1] @ linear))
    length = np.linalg.norm(normals, axis=1)
    regular = length > 1e-6
    if regular.sum() < 8:
        return Surface("freeform")
    points, normals = points[regular], normals[regular] / length[regular, None]
    middle, size = points.mean(axis=0), float(np.ptp(points, axis=0).max())
    found = _of_unit_size((points - middle) / size, normals)
    if found is None:
        return Surface("freeform")
    return Surface(
        found.kind,
        None if found.center is None else middle + size * found.center,
        found.axis,
        None if found.radius is None else size * found.radius,
        None if found.major_radius is None else size * found.major_radius,
        found.half_angle,
    )


def _of_unit_size(p: NDArray[np.float64], n: NDArray[np.float64]) -> Surface | None:
    """Return the surface through points with these normals; None for a free form."""
    if np.abs(n - n[0]).max() <= SAME:
        flat = np.abs((p - p[0]) @ n[0]).max() <= SAME
        return Surface("plane", p[0], n[0]) if flat else None
    # A sphere: p = c + r n.
    center, radius = _around(p, n)
    if _fits(p, center + radius * n):
        return Surface("sphere", center, None, abs(radius))
    # Normals of a cylinder are perpendicular to its axis; normals of a cone have one angle to it.
    axis = np.linalg.svd(n - n.mean(axis=0), full_matrices=False)[2][2]
    slope = float((n @ axis).mean())
    if np.abs(n @ axis - slope).max() <= SAME:
        if abs(slope) <= SAME:
            across = np.eye(3) - np.outer(axis, axis)
            center, radius = _around(p @ across, n @ across)
            return Surface("cylinder", center, axis, abs(radius)) if _fits(p @ across, center + radius * n) else None
        apex = np.linalg.lstsq(n, (n * p).sum(axis=1), rcond=None)[0]
        if np.abs(((p - apex) * n).sum(axis=1)).max() > SAME:
            return None
        return Surface("cone", apex, axis, None, None, float(np.degrees(np.arcsin(min(abs(slope), 1)))))
    # Normals of a torus meet its axis: a linear equation for the axis in Plücker coordinates.
    lines = np.hstack([np.cross(p, n), n])
    values, vectors = np.linalg.svd(lines, full_matrices=False)[1:]
    direction, moment = vectors[-1][:3], vectors[-1][3:]
    length = np.linalg.norm(direction)
    if values[-1] > SAME * np.sqrt(len(p)) or length < 1e-6:
        return None
    axis, origin = direction / length, np.cross(direction, moment) / length**2
    out = (p - origin) - ((p - origin) @ axis)[:, None] * axis
    distance = np.linalg.norm(out, axis=1)
    if distance.min() <= 0:
        return None
    profile = np.stack([distance, (p - origin) @ axis], axis=1)
    of_profile = np.stack([(n * out).sum(axis=1) / distance, n @ axis], axis=1)
    middle, tube = _around(profile, of_profile)
    if not _fits(profile, middle + tube * of_profile):
        return None
    return Surface("torus", origin + middle[1] * axis, axis, abs(tube), abs(float(middle[0])))


def _around(p: NDArray[np.float64], n: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Return c and r of the least squares of p = c + r n."""
    p0, n0 = p.mean(axis=0), n.mean(axis=0)
    radius = float(((p - p0) * (n - n0)).sum() / ((n - n0) ** 2).sum())
    center: NDArray[np.float64] = p0 - radius * n0
    return center, radius


def _fits(p: NDArray[np.float64], of_surface: NDArray[np.float64]) -> bool:
    return bool(np.abs(p - of_surface).max() <= SAME)


def _places(knots: NDArray[np.float64], degree: int) -> NDArray[np.float64]:
    """Return parameters within the spans between knots."""
    ends = np.unique(knots[degree : len(knots) - degree])
    spans = np.unique(np.linspace(0, len(ends) - 2, min(len(ends) - 1, MAX_SPANS)).astype(int))
    places: NDArray[np.float64] = ends[spans, None] + (ends[spans + 1] - ends[spans])[:, None] * PLACES
    return places.reshape(-1)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    units: NDArray[np.float64] = vectors / np.where(length > 0, length, 1)
    return units
