"""Cost of a ray in sparse and in full pictures: a table for shapes of any kind."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping
from functools import partial

from report import heading, in_turn, median_ratio, table

import bobrossnet as bob
from bobrossnet.tracing.pixels import tiled_pixels
from bobrossnet.tracing.trace import SceneTracer

SIZE = (512, 512)
RUNS = 9
SHARES = (0.01, 0.05, 0.25, 1)


def on_one_thread(run: Callable[[], object]) -> Callable[[], object]:
    def alone() -> None:
        threads = bob.thread_count()
        bob.set_thread_count(1)
        run()
        bob.set_thread_count(threads)

    return alone


def sparse_row(name: str, scene: bob.Scene, camera: bob.Camera) -> list[str]:
    trace = SceneTracer(scene, camera, SIZE)
    order = bob.pixel_order(SIZE, order="lattice")
    pixels = {share: order[: round(share * len(order))] for share in SHARES}
    pixels[1] = tiled_pixels(SIZE)  # the order of `bob.trace` for all pixels
    runs = {f"{share:.0%}": on_one_thread(partial(trace, some)) for share, some in pixels.items()}
    seconds = in_turn(runs, RUNS, clock=time.thread_time)
    each = {share: [1e6 * s / len(some) for s in seconds[f"{share:.0%}"]] for share, some in pixels.items()}
    return [
        name,
        *(f"{statistics.median(each[share]):.2f}" for share in SHARES),
        *(f"{median_ratio(each[share], each[1]):.2f}" for share in SHARES if share < 1),
    ]


def sparse_table(what: str, scenes: Mapping[str, bob.Scene], camera: bob.Camera) -> None:
    """Print the table, with its heading."""
    heading(f"{what}, sparse and dense, 512x512, lattice order, one thread: microseconds of processor time a ray")
    shares = [f"{share:.0%}" for share in SHARES]
    columns = ["shape", *shares, *(f"{share} / 100%" for share in shares[:-1])]
    table(columns, [sparse_row(name, scene, camera) for name, scene in scenes.items()])
