"""Training: from a configuration to a weight file, the same file every time.

A step is a function of the configuration and its number, and a checkpoint holds what else there is: weights,
the optimizer's state, the number. So a run that was stopped ends where an uninterrupted one would.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from bobrossnet.errors import InputError
from bobrossnet.learn import checkpoint, data
from bobrossnet.learn.losses import LOSSES, ssim
from bobrossnet.learn.networks import NETWORKS

VALIDATION_FRACTIONS = (0.01, 0.05, 0.25, 0.75, 1.0)


@dataclass(frozen=True)
class TrainConfig:
    """All that a training depends on. The defaults are the shipped weights'; the report's differ where it says so.

    Measured on 128 validation patches at 1, 5, 25, 75 %, traced pixels kept, after 9,600 patches of AdamW: mini-batches
    of 32 reach an SSIM of .758, .820, .833, .934, of 8 .804, .871, .914, .971; a learning rate of 8e-3 in place of
    3e-3 .809, .869, .913, .967; bfloat16 .802, .870, .913, .972 (no faster for mini-batches of 8). AdaDelta (rate 1, no
    cosine) .798, .841, .846, .919, and its scores still went up and down.
    """

    network: str = "paper"  # a name in `NETWORKS`
    groups: int = 4  # of the network's grouped layers
    seed: int = 0  # of shapes, views, order, masks and first weights
    shapes: int = 700  # procedural meshes to train on
    views: int = 2  # of each mesh; up to 21 patches a view
    validation_shapes: int = 30  # further meshes, never trained on
    validation_patches: int = 128  # of those meshes' patches, spread evenly
    order: str = "uniform"  # pixel order of the masks
    steps: int = 14_000  # mini-batches
    batch: int = 8  # patches a mini-batch; the report's were 32
    loss: str = "ssim+l2"  # a name in `LOSSES`
    keep_known: bool = True  # loss of the picture with the traced pixels put back, instead of the raw output
    optimizer: str = "adamw"  # or "adadelta", as in the report
    learning_rate: float = 4e-3  # at its highest
    warmup: int = 200  # steps over which the learning rate rises; then it falls as a cosine, to 0
    weight_decay: float = 1e-4  # AdamW only
    bfloat16: bool = False  # convolutions in bfloat16, on processors that are faster at it
    validate_every: int = 1000  # steps
    checkpoint_every: int = 1000  # steps
    threads: int = 2  # of torch


def train(
    config: TrainConfig,
    out_path: str | os.PathLike[str],
    *,
    checkpoint_path: str | os.PathLike[str] | None = None,
    patches: tuple[NDArray[Any], NDArray[Any]] | None = None,
    report: Callable[[str], object] = print,
) -> nn.Module:
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
        If the configuration names what is not there, or the checkpoint is another configuration's.
    """
    check(config)
    torch.set_num_threads(config.threads)
    training, validation = patches if patches is not None else render(config, report)

    torch.manual_seed(config.seed)
    network = NETWORKS[config.network](groups=config.groups)
    network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    optimizer = OPTIMIZERS[config.optimizer](network, config)
    first = 0
    if checkpoint_path is not None and Path(checkpoint_path).exists():
        first = resume(checkpoint_path, config, network, optimizer)
        report(f"resumed at step {first}")

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
            left = (time.monotonic() - start) / (done - first) * (config.steps - done)
            scores = validate(network, validation, config)
            by_fraction = "  ".join(f"{100 * f:g} % {score:.4f}" for f, score in scores.items())
            mean = float(np.mean(losses))
            report(f"step {done}/{config.steps}  loss {mean:.4f}  SSIM {by_fraction}  {_minutes(left)} left")
            losses = []
        if checkpoint_path is not None and done % config.checkpoint_every == 0:
            save_checkpoint(checkpoint_path, config, network, optimizer, done)

    checkpoint.save(out_path, network, {"training": json.dumps(asdict(config))})
    return network.eval()


def objective(config: TrainConfig, network: nn.Module, partial: Tensor, reference: Tensor) -> Tensor:
    """Return the mean loss of a mini-batch, (N, 5, H, W) and (N, 1, H, W)."""
    with torch.autocast("cpu", torch.bfloat16, enabled=config.bfloat16):
        image = network(partial.contiguous(memory_format=torch.channels_last))
    image = image.float()  # (N, 1, H, W)
    if config.keep_known:
        # Samples wholly traced stay raw: with nothing to fill in they'd teach nothing.
        whole = partial[:, :1].amin((1, 2, 3), keepdim=True) > 0  # (N, 1, 1, 1)
        image = torch.where(whole, image, keep_known(image, partial))
    return LOSSES[config.loss](image, reference).mean()


def keep_known(image: Tensor, partial: Tensor) -> Tensor:
    """Return the picture, (N, 1, H, W), with the traced pixels as they came in."""
    return torch.where(partial[:, :1] > 0, partial[:, 1:2], image)


def learning_rate(config: TrainConfig, step: int) -> float:
    """Return a step's learning rate: a linear rise, then half a cosine; AdaDelta's stays where it is."""
    if config.optimizer == "adadelta":
        return config.learning_rate
    rise = min((step + 1) / max(config.warmup, 1), 1)
    return config.learning_rate * rise * 0.5 * (1 + math.cos(math.pi * step / config.steps))


