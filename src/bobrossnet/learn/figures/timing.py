"""Figure 6.1: time of a completion."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.completion.network import load_network
from bobrossnet.learn.figures.figure import Drawing, Sources
from bobrossnet.learn.figures.style import BLUE, COLUMN, GRAY, RED, new_figure
from bobrossnet.picture.order import Size
from bobrossnet.support.machine import processor

SIZES = ((240, 320), (360, 480), (480, 640), (600, 800), (720, 960), (768, 1024), (864, 1152), (960, 1280))
RUNS = 11
FRACTION = 0.1

REPORT_SIZE, REPORT_MS = (480, 640), 80.0
"""The report's upper bound for pictures up to this size on a GeForce GTX 870M."""


def measure(sources: Sources, sizes: tuple[Size, ...] = SIZES, runs: int = RUNS) -> NDArray[np.float64]:
    """Return the milliseconds of `bob.complete`, (sizes, runs).

    The sizes alternate, so that other load on the machine affects all equally.
    """
    model = load_network(sources.weights)
    parts = [bob.trace(sources.scene, sources.camera, size=size, fraction=FRACTION) for size in sizes]
    elapsed_ms = np.empty((len(sizes), runs))
    for run in range(runs):
        for i, part in enumerate(parts):
            bob.complete(part, model=model)  # allocates this size's memory
            start = time.perf_counter()
            bob.complete(part, model=model)
            elapsed_ms[i, run] = 1000 * (time.perf_counter() - start)
    return elapsed_ms


def draw_timing(sources: Sources, sizes: tuple[Size, ...] = SIZES, runs: int = RUNS) -> Drawing:
    """Draw the median time by number of pixels, with the best-fitting line through the origin."""
    elapsed_ms = measure(sources, sizes, runs)
    low, median, high = np.quantile(elapsed_ms, (0.25, 0.5, 0.75), axis=1)
    megapixels = np.prod(sizes, axis=1) / 1e6
    slope = float(median @ megapixels / (megapixels @ megapixels))  # least squares

    figure = new_figure(COLUMN, 2.4)
    axes = figure.subplots()
    axes.grid()
    end = 1.04 * megapixels.max()
    measured = axes.errorbar(megapixels, median, (median - low, high - median), fmt="o", color=BLUE, capsize=2)
    (line,) = axes.plot((0, end), (0, slope * end), color=GRAY, zorder=1)
    (theirs,) = axes.plot(np.prod(REPORT_SIZE) / 1e6, REPORT_MS, "D", color=RED, zorder=3)
    axes.set_xlim(0, max(end, 0.4))
    axes.set_ylim(0, 1.1 * max(REPORT_MS, high.max()))
    axes.set_xlabel("megapixels")
    axes.set_ylabel("milliseconds to complete")
    labels: dict[Any, str] = {
        measured: "measured: medians and quartiles",
        line: f"{slope:.3g} ms a megapixel",
        theirs: "the report, at most (GeForce GTX 870M, WebGL)",
    }
    axes.legend(labels.keys(), labels.values(), loc="lower left", bbox_to_anchor=(0, 1))  # above, outside the data
    shortest, longest = sizes[0], sizes[-1]
    return Drawing(
        figure,
        f"Time to complete a picture of {shortest[1]} x {shortest[0]} to {longest[1]} x {longest[0]} pixels: medians "
        f"and quartiles of {runs} runs, and the best fit through the origin. {processor()}, threads: "
        f"{bob.thread_count()}, instructions: {_core.isa()}. The report gives {REPORT_MS:g} ms or less for "
        f"{REPORT_SIZE[1]} x {REPORT_SIZE[0]}.",
    )
