"""Building of a data set: views are rendered on a Dask cluster, by default this machine, and stored as they finish.

A view is a function of the plan and its source, and one file, either valid or absent or with a wrong checksum. So an
interrupted build resumes with the missing or damaged views, and ends with the same bytes.
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

SOURCE = re.compile("(made|colored) ([0-9]+)")  # of procedural shapes; any other source is a file's path
MADE = "made "  # prefix of a source, before the seed of `procedural_scene`
COLORED = "colored "  # likewise for `colored_scene`
SEEDS = 1_000_000  # factor of a data set's seed, so that two data sets share no shape


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
    """Render a data set, or its missing views.

    Parameters
    ----------
    path : folder of the data set
        New, empty, or of an interrupted build with the same arguments.
    shapes : number of procedural shapes, optional
        By default 479, or 0 if there are files.
    files : shape files, or folders of them, optional
        Each loadable file is a shape.
    seed : of shapes, cameras, splits and masks
    test_shapes : number of shapes held out for testing
    colored : whether three quarters of the procedural shapes have colours and textures, and half of the views
        perspective
    scheduler : address of a Dask scheduler, optional
        Its workers need this package and the files at the same paths. By default this machine renders, with a thread
        for each core.

    Returns
    -------
    Dataset

    Raises
    ------
    InputError
        If an argument is invalid, the folder has other contents, or the scheduler can't be reached.

    Warns
    -----
    InputWarning
        If a file is omitted because it can't be loaded, or a damaged view is rendered again.
    """
    if shapes is None:
        shapes = 0 if files else SHAPES
    paths = [path for place in files for path in shape_files(place)]
    Plan(seed, shapes + len(paths), test_shapes, colored)  # checks the numbers before the files are read
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
    """Return the scene of one of a data set's `sources`.

    Raises
    ------
    InputError
        If the file can't be loaded.
    """
    made = SOURCE.fullmatch(source)
    if made is None:
        return bob.load(source)
    return (procedural_scene if made[1] == "made" else colored_scene)(int(made[2]))


def _is_whole(dataset: Dataset, shape: int, size: int) -> bool:
    """Return whether a view exists and is valid; warn if it is damaged."""
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
    """Yield the index and the result of each call as it finishes, in any order, and report the progress."""
    with progress(what) as report:
        for count, (index, future) in enumerate(as_done(client, function, arguments), 1):
            yield index, future.result()
            report(count / len(arguments), f"{count}/{len(arguments)}")


def _each(client: Any, function: Callable[..., Any], arguments: Sequence[tuple[Any, ...]], what: str) -> list[Any]:
    results = dict(_as_done(client, function, arguments, what))
    return [results[index] for index in range(len(arguments))]
