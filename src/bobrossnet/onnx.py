"""Networks as ONNX, for other people's run times. It is learn/export.py that writes them, and needs torch."""

from __future__ import annotations

import os
from importlib.metadata import distribution


def export(model: str | os.PathLike[str], path: str | os.PathLike[str]) -> None:
    """Write a network with its weights as ONNX. Needs the [train] extra.

    The graph maps `gbuffer`, (N, C, H, W) float32, the planes of the network's inputs as `GBuffer.stack` has them, to
    `gray`, (N, 1, H, W): the network's own output, not clamped, for any N, H and W. Keep the known pixels yourself.

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
    (point,) = distribution("bobrossnet").entry_points.select(group="bobrossnet.export", name="onnx")
    point.load()(model, path)  # and with it torch, which nothing else here waits for
