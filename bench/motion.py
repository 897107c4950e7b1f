"""Pictures with a moving camera, at 640x480, compared with smaller pictures in the same time.

Also the cost of reprojecting samples, and its gain on orbits. Meshes from the folder of models are added if it exists.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from report import MODELS, heading, replaced, table
from upscaling import edge_directed

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.frames import calls, motion, partial_picture, traced_frames
from bobrossnet.frames.traced_frames import RESHADED
from bobrossnet.sdf import X, Y, Z, box, cylinder, sphere

SIZE = (480, 640)
Mask = NDArray[np.bool_]
Clock = Callable[[], float]
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
PARTS = ("times", "costs", "orbits")
TIMES_MS = (5, 8, 12, 16, 25, 33)
LEVELS = 5
ORBIT = 30  # frames
VIEWS = 3
GEAR = Path(__file__).parents[1] / "examples" / "gear.sdf"
SAME_SURFACE = 0.01  # maximum difference of depth between two pictures of a point: about a pixel


def scenes() -> dict[str, bob.Scene]:
    hole = cylinder(0.5)
    part = (sphere(1) & box(1.5)) - (hole.orient(X) | hole.orient(Y) | hole.orient(Z))
    found = {"happy tree": bob.Scene(bob.happy_tree()), "CSG": bob.Scene(part)}
    files = [MODELS / name for name in MESHES if (MODELS / name).exists()]
    return found | {file.stem: bob.load(file) for file in files}


def uncovered(before: bob.GBuffer, camera_before: _core.Camera, now: bob.GBuffer, camera: _core.Camera) -> Mask:
    """Return a mask of disoccluded pixels: their surface is absent from another camera's picture of the scene."""
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
    """Return SSIM, flicker in gray levels, and the error of disoccluded pixels in gray levels.

    For pictures with reprojected samples, then for new pixels alone, then for the same number in the order `lattice`.
    """
    view = bob.View(scene, size=SIZE)
    found, before = [], None
    for k in range(FRAMES):
        camera = bob.Camera(azimuth=30 + step * k, elevation=20)
        image = view.frame(camera, fraction=share if k else first).image
        if k + 1 not in COUNTED and k not in COUNTED:
            continue
        full, in_core = bob.trace(scene, camera, size=SIZE), bob.SceneTracer(scene, camera, SIZE).camera_in_core
        pictures = image, *(bob.complete(full.sample(share, order=order)) for order in ("adaptive", "lattice"))
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
    """Return the milliseconds of one thread for each step of a frame, medians, after a wholly traced picture."""
    history, layout = _core.History(RESHADED.core, *SIZE), RESHADED
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
        timed("store", start)
        tracer = bob.SceneTracer(scene, bob.Camera(azimuth=30 + 2 * k), SIZE, layout)
        start = time.thread_time()
        history.expect(tracer.camera_in_core, expected, off_center, scene.core)
        timed("reproject", start)
        planes = np.zeros_like(planes)
        start = time.thread_time()
        order.begin(k)
        pixels = order.next(layout.core, planes, expected, off_center, round(NEW[0] * off_center.size))
        timed("choose pixels", start)
        _core.scatter(layout.core, pixels, tracer(pixels).values, planes)
    return {name: statistics.median(each) for name, each in times.items()}


def smaller(
    scene: bob.Scene, camera: bob.Camera, exact: NDArray[np.float32], clock: Clock
) -> list[tuple[float, float, float]]:
    """Return milliseconds and SSIM of pictures at all, half, a quarter … of the resolution.

    They are traced, then upsampled bilinearly and along edges, at no cost here.
    """
    found = []
    for level in range(LEVELS):
        times = []
        for _ in range(3):
            start = clock()
            image = bob.trace(scene, camera, size=(SIZE[0] >> level, SIZE[1] >> level)).gray
            times.append(1000 * (clock() - start))
        bilinear = np.asarray(Image.fromarray(image).resize(SIZE[::-1], Image.Resampling.BILINEAR))
        along_edges = edge_directed(image, *SIZE) if level else image
        found.append((statistics.median(times), bob.ssim(bilinear, exact), bob.ssim(along_edges, exact)))
    return found


