"""The training configuration: its fields, their ranges, and the optimizers by name."""

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
    """Every input of a training run except its data set.

    The defaults are the report's recipe, plus the moving average.

    Raises
    ------
    InputError
        If a value has another type than its default, is out of range, or is an unknown name.
    """

    network: str = "paper"  # a name in `NETWORKS` with learned weights
    start: str = ""  # initial weights: name of shipped weights or a .safetensors file; by default random
    groups: int = 4  # paper: groups of the grouped layers
    features: str = FEATURES  # pyramid: channels between the two convolutions of each level, from the finest on
    handed_on: str = HANDED_ON  # pyramid: channels passed from each level to the next finer one
    seed: int = 0  # of the initial weights and of the shuffle
    epochs: int = 40  # maximum number; 0 writes the initial weights
    patience: int = 5  # epochs without a better validation SSIM before training stops
    batch: int = 32  # samples of a mini-batch over all processes
    draw: str = "each"  # samples of an epoch: each once, or "by-detail", which draws plain samples less often
    fractions: str = "stages"  # the report's five, or "log-uniform" from 1 to 100 %, or "sparse": 0.5 to 90, later 30 %
    order: str = "uniform"  # pixel order of the masks, or several to choose from for each sample: "lattice+uniform"
    loss: str = "ssim+l2"  # a name in `LOSSES`
    keep_known: bool = False  # loss and SSIM of the picture with the traced pixels restored, not of the raw output
    optimizer: str = "adadelta"  # a name in `OPTIMIZERS`
    learning_rate: float = 1.0  # peak rate; AdaDelta's default is 1, AdamW did well with 4e-3, Muon with 0.02
    warmup: int = 200  # AdamW and Muon: steps of the linear rise, at most a tenth of all, before the cosine decay to 0
    weight_decay: float = 1e-4  # AdamW only
    # Decay of the moving average of the weights, which is validated and shipped; 0 uses the weights themselves.
    # AdaDelta's weights oscillate from step to step: after 600 steps the SSIM at the five stages was .8308 .8867 .9180
    # .9339 .9471, and the average's .8339 .8954 .9237 .9388 .9556.
    average: float = 0.999
    # "bf16-mixed" runs the convolutions in bfloat16, for devices with fast bfloat16. With AVX-512's instructions a step
    # took 0.6 times the time; on a processor with AVX2 alone, which emulates bfloat16, more than ten times. It loses
    # the last ten-thousandths of SSIM: the report's recipe gained 0.0002 in epoch 19, and lost 0.0001 after it in
    # bfloat16.
    precision: str = "32-true"
    accelerator: str = "auto"  # "cpu" or "cuda"; "auto" uses the GPU if there is one
    devices: int = 1  # processes, each with a share of every mini-batch
    threads: int = 2  # of torch, in each process
    workers: int = 1  # threads that prepare mini-batches, in each process; 0 prepares them on demand
    checkpoint_every: int = 100  # steps; also saved at the end of each epoch

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            object.__setattr__(self, name, _checked(name, value))  # frozen; numpy's numbers become Python's


FREE = ("accelerator", "devices", "threads", "workers", "checkpoint_every")
"""Fields that may change when training resumes: they affect the result by rounding at most."""


def cosine(config: TrainConfig, share: float, step: int) -> float:
    """Return a step's learning rate: half a cosine from the highest to 0, times a linear rise at the start."""
    rise = min(max((step + 1) / max(config.warmup, 1), 10 * share), 1)
    return config.learning_rate * rise * 0.5 * (1 + math.cos(math.pi * share))


def constant(config: TrainConfig, share: float, step: int) -> float:
    """Return a step's learning rate, constant over all steps."""
    return config.learning_rate


def adamw(network: nn.Module, config: TrainConfig) -> torch.optim.Optimizer:
    """Return AdamW: weight decay decoupled from the gradient's moments."""
    return torch.optim.AdamW(network.parameters(), config.learning_rate, weight_decay=config.weight_decay)


def adadelta(network: nn.Module, config: TrainConfig) -> torch.optim.Optimizer:
    """Return AdaDelta with ρ 0.95 and ε 1e-6 of Zeiler, *ADADELTA: an adaptive learning rate method*, 2012.

    It adapts its own step length, which a learning rate of 1 leaves unchanged. Keras used the same rate and ρ.
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
"""Each optimizer's constructor and learning rate schedule by name.

A schedule is a function of the share of all steps done, 0..1, and the number of steps done.
"""

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
_INTEGERS = {  # minimum and maximum
    "groups": (1, _MANY),  # the network has further limits
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
    """Return a field's value if it is valid; otherwise raise InputError."""
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
    """Return a configuration from settings such as "epochs=3"; other fields keep their defaults.

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
