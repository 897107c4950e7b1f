"""How good weights are on models: mean SSIM and PSNR by fraction, beside fillings without a network.

Letters: M methods, the model before the fillings, P pictures, F fractions of traced pixels.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.adapters.files import ENDINGS, load_mesh
from bobrossnet.complete.filling import FILLINGS
from bobrossnet.complete.model import Model, load_model
from bobrossnet.errors import InputError, check_integer, check_number
from bobrossnet.metrics import WINDOW, psnr, ssim
from bobrossnet.render.order import check_order, check_size

FRACTIONS = (0.01, 0.02, 0.05, 0.10, 0.25, 0.50, 0.75)
BROKEN = "broken_odd"  # a folder of models that are wrong on purpose
METRICS = {"ssim": 4, "psnr": 2}  # in the order of the scores, and with how many digits


@dataclass(frozen=True)
class Evaluation:
    """Scores of several methods on the same partial pictures; traced pixels are kept by all of them.

    `str()` of it is all that there is to print.

    Attributes
    ----------
    pictures : names of the pictures, (P,)
    fractions : shares of traced pixels, (F,)
    scores : by method, the model first: (P, F, 2) float64
        SSIM, of at most 1, and PSNR in dB.
    """

    pictures: tuple[str, ...]
    fractions: tuple[float, ...]
    scores: Mapping[str, NDArray[np.float64]] = field(repr=False)

    def gain(self, over: str) -> NDArray[np.float64]:
        """Return by how much the model's SSIM is above a filling's, from the differences picture by picture.

        Parameters
        ----------
        over : name of the filling

        Returns
        -------
        (F, 2) float64
            Mean difference over the pictures, and half the width of its 95 % confidence interval: 1.96 standard
            errors, as for a few dozen independent pictures or more; NaN for a single picture.
        """
        model, *fillings = self.scores
        if over not in fillings:
            raise InputError(f"over: expected one of {', '.join(fillings)}, got {over!r}")
        difference = self.scores[model][..., 0] - self.scores[over][..., 0]  # (P, F)
        count = len(difference)
        deviation = difference.std(0, ddof=1) if count > 1 else np.full(len(self.fractions), np.nan)
        return np.stack([difference.mean(0), 1.96 * deviation / math.sqrt(count)], 1)

    def table(self, metric: str = "ssim") -> str:
        """Return the means over the pictures as a markdown table, the best of each column bold."""
        index, digits = list(METRICS).index(metric), METRICS[metric]
        means = np.array([scores[..., index].mean(0) for scores in self.scores.values()])  # (M, F)
        rows = []
        for name, row in zip(self.scores, means, strict=True):
            bold = ["**" if mean == best else "" for mean, best in zip(row, means.max(0), strict=True)]
            rows.append([name, *(f"{mark}{mean:.{digits}f}{mark}" for mean, mark in zip(row, bold, strict=True))])
        return self._markdown(rows)

    def gain_table(self) -> str:
        """Return the model's gain over each filling as a markdown table."""
        _, *fillings = self.scores
        return self._markdown(
            [[f"over {name}", *(f"{mean:+.4f} ± {half:.4f}" for mean, half in self.gain(name))] for name in fillings]
        )

    def __str__(self) -> str:
        model, *fillings = self.scores
        parts = {"SSIM": self.table("ssim")}
        if fillings:
            parts[f"Gain of {model} in SSIM, mean and 95 % confidence interval over pictures"] = self.gain_table()
        parts["PSNR, dB"] = self.table("psnr")
        return "\n\n".join(f"{title}\n\n{table}" for title, table in parts.items())

    def _markdown(self, rows: Sequence[Sequence[str]]) -> str:
        heading = ["traced", *(f"{100 * fraction:g} %" for fraction in self.fractions)]
        rule = ["---"] * len(heading)
        return "\n".join("| " + " | ".join(cells) + " |" for cells in (heading, rule, *rows))


