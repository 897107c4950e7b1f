"""What a training depends on: the configuration, what its fields may be, and the optimizers that it can name."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import torch
from torch import nn

from bobrossnet.errors import InputError, InputTypeError, check_integer, check_number
from bobrossnet.learn.losses import LOSSES
from bobrossnet.learn.networks import NETWORKS
from bobrossnet.render.order import ORDERS


@dataclass(frozen=True)
class TrainConfig:
    """All that a training depends on. The defaults are the shipped weights'; the report's differ where it says so.

    Measured on 128 validation patches at 1, 5, 25, 75 %, traced pixels kept, after 9,600 patches of AdamW: mini-batches
    of 32 reach an SSIM of .758, .820, .833, .934, of 8 .804, .871, .914, .971; a learning rate of 8e-3 in place of
    3e-3 .809, .869, .913, .967; bfloat16 .802, .870, .913, .972 (no faster for mini-batches of 8). AdaDelta (rate 1, no
    cosine) .798, .841, .846, .919, and its scores still went up and down.

    Raises
    ------
    InputError
        If a value is of another type than its default, out of its range, or a name that names nothing.
    """

    network: str = "paper"  # a name in `NETWORKS`
    groups: int = 4  # of the network's grouped layers
    seed: int = 0  # of shapes, views, order, masks and first weights
    shapes: int = 700  # procedural meshes to train on
    views: int = 2  # of each mesh; up to 21 patches a view
    validation_shapes: int = 30  # further meshes, never trained on
    validation_patches: int = 128  # of those meshes' patches, spread evenly
    order: str = "uniform"  # pixel order of the masks
    steps: int = 14_000  # mini-batches; 0 gives the first weights
    batch: int = 8  # patches a mini-batch; the report's were 32
    loss: str = "ssim+l2"  # a name in `LOSSES`
    keep_known: bool = True  # loss of the picture with the traced pixels put back, instead of the raw output
    optimizer: str = "adamw"  # a name in `OPTIMIZERS`; the report's was AdaDelta
    learning_rate: float = 4e-3  # at its highest
    warmup: int = 200  # AdamW only: steps over which the learning rate rises to the cosine that falls to 0
    weight_decay: float = 1e-4  # AdamW only
    bfloat16: bool = False  # convolutions in bfloat16, on processors that are faster at it
    validate_every: int = 1000  # steps
    checkpoint_every: int = 1000  # steps
    threads: int = 2  # of torch

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            object.__setattr__(self, name, _checked(name, value))  # frozen, but numpy's numbers become Python's


def cosine(config: TrainConfig, step: int) -> float:
    """Return a step's learning rate: half a cosine from the highest to 0, times a linear rise at the start."""
    rise = min((step + 1) / max(config.warmup, 1), 1)
    return config.learning_rate * rise * 0.5 * (1 + math.cos(math.pi * step / config.steps))


def constant(config: TrainConfig, step: int) -> float:
    """Return a step's learning rate, the same at each."""
    return config.learning_rate


def adamw(network: nn.Module, config: TrainConfig) -> torch.optim.Optimizer:
    """Return AdamW: weight decay beside the gradient's moments."""
    return torch.optim.AdamW(network.parameters(), config.learning_rate, weight_decay=config.weight_decay)


def adadelta(network: nn.Module, config: TrainConfig) -> torch.optim.Optimizer:
    """Return AdaDelta as in the report; its steps find their own length, so a learning rate of 1 suits it."""
    return torch.optim.Adadelta(network.parameters(), config.learning_rate, rho=0.95)


Make = Callable[[nn.Module, TrainConfig], torch.optim.Optimizer]
Schedule = Callable[[TrainConfig, int], float]

OPTIMIZERS: dict[str, tuple[Make, Schedule]] = {"adamw": (adamw, cosine), "adadelta": (adadelta, constant)}
"""By name: what makes the optimizer, and the learning rate of each step, counted from 0."""

_NAMES: dict[str, Collection[str]] = {"network": NETWORKS, "order": ORDERS, "loss": LOSSES, "optimizer": OPTIMIZERS}

_MANY = 2**31 - 1
_INTEGERS = {  # least and most
    "groups": (1, _MANY),  # the network itself says more
    "seed": (0, 2**32 - 1),
    "shapes": (1, 500_000),  # both kinds together at most the million that a seed has, `data.patches_of_shape`
    "views": (1, _MANY),
    "validation_shapes": (1, 500_000),
    "validation_patches": (1, _MANY),
    "steps": (0, _MANY),
    "batch": (1, _MANY),
    "warmup": (0, _MANY),
    "validate_every": (1, _MANY),
    "checkpoint_every": (1, _MANY),
    "threads": (1, 1024),
}


def _checked(name: str, value: Any) -> Any:
    """Return a field's value if it may be that."""
    if name in _INTEGERS:
        return check_integer(name, value, *_INTEGERS[name])
    if name in _NAMES:
        if value not in list(_NAMES[name]):
            raise InputError(f"{name}: expected one of {', '.join(_NAMES[name])}, got {value!r}")
        return value
    if name == "learning_rate":
        return check_number(name, value, 0, above=True)
    if name == "weight_decay":
        return check_number(name, value, 0)
    if not isinstance(value, bool):
        raise InputTypeError(f"{name}: expected True or False, got {value!r}")
    return value


def config_from_settings(settings: Sequence[str]) -> TrainConfig:
    """Return a configuration from lines such as "steps=2000"; what none names stays at its default.

    Raises
    ------
    InputError
        If a name is no field of `TrainConfig`, or a value can't be its field's.
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
