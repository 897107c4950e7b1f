"""Completion methods by the names used in evaluations: networks, and fillings without a network.

A model gives two methods. NAME raw is the raw network output clamped to 0..1, with the traced pixels repainted. NAME
kept is the result of `bobrossnet.complete`, with the traced pixels unchanged. Fillings keep them as well.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.completion.filling import FILLINGS, delaunay_linear
from bobrossnet.completion.network import Network, load_network
from bobrossnet.support.errors import InputError

Weights: TypeAlias = str | os.PathLike[str]
Method: TypeAlias = Callable[[bob.GBuffer], NDArray[np.float32]]
"""Completes a partial picture: (H, W) float32 in 0..1, or (H, W, 3) for colours."""

CHANNELS = ("gray", "color")
"""Channels that can be completed and measured."""

_RAW, _KEPT = " raw", " kept"


def raw(model: str) -> str:
    """Return the name of a model's raw method, with the traced pixels repainted."""
    return f"{model}{_RAW}"


def kept(model: str) -> str:
    """Return the name of a model's method with the traced pixels kept."""
    return f"{model}{_KEPT}"


def repaints(method: str) -> bool:
    """Return whether a method repaints the traced pixels."""
    return method.endswith(_RAW)


def is_kept(method: str) -> bool:
    """Return whether a method is a model's with the traced pixels kept."""
    return method.endswith(_KEPT)


def model_names(models: Sequence[Weights]) -> tuple[str, ...]:
    """Return the names of models: the stems of their files.

    Raises
    ------
    InputError
        If two models have the same name.
    """
    names = tuple(Path(model).stem for model in models)
    if len(set(names)) < len(names):
        raise InputError(f"models: expected different names, got {', '.join(names)}")
    return names


def all_methods(
    models: Sequence[Weights], fillings: Sequence[str], *, repainting: bool = True, channel: str = "gray"
) -> dict[str, Method]:
    """Return the methods of models, raw and kept, and then of fillings, by name.

    Parameters
    ----------
    models : names of shipped weights, or .safetensors files
    fillings : names in `FILLINGS`
    repainting : whether to include the models' raw methods, which are gray
    channel : "gray" or "color"; fillings complete each component separately

    Raises
    ------
    InputError
        If there is no method, or a model or filling is unusable.
    """
    if channel not in CHANNELS:
        raise InputError(f"channel: expected one of {', '.join(CHANNELS)}, got {channel!r}")
    if channel != "gray" and repainting:
        raise InputError("repainting: expected False for colours, which networks do not predict directly, got True")
    for name in fillings:
        if name not in FILLINGS:
            raise InputError(f"fillings: expected some of {', '.join(FILLINGS)}, got {name!r}")
    names = model_names(models)
    if not (names or fillings):
        raise InputError("models: expected one or more, or fillings, got neither")
    methods: dict[str, Method] = {}
    for name, model in zip(names, map(load_network, models), strict=True):
        if repainting:
            methods[raw(name)] = partial(own_output, model)
        methods[kept(name)] = partial(bob.complete, model=model, channel=channel)
    fill = _filled if channel == "gray" else _filled_colors
    return methods | {name: partial(fill, name) for name in fillings}


def own_output(model: Network, part: bob.GBuffer) -> NDArray[np.float32]:
    """Return a network's raw output clamped to 0..1, (H, W) float32, with the traced pixels repainted."""
    return np.clip(model.predict(part), 0, 1)


def _filled(name: str, part: bob.GBuffer) -> NDArray[np.float32]:
    return FILLINGS[name](part.gray, part.mask)


def _filled_colors(name: str, part: bob.GBuffer) -> NDArray[np.float32]:
    if name == "delaunay-linear":  # all components share the triangulation, which takes the longest
        return delaunay_linear(part.color, part.mask)
    return np.stack([FILLINGS[name](plane, part.mask) for plane in np.moveaxis(part.color, -1, 0)], -1)
