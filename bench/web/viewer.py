"""The viewer's page in Chromium: latency, memory and size, and its pictures compared with rivals.

The rivals halve the resolution until all pixels can be traced in time, and upsample the small picture, bilinearly or
along edges, at no cost here. All have one thread and the same time for each frame, for tracing and completion. Needs
the wheel playwright and a Chromium.

Meshes are read from the folder in BOBROSSNET_MODELS; without it, their rows are omitted.
"""

from __future__ import annotations

import argparse
import base64
import itertools
import json
import os
import shutil
import statistics
import sys
import tempfile
import threading
import time
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

import bobrossnet as bob
from bobrossnet.page.files import GALLERY, READ_IN_PAGE, page_files
from bobrossnet.page.server import Server
from bobrossnet.picture.files import color_to_8_bit
from bobrossnet.support.paths import VIEWER

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from report import MODELS, heading, table  # noqa: E402
from upscaling import edge_directed  # noqa: E402

WIDTH, HEIGHT = 640, 480
SIZE = f"?size={WIDTH}x{HEIGHT}"
MESHES = {
    "scans/stanford_bunny.ply": "bunny",
    "scans/armadillo.ply": "armadillo",
    "loader_originals/glb_material/CesiumMilkTruck.glb": "textured truck",
    "scans/kitten.ply": "kitten",
}
FURTHER = ("scans/kitten.ply",)
SCENES = {"gallery/happy_tree.bob": "happy tree", "gallery/csg.sdf": "CSG", "gallery/gear.sdf": "gear"}

FOLDERS = ("loader_originals", "broken_odd", "nurbs", "implicit", "scans")

TIMES_MS = (33, 50, 75, 100, 150, 250, 400, 700, 1200)
LEVELS = 6
STEP, BEFORE = 2, 8  # degrees between the pictures of an orbit, and number of pictures before the compared one
WAYS = ("completed, in motion", "completed, anew", "half resolution", "half, along edges")

ORBIT = """
async ([milliseconds, degrees]) => {
  const { statistics } = bobrossnet, first = statistics.pictures, start = bobrossnet.camera().azimuth;
  const fractions = [], completing = [], gaps = [], begin = performance.now();
  let last = begin;
  const shown = () => {
    fractions.push(statistics.fraction), completing.push(statistics.completing);
    gaps.push(performance.now() - last);
    last = performance.now();
  };
  document.addEventListener("progress", shown, true);
  for (let now = begin; now < begin + milliseconds; now = performance.now()) {
    bobrossnet.look({ azimuth: (start + degrees * (now - begin) / 1000) % 360 });
    await new Promise(requestAnimationFrame);
  }
  document.removeEventListener("progress", shown, true);
  const seconds = (performance.now() - begin) / 1000;
  return { rate: (statistics.pictures - first) / seconds, fractions, completing, gaps, rays: statistics.raysPerSecond };
}
"""

SECTION = """
async ([milliseconds, edges]) => {
  const { statistics } = bobrossnet, picture = document.querySelector("#picture"), { box } = await picture.about();
  picture.toggleAttribute("edges", edges);
  const first = statistics.pictures, fractions = [], begin = performance.now();
  const shown = () => fractions.push(statistics.fraction);
  picture.addEventListener("progress", shown);
  for (let now = begin; now < begin + milliseconds; now = performance.now()) {
    const share = 0.5 - 0.4 * Math.cos((now - begin) / 1000);
    picture.setAttribute("section", `x=${(box[0] + share * (box[3] - box[0])).toFixed(6)}`);
    await new Promise(requestAnimationFrame);
  }
  picture.removeEventListener("progress", shown);
  const pictures = statistics.pictures - first, seconds = (performance.now() - begin) / 1000;
  return { pictures, rate: pictures / seconds, fractions, rays: statistics.raysPerSecond };
}
"""

WINDOWS = ((1280, 800), (1920, 1080), (2560, 1440))
RATIOS = (1, 3)

REST = """
async (azimuth) => {
  const { statistics } = bobrossnet, begin = performance.now();
  let exact, pictures = 0;
  const seen = () => {
    ++pictures;
    if (statistics.exact) exact ??= performance.now() - begin;
  };
  document.addEventListener("progress", seen, true);
  bobrossnet.look({ azimuth });
  await bobrossnet.converged();
  document.removeEventListener("progress", seen, true);
  const { width, height } = document.querySelector("#picture").shadowRoot.querySelector("canvas");
  return { exact, smoothed: performance.now() - begin, pictures, width, height };
}
"""

