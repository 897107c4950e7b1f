"""Limits of the report's network: trained by other recipes, on other data, and with the other decoder of equal size.
A section of docs/report.md, written there by docs/report.py; by itself this prints it.

    python docs/limits.py [--shapes FOLDER] [--work DIR]
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import torch
from torch import Tensor, nn
from torch.nn.functional import relu
from work import MODELS, ROOT, Work

from bobrossnet.learn import reference
from bobrossnet.learn.config import TrainConfig
from bobrossnet.learn.dataset.build import build
from bobrossnet.learn.dataset.plan import STAGES
from bobrossnet.learn.dataset.store import Dataset
from bobrossnet.learn.evaluation.evaluate import evaluate_dataset
from bobrossnet.learn.evaluation.methods import kept, raw
from bobrossnet.learn.evaluation.scores import Evaluation
from bobrossnet.learn.logs import SSIM_COLUMNS
from bobrossnet.learn.networks import NETWORKS, Paper
from bobrossnet.learn.networks.paper import pad, pool, shuffle, upsample
from bobrossnet.learn.shape_files import shape_files
from bobrossnet.learn.train import LOG, WEIGHTS, train
from bobrossnet.support.atomic import write_whole
from bobrossnet.support.tables import table

MESHES = (
    "anatomy_bio animals architecture characters furniture_household math_shapes mechanical nature_food robots scans "
    "vehicles"
)
"""Folders of real meshes, like the report's shapes."""


class EarlySkip(Paper):
    """The report's network by the other reading of its parameter counts. Only PyTorch has it.

    Decoding layers upsample first, and the skip joins before layer 4, which then has 40 input channels, and layer 5
    has 5.
    """

    def __init__(self, groups: int = 4) -> None:
        super().__init__(groups)
        self.decode1 = nn.Conv2d(20 + 20, 5, 3, padding=1)
        self.decode2 = nn.Conv2d(5, 5, 3, padding=1)
        for layer in (self.decode1, self.decode2):
            nn.init.kaiming_normal_(layer.weight, nonlinearity="relu")
            nn.init.zeros_(layer.bias)  # type: ignore[arg-type]

    def forward(self, gbuffer: Tensor) -> Tensor:
        height, width = gbuffer.shape[-2:]
        input = pad(gbuffer, self.multiple)  # (N, 5, H, W)
        encode1 = relu(pool(self.encode1(input)))  # (N, 20, H/2, W/2)
        encode2 = relu(pool(self.encode2(encode1)))  # (N, 80, H/4, W/4)
        encoded = upsample(relu(self.encoded(shuffle(encode2, self.groups))))  # (N, 20, H/2, W/2)
        decode1 = upsample(relu(self.decode1(torch.cat([encoded, encode1], 1))))  # (N, 5, H, W)
        decode2 = relu(self.decode2(decode1))  # (N, 5, H, W)
        output: Tensor = self.output(torch.cat([decode2, input], 1))  # (N, 1, H, W)
        return output[..., :height, :width]


EARLY_SKIP = "paper-early-skip"
NETWORKS[EARLY_SKIP] = EarlySkip

FILLINGS = ("nearest", "pull-push", "delaunay-linear")


@dataclass(frozen=True)
class Recipe:
    name: str  # of the weights
    what: str
    config: TrainConfig
    on_real_meshes: bool = False


