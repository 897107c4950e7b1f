"""Cost of training on this machine.

Seconds to build the data set, milliseconds of a mini-batch from disk and of its training step, minutes of an epoch, and
memory.

    python bench/learn.py [--shapes 24]

The data set and the epoch are extrapolated from some of the 479 shapes, and from some of the steps.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import resource
import statistics
import tempfile
import time
from dataclasses import asdict
from pathlib import Path

import torch
from report import heading, spread, table

from bobrossnet.learn.config import OPTIMIZERS, TrainConfig
from bobrossnet.learn.dataset import Plan
from bobrossnet.learn.dataset.build import build
from bobrossnet.learn.dataset.loader import Batches
from bobrossnet.learn.losses import LOSSES
from bobrossnet.learn.networks import NETWORKS

STEPS = 40


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", type=int, default=24)
    shapes = parser.parse_args().shapes
    heading("Learning")
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        with contextlib.redirect_stderr(io.StringIO()):
            dataset = build(Path(folder) / "data", shapes=shapes, test_shapes=2)
        seconds = (time.perf_counter() - start) / shapes
        megabytes = sum(file.stat().st_size for file in Path(folder).rglob("*") if file.is_file()) / 1e6 / shapes

        batches = Batches(dataset, "train")
        batches[0]  # reads the first block
        made = []
        for step in range(1, STEPS):
            start = time.perf_counter()
            batch = batches[step]
            made.append(time.perf_counter() - start)

        config = TrainConfig()
        torch.set_num_threads(config.threads)
        network = NETWORKS[config.network].from_settings(asdict(config))
        network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        optimizer = OPTIMIZERS[config.optimizer][0](network, config)
        steps = {"one mini-batch repeated": [batch] * STEPS, "mini-batches from disk": batches.stream()}
        times: dict[str, list[float]] = {name: [] for name in steps}
        for name, source in steps.items():
            start = time.perf_counter()
            for step, batch in enumerate(source):
                partial = batch.partial.contiguous(memory_format=torch.channels_last)
                loss = LOSSES[config.loss](network(partial), batch.reference).mean()
                optimizer.zero_grad()
                loss.backward()  # type: ignore[no-untyped-call]
                optimizer.step()
                times[name].append(time.perf_counter() - start)
                start = time.perf_counter()
                if step + 1 == STEPS:
                    break
    plan = Plan()
    table(
        ["what", "measured", f"all {plan.shapes} shapes"],
        [
            ["data set", f"{seconds:.2f} s a shape", f"{seconds * plan.shapes / 60:.1f} min"],
            ["on disk", f"{megabytes:.2f} MB a shape", f"{megabytes * plan.shapes / 1000:.2f} GB"],
            ["making a mini-batch of 32, one thread", f"{spread(made, 1e3)} ms", ""],
        ]
        + [
            [
                f"training step, {name}",
                f"{spread(seconds_each, 1e3)} ms",
                f"{statistics.mean(seconds_each) * len(plan.split('train')) / 32 / 60:.1f} min an epoch",
            ]
            for name, seconds_each in times.items()
        ]
        + [["peak memory", f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20:.2f} GiB", ""]],
    )


if __name__ == "__main__":
    main()
