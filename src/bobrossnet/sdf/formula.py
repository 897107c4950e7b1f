"""Shapes from formulas, with the modelling language's operations as methods."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bobrossnet import _core
from bobrossnet.sdf.d3 import SDF3
from bobrossnet.sdf.symbols import color_formula_of, expression_of


def implicit(function: Callable[..., Any], bounds: Any = None, color: Any = None) -> SDF3:
    """Make the shape that is inside where a function is negative.

    The function is called once, with symbols, and its operations are recorded as a formula; it may use operators,
    numpy's functions, `np.where`, and loops and conditions on numbers.

    Parameters
    ----------
    function : callable
        f(x, y, z), in any unit: it need not be a distance.
    bounds : ((x0, y0, z0), (x1, y1, z1)) numbers, finite, each low below its high, optional
        The box that contains the surface. If omitted, bounds are derived, and an unbounded shape is refused.
    color : callable, str, 3 numbers in 0..1 or ColorFormula, optional
        Colour of the surface: a function of x, y and z that returns linear (r, g, b), or a constant, sRGB as "#rrggbb"
        or linear RGB. Values are clamped to 0..1, with NaN as 0.

    Returns
    -------
    SDF3
        With the modelling language's operations as methods. Where f is not a distance, blends and offsets are uneven.

    Raises
    ------
    InputError
        If a function can't be recorded as a formula, the bounds are not a box, or the colour is invalid; the message
        gives the reason.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> tangle = bob.implicit(lambda x, y, z: x**4 + y**4 + z**4 - 5 * (x * x + y * y + z * z) + 11.8)
    >>> print(tangle.expression)
    x**4 + y**4 + z**4 - (x**2 + y**2 + z**2) * 5 + 11.8
    >>> striped = bob.implicit(lambda x, y, z: x * x + y * y + z * z - 1, color=lambda x, y, z: (z % 0.5, 0.1, 0.2))
    """
    if callable(color) and not isinstance(color, _core.ColorFormula):
        color = color_formula_of(color)
    return SDF3(expression_of(function, 3), bounds, color)
