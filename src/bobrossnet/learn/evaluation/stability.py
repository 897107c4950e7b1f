"""Temporal stability: the share of flicker in the frame-to-frame change of a converging picture.

A converging picture changes; it looks stable where it only moves towards the truth. For consecutive frames x' and x of
a view with a constant truth r,

    change  = mean |x - x'|
    gain    = mean |x' - r| - mean |x - r|
    flicker = change - gain

over the pixels. By the triangle inequality flicker is never negative, and it is 0 where the pixel moves towards the
truth without overshoot: a picture that converges monotonically, pixel by pixel, has no flicker. Twice the distance
that pixels move away from the truth is flicker, since they have to return. Summed over the frames, flicker is the
excess of the pixels' path length over the shortest path.

On an orbit the truth moves too, and flicker is the change beyond the change of the truth:

    flicker = mean |(x - x') - (r - r')|
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.learn.checks import MAX_FRAMES, check_orders
from bobrossnet.learn.evaluation.confidence import relative_change
from bobrossnet.learn.evaluation.methods import Weights, all_methods, is_kept
from bobrossnet.learn.evaluation.runs import Run, find_run, label, orders_of, rivals
from bobrossnet.learn.evaluation.scenes import Scenes, each_scene
from bobrossnet.support.errors import InputError, check_array, check_integer
from bobrossnet.support.messages import counted
from bobrossnet.support.progress import progress
from bobrossnet.support.tables import best_bold, plus_minus, table

F64 = NDArray[np.float64]

FIRST_FRACTION = 0.01  # share of the pixels in the first frame; the others add the same number each, up to all
SIZE = (128, 128)  # Delaunay-linear takes most of the time, about 0.2 s a picture; the network 2 ms
FRAMES = 30
MEASURES = ("change", "flicker", "error")

ORBIT_FRACTIONS = (0.05, 0.25)
ORBIT_FRAMES = 8
ORBIT_STEP = 2.0  # degrees of azimuth between frames

FILLINGS = ("delaunay-linear", "pull-push", "nearest")
LEVELS = 255  # tables give flicker in 8-bit steps


@dataclass(frozen=True)
class Stability:
    """The result of `measure_stability`. Grays are in 0..1. V views, F frames, O orbits.

    `str()` returns everything as markdown. Where a run is expected, a method's name alone selects its run with the
    first of the orders.

    Attributes
    ----------
    shapes : shape shown by each view, (V,)
    fractions : (F,) float64, shares of the pixels traced in the frames
    frames : by method and order: (V, F, 3) float64, change, flicker and error of each frame
        The error is mean |x - r|. Change and flicker of the first frame are NaN.
    orbit_fractions : shares of the pixels traced in the frames of the orbits, (O,)
    orbit : by method and order: (V, O) float64, the mean flicker
    """

    shapes: tuple[str, ...]
    fractions: F64
    frames: Mapping[Run, F64] = field(repr=False)
    orbit_fractions: tuple[float, ...]
    orbit: Mapping[Run, F64] = field(repr=False)

    @property
    def orders(self) -> tuple[str, ...]:
        """The pixel orders of the runs."""
        return orders_of(self.frames)

    def mean(self, run: str | Run) -> F64:
        """Return change, flicker and error of each frame, as means over the views: (F, 3)."""
        return np.asarray(self.frames[find_run(self.frames, run)].mean(0))

    def total(self, run: str | Run) -> tuple[float, float]:
        """Return a run's flicker and change, summed over the frames, as means over the views."""
        change, flicker, _ = np.nansum(self.mean(run), 0).tolist()
        return flicker, change

    def change_of_flicker(self, run: str | Run, over: str | Run) -> F64:
        """Return the relative change of a run's flicker from another run's, view by view in pairs.

        Returns
        -------
        (1 + O, 2) float64
            For the flicker of all frames, and of the orbits: the ratio of the means minus 1, negative where `run` is
            steadier, and half the width of its 95 % confidence interval over shapes of this kind. NaN if undefined.
        """
        return relative_change(self._flickers(run), self._flickers(over), self.shapes)

    def table(self) -> str:
        """Return the flicker of all runs as a markdown table, with the minimum of each column in bold."""
        totals = np.array([self.total(run) for run in self.frames])
        orbits = np.array([self.orbit[run].mean(0) for run in self.frames])
        columns = np.column_stack([LEVELS * totals[:, 0], 100 * totals[:, 0] / totals[:, 1], LEVELS * orbits])
        least = columns.min(0).tolist()
        rows = [
            [label(self.frames, run), *best_bold(row, least, 2)]
            for run, row in zip(self.frames, columns.tolist(), strict=True)
        ]
        return table(["method", "flicker of all frames", "of all change, %", *self._orbits()], rows)

    def change_table(self, run: str | Run) -> str:
        """Return the change of a run's flicker from each of its `rivals`, in percent, as a markdown table."""
        rows = []
        for rival in rivals(self.frames, run):
            changes = 100 * self.change_of_flicker(run, rival)
            rows.append([f"from {label(self.frames, rival)}", *(plus_minus(mean, half, 1) for mean, half in changes)])
        return table(["flicker", "all frames", *self._orbits()], rows)

    def csv(self) -> str:
        """Return all numbers as CSV: a row for each run, view and frame, then one for each of their orbits.

        The columns: sequence, method, order, shape, fraction, change, flicker, error.
        """
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["sequence", "method", "order", "shape", "fraction", *MEASURES])
        for run, views in self.frames.items():
            for shape, frames in zip(self.shapes, views, strict=True):
                for fraction, values in zip(self.fractions, frames, strict=True):
                    cells = ["" if np.isnan(value) else f"{value:.6g}" for value in values]
                    writer.writerow(["converging", *run, shape, f"{fraction:.6f}", *cells])
        for run, views in self.orbit.items():
            for shape, flickers in zip(self.shapes, views, strict=True):
                for fraction, flicker in zip(self.orbit_fractions, flickers, strict=True):
                    writer.writerow(["orbit", *run, shape, f"{fraction:.6f}", "", f"{flicker:.6g}", ""])
        return text.getvalue()

    @classmethod
    def from_csv(cls, text: str) -> Stability:
        """Return the stability with this `csv`, up to rounding.

        Raises
        ------
        InputError
            If the text is invalid.
        """
        frames: dict[Run, dict[str, dict[float, list[float]]]] = {}
        orbits: dict[Run, dict[str, dict[float, float]]] = {}
        try:
            for row in csv.DictReader(io.StringIO(text)):
                run, shape, fraction = (row["method"], row["order"]), row["shape"], float(row["fraction"])
                if row["sequence"] == "orbit":
                    orbits.setdefault(run, {}).setdefault(shape, {})[fraction] = float(row["flicker"])
                else:
                    values = [float(row[name] or "nan") for name in MEASURES]
                    frames.setdefault(run, {}).setdefault(shape, {})[fraction] = values
            first, first_orbit = next(iter(frames.values())), next(iter(orbits.values()))
            shapes, fractions = tuple(first), tuple(next(iter(first.values())))
            orbit_fractions = tuple(next(iter(first_orbit.values())))
            return cls(
                shapes,
                np.array(fractions),
                {run: np.array([[of[shape][f] for f in fractions] for shape in shapes]) for run, of in frames.items()},
                orbit_fractions,
                {
                    run: np.array([[of[shape][f] for f in orbit_fractions] for shape in shapes])
                    for run, of in orbits.items()
                },
            )
        except (KeyError, ValueError, StopIteration) as error:
            raise InputError(f"text: expected the result of a stability measurement, got {error!r}") from error

    def beside(self, other: Stability) -> Stability:
        """Return these runs, followed by another stability's on the same views.

        Raises
        ------
        InputError
            If its views or shares of traced pixels differ.
        """
        same = (self.shapes, self.orbit_fractions) == (other.shapes, other.orbit_fractions)
        same &= [f"{fraction:.6f}" for fraction in self.fractions] == [
            f"{fraction:.6f}" for fraction in other.fractions
        ]
        if not same:
            raise InputError("other: expected a stability of the same views at the same fractions, got another")
        return Stability(
            self.shapes,
            self.fractions,
            {**self.frames, **other.frames},
            self.orbit_fractions,
            {**self.orbit, **other.orbit},
        )

    def of_order(self, order: str) -> Stability:
        """Return the runs with one pixel order."""
        frames, orbit = (
            {run: values for run, values in numbers.items() if run[1] == order} for numbers in (self.frames, self.orbit)
        )
        return Stability(self.shapes, self.fractions, frames, self.orbit_fractions, orbit)

    def caption(self) -> str:
        """Return the caption of `table`."""
        return (
            f"Flicker in gray levels of {LEVELS}, means over {counted(len(self.shapes), 'shape')}. Converging "
            f"pictures go from {100 * self.fractions[0]:g} % of the pixels to all in {len(self.fractions)} frames, and "
            f"their flicker is summed. Orbits turn by {ORBIT_STEP:g}° a frame, and their flicker is the mean of a "
            "frame."
        )

    def __str__(self) -> str:
        parts = [self.caption(), self.table()]
        for run in self.frames:
            if is_kept(run[0]) and rivals(self.frames, run):
                parts += [
                    f"Flicker of {label(self.frames, run)}, change in percent, with 95 % confidence intervals over "
                    "shapes:",
                    self.change_table(run),
                ]
        return "\n\n".join(parts)

    def _flickers(self, run: str | Run) -> F64:
        """Return the flicker of all frames and of the orbits, (V, 1 + O)."""
        found = find_run(self.frames, run)
        return np.column_stack([np.nansum(self.frames[found][..., 1], 1), self.orbit[found]])

    def _orbits(self) -> list[str]:
        return [f"orbit at {100 * fraction:g} %" for fraction in self.orbit_fractions]


