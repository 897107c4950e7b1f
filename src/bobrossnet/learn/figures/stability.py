"""Temporal stability: the share of flicker in the frame-to-frame change of a converging picture."""

from __future__ import annotations

from functools import partial

import numpy as np

from bobrossnet.learn.evaluation.methods import repaints
from bobrossnet.learn.evaluation.scenes import FIRST, Scenes
from bobrossnet.learn.evaluation.stability import LEVELS, ORBIT_STEP, Stability, measure_stability
from bobrossnet.learn.figures.figure import Drawing, Sources
from bobrossnet.learn.figures.scores import FILLINGS as FILLING_COLORS
from bobrossnet.learn.figures.style import BLUE, PAGE, SKY, new_figure
from bobrossnet.learn.shapes import procedural_scene

SHAPES = (FIRST + 2, FIRST + 6, FIRST + 13)  # procedural scenes


def draw_stability(sources: Sources) -> Drawing:
    """Measure and draw the flicker of converging pictures by share of traced pixels, and of orbits."""
    scenes: Scenes = {
        "the scene": lambda: sources.scene,
        **{f"made {number}": partial(procedural_scene, number) for number in SHAPES},
    }
    return show_stability(measure_stability(scenes, [sources.weights], frames=sources.frames, seed=sources.seed))


def show_stability(stability: Stability) -> Drawing:
    """Draw the results for the first order."""
    figure = new_figure(PAGE, 2.4)
    converging, totals, orbit = figure.subplots(1, 3, width_ratios=[2.2, 1, 1.2])
    names = [method for method, order in stability.frames if order == stability.orders[0]]
    colors = [FILLING_COLORS.get(name, SKY if repaints(name) else BLUE) for name in names]
    for name, color in zip(names, colors, strict=True):
        flicker = LEVELS * stability.mean(name)[1:, 1]
        flicker[flicker < 1e-6] = np.nan  # zero up to rounding: a logarithm can't show it
        converging.plot(100 * stability.fractions[1:], flicker, color=color, label=name)
    converging.set(xlabel="pixels traced, %", ylabel="flicker per frame, gray levels of 255", yscale="log")
    converging.set_title(
        f"converging picture, {len(stability.fractions)} frames, mean of {len(stability.shapes)} views"
    )
    converging.yaxis.set_major_formatter("{x:g}")
    converging.grid(axis="y")
    converging.legend()

    places = np.arange(len(names))
    shares = [100 * flicker / change for flicker, change in map(stability.total, names)]
    bars = totals.barh(places, shares, color=colors)
    totals.bar_label(bars, [f"{share:.0f} %" for share in shares], padding=2, fontsize=6.5)
    totals.set(xlabel="share of all change, %", xlim=(0, 1.25 * max(*shares, 1)), title="flicker of all frames")
    totals.set_yticks(places, names)
    totals.invert_yaxis()

    columns = np.arange(len(stability.orbit_fractions))
    width = 0.8 / len(names)
    for i, (name, color) in enumerate(zip(names, colors, strict=True)):
        flickers = LEVELS * stability.orbit[name, stability.orders[0]].mean(0)
        orbit.bar(columns + (i - (len(names) - 1) / 2) * width, flickers, width, color=color)
    orbit.set_xticks(columns, [f"{100 * fraction:g}" for fraction in stability.orbit_fractions])
    orbit.set(xlabel="pixels traced, %", ylabel="flicker per frame, gray levels of 255")
    orbit.set_title(f"orbit, {ORBIT_STEP:g}° a frame")
    orbit.grid(axis="y")
    return Drawing(
        figure,
        f"Temporal stability, means of {len(stability.shapes)} views. Left: flicker of a converging picture, from "
        f"{100 * stability.fractions[0]:g} % of the pixels to all in {len(stability.fractions)} frames. It is the "
        "change that is no progress towards the reference r: mean |x - x'| - (mean |x' - r| - mean |x - r|). "
        "Middle: the sum over the frames as a share of all change. Right: flicker on an orbit, where each frame traces "
        "other pixels: mean |(x - x') - (r - r')|.",
        stability.csv(),
    )