OPTIMIZERS: dict[str, Callable[[nn.Module, TrainConfig], torch.optim.Optimizer]] = {
    "adamw": lambda network, config: torch.optim.AdamW(
        network.parameters(), config.learning_rate, weight_decay=config.weight_decay
    ),
    "adadelta": lambda network, config: torch.optim.Adadelta(network.parameters(), config.learning_rate, rho=0.95),
}


@torch.no_grad()
def validate(network: nn.Module, patches: NDArray[Any], config: TrainConfig) -> dict[float, float]:
    """Return the mean SSIM by fraction, traced pixels kept; at 100 % that of the raw output."""
    scores = {}
    for fraction in VALIDATION_FRACTIONS:
        total = 0.0
        for first in range(0, len(patches), config.batch):
            part = patches[first : first + config.batch]
            # The validation's masks count from a seed of their own, the same at every call.
            masks = [data.mask(config.seed + 1, first + i, fraction, config.order) for i in range(len(part))]
            partial, reference = data.batch(part, np.stack(masks))
            image = network(partial.contiguous(memory_format=torch.channels_last))
            image = image if fraction == 1 else keep_known(image, partial)
            total += ssim(image.clamp(0, 1), reference).sum().item()
        scores[fraction] = total / len(patches)
    return scores


def render(config: TrainConfig, report: Callable[[str], object]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the patches to train on and those to validate on, of other shapes."""
    start = time.monotonic()

    def progress(shape: int) -> None:
        done = shape + 1
        if done % 50 == 0:
            total = config.shapes + config.validation_shapes
            left = (time.monotonic() - start) / done * (total - done)
            report(f"rendered {done}/{total} shapes  {_minutes(left)} left")

    training = data.render_patches(config.seed, range(config.shapes), config.views, progress)
    others = range(config.shapes, config.shapes + config.validation_shapes)
    validation = data.render_patches(config.seed, others, config.views, progress)
    spread = np.linspace(0, len(validation) - 1, min(config.validation_patches, len(validation))).astype(int)
    report(f"{len(training)} patches to train on, {len(spread)} to validate on")
    return training, validation[spread]


def save_checkpoint(
    path: str | os.PathLike[str],
    config: TrainConfig,
    network: nn.Module,
    optimizer: torch.optim.Optimizer,
    done: int,
) -> None:
    """Write weights and optimizer state after `done` steps, whole or not at all."""
    tensors = {f"network.{name}": tensor for name, tensor in network.state_dict().items()}
    for index, state in optimizer.state_dict()["state"].items():
        tensors |= {f"optimizer.{index}.{name}": torch.as_tensor(value) for name, value in state.items()}
    checkpoint.write_tensors(path, tensors, {"step": str(done), "training": json.dumps(asdict(config))})


def resume(
    path: str | os.PathLike[str], config: TrainConfig, network: nn.Module, optimizer: torch.optim.Optimizer
) -> int:
    """Set network and optimizer to a checkpoint's state; return how many steps it has behind it."""
    tensors, header = checkpoint.read_tensors(path)
    theirs = json.loads(header.get("training", "{}"))
    ours = asdict(replace(config, threads=theirs.get("threads", config.threads)))  # threads may change
    if theirs != ours:
        different = ", ".join(key for key in ours if theirs.get(key) != ours[key])
        raise InputError(f"{path}: expected this configuration's checkpoint, got another {different}; move it away")
    weights = {name.removeprefix("network."): tensor for name, tensor in tensors.items() if "network." in name}
    network.load_state_dict(weights)
    states: dict[int, dict[str, Tensor]] = {}
    for name, tensor in tensors.items():
        if name.startswith("optimizer."):
            _, index, key = name.split(".")
            states.setdefault(int(index), {})[key] = tensor
    optimizer.load_state_dict({"state": states, "param_groups": optimizer.state_dict()["param_groups"]})
    return int(header["step"])


def check(config: TrainConfig) -> None:
    """Raise InputError if a name in the configuration names nothing."""
    tables: dict[str, dict[str, Any]] = {"network": NETWORKS, "loss": LOSSES, "optimizer": OPTIMIZERS}
    for field, table in tables.items():
        if getattr(config, field) not in table:
            raise InputError(f"{field}: expected one of {', '.join(table)}, got {getattr(config, field)!r}")


def config_from_settings(settings: Sequence[str]) -> TrainConfig:
    """Return a configuration from lines such as "steps=2000".

    Raises
    ------
    InputError
        If a name is no field of `TrainConfig`, or a value not of the field's type.
    """
    types: dict[str, type] = {name: type(value) for name, value in asdict(TrainConfig()).items()}
    values: dict[str, Any] = {}
    for setting in settings:
        name, _, value = setting.partition("=")
        if name not in types:
            raise InputError(f"{setting}: expected NAME=VALUE with a name of {', '.join(types)}")
        try:
            values[name] = {"true": True, "false": False}[value] if types[name] is bool else types[name](value)
        except (KeyError, ValueError):
            raise InputError(f"{setting}: expected a value of type {types[name].__name__}") from None
    return TrainConfig(**values)


def _minutes(seconds: float) -> str:
    return f"{seconds / 60:.1f} min"
