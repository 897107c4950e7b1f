"""ONNX export of networks. `learn/export.py` implements it and needs torch."""

from __future__ import annotations

import os


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
        If the weights can't be used or the file can't be written.
    """
    from importlib.metadata import distribution  # a tenth of the time of importing the package

    (point,) = distribution("bobrossnet").entry_points.select(group="bobrossnet.export", name="onnx")
    point.load()(model, path)  # this imports torch, which nothing else here needs
