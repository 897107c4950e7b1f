"""Colours of CAD files, for pictures on a black background.

CAD programs show parts on a light one, where black screws and dark housings are well seen. Here nothing would be left
of them but a highlight.
"""

from __future__ import annotations

from bobrossnet.shapes.material import Color, Material

DARKEST = 0.2
"""The least luminance of a colour, a little below that of pure red."""


def luminance(color: Color) -> float:
    """Rec. 709's, of a linear colour or one as sRGB."""
    red, green, blue = Material(color).color
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def visible(color: Color) -> Material:
    """A material of a colour, to which as much white is added as it needs to be seen."""
    now = luminance(color)
    white = max(0.0, (DARKEST - now) / (1 - now)) if now < 1 else 0.0
    return Material([c + white * (1 - c) for c in Material(color).color])
