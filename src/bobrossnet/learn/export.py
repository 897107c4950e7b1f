"""ONNX files of networks."""

from __future__ import annotations

import io
import os
import warnings
from pathlib import Path

import torch

from bobrossnet.completion.weights import weights_path
from bobrossnet.learn.checkpoint import load
from bobrossnet.support.atomic import write_whole


def onnx(model: str | os.PathLike[str], path: str | os.PathLike[str]) -> None:
    """Write a network and its weights as ONNX; see `bobrossnet.export`."""
    network, _ = load(weights_path(model))
    content = io.BytesIO()
    with warnings.catch_warnings():
        # The TorchScript exporter needs no further package and follows the padding's arithmetic on H and W, but is
        # deprecated.
        warnings.simplefilter("ignore")
        torch.onnx.export(
            network.eval(),
            (torch.zeros(1, network.width(), 61, 47),),
            content,  # type: ignore[arg-type]  # the exporter accepts any file object
            dynamo=False,
            input_names=["gbuffer"],
            output_names=["gray"],
            dynamic_axes={"gbuffer": {0: "N", 2: "H", 3: "W"}, "gray": {0: "N", 2: "H", 3: "W"}},
        )
    write_whole(Path(path), content.getvalue())
