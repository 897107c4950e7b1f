"""How good models are: SSIM, PSNR and FLIP by share of traced pixels, beside fillings without a network.

A model stands in the results twice: NAME raw is its network's own output clamped to 0..1, which repaints the traced
pixels; NAME kept is what `bobrossnet.complete` returns, with the traced pixels as they came in. The fillings keep them
as well. Letters: M methods, P pictures, F shares of traced pixels.
"""

from __future__ import annotations

import csv
import io
import math
import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.adapters.files import ALL_ENDINGS
from bobrossnet.complete.filling import FILLINGS
from bobrossnet.complete.model import Model, load_model
from bobrossnet.errors import InputError, InputWarning, check_integer, check_number
from bobrossnet.learn.dataset.plan import PATCH, PATCHES, STAGES, Plan
from bobrossnet.learn.dataset.store import Dataset
from bobrossnet.learn.models import model_files, spread
from bobrossnet.metrics import WINDOW, flip, psnr, ssim
from bobrossnet.progress import progress
from bobrossnet.render.order import check_order, check_size

FRACTIONS = (0.01, 0.02, 0.05, 0.10, 0.25, 0.50, 0.75, 1.0)


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
        """A table whose columns are aligned in plain text, too."""
        heading = ["traced", *(f"{100 * fraction:g} %" for fraction in self.fractions)]
        first, *others = (max(map(len, column)) for column in zip(heading, *rows, strict=True))
        rule = ["-" * first, *("-" * (width - 1) + ":" for width in others)]
        return "\n".join(
            "| " + " | ".join([name.ljust(first), *(c.rjust(w) for c, w in zip(cells, others, strict=True))]) + " |"
            for name, *cells in (heading, rule, *rows)
        )


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


# ---- What is measured on ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Picture:
    name: str
    shape: str
    gray: NDArray[np.float32]  # (H, W), the reference
    part: Callable[[float], bob.GBuffer]  # by the share of its pixels that is traced
    done: float  # how much of all work is done when this is, 0..1


def evaluate_dataset(
    path: str | os.PathLike[str] | Dataset,
    models: Sequence[str | os.PathLike[str]] = ("default",),
    *,
    fractions: Sequence[float] = FRACTIONS,
    order: str = "uniform",
    fillings: Sequence[str] = tuple(FILLINGS),
    limit: int | None = None,
) -> Evaluation:
    """Measure models on a data set's test split: every patch of its shapes, at each share of traced pixels.

    Parameters
    ----------
    path : a data set's folder, or the data set
    models : names of shipped weights, or .safetensors files
        Called by their stems in the result.
    fractions : shares of traced pixels, each above 0
        At the data set's own stages, 1, 25, 50, 75 and 100 %, exactly its samples are measured, 1,050 of ten shapes; at
        others, the pixels come from the order of the patch's sample at 1 %, so that they contain those.
    order : pixel order
    fillings : names in `FILLINGS` to compare with
    limit : how many shapes at most, spread evenly over the split, optional

    Returns
    -------
    Evaluation

    Raises
    ------
    InputError
        If an argument can't be used, or the data set is not complete.
    """
    dataset = path if isinstance(path, Dataset) else Dataset.open(path)
    check_order(order, 0)
    # A patch's samples at the stages, shape by shape.
    numbers = dataset.plan.split("test").reshape(-1, PATCHES, len(STAGES))
    return _evaluate(_pictures_of_dataset(dataset, spread(list(numbers), limit), order), models, fractions, fillings)


def evaluate_folder(
    folder: str | os.PathLike[str],
    models: Sequence[str | os.PathLike[str]] = ("default",),
    *,
    size: tuple[int, int] = (256, 256),
    views: int = 1,
    fractions: Sequence[float] = FRACTIONS,
    order: str = "uniform",
    fillings: Sequence[str] = tuple(FILLINGS),
    limit: int | None = None,
) -> Evaluation:
    """Measure models on views of every file below a folder that `bobrossnet.load` reads.

    Parameters
    ----------
    folder : path
        Searched in depth, in the order of the names, but for folders called `broken_odd`.
    models, fractions, fillings : as in `evaluate_dataset`
    size : (height, width)
        Of at least 11 each.
    views : pictures of each file
        Azimuths spread round it, 30° apart from one file to the next; elevations 20° and 45° in turn.
    order : pixel order
        Its seed is the picture's number.
    limit : how many files at most, spread evenly over all, optional

    Returns
    -------
    Evaluation

    Raises
    ------
    InputError
        If an argument can't be used, or no file below the folder can be loaded.

    Warns
    -----
    InputWarning
        If a file was left out because it can't be loaded.
    """
    if min(check_size(size)) < WINDOW:
        raise InputError(f"size: expected at least {WINDOW}x{WINDOW} pixels, the SSIM window, got {tuple(size)}")
    check_order(order, 0)
    check_integer("views", views, 1, 1000)
    files = spread(model_files(folder), limit)
    pictures = _pictures_of_folder(Path(folder), files, size, views, order)
    result = _evaluate(pictures, models, fractions, fillings)
    if not result.pictures:
        raise InputError(f"{folder}: expected files of shapes ({' '.join(ALL_ENDINGS)}), got none that could be loaded")
    return result