# Milliseconds until the first picture of another camera, and until the last.
LIT = """
async (azimuth) => {
  await measured();
  const begin = performance.now();
  const shown = new Promise((resolve) => document.addEventListener("progress", resolve, { once: true, capture: true }));
  bobrossnet.look({ azimuth });
  await shown;
  const first = performance.now() - begin;
  await measured();
  await bobrossnet.converged();
  const last = performance.now() - begin;
  await measured();
  return [first, last];
}
"""

WHOLE = """
(settings) => new Promise((resolve, reject) => {
  const worker = new Worker("whole.js", { type: "module" });
  worker.onmessage = ({ data }) => {
    worker.terminate();
    data.error ? reject(new Error(data.error)) : resolve(data);
  };
  worker.onerror = (event) => reject(new Error(event.message));
  worker.postMessage(settings);
})
"""

# The last picture of an orbit, and its camera.
MOVED = """
async ([pictures, degrees]) => {
  const view = document.querySelector("#picture");
  let batch;
  for (let i = 0; i < pictures; ++i) {
    const next = new Promise((shown) => view.addEventListener("progress", shown, { once: true }));
    bobrossnet.look({ azimuth: bobrossnet.camera().azimuth + degrees });
    ({ batch } = (await next).detail);
  }
  return { picture: view.toDataURL(), camera: batch.camera };
}
"""

COMPARE = """
(settings) => new Promise((resolve, reject) => {
  const worker = new Worker("rival.js", { type: "module" });
  worker.onmessage = ({ data }) => (data.error ? reject(new Error(data.error)) : resolve(data));
  worker.onerror = (event) => reject(new Error(event.message));
  worker.postMessage(settings);
})
"""

DROP = """
async ([address, name]) => {
  const file = new File([await (await fetch(address)).blob()], name);
  await bobrossnet.openFile({ title: name }, name, file);
  return document.querySelector("#picture").alt !== `Picture of ${name}`;
}
"""

FIRST_PICTURE = 'document.addEventListener("progress", () => { window.firstPicture ??= performance.now(); }, true);'

# Whether the page's workers may share memory, and a script for it: on most servers they may not.
SHARING = {
    "shared memory": "",
    "alone": 'Object.defineProperty(globalThis, "crossOriginIsolated", { value: false });',
}

OPEN = """
async (file) => {
  const begin = performance.now();
  await bobrossnet.openFile({ title: file }, file, file);
  await new Promise((shown) => document.addEventListener("progress", shown, { once: true, capture: true }));
  return performance.now() - begin;
}
"""

LONG_TASKS = """
window.tasks = [];
const observer = new PerformanceObserver((list) => tasks.push(...list.getEntries().map((entry) => entry.duration)));
observer.observe({ type: "longtask" });
"""


def opened(browser: Browser, address: str, *scripts: str, **context: Any) -> Page:
    """Open the page, and wait for its scene."""
    page = browser.new_context(**context).new_page()
    for script in scripts:
        page.add_init_script(script)
    page.goto(address)
    page.evaluate("() => bobrossnet.started")
    return page


# ---- Speed -----------------------------------------------------------------------------------------------


def orbiting(browser: Browser, url: str, scenes: dict[str, str], seconds: float) -> None:
    heading(f"Orbiting, {WIDTH}x{HEIGHT}, the default budget of 33 ms")
    rows = []
    for file, name in scenes.items():
        page = opened(browser, f"{url}{SIZE}&scene={file}")
        page.evaluate("() => bobrossnet.converged()")
        page.evaluate(ORBIT, [2000, 60])  # until all code is compiled
        found = page.evaluate(ORBIT, [1000 * seconds, 60])
        rows.append(
            (
                name,
                f"{found['rate']:.1f}",
                f"{sorted(found['gaps'])[int(0.95 * len(found['gaps']))]:.0f}",
                f"{100 * statistics.median(found['fractions']):.1f} %",
                f"{statistics.median(found['completing']):.0f}",
                f"{found['rays'] / 1000:.0f}",
            )
        )
        page.context.close()
    table(("scene", "pictures/s", "95 % within ms", "traced", "network ms", "1000 rays/s"), rows)


