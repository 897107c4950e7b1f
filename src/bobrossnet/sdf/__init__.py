"""A modelling language of signed distance functions, compatible with fogleman/sdf.

Programs for that package run with their first line changed:

>>> from bobrossnet.sdf import *
>>> f = sphere(1) & box(1.5)
>>> c = cylinder(0.5)
>>> f -= c.orient(X) | c.orient(Y) | c.orient(Z)
>>> f([(0, 0, 0), (0.75, 0.75, 0)]).round(3).tolist()
[[0.5], [0.061]]

Functions create and modify shapes; modifiers are also methods of shapes. Names are the three-dimensional versions; `d2`
and `d3` have both, and `ease` has the easing functions. docs/modelling.md lists all words.
"""

import math
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.sdf import d2, d3, ease
from bobrossnet.sdf.custom import *  # noqa: F403
from bobrossnet.sdf.d2 import *  # noqa: F403
from bobrossnet.sdf.d3 import *  # type: ignore[assignment]  # noqa: F403  # replaces the two-dimensional names
from bobrossnet.sdf.d3 import SDF3
from bobrossnet.sdf.lettering import *  # noqa: F403
from bobrossnet.sdf.masks import *  # noqa: F403
from bobrossnet.sdf.meshes import *  # noqa: F403
from bobrossnet.sdf.meshes import Mesh
from bobrossnet.support.atomic import check_writable
from bobrossnet.support.errors import InputError, check_array

pi = math.pi
degrees = math.degrees
radians = math.radians


def save(path: str | os.PathLike[str], shape: SDF3, *args: Any, **kwargs: Any) -> None:
    """Write a shape as a mesh or a picture; see the method `save`."""
    shape.save(path, *args, **kwargs)


def generate(shape: SDF3, *args: Any, **kwargs: Any) -> NDArray[np.float64]:
    """Return the corners of a mesh's triangles; see the method `generate`."""
    return shape.generate(*args, **kwargs)


def write_binary_stl(path: str | os.PathLike[str], points: Any) -> None:
    """Write triangles, corners (3 t, 3) as from `generate`, to an STL file with the ending .stl."""
    check_writable(path, "an STL file", [".stl"])
    corners = check_array("points", points, (None, 3))
    if len(corners) % 3:
        raise InputError(f"points: expected three for each triangle, got {len(corners)}")
    Mesh(corners, np.arange(len(corners)).reshape(-1, 3)).save(path)


def sample_slice(
    shape: SDF3, *args: Any, **kwargs: Any
) -> tuple[NDArray[np.float64], tuple[float, float, float, float], str]:
    """Return signed distances on a plane; see the method `sample_slice`."""
    return shape.sample_slice(*args, **kwargs)


def show_slice(shape: SDF3, *args: Any, **kwargs: Any) -> None:
    """Plot the signed distances on a plane; see the method `show_slice`."""
    shape.show_slice(*args, **kwargs)


# ruff: noqa: F405
# Type checkers need a list of literals.
__all__ = [
    "ORIGIN",
    "SDF2",
    "SDF3",
    "UP",
    "Mesh",
    "X",
    "Y",
    "Z",
    "bend",
    "bend_linear",
    "bend_radial",
    "blend",
    "box",
    "capped_cone",
    "capped_cylinder",
    "capsule",
    "circle",
    "circular_array",
    "color",
    "cylinder",
    "d2",
    "d3",
    "degrees",
    "difference",
    "dilate",
    "dodecahedron",
    "ease",
    "ellipsoid",
    "elongate",
    "equilateral_triangle",
    "erode",
    "extrude",
    "extrude_to",
    "generate",
    "hexagon",
    "icosahedron",
    "image",
    "intersection",
    "line",
    "measure_image",
    "measure_text",
    "negate",
    "np",
    "octahedron",
    "op2",
    "op3",
    "op23",
    "op32",
    "orient",
    "pi",
    "plane",
    "polygon",
    "pyramid",
    "radians",
    "rectangle",
    "repeat",
    "revolve",
    "rotate",
    "rotate_to",
    "rounded_box",
    "rounded_cone",
    "rounded_cylinder",
    "rounded_rectangle",
    "rounded_x",
    "sample_slice",
    "save",
    "scale",
    "sdf2",
    "sdf3",
    "shell",
    "show_slice",
    "slab",
    "slice",
    "sphere",
    "tetrahedron",
    "text",
    "torus",
    "transition_linear",
    "transition_radial",
    "translate",
    "twist",
    "union",
    "vesica",
    "wireframe_box",
    "wrap_around",
    "write_binary_stl",
]
