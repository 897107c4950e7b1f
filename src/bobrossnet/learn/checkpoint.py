"""Safetensors files of a training run: weights for use, and checkpoints for resuming.

A weight file holds a network's tensors under its layers' names. The strings in its header: `format` (the file's
version), `network` (a name in `NETWORKS`), `inputs` and `outputs` (names of its channels), the network's settings
(`groups`), and `training`, the configuration as JSON. The core's reader, completion/weights.py, mirrors it and needs no
torch. A checkpoint holds `network.<tensor>`, `average.<tensor>` and `optimizer.<parameter>.<tensor>`, and in its
header, as JSON, the configuration `training`, the data set's identity `dataset`, and `progress`.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import safetensors
import torch
from torch import Tensor, nn

from bobrossnet.completion.weights import FORMAT, read_weights, weights_path
from bobrossnet.learn.config import FREE, TrainConfig
from bobrossnet.learn.networks import NETWORKS, Network
from bobrossnet.support.atomic import check_writable, write_whole
from bobrossnet.support.errors import InputError, check_number
from bobrossnet.support.tensors import tensor_file


def save(path: str | os.PathLike[str], network: Network, metadata: Mapping[str, str] | None = None) -> None:
    """Write a network's weights; a failed write leaves no file.

    Parameters
    ----------
    path : path ending in .safetensors
        Replaced if it exists.
    network : one of `NETWORKS`
        Its `settings()` go into the header.
    metadata : strings
        Further entries of the header, such as the training configuration.
    """
    names = {type_: name for name, type_ in NETWORKS.items()}
    settings = {key: str(value) for key, value in network.settings().items()}
    layouts = {"inputs": network.inputs, "outputs": network.outputs}
    header = {**(metadata or {}), "format": FORMAT, "network": names[type(network)], **layouts, **settings}
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
        If the file is not a weight file, has another format, or does not fit its network.
    """
    header, arrays = read_weights(Path(path))
    if header["network"] not in NETWORKS:
        known = ", ".join(NETWORKS)
        raise InputError(f"{path}: expected a network of {known}, got {header['network']!r}")
    try:
        network = NETWORKS[header["network"]].from_settings(header)
        network.load_state_dict({name: torch.from_numpy(array) for name, array in arrays.items()})
    except (KeyError, ValueError, RuntimeError) as error:
        raise InputError(f"{path}: expected the tensors of {header['network']!r}, got {error}") from error
    return network, header


def mix(
    first: str | os.PathLike[str], second: str | os.PathLike[str], share: float, path: str | os.PathLike[str]
) -> None:
    """Write the mean of two networks' weights; the second must have been trained on from the first.

    The mean keeps the abilities of the first network and gains nearly all abilities of the second, because both lie in
    one valley of the loss. Means of independently trained networks are useless.

    Parameters
    ----------
    first, second : names of shipped weights, or .safetensors files
        Networks with the same settings.
    share : float in 0..1
        Weight of the second.
    path : path ending in .safetensors
        Replaced if it exists. Its header is the second's, plus the share and the first's hash.

    Raises
    ------
    InputError
        If the networks differ, the share is out of range, or a file can't be read or written.

    References
    ----------
    Wortsman et al., *Robust fine-tuning of zero-shot models*, 2022.
    """
    check_number("share", share, 0, 1)
    (one, _), (other, header) = load(weights_path(first)), load(weights_path(second))
    if type(one) is not type(other) or one.settings() != other.settings():
        raise InputError(f"second: expected weights of the same network as {first}, got {second}")
    theirs = other.state_dict()
    other.load_state_dict({name: tensor.lerp(theirs[name], share) for name, tensor in one.state_dict().items()})
    kept = {name: value for name, value in header.items() if name not in other.settings()}
    digest = hashlib.sha256(weights_path(first).read_bytes()).hexdigest()
    save(path, other, {**kept, "mixed": json.dumps({"share": share, "with": {"sha256": digest}})})


