"""Pictures whose camera moves: what carrying samples along costs at 640x480, and what it is worth on orbits.

Meshes of other people join the built-in shapes where their folder is there.
"""

from __future__ import annotations

import statistics
import time

import numpy as np
from report import MODELS, heading, table

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.motion import SHADED_ANEW
from bobrossnet.sdf import X, Y, Z, box, cylinder, sphere

SIZE = (480, 640)
MESHES = (
    "scans/igea.ply",
    "mechanical/differential_ring_gear.ply",
    "vehicles/airliner.ply",
    "furniture_household/armchair.ply",
)
STEPS = (2, 4, 10)  # degrees between frames
FRAMES = 15
COUNTED = range(9, FRAMES, 2)
NEW = 0.02
ANEW = (0.02, 0.05, 0.10)


def scenes() -> dict[str, bob.Scene]:
    hole = cylinder(0.5)
    part = (sphere(1) & box(1.5)) - (hole.orient(X) | hole.orient(Y) | hole.orient(Z))
    found = {"happy tree": bob.Scene(bob.happy_tree()), "CSG": bob.Scene(part)}
    files = [MODELS / name for name in MESHES if (MODELS / name).exists()]
    return found | {file.stem: bob.load(file) for file in files}


def orbit(scene: bob.Scene, step: float, first: float) -> list[float]:
    """SSIM with samples carried along, of new pixels alone, and flicker of the first two, in gray levels."""
    view = bob.View(scene, size=SIZE)
    scores, flicker, before = [], [], None
    for k in range(FRAMES):
        camera = bob.Camera(azimuth=30 + step * k, elevation=20)
        image = view.frame(camera, fraction=NEW if k else first).image
        if k + 1 not in COUNTED and k not in COUNTED:
            continue
        full = bob.trace(scene, camera, size=SIZE)
        anew = [bob.complete(full.sample(share)) for share in ANEW]
        if k in COUNTED and before is not None:
            scores.append([bob.ssim(picture, full.gray) for picture in (image, *anew)])
            truth = full.gray - before[0].gray
            flicker.append([255 * np.abs(p - q - truth).mean() for p, q in ((image, before[1]), (anew[0], before[2]))])
        before = full, image, anew[0]
    return [*np.mean(scores, 0), *np.mean(flicker, 0)]


def costs(scene: bob.Scene) -> dict[str, float]:
    """Milliseconds of one thread for each step of a frame, medians, after a picture that was traced whole."""
    history, layout = _core.History(SHADED_ANEW.core, *SIZE), SHADED_ANEW
    camera = bob.Camera()
    tracer = bob.SceneTracer(scene, camera, SIZE, layout)
    planes = np.zeros((layout.width, *SIZE), np.float32)
    samples = tracer(bob.pixel_order(SIZE))
    _core.scatter(layout.core, bob.pixel_order(SIZE), samples.values, planes)
    expected, off_center = np.empty_like(planes), np.empty(SIZE, np.float32)
    order = _core.RefreshOrder(*SIZE)
    times: dict[str, list[float]] = {}

    def timed(name: str, start: float) -> None:
        times.setdefault(name, []).append(1000 * (time.thread_time() - start))

    for k in range(1, 16):
        start = time.thread_time()
        history.add(tracer.camera_in_core, planes)
        timed("take over", start)
        tracer = bob.SceneTracer(scene, bob.Camera(azimuth=30 + 2 * k), SIZE, layout)
        start = time.thread_time()
        history.expect(tracer.camera_in_core, expected, off_center)
        timed("carry along", start)
        start = time.thread_time()
        tracer.shade(expected)
        timed("shade", start)
        planes = np.zeros_like(planes)
        start = time.thread_time()
        order.begin(k)
        pixels = order.next(layout.core, planes, expected, off_center, round(NEW * off_center.size))
        timed("choose pixels", start)
        _core.scatter(layout.core, pixels, tracer(pixels).values, planes)
    return {name: statistics.median(each) for name, each in times.items()}


def main() -> None:
    shown = scenes()
    threads = bob.thread_count()
    bob.set_thread_count(1)
    heading("Carrying samples along, 640x480, orbit of 2° a frame: milliseconds of one thread")
    rows = {name: costs(scene) for name, scene in shown.items()}
    names = list(next(iter(rows.values())))
    table(["scene", *names], [[name, *(f"{row[each]:.1f}" for each in names)] for name, row in rows.items()])
    bob.set_thread_count(threads)
    for first, what in ((NEW, "from nothing"), (1.0, "from an exact picture")):
        heading(
            f"Orbits at 640x480, {what}: mean SSIM of frames {COUNTED.start} to {COUNTED[-1]}; flicker in gray levels"
        )
        columns = ["degrees a frame", f"{NEW:.0%} carried along", *(f"{share:.0%} anew" for share in ANEW)]
        cells = []
        for step in STEPS:
            means = np.mean([orbit(scene, step, first) for scene in shown.values()], 0)
            cells.append([f"{step}", *(f"{x:.4f}" for x in means[:-2]), *(f"{x:.2f}" for x in means[-2:])])
        table([*columns, "flicker", f"of {NEW:.0%} anew"], cells)


if __name__ == "__main__":
    main()
