"""What every kind of shape has in common."""

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
"""Steps along the longest side of a shape that becomes a mesh."""

MAX_CELLS = 4000
"""At most: a little fewer than the core takes, since its lattice is a little larger than the shape."""


class Shape(ABC):
    """A surface in its own units, which a scene places. Shapes are immutable."""

    kind: ClassVar[str]
    """The word for this kind of shape in files."""

    @property
    @abstractmethod
    def core(self) -> _core.Shape:
        """The shape in the core, made when first asked for."""

    def bounding_box(self, matrix: Matrix) -> tuple[Point, Point]:
        """Lowest and highest coordinates, (3,) each, of the shape placed by a matrix."""
        low, high = self.core.bounds(matrix)
        return low, high

    def radius(self, matrix: Matrix, center: Point) -> float:
        """The distance from `center` to the farthest point of the shape placed by a matrix."""
        return self.core.radius(matrix, center)

    @abstractmethod
    def counts(self) -> dict[str, int]:
        """How many parts it consists of, by the noun for one of them."""

    @abstractmethod
    def describe(self) -> dict[str, str]:
        """What `bobrossnet info` shows of it: names and values."""

    @abstractmethod
    def tensors(self) -> dict[str, NDArray[Any]]:
        """The arrays that describe the shape, as files hold them."""

    @classmethod
    @abstractmethod
    def from_tensors(cls, tensors: Mapping[str, NDArray[Any]]) -> Shape:
        """The shape that `tensors` came from.

        Raises
        ------
        InputError
            If an array is missing, of another dtype or shape, or holds what no such shape has.
        """

    @abstractmethod
    def mesh(self, step: float | None = None) -> Shape:
        """The surface as triangles.

        Parameters
        ----------
        step : number above 0, optional
            How long their sides are, in the shape's units; by default 1/128 of its longest side. Time and memory grow
            with its square.

        Returns
        -------
        Mesh
            Anticlockwise seen from outside where there is one.

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
        """Whether it has colours of its own, which its material's is multiplied by."""
        return False

    @property
    def unresolved_rays(self) -> int:
        """How many rays so far passed places that could not be distinguished from the surface."""
        return 0

    @lazy
    def digest(self) -> bytes:
        """SHA-256 of what the shape is, the same for equal shapes."""
        return _core.shape_digest(self.kind, self.digested())

    def digested(self) -> dict[str, NDArray[Any]]:
        """The arrays that the digest is of. A picture counts by its own digest: shapes that share it read it once."""
        return self.tensors()

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self).from_tensors, (self.tensors(),)  # what is in the core can't be copied


def check_tensors(
    tensors: Mapping[str, NDArray[Any]], required: Mapping[str, str], optional: Mapping[str, str] | None = None
) -> None:
    """Raise InputError unless `tensors` are of these names and dtypes."""
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
    """A read-only copy, so that it stays what the core was given."""
    copy = np.array(array, dtype=dtype, order="C")
    copy.flags.writeable = False
    return copy
