"""Figure 5.1: comparison of the five losses, each training a network on the same few samples.

The report chose its loss by such comparisons, on 50 samples and by eye. Here the networks start from the same weights,
see the same mini-batches, and are also measured, on these samples and on others.
"""

from __future__ import annotations

import copy
import csv
import io
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from bobrossnet.learn.checks import MAX_COUNT
from bobrossnet.learn.config import OPTIMIZERS, TrainConfig
from bobrossnet.learn.dataset.loader import Batch, Batches
from bobrossnet.learn.dataset.plan import PATCH, random_generator
from bobrossnet.learn.dataset.store import Dataset
from bobrossnet.learn.figures.figure import Drawing, Sources, data_of
from bobrossnet.learn.figures.style import picture_grid, show_picture
from bobrossnet.learn.losses import LOSSES, OF_REPORT, l1, l2, ssim
from bobrossnet.learn.networks import NETWORKS, Network
from bobrossnet.learn.train import follow
from bobrossnet.picture.files import traced_on_green
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.support.errors import check_integer
from bobrossnet.support.progress import Report, progress

SAMPLES = 50  # training samples, as in the report
OTHERS = 100  # further samples for measurement, from the validation split
STEPS = 400  # 80 epochs: about 130 s of one core for each loss
BATCH = 10  # samples of a mini-batch; with the report's 32 the same time gives a third of the steps
AVERAGE = 0.98  # decay of the moving average of weights: AdaDelta's losses oscillate by half of their value
SHOWN_FRACTION = 0.25  # share of traced pixels in the displayed pictures
TRAINED, UNSEEN = "trained on", "unseen"  # names of the two sets
MEASURES = ("ssim", "l1", "l2", "contrast", "sharpness")


@dataclass(frozen=True)
class Completed:
    """A sample completed by each network.

    Attributes
    ----------
    samples : name of its set
    part : GBuffer, the traced pixels
    reference : (128, 128) float32, the whole picture
    images : by loss: (128, 128) float32 in 0..1, the raw network output, clamped
    scores : by loss: SSIM
    """

    samples: str
    part: GBuffer
    reference: NDArray[np.float32]
    images: Mapping[str, NDArray[np.float32]] = field(repr=False)
    scores: Mapping[str, float]


@dataclass(frozen=True)
class LossComparison:
    """The result of `compare_losses`.

    Attributes
    ----------
    steps : mini-batches for each loss
    counts : by set, `TRAINED` and `UNSEEN`: number of samples
    scores : by loss and set: the numbers of `MEASURES`
        SSIM, L1 and L2 are means over the samples, of the raw network output, clamped to 0..1. Contrast is the standard
        deviation over a sample's pixels, sharpness the mean difference of neighbours, both summed over the samples and
        divided by the references' sum: 1 is ideal, below 1 is flat or blurred, above 1 is noisy.
    shown : samples to show, one of each set
    """

    steps: int
    counts: Mapping[str, int]
    scores: Mapping[tuple[str, str], Mapping[str, float]]
    shown: tuple[Completed, ...]

    def csv(self) -> str:
        """Return the scores as CSV, one line for each loss and set."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["loss", "samples", "count", *MEASURES])
        for (loss, samples), row in self.scores.items():
            writer.writerow([loss, samples, self.counts[samples], *(f"{row[name]:.6f}" for name in MEASURES)])
        return text.getvalue()


def compare_losses(
    dataset: Dataset,
    *,
    samples: int = SAMPLES,
    unseen: int = OTHERS,
    steps: int = STEPS,
    batch: int = BATCH,
    network: str = "paper",
    seed: int = 0,
) -> LossComparison:
    """Train a network with each loss on the same few samples, and measure all networks.

    All have the same initial weights and mini-batches, AdaDelta, and a moving average of the weights. As in the report,
    the loss is computed on the raw network output at every pixel.

    Parameters
    ----------
    dataset : Dataset
    samples : number of training samples, drawn from the training split with all stages
    unseen : number of further samples to measure, from the validation split
    steps : mini-batches for each loss
    batch : samples of a mini-batch; the samples are reshuffled in each epoch
    network : a name in `NETWORKS`
    seed : of samples, mini-batches and initial weights

    Raises
    ------
    InputError
        If a number is out of range.
    """
    check_integer("steps", steps, 0, MAX_COUNT)
    config = TrainConfig(network=network, batch=batch, optimizer="adadelta", learning_rate=1.0, seed=seed)
    sets = {
        TRAINED: Batches(dataset, "train", size=samples, seed=seed)[0],
        UNSEEN: Batches(dataset, "validation", size=unseen, seed=seed)[0],
    }
    networks = {}
    with progress("comparing losses") as report:
        for number, loss in enumerate(OF_REPORT):
            part = _part(report, number / len(OF_REPORT), 1 / len(OF_REPORT), loss)
            networks[loss] = _train(loss, sets[TRAINED], config, steps, part)
    outputs = {(loss, name): _outputs(networks[loss], sets[name]) for loss in OF_REPORT for name in sets}
    return LossComparison(
        steps,
        {name: len(chosen.numbers) for name, chosen in sets.items()},
        {(loss, name): _measure(image, sets[name].reference) for (loss, name), image in outputs.items()},
        tuple(
            _completed(name, chosen, {loss: outputs[loss, name] for loss in OF_REPORT}) for name, chosen in sets.items()
        ),
    )


def draw_losses(sources: Sources) -> Drawing:
    """Compare the losses, and draw reference, sampled region and the five completions for a sample of each set."""
    return show_losses(compare_losses(data_of(sources), steps=sources.steps, seed=sources.seed))


def show_losses(comparison: LossComparison) -> Drawing:
    """Draw the comparison, a row for each displayed sample."""
    rows, columns = len(comparison.shown), 2 + len(OF_REPORT)
    figure, grid = picture_grid(rows, columns, (PATCH, PATCH), above=0.28, between=0.33, left=0.16)
    for axes, sample in zip(grid, comparison.shown, strict=True):
        show_picture(axes[0], sample.reference, "reference")
        axes[0].text(-0.05, 0.5, sample.samples, rotation=90, ha="right", va="center", transform=axes[0].transAxes)
        show_picture(axes[1], traced_on_green(sample.part), f"{round(100 * sample.part.fraction, 1):g} % traced")
        for place, (loss, image) in zip(axes[2:], sample.images.items(), strict=True):
            show_picture(place, image, f"{loss_title(loss)}\nSSIM {sample.scores[loss]:.3f}")
    trained, unseen = (comparison.counts[samples] for samples in (TRAINED, UNSEEN))
    means = []
    for loss in OF_REPORT:
        seen, other = (comparison.scores[loss, samples]["ssim"] for samples in (TRAINED, UNSEEN))
        means.append(f"{loss_title(loss)} {seen:.3f} / {other:.3f}")
    return Drawing(
        figure,
        f"A network trained with each loss on the same {trained} samples, from the same weights and mini-batches, in "
        f"{comparison.steps} steps of AdaDelta. The raw output for a training sample and an unseen one. "
        f"Mean SSIM of all {trained} samples / of {unseen} unseen ones: {', '.join(means)}.",
        comparison.csv(),
    )


def loss_title(name: str) -> str:
    """Return a loss's display name: "ssim+l2" is "SSIM + L2"."""
    return name.upper().replace("+", " + ")