def change_and_flicker(frames: Any, reference: Any) -> F64:
    """Return change, flicker and error of a picture sequence with a constant truth; see the module for the formulas.

    Parameters
    ----------
    frames : (F, H, W) numbers
    reference : (H, W) numbers, the truth

    Returns
    -------
    (F, 3) float64
        Change and flicker of the first frame are NaN.

    Raises
    ------
    InputError
        If the shapes don't match.

    Examples
    --------
    >>> frames = np.array([0.0, 0.5, 0.25, 1.0]).reshape(4, 1, 1)
    >>> change_and_flicker(frames, np.ones((1, 1)))[1:, 1].tolist()  # a step of 0.25 back, to be repeated
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
    """Return the mean flicker of a sequence with a moving truth: two (F, H, W), F at least 2."""
    references = check_array("references", references, (None, None, None)).astype(np.float64)
    frames = check_array("frames", frames, references.shape).astype(np.float64)
    if len(frames) < 2:
        raise InputError(f"frames: expected at least 2, got {len(frames)}")
    return float(np.abs(np.diff(frames - references, axis=0)).mean())


def measure_stability(
    scenes: Scenes,
    models: Sequence[Weights],
    *,
    frames: int = FRAMES,
    size: tuple[int, int] = SIZE,
    orbit_frames: int = ORBIT_FRAMES,
    orders: Sequence[str] = ("uniform",),
    fillings: Sequence[str] = FILLINGS,
    repainting: bool = True,
    seed: int = 0,
) -> Stability:
    """Measure the flicker of converging pictures and of orbits, completed by networks and by fillings.

    Parameters
    ----------
    scenes : functions that make them, by name; one view of each
    models : names of shipped weights, or .safetensors files
    frames : number of frames of a converging picture, at least 2, from `FIRST_FRACTION` to all pixels in equal steps
    size : (height, width)
    orbit_frames : number of frames of an orbit at each of `ORBIT_FRACTIONS`, at least 2; each has its own seed
    orders, seed : pixel orders, and their seed
        Every method is measured with each order.
    fillings : names in `bobrossnet.completion.filling.FILLINGS` to compare with
    repainting : whether networks are also measured with the traced pixels repainted

    Raises
    ------
    InputError
        If an argument is invalid, or there is no scene.

    Warns
    -----
    InputWarning
        If a scene is omitted because its file can't be loaded.
    """
    check_integer("frames", frames, 2, MAX_FRAMES)
    check_integer("orbit_frames", orbit_frames, 2, MAX_FRAMES)
    methods = all_methods(models, fillings, repainting=repainting)
    orders = check_orders(orders)
    runs = [(method, order) for method in methods for order in orders]
    fractions = np.linspace(FIRST_FRACTION, 1, frames)
    shapes = []
    converging: dict[Run, list[F64]] = {run: [] for run in runs}
    orbit: dict[Run, list[list[float]]] = {run: [] for run in runs}
    with progress("measuring stability") as report:
        for number, name, scene in each_scene(scenes, stacklevel=3):
            shapes.append(name)
            cameras = [bob.Camera(azimuth=40 + 70 * number + ORBIT_STEP * i, elevation=25) for i in range(orbit_frames)]
            views = [bob.trace(scene, camera, size=size) for camera in cameras]
            truth = [view.gray for view in views]
            for order in orders:
                parts = [views[0].sample(fraction, order=order, seed=seed + number) for fraction in fractions]
                # A new seed for each frame, as in an interactive view, which restarts when the camera moves.
                moving = [
                    [view.sample(fraction, order=order, seed=seed + i) for i, view in enumerate(views)]
                    for fraction in ORBIT_FRACTIONS
                ]
                for method, complete in methods.items():
                    run = method, order
                    converging[run].append(change_and_flicker([complete(part) for part in parts], truth[0]))
                    orbit[run].append([moving_flicker([complete(part) for part in turn], truth) for turn in moving])
            report((number + 1) / len(scenes), name)
    if not shapes:
        raise InputError("scenes: expected at least one that can be loaded, got none")
    return Stability(
        tuple(shapes),
        fractions,
        {run: np.array(measured) for run, measured in converging.items()},
        ORBIT_FRACTIONS,
        {run: np.array(measured) for run, measured in orbit.items()},
    )