RECIPES = (
    Recipe(
        "paper-best",
        "Muon, SSIM + L1 of the picture with its traced pixels, any share of them, in three orders, patches by detail",
        TrainConfig(
            optimizer="muon",
            learning_rate=0.02,
            epochs=7,
            patience=7,
            loss="ssim+l1",
            keep_known=True,
            draw="by-detail",
            fractions="log-uniform",
            order="adaptive+lattice+uniform",
            precision="bf16-mixed",
        ),
    ),
    Recipe(
        "paper-real",
        "the report's recipe on real meshes",
        TrainConfig(epochs=25, patience=25, precision="bf16-mixed"),
        on_real_meshes=True,
    ),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", type=Path, default=MODELS, help="folder of real shapes")
    parser.add_argument("--work", type=Path, default=ROOT / "out" / "report", help="folder of docs/report.py")
    options = parser.parse_args()
    own = Dataset.open(options.work / "data")
    print("\n\n".join(section(Work(options.work), own, options.work / "paper.safetensors", options.shapes)))


def section(
    work: Work, own: Dataset, paper: Path, shapes: Path, *, epochs: int | None = None, limit: int | None = 31
) -> list[str]:
    """Train the missing recipes, evaluate all of them on test samples of both kinds, and return the section.

    Parameters
    ----------
    own : the data set of procedural shapes
    paper : weights of the report's recipe
    shapes : folder with folders of real meshes
    epochs : maximum number for each recipe
    limit : number of real shapes for the test
    """
    files = [place for name in MESHES.split() if (place := shapes / name).is_dir()]
    with work.timed("data set of real meshes"):
        count = sum(len(shape_files(place)) for place in files)
        real = build(work.folder / "real-data", files=files, test_shapes=round(0.45 * count))
    weights = [paper]
    for recipe in RECIPES:
        run = work.folder / recipe.name
        with work.timed(f"training of {recipe.name}"):
            config = recipe.config if epochs is None else replace(recipe.config, epochs=epochs, precision="32-true")
            train(config, real if recipe.on_real_meshes else own, run)
        weights.append(work.folder / f"{recipe.name}.safetensors")
        write_whole(weights[-1], (run / WEIGHTS).read_bytes())
    with work.timed("evaluation of recipes"):
        of_own = evaluate_dataset(own, weights, fractions=STAGES, fillings=FILLINGS)
        of_real = evaluate_dataset(real, weights, fractions=STAGES, fillings=FILLINGS, limit=limit)
        of_all = evaluate_dataset(real, [paper], fractions=STAGES, fillings=())
    return [
        "## What limits the network",
        ahead(of_real, of_all, paper),
        "The same network by other recipes, on patches of views of 128², 256² and 512² pixels, as in the report. Raw "
        "is the network's output at each pixel. Kept is `complete`: traced pixels are put back, and pixels between "
        "those that agree are interpolated.",
        "\n".join(
            [
                "- **paper**: the report's recipe, as above.",
                *(f"- **{recipe.name}**: {recipe.what}; {recipe.config.epochs} epochs." for recipe in RECIPES),
            ]
        ),
        scores("Test samples of our own shapes", of_own, weights),
        scores(f"Test samples of {len(set(of_real.shapes))} real meshes, never trained on", of_real, weights),
        differences([of_real, of_all], paper),
        decoders(work, own, 7 if epochs is None else epochs),
    ]


def decoders(work: Work, own: Dataset, epochs: int) -> str:
    """Train the other decoder by the report's recipe for some epochs, and compare both networks' validation."""
    run = work.folder / EARLY_SKIP
    with work.timed(f"training of {EARLY_SKIP}"):
        train(TrainConfig(network=EARLY_SKIP, epochs=epochs), own, run)
    rows = [
        [name, *scores_after(epochs, folder)] for name, folder in (("paper", work.folder / "paper"), (EARLY_SKIP, run))
    ]
    counts = [network().multiply_adds() for network in (Paper, EarlySkip)]
    return (
        "The report's parameter counts also fit another decoder: the skip joins before layer 4, 40 → 5, and layer 5 is "
        f"5 → 5. It needs {counts[1]:,.0f} multiply-adds per pixel rather than {counts[0]:,.0f}. Validation after "
        f"{epochs} epoch{'s' * (epochs > 1)} of the report's recipe:\n\n"
        + table(["SSIM", *(f"{100 * stage:g} %" for stage in STAGES)], rows, left=True)
    )


def scores_after(epochs: int, run: Path) -> list[str]:
    """Return the validation SSIM at each stage, of a training of at least `epochs` epochs."""
    with (run / LOG).open(encoding="utf-8") as file:
        row = list(csv.DictReader(file))[epochs - 1]
    return [f"{float(row[name]):.4f}" for name in SSIM_COLUMNS]


def from_the_report(result: Evaluation, paper: Path) -> list[tuple[float, float]]:
    """Return the SSIM of the report's recipe at each stage, and its difference from the report."""
    pairs = zip(result.mean(raw(paper.stem)), reference.SSIM.values(), strict=True)
    return [(float(ours), float(ours - theirs)) for ours, theirs in pairs]


def ahead(some: Evaluation, more: Evaluation, paper: Path) -> str:
    """Return a sentence with the number of stages where the report's recipe exceeds the report on real meshes."""
    counts = [sum(difference > 0 for _, difference in from_the_report(result, paper)) for result in (some, more)]
    return (
        f"On {len(set(some.shapes))} real meshes the report's recipe exceeds the report's SSIM at {counts[0]} of "
        f"{len(STAGES)} stages, on {len(set(more.shapes))} at {counts[1]}."
    )


def differences(results: Sequence[Evaluation], paper: Path) -> str:
    """Return a table of the recipe's raw output on real meshes, and its difference from the report."""
    rows = [
        [f"{len(set(result.shapes))}", *(f"{ours:.4f} ({by:+.4f})" for ours, by in from_the_report(result, paper))]
        for result in results
    ]
    title = "The raw output of the report's recipe on real meshes, and in parentheses its difference from the report:"
    return f"{title}\n\n" + table(["real meshes", *(f"{100 * stage:g} %" for stage in STAGES)], rows, left=True)


def scores(what: str, result: Evaluation, weights: Sequence[Path]) -> str:
    """Return a table of SSIM: networks' raw output and with traced pixels kept, and fillings."""
    names = [path.stem for path in weights]
    rows = [["the report, on its own shapes", *(f"{value:.4f}" for value in reference.SSIM.values())]]
    methods = (*map(raw, names), *map(kept, names), *FILLINGS)
    rows += [[method, *(f"{value:.4f}" for value in result.mean(method))] for method in methods]
    return f"{what}:\n\n" + table(["SSIM", *(f"{100 * stage:g} %" for stage in STAGES)], rows, left=True)


if __name__ == "__main__":
    main()
