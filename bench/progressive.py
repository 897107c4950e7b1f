"""Time budgets of progressive pictures: each frame until convergence at 640x480.

Uses the built-in tracer, and user tracers that are 10 and 100 times slower in wall time.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray
from report import heading, in_turn, table

import bobrossnet as bob
from bobrossnet.tracing.trace import Tracer

SIZE = (480, 640)
BUDGETS_MS = (33, 100)


def slowed(tracer: Tracer, seconds_per_ray: float) -> Tracer:
    """Return the tracer slowed down to a time per ray, by waiting."""

    def trace(pixels: NDArray[np.int32]) -> bob.Samples:
        end = time.perf_counter() + seconds_per_ray * len(pixels)
        samples = tracer(pixels)
        while time.perf_counter() < end:
            pass
        return samples

    return trace


def frame_times(
    begin: Callable[..., Iterator[bob.Frame]], budget_ms: float, full: bob.GBuffer
) -> tuple[list[float], float]:
    """Return the consumer's waiting time in milliseconds for each frame of a convergence, and the first one's SSIM."""
    times: list[float] = []
    frames = begin(size=SIZE, frame_ms=budget_ms)
    first = None
    start = time.perf_counter()
    for frame in frames:
        times.append(1000 * (time.perf_counter() - start))
        first = frame if first is None else first
        start = time.perf_counter()
    assert first is not None
    assert np.array_equal(frame.image, full.gray)
    return times, bob.ssim(first.image, full.gray)


def main() -> None:
    scene = bob.Scene(bob.happy_tree())
    ours = bob.SceneTracer(scene, bob.Camera(), SIZE)
    full = bob.trace(scene, size=SIZE)
    pixels = bob.pixel_order(SIZE)
    ray = statistics.median(in_turn({"ours": partial(ours, pixels)}, 9)["ours"]) / len(pixels)
    heading(f"Progressive pictures, 640x480: milliseconds a frame, as its consumer sees it ({1e9 * ray:.0f} ns a ray)")
    rows = []
    for name, begin, convergences in (
        ("built-in", partial(bob.progressive, scene), 30),
        ("10 x slower", partial(bob.progressive, tracer=slowed(ours, 10 * ray)), 6),
        ("100 x slower", partial(bob.progressive, tracer=slowed(ours, 100 * ray)), 2),
    ):
        for budget in BUDGETS_MS:
            runs = [frame_times(begin, budget, full) for _ in range(convergences)]
            times = [t for run, _ in runs for t in run]
            p95 = float(np.percentile(times, 95))
            rows.append(
                [
                    name,
                    f"{budget} ms",
                    f"{len(times) / convergences:.1f}",
                    f"{np.median(times):.1f}",
                    f"{p95:.1f}",
                    f"{max(times):.1f}",
                    f"{p95 / budget:.2f}",
                    f"{np.mean([ssim for _, ssim in runs]):.3f}",
                ]
            )
    table(["tracer", "budget", "frames", "median", "95 %", "max", "95 % / budget", "SSIM of the first frame"], rows)


if __name__ == "__main__":
    main()
