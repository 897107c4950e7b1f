"""How good weights are on models: mean SSIM and PSNR by fraction, beside fillings without a network."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import bobrossnet as bob
from bobrossnet.adapters.files import ENDINGS, load_mesh
from bobrossnet.complete.filling import FILLINGS
from bobrossnet.errors import InputError
from bobrossnet.metrics import psnr, ssim

FRACTIONS = (0.01, 0.02, 0.05, 0.10, 0.25, 0.50, 0.75)
BROKEN = "broken_odd"  # a folder of models that are wrong on purpose


@dataclass(frozen=True)
class Evaluation:
    """Scores of several methods on the same partial pictures; traced pixels are kept by all of them.

    Attributes
    ----------
    pictures : names of the pictures, (P,)
    fractions : shares of traced pixels, (F,)
    ssim : by method, (P, F) float64, of at most 1
    psnr : by method, (P, F) float64, in dB
    """

    pictures: list[str]
    fractions: tuple[float, ...]
    ssim: dict[str, np.ndarray] = field(repr=False)
    psnr: dict[str, np.ndarray] = field(repr=False)

    def table(self, metric: str = "ssim") -> str:
        """Return the means over the pictures as a markdown table, the best of each column bold."""
        means = {name: np.mean(scores, 0) for name, scores in getattr(self, metric).items()}
        best = np.max(list(means.values()), 0)
        digits = 4 if metric == "ssim" else 2
        lines = [
            "| " + " | ".join(["traced", *(f"{100 * fraction:g} %" for fraction in self.fractions)]) + " |",
            "|" + "---|" * (len(self.fractions) + 1),
        ]
        for name, row in means.items():
            cells = [f"{mean:.{digits}f}" for mean in row]
            cells = [f"**{cell}**" if mean == top else cell for cell, mean, top in zip(cells, row, best, strict=True)]
            lines.append("| " + " | ".join([name, *cells]) + " |")
        return "\n".join(lines)


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
    """
    unknown = [name for name in fillings if name not in FILLINGS]
    if unknown:
        raise InputError(f"fillings: expected some of {', '.join(FILLINGS)}, got {unknown[0]!r}")
    paths = mesh_files(folder)
    if limit is not None and limit < len(paths):
        paths = [paths[int(i)] for i in np.linspace(0, len(paths) - 1, limit)]

    pictures: list[str] = []
    rows: list[dict[str, list[tuple[float, float]]]] = []
    for number, path in enumerate(paths):
        name = path.relative_to(folder).as_posix()
        try:
            scene = bob.Scene([load_mesh(path)])
        except InputError as error:
            report(f"left out: {error}")
            continue
        for view in range(views):
            camera = bob.Camera(azimuth=(30 * number + 360 * view / views) % 360, elevation=(20, 45)[view % 2])
            full = bob.trace(scene, camera, size=size)
            rows.append(score(full, model, fractions, order, number * views + view, fillings))
            pictures.append(f"{name} view {view}")
        if (number + 1) % 25 == 0:
            report(f"evaluated {number + 1}/{len(paths)} files")
    if not rows:
        raise InputError(f"{folder}: expected mesh files ({', '.join(ENDINGS)}), got none that could be loaded")

    methods = rows[0]
    scores = {method: np.array([row[method] for row in rows]) for method in methods}  # (P, F, 2)
    return Evaluation(
        pictures,
        tuple(fractions),
        {method: values[..., 0] for method, values in scores.items()},
        {method: values[..., 1] for method, values in scores.items()},
    )


def score(
    full: bob.GBuffer,
    model: str | os.PathLike[str],
    fractions: Sequence[float],
    order: str,
    seed: int,
    fillings: Sequence[str],
) -> dict[str, list[tuple[float, float]]]:
    """Return (SSIM, PSNR) by method and fraction of one picture, completed from its own pixels."""
    label = Path(model).stem
    scores: dict[str, list[tuple[float, float]]] = {name: [] for name in (label, *fillings)}
    for fraction in fractions:
        part = full.sample(fraction, order=order, seed=seed)
        images: Mapping[str, np.ndarray] = {
            label: bob.complete(part, model=model),
            **{name: FILLINGS[name](part.gray, part.mask) for name in fillings},
        }
        for name, image in images.items():
            scores[name].append((ssim(image, full.gray), psnr(image, full.gray)))
    return scores


def mesh_files(folder: str | os.PathLike[str]) -> list[Path]:
    """Return the mesh files below a folder, sorted; those in a folder named `broken_odd` are left out."""
    found = [path for path in Path(folder).rglob("*") if path.suffix.lower() in ENDINGS]
    return sorted(path for path in found if BROKEN not in path.parts)
