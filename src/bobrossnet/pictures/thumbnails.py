"""Thumbnails: pictures of all shape files of a folder."""

from __future__ import annotations

import os
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet._core import set_thread_count
from bobrossnet.adapters.apart import be_apart
from bobrossnet.adapters.files import check_up, load, shape_files_into
from bobrossnet.picture.camera import Camera, CameraLike, orbiting
from bobrossnet.picture.files import before, sheet
from bobrossnet.picture.order import SizeLike, check_size
from bobrossnet.pictures.background import Background
from bobrossnet.pictures.fitting import fitted, margin_of
from bobrossnet.pictures.rendered import Picture
from bobrossnet.pictures.rendering import check_picture, render
from bobrossnet.support.cluster import as_done, connected
from bobrossnet.support.errors import InputError, check_callable, check_integer
from bobrossnet.support.interrupts import delayed, heed
from bobrossnet.support.machine import MAX_PROCESSES, limit_memory
from bobrossnet.support.messages import name_of, one_line
from bobrossnet.tracing.light import LightLike, check_light

ENDING = ".png"


class Thumbnail(NamedTuple):
    """The result for a file."""

    file: Path
    picture: Path | None
    """The written picture, or None if it failed."""
    error: str | None
    """The reason of a failure, otherwise None."""
    is_new: bool = True
    """Whether it was rendered now; otherwise a picture newer than the file existed."""


class Style(NamedTuple):
    """The rendering options shared by all thumbnails."""

    size: tuple[int, int]
    camera: Camera | None
    samples: int
    background: Background
    up: str
    light: LightLike = None
    ground: bool | None = None


def thumbnail(source: str | os.PathLike[str], style: Style) -> Picture:
    """Render a file's thumbnail; the silhouette fills it."""
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
    camera: CameraLike | None = None,
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
    """Render a picture of each shape file of a folder and its subfolders.

    Parameters
    ----------
    source : folder, or a file
    out : folder
        Folder of the pictures, with the same subfolders; .png is appended to each file's whole name. Created if it does
        not exist.
    size, samples, background, light, ground
        As in `render`.
    camera : Camera, optional
        An orbiting camera; its zoom and pan are fitted to the silhouette.
    up : str
        The upward axis of the files, as in `load`.
    anew : bool
        Also render pictures that exist and are newer than their files.
    workers : int, optional
        Number of processes, at most 256, or 61 on Windows; by default one for each core. If a file crashes a process,
        only that file fails.
    scheduler : address of a Dask scheduler, optional
        The scheduler's workers render the pictures instead. They need this package and both folders at the same paths.
    progress : callable, optional
        Called with the share of finished files, 0..1.

    Returns
    -------
    list of Thumbnail
        One for each file, in the order of their paths; unreadable files have an error of one line.

    Raises
    ------
    InputError
        If an argument is out of range, the folder does not exist, or the scheduler can't be reached.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> made = bob.thumbnails("models", "pictures", size="128x128")  # doctest: +SKIP
    >>> [each.error for each in made if each.error]  # doctest: +SKIP
    ["broken.ply: expected a PLY, which starts with 'ply', got b'?'"]
    """
    check_picture(samples, background, size)
    check_up(up)
    check_light(light)
    check_callable("progress", progress)
    camera = None if camera is None else orbiting(camera)
    style = Style(check_size(size), camera, samples, background, up, light, ground)
    count = check_integer("workers", min(_cores(), MAX_PROCESSES) if workers is None else workers, 1, MAX_PROCESSES)
    files, pictures = shape_files_into(source, out, ENDING)
    made: dict[int, Thumbnail] = {}
    missing = []
    for i, (file, picture) in enumerate(zip(files, pictures, strict=True)):
        if not anew and picture.is_file() and picture.stat().st_mtime >= file.stat().st_mtime:
            made[i] = Thumbnail(file, picture, None, is_new=False)
        else:
            missing.append(i)
    tasks = [(str(files[i].absolute()), str(pictures[i].absolute())) for i in missing]
    done = _made(tasks, style, count) if scheduler is None else _made_on_cluster(tasks, style, scheduler)
    with closing(done):
        for i, error in done:
            file, picture = files[missing[i]], pictures[missing[i]]
            made[missing[i]] = Thumbnail(file, None if error else picture, error)
            if progress is not None:
                progress(len(made) / len(files))
    return [made[i] for i in range(len(files))]


def contact_sheet(made: Sequence[Thumbnail], columns: int | None = None) -> NDArray[np.uint8]:
    """Arrange thumbnails in rows, each above its file's name, on white: (H, W, 3) uint8.

    Equal names follow the names of their folders.

    Raises
    ------
    InputError
        If the list is empty.
    """
    from PIL import Image

    panels = []
    names = Counter(each.file.name for each in made)
    for each in made:
        if each.picture is not None:
            caption = name_of(each.file)
            if names[each.file.name] > 1:
                caption = f"{name_of(each.file.parent)}/{caption}"
            with Image.open(each.picture) as image:
                panels.append((before("white", np.asarray(image.convert("RGBA"))), caption))
    if not panels:
        raise InputError("sheet: expected at least one thumbnail, got none")
    return sheet(panels, columns or max(round(np.sqrt(1.5 * len(panels))), 1))


def _made(tasks: Sequence[tuple[str, str]], style: Style, workers: int) -> Generator[tuple[int, str | None]]:
    """Yield the index of each task as it finishes, and its error if it failed."""
    write = partial(_write, style=style)
    if sys.platform == "emscripten":  # it lacks processes and threads
        yield from ((i, write(*task)) for i, task in enumerate(tasks))
        return
    # These imports take longer than all other modules of the package.
    from concurrent.futures import ProcessPoolExecutor, as_completed
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    context = get_context("spawn")  # a fresh interpreter: a fork would lose the threads
    # Largest files first, so that no process starts a long one at the end.
    suspects = sorted(range(len(tasks)), key=lambda i: os.path.getsize(tasks[i][0]), reverse=True)
    # After a crash of a process, each file that may have caused it runs again in a separate process.
    for at_once in (len(suspects), 1):
        left, suspects = suspects, []
        groups = [left[i : i + at_once] for i in range(0, len(left), max(at_once, 1))]
        for group in groups:
            with ProcessPoolExecutor(min(workers, len(group)), context, _start_worker) as pool:
                try:
                    with delayed():
                        calls = {pool.submit(write, *tasks[i]): i for i in group}
                    for call in as_completed(calls):
                        try:
                            yield calls[call], call.result()
                        except BrokenProcessPool:
                            suspects.append(calls[call])
                except BaseException:  # also if the caller wants no more
                    pool.shutdown(cancel_futures=True)
                    raise
    for i in suspects:
        yield i, _ended(tasks[i][0])


def _made_on_cluster(
    tasks: Sequence[tuple[str, str]], style: Style, scheduler: str
) -> Generator[tuple[int, str | None]]:
    """Run the tasks on a cluster; it gives up on a file that has killed several of its workers."""
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
    set_thread_count(1)  # the files are traced in parallel
    warnings.simplefilter("ignore")
    heed()


def _write(file: str, picture: str, style: Style) -> str | None:
    """Write a thumbnail; return the error message, or None."""
    try:
        drawn = thumbnail(file, style)
        Path(picture).parent.mkdir(parents=True, exist_ok=True)
        drawn.save(picture)
    except OSError as error:
        return f"{Path(file).name}: can't write {error.filename}: {error.strerror}"
    except (InputError, MemoryError) as error:
        return one_line(error) or f"{Path(file).name}: not enough memory"
    return None


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
