"""Accuracy of the expected error: where pictures that stop by it stop, and their true error there.

Letters: P pictures, L limits.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.completion.uncertainty import mean_error
from bobrossnet.learn.checks import check_orders
from bobrossnet.learn.evaluation.methods import Weights
from bobrossnet.learn.evaluation.scenes import Scenes, each_scene
from bobrossnet.support.errors import InputError, check_number
from bobrossnet.support.progress import progress
from bobrossnet.support.tables import table

LIMITS = (0.02, 0.01, 0.005, 0.002)
"""Limits of the expected mean absolute error in gray."""

STEP = 0.01  # share of the pixels between two checks
MEASURES = ("fraction", "expected", "true")


@dataclass(frozen=True)
class KnownError:
    """The result of `measure_known_error`.

    Attributes
    ----------
    shapes : shape shown by each picture, (P,)
    limits : (L,), falling
    stops : by pixel order: (P, L, 3) float64
        The share of the pixels at the first check with an expected error of at most the limit, that expected error, and
        the true error.
    """

    shapes: tuple[str, ...]
    limits: tuple[float, ...]
    stops: Mapping[str, NDArray[np.float64]] = field(repr=False)

    def shares(self) -> list[tuple[str, float, tuple[float, float, float]]]:
        """Return three shares for each order and limit.

        They are the mean share of traced pixels, the share of pictures with a true error below the expected one, and
        the share with both errors within a factor of two.
        """
        found = []
        for order, stops in self.stops.items():
            for limit, (fraction, expected, true) in zip(self.limits, stops.transpose(1, 2, 0), strict=True):
                below, close = true <= expected, np.abs(np.log2((true + 1e-9) / (expected + 1e-9))) <= 1
                found.append((order, limit, (float(fraction.mean()), float(below.mean()), float(close.mean()))))
        return found

    def table(self) -> str:
        """Return `shares` as a markdown table."""
        rows = [
            [order, f"{limit:g}", *(f"{100 * share:.1f} %" for share in shares)]
            for order, limit, shares in self.shares()
        ]
        return table(["order", "stop at", "traced", "true error below", "within a factor of two"], rows)

    def csv(self) -> str:
        """Return a row for each order, picture and limit: order, shape, limit, fraction, expected, true."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["order", "shape", "limit", *MEASURES])
        for order, stops in self.stops.items():
            for shape, of_shape in zip(self.shapes, stops.tolist(), strict=True):
                for limit, row in zip(self.limits, of_shape, strict=True):
                    writer.writerow([order, shape, limit, *row])
        return text.getvalue()

    @classmethod
    def from_csv(cls, text: str) -> KnownError:
        """Return the result with this `csv`. InputError if the text is invalid."""
        stops: dict[str, dict[str, dict[float, list[float]]]] = {}
        try:
            for row in csv.DictReader(io.StringIO(text)):
                by_limit = stops.setdefault(row["order"], {}).setdefault(row["shape"], {})
                by_limit[float(row["limit"])] = [float(row[measure]) for measure in MEASURES]
            by_shape = next(iter(stops.values()))
            limits = tuple(next(iter(by_shape.values())))
            arrays = {
                order: np.array([[found[shape][limit] for limit in limits] for shape in by_shape])
                for order, found in stops.items()
            }
        except (KeyError, ValueError, StopIteration) as error:
            raise InputError(f"text: expected known errors, got {error!r}") from error
        return cls(tuple(by_shape), limits, arrays)

    def beside(self, other: KnownError) -> KnownError:
        """Return these orders, followed by another result's. InputError if the pictures differ."""
        if (self.shapes, self.limits) != (other.shapes, other.limits):
            raise InputError("other: expected known errors of the same pictures at the same limits, got others")
        return KnownError(self.shapes, self.limits, {**self.stops, **other.stops})

    def of_order(self, order: str) -> KnownError:
        """Return the results of one order."""
        return KnownError(self.shapes, self.limits, {order: self.stops[order]})


def measure_known_error(
    scenes: Scenes,
    model: Weights = "default",
    *,
    limits: Sequence[float] = LIMITS,
    size: tuple[int, int] = (256, 256),
    orders: Sequence[str] = ("default",),
) -> KnownError:
    """Trace pictures until their expected error is below limits, and compare it with the true one.

    Parameters
    ----------
    scenes : functions that make them, by name; one view of each
    model : name of shipped weights, or a .safetensors file
    limits : of the expected error, above 0
    size : (height, width)
    orders : pixel orders

    Raises
    ------
    InputError
        If an argument is invalid, or no scene can be made.

    Warns
    -----
    InputWarning
        If a scene is omitted because its file can't be loaded.
    """
    orders = check_orders(orders)
    limits = tuple(sorted((check_number("limits", limit, 0, above=True) for limit in limits), reverse=True))
    shapes: list[str] = []
    stops: dict[str, list[list[list[float]]]] = {order: [] for order in orders}
    with progress("measuring known errors") as report:
        for number, name, scene in each_scene(scenes, stacklevel=3):
            shapes.append(name)
            camera = bob.Camera(azimuth=(30 * number) % 360, elevation=(20, 45)[number % 2])
            full = bob.trace(scene, camera, size=size)
            for order in orders:
                stops[order].append(_stops(full, order, number, model, limits))
            report((number + 1) / len(scenes), name)
    if not shapes:
        raise InputError("scenes: expected at least one that can be loaded, got none")
    return KnownError(tuple(shapes), limits, {order: np.array(found) for order, found in stops.items()})


def _stops(full: bob.GBuffer, order: str, seed: int, model: Weights, limits: Sequence[float]) -> list[list[float]]:
    """Return the measures where each limit is met; at the latest all pixels are traced and the error is 0."""
    found: list[list[float]] = []
    for fraction in np.arange(1, round(1 / STEP) + 1) * STEP:
        part = full.sample(float(min(fraction, 1)), order=order, seed=seed)
        expected = mean_error(part, model)
        while len(found) < len(limits) and expected <= limits[len(found)]:
            found.append([part.fraction, expected, float(np.abs(bob.complete(part, model=model) - full.gray).mean())])
        if len(found) == len(limits):
            break
    return found
