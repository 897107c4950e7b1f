"""What was measured of models and fillings: means, gains with their confidence, tables, CSV.

A model stands in it twice: NAME raw is its network's own output clamped to 0..1, which repaints the traced pixels; NAME
kept is what `bobrossnet.complete` returns, with the traced pixels as they came in. The fillings keep them as well.
Letters: M methods, P pictures, F shares of traced pixels.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet.errors import InputError
from bobrossnet.learn.tables import table
from bobrossnet.metrics import flip, psnr, ssim


class Metric(NamedTuple):
    label: str
    measure: Callable[[Any, Any], float]
    digits: int
    better: int  # 1 if more is better, -1 if less is
    best: float  # of a picture that equals its reference


METRICS = {
    "ssim": Metric("SSIM", ssim, 4, 1, 1.0),
    "psnr": Metric("PSNR of the mean squared error, in dB", psnr, 2, 1, math.inf),
    "flip": Metric("FLIP, less is better", flip, 4, -1, 0.0),
}
"""In the order of the scores."""


@dataclass(frozen=True)
class Evaluation:
    """Scores of several methods on the same partial pictures.

    `str()` of it is all that there is to print, in markdown.

    Attributes
    ----------
    pictures : names of the pictures, (P,)
    shapes : of each picture what it shows, (P,)
        Pictures of one shape are not independent of each other, which the confidence intervals take into account.
    fractions : shares of traced pixels, (F,)
    models : names of the models
        Of their methods, "NAME raw" and "NAME kept" for each.
    scores : by method, the models' first: (P, F, 3) float64
        SSIM, of at most 1; PSNR in dB, infinite where a picture equals its reference; FLIP in 0..1, 0 where equal.
    """

    pictures: tuple[str, ...]
    shapes: tuple[str, ...]
    fractions: tuple[float, ...]
    models: tuple[str, ...]
    scores: Mapping[str, NDArray[np.float64]] = field(repr=False)

    def mean(self, method: str, metric: str = "ssim") -> NDArray[np.float64]:
        """Return a method's score over all pictures.

        Parameters
        ----------
        method : name in `scores`
        metric : "ssim", "psnr" or "flip"

        Returns
        -------
        (F,) float64
            The mean over the pictures; as PSNR that of the mean squared error over all their pixels. A mean of PSNRs
            would be infinite as soon as one picture is exact, as a patch of background is, and all are once every pixel
            is known and kept. So it is infinite only where all of them are exact.
        """
        means = self._values(method, metric).mean(0)
        return _decibels(means) if metric == "psnr" else np.asarray(means)

    def gain(self, method: str, over: str, metric: str = "ssim") -> NDArray[np.float64]:
        """Return by how much one method is better than another, from the differences picture by picture.

        Parameters
        ----------
        method, over : names in `scores`
        metric : "ssim", "psnr" or "flip"

        Returns
        -------
        (F, 2) float64
            The difference of their means, above 0 where `method` is better, and half the width of its 95 % confidence
            interval for other shapes of this kind. NaN where there is none: from a single shape, and for the PSNR where
            a method is exact in all pictures.

        References
        ----------
        Liang and Zeger, *Longitudinal data analysis using generalized linear models*, 1986: standard errors of data in
        clusters, here shapes; with one picture of each they are the usual ones. PSNR goes through the delta method.
        """
        ours, theirs = self._values(method, metric), self._values(over, metric)  # (P, F)
        if metric == "psnr":
            with np.errstate(divide="ignore", invalid="ignore"):
                share_of_error = theirs / theirs.mean(0) - ours / ours.mean(0)
                difference = _decibels(ours.mean(0)) - _decibels(theirs.mean(0))
                deviations = 10 / math.log(10) * share_of_error
        else:
            gains = METRICS[metric].better * (ours - theirs)
            difference = gains.mean(0)
            deviations = gains - difference
        return np.stack([difference, _half_width(deviations, self.shapes)], 1)

    def table(self, metric: str = "ssim") -> str:
        """Return `mean` of all methods as a markdown table, the best of each column bold."""
        _, _, digits, better, _ = self._metric(metric)
        means = np.array([self.mean(method, metric) for method in self.scores])  # (M, F)
        best = (better * means).max(0) * better
        rows = []
        for method, row in zip(self.scores, means, strict=True):
            bold = ["**" if mean == top else "" for mean, top in zip(row, best, strict=True)]
            rows.append([method, *(f"{mark}{_text(mean, digits)}{mark}" for mean, mark in zip(row, bold, strict=True))])
        return self._markdown(rows)

    def gain_table(self, method: str, metric: str = "ssim") -> str:
        """Return a method's gain over each other one that keeps the traced pixels as a markdown table."""
        digits = self._metric(metric).digits
        others = [name for name in self.scores if name != method and name not in map(raw, self.models)]
        return self._markdown(
            [
                [f"over {name}", *(f"{_text(mean, digits, '+')} ± {_text(half, digits)}" for mean, half in gains)]
                for name, gains in ((name, self.gain(method, name, metric)) for name in others)
            ]
        )

    def csv(self) -> str:
        """Return all scores as CSV, a row for each method, picture and share of traced pixels.

        The columns: method, shape, picture, fraction, ssim, psnr, flip; PSNR may be inf.
        """
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["method", "shape", "picture", "fraction", *METRICS])
        for method, scores in self.scores.items():
            for shape, picture, by_fraction in zip(self.shapes, self.pictures, scores.tolist(), strict=True):
                for fraction, row in zip(self.fractions, by_fraction, strict=True):
                    writer.writerow([method, shape, picture, fraction, *row])
        return text.getvalue()

    @classmethod
    def from_csv(cls, text: str) -> Evaluation:
        """Return the evaluation whose `csv` this is.

        Raises
        ------
        InputError
            If it isn't one's.
        """
        scores: dict[str, dict[tuple[str, str], dict[float, list[float]]]] = {}
        try:
            for row in csv.DictReader(io.StringIO(text)):
                by_fraction = scores.setdefault(row["method"], {}).setdefault((row["shape"], row["picture"]), {})
                by_fraction[float(row["fraction"])] = [float(row[metric]) for metric in METRICS]
            by_picture = next(iter(scores.values()))
            arrays = {
                method: np.array([[scores[method][key][f] for f in fractions] for key, fractions in by_picture.items()])
                for method in scores
            }
        except (KeyError, ValueError, StopIteration) as error:
            raise InputError(f"text: expected the scores of an evaluation, got {error!r}") from error
        shapes, pictures = zip(*by_picture, strict=True)
        fractions = tuple(next(iter(by_picture.values())))
        models = tuple(name.removesuffix(" raw") for name in scores if name.endswith(" raw"))
        return cls(pictures, shapes, fractions, models, arrays)

    def beside(self, other: Evaluation) -> Evaluation:
        """Return these methods and, after them, another evaluation's of the same pictures.

        Raises
        ------
        InputError
            If it is of other pictures or shares of traced pixels.
        """
        if (self.shapes, self.pictures, self.fractions) != (other.shapes, other.pictures, other.fractions):
            raise InputError("other: expected an evaluation of the same pictures at the same fractions, got another")
        scores = {**self.scores, **other.scores}
        return Evaluation(self.pictures, self.shapes, self.fractions, self.models + other.models, scores)

    def __str__(self) -> str:
        parts = [f"Means over {len(self.pictures):,} pictures of {len(set(self.shapes)):,} shapes."]
        for metric, (label, *_) in METRICS.items():
            parts += [f"{label}:", self.table(metric)]
            if metric == "ssim" and len(self.scores) > 2:
                for model in self.models:
                    parts += [
                        f"Gain of {kept(model)} in SSIM, with 95 % confidence intervals over shapes:",
                        self.gain_table(kept(model)),
                    ]
        return "\n\n".join(parts)

    def _values(self, method: str, metric: str) -> NDArray[np.float64]:
        """What is averaged over pictures, (P, F): SSIM, FLIP, or the mean squared error that a PSNR stands for."""
        self._metric(metric)
        if method not in self.scores:
            raise InputError(f"method: expected one of {', '.join(self.scores)}, got {method!r}")
        values = self.scores[method][..., list(METRICS).index(metric)]
        return 10 ** (-values / 10) if metric == "psnr" else values

    def _metric(self, name: str) -> Metric:
        if name not in METRICS:
            raise InputError(f"metric: expected one of {', '.join(METRICS)}, got {name!r}")
        return METRICS[name]

    def _markdown(self, rows: Sequence[Sequence[str]]) -> str:
        return table(["traced", *(f"{100 * fraction:g} %" for fraction in self.fractions)], rows)


