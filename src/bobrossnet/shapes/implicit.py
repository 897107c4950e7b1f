"""Implicit surfaces: solids where a formula is negative."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import Color, linear
from bobrossnet.shapes.affine import check_size
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.shapes.shape import Shape, check_tensors
from bobrossnet.support.errors import InputError, InputTypeError, check_array, check_finite, warn_coarse
from bobrossnet.support.threads import lazy

MESHES = {"mesh_sizes": "uint32", "mesh_vertices": "float32", "mesh_triangles": "uint32"}
"""Array names and dtypes of formulas with the distance of a mesh."""


class Implicit(Shape):
    """The surface f(x, y, z) = 0 of a formula; f < 0 is inside.

    Parameters
    ----------
    expression : Expression
        f, in any unit: it need not be a distance.
    bounds : ((x0, y0, z0), (x1, y1, z1)) numbers, finite, each low below its high, optional
        The box that contains the surface. If omitted, bounds are derived, and an unbounded shape is refused.
    color : ColorFormula, str or 3 numbers in 0..1, optional
        Colour of the surface: sRGB as "#rrggbb", linear RGB, or a formula, clamped to 0..1 with NaN as 0. A formula
        is evaluated at hits and affects neither these nor the normals. The material's colour multiplies it.

    Raises
    ------
    InputError
        If the bounds are not a box, or the colour is invalid. At first placement or trace: if the shape is unbounded
        and has no bounds, or has no surface.
    """

    kind = "implicit"

    expression: _core.Expression
    bounds: NDArray[np.float64] | None
    color_formula: _core.ColorFormula | None

    def __init__(
        self, expression: _core.Expression, bounds: Any = None, color: Color | _core.ColorFormula | None = None
    ) -> None:
        if not isinstance(expression, _core.Expression):
            hint = "; bobrossnet.implicit takes functions" if callable(expression) else ""
            raise InputTypeError(f"expression: expected an Expression, got {type(expression).__name__}{hint}")
        self.expression = expression
        self.bounds = None if bounds is None else _box(bounds)
        self.color_formula = color_formula(color)

    @classmethod
    def within(cls, expression: _core.Expression, bounds: NDArray[np.float64]) -> Implicit:
        """Make the surface of a formula within known bounds, without deriving them."""
        shape = cls(expression)
        shape.domain = bounds
        return shape

    @lazy
    def core(self) -> _core.Implicit:
        surface = _core.Implicit(self.expression, self.domain, self.color_formula)
        if not surface.cells:
            raise InputError("shape: expected a surface within the bounds, got none")
        if surface.is_coarse:
            warn_coarse("formula")
        return surface

    @lazy
    def domain(self) -> NDArray[np.float64]:
        """(2, 3): the given bounds, or the formula's; the surface is cut off there."""
        if self.bounds is not None:
            return self.bounds
        try:
            bounds = _core.find_bounds(self.expression)
        except ValueError as error:
            raise InputError(f"shape: expected {error}; cut it, or give bounds=((x0, y0, z0), (x1, y1, z1))") from None
        if bounds is None:
            raise InputError(
                "shape: expected a formula that is negative somewhere within 1e9 of the origin, got one that never is"
            )
        return bounds

    @property
    def cells(self) -> int:
        """Number of cells of space that contain the surface, each with a simplified formula."""
        return self.core.cells

    @property
    def is_colored(self) -> bool:
        return self.color_formula is not None

    @property
    def unresolved_rays(self) -> int:
        """Number of rays so far that passed places indistinguishable from the surface.

        There the surface is tangent to the ray within a millionth of the shape's size, or the formula is too irregular
        to be bounded. Rays never step over any other root.
        """
        return self.core.unresolved_rays

    def counts(self) -> dict[str, int]:
        return {"cell": self.cells}

    def describe(self) -> dict[str, str]:
        return {
            "formula": f"{len(self.expression):,} steps: {self.expression}",
            "cells": f"{self.cells:,}, {self.core.bytes / 2**20:.1f} MiB",
            **({} if self.color_formula is None else {"colours": f"{len(self.color_formula):,} steps"}),
        }

    def mesh(self, step: float | None = None) -> Mesh:
        """Mesh the surface by dual contouring.

        Each vertex is the intersection of the surface's planes in a cell of side `step`, so sharp edges and corners
        stay sharp. Roots and planes are exact.

        Parameters
        ----------
        step : number above 0, optional
            In the shape's units; by default 1/128 of its longest side. Thinner details may be partly lost. Time and
            memory grow with the inverse square of the step.

        Returns
        -------
        Mesh
            Closed, with every edge in exactly two triangles, anticlockwise seen from outside. The deviation from the
            surface is at most about the step, and a small fraction of it where the surface is smooth. Its vertices have
            the shape's colours.

        Raises
        ------
        InputError
            If the step is below 1/4000 of the longest side, or so large that no triangle is left, or if there would be
            more than 33 million triangles.

        Examples
        --------
        >>> from bobrossnet.sdf import *
        >>> (sphere(1) & box(1.5)).mesh().save("part.stl")  # doctest: +SKIP
        """
        length = self.check_step(step)
        try:
            vertices, triangles = self.core.dual_contour(length)
        except ValueError as error:
            raise InputError(f"step: expected a larger one than {length:g}, which makes {error}") from None
        if not len(triangles):
            raise InputError(f"step: expected less than the shape's thickness, got {length:g}")
        colors = self.core.colors(vertices) if self.is_colored else None
        return Mesh.owning(vertices, triangles, colors)

    def tensors(self) -> dict[str, NDArray[Any]]:
        tensors: dict[str, NDArray[Any]] = {
            "ops": self.expression.ops,
            "operands": self.expression.operands,
            "values": self.expression.values,
        }
        tensors |= zip(MESHES, self.expression.mesh_arrays, strict=False)
        if self.bounds is not None:
            tensors["bounds"] = self.bounds
        color = self.color_formula
        if color is not None:
            tensors |= {"color_ops": color.ops, "color_operands": color.operands}
            tensors |= {"color_values": color.values, "color_roots": color.roots}
            tensors |= zip((f"color_{name}" for name in MESHES), color.mesh_arrays, strict=False)
        return tensors

    @classmethod
    def from_tensors(cls, tensors: Mapping[str, NDArray[Any]]) -> Implicit:
        required = {"ops": "uint8", "operands": "uint32", "values": "float64"}
        of_color = {f"color_{name}": dtype for name, dtype in required.items()} | {"color_roots": "uint32"}
        of_color_meshes = {f"color_{name}": dtype for name, dtype in MESHES.items()}
        check_tensors(tensors, required, {"bounds": "float64", **MESHES, **of_color, **of_color_meshes})
        expression = _formula("formula", _core.Expression, tensors, required, MESHES)
        color = None
        if (of_color.keys() | of_color_meshes.keys()) & tensors.keys():
            given = {name: tensor for name, tensor in tensors.items() if name.startswith("color_")}
            check_tensors(given, of_color, of_color_meshes)
            color = _formula("color", _core.ColorFormula, given, of_color, of_color_meshes)
        return cls(expression, tensors.get("bounds"), color)

    def __repr__(self) -> str:
        bounds = "" if self.bounds is None else f", bounds={self.bounds.tolist()}"
        color = "" if self.color_formula is None else f", color={self.color_formula!r}"
        return f"Implicit({self.expression}{bounds}{color})"


F = TypeVar("F")


def _formula(
    name: str,
    kind: Callable[..., F],
    tensors: Mapping[str, NDArray[Any]],
    names: Iterable[str],
    meshes: Iterable[str],
) -> F:
    given = [*names, *(each for each in meshes if each in tensors)]
    try:
        return kind(**{each.removeprefix("color_"): np.ascontiguousarray(tensors[each]) for each in given})
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: {error}") from None


def color_formula(color: Color | _core.ColorFormula | None) -> _core.ColorFormula | None:
    """Convert a shape's colour argument to a formula."""
    if color is None or isinstance(color, _core.ColorFormula):
        return color
    if callable(color):
        raise InputTypeError(
            "color: expected a colour or a ColorFormula, got a function; bobrossnet.implicit takes functions"
        )
    return _core.ColorFormula.constant(*linear("color", color))


def _box(bounds: Any) -> NDArray[np.float64]:
    box = check_finite("bounds", check_array("bounds", bounds, (2, 3), hint="((x0, y0, z0), (x1, y1, z1))"))
    check_size("bounds", box)
    if not (box[0] < box[1]).all():
        raise InputError(f"bounds: expected each low below its high, got {box[0].tolist()} and {box[1].tolist()}")
    return np.array(box, np.float64)
