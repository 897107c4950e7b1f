"""Figure 6.2: mean SSIM by share of traced pixels, compared with the report's and with interpolation."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path

from matplotlib.transforms import Bbox

from bobrossnet.learn import reference
from bobrossnet.learn.evaluation import methods
from bobrossnet.learn.evaluation.scores import Evaluation
from bobrossnet.learn.figures.figure import Drawing, LeftOutError, Sources
from bobrossnet.learn.figures.style import BLUE, GRAY, GREEN, ORANGE, PAGE, PURPLE, RED, SKY, new_figure
from bobrossnet.support.errors import InputError

Means = Mapping[str, Mapping[float, float]]
"""Mean SSIM by method and share of traced pixels."""

FILLINGS = {"delaunay-linear": ORANGE, "pull-push": GREEN, "nearest": PURPLE, "telea": GRAY}
DENSE = 0.25  # start of the right panel's closer view


def draw_scores(sources: Sources) -> Drawing:
    """Draw an evaluation's means."""
    if sources.scores is None:
        raise LeftOutError("it needs an evaluation's scores (--scores FILE.csv)")
    return show_scores(read_means(sources.scores))


def read_means(path: str | os.PathLike[str]) -> dict[str, dict[float, float]]:
    """Read an evaluation's CSV file and return the mean SSIM by method and share of traced pixels, for its first order.

    Raises
    ------
    InputError
        If the file can't be read or has other contents.
    """
    try:
        text = Path(path).read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: can't read it: {error}") from error
    try:
        result = Evaluation.from_csv(text)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    methods = [method for method, order in result.scores if order == result.orders[0]]
    return {method: dict(zip(result.fractions, result.mean(method).tolist(), strict=True)) for method in methods}


def show_scores(means: Means) -> Drawing:
    """Draw means by share of traced pixels, in full and enlarged at the dense end, above the report's table.

    Parameters
    ----------
    means : by method, including one ending in " raw" and one in " kept"; thin lines are drawn for `FILLINGS`

    Raises
    ------
    InputError
        If a method is missing.
    """
    raw, kept = (_method(means, of) for of in (methods.raw, methods.kept))
    lines = [("the report", reference.SSIM, RED, "D:"), (raw, means[raw], SKY, "s-"), (kept, means[kept], BLUE, "o-")]
    figure = new_figure(PAGE, 3.1)
    panels = figure.subplot_mosaic([["all", "dense"], ["table", "table"]], height_ratios=[3.2, 1])
    for name, color in FILLINGS.items():
        if name in means:
            lines.append((name, means[name], color, "-"))
    for panel, least in (("all", 0.0), ("dense", DENSE)):
        axes = panels[panel]
        shown = []
        for name, line, color, marks in lines:
            points = sorted((100 * fraction, mean) for fraction, mean in line.items() if fraction >= least)
            thin = name in FILLINGS
            axes.plot(*zip(*points, strict=True), marks, color=color, lw=0.7 if thin else 1.2, label=name)
            shown += [] if thin else points
        axes.set(xscale="log", xlabel="pixels traced, %", ylabel="mean SSIM")
        ticks = sorted({fraction for fraction, _ in shown})
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.set_xticks([], minor=True)
        axes.grid()
    lowest = min(mean for _, line, _, marks in lines[:3] for fraction, mean in line.items() if fraction >= DENSE)
    panels["dense"].set_ylim(max(lowest - 0.1 * (1 - lowest), 0), 1 + 0.1 * (1 - lowest))
    panels["all"].legend(loc="lower right", ncols=2)

    stages = list(reference.SSIM)
    panels["table"].set_axis_off()
    table = panels["table"].table(
        [[f"{line[stage]:.4f}" if stage in line else "–" for stage in stages] for _, line, *_ in lines[:3]],
        rowLabels=[name for name, *_ in lines[:3]],
        colLabels=[f"{100 * stage:g} %" for stage in stages],
        bbox=Bbox.from_bounds(0.12, 0, 0.88, 1),
        cellLoc="center",
        edges="horizontal",
    )
    table.auto_set_font_size(False)
    table.set_fontsize(6.5)
    for cell in table.get_celld().values():
        cell.set_linewidth(0.4)
    return Drawing(
        figure,
        f"Mean SSIM by the share of traced pixels. {raw}: the network's output, as in the report. {kept}: with traced "
        "pixels kept, as in the fillings (thin lines). Right: the same from "
        f"{100 * DENSE:g} % on. The report used other shapes.",
        "\n".join(
            ["method,fraction,ssim"]
            + [f"{name},{fraction:g},{mean:.6f}" for name, line, *_ in lines for fraction, mean in line.items()]
            + [""]
        ),
    )


def _method(means: Means, of: Callable[[str], str]) -> str:
    for name in means:
        if name.endswith(of("")):
            return name
    raise InputError(f"scores: expected a method {of('NAME')}, got {', '.join(means) or 'none'}")
