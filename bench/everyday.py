"""Files per second of thumbnails, compared with pyvista if installed, and pictures per second of films."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path

from report import MODELS, heading, shape_files, spread, table

import bobrossnet as bob

RUNS = 3
SIZE = 256
READ_BY_VTK = (".ply", ".obj", ".stl")


def by_pyvista(file: str, out: str) -> bool:
    """Draw a file as in pyvista's documentation; return whether it has any content."""
    import pyvista

    warnings.simplefilter("ignore")
    try:
        mesh = pyvista.read(file)
        plotter = pyvista.Plotter(off_screen=True, window_size=[SIZE, SIZE])
        plotter.add_mesh(mesh)
        plotter.screenshot(out)
        plotter.close()
    except Exception:  # any error, from unreadable files
        return False
    return True


def quiet() -> None:
    """Discard VTK's output about files and displays."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for output in (1, 2):
        os.dup2(nowhere, output)


def with_pyvista(folder: Path, out: Path) -> int:
    """Draw all files by pyvista with a process for each core; return the number of pictures."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    out.mkdir()
    with ProcessPoolExecutor(os.cpu_count(), get_context("spawn"), quiet) as pool:
        done = pool.map(by_pyvista, map(str, files), [str(out / f"{i}.png") for i in range(len(files))])
        return sum(done)


def with_ours(folder: Path, out: Path) -> int:
    """Return the number of pictures by `bob.thumbnails`."""
    return sum(each.error is None for each in bob.thumbnails(folder, out, size=(SIZE, SIZE)))


def thumbnails(folder: Path) -> None:
    """Print the files per second of each, interleaved, including the start of processes."""
    with tempfile.TemporaryDirectory() as made:
        place = Path(made)
        common = place / "common"
        for file in (path for path in folder.rglob("*") if path.suffix.lower() in READ_BY_VTK):
            copy = common / file.relative_to(folder)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, copy)
        rivals: dict[str, tuple[Callable[[Path, Path], int], Path]] = {
            "ours, 4 rays at edges, all files": (with_ours, folder),
            "ours, 4 rays at edges, PLY, OBJ and STL": (with_ours, common),
        }
        if find_spec("pyvista"):
            rivals["pyvista, PLY, OBJ and STL"] = (with_pyvista, common)
        else:
            print("without a rival: pyvista is not installed", file=sys.stderr)
        seconds: dict[str, list[float]] = {name: [] for name in rivals}
        drawn = {}
        for run in range(RUNS):
            for i, (name, (draw, source)) in enumerate(rivals.items()):
                start = time.perf_counter()
                drawn[name] = draw(source, place / f"{run} {i}")
                seconds[name].append(time.perf_counter() - start)
        heading(f"Thumbnails, {SIZE}x{SIZE}, a process for each core")
        rows = [
            [name, f"{drawn[name]:,}", spread(times), spread([drawn[name] / t for t in times])]
            for name, times in seconds.items()
        ]
        table(["", "pictures", "seconds", "pictures a second"], rows)


def films() -> None:
    """Print the time of a turn around the built-in scene."""
    heading("Films: one turn of the built-in scene, 75 pictures of 640x480, WebP, all threads")
    rows = []
    with tempfile.TemporaryDirectory() as made:
        for name, options in (
            ("10 % of the pixels", {"fraction": 0.1}),
            ("every pixel", {"samples": 1}),
            ("every pixel, 4 rays at edges", {"samples": 4}),
            ("every pixel, 16 rays at edges", {"samples": 16}),
        ):
            times = []
            for _ in range(RUNS):
                film = bob.orbit(bob.happy_tree(), background="#fff", **options)
                start = time.perf_counter()
                film.save(Path(made) / "a.webp")
                times.append(time.perf_counter() - start)
            rows.append([name, spread(times), f"{(Path(made) / 'a.webp').stat().st_size / 1e6:.1f}"])
    table(["", "seconds", "MB"], rows)


if __name__ == "__main__":
    shape_files()
    thumbnails(MODELS)
    films()
