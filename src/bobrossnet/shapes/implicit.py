"""Implicit surfaces: shapes that are inside where a formula is negative."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.errors import InputError, InputTypeError, check_array, check_finite
from bobrossnet.shapes.formula import expression_of

if TYPE_CHECKING:
    from bobrossnet.sdf.d3 import SDF3


class Implicit:
    """The surface f(x, y, z) = 0 of a formula; f < 0 is inside.

    Parameters
    ----------
    expression : Expression
        f, in any unit: it need not be a distance.
    bounds : ((x0, y0, z0), (x1, y1, z1)) numbers, finite, each low below its high, optional
        The box that is looked at. Without it, it is found, and a shape without bounds is refused.

    Raises
    ------
    InputError
        If the bounds are no box.
    """

    __slots__ = ("bounds", "expression")

    expression: _core.Expression
    bounds: NDArray[np.float64] | None

    def __init__(self, expression: _core.Expression, bounds: Any = None) -> None:
        if not isinstance(expression, _core.Expression):
            hint = "; bobrossnet.implicit takes functions" if callable(expression) else ""
            raise InputTypeError(f"expression: expected an Expression, got {type(expression).__name__}{hint}")
        self.expression = expression
        self.bounds = None if bounds is None else _box(bounds)

    def __repr__(self) -> str:
        bounds = "" if self.bounds is None else f", bounds={self.bounds.tolist()}"
        return f"Implicit({self.expression}{bounds})"


def implicit(function: Callable[..., Any], bounds: Any = None) -> SDF3:
    """The shape that is inside where a function is negative.

    The function is called once, with symbols, and what it computes becomes a formula; it may use operators, numpy's
    functions, `np.where`, and loops and conditions on numbers.

    Parameters
    ----------
    function : callable
        f(x, y, z), of any unit: it need not be a distance.
    bounds : ((x0, y0, z0), (x1, y1, z1)) numbers, finite, each low below its high, optional
        The box that is looked at. Without it, it is found, and a shape without bounds is refused.

    Returns
    -------
    SDF3
        With the modelling language's operations as methods; where f is no distance, blends and offsets are as uneven
        as f is.

    Raises
    ------
    InputError
        If the function can't be turned into a formula, or the bounds are no box; the message says why.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> tangle = bob.implicit(lambda x, y, z: x**4 + y**4 + z**4 - 5 * (x * x + y * y + z * z) + 11.8)
    >>> print(tangle.expression)
    x**4 + y**4 + z**4 - (x**2 + y**2 + z**2) * 5 + 11.8
    """
    from bobrossnet.sdf.d3 import SDF3  # the language is built on this file

    return SDF3(expression_of(function, 3), bounds)


def _box(bounds: Any) -> NDArray[np.float64]:
    box = check_finite("bounds", check_array("bounds", bounds, (2, 3), hint="((x0, y0, z0), (x1, y1, z1))"))
    if not (box[0] < box[1]).all():
        raise InputError(f"bounds: expected each low below its high, got {box[0].tolist()} and {box[1].tolist()}")
    return np.array(box, np.float64)
