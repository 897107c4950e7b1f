"""Reproduce the report: build the data set, train, evaluate, draw, and write docs/report.md with both results.

    python docs/report.py [--scale small] [--shapes FOLDER] [--work DIR]

DIR keeps finished steps, so that an interrupted run resumes. The small scale takes 10 minutes on two cores with few
shapes and epochs, and writes its page to DIR, not to docs/.
"""

from __future__ import annotations

import argparse
import csv
import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from limits import section
from work import MODELS, ROOT, Work

import bobrossnet as bob
from bobrossnet.learn import reference
from bobrossnet.learn.config import TrainConfig
from bobrossnet.learn.dataset.build import build
from bobrossnet.learn.dataset.plan import PATCHES, SHAPES, STAGES, TEST_SHAPES
from bobrossnet.learn.dataset.statistics import Comparison, compare_with_folder
from bobrossnet.learn.dataset.store import Dataset
from bobrossnet.learn.evaluation.evaluate import evaluate_dataset, evaluate_folder
from bobrossnet.learn.evaluation.methods import kept, raw
from bobrossnet.learn.evaluation.scenes import each_scene, scenes_of_folder
from bobrossnet.learn.evaluation.scores import Evaluation
from bobrossnet.learn.figures import FIGURES, Sources, draw_figures
from bobrossnet.learn.figures.losses import UNSEEN, loss_title
from bobrossnet.learn.train import LOG, WEIGHTS, train
from bobrossnet.support.atomic import write_whole
from bobrossnet.support.tables import table

NAME = "paper"  # name of the network in evaluations
SCAN = "scans/armadillo.ply"  # of the Stanford Computer Graphics Laboratory, as the report's dragon is; y is up
SCAN_CAMERA = bob.Camera(azimuth=70, elevation=12)
USES = {"train": "training", "validation": "validation", "test": "testing"}
PICTURES = ("2.1", "5.1", "5.2", "6.3", "6.4")  # mostly pixels: SVG would be no sharper, at five megabytes
SAME = 0.01  # difference of SSIM below which networks trained on 50 samples are equal
VERSIONS = ("bobrossnet", "numpy", "torch", "lightning-fabric", "zarr")


@dataclass(frozen=True)
class Scale:
    """Sizes and counts of a run."""

    shapes: int = SHAPES
    test_shapes: int = TEST_SHAPES
    config: TrainConfig = field(default_factory=TrainConfig)
    real: int | None = None  # maximum of shapes by other people; None: all
    figures: dict[str, Any] = field(default_factory=dict)  # fields of `Sources`


