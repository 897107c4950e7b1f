"""What a training depends on: the configuration, what its fields may be, and the optimizers that it can name."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import torch
from torch import nn

from bobrossnet.learn.dataset.loader import DRAWS, FRACTIONS
from bobrossnet.learn.losses import LOSSES
from bobrossnet.learn.muon import Muon
from bobrossnet.learn.networks import learnt
from bobrossnet.learn.networks.pyramid import FEATURES, HANDED_ON
from bobrossnet.picture.order import ORDERS
from bobrossnet.support.errors import InputError, InputTypeError, check_integer, check_number

ACCELERATORS = ("auto", "cpu", "cuda")
PRECISIONS = ("32-true", "bf16-mixed")


@dataclass(frozen=True)
class TrainConfig:
    """Everything a training run depends on except its data set. The defaults are the report's recipe, plus the moving
    average.

    Raises
    ------
    InputError
        If a value has another type than its default, is out of range, or is an unknown name.
    """

    network: str = "paper"  # a name in `NETWORKS` that has anything to learn
    start: str = ""  # what it begins with: shipped weights' name or a .safetensors file; by default new weights
    groups: int = 4  # of the grouped layers of paper
    features: str = FEATURES  # of pyramid: channels between the two convolutions of each level, from the finest on
    handed_on: str = HANDED_ON  # of pyramid: channels that each level but the finest hands on to the finer one
    seed: int = 0  # of the first weights and of the shuffle
    epochs: int = 40  # at most; 0 gives the first weights
    patience: int = 5  # epochs without a better SSIM in validation, after which the training ends
    batch: int = 32  # samples of a mini-batch, of all processes together
    draw: str = "each"  # samples of an epoch: each once, or "by-detail", those that show little more seldom
    fractions: str = "stages"  # the report's five, or "log-uniform" from 1 to 100 %, or "sparse": 0.5 to 90, later 30 %
    order: str = "uniform"  # pixel order of the masks, or several, "lattice+uniform", of which each sample has one
    loss: str = "ssim+l2"  # a name in `LOSSES`
    keep_known: bool = False  # loss and SSIM of the picture with the traced pixels put back, not of the raw output
    optimizer: str = "adadelta"  # a name in `OPTIMIZERS`
    learning_rate: float = 1.0  # at its highest; AdaDelta's own is 1, for AdamW 4e-3 did well, for Muon 0.02
    warmup: int = 200  # AdamW and Muon: steps over which the learning rate rises to the cosine that falls to 0
    weight_decay: float = 1e-4  # AdamW only
    # Decay of the moving average of the weights, which is what is validated and shipped; 0 for the weights themselves.
    # AdaDelta's go up and down from step to step: after 600 steps the SSIM at the five stages was .8308 .8867 .9180
    # .9339 .9471, and the average's .8339 .8954 .9237 .9388 .9556.
    average: float = 0.999
    # "bf16-mixed" has the convolutions in bfloat16, for devices that are faster at it: with AVX-512's own a step took
    # 0.6 times as long; on a processor with AVX2 alone, which emulates it, more than ten times. It does not reach the
    # last ten-thousandths of SSIM: the report's recipe gained 0.0002 in epoch 19, and lost 0.0001 after it in bfloat16.
    precision: str = "32-true"
    accelerator: str = "auto"  # "cpu" or "cuda"; "auto" takes the GPU if there is one
    devices: int = 1  # processes, each with a share of every mini-batch
    threads: int = 2  # of torch, in each process
    workers: int = 1  # threads that make mini-batches, in each process; 0 makes them when they are needed
    checkpoint_every: int = 100  # steps; and at the end of each epoch

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            object.__setattr__(self, name, _checked(name, value))  # frozen, but numpy's numbers become Python's


FREE = ("accelerator", "devices", "threads", "workers", "checkpoint_every")
"""Fields that may change when training resumes: they change the result by rounding, if at all."""


def cosine(config: TrainConfig, share: float, step: int) -> float:
    """Return a step's learning rate: half a cosine from the highest to 0, times a linear rise at the start."""
    rise = min((step + 1) / max(config.warmup, 1), 1)
    return config.learning_rate * rise * 0.5 * (1 + math.cos(math.pi * share))


