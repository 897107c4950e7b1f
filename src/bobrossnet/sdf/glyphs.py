"""Outlines of a line of text as the font's Bézier curves, by fontTools: the extra `text`."""

# ruff: noqa: N802, N815  # the pen's methods have fontTools' names

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from fontTools.pens.basePen import BasePen
from fontTools.pens.boundsPen import BoundsPen
from fontTools.ttLib import TTFont, TTLibError

from bobrossnet.sdf.outlines import Places
from bobrossnet.support.errors import InputError


@dataclass(frozen=True)
class Line:
    """A line of text in units of the font size: the Bézier curves of each outline, and their box.

    The box spans the advance widths of all letters, extended to their outlines.
    """

    outlines: list[list[Places]]
    low: complex
    high: complex

    @property
    def size(self) -> tuple[float, float]:
        across = self.high - self.low
        return across.real, across.imag


class Pen(BasePen):  # type: ignore[misc]
    """A pen that records the curves of outlines, and closes them."""

    def __init__(self, glyphs: Any) -> None:
        super().__init__(glyphs)
        self.outlines: list[list[list[Any]]] = []

    def _moveTo(self, point: Any) -> None:
        self.outlines.append([])
        self.first = point

    def _lineTo(self, point: Any) -> None:
        if point != self._getCurrentPoint():
            self._curveToOne(point)

    def _curveToOne(self, *points: Any) -> None:
        self.outlines[-1].append([self._getCurrentPoint(), *points])

    def _closePath(self) -> None:
        self._lineTo(self.first)

    _qCurveToOne = _curveToOne
    _endPath = _closePath


def line(name: str, path: str, text: str) -> Line:
    """Lay out text in the font of a file, by advance widths and the `kern` table. `name` begins error messages.

    Raises
    ------
    InputError
        If the font can't be read, or no part of the text is visible.
    """
    outlines: list[list[Any]] = []
    at, before, low, high = 0.0, "", complex(0, np.inf), complex(0, -np.inf)
    try:
        with TTFont(path, fontNumber=0) as font:
            size = font["head"].unitsPerEm
            glyphs, names = font.getGlyphSet(), font.getBestCmap() or {}
            tables = font["kern"].kernTables if "kern" in font else []
            kerning = {pair: by for table in tables for pair, by in getattr(table, "kernTable", {}).items()}
            for letter in text:
                glyph = names.get(ord(letter), ".notdef")
                at += kerning.get((before, glyph), 0)
                pen, bounds = Pen(glyphs), BoundsPen(glyphs)
                glyphs[glyph].draw(pen)
                glyphs[glyph].draw(bounds)
                outlines += [[np.array(curve) @ (1, 1j) + at for curve in each] for each in pen.outlines if each]
                if bounds.bounds:
                    x0, y0, x1, y1 = bounds.bounds
                    low = complex(min(low.real, at + x0), min(low.imag, y0))
                    high = complex(max(high.real, at + x1), max(high.imag, y1))
                at, before = at + glyphs[glyph].width, glyph
    except Exception as error:  # damaged fonts raise many types
        reason = " ".join(str(error).split()) if isinstance(error, TTLibError) else type(error).__name__
        raise InputError(f"{name}: {path}: expected a font with outlines, TrueType or OpenType: {reason}") from error
    high = complex(max(high.real, at), high.imag)
    if high.imag <= low.imag:
        raise InputError(f"{name}: text: expected letters that can be seen, got {text!r}")
    return Line([[curve / size for curve in outline] for outline in outlines], low / size, high / size)
