"""Temporal stability: how much of the change from frame to frame of a converging picture is flicker.

A picture that converges changes; to the eye it is stable where it only ever changes towards the truth. For consecutive
frames x' and x of a view whose truth r does not change,

    change  = mean |x - x'|
    gain    = mean |x' - r| - mean |x - r|
    flicker = change - gain

over the pixels. By the triangle inequality no pixel's flicker is below 0, and it is 0 where the pixel moves towards the
truth without passing it: a picture that converges monotonically, pixel by pixel, has none. Twice the way that pixels
go wrong is flicker, since it has to be gone back. Summed over the frames, flicker is the length of the pixels' way
beyond the shortest.

On an orbit the truth moves too, and what is not the truth's own change is

    flicker = mean |(x - x') - (r - r')|
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.complete.filling import delaunay_linear, nearest, pull_push
from bobrossnet.complete.model import ModelLike, load_model
from bobrossnet.errors import InputError, check_array, check_integer
from bobrossnet.learn.figures.figure import Drawing, Sources
from bobrossnet.learn.figures.style import BLUE, GREEN, ORANGE, PAGE, PURPLE, SKY, new_figure
from bobrossnet.learn.shapes import procedural_scene
from bobrossnet.progress import progress
from bobrossnet.shapes.scene import SceneLike

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
Method = Callable[[bob.GBuffer], F32]

FIRST_FRACTION = 0.01  # of the pixels, traced in the first frame; the others add as many each, up to all
SIZE = (128, 128)  # Delaunay-linear takes nearly all of the time, about 0.3 s a picture; the network 2 ms
SHAPES = (4_000_000_002, 4_000_000_006, 4_000_000_013)  # procedural scenes, of no data set of a seed below 4,000
MEASURES = ("change", "flicker", "error")

ORBIT_FRACTIONS = (0.05, 0.25)
ORBIT_FRAMES = 8
ORBIT_STEP = 2.0  # degrees of azimuth between frames

COLORS = {"network": BLUE, "network, raw": SKY, "delaunay-linear": ORANGE, "pull-push": GREEN, "nearest": PURPLE}


@dataclass(frozen=True)
class Stability:
    """What `measure_stability` found, means over the views. Grays are in 0..1.

    Attributes
    ----------
    views : how many
    fractions : (F,) float64, shares of the pixels traced in the frames
    frames : by method: (F, 3) float64, change, flicker and error of each frame
        The error is mean |x - r|. The first frame has no change and no flicker: NaN.
    orbit_fractions : shares of the pixels traced in the frames of the orbits
    orbit : by method: as many numbers, the mean flicker
    """

    views: int
    fractions: F64
    frames: Mapping[str, F64] = field(repr=False)
    orbit_fractions: tuple[float, ...]
    orbit: Mapping[str, F64]

    def total(self, method: str) -> tuple[float, float]:
        """Return a method's flicker and change, each summed over the frames."""
        change, flicker, _ = np.nansum(self.frames[method], 0).tolist()
        return flicker, change

    def csv(self) -> str:
        """Return all numbers as CSV: a line for each method and frame, then one for each method's orbits."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["sequence", "method", "fraction", *MEASURES])
        for method, frames in self.frames.items():
            for fraction, values in zip(self.fractions, frames, strict=True):
                cells = ["" if np.isnan(value) else f"{value:.7f}" for value in values]
                writer.writerow(["converging", method, f"{fraction:.6f}", *cells])
        for method, flickers in self.orbit.items():
            for fraction, flicker in zip(self.orbit_fractions, flickers, strict=True):
                writer.writerow(["orbit", method, f"{fraction:.6f}", "", f"{flicker:.7f}", ""])
        return text.getvalue()


def change_and_flicker(frames: Any, reference: Any) -> F64:
    """Return change, flicker and error of a sequence of pictures whose truth stays; the formulas are at the top.

    Parameters
    ----------
    frames : (F, H, W) numbers
    reference : (H, W) numbers, the truth

    Returns
    -------
    (F, 3) float64
        Of the first frame only the error, its change and flicker are NaN.

    Raises
    ------
    InputError
        If the shapes don't fit.

    Examples
    --------
    >>> frames = np.array([0.0, 0.5, 0.25, 1.0]).reshape(4, 1, 1)
    >>> change_and_flicker(frames, np.ones((1, 1)))[1:, 1].tolist()  # a step of 0.25 back, which it has to go again
    [0.0, 0.5, 0.0]
    """
    reference = check_array("reference", reference, (None, None)).astype(np.float64)
    frames = check_array("frames", frames, (None, *reference.shape)).astype(np.float64)
    measured = np.full((len(frames), len(MEASURES)), np.nan)
    measured[:, 2] = np.abs(frames - reference).mean((1, 2))
    measured[1:, 0] = np.abs(np.diff(frames, axis=0)).mean((1, 2))
    measured[1:, 1] = measured[1:, 0] + np.diff(measured[:, 2])
    return measured


def moving_flicker(frames: Any, references: Any) -> float:
    """Return the mean flicker of a sequence whose truth moves too: two (F, H, W), F at least 2."""
    references = check_array("references", references, (None, None, None)).astype(np.float64)
    frames = check_array("frames", frames, references.shape).astype(np.float64)
    if len(frames) < 2:
        raise InputError(f"frames: expected at least 2, got {len(frames)}")
    return float(np.abs(np.diff(frames - references, axis=0)).mean())


def measure_stability(
    model: ModelLike,
    scenes: Sequence[SceneLike],
    *,
    frames: int,
    size: tuple[int, int] = SIZE,
    orbit_frames: int = ORBIT_FRAMES,
    order: str = "uniform",
    seed: int = 0,
) -> Stability:
    """Measure the flicker of converging pictures and of orbits, completed by a network and by interpolation.

    Parameters
    ----------
    model : name of shipped weights, a .safetensors file, or a Model
        Measured with the traced pixels kept, "network", and as the network puts them out, clamped, "network, raw".
    scenes : what to look at, a view of each
    frames : of a converging picture, at least 2, from `FIRST_FRACTION` to all of the pixels in equal steps
    size : (height, width)
    orbit_frames : of an orbit at each of `ORBIT_FRACTIONS`, at least 2; each frame traces other pixels
    order, seed : of the pixels

    Raises
    ------
    InputError
        If an argument can't be used.
    """
    check_integer("frames", frames, 2, 10_000)
    check_integer("orbit_frames", orbit_frames, 2, 10_000)
    if not scenes:
        raise InputError("scenes: expected at least one, got none")
    methods = _methods(model)
    fractions = np.linspace(FIRST_FRACTION, 1, frames)
    converging: dict[str, list[F64]] = {name: [] for name in methods}
    orbit: dict[str, list[list[float]]] = {name: [] for name in methods}
    with progress("measuring stability") as report:
        for number, scene in enumerate(scenes):
            cameras = [bob.Camera(azimuth=40 + 70 * number + ORBIT_STEP * i, elevation=25) for i in range(orbit_frames)]
            views = [bob.trace(scene, camera, size=size) for camera in cameras]
            parts = [views[0].sample(fraction, order=order, seed=seed + number) for fraction in fractions]
            for name, method in methods.items():
                converging[name].append(change_and_flicker([method(part) for part in parts], views[0].gray))
            truth = [view.gray for view in views]
            for name, method in methods.items():
                # Other pixels in each frame, as in an interactive view, which starts anew when the camera moves.
                orbit[name].append(
                    [
                        moving_flicker(
                            [method(v.sample(f, order=order, seed=seed + i)) for i, v in enumerate(views)], truth
                        )
                        for f in ORBIT_FRACTIONS
                    ]
                )
            report((number + 1) / len(scenes))
    return Stability(
        len(scenes),
        fractions,
        {name: np.mean(measured, 0) for name, measured in converging.items()},
        ORBIT_FRACTIONS,
        {name: np.mean(measured, 0) for name, measured in orbit.items()},
    )


def draw_stability(sources: Sources) -> Drawing:
    """Measure, and draw the flicker of converging pictures over the share of pixels traced, beside that of orbits."""
    scenes = [sources.scene, *(procedural_scene(number) for number in SHAPES)]
    return show_stability(measure_stability(sources.weights, scenes, frames=sources.frames, seed=sources.seed))


def show_stability(stability: Stability) -> Drawing:
    """Draw what was measured."""
    figure = new_figure(PAGE, 2.4)
    converging, totals, orbit = figure.subplots(1, 3, width_ratios=[2.2, 1, 1.2])
    names = list(stability.frames)
    for name in names:
        flicker = 255 * stability.frames[name][1:, 1]
        flicker[flicker < 1e-6] = np.nan  # none, but for rounding: nothing that a logarithm can show
        converging.plot(100 * stability.fractions[1:], flicker, color=COLORS[name], label=name)
    converging.set(xlabel="pixels traced, %", ylabel="flicker per frame, gray levels of 255", yscale="log")
    converging.set_title(f"converging picture, {len(stability.fractions)} frames, mean of {stability.views} views")
    converging.yaxis.set_major_formatter("{x:g}")
    converging.grid(axis="y")
    converging.legend()

    places = np.arange(len(names))
    shares = [100 * flicker / change for flicker, change in map(stability.total, names)]
    bars = totals.barh(places, shares, color=[COLORS[name] for name in names])
    totals.bar_label(bars, [f"{share:.0f} %" for share in shares], padding=2, fontsize=6.5)
    totals.set(xlabel="share of all change, %", xlim=(0, 1.25 * max(*shares, 1)), title="flicker of all frames")
    totals.set_yticks(places, names)
    totals.invert_yaxis()

    columns = np.arange(len(stability.orbit_fractions))
    width = 0.8 / len(names)
    for i, name in enumerate(names):
        orbit.bar(columns + (i - (len(names) - 1) / 2) * width, 255 * stability.orbit[name], width, color=COLORS[name])
    orbit.set_xticks(columns, [f"{100 * fraction:g}" for fraction in stability.orbit_fractions])
    orbit.set(xlabel="pixels traced, %", ylabel="flicker per frame, gray levels of 255")
    orbit.set_title(f"orbit, {ORBIT_STEP:g}° a frame")
    orbit.grid(axis="y")
    return Drawing(
        figure,
        "Temporal stability. Left: change from frame to frame of a converging picture that is not progress towards the "
        f"truth, mean |x - x'| - (mean |x' - r| - mean |x - r|), from {100 * stability.fractions[0]:g} % of the pixels "
        f"to all in {len(stability.fractions)} frames. Middle: the sum over the frames as a share of all change. "
        "Right: on an orbit, where each frame traces other pixels, change that is not the truth's own, "
        f"mean |(x - x') - (r - r')|. Means of {stability.views} views.",
        stability.csv(),
    )


def _methods(model: ModelLike) -> dict[str, Method]:
    network = load_model(model)
    return {
        "network": lambda part: bob.complete(part, model=network),
        "network, raw": lambda part: np.clip(network.predict(part), 0, 1),
        "delaunay-linear": lambda part: delaunay_linear(part.gray, part.mask),
        "pull-push": lambda part: pull_push(part.gray, part.mask),
        "nearest": lambda part: nearest(part.gray, part.mask),
    }