def raw(model: str) -> str:
    """The method of a model's own output, its traced pixels repainted."""
    return f"{model} raw"


def kept(model: str) -> str:
    """The method of a model's output with the traced pixels as they came in."""
    return f"{model} kept"


def _decibels(error: NDArray[np.float64]) -> NDArray[np.float64]:
    with np.errstate(divide="ignore"):
        return np.asarray(-10 * np.log10(error))


def _half_width(deviations: NDArray[np.float64], shapes: Sequence[str]) -> NDArray[np.float64]:
    """Half of the 95 % confidence interval of a mean, (F,), from deviations from it, (P, F), in clusters by shape."""
    from scipy.special import stdtrit

    names, cluster = np.unique(shapes, return_inverse=True)
    count = len(names)
    if count < 2:
        return np.full(deviations.shape[1], np.nan)
    sums = np.zeros((count, deviations.shape[1]))
    np.add.at(sums, cluster, deviations)
    error = np.sqrt(count / (count - 1) * (sums**2).sum(0)) / len(deviations)
    return np.asarray(stdtrit(count - 1, 0.975) * error)  # Student's t


def _text(number: float, digits: int, sign: str = "") -> str:
    if math.isnan(number):
        return "–"
    return "∞" if number == math.inf else f"{number:{sign}.{digits}f}"