def _pictures_of_dataset(dataset: Dataset, numbers: Sequence[NDArray[np.int64]], order: str) -> Iterator[_Picture]:
    """Pictures of the samples `numbers`, (PATCHES, STAGES) of each shape."""
    for k, of_shape in enumerate(numbers):
        shape = dataset.plan.sample(int(of_shape[0, 0])).shape
        for i, (patch, of_patch) in enumerate(zip(dataset.patches(shape), of_shape.tolist(), strict=True)):
            _, size, row, column, _ = dataset.plan.sample(of_patch[0])
            whole = patch.astype(np.float32)
            yield _Picture(
                name=f"{size}x{size} row {row} column {column}",
                shape=dataset.sources[shape],
                gray=whole[0],
                part=partial(_part_of_patch, dataset.plan, of_patch, whole, order),
                done=(k + (i + 1) / PATCHES) / len(numbers),
            )


def _part_of_patch(
    plan: Plan, numbers: Sequence[int], whole: NDArray[np.float32], order: str, fraction: float
) -> bob.GBuffer:
    """A patch's sample, of `numbers` by stage."""
    number = numbers[STAGES.index(fraction) if fraction in STAGES else 0]
    planes = np.empty((1 + len(whole), PATCH, PATCH), np.float32)
    planes[0] = plan.mask(number, fraction, order=order)
    np.multiply(whole, planes[0], out=planes[1:])
    return bob.GBuffer.from_stack(planes)


def _pictures_of_folder(
    folder: Path, files: Sequence[Path], size: tuple[int, int], views: int, order: str
) -> Iterator[_Picture]:
    for number, path in enumerate(files):
        try:
            scene = bob.load(path)
        except InputError as error:
            warnings.warn(f"left out: {error}", InputWarning, stacklevel=4)  # at the call of evaluate_folder
            continue
        for view in range(views):
            camera = bob.Camera(azimuth=(30 * number + 360 * view / views) % 360, elevation=(20, 45)[view % 2])
            full = bob.trace(scene, camera, size=size)
            yield _Picture(
                name=f"view {view}",
                shape=path.relative_to(folder).as_posix(),
                gray=full.gray,
                part=partial(full.sample, order=order, seed=number * views + view),
                done=(number + (view + 1) / views) / len(files),
            )


# ---- Measuring -------------------------------------------------------------------------------------------


def _evaluate(
    pictures: Iterable[_Picture],
    models: Sequence[str | os.PathLike[str]],
    fractions: Sequence[float],
    fillings: Sequence[str],
) -> Evaluation:
    """Measure models and fillings on pictures, one picture in memory at a time."""
    for name in fillings:
        if name not in FILLINGS:
            raise InputError(f"fillings: expected some of {', '.join(FILLINGS)}, got {name!r}")
    fractions = tuple(check_number("fractions", fraction, 0, 1, above=True) for fraction in fractions)
    if not fractions:
        raise InputError("fractions: expected at least one share of the pixels, got none")
    names = tuple(Path(model).stem for model in models)
    if len(set(names)) < len(names):
        raise InputError(f"models: expected each of another name, got {', '.join(names)}")
    if not (names or fillings):
        raise InputError("models: expected one or more, or fillings, got neither")
    networks = [load_model(model) for model in models]

    names_of_pictures, shapes = [], []
    scores: list[NDArray[np.float64]] = []  # of each picture
    with progress("evaluating") as report:
        for picture in pictures:
            scores.append(_score(picture, networks, fractions, fillings))
            names_of_pictures.append(picture.name)
            shapes.append(picture.shape)
            report(picture.done, picture.shape)

    methods = [method for name in names for method in (raw(name), kept(name))] + list(fillings)
    by_picture = np.reshape(scores, (-1, len(methods), len(fractions), len(METRICS)))
    by_method = dict(zip(methods, np.moveaxis(by_picture, 1, 0), strict=True))
    return Evaluation(tuple(names_of_pictures), tuple(shapes), fractions, names, by_method)


def _score(
    picture: _Picture, networks: Sequence[Model], fractions: Sequence[float], fillings: Sequence[str]
) -> NDArray[np.float64]:
    """The scores of one picture, (M, F, 3): each network raw and kept, then each filling."""
    scores = np.empty((2 * len(networks) + len(fillings), len(fractions), len(METRICS)))
    for f, fraction in enumerate(fractions):
        part = picture.part(fraction)
        images = []
        for network in networks:
            images += [np.clip(network.predict(part), 0, 1), bob.complete(part, model=network)]
        images += [FILLINGS[name](part.gray, part.mask) for name in fillings]
        for m, image in enumerate(images):
            # Often: background, and whatever is traced wholly and kept.
            exact = np.array_equal(image, picture.gray)
            scores[m, f] = [
                metric.best if exact else metric.measure(image, picture.gray) for metric in METRICS.values()
            ]
    return scores
