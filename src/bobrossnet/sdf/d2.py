"""Shapes in two dimensions, and operations on them. Editors and type checkers read d2.pyi (docs/modelling.py)."""

import numpy as np

from bobrossnet.sdf import words

ORIGIN = np.array((0, 0))

X = np.array((1, 0))
Y = np.array((0, 1))

UP = Y


class SDF2(words.Flat):
    """A shape in two dimensions. Operations are its methods; ``|``, ``&`` and ``-`` combine it with other shapes.

    Parameters
    ----------
    function : Expression, or callable
        A formula in x and y, negative inside; or a function of points (n, 2), called once with symbols, that returns
        one number for each.
    color : str, 3 numbers in 0..1, ColorFormula or callable, optional
        Colour of the shape: sRGB as "#rrggbb", linear RGB, a formula, or a function of points that returns (n, 3).

    Attributes
    ----------
    expression : Expression
    color_formula : ColorFormula or None
    """


words.add_methods(SDF2)
_words = words.shape_words(2)
globals().update(_words)
__all__ = ["ORIGIN", "SDF2", "UP", "X", "Y", *_words]
