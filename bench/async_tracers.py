"""Gain of concurrent calls with slow pixels: seconds to the frame of 5 % of the pixels, by number of workers.

A pixel takes 2 ms in a process of a pool, where it sleeps, as if on separate machines. Prints the table of
docs/tracers.md.
"""

from __future__ import annotations

import multiprocessing
import statistics
import time
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor

import numpy as np
from numpy.typing import NDArray
from report import heading, table

import bobrossnet as bob

SIZE = (480, 640)
SHARE = 0.05
PIXEL_SECONDS = 2e-3
WORKERS = (1, 2, 4, 8, 16)
CAMERA = bob.Camera(azimuth=30)


class Slow:
    """The core's tracer with artificially slow pixels."""

    size = SIZE

    def __init__(self) -> None:
        self.trace = bob.SceneTracer(bob.happy_tree(), CAMERA, SIZE)

    def __call__(self, pixels: NDArray[np.int32]) -> bob.Samples:
        time.sleep(PIXEL_SECONDS * len(pixels))
        return self.trace(pixels)


slow: Slow
"""One tracer in each process."""


def begin() -> None:
    global slow
    slow = Slow()


def in_process(pixels: NDArray[np.int32]) -> bob.Samples:
    return slow(pixels)


class Pooled:
    """The slow tracer in a pool of processes."""

    size = SIZE

    def __init__(self, pool: ProcessPoolExecutor, workers: int) -> None:
        self.pool, self.in_flight = pool, workers

    def __call__(self, pixels: NDArray[np.int32]) -> Future[bob.Samples]:
        return self.pool.submit(in_process, pixels)


def frames_to_share(frames: Iterator[bob.Frame]) -> tuple[list[bob.Frame], float]:
    """Return the frames up to the first with the share, and the seconds until it arrives."""
    shown = []
    start = time.perf_counter()
    for frame in frames:
        shown.append(frame)
        if frame.fraction >= SHARE:
            break
    return shown, time.perf_counter() - start


def main() -> None:
    full = bob.trace(bob.happy_tree(), CAMERA, size=SIZE)
    picture = f"{SHARE:.0%} of {SIZE[1]}x{SIZE[0]}"
    heading(f"{picture}, {1e3 * PIXEL_SECONDS:g} ms a pixel: seconds until they are shown")
    rows = []

    def measure(name: str, tracer: Slow | Pooled, best: float) -> None:
        (first,), seconds = frames_to_share(bob.progressive(tracer=tracer, first=SHARE))
        paced, paced_seconds = frames_to_share(bob.progressive(tracer=tracer, frame_ms=100))
        median = 1e3 * statistics.median(frame.seconds for frame in paced)
        ssim = f"{bob.ssim(first.image, full.gray):.3f}"
        rows.append([name, f"{seconds:.1f}", f"{best:.1f}", ssim, f"{paced_seconds:.1f}", f"{median:.0f}"])

    best = SHARE * SIZE[0] * SIZE[1] * PIXEL_SECONDS
    measure("samples, one call after the other", Slow(), best)
    for workers in WORKERS:
        with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), begin) as pool:
            list(pool.map(time.sleep, [1] * workers))  # every worker has started
            measure(f"futures, {workers} worker{'s' * (workers > 1)}", Pooled(pool, workers), best / workers)
    table(["tracer", "first=0.05", "at best", "SSIM", "frame_ms=100", "median ms of a frame"], rows)


if __name__ == "__main__":
    main()
