"""User-defined words: shapes and operations written as functions of points, after fogleman/sdf.

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

The inner function takes points (n, 2) or (n, 3) and returns a number for each, (n,) or (n, 1), negative inside. It is
called once, with symbols in place of points, and may use numpy's functions; `np.where` replaces Python's `if`. In
operations, `other(p)` is the other shape's value at the points, (n, 1). Its colour is kept by functions of `other(p)`
alone, and by the choices `np.minimum`, `np.maximum` and `np.where`. Other combinations of two colours, such as sums,
have no colour.
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
    """Turn a function that returns a function of points (n, 2) into one that returns a shape in two dimensions."""
    return _making(SDF2, function)


def sdf3(function: Callable[P, Any]) -> Callable[P, SDF3]:
    """Turn a function that returns a function of points (n, 3) into one that returns a shape in three dimensions."""
    return _making(SDF3, function)


def op2(function: Callable[P, Any]) -> Callable[P, SDF2]:
    """Turn a function into an operation on a shape in two dimensions, its first argument, and a method of it."""
    return _method(SDF2, _making(SDF2, function))


def op3(function: Callable[P, Any]) -> Callable[P, SDF3]:
    """Turn a function into an operation on a shape in three dimensions, its first argument, and a method of it."""
    return _method(SDF3, _making(SDF3, function))


def op23(function: Callable[P, Any]) -> Callable[P, SDF3]:
    """Turn a function into an operation, and a method, from a shape in two dimensions to one in three."""
    return _method(SDF2, _making(SDF3, function))


def op32(function: Callable[P, Any]) -> Callable[P, SDF2]:
    """Turn a function into an operation, and a method, from a shape in three dimensions to one in two."""
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
