"""Thumbnails: a picture of every shape file of a folder."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet._core import set_thread_count
from bobrossnet.adapters.apart import be_apart
from bobrossnet.adapters.files import check_up, load, shape_files
from bobrossnet.picture.camera import Camera, orbiting
from bobrossnet.picture.files import before, sheet
from bobrossnet.picture.order import SizeLike, check_size
from bobrossnet.pictures.fitting import fitted, margin_of
from bobrossnet.pictures.rendered import Picture
from bobrossnet.pictures.rendering import Background, check_picture, render
from bobrossnet.support.cluster import as_done, connected
from bobrossnet.support.errors import InputError, check_callable, check_integer
from bobrossnet.support.machine import MAX_PROCESSES, limit_memory
from bobrossnet.support.messages import one_line
from bobrossnet.tracing.light import LightLike

ENDING = ".png"


class Thumbnail(NamedTuple):
    """What became of a file."""

    file: Path
    picture: Path | None
    """Where it is, if there is one."""
    error: str | None
    """Why there is none."""
    is_new: bool = True
    """Whether it was made now; else it was there, newer than its file."""


class Style(NamedTuple):
    """What thumbnails look like."""

    size: tuple[int, int]
    camera: Camera
    samples: int
    background: Background
    up: str
    light: LightLike = None
    ground: bool | None = None


def thumbnail(source: str | os.PathLike[str], style: Style) -> Picture:
    """The picture of a file, which its silhouette fills."""
    scene = load(source, up=style.up)
    margin = margin_of(scene, style.light, style.ground)
    camera = fitted(scene, style.camera, size=style.size, margin=margin)
    return render(
        scene,
        camera,
        size=style.size,
        samples=style.samples,
        background=style.background,
        light=style.light,
        ground=style.ground,
    )


def thumbnails(
    source: str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    size: SizeLike = (256, 256),
    camera: Camera | None = None,
    samples: int = 4,
    background: Background = None,
    up: str = "z",
    light: LightLike = None,
    ground: bool | None = None,
    anew: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Thumbnail]:
    """Make a picture of each shape file of a folder, and of those below it.

    Parameters
    ----------
    source : folder, or a file
    out : folder
        Where the pictures are written, in the same folders as the files, under their whole names and .png behind. It
        is made if it is not there.
    size, samples, background, light, ground
        As in `render`.
    camera : Camera, optional
        One that orbits; its zoom and pan become those at which the silhouette fills the picture.
    up : "z" or "y"
        The files' axis that points up.
    anew : bool
        Also pictures that are there already, newer than their files.
    workers : int, optional
        Processes, at most 256, or 61 on Windows; by default one for each core. A file that ends one costs that file
        alone.
    scheduler : address of a Dask scheduler, optional
        Its workers make the pictures instead. They have this package, and see both folders where this machine does.
    progress : callable, optional
        Called with the share of the files that are done, 0..1.

    Returns
    -------
    list of Thumbnail
        One for each file, in the order of their paths; those that can't be read have an error of one line.

    Raises
    ------
    InputError
        If an argument is out of range, there is no such folder, or the scheduler can't be reached.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> made = bob.thumbnails("models", "pictures", size="128x128")  # doctest: +SKIP
    >>> [each.error for each in made if each.error]  # doctest: +SKIP
    ["broken.ply: expected a PLY, which starts with 'ply', got b'?'"]
    """
    check_picture(samples, background, size)
    check_up(up)
    check_callable("progress", progress)
    style = Style(check_size(size), orbiting(camera), samples, background, up, light, ground)
    count = check_integer("workers", min(_cores(), MAX_PROCESSES) if workers is None else workers, 1, MAX_PROCESSES)
    files = shape_files(source)
    folder = Path(source) if Path(source).is_dir() else Path(source).parent
    pictures = [Path(out) / f"{file.relative_to(folder)}{ENDING}" for file in files]
    made: dict[int, Thumbnail] = {}
    missing = []
    for i, (file, picture) in enumerate(zip(files, pictures, strict=True)):
        if not anew and picture.is_file() and picture.stat().st_mtime >= file.stat().st_mtime:
            made[i] = Thumbnail(file, picture, None, is_new=False)
        else:
            missing.append(i)
    tasks = [(str(files[i].absolute()), str(pictures[i].absolute())) for i in missing]
    done = _made(tasks, style, count) if scheduler is None else _made_on_cluster(tasks, style, scheduler)
    for i, error in done:
        file, picture = files[missing[i]], pictures[missing[i]]
        made[missing[i]] = Thumbnail(file, None if error else picture, error)
        if progress is not None:
            progress(len(made) / len(files))
    return [made[i] for i in range(len(files))]


def contact_sheet(made: Sequence[Thumbnail], columns: int | None = None) -> NDArray[np.uint8]:
    """Thumbnails in rows, each above its file's name, on white: (H, W, 3) uint8.

    Raises
    ------
    InputError
        If there is none.
    """
    from PIL import Image

    panels = []
    for each in made:
        if each.picture is not None:
            with Image.open(each.picture) as image:
                panels.append((before("white", np.asarray(image.convert("RGBA"))), each.file.name))
    if not panels:
        raise InputError("sheet: expected at least one thumbnail, got none")
    return sheet(panels, columns or max(round(np.sqrt(1.5 * len(panels))), 1))


def _made(tasks: Sequence[tuple[str, str]], style: Style, workers: int) -> Iterator[tuple[int, str | None]]:
    """The number of each task as it is done, and its error if it failed."""
    write = partial(_write, style=style)
    if sys.platform == "emscripten":  # which has neither processes nor threads
        yield from ((i, write(*task)) for i, task in enumerate(tasks))
        return
    # Which take longer to import than the rest of the package's own modules.
    from concurrent.futures import ProcessPoolExecutor, as_completed
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    context = get_context("spawn")  # which shares nothing with this process: a fork would lose its threads
    # The largest first, so that no process has a long one left when the others are done.
    suspects = sorted(range(len(tasks)), key=lambda i: os.path.getsize(tasks[i][0]), reverse=True)
    # After a process has died of a file, each of those that it may have been is tried on its own.
    for at_once in (len(suspects), 1):
        left, suspects = suspects, []
        groups = [left[i : i + at_once] for i in range(0, len(left), max(at_once, 1))]
        for group in groups:
            with ProcessPoolExecutor(min(workers, len(group)), context, _start_worker) as pool:
                calls = {pool.submit(write, *tasks[i]): i for i in group}
                for call in as_completed(calls):
                    try:
                        yield calls[call], call.result()
                    except BrokenProcessPool:
                        suspects.append(calls[call])
    for i in suspects:
        yield i, _ended(tasks[i][0])


def _made_on_cluster(
    tasks: Sequence[tuple[str, str]], style: Style, scheduler: str
) -> Iterator[tuple[int, str | None]]:
    """The same on a cluster, which gives up on a file that has ended some of its workers."""
    with connected(scheduler) as client:
        from distributed import KilledWorker

        for i, future in as_done(client, partial(_write, style=style), tasks):
            try:
                yield i, future.result()
            except KilledWorker:
                yield i, _ended(tasks[i][0])


def _ended(file: str) -> str:
    return f"{Path(file).name}: its reader ended without a word, perhaps for want of memory"


def _start_worker() -> None:
    limit_memory()
    be_apart()
    set_thread_count(1)  # the files are traced side by side
    warnings.simplefilter("ignore")


def _write(file: str, picture: str, style: Style) -> str | None:
    """Make a thumbnail; return what went wrong."""
    try:
        drawn = thumbnail(file, style)
        Path(picture).parent.mkdir(parents=True, exist_ok=True)
        drawn.save(picture)
    except (InputError, MemoryError, OSError) as error:
        return one_line(error) or f"{Path(file).name}: not enough memory"
    return None


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
