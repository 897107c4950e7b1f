"""Areas and volumes of meshes, of NURBS solids, and of other shapes from their meshes."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet.measuring.crossings import APART, crossings
from bobrossnet.shapes.affine import Matrix, mapped
from bobrossnet.shapes.mesh import Mesh, rounded
from bobrossnet.shapes.nurbs import Brep
from bobrossnet.shapes.shape import Shape
from bobrossnet.tracing.scene import Scene

RAYS = 3
"""Number of rays for each side of a face: the majority decides which side is inside."""

OPEN = 1e-5
"""Residual of a closed surface's identities above which it counts as open, in its area: a hole of this share of it, and
more than gaps within the tolerance of CAD systems make."""

STEPS = (32, 64, 128)
"""Steps of the meshes of other shapes along their longest side."""

QUADRATIC = (3, 5.5)
"""Range of the ratio of two differences that fall with the square of the step: 4, but for rounding and cut edges."""

ROUNDING = 1e-12
"""Relative error of sums over triangles."""

QUADRATURE = 1e-8
"""The same of integrals over smooth faces."""

SINGLE = 1e-6
"""The same of meshes of formulas and tubes: these are computed in float32."""


Indices: TypeAlias = NDArray[np.int64]


class Amount(NamedTuple):
    """An area and a volume."""

    area: float
    volume: float | None
    """Signed, of a mesh; None if the surface is open."""
    error: float
    """Relative, of the larger one of both."""


def of_triangles(vertices: NDArray[np.float64], triangles: NDArray[np.int32]) -> Amount:
    """Return the area and volume of a mesh."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    area = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)
    return Amount(area, closed_volume(vertices, triangles), ROUNDING)