def cutting(browser: Browser, url: str, scenes: dict[str, str], seconds: float) -> None:
    heading(f"A section moves through the scene, {WIDTH}x{HEIGHT}, the default budget of 33 ms")
    rows = []
    for file, name in scenes.items():
        page = opened(browser, f"{url}{SIZE}&scene={file}")
        page.evaluate("() => bobrossnet.converged()")
        for edges in (False, True):
            page.evaluate(SECTION, [2000, edges])  # until all code is compiled
            before = processor_seconds()
            found = page.evaluate(SECTION, [1000 * seconds, edges])
            spent = 1000 * (processor_seconds() - before) / max(found["pictures"], 1)
            rows.append(
                (
                    name,
                    "with edges" if edges else "without",
                    f"{found['rate']:.1f}",
                    f"{spent:.0f}",
                    f"{100 * statistics.median(found['fractions']):.1f} %",
                    f"{found['rays'] / 1000:.0f}",
                )
            )
        page.context.close()
    table(("scene", "edges", "pictures/s", "CPU ms a picture", "traced", "1000 rays/s"), rows)


def processor_seconds() -> float:
    """Return the processor time of all processes below this one, on Linux; else NaN."""
    children: dict[int, list[int]] = {}
    ticks = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            fields = stat.read_text().rpartition(")")[2].split()
            number = int(stat.parent.name)
            children.setdefault(int(fields[1]), []).append(number)
            ticks[number] = int(fields[11]) + int(fields[12])
    if not ticks:
        return float("nan")
    below = [os.getpid()]
    for process in below:
        below += children.get(process, [])
    return sum(ticks.get(process, 0) for process in below[1:]) / os.sysconf("SC_CLK_TCK")


def first_pictures(browser: Browser, url: str, scenes: dict[str, str], runs: int) -> None:
    heading("First completed picture, median ms: of the page's start, and of a scene in the open page")
    rows = []
    for file, name in scenes.items():
        spent: dict[str, list[tuple[float, float]]] = {way: [] for way in SHARING}
        for _ in range(runs):
            for way, script in SHARING.items():
                page = opened(browser, f"{url}{SIZE}&scene={file}", FIRST_PICTURE, script)
                page.evaluate("() => bobrossnet.converged()")
                start = page.evaluate("() => firstPicture")
                page.wait_for_timeout(1500)
                spent[way].append((start, page.evaluate(OPEN, file)))
                page.context.close()
        medians = {way: [statistics.median(times) for times in zip(*spent[way], strict=True)] for way in SHARING}
        rows.append((name, *(f"{medians[way][i]:.0f}" for i in range(2) for way in SHARING)))
    table(("scene", *(f"{what}, {way}" for what in ("start of the page", "in the open page") for way in SHARING)), rows)


def at_rest(browser: Browser, url: str, scenes: dict[str, str], runs: int) -> None:
    heading(
        f"From rest to exact and smoothed, ms, on {os.cpu_count()} threads;"
        " all at once: all pixels in one call of the tracer"
    )
    rows = []
    for file, name in scenes.items():
        for (width, height), ratio in itertools.product(WINDOWS, RATIOS):
            window = {"width": width, "height": height}
            page = opened(browser, f"{url}?scene={file}", viewport=window, device_scale_factor=ratio)
            page.evaluate("() => bobrossnet.converged()")
            found = [(page.evaluate(REST, 40 + 10 * i), whole(page, file)) for i in range(runs)]
            middle = {
                key: statistics.median(each[key] for each, _ in found) for key in ("exact", "smoothed", "pictures")
            }
            once = statistics.median(spent for _, spent in found)
            size = f"{found[0][0]['width']}x{found[0][0]['height']}"
            ratios = [statistics.median(each[key] / spent for each, spent in found) for key in ("exact", "smoothed")]
            rows.append(
                (name, f"{width}x{height}, {ratio}", size, f"{once:.0f}", *(f"{middle[key]:.0f}" for key in middle))
                + tuple(f"{each:.2f}" for each in ratios)
            )
            page.context.close()
    table(
        (
            "scene",
            "window, ratio",
            "pixels",
            "all at once",
            "exact",
            "smoothed",
            "pictures",
            "exact, ratio",
            "smoothed, ratio",
        ),
        rows,
    )


