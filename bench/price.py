"""Cost of a picture: the milliseconds of `bob.trace` and `bob.complete`, next to their errors.

For each pixel order at several shares of the pixels, and for smaller pictures, upsampled along edges at no cost. The
scenes are of every kind; runs alternate. Times are wall time, or, with `--cpu`, the process' CPU time on one thread,
for busy machines. `--quick` takes five scenes and fewer runs.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np
from implicit import solid
from report import MODELS, heading, in_turn, table
from sparse_rays import on_one_thread
from upscaling import edge_directed

import bobrossnet as bob
from bobrossnet.metrics import flip

SIZE = (480, 640)
SHARES = (0.01, 0.02, 0.035, 0.05, 0.07, 0.1, 0.15, 0.25)
LATTICE_SHARES = (*SHARES, 0.4)
SCALES = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7)
"""Sides of the smaller pictures."""
BUDGETS = (0.1, 0.2, 0.3, 0.5)
"""Errors are compared at these shares of the time of all pixels."""
ORDERS = ("priority", "adaptive", "squares", "lattice")
SMALLER = "smaller picture"
Times: TypeAlias = dict[str, float]
QUICK = ("tanglecube", "CSG", "ducky", "happy tree", "barkour_body")


@dataclass(frozen=True)
class Point:
    """A method of making the picture, with its errors."""

    way: str
    share: float  # of the pixels
    make: Callable[[], bob.GBuffer]
    ssim: float
    flip: float

    @property
    def name(self) -> str:
        return f"{self.way} {self.share}"


def scenes(names: Sequence[str]) -> Iterator[tuple[str, bob.Scene]]:
    """Yield scenes of every kind whose files exist. Expensive: bear, prospero, colonnade and conference_room."""
    made: dict[str, Callable[[], bob.SceneLike]] = {"CSG": solid, "happy tree": bob.happy_tree}
    files = (
        "implicit/bear.vm",
        "implicit/tanglecube.vm",
        "implicit/prospero.vm",
        "implicit/colonnade.vm",
        "nurbs/ducky.nurbs.json",
        "nurbs/gear.3dm",
        "nurbs/newell_teapot.bpt",
        "architecture/conference_room.ply",
        "scans/armadillo.ply",
        "robots/barkour_body.ply",
    )
    for file in files:
        if (MODELS / file).is_file():
            made[(MODELS / file).name.split(".")[0]] = partial(bob.load, MODELS / file)
        else:
            print(f"skipped {file}: no such file in {MODELS}; name the folder of shapes in BOBROSSNET_MODELS")
    for name, load in made.items():
        if not names or name in names:
            yield name, bob.Scene(load())


def traced_and_completed(scene: bob.Scene, camera: bob.Camera, share: float, order: str) -> bob.GBuffer:
    part = bob.trace(scene, camera, size=SIZE, fraction=share, order=order)
    bob.complete(part)
    return part


def points(scene: bob.Scene, camera: bob.Camera, full: bob.GBuffer) -> list[Point]:
    """Return all methods at all shares, with their errors."""
    result = []
    for order in ORDERS:
        for share in SHARES if order != "lattice" else LATTICE_SHARES:
            make = partial(traced_and_completed, scene, camera, share, order)
            image = bob.complete(make())
            result.append(Point(order, share, make, bob.ssim(image, full.gray), flip(image, full.gray)))
    for scale in SCALES:
        size = round(scale * SIZE[0]), round(scale * SIZE[1])
        make = partial(bob.trace, scene, camera, size=size)
        image = edge_directed(make().gray, *SIZE)
        result.append(Point(SMALLER, scale**2, make, bob.ssim(image, full.gray), flip(image, full.gray)))
    return result


def error_at(ms: float, times: Sequence[float], errors: Sequence[float]) -> float:
    """Return a method's error after `ms`, with its logarithm interpolated between shares; 1 before the first."""
    if ms < times[0]:
        return 1
    return float(np.exp(np.interp(ms, times, np.log(np.maximum(errors, 1e-6)))))


