"""Line drawings: visible edges of a scene and, on demand, hidden ones, over pictures or alone."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import Color, hex_color, linear
from bobrossnet.picture.camera import Camera, check_camera
from bobrossnet.picture.files import FORMATS
from bobrossnet.picture.order import SizeLike, check_size
from bobrossnet.pictures.background import Background, picture_of
from bobrossnet.pictures.hidden import Curves, hidden_edges
from bobrossnet.pictures.rendered import Picture
from bobrossnet.support.atomic import check_writable, write_whole
from bobrossnet.support.errors import InputError, InputTypeError, check_flag, check_number, shape_of
from bobrossnet.tracing.scene import Scene, SceneLike, as_scene

F32 = NDArray[np.float32]

SVG = ".svg"

HIDDEN_WIDTH = 0.6
"""Width of hidden lines, in widths of visible ones: about the half of ISO 128, and still visible at one pixel."""

DASH, GAP = 4.0, 2.5
"""Dashes of hidden lines, in widths of visible lines."""


@dataclass(frozen=True)
class Edges:
    """Lines of a drawing.

    Raises
    ------
    InputError
        If a value is out of range.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> bob.Edges(width=2, hidden=True)
    Edges(width=2.0, color='#000000', hidden=True, smooth=True)
    """

    width: float = 1.5
    """Width in pixels, 0.1..100, whatever the zoom. Hidden lines have 0.6 of it, and dashes."""
    color: Color = "#000000"
    """Color of the lines, in any form that `Material.color` accepts."""
    hidden: bool = field(default=False, kw_only=True)
    """Whether to draw hidden borders of NURBS faces and hidden creases of meshes, too."""
    smooth: bool = field(default=True, kw_only=True)
    """Whether to draw visible borders where NURBS faces meet without a crease, as at fillets."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "width", float(check_number("width", self.width, 0.1, 100)))
        linear("color", self.color)
        for name in ("hidden", "smooth"):
            object.__setattr__(self, name, check_flag(name, getattr(self, name)))


EdgesLike: TypeAlias = bool | Edges


def check_edges(edges: Any) -> Edges | None:
    """Return the lines to draw for an argument `edges`; None for no lines."""
    if isinstance(edges, Edges):
        return edges
    if not isinstance(edges, bool | np.bool_):
        raise InputTypeError(f"edges: expected True, False or Edges, got {type(edges).__name__}")
    return Edges() if edges else None


class Drawing:
    """A line drawing. `numpy.asarray(drawing)` is its picture; notebooks display it.

    Attributes
    ----------
    size : (height, width)
    edges : Edges
    visible, hidden : tuple of (n, 2) float32
        Polylines of rows and columns; pixel centres are integers. Closed curves end where they begin.
    """

    def __init__(self, visible: Curves, hidden: Curves | None, size: tuple[int, int], edges: Edges) -> None:
        self.size, self.edges = size, edges
        self._visible, self._hidden = visible, hidden

    def __reduce__(self) -> tuple[Any, ...]:
        return Drawing, (self._visible, self._hidden, self.size, self.edges)

    @property
    def visible(self) -> tuple[F32, ...]:
        return _polylines(self._visible)

    @property
    def hidden(self) -> tuple[F32, ...]:
        return () if self._hidden is None else _polylines(self._hidden)

    def coverage(self) -> F32:
        """Return the share of each pixel that lines cover, (H, W) in 0..1."""
        coverage = np.zeros(self.size, np.float32)
        width = self.edges.width
        if self._hidden is not None:
            dashes = _core.dashed(*self._hidden, DASH * width, GAP * width)
            _core.draw_strokes(*dashes, HIDDEN_WIDTH * width, coverage)
        _core.draw_strokes(*self._visible, width, coverage)
        return coverage

    def over(self, picture: Picture, coverage: F32 | None = None) -> Picture:
        """Return a picture of the same size with the lines over it; `coverage` is theirs, if it is known."""
        coverage = self.coverage() if coverage is None else coverage
        covered = np.nonzero(coverage)
        share = coverage[covered]
        color, alpha = picture.color.copy(), picture.alpha.copy()
        color[covered] += share[:, None] * (np.asarray(linear("color", self.edges.color), np.float32) - color[covered])
        alpha[covered] += share * (1 - alpha[covered])
        return Picture(color, alpha)

    def picture(self, background: Background = None) -> Picture:
        """Return the drawing as pixels, on a background as in `render`."""
        empty = picture_of(np.zeros((*self.size, 3), np.float32), np.zeros(self.size, np.float32), background)
        return self.over(empty)

    def svg(self, background: Background = None) -> str:
        """Return the drawing as an SVG document, one unit a pixel; the background is one colour or None."""
        height, width = self.size
        lines = [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">'
        ]
        if background is not None:
            lines.append(f'<rect width="100%" height="100%" fill="{svg_color("background", background)}"/>')
        stroke, color = self.edges.width, svg_color("color", self.edges.color)
        lines.append(f'<g fill="none" stroke="{color}" stroke-linecap="round" stroke-linejoin="round">')
        if self._hidden is not None:
            dashes = f"{DASH * stroke:g} {GAP * stroke:g}"
            lines += [
                f'<g id="hidden" stroke-width="{HIDDEN_WIDTH * stroke:g}" stroke-dasharray="{dashes}" '
                'stroke-linecap="butt">',
                *_paths(self.hidden),
                "</g>",
            ]
        lines += [f'<g id="visible" stroke-width="{stroke:g}">', *_paths(self.visible), "</g>", "</g>", "</svg>", ""]
        return "\n".join(lines)

    def save(self, path: str | os.PathLike[str], background: Any = None) -> None:
        """Write the drawing as .svg, or as a picture on a background in the format of the path's ending.

        Raises
        ------
        InputError
            If the ending is unknown, or the file can't be written.
        """
        file = check_drawing_path(path)
        if file.suffix.lower() == SVG:
            write_whole(file, self.svg(background).encode())
        else:
            self.picture(background).save(file)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.picture().rgba, dtype, copy=copy)

    def _repr_svg_(self) -> str:
        return self.svg()

    def __repr__(self) -> str:
        hidden = f", {len(self.hidden):,} hidden" if self._hidden is not None else ""
        return f"Drawing({self.size[0]} x {self.size[1]}, {len(self._visible[1]):,} visible curves{hidden})"


