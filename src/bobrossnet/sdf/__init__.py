"""A language for modelling shapes as distance functions, after fogleman/sdf.

Programs written for that package run with their first line changed:

>>> from bobrossnet.sdf import *
>>> f = sphere(1) & box(1.5)
>>> c = cylinder(0.5)
>>> f -= c.orient(X) | c.orient(Y) | c.orient(Z)
>>> f([(0, 0, 0), (0.75, 0.75, 0)]).round(3).tolist()
[[0.5], [0.061]]

Functions make shapes and modify them; those that modify a shape are also its methods. A name has its meaning in three
dimensions; `d2` and `d3` have both meanings, and `ease` the easing functions. docs/modelling.md lists all words.
"""

import math
import os
from typing import Any, NoReturn

import numpy as np

from bobrossnet.sdf import custom, d2, d3, ease
from bobrossnet.sdf.custom import *  # noqa: F403
from bobrossnet.sdf.d2 import *  # noqa: F403
from bobrossnet.sdf.d3 import *  # type: ignore[assignment]  # noqa: F403  # in place of those of two dimensions
from bobrossnet.sdf.d3 import SDF3

pi = math.pi
degrees = math.degrees
radians = math.radians


def save(path: str | os.PathLike[str], shape: SDF3, *args: Any, **kwargs: Any) -> None:
    """Write a picture of a shape, as its method `save` does."""
    shape.save(path, *args, **kwargs)


def generate(shape: SDF3, *args: Any, **kwargs: Any) -> NoReturn:
    """Not possible: shapes are traced, not turned into triangles."""
    shape.generate(*args, **kwargs)


def show_slice(shape: SDF3, *args: Any, **kwargs: Any) -> NoReturn:
    """Not possible: ``shape(points)`` gives the distances to plot."""
    shape.show_slice(*args, **kwargs)


__all__ = ["d2", "d3", "degrees", "ease", "generate", "np", "pi", "radians", "save", "show_slice"]
__all__ += [*custom.__all__, *d2.__all__, *d3.__all__]