SCALES = {
    "full": Scale(),
    "small": Scale(24, 4, TrainConfig(epochs=3), 12, {"steps": 20, "frames": 12}),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scale", choices=SCALES, default="full")
    parser.add_argument("--shapes", type=Path, default=MODELS, help="folder of real shapes to measure on as well")
    parser.add_argument("--work", type=Path, help="folder for data, weights and scores (default: out/report, -small)")
    options = parser.parse_args()
    small = options.scale == "small"
    scale = SCALES[options.scale]
    work = Work(options.work or ROOT / "out" / ("report-small" if small else "report"))
    docs = work.folder if small else ROOT / "docs"
    shapes = options.shapes if options.shapes.is_dir() else None

    with work.timed("data set"):
        dataset = build(work.folder / "data", shapes=scale.shapes, test_shapes=scale.test_shapes)
    run = work.folder / "paper"
    with work.timed("training"):
        train(scale.config, dataset, run)
    weights = work.folder / f"{NAME}.safetensors"
    write_whole(weights, (run / WEIGHTS).read_bytes())
    with work.timed("evaluation"):
        own = beside_fillings(work.folder / "test-fillings.csv", partial(evaluate_dataset, dataset), weights)
        scores = work.folder / "scores.csv"
        write_whole(scores, own.csv().encode())
        real, comparison = None, None
        if shapes:
            measure = partial(evaluate_folder, shapes, limit=scale.real)
            real = beside_fillings(work.folder / "real-fillings.csv", measure, weights)
            comparison = compare_with_folder(dataset, shapes, limit=scale.real)
    with work.timed("figures"):
        sources = Sources(weights=str(weights), data=dataset, scores=scores, **scale.figures)
        scan = shapes / SCAN if shapes and (shapes / SCAN).exists() else None
        if scan:
            sources = replace(sources, scene=bob.load(scan).turned_upright(), camera=SCAN_CAMERA)
        captions = draw(docs / "report", sources, work.folder / "captions.json")
    limits = []
    if shapes:
        less = {"epochs": 1, "limit": 2} if small else {}
        limits = section(work, dataset, weights, shapes, **less)
    parts = [
        *heading(options.scale, work),
        *data_set(dataset, comparison),
        *training(scale.config, run),
        *test_split(own, dataset),
        *real_shapes(real, white_shapes(shapes) if shapes else set()),
        *limits,
        *losses(docs / "report" / "figure-5.1.csv"),
        *figures(captions, scan is not None),
    ]
    (docs / "report.md").write_text("\n\n".join(parts) + "\n", "utf-8")
    print(f"wrote {docs / 'report.md'}")


def beside_fillings(path: Path, measure: Callable[..., Evaluation], weights: Path) -> Evaluation:
    """Measure weights and fillings. The scores of the fillings, which take longest, are kept in a file."""
    if not path.exists():
        write_whole(path, measure([]).csv().encode())
    return measure([weights], fillings=[]).beside(Evaluation.from_csv(path.read_text("utf-8")))


def draw(folder: Path, sources: Sources, captions_file: Path) -> dict[str, str]:
    """Draw the figures and return their captions.

    The figure of the losses trains five networks and depends on the data alone, so it is drawn once.
    """
    captions: dict[str, str] = json.loads(captions_file.read_text("utf-8")) if captions_file.exists() else {}
    done = {"5.1"} & captions.keys()
    captions |= draw_figures(folder, sources, only=[name for name in FIGURES if name not in done])
    for name in PICTURES:
        (folder / f"figure-{name}.svg").unlink(missing_ok=True)
    captions_file.write_text(json.dumps(captions, indent=2) + "\n", "utf-8")
    return {name: captions[name] for name in FIGURES if name in captions}


def heading(scale: str, work: Work) -> list[str]:
    return [
        "# The report, reproduced",
        "This page repeats *Accelerating rendering by partial inpainting: BobRossNet* (2019) with this package: data "
        "set, training, results and figures, on shapes that the package makes itself. "
        f"`make report{' SCALE=small' * (scale == 'small')}` wrote it.",
        *work.circumstances(VERSIONS),
    ]


def data_set(dataset: Dataset, comparison: Comparison | None) -> list[str]:
    plan = dataset.plan
    counts = ", ".join(f"{len(plan.split(name)):,} for {use}" for name, use in USES.items())
    size = sum(file.stat().st_size for file in dataset.path.rglob("*") if file.is_file()) / 1e6
    parts = [
        "## The data set",
        f"`bobrossnet dataset build DIR` writes {plan.samples:,} samples, {counts}, in {size:.0f} MB.",
        f"Each of the {plan.shapes} shapes is seen from three directions at 128², 256² and 512² and cut into 21 "
        "patches. A patch is sampled at 1, 25, 50, 75 and 100 % of its pixels. "
        f"{plan.test_shapes} shapes are for testing only.",
        "![samples](report/figure-5.2.png)",
    ]
    if comparison is not None:
        parts += ["### Compared with real shapes", str(comparison)]
    return parts


def training(config: TrainConfig, run: Path) -> list[str]:
    with (run / LOG).open(newline="", encoding="utf-8") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    best = max(rows, key=lambda row: row["ssim"])
    minutes = sum(row["seconds"] for row in rows) / 60
    done = len(rows) == config.epochs or len(rows) - best["epoch"] >= config.patience
    return [
        "## Training",
        f"`bobrossnet train DIR RUN` took {minutes:.0f} minutes for {len(rows)} epochs, {minutes / len(rows):.1f} "
        f"each. The best in validation is epoch {best['epoch']:.0f}."
        + ("" if done else " **It was stopped there, while it was still improving.**"),
        f"The loss is {config.loss.upper().replace('+', ' + ')} of the network's raw output at every pixel. AdaDelta "
        f"(rate 1, ρ 0.95, ε 1e-6) minimises it over mini-batches of {config.batch} in float32.",
        table(
            ["epoch", "loss", "in validation", *(f"SSIM {100 * stage:g} %" for stage in STAGES)],
            [
                [f"{row['epoch']:.0f}", f"{row['training_loss']:.4f}", f"{row['validation_loss']:.4f}"]
                + [f"{row[f'ssim_{100 * stage:g}']:.4f}" for stage in STAGES]
                for row in rows
            ],
        ),
    ]


def test_split(own: Evaluation, dataset: Dataset) -> list[str]:
    at = [own.fractions.index(stage) for stage in STAGES]
    ours = own.mean(raw(NAME))[at]
    rows = [
        ["the report", *(f"{value:.4f}" for value in reference.SSIM.values())],
        ["ours", *(f"{value:.4f}" for value in ours)],
        ["difference", *(f"{a - b:+.4f}" for a, b in zip(ours, reference.SSIM.values(), strict=True))],
        ["ours, traced pixels kept", *(f"{value:.4f}" for value in own.mean(kept(NAME))[at])],
    ]
    short = [f"{100 * s:g} %" for s, mean in zip(STAGES, ours, strict=True) if mean < reference.SSIM[s]]
    verdict = f"Ours is below the report at {', '.join(short)}." if short else "Ours is at no stage below the report."
    return [
        "## Results on the test samples",
        f"{verdict} Mean SSIM over {len(own.pictures) * len(STAGES):,} samples of the test shapes, of the network's "
        "raw output, which repaints traced pixels too.",
        table(["pixels traced", *(f"{100 * stage:g} %" for stage in STAGES)], rows),
        *by_detail(own, dataset),
        "All test samples at more shares of traced pixels, with other fillings:",
        str(own),
    ]


def by_detail(own: Evaluation, dataset: Dataset) -> list[str]:
    """How the results depend on the detail of the patches: thirds of the test split."""
    test = dataset.plan.split("test").reshape(-1, PATCHES, len(STAGES))
    shapes = [dataset.plan.sample(int(numbers[0, 0])).shape for numbers in test]
    gray = np.concatenate([dataset.patches(shape)[:, 0] for shape in shapes]).astype(np.float64)
    detail = sum((np.diff(gray, axis=axis) ** 2).sum((1, 2)) for axis in (1, 2)) / gray[0].size
    at = [own.fractions.index(stage) for stage in STAGES]
    rows = []
    for which, third in zip(("least", "middle", "most"), np.array_split(np.argsort(detail), 3), strict=True):
        for method in (raw(NAME), "delaunay-linear"):
            means = own.scores[method, own.orders[0]][third][:, at, 0].mean(0)
            rows.append([f"{which}, {detail[third].mean():.4f}", method, *(f"{mean:.4f}" for mean in means)])
    rows.sort(key=lambda row: row[1], reverse=True)
    return [
        "The scores depend on the shapes. Below, the patches are in thirds by detail, the mean squared difference of "
        "gray between neighbours. Interpolation, with traced pixels kept, struggles with the same third.",
        table(["detail", "SSIM of", *(f"{100 * stage:g} %" for stage in STAGES)], rows),
    ]


def white_shapes(shapes: Path) -> set[str]:
    """Return the files without colours, by their names in evaluations."""
    names = set()
    for _, name, scene in each_scene(scenes_of_folder(shapes), stacklevel=2):
        if not bob.Scene(scene).is_colored:
            names.add(name)
    return names


def real_shapes(real: Evaluation | None, white: set[str]) -> list[str]:
    if real is None:
        return []
    parts = [
        "## Results on real shapes",
        f"{verdict(real)} These are shapes by other people, never trained on; traced pixels are kept.",
    ]
    others = set(real.shapes) - white
    if white and others:
        plain, colored = real.of_shapes(white), real.of_shapes(others)
        methods = (kept(NAME), "nearest", "pull-push", "delaunay-linear")
        rows = [[method, *(f"{mean:.4f}" for mean in colored.mean(method))] for method in methods]
        parts += [
            f"The report's shapes and ours are white, as are {len(white)} of these. {verdict(plain)}",
            f"The other {len(others)} have colours, which the network was not trained on: it mistakes dark ones for "
            f"shade. {verdict(colored)}",
            table(["SSIM, colours", *(f"{100 * fraction:g} %" for fraction in real.fractions)], rows, left=True),
        ]
    return [*parts, "All real shapes:", str(real)]


def verdict(real: Evaluation) -> str:
    lost = []
    for filling in ("nearest", "pull-push"):
        pairs = zip(real.fractions, real.mean(kept(NAME)), real.mean(filling), strict=True)
        shares = [f"{100 * fraction:g}" for fraction, ours, theirs in pairs if fraction < 1 and ours < theirs]
        if shares:
            lost.append(f"{filling.capitalize()} filling beats the network at {', '.join(shares)} %.")
    return " ".join(lost) or "The network is above nearest and pull-push filling at every share below 100 %."


def losses(path: Path) -> list[str]:
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    by_set: dict[str, dict[str, float]] = {}
    for row in rows:
        by_set.setdefault(row["samples"], {})[row["loss"]] = float(row["ssim"])
    ours = by_set[UNSEEN]
    best = max(ours, key=ours.__getitem__)
    behind = ours[best] - ours[reference.LOSS]
    verdict = (
        f"On unseen samples {loss_title(best)} has the highest SSIM, {ours[best]:.3f}; the report's choice has "
        f"{ours[reference.LOSS]:.3f}. " + ("We agree with it." if behind < SAME else "We would choose otherwise.")
    )
    columns = list(rows[0])
    return [
        "## Five losses",
        "The report compared five losses by eye, on 50 samples, and chose SSIM + L2.",
        "![losses](report/figure-5.1.png)",
        table(columns, [[row[column] for column in columns] for row in rows]),
        verdict,
    ]


def figures(captions: dict[str, str], scan: bool) -> list[str]:
    parts = ["## Figures"]
    for name, caption in captions.items():
        path = f"report/figure-{name}"
        vector = "" if name in PICTURES else f" ([SVG]({path}.svg))"
        parts += [f"![figure {name}]({path}.png)", f"**Figure {name}**{vector}. {caption}"]
    if scan:
        parts.append("The armadillo is a scan of the Stanford Computer Graphics Laboratory.")
    return parts


if __name__ == "__main__":
    main()
