"""What solids can do besides the language's operations: be traced and drawn."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, NoReturn

from bobrossnet.errors import InputError
from bobrossnet.picture.camera import Camera
from bobrossnet.picture.files import FORMATS, check_picture_path, to_8_bit, write_picture
from bobrossnet.picture.order import SizeLike
from bobrossnet.sdf import words
from bobrossnet.shapes.implicit import Implicit
from bobrossnet.tracing.trace import trace


class Solid(words.SDF, Implicit):
    """What `SDF3`, which has the language's operations besides, is made of."""

    dimensions = 3

    def __init__(self, function: Any, bounds: Any = None) -> None:
        Implicit.__init__(self, words.formula(function, 3), bounds)
        self._k = None

    def __reduce__(self) -> tuple[Any, ...]:
        return (*super().__reduce__()[:2], {"_k": self._k})

    def save(
        self,
        path: str | os.PathLike[str],
        step: Any = None,
        bounds: Any = None,
        samples: Any = None,
        workers: Any = None,
        batch_size: Any = None,
        verbose: Any = None,
        sparse: Any = None,
        *,
        size: SizeLike = (480, 640),
        camera: Camera | None = None,
    ) -> None:
        """Write a picture of the shape.

        Parameters
        ----------
        path : str or path
            Ends in that of a picture, such as ``.png``.
        bounds : ((x0, y0, z0), (x1, y1, z1)) numbers, optional
            The box to look in; by default the shape's own, or the one that is found.
        step, samples, workers, batch_size, verbose, sparse
            Of programs that write meshes; a picture doesn't need them.
        size : (height, width) or "WIDTHxHEIGHT"
        camera : Camera, optional

        Raises
        ------
        InputError
            If the path isn't that of a picture, or the shape can't be traced.
        """
        if Path(path).suffix.lower() not in FORMATS:
            raise InputError(
                f"{path}: expected a picture's ending ({' '.join(FORMATS)}), got {Path(path).suffix or 'none'}; "
                "shapes are traced, not turned into triangles"
            )
        path = check_picture_path(path)
        shape = self if bounds is None else Implicit(self.expression, bounds)
        write_picture(path, to_8_bit(trace(shape, camera, size=size).gray))

    def generate(self, *args: Any, **kwargs: Any) -> NoReturn:
        """Not possible: shapes are traced, not turned into triangles."""
        raise InputError(
            "generate: expected a picture, got a request for triangles, which shapes are not turned into; "
            "shape.save('picture.png') draws it, bobrossnet.trace(shape) gives its G-buffer"
        )

    def show_slice(self, *args: Any, **kwargs: Any) -> NoReturn:
        """Not possible: ``shape(points)`` gives the distances to plot."""
        raise InputError(
            "show_slice: expected a picture of the surface, got a request for a plot of distances; "
            "shape(points) gives them, shape.slice() the section at z = 0, shape.save('picture.png') the surface"
        )