def constant(config: TrainConfig, share: float, step: int) -> float:
    """Return a step's learning rate, the same at each."""
    return config.learning_rate


def adamw(network: nn.Module, config: TrainConfig) -> torch.optim.Optimizer:
    """Return AdamW: weight decay beside the gradient's moments."""
    return torch.optim.AdamW(network.parameters(), config.learning_rate, weight_decay=config.weight_decay)


def adadelta(network: nn.Module, config: TrainConfig) -> torch.optim.Optimizer:
    """Return AdaDelta with ρ 0.95 and ε 1e-6 of Zeiler, *ADADELTA: an adaptive learning rate method*, 2012.

    It adapts its step length by itself; a learning rate of 1 leaves that unchanged. Keras had the same rate and ρ.
    """
    return torch.optim.Adadelta(network.parameters(), config.learning_rate, rho=0.95, eps=1e-6)


def muon(network: nn.Module, config: TrainConfig) -> torch.optim.Optimizer:
    """Return Muon."""
    return Muon(network.parameters(), config.learning_rate)


Make = Callable[[nn.Module, TrainConfig], torch.optim.Optimizer]
Schedule = Callable[[TrainConfig, float, int], float]

OPTIMIZERS: dict[str, tuple[Make, Schedule]] = {
    "adadelta": (adadelta, constant),
    "adamw": (adamw, cosine),
    "muon": (muon, cosine),
}
"""By name: what makes the optimizer, and its learning rate by the share of all steps done, 0..1, and their number."""

_NAMES: dict[str, Collection[str]] = {
    "draw": DRAWS,
    "fractions": FRACTIONS,
    "loss": LOSSES,
    "optimizer": OPTIMIZERS,
    "precision": PRECISIONS,
    "accelerator": ACCELERATORS,
}

_STRINGS = {"start": "a name or a path", "features": "numbers with commas", "handed_on": "numbers with commas"}

_MANY = 2**31 - 1
_INTEGERS = {  # least and most
    "groups": (1, _MANY),  # the network itself says more
    "seed": (0, 2**32 - 1),
    "epochs": (0, _MANY),
    "patience": (1, _MANY),
    "batch": (1, _MANY),
    "warmup": (0, _MANY),
    "devices": (1, 1024),
    "threads": (1, 1024),
    "workers": (0, 1024),
    "checkpoint_every": (1, _MANY),
}


def _checked(name: str, value: Any) -> Any:
    """Return a field's value if it may be that."""
    if name in _INTEGERS:
        return check_integer(name, value, *_INTEGERS[name])
    if name == "order":
        if not isinstance(value, str) or not set(value.split("+")) <= set(ORDERS):
            raise InputError(f"order: expected one of {', '.join(ORDERS)}, or several joined by +, got {value!r}")
        return value
    if name in _STRINGS:
        if not isinstance(value, str):
            raise InputTypeError(f"{name}: expected {_STRINGS[name]}, got {value!r}")
        return value
    if name == "network" or name in _NAMES:
        names = learnt() if name == "network" else _NAMES[name]
        if value not in list(names):
            raise InputError(f"{name}: expected one of {', '.join(names)}, got {value!r}")
        return value
    if name == "learning_rate":
        return check_number(name, value, 0, above=True)
    if name == "weight_decay":
        return check_number(name, value, 0)
    if name == "average":
        return check_number(name, value, 0, 1)
    if not isinstance(value, bool):
        raise InputTypeError(f"{name}: expected True or False, got {value!r}")
    return value


def config_from_settings(settings: Sequence[str]) -> TrainConfig:
    """Return a configuration from settings such as "epochs=3"; the rest stays at its defaults.

    Raises
    ------
    InputError
        If a name is not a field of `TrainConfig`, or a value is not valid for its field.
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
            what = "true or false" if types[name] is bool else f"a value of type {types[name].__name__}"
            raise InputError(f"{setting}: expected {what}") from None
    return TrainConfig(**values)
