"""Training: from a configuration to a weight file, the same file every time.

A step is a function of the configuration and its number, and a checkpoint holds what else there is: weights,
the optimizer's state, the number. So a run that was stopped ends where an uninterrupted one would.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from bobrossnet.errors import InputError
from bobrossnet.learn import checkpoint, data
from bobrossnet.learn.config import OPTIMIZERS, TrainConfig
from bobrossnet.learn.losses import LOSSES, ssim
from bobrossnet.learn.networks import NETWORKS, Network

VALIDATION_FRACTIONS = (0.01, 0.05, 0.25, 0.75, 1.0)


def train(
    config: TrainConfig,
    out_path: str | os.PathLike[str],
    *,
    checkpoint_path: str | os.PathLike[str] | None = None,
    patches: tuple[NDArray[Any], NDArray[Any]] | None = None,
    report: Callable[[str], object] = print,
) -> Network:
    """Train a network and write its weights.

    Parameters
    ----------
    config : TrainConfig
    out_path : path ending in .safetensors
        Weights, with the configuration in their header. Written at the end, whole or not at all.
    checkpoint_path : path ending in .safetensors, optional
        Written every `checkpoint_every` steps; if it is there at the start, the training goes on from it.
    patches : two (N, 4, 128, 128) arrays, optional
        For training and for validation, in place of those that the configuration says to render.
    report : function of one line
        Told how it goes.

    Returns
    -------
    the network, float32, for evaluation

    Raises
    ------
    InputError
        If a file can't be written where it is to be, the network can't be of these settings, the checkpoint is another
        configuration's, or there are no patches.
    """
    # All that can be refused comes before the minutes of rendering, which draws on other random numbers.
    for path in (out_path, checkpoint_path):
        if path is not None:
            checkpoint.make_place(path)
    torch.set_num_threads(config.threads)
    torch.manual_seed(config.seed)
    network = NETWORKS[config.network].from_settings(asdict(config))
    network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    make_optimizer, learning_rate = OPTIMIZERS[config.optimizer]
    optimizer = make_optimizer(network, config)
    first = 0
    if checkpoint_path is not None and Path(checkpoint_path).exists():
        first = checkpoint.resume(checkpoint_path, config, network, optimizer)
        report(f"resumed at step {first}")

    training, validation = patches if patches is not None else render(config, report)
    if not (len(training) and len(validation)):
        raise InputError(f"patches: expected some of each kind, got {len(training)} and {len(validation)}")

    start, losses = time.monotonic(), []
    for step in range(first, config.steps):
        partial, reference = data.training_batch(training, config.seed, step, config.batch, config.order)
        for group in optimizer.param_groups:
            group["lr"] = learning_rate(config, step)
        loss = objective(config, network, partial, reference)
        optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        optimizer.step()
        losses.append(loss.item())

        done = step + 1
        if done % config.validate_every == 0 or done == config.steps:
            minutes = (time.monotonic() - start) / 60 / (done - first) * (config.steps - done)
            scores = validate(network, validation, config)
            by_fraction = "  ".join(f"{100 * f:g} % {score:.4f}" for f, score in scores.items())
            progress = f"step {done}/{config.steps}  loss {np.mean(losses):.4f}"
            report(f"{progress}  SSIM {by_fraction}  {minutes:.1f} min left")
            losses = []
        if checkpoint_path is not None and done % config.checkpoint_every == 0:
            checkpoint.save_checkpoint(checkpoint_path, config, network, optimizer, done)

    checkpoint.save(out_path, network, {"training": json.dumps(asdict(config))})
    return network.eval()


def objective(config: TrainConfig, network: Network, partial: Tensor, reference: Tensor) -> Tensor:
    """Return the mean loss of a mini-batch, (N, 5, H, W) and (N, 1, H, W)."""
    image = predict(network, partial, bfloat16=config.bfloat16)
    if config.keep_known:
        image = keep_known(image, partial)
    return LOSSES[config.loss](image, reference).mean()


def predict(network: Network, partial: Tensor, *, bfloat16: bool = False) -> Tensor:
    """Return the network's own output for partial pictures: (N, 5, H, W) → (N, 1, H, W) float32, not clamped."""
    with torch.autocast("cpu", torch.bfloat16, enabled=bfloat16):
        image: Tensor = network(partial.contiguous(memory_format=torch.channels_last))
    return image.float()


def keep_known(image: Tensor, partial: Tensor) -> Tensor:
    """Return pictures, (N, 1, H, W), with the traced pixels as they came in; a picture wholly traced stays the
    network's own: with nothing to fill in it would teach nothing."""
    traced = partial[:, :1] > 0  # (N, 1, H, W)
    whole = partial[:, :1].amin((1, 2, 3), keepdim=True) > 0  # (N, 1, 1, 1)
    return torch.where(traced & ~whole, partial[:, 1:2], image)


@torch.no_grad()
def validate(network: Network, patches: NDArray[Any], config: TrainConfig) -> dict[float, float]:
    """Return the mean SSIM by fraction, traced pixels kept; at 100 % that of the raw output."""
    scores = {}
    for fraction in VALIDATION_FRACTIONS:
        total = 0.0
        for first in range(0, len(patches), config.batch):
            part = patches[first : first + config.batch]
            # The validation's masks count from a seed of their own, the same at every call.
            masks = [data.mask(config.seed + 1, first + i, fraction, config.order) for i in range(len(part))]
            partial, reference = data.batch(part, np.stack(masks))
            image = keep_known(predict(network, partial), partial)
            total += ssim(image.clamp(0, 1), reference).sum().item()
        scores[fraction] = total / len(patches)
    return scores


def render(config: TrainConfig, report: Callable[[str], object]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the patches to train on and those to validate on, of other shapes."""
    start, total = time.monotonic(), config.shapes + config.validation_shapes

    def progress(shape: int) -> None:
        done = shape + 1
        if done % 50 == 0:
            minutes = (time.monotonic() - start) / 60 / done * (total - done)
            report(f"rendered {done}/{total} shapes  {minutes:.1f} min left")

    training = data.render_patches(config.seed, range(config.shapes), config.views, progress)
    validation = data.render_patches(config.seed, range(config.shapes, total), config.views, progress)
    spread = np.linspace(0, len(validation) - 1, min(config.validation_patches, len(validation))).astype(int)
    report(f"{len(training)} patches to train on, {len(spread)} to validate on")
    return training, validation[spread]
