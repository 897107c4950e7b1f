"""Images as shapes in two dimensions, after fogleman/sdf: white is inside."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.sdf.d2 import SDF2
from bobrossnet.sdf.outlines import Outline, Places, fitted_size, region
from bobrossnet.support.errors import InputError, check_integer
from bobrossnet.support.paths import check_file, is_path, path_of

if TYPE_CHECKING:
    from PIL.Image import Image

PIXELS = 2**22
"""Maximum number of pixels, as in fogleman/sdf."""

TOLERANCE = 0.25
"""Tolerance of the outline's simplification, in pixels: with a tenth of it, circles have twice as many corners."""

MOST_CORNERS = 2**18
"""Maximum number of corners before simplification; noisy images exceed it, and their formula would be too large."""

WHITE = 127.5
"""Threshold of gray levels: higher ones are white."""


def measure_image(path_or_array: Any, width: float | None = None, height: float | None = None) -> tuple[float, float]:
    """Return the width and height of the shape that `image` makes of the same arguments, borders included.

    Parameters
    ----------
    As in `image`.

    Returns
    -------
    (width, height) : floats

    Raises
    ------
    InputError
        As `image`.
    """
    return fitted_size("measure_image", _opened("measure_image", path_or_array).size, width, height)


def image(path_or_array: Any, width: float | None = None, height: float | None = None, pixels: int = PIXELS) -> SDF2:
    """Make a shape of the white part of an image, centred on the origin.

    The outline is the level set of half white, interpolated between pixel centres and simplified by at most a quarter
    of a pixel. Distances are distances from this outline.

    Parameters
    ----------
    path_or_array : path, PIL image, or array
        A file that Pillow reads, or an array (h, w) bool, uint8, or float in 0..1, or (h, w, 3 or 4) uint8. Colours are
        converted to luma; alpha is ignored.
    width, height : numbers above 0, optional
        Size of the whole image; if both are given, it is stretched. By default the height is 1.
    pixels : int, 16..2**26
        Larger images are downsampled first.

    Raises
    ------
    InputError
        If the image can't be read, has no white, or has too intricate an outline.

    Examples
    --------
    >>> import numpy as np
    >>> from bobrossnet.sdf import *
    >>> y, x = np.mgrid[-32:32, -32:32] + 0.5
    >>> ball = image(np.clip(20.5 - np.hypot(x, y), 0, 1), height=64)
    >>> ball([(0, 0), (30, 0)]).round().tolist()
    [[-20.0], [10.0]]
    """
    picture = _opened("image", path_or_array)
    wide, high = fitted_size("image", picture.size, width, height)
    factor = (check_integer("image: pixels", pixels, 16, 2**26) / (picture.width * picture.height)) ** 0.5
    if factor < 1:
        picture = picture.resize([max(1, round(side * factor)) for side in picture.size])
    gray = np.asarray(picture, np.float64)
    scale_x, scale_y = wide / gray.shape[1], high / gray.shape[0]
    outlines: list[Outline] = []
    for loop in _contours(gray):
        corners = _simplified(loop)
        if len(corners) > 2:
            x, y = corners.real * scale_x - wide / 2, high / 2 - corners.imag * scale_y
            outlines.append(np.stack([x, y, np.zeros(len(x))], axis=1))
    if not outlines:
        raise InputError("image: expected a picture with white in it, got none")
    return region(outlines, "image")