def draw(
    scene: SceneLike, camera: Camera | None = None, *, size: SizeLike = (480, 640), edges: Edges | None = None
) -> Drawing:
    """Draw the edges of a scene: borders of NURBS faces, creases of other surfaces, silhouettes.

    Faces of STEP files and of other breps end at their borders, without seams of closed surfaces. Other surfaces have a
    crease where their normals differ by 25 degrees or more.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these
    camera : Camera, optional
    size : (height, width) or "WIDTHxHEIGHT"
    edges : Edges, optional

    Returns
    -------
    Drawing
        A notebook displays it; `save` writes SVG or pixels.

    Raises
    ------
    InputError
        If an argument is out of range.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> bob.draw(bob.happy_tree(), size="160x120").size
    (120, 160)
    """
    scene = as_scene(scene)
    camera = check_camera(Camera() if camera is None else camera)
    height, width = check_size(size)
    if edges is not None and not isinstance(edges, Edges):
        raise InputTypeError(f"edges: expected Edges, got {type(edges).__name__}")
    return drawing_of(scene, camera, (height, width), edges or Edges())


def drawing_of(scene: Scene, camera: Camera, size: tuple[int, int], edges: Edges) -> Drawing:
    """Return the drawing of checked arguments; see `draw`."""
    core = camera.core(scene.center, scene.radius)
    visible = _core.visible_edges(scene.core, core, *size, edges.smooth)
    hidden = hidden_edges(scene, camera, size) if edges.hidden else None
    return Drawing(visible, hidden, size, edges)


def check_drawing_path(path: str | os.PathLike[str]) -> Any:
    """Return `path` if a drawing can be written there."""
    return check_writable(path, "a drawing", (SVG, *FORMATS))


def _polylines(curves: Curves) -> tuple[F32, ...]:
    points, ends = curves
    return tuple(np.split(points, ends[:-1])) if len(ends) else ()


def _paths(curves: Iterable[F32]) -> list[str]:
    """Return SVG paths; pixel centres lie at halves there."""
    paths = []
    for curve in curves:
        closed = len(curve) > 2 and (curve[0] == curve[-1]).all()
        places = " ".join(f"{x:.2f},{y:.2f}" for y, x in (curve[:-1] if closed else curve) + 0.5)
        paths.append(f'<path d="M{places}{"Z" if closed else ""}"/>')
    return paths


def svg_color(name: str, color: Any) -> str:
    """Return a colour as an SVG has it; raise InputError for two."""
    if not isinstance(color, str) and shape_of(color) == (2,):
        raise InputError(f"{name}: expected one colour for an SVG, got two")
    return hex_color(linear(name, color))
