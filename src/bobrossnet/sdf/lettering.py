"""Text as shapes in two dimensions, after fogleman/sdf, from the font's exact outlines."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np

from bobrossnet.sdf.d2 import SDF2
from bobrossnet.sdf.outlines import Places, arcs_along, fitted_size, region
from bobrossnet.support.errors import InputError, InputTypeError
from bobrossnet.support.paths import check_file, is_path, path_of

if TYPE_CHECKING:
    from bobrossnet.sdf.glyphs import Line

TOLERANCE = 3e-5
"""Maximum distance of outlines from the font's curves, as a share of the font size."""


def measure_text(
    font_name: str | os.PathLike[str], text: str, width: float | None = None, height: float | None = None
) -> tuple[float, float]:
    """Return the width and height of the shape that `text` makes of the same arguments.

    Parameters
    ----------
    As in `text`.

    Returns
    -------
    (width, height) : floats
        Width: the advance widths of all letters, spaces included, extended to their outlines. Height: from the lowest
        to the highest point of the letters.

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
    """Make a line of text, centred on the origin.

    Its outline follows the font's curves by arcs, to 3e-5 of the font size; letters are about 0.7 of that size high.
    Distances are distances from this outline. Letters are set by advance widths and the font's `kern` table, without
    ligatures or the shaping of scripts that join or reorder letters.

    Parameters
    ----------
    font_name : str or path
        A TrueType or OpenType file, or a name under which Pillow finds one, such as ``"DejaVuSans.ttf"``.
    text : str
        One line. Missing letters are drawn as the font's box for them.
    width, height : numbers above 0, optional
        Size of the box of `measure_text`; if both are given, letters are stretched. By default the height is 1.
    pixels, points
        Accepted for fogleman/sdf, and ignored.

    Raises
    ------
    InputError
        If the font can't be read, the text is invisible or too long for one formula, or fontTools is missing.

    Examples
    --------
    A sign that fits its text, for any font on this machine::

        width, height = measure_text(font, "Hello")
        f = rounded_box((width + 1, height + 1, 0.2), 0.1) - text(font, "Hello").extrude(0.1).translate(0.1 * Z)
    """
    line = _line("text", font_name, text)
    wide, high = fitted_size("text", line.size, width, height)
    scale_x, scale_y = wide / line.size[0], high / line.size[1]
    middle = (line.low + line.high) / 2

    def placed(curve: Places) -> Places:
        from_middle = curve - middle
        return from_middle.real * scale_x + 1j * from_middle.imag * scale_y

    def arcs(curve: Places) -> Any:
        return arcs_along(placed(curve), TOLERANCE * min(scale_x, scale_y), max(scale_x, scale_y))

    return region([np.concatenate([arcs(curve) for curve in outline]) for outline in line.outlines], "text")


def _line(name: str, font_name: str | os.PathLike[str], text: str) -> Line:
    """Lay out the text in a font that Pillow finds; `name` begins error messages."""
    try:
        from bobrossnet.sdf.glyphs import line
    except ModuleNotFoundError:
        raise InputError(f"{name}: this needs fontTools: pip install 'bobrossnet[text]'") from None
    if not is_path(font_name):
        raise InputTypeError(f"{name}: font_name: expected a path or a name, got {type(font_name).__name__}")
    font = path_of(font_name, f"{name}: font_name")
    if not isinstance(text, str):
        raise InputTypeError(f"{name}: text: expected a string, got {type(text).__name__}")
    if not text.isprintable():
        raise InputError(f"{name}: text: expected one line of letters, got {text!r}; make each line a shape of its own")
    from PIL import ImageFont  # imported only when needed

    try:
        if os.path.exists(font):  # otherwise a name for Pillow to find
            check_file(font)
        path = str(ImageFont.truetype(str(font), 16).path)
    except (OSError, ValueError) as error:
        raise InputError(f"{name}: font {str(font)!r:.100}: {error}") from None
    return line(name, path, text)


__all__ = ["measure_text", "text"]
