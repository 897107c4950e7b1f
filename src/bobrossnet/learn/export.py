"""Networks as files for other people's run times."""

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
    """Write a network with its weights as ONNX; `bobrossnet.export` says how."""
    network, _ = load(weights_path(model))
    content = io.BytesIO()
    with warnings.catch_warnings():
        # The exporter through TorchScript needs no further package, follows the padding's arithmetic on H and W, and is
        # deprecated.
        warnings.simplefilter("ignore")
        torch.onnx.export(
            network.eval(),
            (torch.zeros(1, network.width(), 61, 47),),
            content,  # type: ignore[arg-type]  # any file is fine for this exporter
            dynamo=False,
            input_names=["gbuffer"],
            output_names=["gray"],
            dynamic_axes={"gbuffer": {0: "N", 2: "H", 3: "W"}, "gray": {0: "N", 2: "H", 3: "W"}},
        )
    write_whole(Path(path), content.getvalue())
