"""The style of figures: sizes and colours for a two-column paper, and deterministic files."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bobrossnet.picture.files import to_8_bit
from bobrossnet.picture.order import Size
from bobrossnet.support.atomic import check_writable, write_whole

COLUMN = 3.5  # inches, width of one column
PAGE = 7.16  # inches, width of both columns and their gap
DPI = 300  # of PNG files, and of pictures within SVG files
ENDINGS = (".svg", ".png")

BLUE, ORANGE, GREEN, PURPLE, SKY, RED, YELLOW, BLACK = PALETTE = (
    "#0072b2",
    "#e69f00",
    "#009e73",
    "#cc79a7",
    "#56b4e9",
    "#d55e00",
    "#f0e442",
    "#000000",
)
"""Okabe and Ito's palette, distinguishable with colour vision deficiencies (*Color Universal Design*, 2008)."""

GRAY = "#666666"  # for secondary content

_STYLE: Any = {
    # matplotlib's default font, always installed, so that figures are the same everywhere.
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans", "Verdana", "sans-serif"],
    "font.size": 7,
    "axes.titlesize": 7,
    "axes.labelsize": 7,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
    "legend.fontsize": 6.5,
    "legend.frameon": False,
    "axes.prop_cycle": cycler(color=PALETTE),
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "axes.axisbelow": True,
    "grid.linewidth": 0.4,
    "grid.color": "#dddddd",
    "lines.linewidth": 1.2,
    "lines.markersize": 3.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "figure.dpi": DPI,
    "savefig.dpi": DPI,
    "figure.facecolor": "white",
    "svg.fonttype": "none",  # keeps text as text
    "svg.hashsalt": "bobrossnet",  # deterministic names within the file
}


@contextmanager
def style() -> Iterator[None]:
    """Apply the figure style within the block; matplotlib's settings are restored afterwards."""
    with matplotlib.rc_context(_STYLE):
        yield


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure, with a size in inches and automatic layout."""
    return Figure(figsize=(width, height), layout="constrained")


def picture_grid(
    rows: int, columns: int, size: Size, *, above: float = 0.16, between: float = 0.21, left: float = 0.0
) -> tuple[Figure, NDArray[np.object_]]:
    """Return a figure of axes for pictures, at most as wide as a page, and the axes, (rows, columns).

    Each pixel of a picture covers a square of the same integer number of the PNG file's pixels, as large as fits;
    larger pictures are downscaled.

    Parameters
    ----------
    rows, columns : numbers of rows and columns
    size : (height, width) of the pictures, in pixels
    above, between : inches above the first row, and between rows
        0.16 leaves room for one line of title; 0.05 equals the gap between columns.
    left : inches left of the first column
    """
    height, width = size
    gap = 0.05  # inches between pictures
    room = (PAGE - left + gap) / columns - gap  # inches for a picture
    scale = max(int(room * DPI) // width, 1) / DPI if width <= room * DPI else room / width  # inches a pixel
    x = [round((left + i * gap) * DPI) / DPI + i * width * scale for i in range(columns)]
    y = [round(between * i * DPI) / DPI + i * height * scale for i in range(rows)]  # from the bottom
    figure_width, figure_height = x[-1] + width * scale, y[-1] + height * scale + above
    figure = Figure(figsize=(figure_width, figure_height))
    axes = np.empty((rows, columns), object)
    for row, column in np.ndindex(rows, columns):
        axes[row, column] = figure.add_axes(
            (
                x[column] / figure_width,
                y[rows - 1 - row] / figure_height,
                width * scale / figure_width,
                height * scale / figure_height,
            )
        )
    return figure, axes


def show_picture(axes: Axes, picture: NDArray[Any], title: str = "") -> None:
    """Show a picture with unfiltered pixels, without axes.

    Parameters
    ----------
    axes : Axes
    picture : (H, W) float32 gray in 0..1, or (H, W, 3) uint8
    title : a line above it
    """
    shown = picture if picture.ndim == 3 else np.repeat(to_8_bit(picture)[..., None], 3, -1)
    axes.imshow(shown, interpolation="none")
    axes.set_axis_off()
    if title:
        axes.set_title(title, pad=3)


def figure_paths(path: str | os.PathLike[str]) -> list[Path]:
    """Return the files of a figure for a path without an ending; all of them can be written.

    Raises
    ------
    InputError
        If a file can't be written.
    """
    return [check_writable(f"{os.fspath(path)}{ending}") for ending in ENDINGS]


def save(figure: Figure, path: str | os.PathLike[str], description: str = "") -> None:
    """Write a figure as PATH.svg and PATH.png; a failed write leaves no file.

    Parameters
    ----------
    figure : drawn within `style()`
    path : without an ending
    description : the figure's caption, kept in both files

    Raises
    ------
    InputError
        If a file can't be written.
    """
    paths = figure_paths(path)
    contents = []
    with style():
        for file in paths:
            content = io.BytesIO()
            # No date or version, so that files of the same figure are equal.
            metadata = {"Date": None, "Creator": None} if file.suffix == ".svg" else {"Software": None}
            figure.savefig(content, format=file.suffix[1:], metadata={**metadata, "Description": description or None})
            contents.append(content.getvalue())
    for file, data in zip(paths, contents, strict=True):
        write_whole(file, data)
