"""Time to complete a picture with each network: the core against PyTorch, ONNX Runtime and OpenVINO.

The same weights, input and number of threads, in the same run; every result is compared with PyTorch's. Also the cost
of a small change of a picture, and the time to choose the first pixels, for each pixel order.
"""

from __future__ import annotations

import argparse
import gc
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import onnxruntime
import torch
from numpy.typing import NDArray
from report import heading, in_turn, median_ratio, spread, table

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.completion.network import make_network
from bobrossnet.completion.weights import find_weights, read_weights, shipped_names
from bobrossnet.learn.checkpoint import load, save
from bobrossnet.learn.networks import NETWORKS, learnt
from bobrossnet.picture.channels import TRACED
from bobrossnet.picture.order import FIXED_ORDERS
from bobrossnet.support.machine import extra_memory

THREADS = 2
SIZES = ((240, 320), (480, 640), (720, 1280), (1080, 1920), (2160, 3840))
REST = 0.05  # seconds before each run, longer than any rival's threads spin
PIXELS = 2e7  # pixels that each rival completes at each size, in at least 3 runs
CORE = Path(__file__).parents[1] / "core"
FLAGS = ["-std=c++20", "-O3", "-march=native", "-ffp-contract=off", "-Wno-psabi", "-DBOB_ISA=widest", f"-I{CORE}"]

Run = Callable[[], NDArray[np.float32]]


def rivals(weights: Path, onnx: Path, stack: NDArray[np.float32]) -> dict[str, Callable[[], Run]]:
    """Return the rivals by name. Each prepares a network, and returns a function with its output, (H, W)."""
    size = stack.shape[1:]

    def core() -> Run:
        metadata, tensors = read_weights(weights)
        network, gbuffer = make_network(metadata, tensors), bob.GBuffer.from_stack(stack)
        return lambda: network.predict(gbuffer)

    def pytorch() -> Run:
        network = load(weights)[0].eval()
        network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        batch = torch.from_numpy(stack[None].copy()).to(memory_format=torch.channels_last)

        def run() -> NDArray[np.float32]:
            with torch.inference_mode():
                result: NDArray[np.float32] = network(batch)[0, 0].numpy()
            return result

        return run

    def onnx_runtime() -> Run:
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = THREADS
        session = onnxruntime.InferenceSession(onnx, options, providers=["CPUExecutionProvider"])
        return lambda: session.run(None, {"gbuffer": stack[None]})[0][0, 0]

    def openvino(**precision: str) -> Run:
        vino = import_module("openvino").Core()
        model = vino.read_model(onnx)
        model.reshape([1, 5, *size])
        hints = {"PERFORMANCE_HINT": "LATENCY", "INFERENCE_NUM_THREADS": THREADS, **precision}
        request = vino.compile_model(model, "CPU", hints).create_infer_request()
        return lambda: request.infer([stack[None]], share_inputs=True)[0][0, 0].copy()

    result: dict[str, Callable[[], Run]] = {
        "PyTorch, channels_last": pytorch,
        "ONNX Runtime": onnx_runtime,
        "core": core,
    }
    if find_spec("openvino"):
        result["OpenVINO, float32"] = partial(openvino, INFERENCE_PRECISION_HINT="f32")
        result["OpenVINO, its default"] = openvino
    return result


def peak(folder: Path) -> float:
    """Return this machine's current peak of fused multiply-adds, in GFLOP/s."""
    program = folder / "peak"
    if not program.exists():
        subprocess.run(["c++", *FLAGS, "-o", program, Path(__file__).with_name("peak.cpp"), "-pthread"], check=True)
    return float(subprocess.run([program, str(THREADS)], check=True, capture_output=True, text=True).stdout)


