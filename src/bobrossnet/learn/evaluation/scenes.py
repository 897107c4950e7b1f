"""Scenes for evaluations, made on demand: files of a folder, a data set's test shapes, procedural shapes."""

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
"""Functions that make scenes, by name."""

FIRST = 4_000_000_000  # seed of procedural test shapes, outside data sets with seeds below 4,000


class Numbered(NamedTuple):
    """A scene and its number, counting omitted ones."""

    number: int
    name: str
    scene: SceneLike


def scenes_of_folder(folder: str | os.PathLike[str], limit: int | None = None) -> Scenes:
    """Return the scenes of the files below a folder, by name; at most `limit`, spread evenly."""
    files = spread(shape_files(folder), limit)
    return {path.relative_to(folder).as_posix(): partial(bob.load, path) for path in files}


def scenes_of_dataset(path: str | os.PathLike[str] | Dataset, limit: int | None = None) -> Scenes:
    """Return the shapes of a data set's test split; at most `limit`, spread evenly."""
    dataset = path if isinstance(path, Dataset) else Dataset.open(path)
    numbers = dict.fromkeys(dataset.plan.sample(int(number)).shape for number in dataset.plan.split("test"))
    sources = [dataset.sources[number] for number in numbers]
    return {source: partial(scene_of, source) for source in spread(sources, limit)}


def own_scenes(count: int, first: int = FIRST, *, colored: bool = False) -> Scenes:
    """Return procedural shapes, white or all in colours; by default ones reserved for testing."""
    seeds = itertools.filterfalse(is_white, itertools.count(first)) if colored else itertools.count(first)
    sources = [f"{COLORED if colored else MADE}{seed}" for seed in itertools.islice(seeds, count)]
    return {source: partial(scene_of, source) for source in sources}


def with_colors(scenes: Scenes) -> Scenes:
    """Return the coloured ones among the scenes; each is made to find out, and failing ones are omitted."""
    made = each_scene(scenes, stacklevel=3)
    return {name: scenes[name] for _, name, scene in made if as_scene(scene).is_colored}


def each_scene(scenes: Scenes, stacklevel: int) -> Iterator[Numbered]:
    """Yield the scenes, made one at a time.

    Warns
    -----
    InputWarning
        If one is omitted because its file can't be loaded; `stacklevel` as in `warnings.warn`.
    """
    for number, (name, make) in enumerate(scenes.items()):
        try:
            scene = make()
        except InputError as error:
            left_out(error, stacklevel)
            continue
        yield Numbered(number, name, scene)
