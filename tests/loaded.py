"""Files as tests load them: with their warnings, and measured."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob


def told(file: Path) -> tuple[bob.Scene, list[str]]:
    """Return a file's scene, and the texts of all warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene = bob.load(file)
    return scene, [str(warning.message) for warning in caught]


def area(vertices: NDArray[np.float64], triangles: NDArray[np.int32]) -> float:
    """Return the area of a mesh."""
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def area_of(shape: bob.Shape) -> float:
    """Return the area of a shape that is a mesh."""
    assert isinstance(shape, bob.Mesh)
    return area(shape.vertices, shape.triangles)