def weights_of(network: str, folder: Path) -> Path:
    """Return the shipped weights of a network, with layers of zeros, which the core omits; otherwise new weights."""
    shipped = find_weights("default" if network == "pyramid" else network)
    if shipped is None:
        save(folder / f"{network}.safetensors", NETWORKS[network].from_settings({}))
    return shipped or folder / f"{network}.safetensors"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plot", type=Path, metavar="PICTURE", help="draw milliseconds over pixels")
    arguments = parser.parse_args()
    bob.set_thread_count(THREADS)
    torch.set_num_threads(THREADS)
    scene = bob.Scene(bob.happy_tree())
    heading(f"Completing: {THREADS} threads")
    rows: list[list[str]] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        peaks = [peak(folder)]
        for network in learnt():
            weights, onnx = weights_of(network, folder), folder / f"{network}.onnx"
            bob.export(weights, onnx)
            for size in SIZES:
                rows += compare(
                    f"complete.{network}", weights, onnx, bob.trace(scene, size=size, fraction=0.05), peaks[-1]
                )
                peaks.append(peak(folder))
    what = "GFLOP/s count convolutions by definition, so a kernel that multiplies less may exceed the peak"
    print(f"{what}: {spread(peaks)} GFLOP/s, measured before each size.")
    print("MB: the peak of memory beyond input and output. Difference: the largest from PyTorch.\n")
    if not find_spec("openvino"):
        print("skipped OpenVINO: it is not installed (pip install openvino)\n")
    table(["what", "with", "ms", "/ core", "after a rest", "/ core", "GFLOP/s", "of peak", "MB", "difference"], rows)
    if arguments.plot:
        plot(rows, arguments.plot)
    ladder_times(scene)
    size_times(scene)
    order_times()
    deciding_times()


def plot(rows: list[list[str]], path: Path) -> None:
    """Plot each rival's time by number of pixels."""
    figure, axes = plt.subplots(1, len(learnt()), figsize=(9, 4), sharey=True, layout="constrained")
    points: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for what, name, milliseconds, *_ in rows:
        _, network, size = what.split(".")
        width, height = map(int, size.split("x"))
        points.setdefault((network, name), []).append((width * height / 1e6, float(milliseconds.split()[0])))
    for ax, network in zip(axes, learnt(), strict=True):
        for (of, name), values in points.items():
            if of == network:
                ax.loglog(
                    *zip(*values, strict=True),
                    marker="o",
                    markersize=4,
                    linewidth=2 if name == "core" else 1,
                    label=name,
                )
        ax.set(title=network, xlabel="million pixels")
        ax.grid(alpha=0.3, which="both")
    axes[0].set_ylabel("milliseconds")
    axes[-1].legend()
    figure.savefig(path, dpi=110)


def compare(what: str, weights: Path, onnx: Path, gbuffer: bob.GBuffer, peak: float) -> list[list[str]]:
    """Return the table's rows for one picture."""
    height, width = gbuffer.size
    operations = 2 * load(weights)[0].multiply_adds(height, width) * height * width
    runs: dict[str, Run] = {}
    memory, difference = {}, {}
    expected: NDArray[np.float32] | None = None
    for name, ready in rivals(weights, onnx, gbuffer.stack()).items():
        run = runs[name] = ready()
        gc.collect()
        results: list[NDArray[np.float32]] = []
        needed = extra_memory(lambda run=run, results=results: results.append(run()))  # type: ignore[misc]
        memory[name] = "?" if needed is None else f"{max(0, needed - 4 * height * width) / 2**20:.0f}"
        expected = results[0] if expected is None else expected
        difference[name] = float(np.abs(results[0] - expected).max())
        assert difference[name] < 1e-5 or name == "OpenVINO, its default", (name, difference[name])
    turns = max(3, min(21, round(PIXELS / (height * width))))
    rested, seconds = (in_turn(runs, turns, rest=REST, again=again) for again in (False, True))
    rows = []
    for name, values in seconds.items():
        rate = operations / float(np.median(values)) / 1e9
        rows.append(
            [
                f"{what}.{width}x{height}",
                name,
                spread(values, 1e3),
                f"{median_ratio(values, seconds['core']):.2f}",
                spread(rested[name], 1e3),
                f"{median_ratio(rested[name], rested['core']):.2f}",
                f"{rate:.0f}",
                f"{100 * rate / peak:.0f} %",
                memory[name],
                f"{difference[name]:.0e}",
            ]
        )
    return rows