def in_time(
    scene: bob.Scene, camera: bob.Camera, exact: NDArray[np.float32], ms: float, clock: Clock
) -> tuple[float, float, float]:
    """Return SSIM, milliseconds and share of pixels at the end of an orbit with a time budget per picture."""
    view, frames = bob.View(scene, size=SIZE), []
    for k in range(ORBIT):
        before = bob.Camera(azimuth=camera.azimuth - STEPS[0] * (ORBIT - 1 - k), elevation=camera.elevation)
        start = clock()
        frame = view.frame(before, ms=ms)
        frames.append((1000 * (clock() - start), frame.fraction))
    return bob.ssim(frame.image, exact), *np.median(frames[ORBIT // 2 :], 0)


def beside_smaller_pictures(shown: dict[str, bob.Scene], clock: Clock) -> None:
    heading(f"SSIM by the ms of a frame: orbits of {STEPS[0]}° a frame, and smaller pictures; means of {VIEWS} views")
    rows = []
    for name, scene in shown.items():
        scores = np.zeros((3, len(TIMES_MS), VIEWS))
        took = np.zeros((2, len(TIMES_MS), VIEWS))
        for i in range(VIEWS):
            camera = bob.Camera(azimuth=30 + 360 * i / VIEWS, elevation=20)
            exact = bob.trace(scene, camera, size=SIZE).gray
            levels = smaller(scene, camera, exact, clock)
            for k, ms in enumerate(TIMES_MS):
                scores[0, k, i], *took[:, k, i] = in_time(scene, camera, exact, ms, clock)
                scores[1:, k, i] = next((found[1:] for found in levels if found[0] <= ms), (np.nan, np.nan))
        means = scores.mean(-1)
        for way, mean in zip(("bob.View", "half resolution", "half, along edges"), means, strict=True):
            rows.append([name, way, *("–" if np.isnan(x) else f"{x:.3f}" for x in mean)])
        rows.append([name, "ms, % traced", *(f"{ms:.0f}, {100 * share:.0f}" for ms, share in took.mean(-1).T)])
    table(["scene", "picture", *(f"{ms} ms" for ms in TIMES_MS)], rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", help=f"of {', '.join(PARTS)}; by default all")
    parser.add_argument("--cpu", action="store_true", help="times are the process' own on one thread, on busy machines")
    options = parser.parse_args()
    parts, shown = options.parts or PARTS, scenes()
    if "times" in parts and not options.cpu:
        beside_smaller_pictures(shown | {"gear": bob.load(GEAR)}, time.perf_counter)
    elif "times" in parts:
        bob.set_thread_count(1)
        timer = SimpleNamespace(perf_counter=time.process_time)
        with replaced(*((module, "time", timer) for module in (calls, motion, partial_picture, traced_frames))):
            beside_smaller_pictures(shown | {"gear": bob.load(GEAR)}, time.process_time)
    if "costs" in parts:
        print_costs(shown)
    if "orbits" in parts:
        print_orbits(shown)


def print_costs(shown: dict[str, bob.Scene]) -> None:
    threads = bob.thread_count()
    bob.set_thread_count(1)
    heading("Reprojection, 640x480, orbit of 2° a frame: milliseconds of one thread")
    rows = {name: costs(scene) for name, scene in shown.items()}
    names = list(next(iter(rows.values())))
    table(["scene", *names], [[name, *(f"{row[each]:.1f}" for each in names)] for name, row in rows.items()])
    bob.set_thread_count(threads)


def print_orbits(shown: dict[str, bob.Scene]) -> None:
    ways = ("new alone", "lattice")
    columns = ["degrees a frame", "new pixels", "SSIM", *ways, "flicker", *ways, "uncovered", *ways]
    for first, what in ((0.02, "from nothing"), (1.0, "from an exact picture")):
        heading(
            f"Orbits at 640x480, {what}, with reprojected samples and with new pixels alone: means of frames "
            f"{COUNTED.start} to {COUNTED[-1]}; flicker and the error of uncovered pixels in gray levels"
        )
        cells = []
        for step in STEPS:
            for share in NEW:
                means = np.mean([orbit(scene, step, first, share) for scene in shown.values()], 0)
                cells.append(
                    [f"{step}", f"{share:.0%}", *(f"{x:.4f}" for x in means[:3]), *(f"{x:.2f}" for x in means[3:])]
                )
        table(columns, cells)


if __name__ == "__main__":
    main()