def closed_volume(vertices: NDArray[np.float64], triangles: NDArray[np.int32]) -> float | None:
    """Return the signed volume of a closed mesh, negative if it is inside out; None if an edge has no opposite."""
    start, end = _edges(vertices, triangles)
    count = len(vertices)
    if not np.array_equal(np.sort(start * count + end), np.sort(end * count + start)):
        return None
    a, b, c = (vertices[triangles[:, i]] - vertices[0] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def _edges(vertices: NDArray[np.float64], triangles: NDArray[np.int32]) -> tuple[Indices, Indices]:
    """Return the edges of all triangles, from and to, with one number for vertices of one place."""
    _, same = np.unique(rounded(vertices), axis=0, return_inverse=True)
    corners = same.reshape(-1)[triangles].astype(np.int64)
    corners = corners[(corners != np.roll(corners, 1, axis=1)).all(axis=1)]
    return corners.T.reshape(-1), np.roll(corners, -1, axis=1).T.reshape(-1)


def edge_faults(vertices: NDArray[np.float64], triangles: NDArray[np.int32]) -> tuple[int, int]:
    """Return the number of edges of one triangle, at holes, and of edges that two triangles run along the same way.

    The second are the borders of triangles that are inside out.
    """
    start, end = _edges(vertices, triangles)
    edges = np.minimum(start, end) * len(vertices) + np.maximum(start, end)
    _, which, count = np.unique(edges, return_inverse=True, return_counts=True)
    along = np.bincount(which.reshape(-1), np.where(start < end, 1, -1), len(count))
    return int((count == 1).sum()), int(((count == 2) & (along != 0)).sum())


def placed_brep(brep: Brep, matrix: Matrix) -> tuple[Brep, float]:
    """Return a brep placed by a matrix, and a factor of its lengths: the same brep, if the matrix keeps angles."""
    linear = matrix[:3, :3]
    squares = linear.T @ linear
    scale = float(np.sqrt(np.trace(squares) / 3))
    if np.abs(squares / scale**2 - np.eye(3)).max() <= 1e-12:
        return brep, scale
    faces = [
        type(face)(mapped(matrix, face.control_points.reshape(-1, 3)).reshape(face.control_points.shape), *rest)
        for face in brep.faces
        for rest in [(face.knots_u, face.knots_v, face.weights, face.trims or None)]
    ]
    return Brep(faces, brep.tolerance), 1.0


def of_brep(brep: Brep) -> Amount:
    """Return the area of a brep, and its volume if it is closed.

    Over a closed surface with unit normals n, the integral of n is 0, and the integral of x n^T is the
    volume times the identity. The difference is the error.
    """
    moments = brep.moments
    area = float(moments[:, 0].sum())
    outward = _outward(brep)[:, None]
    normal = (outward * moments[:, 1:4]).sum(axis=0)
    position = (outward * moments[:, 4:13]).sum(axis=0).reshape(3, 3)
    low, high = brep.bounding_box(np.eye(4))
    size, middle = float((high - low).max()), (low + high) / 2
    position -= np.outer(middle, normal)
    volume = float(np.trace(position) / 3)
    missing = float(np.abs(position - volume * np.eye(3)).max())
    # Gaps within the tolerance of the file are no holes.
    if max(float(np.abs(normal).max()), missing / size) > max(OPEN, brep.tolerance / size) * area or not volume > 0:
        return Amount(area, None, QUADRATURE)
    return Amount(area, volume, max(QUADRATURE, missing / volume))


def _outward(brep: Brep) -> NDArray[np.float64]:
    """(n,): 1 for each face whose normal leads out of the solid, else -1. Rays from both sides count surfaces."""
    scene = Scene(brep)
    random = np.random.Generator(np.random.Philox(0))
    inside = brep.moments[:, 13:]
    by = np.array([face.derivatives(u, v, 1) for face, (u, v) in zip(brep.faces, inside, strict=True)])
    normals = np.cross(by[:, 1, 0], by[:, 0, 1])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    tilts = random.uniform(-0.6, 0.6, (len(normals), 2 * RAYS, 3))
    sides = np.repeat([1.0, -1.0], RAYS)[:, None]
    directions = (sides * (normals[:, None] + tilts)).reshape(-1, 3)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    origins = (by[:, None, 0, 0] + APART * scene.radius * sides * normals[:, None]).reshape(-1, 3)
    odd = np.zeros(len(origins), bool)
    for which, _ in crossings(scene, origins, directions):
        odd[which] ^= True
    votes = np.where(odd.reshape(-1, 2 * RAYS), -1, 1) * sides[:, 0]
    return np.where(votes.sum(axis=1) >= 0, 1.0, -1.0)


def of_shape(shape: Shape, matrix: Matrix) -> Amount:
    """Return the area and volume of a placed shape by three meshes."""
    low, high = shape.bounding_box(np.eye(4))
    size = float((high - low).max())
    found = [_of_mesh(shape.mesh(size / steps), matrix) for steps in STEPS]
    area, error = _limit(*(each.area for each in found))
    volumes = [each.volume for each in found if each.volume is not None]
    if len(volumes) < len(found):
        return Amount(area, None, max(error, SINGLE))
    volume, volume_error = _limit(*volumes)
    return Amount(area, volume, max(error, volume_error, SINGLE))


def _limit(coarse: float, middle: float, fine: float) -> tuple[float, float]:
    """Return the limit of values for steps that are halved, and its relative error.

    Errors on smooth surfaces fall with the square of the step, so that Richardson's extrapolation leaves less than the
    last difference. Meshes cut edges that are not along the axes, and their errors fall irregularly: the last value is
    then off by at most the largest difference.
    """
    before, last = middle - coarse, fine - middle
    if last == 0 or not QUADRATIC[0] <= before / last <= QUADRATIC[1]:
        return fine, max(abs(before), abs(last)) / max(abs(fine), 1e-300)
    return fine + last / 3, abs(last) / abs(fine)


def _of_mesh(mesh: Shape, matrix: Matrix) -> Amount:
    assert isinstance(mesh, Mesh)
    return of_triangles(mapped(matrix, mesh.vertices), mesh.triangles)
