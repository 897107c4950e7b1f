"""Many elements on one page: <bob-view> and <model-viewer> with the same files, in one run.

Needs the wheel playwright and a Chromium, and npm, which fetches <model-viewer> to build/web at the first run. The
files are read from the folder in BOBROSSNET_MODELS.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

import bobrossnet as bob
from bobrossnet.page.export import export
from bobrossnet.page.files import page_files

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE.parents[1] / "tests")]

from browser import launch, serving  # type: ignore[import-not-found]  # noqa: E402
from report import MODELS, heading, table  # noqa: E402
from rivals import PACKAGES, fetch_packages  # noqa: E402

FILES = (
    "loader_originals/glb_material/Duck.glb",
    "loader_originals/glb_material/CesiumMilkTruck.glb",
    "scans/egyptian_cat_statue.ply",
    "vehicles/retro_ufo.ply",
    "furniture_household/oil_barrel.ply",
)
"""One after the other for the elements of a page; those without a .glb are written as one."""

PAGE = """<!doctype html>
<script type="module" src="{script}"></script>
<style>body {{ margin: 0 }} {name} {{ float: left; width: {width}px; height: {height}px }}</style>
{elements}
"""

WATCH = """
window.alive = new Set(), window.most = 0, window.loads = [], window.exact = 0;
window.Worker = class extends Worker {
  constructor(...settings) { super(...settings); alive.add(this); most = Math.max(most, alive.size); }
  terminate() { super.terminate(); alive.delete(this); }
};
const views = () => [...document.querySelectorAll("bob-view, model-viewer")];
document.addEventListener("load", ({ target }) => views().includes(target) && loads.push(performance.now()), true);
window.converged = () => Promise.all(views().map((view) => view.converged?.())).then(() => (exact = performance.now()));
"""

REST_MS = 3000
SHARING = {"Cross_Origin_Opener_Policy": "same-origin", "Cross_Origin_Embedder_Policy": "require-corp"}


def of_processes(read: Callable[[Path], float], marker: str, kind: str = "") -> float:
    """Return the sum over the processes of `kind` of the browser whose command line contains a marker."""
    found: dict[int, tuple[int, str]] = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((folder / "stat").read_text("utf-8").rpartition(")")[2].split()[1])
            found[int(folder.name)] = parent, (folder / "cmdline").read_text("utf-8", "replace")
        except OSError:
            continue  # it has ended meanwhile
    inside = {pid for pid, (_, command) in found.items() if marker in command and "--type=" not in command}
    while more := {pid for pid, (parent, _) in found.items() if parent in inside} - inside:
        inside |= more
    total = 0.0
    for pid in inside:
        try:
            total += read(Path(f"/proc/{pid}")) if kind in found[pid][1] else 0
        except OSError:
            continue
    return total


def resident(folder: Path) -> float:
    """Return the MB of a process, without memory that it shares with other processes, except its own workers."""
    sizes = dict(line.split(":") for line in (folder / "smaps_rollup").read_text("utf-8").splitlines()[1:])
    return int(sizes["Pss"].split()[0]) / 1000


def seconds(folder: Path) -> float:
    """Return the processor time of a process."""
    fields = (folder / "stat").read_text("utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measured(kind: Any, url: str, count: int, size: tuple[int, int], marker: str) -> list[str]:
    """Return a row of the table, for a page of elements in a browser whose command line has a marker."""
    browser = launch(kind, f"--user-agent={marker}")
    try:
        page = browser.new_page(viewport={"width": size[0], "height": size[1]})
        page.add_init_script(WATCH)
        page.goto(url)
        page.wait_for_function(f"() => loads.length >= {count}", timeout=240_000)
        page.evaluate("() => converged()")
        last, exact, most = page.evaluate("() => [loads.at(-1), exact, most]")
        page.wait_for_timeout(REST_MS)
        before, begin = of_processes(seconds, marker), time.perf_counter()
        page.wait_for_timeout(REST_MS)
        idle = (of_processes(seconds, marker) - before) / (time.perf_counter() - begin)
        memory = [f"{of_processes(resident, marker, f'--type={kind}'):.0f}" for kind in ("renderer", "gpu")]
        return [str(most), *memory, f"{last / 1000:.1f}", f"{exact / 1000:.1f}", f"{100 * idle:.1f} %"]
    finally:
        browser.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--counts", type=int, nargs="+", default=[20, 100])
    arguments = parser.parse_args()
    if not (PACKAGES / "node_modules/@google/model-viewer").is_dir():
        fetch_packages()
    with tempfile.TemporaryDirectory() as name, sync_playwright() as playwright:
        folder = Path(name)
        with page_files() as files:
            export(files, folder / "bob")
        (folder / "packages").symlink_to(PACKAGES / "node_modules")
        names = []
        for path in map(MODELS.__truediv__, FILES):
            names.append(f"{path.stem}.glb")
            if path.suffix == ".glb":
                shutil.copy(path, folder)
            else:
                bob.load_mesh(path).save(folder / names[-1])
        rows = []
        for count in arguments.counts:
            width, height = (256, 192) if count <= 20 else (128, 96)
            size = (1280, 768 if count <= 20 else 960)
            for label, tag, script, headers in (
                ("bob-view, shared memory", "bob-view", "bob/component/bob-view.js", SHARING),
                ("bob-view, alone", "bob-view", "bob/component/bob-view.js", {}),
                ("model-viewer", "model-viewer", "packages/@google/model-viewer/dist/model-viewer.min.js", {}),
            ):
                elements = f'<{tag} src="{{}}" camera-controls></{tag}>'
                text = "\n".join(elements.format(names[i % len(names)]) for i in range(count))
                (folder / "index.html").write_text(
                    PAGE.format(script=script, name=tag, width=width, height=height, elements=text)
                )
                marker = f"{count}-{label}".replace(",", "").replace(" ", "-")
                with serving(folder, **headers) as url:
                    rows.append((str(count), label, *measured(playwright.chromium, url, count, size, marker)))
    heading("Elements on one page")
    columns = (
        "elements",
        "",
        "workers",
        "renderer MB",
        "GPU process MB",
        "last picture s",
        "exact s",
        "processor at rest",
    )
    table(columns, rows)


if __name__ == "__main__":
    main()