def save_checkpoint(
    path: str | os.PathLike[str],
    networks: Mapping[str, nn.Module],
    optimizer: torch.optim.Optimizer,
    header: Mapping[str, Any],
) -> None:
    """Write weights, the optimizer's state and a header of JSON values; a failed write leaves no file."""
    tensors = {
        f"{kind}.{name}": tensor for kind, network in networks.items() for name, tensor in network.state_dict().items()
    }
    for index, state in optimizer.state_dict()["state"].items():
        tensors |= {f"optimizer.{index}.{name}": torch.as_tensor(value) for name, value in state.items()}
    write_tensors(path, tensors, {key: json.dumps(value) for key, value in header.items()})


def load_checkpoint(
    path: str | os.PathLike[str], networks: Mapping[str, nn.Module], optimizer: torch.optim.Optimizer
) -> None:
    """Restore networks and optimizer to the state from `save_checkpoint`.

    Raises
    ------
    InputError
        If the file belongs to other networks or another optimizer.
    """
    parts: dict[str, dict[str, Tensor]] = {}
    for name, tensor in read_tensors(path)[0].items():
        kind, _, rest = name.partition(".")
        parts.setdefault(kind, {})[rest] = tensor
    states: dict[int, dict[str, Tensor]] = {}
    for name, tensor in parts.get("optimizer", {}).items():
        index, key = name.split(".")
        states.setdefault(int(index), {})[key] = tensor
    try:
        for kind, network in networks.items():
            network.load_state_dict(parts[kind])
        optimizer.load_state_dict({"state": states, "param_groups": optimizer.state_dict()["param_groups"]})
    except (KeyError, ValueError, RuntimeError) as error:
        raise InputError(f"{path}: expected this network's checkpoint, got {error}; move the file away") from error


def read_progress(path: str | os.PathLike[str], expected: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return a checkpoint's progress, if it belongs to the expected training run.

    Parameters
    ----------
    path : path of the checkpoint
    expected : expected fields for each key of the header; those in `FREE` may differ

    Raises
    ------
    InputError
        If the file is not a checkpoint, or belongs to another training run.
    """
    try:
        header = {key: json.loads(value) for key, value in read_tensors(path)[1].items()}
    except ValueError:
        header = {}
    if not {"progress", *expected} <= header.keys():
        raise InputError(f"{path}: expected a checkpoint, got a file without its progress; move the file away")
    # A field missing from a checkpoint is newer than it; its default has the former meaning.
    younger = {"training": asdict(TrainConfig())}
    different = [
        f"{name} {theirs.get(name)!r} instead of {ours.get(name)!r}"
        for key, ours in expected.items()
        for theirs in [{**younger.get(key, {}), **header[key]}]
        for name in {**ours, **theirs}
        if name not in FREE and theirs.get(name) != ours.get(name)
    ]
    if different:
        got = ", ".join(different)
        raise InputError(f"{path}: expected a checkpoint of this training, got one of {got}; move the file away")
    return dict(header["progress"])


def make_place(path: str | os.PathLike[str]) -> Path:
    """Make a file's parent folder, and return the file's path if it can be written there.

    Raises
    ------
    InputError
        If the folder can't be made, or the file can't be written.
    """
    try:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: can't make its folder: {error.strerror}") from error
    return check_writable(path)


def write_tensors(path: str | os.PathLike[str], tensors: Mapping[str, Tensor], header: Mapping[str, str]) -> None:
    """Write tensors and strings to a safetensors file; a failed write leaves no file."""
    arrays = {name: tensor.detach().cpu().numpy() for name, tensor in tensors.items()}
    write_whole(make_place(path), tensor_file(header, arrays))


def read_tensors(path: str | os.PathLike[str]) -> tuple[dict[str, Tensor], dict[str, str]]:
    """Read the tensors and the strings of a safetensors file."""
    try:
        with safetensors.safe_open(path, framework="pt") as file:
            return {name: file.get_tensor(name) for name in file.keys()}, dict(file.metadata() or {})  # noqa: SIM118
    except (OSError, safetensors.SafetensorError) as error:
        raise InputError(f"{path}: expected a safetensors file, got {error}") from error
