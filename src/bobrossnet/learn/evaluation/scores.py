"""Results of an evaluation: means, gains with confidence intervals, tables, CSV.

methods.py defines the names of methods; a method with a pixel order is a run.
Letters: R runs, P pictures, F shares of traced pixels.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet.color import luminance, to_srgb
from bobrossnet.learn.evaluation.confidence import half_width, relative_change
from bobrossnet.learn.evaluation.methods import is_kept
from bobrossnet.learn.evaluation.runs import Run, find_run, label, orders_of, rivals
from bobrossnet.metrics import flip, psnr, ssim
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import counted
from bobrossnet.support.tables import best_bold, plus_minus, table


class Metric(NamedTuple):
    label: str
    measure: Callable[[Any, Any], float]  # of gray pictures
    of_color: Callable[[Any, Any], float]  # of pictures in linear RGB
    digits: int
    better: int  # 1 if higher is better, otherwise -1
    best: float  # value of an exact picture


METRICS = {
    "ssim": Metric("SSIM", ssim, lambda image, other: ssim(luminance(image), luminance(other)), 4, 1, 1.0),
    "psnr": Metric("PSNR of the mean squared error, in dB", psnr, psnr, 2, 1, math.inf),
    "flip": Metric("FLIP, less is better", flip, lambda image, other: flip(to_srgb(image), to_srgb(other)), 4, -1, 0.0),
}
"""In the order of the scores.

