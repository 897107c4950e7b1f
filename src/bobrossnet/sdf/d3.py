"""Shapes in three dimensions, and operations on them. Editors and type checkers read d3.pyi (docs/modelling.py)."""

import numpy as np

from bobrossnet.sdf import words
from bobrossnet.sdf.solid import Solid

ORIGIN = np.array((0, 0, 0))

X = np.array((1, 0, 0))
Y = np.array((0, 1, 0))
Z = np.array((0, 0, 1))

UP = Z


class SDF3(Solid):
    """A shape in three dimensions. Operations are its methods; ``|``, ``&`` and ``-`` combine it with other shapes.

    Parameters
    ----------
    function : Expression, or callable
        A formula in x, y and z, negative inside; or a function of points (n, 3), called once with symbols, that returns
        one number for each.
    bounds : ((x0, y0, z0), (x1, y1, z1)) numbers, optional
        The box that contains the traced surface. If omitted, bounds are derived.
    color : str, 3 numbers in 0..1, ColorFormula or callable, optional
        Colour of the shape: sRGB as "#rrggbb", linear RGB, a formula, or a function of points that returns (n, 3).

    Attributes
    ----------
    expression : Expression
    bounds : (2, 3) float64 or None
    color_formula : ColorFormula or None
    """


words.add_methods(SDF3)
_words = words.shape_words(3)
globals().update(_words)
__all__ = ["ORIGIN", "SDF3", "UP", "X", "Y", "Z", *_words]
