"""Weight files: a network's tensors as safetensors, and in the header what they are and how they were made.

The header's strings: `format` (this file's version), `network` (a name in `NETWORKS`), the network's own
settings (`groups`), and whatever the training adds. The core's reader mirrors this one; it needs no torch.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import safetensors
import safetensors.torch
from torch import Tensor, nn

from bobrossnet.atomic import write_whole
from bobrossnet.complete.weights import FORMAT
from bobrossnet.errors import InputError
from bobrossnet.learn.networks import NETWORKS


def save(path: str | os.PathLike[str], network: nn.Module, metadata: Mapping[str, str] | None = None) -> None:
    """Write a network's weights, whole or not at all.

    Parameters
    ----------
    path : path ending in .safetensors
        Replaced if it exists.
    network : one of `NETWORKS`
        Its `settings()` go into the header.
    metadata : strings
        More to keep in the header, e.g. the training's configuration.
    """
    names = {type_: name for name, type_ in NETWORKS.items()}
    settings = {key: str(value) for key, value in network.settings().items()}  # type: ignore[operator]
    header = {**(metadata or {}), "format": FORMAT, "network": names[type(network)], **settings}
    write_tensors(path, network.state_dict(), header)


def load(path: str | os.PathLike[str]) -> tuple[nn.Module, dict[str, str]]:
    """Read a network written by `save`.

    Returns
    -------
    network : one of `NETWORKS`, on the CPU, float32
    metadata : the header's strings

    Raises
    ------
    InputError
        If the file is no weight file, of another format, or does not fit its network.
    """
    tensors, header = read_tensors(path)
    if header.get("format") != FORMAT:
        raise InputError(f"{path}: expected weights of format {FORMAT!r}, got {header.get('format')!r}")
    if header.get("network") not in NETWORKS:
        known = ", ".join(NETWORKS)
        raise InputError(f"{path}: expected a network of {known}, got {header.get('network')!r}")
    try:
        network = NETWORKS[header["network"]](groups=int(header["groups"]))
        network.load_state_dict(tensors)
    except (KeyError, ValueError, ZeroDivisionError, RuntimeError) as error:
        raise InputError(f"{path}: expected the tensors of {header['network']!r}, got {error}") from error
    return network, header


def write_tensors(path: str | os.PathLike[str], tensors: Mapping[str, Tensor], header: Mapping[str, str]) -> None:
    """Write tensors and strings to a safetensors file, whole or not at all."""
    content = safetensors.torch.save(
        {name: tensor.detach().cpu().contiguous() for name, tensor in tensors.items()}, dict(header)
    )
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, content)


def read_tensors(path: str | os.PathLike[str]) -> tuple[dict[str, Tensor], dict[str, str]]:
    """Read the tensors and the strings of a safetensors file."""
    try:
        with safetensors.safe_open(path, framework="pt") as file:
            return {name: file.get_tensor(name) for name in file.keys()}, dict(file.metadata() or {})  # noqa: SIM118
    except (OSError, safetensors.SafetensorError) as error:
        raise InputError(f"{path}: expected a safetensors file, got {error}") from error
