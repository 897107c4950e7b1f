"""Text as shapes in two dimensions, after fogleman/sdf: the outlines of a font's letters themselves."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import ImageFont

from bobrossnet.errors import InputError, InputTypeError
from bobrossnet.sdf.d2 import SDF2
from bobrossnet.sdf.outlines import Outline, Places, arcs_along, fitted_size, region

TOLERANCE = 3e-5
"""How far outlines are from the font's curves at most, in the font's size."""


@dataclass(frozen=True)
class Line:
    """A line of text in units of the font's size: the Bézier curves of each outline, and the box around it, from where
    its first letter begins to where another would, or as far as the letters reach beyond that."""

    outlines: list[list[Places]]
    low: complex
    high: complex

    @property
    def size(self) -> tuple[float, float]:
        across = self.high - self.low
        return across.real, across.imag


def measure_text(
    font_name: str | os.PathLike[str], text: str, width: float | None = None, height: float | None = None
) -> tuple[float, float]:
    """The width and height of the shape that `text` makes of the same arguments.

    Parameters
    ----------
    As of `text`.

    Returns
    -------
    (width, height) : floats
        Across from where the first letter begins to where another would follow, spaces included, or as far as letters reach
        beyond; from the lowest to the highest point of the letters.

    Raises
    ------
    InputError
        As `text`.
    """
    return fitted_size("measure_text", _line("measure_text", font_name, text).size, width, height)


def text(
    font_name: str | os.PathLike[str],
    text: str,
    width: float | None = None,
    height: float | None = None,
    pixels: Any = None,
    points: Any = None,
) -> SDF2:
    """A line of text, its middle at the origin.

    Its outline is the font's own to 3e-5 of the font's size, of which letters are about 0.7 high: arcs along its
    curves. Distances are those from this outline. Letters follow one another by their widths and the font's `kern` table; there
    are no ligatures, and scripts that join or reorder letters are not shaped.

    Parameters
    ----------
    font_name : str or path
        A font file, TrueType or OpenType, or a name under which Pillow finds one, such as ``"DejaVuSans.ttf"``.
    text : str
        One line. What the font has no letter for is drawn as its box for that.
    width, height : numbers above 0, optional
        Of the box that `measure_text` describes; with both, letters are stretched. Without either, the height is 1.
    pixels, points
        Of fogleman/sdf, and not needed.

    Raises
    ------
    InputError
        If the font can't be read, the text has nothing to be seen, or fontTools is missing.

    Examples
    --------
    >>> from bobrossnet.sdf import *
    >>> w, h = measure_text("DejaVuSans.ttf", "Hello")  # doctest: +SKIP
    >>> f = rounded_box((w + 1, h + 1, 0.2), 0.1) - text("DejaVuSans.ttf", "Hello").extrude(0.1).translate(0.1 * Z)
    ... # doctest: +SKIP
    """
    line = _line("text", font_name, text)
    wide, high = fitted_size("text", line.size, width, height)
    scale_x, scale_y = wide / line.size[0], high / line.size[1]
    middle = (line.low + line.high) / 2

    def placed(curve: Places) -> Places:
        from_middle = curve - middle
        return from_middle.real * scale_x + 1j * from_middle.imag * scale_y

    tolerance = TOLERANCE * min(scale_x, scale_y)
    outlines: list[Outline] = []
    for outline in line.outlines:
        outlines.append(
            np.concatenate([arcs_along(placed(curve), tolerance, max(scale_x, scale_y)) for curve in outline])
        )
    return region(outlines, "text")


def _line(name: str, font_name: str | os.PathLike[str], text: str) -> Line:
    """The text in a font; `name` begins messages."""
    try:
        from fontTools.pens.basePen import BasePen
        from fontTools.pens.boundsPen import BoundsPen
        from fontTools.ttLib import TTFont, TTLibError
    except ModuleNotFoundError:
        raise InputError(f"{name}: this needs fontTools: pip install 'bobrossnet[text]'") from None
    if not isinstance(text, str):
        raise InputTypeError(f"{name}: text: expected a string, got {type(text).__name__}")
    if not text.isprintable():
        raise InputError(f"{name}: text: expected one line of letters, got {text!r}; make each line a shape of its own")
    path = _font_file(name, font_name)

    class Pen(BasePen):  # type: ignore[misc]
        """Writes down the curves of outlines, which it closes."""

        def __init__(self, glyphs: Any) -> None:
            super().__init__(glyphs)
            self.outlines: list[list[list[tuple[float, float]]]] = []

        def _moveTo(self, point: Any) -> None:
            self.outlines.append([])
            self.first = point

        def _lineTo(self, point: Any) -> None:
            if point != self._getCurrentPoint():
                self.outlines[-1].append([self._getCurrentPoint(), point])

        def _qCurveToOne(self, control: Any, point: Any) -> None:
            self.outlines[-1].append([self._getCurrentPoint(), control, point])

        def _curveToOne(self, control1: Any, control2: Any, point: Any) -> None:
            self.outlines[-1].append([self._getCurrentPoint(), control1, control2, point])

        def _closePath(self) -> None:
            self._lineTo(self.first)

        _endPath = _closePath

    try:
        font = TTFont(path, fontNumber=0)
        size = font["head"].unitsPerEm
        glyphs, names = font.getGlyphSet(), font.getBestCmap() or {}
        kerning = font["kern"].kernTables[0].kernTable if "kern" in font else {}
        outlines = []
        at, before, low, high = 0.0, None, complex(0, np.inf), complex(0, -np.inf)
        for letter in text:
            glyph = names.get(ord(letter), ".notdef")
            at += kerning.get((before, glyph), 0)
            pen, bounds = Pen(glyphs), BoundsPen(glyphs)
            glyphs[glyph].draw(pen)
            glyphs[glyph].draw(bounds)
            outlines += [[np.array(curve) @ (1, 1j) + at for curve in outline] for outline in pen.outlines if outline]
            if bounds.bounds:
                x0, y0, x1, y1 = bounds.bounds
                low = complex(min(low.real, at + x0), min(low.imag, y0))
                high = complex(max(high.real, at + x1), max(high.imag, y1))
            at, before = at + glyphs[glyph].width, glyph
        high = complex(max(high.real, at), high.imag)
    except (TTLibError, KeyError, ValueError, AttributeError, AssertionError, OSError) as error:
        raise InputError(f"{name}: {path}: expected a font with outlines, TrueType or OpenType: {error}") from None
    if not outlines or high.imag <= low.imag:
        raise InputError(f"{name}: text: expected letters that can be seen, got {text!r}")
    return Line([[curve / size for curve in outline] for outline in outlines], low / size, high / size)


def _font_file(name: str, font_name: str | os.PathLike[str]) -> str:
    """Where Pillow finds a font."""
    if not isinstance(font_name, str | os.PathLike):
        raise InputTypeError(f"{name}: font_name: expected a path or a name, got {type(font_name).__name__}")
    try:
        return str(ImageFont.truetype(os.fspath(font_name), 16).path)
    except OSError as error:
        raise InputError(f"{name}: font {os.fspath(font_name)!r}: {error}") from None


__all__ = ["measure_text", "text"]
