"""The core's networks with their weights, loaded once."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.completion.display import displayed
from bobrossnet.completion.weights import read_weights, weights_path
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.support.errors import InputError


@dataclass(frozen=True)
class Network:
    """A network with its weights, ready to run."""

    core: _core.Network
    weights: tuple[Mapping[str, str], Mapping[str, NDArray[np.float32]]] = field(repr=False, compare=False)
    """The metadata and tensors that `read_weights` returned."""

    def __reduce__(self) -> tuple[Any, ...]:
        return make_network, self.weights  # the core's objects can't be copied

    def predict(self, gbuffer: GBuffer) -> NDArray[np.float32]:
        """Return the network's raw output at every pixel: (H, W) float32, display-referred, not clamped."""
        return self.run(displayed(gbuffer))

    def run(self, gbuffer: GBuffer) -> NDArray[np.float32]:
        """Run `predict` on a G-buffer that is already display-referred."""
        image = np.empty(gbuffer.size, np.float32)
        try:
            self.core(gbuffer.layout.core, gbuffer.planes, image[None])
        except ValueError as error:
            raise InputError(f"gbuffer: {error}") from None
        return image


NetworkLike: TypeAlias = str | os.PathLike[str] | Network


def load_network(model: NetworkLike) -> Network:
    """Return the network that `model` names, loaded once and cached.

    Raises
    ------
    InputError
        If the file does not exist or its contents can't be used.
    """
    if isinstance(model, Network):
        return model
    path = weights_path(model)
    try:
        modified = path.stat().st_mtime_ns
    except OSError as error:
        raise InputError(f"model: can't read {path}: {error.strerror}") from error
    except ValueError as error:  # a NUL in the name
        raise InputError(f"model: can't read {str(path)!a:.100}: {error}") from error
    return _load(path, modified)


@lru_cache(maxsize=8)
def _load(path: Path, modified: int) -> Network:
    """Load a weight file; `modified` belongs to the cache key, so a rewritten file is loaded again."""
    metadata, tensors = read_weights(path)
    try:
        return make_network(metadata, tensors)
    except ValueError as error:
        raise InputError(f"{path.name}: {error}") from error


def make_network(metadata: Mapping[str, str], tensors: Mapping[str, NDArray[np.float32]]) -> Network:
    """Make a network from the result of `read_weights`. Raises ValueError if the tensors do not fit."""
    inputs, outputs = _core.Layout(metadata["inputs"]), _core.Layout(metadata["outputs"])
    return Network(_core.Network(metadata["network"], dict(tensors), inputs, outputs), (metadata, tensors))