def evaluate(
    model: str | os.PathLike[str],
    folder: str | os.PathLike[str],
    *,
    views: int = 2,
    size: tuple[int, int] = (256, 256),
    fractions: Sequence[float] = FRACTIONS,
    order: str = "uniform",
    fillings: Sequence[str] = tuple(FILLINGS),
    limit: int | None = None,
    report: Callable[[str], object] = print,
) -> Evaluation:
    """Measure weights on every mesh file below a folder.

    Parameters
    ----------
    model : name of shipped weights, or a .safetensors file
        Called by its stem in the result, or "model STEM" if a filling is called so.
    folder : path
        Searched in depth, in the order of the names; files that can't be loaded are reported and left out.
    views : pictures of each mesh
        Azimuths spread round it, 30° apart from one mesh to the next; elevations 20° and 45° in turn.
    size : (height, width)
        Of at least 11 each.
    fractions : shares of traced pixels, each above 0
    order : pixel order
        Its seed is the picture's number.
    fillings : names in `FILLINGS` to compare with
    limit : how many meshes at most, spread evenly over the files, optional
    report : function of one line
        Told how it goes.

    Returns
    -------
    Evaluation

    Raises
    ------
    InputError
        If an argument can't be used, or no file below the folder can be loaded.
    """
    for name in fillings:
        if name not in FILLINGS:
            raise InputError(f"fillings: expected some of {', '.join(FILLINGS)}, got {name!r}")
    fractions = tuple(check_number("fractions", fraction, 0, 1, above=True) for fraction in fractions)
    if not fractions:
        raise InputError("fractions: expected at least one share of the pixels, got none")
    if min(check_size(size)) < WINDOW:
        raise InputError(f"size: expected at least {WINDOW}x{WINDOW} pixels, the SSIM window, got {tuple(size)}")
    check_order(order, 0)
    check_integer("views", views, 1, 1000)
    network = load_model(model)
    paths = mesh_files(folder)
    if limit is not None and check_integer("limit", limit, 1, 2**31 - 1) < len(paths):
        paths = [paths[int(i)] for i in np.linspace(0, len(paths) - 1, limit)]

    pictures: list[str] = []
    scores: list[NDArray[np.float64]] = []  # of each picture
    for number, path in enumerate(paths):
        try:
            scene = bob.Scene([load_mesh(path)])
        except InputError as error:
            report(f"left out: {error}")
        else:
            for view in range(views):
                camera = bob.Camera(azimuth=(30 * number + 360 * view / views) % 360, elevation=(20, 45)[view % 2])
                full = bob.trace(scene, camera, size=size)
                seed = number * views + view
                scores.append(score(full, network, fractions=fractions, order=order, seed=seed, fillings=fillings))
                pictures.append(f"{path.relative_to(folder).as_posix()} view {view}")
        if (number + 1) % 25 == 0:
            report(f"evaluated {number + 1}/{len(paths)} files")
    if not scores:
        raise InputError(f"{folder}: expected mesh files ({', '.join(ENDINGS)}), got none that could be loaded")

    stem = Path(model).stem
    methods = [f"model {stem}" if stem in fillings else stem, *fillings]
    return Evaluation(tuple(pictures), fractions, dict(zip(methods, np.stack(scores, 1), strict=True)))


def score(
    full: bob.GBuffer,
    model: Model,
    *,
    fractions: Sequence[float],
    order: str,
    seed: int,
    fillings: Sequence[str],
) -> NDArray[np.float64]:
    """Return SSIM and PSNR of one picture, completed from its own pixels by the model, then by each filling.

    Parameters
    ----------
    full : GBuffer, every pixel traced
    model, fractions, order, fillings : as in `evaluate`, the model loaded
    seed : of the order

    Returns
    -------
    (M, F, 2) float64
    """
    scores = np.empty((1 + len(fillings), len(fractions), 2))
    for f, fraction in enumerate(fractions):
        part = full.sample(fraction, order=order, seed=seed)
        images = [bob.complete(part, model=model), *(FILLINGS[name](part.gray, part.mask) for name in fillings)]
        scores[:, f] = [(ssim(image, full.gray), psnr(image, full.gray)) for image in images]
    return scores


def mesh_files(folder: str | os.PathLike[str]) -> list[Path]:
    """Return the mesh files below a folder, sorted; those in a folder named `broken_odd` below it are left out."""
    found = [path for path in Path(folder).rglob("*") if path.suffix.lower() in ENDINGS]
    return sorted(path for path in found if BROKEN not in path.relative_to(folder).parts)