def milliseconds(
    scene: bob.Scene, camera: bob.Camera, ways: Sequence[Point], threads: int, runs: int, cpu: bool
) -> Times:
    """Return medians for all pixels, "all", and for each method, by name and share."""
    rivals: dict[str, Callable[[], object]] = {"all": partial(bob.trace, scene, camera, size=SIZE)}
    rivals |= {p.name: p.make for p in ways}
    if threads == 1:
        rivals = {name: on_one_thread(run) for name, run in rivals.items()}
    seconds = in_turn(rivals, runs, clock=time.process_time if cpu else time.perf_counter)
    return {name: 1e3 * statistics.median(each) for name, each in seconds.items()}


def whole_row(name: str, threads: int, ways: Sequence[Point], ms: Times) -> list[str]:
    """Return the cost of a call in the order "priority", and its errors."""
    row = [name, str(threads), f"{ms['all']:.1f}"]
    for point in ways:
        if point.way == "priority" and point.share in (0.05, 0.25):
            took = ms[point.name]
            row += [f"{took:.1f}", f"{took / ms['all']:.2f}", f"{point.ssim:.4f}", f"{point.flip:.4f}"]
    return row


def errors_at(ms_at: float, ways: Sequence[Point], ms: Times) -> dict[str, float]:
    """Return 1 - SSIM of each method after `ms_at`."""
    result = {}
    for way in (*ORDERS, SMALLER):
        own = [p for p in ways if p.way == way]
        times = [float(t) for t in np.maximum.accumulate([ms[p.name] for p in own])]
        result[way] = error_at(ms_at, times, [1 - p.ssim for p in own])
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="five scenes and fewer runs")
    parser.add_argument("--cpu", action="store_true", help="processor time of one thread instead of wall time")
    parser.add_argument("scenes", nargs="*", help="names; by default all")
    options = parser.parse_args()
    threads = [1] if options.cpu or bob.thread_count() == 1 else [bob.thread_count(), 1]
    camera = bob.Camera()
    whole_rows: list[list[str]] = []
    equal_rows: dict[int, list[list[str]]] = {count: [] for count in threads}
    ahead: dict[int, list[tuple[float, float]]] = {count: [] for count in threads}
    for name, scene in scenes(options.scenes or (QUICK if options.quick else ())):
        ways = points(scene, camera, bob.trace(scene, camera, size=SIZE))
        for count in threads:
            ms = milliseconds(scene, camera, ways, count, 5 if options.quick else 9, options.cpu)
            whole_rows.append(whole_row(name, count, ways, ms))
            cells = []
            for budget in BUDGETS:
                errors = errors_at(budget * ms["all"], ways, ms)
                cells.append(" / ".join("–" if e == 1 else f"{1e3 * e:.2f}" for e in errors.values()))
                if errors["priority"] < 1:  # its first picture is ready by then
                    orders = min(errors[way] for way in ORDERS if way != "priority")
                    ahead[count].append((1 - errors["priority"] / orders, 1 - errors["priority"] / errors[SMALLER]))
            equal_rows[count].append([name, f"{ms['all']:.1f}", *cells])
    kind = "processor time" if options.cpu else "wall time"
    heading(f"A picture's price, 640x480, bob.trace and bob.complete: milliseconds, {kind}, medians")
    table(
        ["scene", "threads", "all pixels", *("5 %", "/ all", "SSIM", "FLIP"), *("25 %", "/ all", "SSIM", "FLIP")],
        whole_rows,
    )
    for count in threads:
        names = " / ".join((*ORDERS, SMALLER))
        heading(f"1000 (1 − SSIM) after as many milliseconds, threads: {count}, {names}")
        table(["scene", "all pixels, ms", *(f"{budget:.0%} of that" for budget in BUDGETS)], equal_rows[count])
        of_orders, of_smaller = (f"{statistics.median(each):.0%}" for each in zip(*ahead[count], strict=True))
        print(f"\nIn the median cell, priority's is {of_orders} below the orders', {of_smaller} below the smaller's.")


if __name__ == "__main__":
    main()
