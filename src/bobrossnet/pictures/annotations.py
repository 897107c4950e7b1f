"""Words and lines on sheets: labels, dimensions, a scale bar, cutting lines and the names of parts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import floor, hypot, log10
from typing import Any

INK, GRAY, RED, PAPER = (20, 24, 32), (110, 118, 130), (176, 32, 32), (255, 255, 255)

MAX_NAME = 24
"""Characters of a part's name."""

DASHES = (1.0, 0.25, 0.25, 0.25)
"""Dash, gap, dot and gap of cutting lines, in heights of a line."""

Color = tuple[int, int, int]
Place = tuple[float, float]
"""x and y, in pixels from the page's top left."""


def lengths(sides: Iterable[float], unit: str) -> str:
    """Lengths as people read them, such as "4 x 2 x 1 mm"."""
    return " x ".join(map(_number, sides)) + (f" {unit}" if unit else "")


def _number(value: float) -> str:
    """Four digits, and all of those before the point where these are up to seven."""
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value:.4g}"


def font(line: int) -> Any:
    """Pillow's font for lines of a height in pixels."""
    from PIL import ImageFont

    return ImageFont.load_default(round(0.8 * line))


class Annotations:
    """Draws words and lines on a page.

    Parameters
    ----------
    draw : ImageDraw of Pillow
    line : int
        Height of a line of text in pixels.
    unit : str
        Follows lengths.
    """

    def __init__(self, draw: Any, line: int, unit: str) -> None:
        self._draw, self._line, self._unit, self._font = draw, line, unit, font(line)

    def label(self, place: Place, text: str, color: Color, anchor: str) -> None:
        """Text with a white border, which keeps it legible over lines; the anchor is Pillow's."""
        self._draw.text(place, text, color, font=self._font, anchor=anchor, stroke_width=2, stroke_fill=PAPER)

    def title(self, place: Place, title: str, facts: list[str], width: float) -> None:
        """The title and facts in one line, with the title cut off if the line is wider than `width`."""
        words = "   ".join([title, *facts])
        while self._draw.textlength(words, font=self._font) > width and len(title) > 4:
            title = f"{title[:-4]}..."
            words = "   ".join([title, *facts])
        self.label(place, words, INK, "lm")

    def dimensions(self, middle: Place, wide: float, high: float, pixels: float) -> None:
        """A dimension line below a view and one to its left; lengths in units of `pixels` each."""
        line, draw = self._line, self._draw
        left, right = middle[0] - wide * pixels / 2, middle[0] + wide * pixels / 2
        top, bottom = middle[1] - high * pixels / 2, middle[1] + high * pixels / 2
        y, x, tick = bottom + 1.2 * line, left - 1.2 * line, 0.3 * line
        draw.line([(left, y), (right, y)], GRAY)
        for end in (left, right):
            draw.line([(end, bottom + 0.4 * line), (end, y + tick)], GRAY)
        draw.line([(x, top), (x, bottom)], GRAY)
        for end in (top, bottom):
            draw.line([(left - 0.4 * line, end), (x - tick, end)], GRAY)
        self.label((middle[0], y + 0.3 * line), lengths([wide], self._unit), INK, "mt")
        self.label((x - 0.4 * line, middle[1]), lengths([high], self._unit), INK, "rm")

    def scale_bar(self, right: float, y: float, pixels: float) -> None:
        """The longest of 1, 2 or 5 times a power of ten units that is at most six lines wide."""
        line, draw = self._line, self._draw
        longest = 6 * line / pixels
        power = 10.0 ** floor(log10(longest))
        length = max(times * power for times in (1, 2, 5) if times * power <= longest)
        left = right - length * pixels
        draw.line([(left, y), (right, y)], INK, width=max(2, line // 8))
        for end in (left, right):
            draw.line([(end, y - 0.25 * line), (end, y + 0.25 * line)], INK, width=max(2, line // 8))
        self.label(((left + right) / 2, y - 0.3 * line), lengths([length], self._unit), INK, "mb")

    def cutting_line(self, start: Place, end: Place, text: str) -> None:
        """A dash-dot line where a section cuts, a little longer than the view, with its name at the upper end."""
        line = self._line
        length = max(hypot(end[0] - start[0], end[1] - start[1]), 1e-9)
        along = (end[0] - start[0]) / length, (end[1] - start[1]) / length
        at, step = -0.6 * line, 0
        while at < length + 0.6 * line:
            stop = min(at + DASHES[step % 4] * line, length + 0.6 * line)
            if step % 2 == 0:
                ends = [(start[0] + t * along[0], start[1] + t * along[1]) for t in (at, stop)]
                self._draw.line(ends, RED)
            at, step = stop, step + 1
        beyond = length + 0.8 * line
        place = start[0] + beyond * along[0], start[1] + beyond * along[1]
        self.label(place, text, RED, "mb" if abs(along[1]) > abs(along[0]) else "lm")

    def names(self, places: Mapping[str, Place], right: float, top: float, height: float) -> None:
        """Names in a column that ends at `right`, each with a leader to its place."""
        line, draw = self._line, self._draw
        labels = []
        for i, (name, at) in enumerate(sorted(places.items(), key=lambda item: item[1][::-1])):
            y = top + (i + 0.5) * min(height / len(places), 2 * line)
            text = name if len(name) <= MAX_NAME else f"{name[: MAX_NAME - 3]}..."
            start = right - draw.textlength(text, font=self._font) - 0.3 * line
            draw.line([(start, y), at], GRAY)
            draw.ellipse([(at[0] - 2, at[1] - 2), (at[0] + 2, at[1] + 2)], INK)
            labels.append(((right, y), text))
        for place, text in labels:
            self.label(place, text, INK, "rm")
