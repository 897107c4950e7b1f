"""The base class of all shapes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.shapes.affine import IDENTITY, Matrix, Point
from bobrossnet.support.errors import InputError, InputTypeError, check_number
from bobrossnet.support.threads import lazy

Number = TypeVar("Number", bound=np.generic)

DEFAULT_CELLS = 128
"""Default number of mesh steps along a shape's longest side."""

MAX_CELLS = 4000
"""Maximum number of mesh steps: below the core's limit, since its lattice is slightly larger than the shape."""


class Shape(ABC):
    """A surface in local units, placed by a scene. Shapes are immutable."""

    kind: ClassVar[str]
    """Name of the kind of shape in files."""

    @property
    @abstractmethod
    def core(self) -> _core.Shape:
        """The core's shape, made at first use."""

    def bounding_box(self, matrix: Matrix) -> tuple[Point, Point]:
        """Return the minimum and maximum coordinates, (3,) each, of the shape placed by a matrix."""
        low, high = self.core.bounds(matrix)
        return low, high

    def radius(self, matrix: Matrix, center: Point) -> float:
        """Return the distance from `center` to the farthest point of the shape placed by a matrix."""
        return self.core.radius(matrix, center)

    @abstractmethod
    def counts(self) -> dict[str, int]:
        """Return the number of primitives by their noun, such as triangles."""

    @abstractmethod
    def describe(self) -> dict[str, str]:
        """Return the names and values that `bobrossnet info` shows."""

    @abstractmethod
    def tensors(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of the shape, as stored in files."""

    @classmethod
    @abstractmethod
    def from_tensors(cls, tensors: Mapping[str, NDArray[Any]]) -> Shape:
        """Rebuild the shape from its `tensors`.

        Raises
        ------
        InputError
            If an array is missing, has another dtype or shape, or holds invalid values.
        """

    @abstractmethod
    def mesh(self, step: float | None = None) -> Shape:
        """Return the surface as a triangle mesh.

        Parameters
        ----------
        step : number above 0, optional
            Length of the triangles' sides, in the shape's units; by default 1/128 of its longest side. Time and memory
            grow with its inverse square.

        Returns
        -------
        Mesh
            Anticlockwise seen from outside, if the shape has an outside.

        Raises
        ------
        InputError
            If the step is out of range, or there would be too many triangles.
        """

    def check_step(self, step: float | None) -> float:
        """Return the step of `mesh` as a float, the default for None; raise InputError if it is out of range."""
        low, high = self.bounding_box(IDENTITY)
        size = float((high - low).max())
        if step is None:
            return size / DEFAULT_CELLS
        return check_number("step", step, size / MAX_CELLS, hint=f"{MAX_CELLS} steps are the most along a side")

    @property
    def is_colored(self) -> bool:
        """Whether the shape has colours, which the material's colour multiplies."""
        return False

    @property
    def unresolved_rays(self) -> int:
        """Number of rays so far that passed places indistinguishable from the surface."""
        return 0

    @lazy
    def digest(self) -> bytes:
        """Return the SHA-256 of the shape's definition, equal for equal shapes."""
        return _core.shape_digest(self.kind, self.digested())

    def digested(self) -> dict[str, NDArray[Any]]:
        """Return the arrays to hash. A picture is replaced by its digest: shapes that share it hash it once."""
        return self.tensors()

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self).from_tensors, (self.tensors(),)  # the core's objects can't be copied


def check_tensors(
    tensors: Mapping[str, NDArray[Any]], required: Mapping[str, str], optional: Mapping[str, str] | None = None
) -> None:
    """Raise InputError unless `tensors` have these names and dtypes."""
    dtypes = {**required, **(optional or {})}
    missing, unknown = sorted(required.keys() - tensors.keys()), sorted(tensors.keys() - dtypes.keys())
    if missing:
        raise InputError(f"{missing[0]}: expected an array of {dtypes[missing[0]]}, got none")
    if unknown:
        raise InputError(f"{unknown[0]}: expected only {', '.join(dtypes)}, got an extra one")
    for name, tensor in tensors.items():
        if tensor.dtype != dtypes[name]:
            raise InputTypeError(f"{name}: expected {dtypes[name]}, got {tensor.dtype}")


def frozen(array: NDArray[Any], dtype: type[Number]) -> NDArray[Number]:
    """Return a read-only copy, so that it stays equal to the core's values."""
    copy = np.array(array, dtype=dtype, order="C")
    copy.flags.writeable = False
    return copy
