"""Building a data set: its views are rendered on a Dask cluster, this machine by default, and stored as they come.

A view is a function of the plan and its source, and one file, which is complete or absent, or fails its checksum. So an
interrupted build resumes with the views that are missing or damaged, and ends with the same bytes.
"""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.learn.dataset.plan import SHAPES, SIZES, TEST_SHAPES, Plan
from bobrossnet.learn.dataset.store import PLANES, Dataset
from bobrossnet.learn.shape_files import left_out, shape_files
from bobrossnet.learn.shapes import procedural_scene
from bobrossnet.learn.shapes.colors import colored_scene
from bobrossnet.support.cluster import as_done, connected
from bobrossnet.support.errors import InputError, InputWarning
from bobrossnet.support.progress import progress

SOURCE = re.compile("(made|colored) ([0-9]+)")  # of what the package makes itself; every other is a file's path
MADE = "made "  # a source's first word, before the seed of `procedural_scene`
COLORED = "colored "  # the same of `colored_scene`
SEEDS = 1_000_000  # to a data set's seed, so that two share no shape


def build(
    path: str | os.PathLike[str],
    *,
    shapes: int | None = None,
    files: Sequence[str | os.PathLike[str]] = (),
    seed: int = 0,
    test_shapes: int = TEST_SHAPES,
    colored: bool = False,
    scheduler: str | None = None,
) -> Dataset:
    """Render a data set, or what is missing of it.

    Parameters
    ----------
    path : folder of the data set
        New, empty, or of a build with the same arguments that was stopped.
    shapes : how many shapes the package makes itself, optional
        By default 479, and none if there are files.
    files : shape files, or folders of them, optional
        Each that can be loaded is a shape.
    seed : of shapes, cameras, splits and masks
    test_shapes : how many of the shapes are set aside for testing
    colored : with colours and textures on three quarters of the shapes that the package makes itself, and half of the
        views in perspective
    scheduler : address of a Dask scheduler, optional
        Its workers have this package, and see the files where this machine does. By default this machine
        renders, with a thread for each core.

    Returns
    -------
    Dataset

    Raises
    ------
    InputError
        If an argument can't be used, the folder holds something else, or the scheduler can't be reached.

    Warns
    -----
    InputWarning
        If a file is left out because it can't be loaded, or a view is rendered again because it is damaged.
    """
    if shapes is None:
        shapes = 0 if files else SHAPES
    paths = [path for place in files for path in shape_files(place)]
    with connected(scheduler) as client:
        errors = _each(client, _error_of_file, [(str(path),) for path in paths], "checking files")
        for error in filter(None, errors):
            left_out(error, stacklevel=2)
        made = COLORED if colored else MADE
        sources = [f"{made}{seed * SEEDS + i}" for i in range(shapes)]
        sources += [str(path) for path, error in zip(paths, errors, strict=True) if error is None]
        plan = Plan(seed, len(sources), test_shapes, colored)
        dataset = Dataset.create(path, plan, sources)
        missing = [i for i in range(plan.shapes) if False in [_is_whole(dataset, i, size) for size in SIZES]]
        for shape, views in _as_done(client, _render, [(sources[i], plan, i) for i in missing], "rendering shapes"):
            for size, view in zip(SIZES, views, strict=True):
                dataset.write(missing[shape], size, view)
    return dataset


def views_of(scene: bob.Scene, plan: Plan, shape: int) -> list[NDArray[np.float16]]:
    """Return a shape's views, (4, size, size) float16 each: gray, depth, normal x, normal y."""
    return [
        bob.trace(scene, plan.camera(shape, size), size=(size, size)).stack()[PLANES].astype(np.float16)
        for size in SIZES
    ]


def scene_of(source: str) -> bob.Scene:
    """Return what a data set's views show, of one of its `sources`.

    Raises
    ------
    InputError
        If it is a file that can't be loaded.
    """
    made = SOURCE.fullmatch(source)
    if made is None:
        return bob.load(source)
    return (procedural_scene if made[1] == "made" else colored_scene)(int(made[2]))


def _is_whole(dataset: Dataset, shape: int, size: int) -> bool:
    """Tell whether a view is there; warn if it is, but damaged."""
    if not dataset.has(shape, size):
        return False
    try:
        dataset.read(shape, size)
    except InputError as error:
        warnings.warn(str(error), InputWarning, stacklevel=3)
        return False
    return True


def _render(source: str, plan: Plan, shape: int) -> list[NDArray[np.float16]]:
    return views_of(scene_of(source), plan, shape)


def _error_of_file(file: str) -> str | None:
    try:
        bob.load(file)
    except InputError as error:
        return str(error)
    return None


def _as_done(
    client: Any, function: Callable[..., Any], arguments: Sequence[tuple[Any, ...]], what: str
) -> Iterator[tuple[int, Any]]:
    """Yield the index and the result of each call as it is done, in any order, and report it."""
    with progress(what) as report:
        for count, (index, future) in enumerate(as_done(client, function, arguments), 1):
            yield index, future.result()
            report(count / len(arguments), f"{count}/{len(arguments)}")


def _each(client: Any, function: Callable[..., Any], arguments: Sequence[tuple[Any, ...]], what: str) -> list[Any]:
    results = dict(_as_done(client, function, arguments, what))
    return [results[index] for index in range(len(arguments))]