def in_light(browser: Browser, url: str, scenes: dict[str, str], runs: int) -> None:
    heading(f"From a new camera on, {WIDTH}x{HEIGHT}: elapsed ms, and in brackets the workers' own; medians of {runs}")
    rows = []
    for file, name in scenes.items():
        for light in ("headlight", "studio"):
            page = browser.new_context().new_page()
            spent: list[float] = []
            page.expose_function("measured", lambda own=spent: own.append(worker_milliseconds()))
            page.goto(f"{url}{SIZE}&scene={file}&light={light}")
            page.evaluate("() => bobrossnet.started.then(() => bobrossnet.converged())")
            found = []
            for i in range(1 + runs):
                spent.clear()
                elapsed = page.evaluate(LIT, 40 + 10 * i)
                found.append([*elapsed, *(own - spent[0] for own in spent[1:])])
            first, last, own_first, own_last = (statistics.median(times) for times in zip(*found[1:], strict=True))
            rows.append((name, light, f"{first:.0f} ({own_first:.0f})", f"{last:.0f} ({own_last:.0f})"))
            page.context.close()
    table(("scene", "light", "first picture", "last picture"), rows)


def worker_milliseconds() -> float:
    """Return processor milliseconds of all workers of this process's browser."""
    parents = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            parents[int(path.parent.name)] = int(path.read_text("utf-8").rpartition(")")[2].split()[1])

    def is_own(process: int) -> bool:
        return process == os.getpid() or (process in parents and is_own(parents[process]))

    own = {process for process in parents if is_own(process)}
    return sum(spent for process in own for spent in thread_milliseconds(f"{process}").values())


def whole(page: Page, file: str) -> float:
    """Return the milliseconds to trace all pixels of the page's picture at once."""
    size = page.evaluate("() => bobrossnet.schedule.size")
    camera = page.evaluate("() => bobrossnet.camera()")
    settings = {"file": file, "camera": camera, "sizes": [size], "threads": os.cpu_count()}
    (spent,) = page.evaluate(WHOLE, settings)
    return float(spent)


def in_windows(browser: Browser, url: str, scenes: dict[str, str], files: dict[str, Any]) -> None:
    heading(f"SSIM in motion, as displayed, after {2 * BEFORE} steps of {STEP}°, in 33 ms: mean of three places")
    rows = []
    for file, name in scenes.items():
        scene = bob.load(files[file], up="auto")  # as the page does
        for (width, height), ratio in itertools.product(WINDOWS, RATIOS):
            window = {"width": width, "height": height}
            page = opened(browser, f"{url}?scene={file}", viewport=window, device_scale_factor=ratio)
            page.evaluate("() => bobrossnet.converged()")
            page.uncheck("#refines")
            scores, sizes = [], []
            at_rest = page.evaluate("() => bobrossnet.schedule.size")
            for _ in range(3):
                found = page.evaluate(MOVED, [2 * BEFORE, STEP])
                shown = Image.open(BytesIO(base64.b64decode(found["picture"].partition(",")[2]))).convert("RGB")
                sizes.append(f"{shown.width}x{shown.height}")
                pan = found["camera"].pop("panX"), found["camera"].pop("panY")
                camera = bob.Camera(**found["camera"], pan=pan)
                size = at_rest["height"], at_rest["width"]
                exact = color_to_8_bit(bob.trace(scene, camera, size=size).color)
                large = np.asarray(shown.resize(size[::-1], Image.Resampling.BILINEAR))
                scores.append(bob.ssim(*((each / 255).astype(np.float32).mean(-1) for each in (large, exact))))
            sizes_shown = ", ".join(dict.fromkeys(sizes))
            rows.append(
                (name, f"{width}x{height}, {ratio}", f"{size[1]}x{size[0]}", sizes_shown, f"{np.mean(scores):.3f}")
            )
            page.context.close()
    table(("scene", "window, ratio", "pixels", "moving", "SSIM"), rows)


