"""Milliseconds to complete a picture with the report's network: the core against PyTorch and ONNX Runtime.

The same weights, the same input, in the same run, with all cores; every result is compared with PyTorch's. Then
milliseconds to say which pixels come first, for each pixel order.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import onnxruntime
import torch
from report import heading, in_turn, median_ratio, spread, table

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.complete.model import load_model, weights_path
from bobrossnet.learn.checkpoint import load
from bobrossnet.render.order import ORDERS

SIZES = ((240, 320), (480, 640), (720, 1280))
RUNS = 21


def rivals(gbuffer: bob.GBuffer, onnx: Path) -> dict[str, Callable[[], np.ndarray]]:
    """What completes the picture, by name; each returns the network's output, (H, W)."""
    stack = gbuffer.stack()[None].copy()
    network = load(weights_path("paper"))[0].eval()
    wide = load(weights_path("paper"))[0].eval()
    wide.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    eager, last = torch.from_numpy(stack), torch.from_numpy(stack).to(memory_format=torch.channels_last)
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = bob.thread_count()
    session = onnxruntime.InferenceSession(onnx, options, providers=["CPUExecutionProvider"])
    model = load_model("paper")
    best = _core.isa()

    def core(name: str) -> Callable[[], np.ndarray]:
        def run() -> np.ndarray:
            _core.set_isa(name)
            result = model.predict(gbuffer)
            _core.set_isa(best)
            return result

        return run

    def with_torch(module: torch.nn.Module, batch: torch.Tensor) -> Callable[[], np.ndarray]:
        def run() -> np.ndarray:
            with torch.inference_mode():
                result: np.ndarray = module(batch)[0, 0].numpy()
            return result

        return run

    available = [name for name in ("baseline", "avx2", "avx512") if _core.set_isa(name)]
    _core.set_isa(best)
    return {
        "PyTorch": with_torch(network, eager),
        "PyTorch, channels_last": with_torch(wide, last),
        "ONNX Runtime": lambda: session.run(None, {"gbuffer": stack})[0][0, 0],
        **{f"core, {name}": core(name) for name in available},
        "bob.complete": lambda: bob.complete(gbuffer, model=model),
    }


def main() -> None:
    torch.set_num_threads(bob.thread_count())
    scene = bob.Scene(bob.happy_tree())
    heading(f"Completing with the report's network: milliseconds, {bob.thread_count()} threads")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        onnx = Path(folder) / "paper.onnx"
        bob.export("paper", onnx)
        for size in SIZES:
            gbuffer = bob.trace(scene, size=size, fraction=0.05)
            runs = rivals(gbuffer, onnx)
            expected = runs["PyTorch"]()
            for name, run in runs.items():
                if name != "bob.complete":
                    assert np.abs(run() - expected).max() < 1e-5, name
            seconds = in_turn(runs, RUNS)
            for name, values in seconds.items():
                ratio = median_ratio(values, seconds["bob.complete"])
                rows.append([f"complete.paper.{size[1]}x{size[0]}", name, spread(values, 1e3), f"{ratio:.2f}"])
    table(["what", "with", "ms", "/ bob.complete"], rows)
    order_times()


def order_times() -> None:
    """Print how long the first pixels of a 4K picture take to name."""
    size = (2160, 3840)
    heading(f"Pixel orders: milliseconds for the first pixels of {size[1]}x{size[0]}, {bob.thread_count()} threads")
    rows = []
    for fraction in (0.05, 0.25, 1.0):
        count = round(fraction * size[0] * size[1])
        seconds = in_turn({order: partial(bob.pixel_order, size, order=order, count=count) for order in ORDERS}, 7)
        for order, values in seconds.items():
            rows.append([f"order.{order}.{100 * fraction:g}%", spread(values, 1e3, 2)])
    table(["what", "ms"], rows)


if __name__ == "__main__":
    main()
