"""What every kind of shape has in common."""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.errors import InputError, InputTypeError
from bobrossnet.shapes.affine import Matrix, Points, from_unit_sphere, to_unit_sphere

Number = TypeVar("Number", bound=np.generic)

SMALLEST = 1e-307
"""Radius of a shape, in its own units, whose reciprocal float64 can hold; a smaller one is a point at any scale."""


class Shape(ABC):
    """A surface in units of its own, which a scene places. It does not change once it is made."""

    kind: ClassVar[str]
    """The word for this kind of shape in files."""

    @cached_property
    def core(self) -> tuple[_core.Shape, Matrix]:
        """The shape in the core, built when first asked for, and the (4, 4) map from its own units to what the core was
        given, which is about 1 in size."""
        return self._build()

    @abstractmethod
    def _build(self) -> tuple[_core.Shape, Matrix]: ...

    @abstractmethod
    def bounding_box(self, matrix: Matrix) -> tuple[Points, Points]:
        """Lowest and highest coordinates, (3,) each, of the shape placed by a matrix."""

    @abstractmethod
    def radius(self, matrix: Matrix, center: Points) -> float:
        """The distance from `center` to the farthest point of the shape placed by a matrix."""

    @abstractmethod
    def counts(self) -> dict[str, int]:
        """How many there are of what it is made of, by the noun for one of them."""

    @abstractmethod
    def describe(self) -> dict[str, str]:
        """What there is to say about it, for people: names and values."""

    @abstractmethod
    def tensors(self) -> dict[str, NDArray[Any]]:
        """The arrays that the shape can be made from again, as files hold them."""

    @classmethod
    @abstractmethod
    def from_tensors(cls, tensors: Mapping[str, NDArray[Any]]) -> Shape:
        """The shape that `tensors` came from.

        Raises
        ------
        InputError
            If an array is missing, of another dtype or shape, or holds what no such shape has.
        """

    @property
    def unresolved_rays(self) -> int:
        """How many rays so far passed places that could not be told from the surface."""
        return 0

    @cached_property
    def digest(self) -> bytes:
        """SHA-256 of what the shape is, the same for equal shapes."""
        digest = hashlib.sha256(self.kind.encode())
        for name, tensor in sorted(self.tensors().items()):
            digest.update(f"{name} {tensor.dtype.str} {tensor.shape}".encode())
            digest.update(np.ascontiguousarray(tensor).data)
        return digest.digest()

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self).from_tensors, (self.tensors(),)  # what is in the core can't be copied


class MeasuredShape(Shape):
    """A shape whose extents the core finds."""

    @property
    @abstractmethod
    def _surface(self) -> _core.MeasuredShape: ...

    @property
    @abstractmethod
    def _sphere(self) -> tuple[Points, float]:
        """The centre and the size in the shape's own units of what the core was given as a sphere of size 1."""

    def _build(self) -> tuple[_core.Shape, Matrix]:
        return self._surface, to_unit_sphere(*self._sphere)

    def bounding_box(self, matrix: Matrix) -> tuple[Points, Points]:
        key = matrix.tobytes()
        if key not in self._boxes:  # a scene asks twice, and it takes a while to find
            self._boxes[key] = self._surface.bounds(self._from_core(matrix))
        low, high = self._boxes[key]
        return low, high

    @cached_property
    def _boxes(self) -> dict[bytes, NDArray[np.float64]]:
        return {}

    def radius(self, matrix: Matrix, center: Points) -> float:
        from_core = self._from_core(matrix)
        largest = float(np.linalg.svd(from_core[:, :3], compute_uv=False)[0])
        return self._surface.radius(from_core, np.array(center, np.float64), largest)

    def _from_core(self, matrix: Matrix) -> Matrix:
        """(3, 4): from the core's coordinates to where a matrix places the shape."""
        return np.ascontiguousarray((matrix @ from_unit_sphere(*self._sphere))[:3])


def bounding_sphere(placed: Iterable[tuple[Shape, Matrix]]) -> tuple[Points, float]:
    """The sphere about the centre of the shapes' common bounding box that reaches to their farthest point."""
    placed = list(placed)
    boxes = [shape.bounding_box(matrix) for shape, matrix in placed]
    low, high = np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)
    center: Points = low / 2 + high / 2  # the sum could leave float64's range
    return center, max(shape.radius(matrix, center) for shape, matrix in placed)


def check_tensors(
    tensors: Mapping[str, NDArray[Any]], required: Mapping[str, str], optional: Mapping[str, str] | None = None
) -> None:
    """Raise InputError unless `tensors` are of these names and dtypes."""
    dtypes = {**required, **(optional or {})}
    missing, unknown = sorted(required.keys() - tensors.keys()), sorted(tensors.keys() - dtypes.keys())
    if missing:
        raise InputError(f"{missing[0]}: expected an array of {dtypes[missing[0]]}, got none")
    if unknown:
        raise InputError(f"{unknown[0]}: expected only {', '.join(dtypes)}, got this as well")
    for name, tensor in tensors.items():
        if tensor.dtype != dtypes[name]:
            raise InputTypeError(f"{name}: expected {dtypes[name]}, got {tensor.dtype}")


def frozen(array: NDArray[Any], dtype: type[Number]) -> NDArray[Number]:
    """A copy that nobody can change: what the core was given must stay true."""
    copy = np.array(array, dtype=dtype, order="C")
    copy.flags.writeable = False
    return copy