def ladder_times(scene: bob.Scene) -> None:
    """Print the time of `complete` with each of the shipped networks, interleaved."""
    heading("Completing 640x480 with each network, all of bob.complete: milliseconds")
    part = bob.trace(scene, size=(480, 640), fraction=0.05)
    rows = {name: [name] for name in shipped_names()}
    for threads in (1, THREADS):
        bob.set_thread_count(threads)
        runs: dict[str, Run] = {name: partial(bob.complete, part, model=name) for name in rows}
        for name, seconds in in_turn(runs, 41).items():
            rows[name].append(spread(seconds, 1e3, 2))
    table(["model", "1 thread", f"{THREADS} threads"], list(rows.values()))


def size_times(scene: bob.Scene) -> None:
    """Print the time of `complete` for each pixel in pictures of several sizes, and the memory besides the picture."""
    heading("Completing, all of bob.complete, one thread: ns of processor time a pixel, MB besides the picture")
    bob.set_thread_count(1)
    rows = []
    for height, width in (SIZES[1], *SIZES[3:]):
        part = bob.trace(scene, size=(height, width), fraction=0.05)
        for name in ("filling", "default", "paper"):
            run = partial(bob.complete, part, model=name)
            needed = extra_memory(run)
            memory = "?" if needed is None else f"{max(0, needed - 4 * height * width) / 2**20:.0f}"
            (seconds,) = in_turn({name: run}, 7, clock=time.thread_time).values()
            rows.append([f"{name}.{width}x{height}", spread(seconds, 1e9 / (height * width), 1), memory])
    bob.set_thread_count(THREADS)
    table(["what", "ns", "MB"], rows)


def order_times() -> None:
    """Print the time to choose the first pixels of a 4K picture."""
    size = (2160, 3840)
    heading(f"Pixel orders: milliseconds for the first pixels of {size[1]}x{size[0]}, {bob.thread_count()} threads")
    rows = []
    for fraction in (0.05, 0.25, 1.0):
        first = round(fraction * size[0] * size[1])
        orders = {order: partial(bob.pixel_order, size, order=order, count=first) for order in FIXED_ORDERS}
        seconds = in_turn(orders, 7)
        for order, values in seconds.items():
            rows.append([f"order.{order}.{100 * fraction:g}%", spread(values, 1e3, 2)])
    table(["what", "ms"], rows)


def deciding_times() -> None:
    """Print the time of the adaptive order's next choice of pixels, including reading the previous ones."""
    heading("Adaptive order: deciding, one thread, on the built-in scene; medians of 7")
    rows = []
    for height, width in ((480, 640), (2160, 3840)):
        planes = bob.trace(bob.happy_tree(), size=(height, width)).planes
        for fraction in (0.05, 0.25, 1.0):
            runs = [deciding(planes, fraction) for _ in range(7)]
            pixels = sum(length for _, length in runs[0])
            total = statistics.median(sum(seconds for seconds, _ in run) for run in runs)
            longest = statistics.median(max(seconds for seconds, _ in run) for run in runs)
            rows.append(
                [
                    f"{100 * fraction:g} % of {width}x{height}",
                    f"{1e3 * total:.2f}",
                    str(len(runs[0])),
                    f"{1e3 * longest:.2f}",
                    f"{1e9 * total / pixels:.0f}",
                ]
            )
    table(["pixels", "ms in all", "rounds", "ms of the longest", "ns a pixel"], rows)


def deciding(planes: NDArray[np.float32], fraction: float) -> list[tuple[float, int]]:
    """Return seconds and pixels of each round."""
    size = planes.shape[1:]
    order, rounds, pixels = _core.AdaptiveOrder(0, *size), [], 0
    while pixels < round(fraction * size[0] * size[1]):
        start = time.perf_counter()
        length = len(order.next(TRACED.core, planes))
        rounds.append((time.perf_counter() - start, length))
        pixels += length
    return rounds


if __name__ == "__main__":
    main()
