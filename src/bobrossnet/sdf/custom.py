"""Words of your own: shapes and operations written as functions of points, after fogleman/sdf.

>>> import numpy as np
>>> from bobrossnet.sdf import *
>>> @sdf3
... def ellipsoid_like(radii=(1, 2, 3)):
...     def f(p):
...         return (np.linalg.norm(p / radii, axis=1) - 1) * min(radii)
...     return f
>>> @op3
... def bumpy(other, height=0.1):
...     def f(p):
...         return other(p) + height * np.sin(20 * p).prod(axis=1, keepdims=True)
...     return f
>>> f = ellipsoid_like((1, 1, 0.5)).bumpy(0.05) | sphere(0.5)

The function within takes points (n, 2) or (n, 3) and returns a number for each, (n,) or (n, 1), negative inside. It is
called once, with symbols in the place of points, and may use numpy's functions; `np.where` chooses between values where
Python's `if` would. In operations, `other(p)` is the other shape's value at the points, (n, 1), which carries its
colour along: through whatever is done to it alone, and through `np.minimum`, `np.maximum` and `np.where`, which choose
one. Where shapes of two colours are mixed otherwise, as sums are, the result has none.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

from bobrossnet.sdf.d2 import SDF2
from bobrossnet.sdf.d3 import SDF3
from bobrossnet.sdf.symbols import formulas_of_points

P = ParamSpec("P")
S = TypeVar("S", SDF2, SDF3)


def sdf2(function: Callable[P, Any]) -> Callable[P, SDF2]:
    """Make a function that returns a function of points (n, 2) return a shape in two dimensions."""
    return _making(SDF2, function)


def sdf3(function: Callable[P, Any]) -> Callable[P, SDF3]:
    """Make a function that returns a function of points (n, 3) return a shape in three dimensions."""
    return _making(SDF3, function)


def op2(function: Callable[P, Any]) -> Callable[P, SDF2]:
    """Make a function an operation on shapes in two dimensions, its first argument, and a method of them."""
    return _method(SDF2, _making(SDF2, function))


def op3(function: Callable[P, Any]) -> Callable[P, SDF3]:
    """Make a function an operation on shapes in three dimensions, its first argument, and a method of them."""
    return _method(SDF3, _making(SDF3, function))


def op23(function: Callable[P, Any]) -> Callable[P, SDF3]:
    """Make a function an operation that makes of a shape in two dimensions one in three, and a method of the former."""
    return _method(SDF2, _making(SDF3, function))


def op32(function: Callable[P, Any]) -> Callable[P, SDF2]:
    """Make a function an operation that makes of a shape in three dimensions one in two, and a method of the former."""
    return _method(SDF3, _making(SDF2, function))


def _making(shape: type[S], function: Callable[P, Any]) -> Callable[P, S]:
    name = getattr(function, "__name__", "function")

    @functools.wraps(function)
    def make(*args: P.args, **kwargs: P.kwargs) -> S:
        made = function(*args, **kwargs)
        if isinstance(made, shape):
            return made
        expression, color = formulas_of_points(made, shape.dimensions, name)
        return shape(expression, color=color)

    return make


def _method(shape: type[SDF2 | SDF3], operation: Callable[P, S]) -> Callable[P, S]:
    setattr(shape, getattr(operation, "__name__", "operation"), operation)
    return operation


__all__ = ["op2", "op3", "op23", "op32", "sdf2", "sdf3"]
