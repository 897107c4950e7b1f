"""The cost of sections: tracing a scene with and without one, alternating, in seconds of one thread's time.

OMP_NUM_THREADS=1 python bench/sections.py [FILE...]
"""

import resource
import statistics
import sys

import bobrossnet as bob

SIZE = (480, 640)
RUNS = 7


def seconds(scene: bob.Scene, camera: bob.Camera) -> float:
    before = resource.getrusage(resource.RUSAGE_SELF)
    bob.trace(scene, camera, size=SIZE)
    after = resource.getrusage(resource.RUSAGE_SELF)
    return after.ru_utime - before.ru_utime


def main() -> None:
    bob.set_thread_count(1)
    scenes = {file: bob.load(file) for file in sys.argv[1:]} or {"happy tree": bob.Scene(bob.happy_tree())}
    print(f"| scene, {SIZE[1]}x{SIZE[0]} | whole, ms | x, ms | y, ms | z, ms |\n|---|---|---|---|---|")
    for name, scene in scenes.items():
        camera = bob.Camera(azimuth=30, elevation=25)
        middle = [
            bob.Section(normal, scene.center[axis]) for axis, normal in enumerate(((1, 0, 0), (0, 1, 0), (0, 0, 1)))
        ]
        ways = [scene, *(scene.sectioned(section) for section in middle)]
        times: list[list[float]] = [[] for _ in ways]
        for _ in range(RUNS + 1):  # the first one warms up
            for way, taken in zip(ways, times, strict=True):
                taken.append(seconds(way, camera))
        medians = [1000 * statistics.median(taken[1:]) for taken in times]
        print(f"| {name} | " + " | ".join(f"{median:.0f}" for median in medians) + " |", flush=True)


if __name__ == "__main__":
    main()