For colours, SSIM is computed on luminance, PSNR on all three components, both in linear light, and FLIP in sRGB.
"""


@dataclass(frozen=True)
class Evaluation:
    """Scores of several methods, each with one or more pixel orders, on the same pictures.

    `str()` returns everything as markdown. Where a run is expected, a method's name alone selects its run with the
    first of the orders.

    Attributes
    ----------
    pictures : names of the pictures, (P,)
    shapes : shape shown by each picture, (P,)
        Pictures of one shape are correlated, which the confidence intervals account for.
    fractions : shares of traced pixels, (F,)
    scores : by method and order: (P, F, 3) float64
        SSIM, at most 1; PSNR in dB, infinite for an exact picture; FLIP in 0..1, 0 for an exact picture.
    """

    pictures: tuple[str, ...]
    shapes: tuple[str, ...]
    fractions: tuple[float, ...]
    scores: Mapping[Run, NDArray[np.float64]] = field(repr=False)

    @property
    def orders(self) -> tuple[str, ...]:
        """The pixel orders of the runs."""
        return orders_of(self.scores)

    def mean(self, run: str | Run, metric: str = "ssim") -> NDArray[np.float64]:
        """Return a run's mean score over all pictures.

        Parameters
        ----------
        run : method, or method and order
        metric : "ssim", "psnr" or "flip"

        Returns
        -------
        (F,) float64
            The mean over the pictures; for PSNR, the PSNR of the mean squared error over all their pixels. A mean of
            PSNRs would be infinite as soon as one picture is exact: a background patch often is, and every picture is
            once all pixels are traced and kept. This one is infinite only if all pictures are exact.
        """
        means = self._values(run, metric).mean(0)
        return _decibels(means) if metric == "psnr" else np.asarray(means)

    def gain(self, run: str | Run, over: str | Run, metric: str = "ssim") -> NDArray[np.float64]:
        """Return a run's gain over another, from the differences picture by picture.

        Parameters
        ----------
        run, over : each a method, or method and order
        metric : "ssim", "psnr" or "flip"

        Returns
        -------
        (F, 2) float64
            The difference of their means, positive where `run` is better, and half the width of its 95 % confidence
            interval over shapes of this kind. NaN if undefined: for a single shape, and for the PSNR if a run is exact
            in all pictures.
        """
        ours, theirs = self._values(run, metric), self._values(over, metric)  # (P, F)
        if metric == "psnr":
            with np.errstate(divide="ignore", invalid="ignore"):
                share_of_error = theirs / theirs.mean(0) - ours / ours.mean(0)
                difference = _decibels(ours.mean(0)) - _decibels(theirs.mean(0))
                deviations = 10 / math.log(10) * share_of_error  # the delta method
        else:
            gains = METRICS[metric].better * (ours - theirs)
            difference = gains.mean(0)
            deviations = gains - difference
        return np.stack([difference, half_width(deviations, self.shapes)], 1)

    def change_of_error(self, run: str | Run, over: str | Run, metric: str = "ssim") -> NDArray[np.float64]:
        """Return the relative change of a run's error from another run's, picture by picture in pairs.

        Parameters
        ----------
        run, over : each a method, or method and order
        metric : "ssim", "psnr" or "flip"
            The error is 1 - SSIM, the mean squared error, or FLIP.

        Returns
        -------
        (F, 2) float64
            The ratio of their mean errors minus 1, negative where `run` is better, and half the width of its 95 %
            confidence interval over shapes of this kind. NaN if undefined.
        """
        ours, theirs = self._values(run, metric), self._values(over, metric)  # (P, F)
        if metric == "ssim":
            ours, theirs = 1 - ours, 1 - theirs
        return relative_change(ours, theirs, self.shapes)

    def table(self, metric: str = "ssim") -> str:
        """Return `mean` of all runs as a markdown table, with the best of each column in bold."""
        kind = self._metric(metric)
        digits, better = kind.digits, kind.better
        means = np.array([self.mean(run, metric) for run in self.scores])  # (R, F)
        best = (better * means).max(0) * better
        rows = zip(self.scores, means.tolist(), strict=True)
        return self._markdown([[label(self.scores, run), *best_bold(row, best.tolist(), digits)] for run, row in rows])

    def gain_table(self, run: str | Run, metric: str = "ssim") -> str:
        """Return a run's gain over each of `rivals` as a markdown table."""
        digits = self._metric(metric).digits
        rows = []
        for rival in rivals(self.scores, run):
            gains = self.gain(run, rival, metric)
            rows.append(
                [f"over {label(self.scores, rival)}", *(plus_minus(mean, half, digits) for mean, half in gains)]
            )
        return self._markdown(rows)

    def error_table(self, run: str | Run) -> str:
        """Return the change of a run's error from each of its `rivals`, in percent, as a markdown table."""
        rows = []
        for rival in rivals(self.scores, run):
            changes = 100 * self.change_of_error(run, rival)
            rows.append([f"from {label(self.scores, rival)}", *(plus_minus(mean, half, 1) for mean, half in changes)])
        return self._markdown(rows)

    def csv(self) -> str:
        """Return all scores as CSV, a row for each run, picture and share of traced pixels.

        The columns: method, order, shape, picture, fraction, ssim, psnr, flip; PSNR may be inf.
        """
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["method", "order", "shape", "picture", "fraction", *METRICS])
        for run, scores in self.scores.items():
            for shape, picture, by_fraction in zip(self.shapes, self.pictures, scores.tolist(), strict=True):
                for fraction, row in zip(self.fractions, by_fraction, strict=True):
                    writer.writerow([*run, shape, picture, fraction, *row])
        return text.getvalue()

    @classmethod
    def from_csv(cls, text: str) -> Evaluation:
        """Return the evaluation with this `csv`.

        Raises
        ------
        InputError
            If the text is invalid.
        """
        scores: dict[Run, dict[tuple[str, str], dict[float, list[float]]]] = {}
        try:
            for row in csv.DictReader(io.StringIO(text)):
                by_picture = scores.setdefault((row["method"], row["order"]), {})
                by_fraction = by_picture.setdefault((row["shape"], row["picture"]), {})
                by_fraction[float(row["fraction"])] = [float(row[metric]) for metric in METRICS]
            by_picture = next(iter(scores.values()))
            arrays = {
                run: np.array([[scores[run][key][f] for f in fractions] for key, fractions in by_picture.items()])
                for run in scores
            }
        except (KeyError, ValueError, StopIteration) as error:
            raise InputError(f"text: expected the scores of an evaluation, got {error!r}") from error
        shapes, pictures = zip(*by_picture, strict=True)
        fractions = tuple(next(iter(by_picture.values())))
        return cls(pictures, shapes, fractions, arrays)

    def beside(self, other: Evaluation) -> Evaluation:
        """Return these runs, followed by another evaluation's on the same pictures.

        Raises
        ------
        InputError
            If its pictures or shares of traced pixels differ.
        """
        if (self.shapes, self.pictures, self.fractions) != (other.shapes, other.pictures, other.fractions):
            raise InputError("other: expected an evaluation of the same pictures at the same fractions, got another")
        scores = {**self.scores, **other.scores}
        return Evaluation(self.pictures, self.shapes, self.fractions, scores)

    def of_order(self, order: str) -> Evaluation:
        """Return the runs with one pixel order."""
        scores = {run: values for run, values in self.scores.items() if run[1] == order}
        return Evaluation(self.pictures, self.shapes, self.fractions, scores)

    def of_shapes(self, names: Collection[str]) -> Evaluation:
        """Return the scores of the named shapes. InputError if no shape has such a name."""
        chosen = np.array([shape in names for shape in self.shapes])
        if not chosen.any():
            raise InputError(f"names: expected some of the shapes, got {', '.join(names)}")
        pictures, shapes = (tuple(np.array(values)[chosen].tolist()) for values in (self.pictures, self.shapes))
        return Evaluation(
            pictures, shapes, self.fractions, {run: values[chosen] for run, values in self.scores.items()}
        )

    def __str__(self) -> str:
        parts = [f"Means over {counted(len(self.pictures), 'picture')} of {counted(len(set(self.shapes)), 'shape')}."]
        for metric, described in METRICS.items():
            parts += [f"{described.label}:", self.table(metric)]
            if metric == "ssim":
                for run in self.scores:
                    if is_kept(run[0]) and rivals(self.scores, run):
                        parts += [
                            f"Gain of {label(self.scores, run)} in SSIM, with 95 % confidence intervals over shapes:",
                            self.gain_table(run),
                            f"1 - SSIM of {label(self.scores, run)}, change in percent:",
                            self.error_table(run),
                        ]
        return "\n\n".join(parts)

    def _values(self, run: str | Run, metric: str) -> NDArray[np.float64]:
        """Return the values to average over pictures, (P, F): SSIM, FLIP, or the mean squared error for PSNR."""
        self._metric(metric)
        values = self.scores[find_run(self.scores, run)][..., list(METRICS).index(metric)]
        return 10 ** (-values / 10) if metric == "psnr" else values

    def _metric(self, name: str) -> Metric:
        if name not in METRICS:
            raise InputError(f"metric: expected one of {', '.join(METRICS)}, got {name!r}")
        return METRICS[name]

    def _markdown(self, rows: Sequence[Sequence[str]]) -> str:
        return table(["traced", *(f"{100 * fraction:g} %" for fraction in self.fractions)], rows)


def _decibels(error: NDArray[np.float64]) -> NDArray[np.float64]:
    with np.errstate(divide="ignore"):
        return np.asarray(-10 * np.log10(error))
