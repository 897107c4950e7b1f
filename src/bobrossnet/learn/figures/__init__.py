"""The report's figures, drawn from data in one style, a file each."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence

from bobrossnet.completion.network import load_network
from bobrossnet.learn.checks import check_figures
from bobrossnet.learn.figures.architecture import draw_full, draw_grouped, draw_unet
from bobrossnet.learn.figures.convergence import draw_convergence
from bobrossnet.learn.figures.figure import Draw, Drawing, LeftOutError, Sources
from bobrossnet.learn.figures.losses import draw_losses
from bobrossnet.learn.figures.samples import draw_samples
from bobrossnet.learn.figures.scores import draw_scores
from bobrossnet.learn.figures.stability import draw_stability
from bobrossnet.learn.figures.stages import draw_dense, draw_sparse
from bobrossnet.learn.figures.style import figure_paths, save, style
from bobrossnet.learn.figures.timing import draw_timing
from bobrossnet.support.atomic import write_whole
from bobrossnet.support.errors import InputError
from bobrossnet.support.paths import path_of

FIGURES: dict[str, Draw] = {
    "2.1": draw_convergence,
    "4.1": draw_unet,
    "4.2": draw_full,
    "4.3": draw_grouped,
    "5.1": draw_losses,
    "5.2": draw_samples,
    "6.1": draw_timing,
    "6.2": draw_scores,
    "6.3": draw_sparse,
    "6.4": draw_dense,
    "stability": draw_stability,
}
"""Figures by `FIGURE_NAMES`."""

__all__ = ["FIGURES", "Drawing", "LeftOutError", "Sources", "draw_figures"]


def draw_figures(
    out: str | os.PathLike[str],
    sources: Sources | None = None,
    *,
    only: Sequence[str] | None = None,
    report: Callable[[str], object] = print,
) -> dict[str, str]:
    """Draw figures and write them to a folder as figure-NAME.svg and figure-NAME.png, data as figure-NAME.csv.

    Parameters
    ----------
    out : folder, created if missing
    sources : Sources, optional
        The data of the figures. Figures that need more data are omitted, and reported.
    only : names of `FIGURE_NAMES`, optional
    report : function of one line
        Called with a line about each figure.

    Returns
    -------
    dict
        The captions of the written figures, by name, in the order of `FIGURE_NAMES`.

    Raises
    ------
    InputError
        If a name is unknown, or a file can't be written or read.
    """
    names = check_figures(only)
    sources = Sources() if sources is None else sources
    load_network(sources.weights)  # report mistakes before spending time
    out = path_of(out, "out")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{out}: can't make this folder: {error.strerror}") from error
    paths = {name: out / f"figure-{name}" for name in names}
    for path in paths.values():
        figure_paths(path)
    captions = {}
    for name, path in paths.items():
        try:
            with style():
                drawing = FIGURES[name](sources)
        except LeftOutError as error:
            report(f"figure {name} left out: {error}")
        else:
            save(drawing.figure, path, drawing.caption)
            if drawing.csv:
                write_whole(path.with_name(f"{path.name}.csv"), drawing.csv.encode())
            captions[name] = drawing.caption
            report(f"wrote {path}.svg and .png: {drawing.caption}")
    return captions