def _opened(name: str, thing: Any) -> Image:
    """Open an image as gray levels: of mode L, or F in 0..255."""
    from PIL import Image  # imported only when needed

    if isinstance(thing, Image.Image):
        return thing.convert("L")
    if is_path(thing):
        thing = path_of(thing, f"{name}: path_or_array")
        try:
            check_file(thing)
            with Image.open(thing) as picture:
                return picture.convert("L")
        except (OSError, ValueError, Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
            raise InputError(f"{name}: {thing}: expected a picture: {error}") from None
    try:
        array = np.asarray(thing)
    except ValueError:  # rows of unequal lengths
        array = np.asarray(None)
    colored = array.ndim == 3 and array.shape[2] in (3, 4) and array.dtype == np.uint8
    gray = array.ndim == 2 and (array.dtype in (np.bool_, np.uint8) or array.dtype.kind == "f")
    if not (colored or gray) or not array.size:
        expected = "(h, w) bool, uint8 or float, or (h, w, 3 or 4) uint8"
        raise InputError(f"{name}: path_or_array: expected an array {expected}, got {array.shape} {array.dtype}")
    if array.dtype.kind == "f":
        return Image.fromarray(255 * np.clip(np.nan_to_num(array), 0, 1).astype(np.float32))
    return Image.fromarray(array).convert("L")


# Marching squares on a square of four pixels: a bit for each white corner, clockwise from the top left. The outline
# runs between sides, numbered clockwise from the top, with white to its left. If white meets white only across a
# diagonal, the mean of the four pixels decides.
APART = {
    0b0001: [(3, 0)], 0b0010: [(0, 1)], 0b0100: [(1, 2)], 0b1000: [(2, 3)],
    0b0011: [(3, 1)], 0b0110: [(0, 2)], 0b1100: [(1, 3)], 0b1001: [(2, 0)],
    0b1110: [(0, 3)], 0b1101: [(1, 0)], 0b1011: [(2, 1)], 0b0111: [(3, 2)],
    0b0101: [(3, 0), (1, 2)], 0b1010: [(0, 1), (2, 3)],
}  # fmt: skip
JOINED = {0b0101: [(1, 0), (3, 2)], 0b1010: [(0, 3), (2, 1)]}


def _contours(gray: NDArray[np.float64]) -> Iterator[Places]:
    """Yield closed outlines around white by marching squares, in pixels, x right and y down from the top left.

    White regions that reach the image's border are closed along it.
    """
    around = np.pad(gray, 1, mode="edge")
    framed = np.minimum(around, 2 * WHITE - around)
    framed[1:-1, 1:-1] = gray
    height, width = framed.shape
    corners = [framed[:-1, :-1], framed[:-1, 1:], framed[1:, 1:], framed[1:, :-1]]
    code = np.sum([(corner > WHITE) << bit for bit, corner in enumerate(corners)], axis=0)
    joined = np.sum(corners, axis=0) > 4 * WHITE
    # Sides of squares by number: along rows first, then along columns.
    square = np.arange(height * width).reshape(height, width)[:-1, :-1]
    sides = [square, height * width + square + 1, square + width, height * width + square]
    onward = np.full(2 * height * width, -1)
    for table, chosen in ((APART, ~joined | ~np.isin(code, list(JOINED))), (JOINED, joined)):
        for case, ways in table.items():
            rows, columns = np.nonzero((code == case) & chosen)
            for start, end in ways:
                onward[sides[start][rows, columns]] = sides[end][rows, columns]
    starts = np.flatnonzero(onward >= 0)
    if len(starts) > MOST_CORNERS:
        raise InputError(
            f"image: expected an outline of at most {MOST_CORNERS} corners, got {len(starts)}; give fewer pixels="
        )

    # Interpolated position of half white on each side; pixel centres are at halves.
    along_column, place = np.divmod(starts, height * width)
    row, column = np.divmod(place, width)
    here, there = framed[row, column], framed[row + along_column, column + 1 - along_column]
    share = (WHITE - here) / (there - here)
    places = np.where(along_column, column - 0.5 + 1j * (row - 0.5 + share), column - 0.5 + share + 1j * (row - 0.5))

    number = np.full(onward.shape, -1)
    number[starts] = np.arange(len(starts))
    following = number[onward[starts]].tolist()
    seen = bytearray(len(starts))
    for first in range(len(starts)):
        loop = []
        at = first
        while not seen[at]:
            seen[at] = 1
            loop.append(at)
            at = following[at]
        if loop:
            yield places[loop]


def _simplified(loop: Places) -> Places:
    """Simplify a closed outline by Douglas-Peucker, between two distant corners."""
    far = int(np.abs(loop - loop[0]).argmax())
    closed = np.append(loop, loop[0])
    kept = {0, far}
    open_ranges = [(0, far), (far, len(loop))]
    while open_ranges:
        first, last = open_ranges.pop()
        if last - first < 2:
            continue
        chord = closed[last] - closed[first]
        off = closed[first + 1 : last] - closed[first]
        if chord:
            run = np.clip((off * chord.conjugate()).real / abs(chord) ** 2, 0, 1)
            off = off - run * chord
        middle = first + 1 + int(np.abs(off).argmax())
        if abs(off[middle - first - 1]) > TOLERANCE:
            kept.add(middle)
            open_ranges += [(first, middle), (middle, last)]
    return loop[sorted(kept)]


__all__ = ["image", "measure_image"]
