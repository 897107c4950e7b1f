"""Gain of each constant of the frame planner: orbits with and without it.

Pictures are real and times are simulated, so that every run gives the same numbers: rays, completion and reprojection
take the times below, and five times as long at their first run.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from motion import scenes
from report import replaced, table

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.frames import calls, motion, partial_picture, traced_frames
from bobrossnet.frames.planner import Planner

SIZE = (240, 320)
FRAMES = 40
SETTLED = 15
"""Frames before the compared ones."""
SCENES = 3
BUDGETS_MS = (3, 8)
STEP = 2.0
"""Degrees per frame."""
SPEEDS = {"fast": 20e-9, "medium": 200e-9, "slow": 3e-6}
"""Seconds per ray of a whole picture."""
DEARER = {"whole": 1.0, "squares": 1.3, "adaptive": 2.5, "reproject": 2.5}
"""Cost of a ray in each mode, relative to that."""
PER_CALL = 50e-6
COMPLETING = {"filling": 4e-9, "default": 13e-9}
"""Seconds per pixel."""
REPROJECTING = 12e-9
COLD = 5
NOISE = 0.15
WITHOUT: dict[str, dict[str, float]] = {
    "as it is": {},
    "untried 1": {"untried": 1.0},
    "doubt 0": {"doubt": 0.0},
    "floor 0": {"floor": 0.0},
    "fade 0": {"fade": 0.0},
    "margin 1": {"margin": 1.0},
    "growth 1e9": {"growth": 1e9},
}


class Clock:
    """A simulated clock, advanced by work with noise; the first work of each kind takes longer."""

    def __init__(self) -> None:
        self.now = 0.0
        self._seen: dict[str, int] = {}
        self._random = np.random.default_rng(1)

    def perf_counter(self) -> float:
        return self.now

    def work(self, kind: str, seconds: float) -> None:
        times = self._seen[kind] = self._seen.get(kind, 0) + 1
        self.now += seconds * (COLD if times == 1 else 1) * float(np.exp(NOISE * self._random.normal()))


@contextmanager
def simulated(clock: Clock, view_of: Any, ray: float) -> Iterator[None]:
    """Make the work of frames advance the clock."""
    complete, trace = bob.complete, bob.SceneTracer.__call__

    def timed_complete(shown: bob.GBuffer, model: Any) -> Any:
        if not shown.mask.all():
            name = next(name for name, network in view_of().networks.items() if network is model)
            clock.work(name, COMPLETING[name] * shown.mask.size)
        return complete(shown, model=model)

    def timed_trace(self: bob.SceneTracer, pixels: Any) -> bob.Samples:
        mode = view_of().mode
        clock.work(mode, PER_CALL + DEARER[mode] * ray * len(pixels))
        return trace(self, pixels)

    class TimedHistory(_core.History):
        def expect(self, camera: Any, planes: Any, *more: Any) -> int:
            clock.work("reprojecting", REPROJECTING * planes[0].size)
            return super().expect(camera, planes, *more)

    timer = SimpleNamespace(perf_counter=clock.perf_counter)
    with replaced(
        (partial_picture, "complete", timed_complete),
        *((module, "time", timer) for module in (calls, motion, partial_picture, traced_frames)),
        (_core, "History", TimedHistory),
        (bob.SceneTracer, "__call__", timed_trace),
    ):
        yield


@dataclass
class Orbit:
    """1 - SSIM, flicker in gray levels, share of frames over a tenth late, and number of mode changes."""

    error: float
    flicker: float
    late: float
    changes: float


def orbit(scene: bob.Scene, truth: list[Any], ms: float, ray: float, constants: dict[str, float]) -> Orbit:
    chosen = _core.FrameConstants()
    for name, value in constants.items():
        setattr(chosen, name, value)
    clock = Clock()
    held: dict[str, Any] = {}

    def state() -> Any:
        picture = getattr(held.get("frames"), "picture", None)
        return SimpleNamespace(networks=held["networks"], mode=picture.mode if picture else "adaptive")

    class Tried(Planner):
        def __init__(self, size: Any, model: Any, order: str = "adaptive") -> None:
            super().__init__(size, model, order)
            held["networks"] = self.networks
            self.core = _core.FramePlanner(size[0] * size[1], list(self.networks), chosen)

    error, flicker, late, modes, before = [], [], [], [], None
    with replaced((motion, "Planner", Tried)), simulated(clock, state, ray):
        view = bob.View(scene, size=SIZE)
        held["frames"] = frames = view._frames
        assert isinstance(frames, traced_frames.TracedFrames)
        for k, exact in enumerate(truth):
            start = clock.now
            image = view.frame(bob.Camera(azimuth=30 + STEP * k), ms=ms).image
            if k >= SETTLED and before is not None:
                error.append(1 - bob.ssim(image, exact))
                late.append(clock.now - start > 1.1 * ms / 1000)
                modes.append(frames.picture.mode)
                flicker.append(255 * np.abs(image - before - (exact - truth[k - 1])).mean())
            before = image
    changes = sum(a != b for a, b in itertools.pairwise(modes))
    return Orbit(float(np.mean(error)), float(np.mean(flicker)), float(np.mean(late)), changes)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.parse_args()
    rows: dict[str, list[Orbit]] = {name: [] for name in WITHOUT}
    for scene in list(scenes().values())[:SCENES]:
        truth = [bob.trace(scene, bob.Camera(azimuth=30 + STEP * k), size=SIZE).gray for k in range(FRAMES)]
        for ray in SPEEDS.values():
            for ms in BUDGETS_MS:
                for name, constants in WITHOUT.items():
                    rows[name].append(orbit(scene, truth, ms, ray, constants))
    table(
        ["constants", "1 - SSIM", "flicker", "late", "changes of mode"],
        [
            [
                name,
                *(
                    f"{np.mean([getattr(o, column) for o in orbits]):.{digits}f}"
                    for column, digits in (("error", 4), ("flicker", 3), ("late", 3), ("changes", 2))
                ),
            ]
            for name, orbits in rows.items()
        ],
    )


if __name__ == "__main__":
    main()
