"""Instances: shapes with a placement and a material."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from bobrossnet import _core
from bobrossnet.shapes.affine import IDENTITY, Matrix, check_map, rotation, scaling, translation
from bobrossnet.shapes.shape import Shape
from bobrossnet.support.errors import InputError, InputTypeError, check_integer, each_of
from bobrossnet.tracing.material import Material

Z = (0.0, 0.0, 1.0)
WHITE = Material()


class Piece(NamedTuple):
    """The primitives of an instance that belong to one part of its scene."""

    path: tuple[str, ...]
    """Names from the root of the tree of parts to the part. Siblings of one name differ by a number behind it."""
    size: int | None = None
    """Number of consecutive primitives; None for all."""


@dataclass(frozen=True, eq=False, init=False, slots=True)
class Instance:
    """A shape with its placement.

    Instances of one shape share its memory. `translate`, `scale` and `rotate` follow the modelling language; each acts
    on the result of the previous one:

    >>> import bobrossnet as bob
    >>> tree = bob.Instance(bob.happy_tree())
    >>> far = tree.rotate(0.5).scale(0.4).translate((2, 0, 0))
    >>> scene = bob.Scene([tree, far])

    Parameters
    ----------
    shape : Shape
    transform : (4, 4) numbers, optional
        Maps the shape's units to the scene's, multiplied from the left to column vectors; affine and invertible.
    material : Material, optional
        White by default.
    name : str, optional
        A label; nothing but the tree of parts depends on it.
    pieces : iterable of (path, count), optional
        Places in the tree `Scene.parts`: for consecutive primitives, the names from the root down. By default the
        instance is a part below the root.

    Raises
    ------
    InputError
        If an argument has the wrong type, the transform can't be inverted, or the pieces are not all of the shape.
    """

    shape: Shape
    transform: Matrix
    material: Material
    name: str | None
    pieces: tuple[Piece, ...]

    def __init__(
        self,
        shape: Shape,
        transform: Any = None,
        material: Material | None = None,
        name: str | None = None,
        pieces: Iterable[Any] = (),
    ) -> None:
        if not isinstance(shape, Shape):
            raise InputTypeError(f"shape: expected a shape, got {type(shape).__name__}")
        if material is not None and not isinstance(material, Material):
            raise InputTypeError(f"material: expected a Material, got {type(material).__name__}")
        if name is not None and not isinstance(name, str):
            raise InputTypeError(f"name: expected a string, got {type(name).__name__}")
        matrix = check_map("transform", IDENTITY if transform is None else transform)
        matrix.flags.writeable = False
        for field, value in (
            ("shape", shape),
            ("transform", matrix),
            ("material", WHITE if material is None else material),
            ("name", name),
            ("pieces", _pieces(pieces, shape)),
        ):
            object.__setattr__(self, field, value)

    def __reduce__(self) -> tuple[Any, ...]:
        return Instance, (
            self.shape,
            self.transform,
            self.material,
            self.name,
            self.pieces,
        )  # keeps the transform read-only

    def transformed(self, matrix: Any) -> Instance:
        """Return the instance transformed by a (4, 4) matrix."""
        return replace(self, transform=check_map("matrix", matrix) @ self.transform)

    def translate(self, offset: Any) -> Instance:
        """Return the instance translated by (x, y, z)."""
        return self.transformed(translation(offset))

    def scale(self, factor: Any) -> Instance:
        """Return the instance scaled about the scene's origin, by one factor or by one for each axis, not 0."""
        return self.transformed(scaling(factor))

    def rotate(self, angle: float, vector: Any = Z) -> Instance:
        """Return the instance rotated about an axis through the scene's origin, by an angle in radians.

        Positive angles are anticlockwise, seen against the axis.
        """
        return self.transformed(rotation(angle, vector))

    def digest(self) -> bytes:
        """SHA-256 of everything visible: the shape, its placement and its material."""
        return _core.instance_digest(self.shape.digest, self.transform, self.material.core())


def _pieces(pieces: Iterable[Any], shape: Shape) -> tuple[Piece, ...]:
    """Pieces of a shape, checked."""
    checked: list[Piece] = []
    for piece in each_of("pieces", pieces, "pairs of a path and a count"):
        if not (isinstance(piece, tuple) and len(piece) == 2):
            raise InputTypeError(f"pieces: expected pairs of a path and a count, got {type(piece).__name__}")
        path, count = piece
        if not (isinstance(path, tuple) and path and all(isinstance(name, str) for name in path)):
            raise InputTypeError(f"pieces: expected paths, tuples of at least one name, got {path!r:.100}")
        checked.append(Piece(path, None if count is None else check_integer("pieces", count, 1, 2**31 - 1)))
    if not checked or (len(checked) == 1 and checked[0].size is None):
        return tuple(checked)
    total, expected = sum(piece.size or 0 for piece in checked), primitive_count(shape)
    if total != expected or any(piece.size is None for piece in checked):
        raise InputError(f"pieces: expected counts of all {expected:,} primitives of the shape, got {total:,}")
    return tuple(checked)


def primitive_count(shape: Shape) -> int:
    """Number of primitives that `Hits` tell apart: triangles of a mesh, faces of a brep; else 1."""
    counts = shape.counts()
    return next((counts[noun] for noun in ("triangle", "face") if noun in counts), 1)
