"""Text as shapes in two dimensions, after fogleman/sdf: the outlines of a font's letters themselves."""

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
"""How far outlines are from the font's curves at most, in the font's size."""


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
        Across from where the first letter begins to where another would follow, spaces included, or as far as letters
        reach beyond; from the lowest to the highest point of the letters.

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
    curves. Distances are those from this outline. Letters follow one another by their widths and the font's `kern`
    table; there are no ligatures, and scripts that join or reorder letters are not shaped.

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
        If the font can't be read, the text has nothing to be seen or too much for one formula, or fontTools is missing.

    Examples
    --------
    A sign as large as its text, for a name of a font that this machine has::

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
    """The text in a font that Pillow finds; `name` begins messages."""
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
    from PIL import ImageFont  # which imports wait for, text or not

    try:
        if os.path.exists(font):  # else a name that Pillow knows
            check_file(font)
        path = str(ImageFont.truetype(str(font), 16).path)
    except (OSError, ValueError) as error:
        raise InputError(f"{name}: font {str(font)!r:.100}: {error}") from None
    return line(name, path, text)


__all__ = ["measure_text", "text"]
