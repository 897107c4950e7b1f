"""The cost of sections: tracing a scene with and without one, alternating, in seconds of one thread's time.

OMP_NUM_THREADS=1 python bench/sections.py [FILE...]
"""

import statistics
import sys
import time
from functools import partial

from report import heading, in_turn, table

import bobrossnet as bob

SIZE = (480, 640)
RUNS = 7


def main() -> None:
    bob.set_thread_count(1)
    scenes = {file: bob.load(file) for file in sys.argv[1:]} or {"happy tree": bob.Scene(bob.happy_tree())}
    rows = []
    for name, scene in scenes.items():
        camera = bob.Camera(azimuth=30, elevation=25)
        ways = {"whole": scene}
        ways |= {f"{axis}": scene.sectioned(f"{axis}={scene.center[i]}") for i, axis in enumerate("xyz")}
        tracing = {way: partial(bob.trace, one, camera, size=SIZE) for way, one in ways.items()}
        seconds = in_turn(tracing, RUNS, clock=time.process_time)
        rows.append((name, *(f"{1000 * statistics.median(taken):.0f}" for taken in seconds.values())))
    heading(f"Tracing {SIZE[1]}x{SIZE[0]}, ms of one thread")
    table(("scene", "whole", "x", "y", "z"), rows)


if __name__ == "__main__":
    main()