def in_bands(browser: Browser, server: Server) -> None:
    heading("Milliseconds to complete 3 % of the tree, alone and with another worker: elapsed, and of each thread")
    server.files["bands.html"] = b"<!doctype html><script src=bands.js></script>"
    cases = [(size, model) for size in ((480, 640), (1080, 1920)) for model in ("default", "small")]
    page, spent = browser.new_context().new_page(), []
    page.expose_function("measured", lambda: spent.append(thread_milliseconds()))
    page.goto(server.url + "bands.html")
    rows = []
    for (height, width), model in cases:
        settings = {"file": "gallery/happy_tree.bob", "height": height, "width": width, "share": 0.03, "model": model}
        for helpers in (0, 1):
            spent.clear()
            elapsed = page.evaluate("(settings) => measureBands(settings)", settings | {"helpers": helpers, "runs": 15})
            first, last = spent
            threads = sorted(set(first) & set(last))[-1 - helpers :]
            each = ", ".join(f"{(last[thread] - first[thread]) / 10:.1f}" for thread in threads)
            rows.append((f"{width}x{height}", model, str(1 + helpers), f"{elapsed:.1f}", each))
    table(("size", "network", "workers", "elapsed", "each thread"), rows)
    page.context.close()


def thread_milliseconds(processes: str = "[0-9]*") -> dict[int, float]:
    """Return processor milliseconds by thread of all browsers' workers."""
    found = {}
    for path in Path("/proc").glob(f"{processes}/task/[0-9]*"):
        try:
            if (path / "comm").read_text("utf-8").startswith("DedicatedWorker"):
                found[int(path.name)] = int((path / "schedstat").read_text("utf-8").split()[0]) / 1e6
        except OSError:
            continue  # it has ended meanwhile
    return found


# ---- Size ------------------------------------------------------------------------------------------------


