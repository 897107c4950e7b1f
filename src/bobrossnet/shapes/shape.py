"""What every kind of shape has in common."""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.errors import InputError, InputTypeError
from bobrossnet.shapes.affine import Matrix, Points


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
