"""Affine maps of space as (4, 4) float64 matrices, multiplied from the left to column vectors."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.support.errors import InputError, check_array, check_finite, check_number, shape_of

Matrix: TypeAlias = NDArray[np.float64]
Point: TypeAlias = NDArray[np.float64]
"""(3,)"""

Points: TypeAlias = NDArray[np.float64]
"""(n, 3)"""

IDENTITY: Matrix = np.eye(4)

UPRIGHT: Matrix = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
"""Rotates y up to z up: (x, y, z) becomes (x, -z, y)."""

TURNS: dict[str, Matrix] = {
    "x": np.array([[0.0, 0, -1, 0], [0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1]]),
    "y": UPRIGHT,
    "z": IDENTITY,
    "-x": np.array([[0.0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]),
    "-y": np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]]),
    "-z": np.array([[1.0, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]),
}
"""Rotations of each axis to z."""

MAX_COORDINATE = 1e100
"""Maximum size of a coordinate: beyond, squares and products leave float64."""

FLATTEST = 1e-10
"""Minimum ratio of a map's scales along two directions.

Smaller ratios are refused as singular: rays in float32 can't resolve such shapes.
"""


def translation(offset: Any) -> Matrix:
    """Return the translation by `offset`, 3 numbers."""
    matrix = np.eye(4)
    matrix[:3, 3] = check_finite("offset", check_array("offset", offset, (3,)))
    return matrix


def scaling(factor: Any) -> Matrix:
    """Return the scaling about the origin by one number, or by 3 numbers along the axes, not 0."""
    factors = np.asarray(factor) if shape_of(factor) else [check_number("factor", factor)] * 3
    return check_map("factor", np.diag([*check_array("factor", factors, (3,)).astype(np.float64), 1.0]))


def rotation(angle: Any, vector: Any) -> Matrix:
    """Return the rotation about an axis through the origin, by Rodrigues' formula.

    Parameters
    ----------
    angle : float
        In radians, anticlockwise seen against the axis.
    vector : (3,) numbers
        The axis, of any nonzero length.
    """
    angle = check_number("angle", angle)
    axis = check_finite("vector", check_array("vector", vector, (3,))).astype(np.float64)
    length = np.linalg.norm(axis)
    if length == 0:
        raise InputError("vector: expected an axis of a length above 0, got (0, 0, 0)")
    x, y, z = axis / length
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix = np.eye(4)
    matrix[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return matrix


def rotation_by_degrees(degrees: Any, vector: Any) -> Matrix:
    """Return the `rotation` by an angle in degrees; exact for multiples of 90 about a coordinate axis."""
    turn = check_number("degrees", degrees) % 360
    matrix = rotation(np.radians(turn), vector)
    return np.rint(matrix) + 0.0 if turn % 90 == 0 and np.count_nonzero(vector) == 1 else matrix


def check_size(name: str, array: NDArray[Any]) -> None:
    """Raise InputError for numbers larger than `MAX_COORDINATE`."""
    largest = float(np.abs(array.astype(np.float64)).max(initial=0))
    if largest > MAX_COORDINATE:
        raise InputError(f"{name}: expected numbers of at most {MAX_COORDINATE:g} in size, got {largest:.6g}")


def check_map(name: str, value: Any) -> Matrix:
    """Return `value` as a new (4, 4) float64 matrix if it is an invertible affine map; otherwise raise InputError."""
    matrix: Matrix = np.array(check_finite(name, check_array(name, value, (4, 4))), np.float64, order="C")
    last = tuple(matrix[3].tolist())
    if last != (0, 0, 0, 1):
        raise InputError(f"{name}: expected an affine map, whose last row is (0, 0, 0, 1), got {last}")
    sizes = _core.singular_values(matrix)
    if not sizes[2] > FLATTEST * sizes[0]:
        raise InputError(f"{name}: expected a map that keeps all three dimensions, got one that is singular")
    return matrix


def mapped(matrix: Matrix, points: NDArray[np.floating[Any]]) -> Points:
    """Map points, (n, 3), by a matrix."""
    # Not by @: a BLAS's threads keep spinning for a while on the cores that the tracer needs.
    x, y, z = points.T
    moved: Points = np.stack([a * x + b * y + c * z + d for a, b, c, d in matrix[:3]])
    return moved.T


def to_unit_sphere(center: Point, radius: float) -> Matrix:
    """Return the map from a sphere to the unit sphere."""
    matrix = np.diag([1 / radius, 1 / radius, 1 / radius, 1.0])
    matrix[:3, 3] = -center / radius
    return matrix
