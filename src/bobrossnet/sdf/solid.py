"""Solids: distance functions in three dimensions that can be traced, drawn and meshed."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.camera import CameraLike
from bobrossnet.picture.files import FORMATS, check_picture_path, color_to_8_bit, write_picture
from bobrossnet.picture.order import SizeLike
from bobrossnet.sdf import words
from bobrossnet.shapes.affine import IDENTITY
from bobrossnet.shapes.implicit import Implicit
from bobrossnet.shapes.mesh import FORMATS as MESH_FORMATS
from bobrossnet.shapes.mesh import Mesh, check_mesh_path
from bobrossnet.support.atomic import check_writable, write_whole
from bobrossnet.support.errors import InputError, check_array, check_integer, check_number, shape_of
from bobrossnet.support.paths import path_of
from bobrossnet.tracing.trace import trace

SAMPLES = 2**22
"""Default number of samples, as in fogleman/sdf."""


class Solid(words.SDF, Implicit):
    """Base class of `SDF3`, without the language's operations."""

    dimensions = 3

    def __init__(self, function: Any, bounds: Any = None, color: Any = None) -> None:
        expression, own_color = words.formulas(function, color, 3)
        Implicit.__init__(self, expression, bounds, own_color)
        self._k = None

    def __reduce__(self) -> tuple[Any, ...]:
        return (*super().__reduce__()[:2], {"_k": self._k})

    def save(
        self,
        path: str | os.PathLike[str],
        step: Any = None,
        bounds: Any = None,
        samples: float | None = SAMPLES,
        workers: Any = None,
        batch_size: Any = None,
        verbose: Any = None,
        sparse: Any = None,
        *,
        size: SizeLike = (480, 640),
        camera: CameraLike | None = None,
    ) -> None:
        """Write the shape as a mesh, as a formula, or as a picture.

        Parameters
        ----------
        path : str or path
            The ending selects a mesh, .stl, .ply, .obj or .glb; a formula, .3mf, in millimetres, by the Volumetric and
            Implicit Extensions 1.0; or a picture, such as ``.png``.
        step, bounds, samples
            As in `generate`; a picture and a 3MF use the bounds alone.
        workers, batch_size, verbose, sparse
            Accepted for fogleman/sdf, and ignored.
        size : (height, width) or "WIDTHxHEIGHT"
            Size of a picture.
        camera : Camera, optional
            Camera of a picture.

        Raises
        ------
        InputError
            If the ending is unknown, or the shape can't be traced or meshed.
        """
        ending = path_of(path).suffix.lower()
        if ending in MESH_FORMATS:
            check_mesh_path(path)
            self._within(bounds, step, samples).save(path)
        elif ending == ".3mf":
            from bobrossnet.adapters.threemf_writing import written_3mf

            path = check_writable(path)
            write_whole(path, written_3mf(self._in(bounds)))
        elif ending in FORMATS:
            path = check_picture_path(path)
            seen = trace(self._in(bounds), camera, size=size)
            write_picture(path, color_to_8_bit(seen.color if self.is_colored else seen.gray))
        else:
            endings = " ".join([*MESH_FORMATS, ".3mf", *FORMATS])
            raise InputError(f"{path}: expected the ending of a mesh or a picture ({endings}), got {ending or 'none'}")

    def generate(
        self,
        step: Any = None,
        bounds: Any = None,
        samples: float | None = SAMPLES,
        workers: Any = None,
        batch_size: Any = None,
        verbose: Any = None,
        sparse: Any = None,
    ) -> NDArray[np.float64]:
        """Return the corners of a mesh's triangles, in fogleman/sdf's layout; `mesh` returns vertices and triangles.

        Parameters
        ----------
        step : number above 0, or 3 of them, optional
            Length of the triangles' sides; of 3 numbers, the minimum is used.
        bounds : ((x0, y0, z0), (x1, y1, z1)) numbers, optional
            The box to mesh; by default the shape's bounds, given or derived. The shape is cut by it and closed there.
        samples : number above 0, optional
            If the step is omitted, the number of grid points within the bounds that determines it.
        workers, batch_size, verbose, sparse
            Accepted for fogleman/sdf, and ignored.

        Returns
        -------
        (3 t, 3) float64
            Three for each triangle, anticlockwise seen from outside.
        """
        mesh = self._within(bounds, step, samples)
        return mesh.vertices[mesh.triangles].reshape(-1, 3)

    def _within(self, bounds: Any, step: Any, samples: float | None) -> Mesh:
        """Return the mesh for the arguments of `generate`."""
        shape = self._in(bounds)
        if step is not None and shape_of(step):
            step = float(check_array("step", step, (3,)).min())
        if step is None and samples is not None:
            low, high = shape.bounding_box(IDENTITY)
            step = (float(np.prod(high - low)) / check_number("samples", samples, 1)) ** (1 / 3)
        return shape.mesh(step)

    def _in(self, bounds: Any) -> Implicit:
        """Return the shape within other bounds; None keeps its bounds."""
        return self if bounds is None else Implicit(self.expression, bounds, self.color_formula)

    def sample_slice(
        self, w: int = 1024, h: int = 1024, x: Any = None, y: Any = None, z: Any = None, bounds: Any = None
    ) -> tuple[NDArray[np.float64], tuple[float, float, float, float], str]:
        """Return the signed distances on a plane perpendicular to an axis.

        Parameters
        ----------
        w, h : int, 2..8192
            Number of points along the first and the second of the other two axes.
        x, y or z : number
            Position of the plane; the first one given is used.
        bounds : ((x0, y0, z0), (x1, y1, z1)) numbers, optional
            By default the shape's bounds.

        Returns
        -------
        distances : (w, h) float64
        extent : (low, high, low, high)
            Range of the second of these axes and of the first, for matplotlib's imshow.
        axes : str
            Names of both in this order, such as "YX".
        """
        size = check_integer("w", w, 2, 8192), check_integer("h", h, 2, 8192)
        shape = self._in(bounds)
        low, high = shape.bounding_box(IDENTITY) if bounds is None or shape.bounds is None else shape.bounds
        across = next((axis for axis, at in enumerate((x, y, z)) if at is not None), None)
        if across is None:
            raise InputError("show_slice: expected a plane, x=, y= or z=, got none")
        at = check_number("xyz"[across], (x, y, z)[across])
        first, second = (axis for axis in range(3) if axis != across)
        lines = [np.linspace(low[axis], high[axis], n) for axis, n in zip((first, second), size, strict=True)]
        points = np.full((*size, 3), at)
        points[..., first], points[..., second] = np.meshgrid(*lines, indexing="ij")
        extent = (float(low[second]), float(high[second]), float(low[first]), float(high[first]))
        return self(points.reshape(-1, 3)).reshape(size), extent, "XYZ"[second] + "XYZ"[first]

    def show_slice(self, *args: Any, abs: bool = False, **kwargs: Any) -> None:
        """Plot the signed distances on a plane, by matplotlib.

        Parameters
        ----------
        As in `sample_slice`, such as ``z=0``.
        abs : bool
            Whether to plot absolute distances.

        Raises
        ------
        InputError
            If an argument is invalid, or matplotlib is not installed.
        """
        distances, extent, axes = self.sample_slice(*args, **kwargs)
        try:
            import matplotlib.pyplot as plt
        except ModuleNotFoundError:
            raise InputError("show_slice: expected matplotlib, found none: pip install matplotlib") from None
        plt.imshow(np.abs(distances) if abs else distances, extent=extent, origin="lower")
        plt.xlabel(axes[0])
        plt.ylabel(axes[1])
        plt.colorbar()
        plt.show()