def _train(loss: str, samples: Batch, config: TrainConfig, steps: int, report: Report) -> Network:
    """Return the moving average of a network's weights at the end of its training."""
    with torch.random.fork_rng(devices=[]):  # keeps the caller's random state
        torch.manual_seed(config.seed)
        network = NETWORKS[config.network].from_settings({"groups": config.groups})
    network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    average = copy.deepcopy(network).requires_grad_(False)
    make_optimizer, _ = OPTIMIZERS[config.optimizer]
    optimizer = make_optimizer(network, config)
    count = len(samples.numbers)
    epoch_steps = -(-count // config.batch)
    for step in range(steps):
        epoch, place = divmod(step, epoch_steps)
        order = random_generator(config.seed, 5, epoch).permutation(count)
        chosen = torch.from_numpy(order[place * config.batch : (place + 1) * config.batch])
        partial = samples.partial[chosen].contiguous(memory_format=torch.channels_last)
        value = LOSSES[loss](network(partial), samples.reference[chosen]).mean()
        optimizer.zero_grad()
        value.backward()  # type: ignore[no-untyped-call]
        optimizer.step()
        follow(average, network, AVERAGE, step + 1)
        report((step + 1) / steps, f"{value.item():.4f}")
    return average.eval()


@torch.no_grad()
def _outputs(network: Network, samples: Batch) -> Tensor:
    """Return the clamped network outputs for all samples, (n, 1, 128, 128), in chunks to bound memory."""
    return torch.cat([network(partial) for partial in torch.split(samples.partial, 10)]).clamp(0, 1)


def _measure(image: Tensor, reference: Tensor) -> dict[str, float]:
    contrast, sharpness = (_ratio(of(image), of(reference)) for of in (_deviation, _gradient))
    means = [float(measure(image, reference).mean()) for measure in (ssim, l1, l2)]
    return dict(zip(MEASURES, [*means, contrast, sharpness], strict=True))


def _ratio(of_image: Tensor, of_reference: Tensor) -> float:
    return float(of_image.sum() / of_reference.sum())


def _deviation(picture: Tensor) -> Tensor:
    return picture.flatten(1).std(1)


def _gradient(picture: Tensor) -> Tensor:
    """Return the mean absolute difference of neighbours along rows and columns: (n, 1, H, W) → (n,)."""
    across, down = picture.diff(dim=3).abs().mean((1, 2, 3)), picture.diff(dim=2).abs().mean((1, 2, 3))
    return across + down


def _completed(name: str, samples: Batch, outputs: Mapping[str, Tensor]) -> Completed:
    """Return the sample with the most edges at the displayed share of pixels, with its completions."""
    edges = _gradient(samples.reference).numpy()
    nearness = -np.abs(samples.fractions - SHOWN_FRACTION)  # small sets may lack the fraction
    chosen = int(np.lexsort((edges, nearness))[-1])
    reference = samples.reference[chosen, 0].numpy()
    return Completed(
        name,
        GBuffer.from_stack(samples.partial[chosen].numpy().copy()),
        reference,
        {loss: output[chosen, 0].numpy() for loss, output in outputs.items()},
        {loss: float(ssim(output[chosen, None], samples.reference[chosen, None])) for loss, output in outputs.items()},
    )


def _part(report: Report, start: float, share: float, what: str) -> Report:
    """Return a report function for a part of the work."""
    return lambda done, note="": report(start + share * done, f"{what} {note}")
