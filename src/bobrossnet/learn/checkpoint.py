"""Safetensors files that a training writes: weights, to be used, and checkpoints, to go on from.

A weight file holds a network's tensors under its layers' names. Its header's strings: `format` (this file's version),
`network` (a name in `NETWORKS`), the network's own settings (`groups`), and `training`, the configuration as JSON. The
core's reader, complete/weights.py, mirrors it and needs no torch. A checkpoint holds `network.<tensor>` and
`optimizer.<parameter>.<tensor>`, and in its header `step` and `training`.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

import safetensors
import safetensors.torch
import torch
from torch import Tensor

from bobrossnet.atomic import check_writable, write_whole
from bobrossnet.complete.weights import FORMAT
from bobrossnet.errors import InputError
from bobrossnet.learn.config import TrainConfig
from bobrossnet.learn.networks import NETWORKS, Network


def save(path: str | os.PathLike[str], network: Network, metadata: Mapping[str, str] | None = None) -> None:
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
    settings = {key: str(value) for key, value in network.settings().items()}
    header = {**(metadata or {}), "format": FORMAT, "network": names[type(network)], **settings}
    write_tensors(path, network.state_dict(), header)


def load(path: str | os.PathLike[str]) -> tuple[Network, dict[str, str]]:
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
        network = NETWORKS[header["network"]].from_settings(header)
        network.load_state_dict(tensors)
    except (KeyError, ValueError, RuntimeError) as error:
        raise InputError(f"{path}: expected the tensors of {header['network']!r}, got {error}") from error
    return network, header


def save_checkpoint(
    path: str | os.PathLike[str],
    config: TrainConfig,
    network: Network,
    optimizer: torch.optim.Optimizer,
    done: int,
) -> None:
    """Write weights and the optimizer's state after `done` steps, whole or not at all."""
    tensors = {f"network.{name}": tensor for name, tensor in network.state_dict().items()}
    for index, state in optimizer.state_dict()["state"].items():
        tensors |= {f"optimizer.{index}.{name}": torch.as_tensor(value) for name, value in state.items()}
    write_tensors(path, tensors, {"step": str(done), "training": json.dumps(asdict(config))})


def resume(
    path: str | os.PathLike[str], config: TrainConfig, network: Network, optimizer: torch.optim.Optimizer
) -> int:
    """Set network and optimizer to a checkpoint's state; return how many steps it has behind it.

    Raises
    ------
    InputError
        If the file is no checkpoint, or another configuration's; only `threads` may differ.
    """
    tensors, header = read_tensors(path)
    if not {"step", "training"} <= header.keys():
        raise InputError(f"{path}: expected a checkpoint, got a file without its step; move the file away")
    theirs, ours = json.loads(header["training"]), asdict(config)
    different = [
        f"{name} {theirs.get(name)!r} instead of {ours.get(name)!r}"
        for name in {**ours, **theirs}
        if name != "threads" and theirs.get(name) != ours.get(name)
    ]
    if different:
        got = ", ".join(different)
        raise InputError(f"{path}: expected this configuration's checkpoint, got one of {got}; move the file away")

    weights: dict[str, Tensor] = {}
    states: dict[int, dict[str, Tensor]] = {}
    for name, tensor in tensors.items():
        if name.startswith("network."):
            weights[name.removeprefix("network.")] = tensor
        elif name.startswith("optimizer."):
            _, index, key = name.split(".")
            states.setdefault(int(index), {})[key] = tensor
    network.load_state_dict(weights)
    optimizer.load_state_dict({"state": states, "param_groups": optimizer.state_dict()["param_groups"]})
    return int(header["step"])


def make_place(path: str | os.PathLike[str]) -> Path:
    """Make the folder that a file is to lie in; return the file's path if it can be written there.

    Raises
    ------
    InputError
        If it can't.
    """
    try:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: can't make its folder: {error.strerror}") from error
    return check_writable(path)


def write_tensors(path: str | os.PathLike[str], tensors: Mapping[str, Tensor], header: Mapping[str, str]) -> None:
    """Write tensors and strings to a safetensors file, whole or not at all."""
    content = safetensors.torch.save(
        {name: tensor.detach().cpu().contiguous() for name, tensor in tensors.items()}, dict(header)
    )
    write_whole(make_place(path), content)


def read_tensors(path: str | os.PathLike[str]) -> tuple[dict[str, Tensor], dict[str, str]]:
    """Read the tensors and the strings of a safetensors file."""
    try:
        with safetensors.safe_open(path, framework="pt") as file:
            return {name: file.get_tensor(name) for name in file.keys()}, dict(file.metadata() or {})  # noqa: SIM118
    except (OSError, safetensors.SafetensorError) as error:
        raise InputError(f"{path}: expected a safetensors file, got {error}") from error
