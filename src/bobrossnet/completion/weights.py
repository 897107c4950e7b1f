"""Weight files: safetensors with a network's tensors under its layers' names."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.support.errors import InputError, brief
from bobrossnet.support.paths import check_file, path_of

WEIGHTS = Path(__file__).parent.parent / "weights"
"""The folder of the shipped weights."""

UNCERTAINTY = WEIGHTS / "uncertainty.safetensors"
"""Weights of the network that predicts errors; it completes no pictures."""

FORMAT = "bobrossnet-1"
"""Value of "format" in each file's metadata.

Next to it are "network", the network's name, and "inputs" and "outputs", comma-separated channel names.
"""

DEFAULTS = {"inputs": "mask,gray,depth,normal", "outputs": "gray"}
"""Channels of a file without "inputs" or "outputs"."""


def weights_path(model: str | os.PathLike[str]) -> Path:
    """Return the file that `model` names.

    Raises
    ------
    InputError
        If it is neither the name of shipped weights nor a .safetensors path.
    """
    path = find_weights(model)
    if path is None:
        names = ", ".join(shipped_names())
        got = brief(str(path_of(model, "model")), of_type=False)
        raise InputError(f"model: expected one of {names} or a .safetensors file, got {got}")
    return path


def shipped_names() -> list[str]:
    """Return the names of the shipped weights that complete pictures."""
    return sorted(file.stem for file in WEIGHTS.glob("*.safetensors") if file != UNCERTAINTY)


def find_weights(model: str | os.PathLike[str]) -> Path | None:
    """Return the file of shipped weights of this name, or `model` itself if it is a .safetensors path, or None."""
    path = path_of(model, "model")
    shipped = {file.stem: file for file in WEIGHTS.glob("*.safetensors")}
    return shipped.get(str(path), path if path.suffix == ".safetensors" else None)


def read_weights(path: Path) -> tuple[dict[str, str], dict[str, NDArray[np.float32]]]:
    """Read a weight file.

    Returns
    -------
    metadata : dict of str to str
        "format", "network", "inputs", "outputs" and any other entries.
    tensors : dict of str to float32 arrays

    Raises
    ------
    InputError
        If the file can't be read, is not a safetensors file of this package, or holds other values than finite float32.
    """
    from safetensors import SafetensorError, safe_open

    try:
        check_file(path)
        with safe_open(path, framework="numpy") as file:
            metadata: dict[str, str] = file.metadata() or {}
            tensors: dict[str, NDArray[Any]] = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    except (OSError, SafetensorError, InputError) as error:
        reason = str(error).splitlines()[0][:200]
        raise InputError(f"{path.name}: expected a safetensors file, can't read it: {reason}") from error
    if metadata.get("format") != FORMAT or "network" not in metadata:
        raise InputError(f"{path.name}: expected weights of format {FORMAT}, got format {metadata.get('format')!r}")
    for name, tensor in tensors.items():
        if tensor.dtype != np.float32 or not np.isfinite(tensor).all():
            raise InputError(f"{path.name}: {name[:100]}: expected finite float32 values, got {tensor.dtype} or NaN")
    return {**DEFAULTS, **metadata}, tensors