def write_hills(path: Path, side: int) -> None:
    """Write a binary PLY of 2 (side - 1)² triangles."""
    x, y = np.meshgrid(*(np.linspace(-1, 1, side, dtype=np.float32),) * 2, indexing="ij")
    z = 0.2 * np.sin(7 * x) * np.cos(5 * y) + 0.01 * np.sin(90 * x) * np.sin(80 * y)
    index = np.arange(side * side, dtype=np.int32).reshape(side, side)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    corners = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], -2).reshape(-1, 3)
    faces = np.empty(len(corners), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, corners
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {side * side}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    vertices = np.stack([x, y, z], -1).astype("<f4")
    path.write_bytes(header.encode() + vertices.tobytes() + faces.tobytes())


def large_mesh(browser: Browser, server: Server) -> None:
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hills.ply"
        write_hills(path, 1700)
        server.files["hills.ply"] = path
        heading(f"A mesh of {path.stat().st_size / 1e6:.0f} MB, {2 * 1699**2:,} triangles")
        for way, script in SHARING.items():
            page = opened(browser, f"{server.url}{SIZE}#scene=csg.sdf", LONG_TASKS, script)
            page.evaluate("() => bobrossnet.converged()")
            page.evaluate("() => { tasks.length = 0; }")
            begin = time.perf_counter()
            page.evaluate("() => bobrossnet.openFile({ title: 'hills' }, 'hills.ply', 'hills.ply')")
            spent = time.perf_counter() - begin
            page.evaluate("() => bobrossnet.converged()")
            exact = time.perf_counter() - begin
            tasks = page.evaluate("() => tasks")
            rows.append((way, f"{spent:.1f}", f"{exact:.1f}", f"{max(tasks):.0f}" if tasks else "below 50"))
            page.context.close()
    table(("workers", "opened s", "exact s", "longest task of the page ms"), rows)


def resident(marker: str = "--type=renderer") -> float:
    """Return the MB of all renderers, without memory shared with other processes."""
    total = 0
    for command in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if marker in command.read_text("utf-8"):
                for line in (command.parent / "smaps_rollup").read_text("utf-8").splitlines():
                    if line.startswith(("Private_Clean", "Private_Dirty")):
                        total += int(line.split()[1])
        except OSError:
            continue  # it has ended meanwhile
    return total / 1000


def memory(browser: Browser, server: Server, minutes: float) -> None:
    heading(f"Memory of the page in {minutes:g} minutes of orbiting and opening scenes and files, MB")
    rows: list[tuple[str, ...]] = []
    for way, script in SHARING.items():
        page = opened(browser, server.url + SIZE, script)
        rows += [(way, *row) for row in memory_over(page, server, minutes)]
        page.context.close()
    table(("workers", "minute", "opened", "of which refused", "MB"), rows)


def memory_over(page: Page, server: Server, minutes: float) -> list[tuple[str, ...]]:
    """Return, for each tenth of the time: minutes, opened files, refused files, and MB."""
    scenes = page.evaluate("() => [...document.querySelectorAll('#gallery option')].map((option) => option.value)")
    files = sorted(
        file for folder in FOLDERS for file in (MODELS / folder).glob("*") if file.suffix.lower() in READ_IN_PAGE
    )
    server.files |= {f"models/{file.name}": file for file in files}
    # A scene, then two files, and so on, repeated.
    rows: list[tuple[str, ...]] = []
    begin, turn, failed = time.perf_counter(), 0, 0
    while (spent := time.perf_counter() - begin) < 60 * minutes:
        if files and turn % 3:
            name = files[(turn - turn // 3 - 1) % len(files)].name
            failed += page.evaluate(DROP, [f"models/{quote(name)}", name])
        else:
            page.select_option("#gallery", scenes[turn // 3 % len(scenes)])
            page.wait_for_selector("#stage:not([aria-busy])")
        page.evaluate(ORBIT, [1500, 60])
        turn += 1
        if spent >= 60 * minutes * (len(rows) + 1) / 10:
            rows.append((f"{spent / 60:.1f}", str(turn), str(failed), f"{resident():.0f}"))
    return rows


# ---- Quality ---------------------------------------------------------------------------------------------


def decoded(text: str, height: int, width: int) -> NDArray[np.float32]:
    return (np.frombuffer(base64.b64decode(text), np.uint8).reshape(height, width) / 255).astype(np.float32)


def enlarged(small: NDArray[np.float32]) -> NDArray[np.float32]:
    """Upsample bilinearly, like a canvas."""
    return np.asarray(Image.fromarray(small).resize((WIDTH, HEIGHT), Image.Resampling.BILINEAR))


def compared(page: Page, file: str, views: int) -> tuple[NDArray[np.float64], dict[str, float]]:
    """Return the mean SSIM by method and frame time, NaN if a view lacks it, and the cost of ours in milliseconds."""
    cameras = [{"azimuth": 360 * i / views, "elevation": 20} for i in range(views)]
    settings = {
        "file": file, "height": HEIGHT, "width": WIDTH, "cameras": cameras, "step": STEP, "before": BEFORE,
        "times": TIMES_MS, "levels": LEVELS,
    }  # fmt: skip
    scores = np.full((len(WAYS), len(TIMES_MS), views), np.nan)
    found = page.evaluate(COMPARE, settings)
    for view, frame in enumerate(found):
        exact = decoded(frame["exact"], HEIGHT, WIDTH)
        of_levels = []
        for level, small in enumerate(frame["theirs"]):
            picture = decoded(small["image"], HEIGHT >> level, WIDTH >> level)
            ways = (enlarged(picture), edge_directed(picture, HEIGHT, WIDTH)) if level else (picture, picture)
            of_levels.append((small["milliseconds"], [bob.ssim(way, exact) for way in ways]))
        for i, limit in enumerate(TIMES_MS):
            scores[0, i, view] = bob.ssim(decoded(frame["inMotion"][i], HEIGHT, WIDTH), exact)
            scores[1, i, view] = bob.ssim(decoded(frame["anew"][i], HEIGHT, WIDTH), exact)
            fitting = [of_level for milliseconds, of_level in of_levels if milliseconds <= limit]
            scores[2:, i, view] = fitting[0] if fitting else np.nan
    parts = ("dense", "filling", "completing", "deciding", "carrying")
    # A mean of all views or none: a frame missing in one view is missing.
    return scores.mean(-1), {part: float(np.median([frame[part] for frame in found])) for part in parts}


def beside_the_rivals(browser: Browser, url: str, scenes: dict[str, str], views: int, figure: Path | None) -> None:
    heading(
        f"Mean SSIM of {views} views, by the ms of a frame in one thread; in motion: after {BEFORE} steps of {STEP}°"
    )
    page = browser.new_context().new_page()
    page.goto(url + "gallery/index.json")
    page.goto(url + "rival.html")
    rows, curves = [], {}
    for file, name in scenes.items():
        means, costs = compared(page, file, views)
        curves[name] = means
        for label, mean in zip(WAYS, means, strict=True):
            rows.append((name, label, *("–" if np.isnan(value) else f"{value:.3f}" for value in mean)))
        print(
            f"{name}: all pixels {costs['dense']:.1f} ms,"
            f" completing {costs['completing']:.1f} ms, the filling {costs['filling']:.1f} ms,"
            f" deciding on 5 % of the pixels {costs['deciding']:.1f} ms, carrying along"
            + (" nothing" if np.isnan(costs["carrying"]) else f" {costs['carrying']:.1f} ms")
        )
    table(("scene", "picture", *(f"{limit} ms" for limit in TIMES_MS)), rows)
    if figure is not None:
        draw(curves, figure)


def draw(curves: dict[str, NDArray[np.float64]], figure: Path) -> None:
    import matplotlib.pyplot as plt

    drawing, axes = plt.subplots(1, len(curves), figsize=(3.2 * len(curves), 3.2), sharey=True, layout="constrained")
    styles = (("o-", "#0b6b3a"), ("o:", "#6b9a3a"), ("s--", "#8a4b08"), ("^--", "#b8860b"))
    for axis, (name, means) in zip(np.atleast_1d(axes), curves.items(), strict=True):
        for way, mean, (style, color) in zip(WAYS, means, styles, strict=True):
            axis.plot(TIMES_MS, mean, style, color=color, label=way)
        axis.set(title=name, xlabel="ms for a frame, one thread", xscale="log")
        axis.set_xticks(TIMES_MS, [str(limit) for limit in TIMES_MS], rotation=60)
        axis.minorticks_off()
        axis.grid(alpha=0.3)
    np.atleast_1d(axes)[0].set_ylabel("SSIM against the exact picture")
    np.atleast_1d(axes)[0].legend(loc="lower right", fontsize=8)
    drawing.savefig(figure, dpi=110)


PARTS = ("orbiting", "section", "first", "rest", "light", "windows", "bands", "large", "rival", "memory")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", help=f"of {', '.join(PARTS)}; by default all")
    parser.add_argument("--seconds", type=float, default=10, help="of each orbit")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--gallery", action="store_true", help="first pictures of all of the gallery's scenes")
    parser.add_argument("--scenes", nargs="*", help="names of those at rest and in windows; by default all")
    parser.add_argument("--minutes", type=float, default=10, help="for memory")
    parser.add_argument("--views", type=int, default=8)
    parser.add_argument("--figure", type=Path, help="where to draw the curves of SSIM")
    arguments = parser.parse_args()
    parts = arguments.parts or PARTS
    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    options = ["--no-sandbox"] if os.geteuid() == 0 else []
    with page_files() as files, Server(files) as server, sync_playwright() as playwright:
        scenes = dict(SCENES)
        further = {"gallery/lantern.bob": "lantern"}
        for path, name in MESHES.items():
            if (MODELS / path).is_file():
                served = Path(path).name
                server.files[served] = MODELS / path
                (further if path in FURTHER else scenes)[served] = name
        server.files |= {"bands.js": HERE / "bands.js", "rival.js": HERE / "rival.js", "rival.html": b"<!doctype html>"}
        server.files["whole.js"] = HERE / "whole.js"
        threading.Thread(target=server.serve_forever, daemon=True).start()
        chosen = {file: name for file, name in (scenes | further).items() if name in (arguments.scenes or (name,))}
        browser = playwright.chromium.launch(executable_path=chromium, args=options)
        print(f"{browser.version}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
        if "orbiting" in parts:
            orbiting(browser, server.url, scenes, arguments.seconds)
        if "section" in parts:
            cutting(browser, server.url, chosen, arguments.seconds)
        if "first" in parts:
            gallery = json.loads((VIEWER / GALLERY).read_bytes()) if arguments.gallery else []
            further = {f"gallery/{entry['file']}": entry["title"] for entry in gallery}
            first_pictures(browser, server.url, further | scenes, arguments.runs)
        if "rest" in parts:
            at_rest(browser, server.url, chosen, arguments.runs)
        if "light" in parts:
            in_light(browser, server.url, chosen, arguments.runs)
        if "windows" in parts:
            in_windows(browser, server.url, chosen, server.files)
        if "bands" in parts:
            in_bands(browser, server)
        if "large" in parts:
            large_mesh(browser, server)
        if "rival" in parts:
            beside_the_rivals(browser, server.url, scenes, arguments.views, arguments.figure)
        if "memory" in parts:
            memory(browser, server, arguments.minutes)
        browser.close()
        server.shutdown()


if __name__ == "__main__":
    main()
