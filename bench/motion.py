"""Pictures whose camera moves: what carrying samples along costs at 640x480, and what it is worth on orbits.

Meshes of other people join the built-in shapes where their folder is there.
"""

from __future__ import annotations

import statistics
import time

import numpy as np
from numpy.typing import NDArray
from report import MODELS, heading, table

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.motion import SHADED_ANEW
from bobrossnet.sdf import X, Y, Z, box, cylinder, sphere

SIZE = (480, 640)
Mask = NDArray[np.bool_]
MESHES = (
    "scans/igea.ply",
    "mechanical/differential_ring_gear.ply",
    "vehicles/airliner.ply",
    "furniture_household/armchair.ply",
)
STEPS = (2, 4, 10)  # degrees between frames
FRAMES = 15
COUNTED = range(9, FRAMES, 2)
NEW = (0.02, 0.05, 0.10)
SAME_SURFACE = 0.01  # of depth, between two pictures of a point: a pixel or so


def scenes() -> dict[str, bob.Scene]:
    hole = cylinder(0.5)
    part = (sphere(1) & box(1.5)) - (hole.orient(X) | hole.orient(Y) | hole.orient(Z))
    found = {"happy tree": bob.Scene(bob.happy_tree()), "CSG": bob.Scene(part)}
    files = [MODELS / name for name in MESHES if (MODELS / name).exists()]
    return found | {file.stem: bob.load(file) for file in files}


def uncovered(before: bob.GBuffer, camera_before: _core.Camera, now: bob.GBuffer, camera: _core.Camera) -> Mask:
    """Which pixels show a surface that another camera's picture of the same scene did not."""
    hit = now.depth > 0
    at = np.column_stack([*np.nonzero(hit), now.depth[hit]]).astype(np.float32)
    row, column, depth = camera_before.seen(*SIZE, camera.points(*SIZE, at)).T
    row, column = np.round(row).astype(int), np.round(column).astype(int)
    inside = (row >= 0) & (row < SIZE[0]) & (column >= 0) & (column < SIZE[1])
    seen = np.zeros(len(row), bool)
    seen[inside] = np.abs(before.depth[row[inside], column[inside]] - depth[inside]) < SAME_SURFACE
    result = np.zeros(SIZE, bool)
    result[hit] = ~seen
    return result


def orbit(scene: bob.Scene, step: float, first: float, share: float) -> list[float]:
    """Of pictures with samples carried along, and then of new pixels alone: SSIM, flicker in gray levels, and by how
    many gray levels uncovered pixels are wrong."""
    view = bob.View(scene, size=SIZE)
    found, before = [], None
    for k in range(FRAMES):
        camera = bob.Camera(azimuth=30 + step * k, elevation=20)
        image = view.frame(camera, fraction=share if k else first).image
        if k + 1 not in COUNTED and k not in COUNTED:
            continue
        full, in_core = bob.trace(scene, camera, size=SIZE), bob.SceneTracer(scene, camera, SIZE).camera_in_core
        pictures = image, bob.complete(full.sample(share))
        if k in COUNTED and before is not None:
            full_before, core_before, pictures_before = before
            new, truth = uncovered(full_before, core_before, full, in_core), full.gray - full_before.gray
            found.append(
                [
                    [
                        bob.ssim(picture, full.gray),
                        255 * np.abs(picture - other - truth).mean(),
                        255 * np.abs(picture - full.gray)[new].mean(),
                    ]
                    for picture, other in zip(pictures, pictures_before, strict=True)
                ]
            )
        before = full, in_core, pictures
    return [float(x) for x in np.mean(found, 0).T.ravel()]


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
        pixels = order.next(layout.core, planes, expected, off_center, round(NEW[0] * off_center.size))
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
    columns = ["degrees a frame", "new pixels", "SSIM", "anew", "flicker", "anew", "uncovered", "anew"]
    for first, what in ((0.02, "from nothing"), (1.0, "from an exact picture")):
        heading(
            f"Orbits at 640x480, {what}, with samples carried along and with new pixels alone: means of frames "
            f"{COUNTED.start} to {COUNTED[-1]}; flicker, and how wrong uncovered pixels are, in gray levels"
        )
        cells = []
        for step in STEPS:
            for share in NEW:
                means = np.mean([orbit(scene, step, first, share) for scene in shown.values()], 0)
                cells.append(
                    [f"{step}", f"{share:.0%}", *(f"{x:.4f}" for x in means[:2]), *(f"{x:.2f}" for x in means[2:])]
                )
        table(columns, cells)


if __name__ == "__main__":
    main()
