"""Scenes to measure on, each made when its turn comes: files of a folder, a data set's test shapes, our own."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import NamedTuple, TypeAlias

import bobrossnet as bob
from bobrossnet.learn.dataset.build import COLORED, MADE, scene_of
from bobrossnet.learn.dataset.store import Dataset
from bobrossnet.learn.shape_files import left_out, shape_files, spread
from bobrossnet.learn.shapes.colors import is_white
from bobrossnet.support.errors import InputError
from bobrossnet.tracing.scene import SceneLike, as_scene

Scenes: TypeAlias = Mapping[str, Callable[[], SceneLike]]
"""By its name what makes a scene."""

FIRST = 4_000_000_000  # of the package's own shapes: of no data set of a seed below 4,000


class Numbered(NamedTuple):
    """A scene, and its number among all, those that were left out too."""

    number: int
    name: str
    scene: SceneLike


def scenes_of_folder(folder: str | os.PathLike[str], limit: int | None = None) -> Scenes:
    """Return what the files below a folder show, in the order of their names; at most `limit`, spread evenly."""
    files = spread(shape_files(folder), limit)
    return {path.relative_to(folder).as_posix(): partial(bob.load, path) for path in files}


def scenes_of_dataset(path: str | os.PathLike[str] | Dataset, limit: int | None = None) -> Scenes:
    """Return the shapes of a data set's test split; at most `limit`, spread evenly."""
    dataset = path if isinstance(path, Dataset) else Dataset.open(path)
    numbers = dict.fromkeys(dataset.plan.sample(int(number)).shape for number in dataset.plan.split("test"))
    sources = [dataset.sources[number] for number in numbers]
    return {source: partial(scene_of, source) for source in spread(sources, limit)}


def own_scenes(count: int, first: int = FIRST, *, colored: bool = False) -> Scenes:
    """Return shapes that the package makes itself, white or all in colours; by default those for testing alone."""
    seeds = itertools.filterfalse(is_white, itertools.count(first)) if colored else itertools.count(first)
    sources = [f"{COLORED if colored else MADE}{seed}" for seed in itertools.islice(seeds, count)]
    return {source: partial(scene_of, source) for source in sources}


def with_colors(scenes: Scenes) -> Scenes:
    """Return those of the scenes that have colours; each is made for it, and those that can't be are left out."""
    made = each_scene(scenes, stacklevel=3)
    return {name: scenes[name] for _, name, scene in made if as_scene(scene).is_colored}


def each_scene(scenes: Scenes, stacklevel: int) -> Iterator[Numbered]:
    """Make one scene after the other.

    Warns
    -----
    InputWarning
        If one is left out because its file can't be loaded; `stacklevel` as of `warnings.warn`.
    """
    for number, (name, make) in enumerate(scenes.items()):
        try:
            scene = make()
        except InputError as error:
            left_out(error, stacklevel)
            continue
        yield Numbered(number, name, scene)
