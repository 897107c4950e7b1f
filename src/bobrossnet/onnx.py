"""ONNX export of networks. `learn/export.py` implements it and needs torch."""

from __future__ import annotations

import os

from bobrossnet.support.errors import InputError


def export(model: str | os.PathLike[str], path: str | os.PathLike[str]) -> None:
    """Write a network and its weights as an ONNX file. Needs the [train] extra.

    The graph maps `gbuffer`, (N, C, H, W) float32, to `gray`, (N, 1, H, W), for any N, H and W. The input has those
    planes of `GBuffer.stack` that the network reads. The output is not clamped and also replaces the traced pixels:
    restore these yourself.

    Parameters
    ----------
    model : str or path
        Name of shipped weights, or a .safetensors file.
    path : path
        The .onnx file to write; replaced if it exists.

    Raises
    ------
    InputError
        If the weights can't be used, the file can't be written or the extra is not installed.
    """
    from importlib.metadata import distribution  # a tenth of the time of importing the package

    (point,) = distribution("bobrossnet").entry_points.select(group="bobrossnet.export", name="onnx")
    try:
        write = point.load()  # this imports torch, which nothing else here needs
    except ModuleNotFoundError as error:
        raise InputError(f"export: this needs {error.name}: pip install 'bobrossnet[train]'") from error
    write(model, path)
