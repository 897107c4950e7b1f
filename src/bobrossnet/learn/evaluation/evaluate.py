"""Evaluation of models on a data set's test split or on scenes, compared with fillings without a network.

Letters: M methods, O pixel orders, P pictures, F shares of traced pixels.
"""

from __future__ import annotations

import itertools
import os
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.adapters.files import ALL_ENDINGS
from bobrossnet.completion.filling import FILLINGS
from bobrossnet.learn.checks import MAX_VIEWS, check_measured, check_orders
from bobrossnet.learn.dataset.plan import PATCHES, STAGES, Plan
from bobrossnet.learn.dataset.store import Dataset, part_of
from bobrossnet.learn.evaluation.methods import Method, Weights, all_methods
from bobrossnet.learn.evaluation.scenes import Scenes, each_scene, scenes_of_folder
from bobrossnet.learn.evaluation.scores import METRICS, Evaluation
from bobrossnet.learn.shape_files import spread
from bobrossnet.picture.order import ORDERS_BY_SIGHT
from bobrossnet.support.errors import InputError, check_integer, check_number
from bobrossnet.support.progress import progress

FRACTIONS = (0.01, 0.02, 0.05, 0.10, 0.25, 0.50, 0.75, 1.0)
MODELS = ("default", "paper")  # the shipped network, and the report's
ORDERS = ("uniform",)  # the report's


@dataclass(frozen=True)
class _Picture:
    name: str
    shape: str
    reference: NDArray[np.float32]  # (H, W) gray, or (H, W, 3) linear RGB
    part: Callable[[str, float], bob.GBuffer]  # by pixel order and share of traced pixels
    done: float  # share of all work done after this picture, 0..1


def evaluate_dataset(
    path: str | os.PathLike[str] | Dataset,
    models: Sequence[Weights] = MODELS,
    *,
    fractions: Sequence[float] = FRACTIONS,
    orders: Sequence[str] = ORDERS,
    fillings: Sequence[str] = tuple(FILLINGS),
    repainting: bool = True,
    limit: int | None = None,
    seconds: float = inf,
) -> Evaluation:
    """Evaluate models on a data set's test split: every patch of its shapes, at each share of traced pixels.

    Parameters
    ----------
    path : a data set's folder, or the data set
    models : names of shipped weights, or .safetensors files
        Named by their stems in the result.
    fractions : shares of traced pixels, each above 0
        At the data set's stages, 1, 25, 50, 75 and 100 %, exactly its samples are used, 1,050 of ten shapes; at other
        shares, the pixels follow the order of the patch's sample at 1 %, so that they contain its pixels.
    orders : pixel orders
        Every method is measured with each order, on the same pictures.
    fillings : names in `FILLINGS` to compare with
    repainting : whether networks are also measured with the traced pixels repainted
    limit : maximum number of shapes, spread evenly over the split, optional
    seconds : time after which no further picture begins

    Returns
    -------
    Evaluation

    Raises
    ------
    InputError
        If an argument is invalid, or the data set is incomplete.
    """
    dataset = path if isinstance(path, Dataset) else Dataset.open(path)
    # A patch's samples at the stages, shape by shape.
    numbers = dataset.plan.split("test").reshape(-1, PATCHES, len(STAGES))
    pictures = _pictures_of_dataset(dataset, spread(list(numbers), limit))
    methods = all_methods(models, fillings, repainting=repainting)
    return _evaluate(_begun_within(seconds, pictures), methods, fractions, orders)


def evaluate_folder(
    folder: str | os.PathLike[str], models: Sequence[Weights] = MODELS, *, limit: int | None = None, **options: Any
) -> Evaluation:
    """Evaluate models on views of every file below a folder that `bobrossnet.load` reads.

    Parameters
    ----------
    folder : path
        Searched recursively, in the order of the names, except folders named `broken_odd`.
    models, options : as in `evaluate_scenes`
    limit : maximum number of files, spread evenly over all, optional

    Raises
    ------
    InputError
        If an argument is invalid, or no file below the folder can be loaded.
    """
    scenes = scenes_of_folder(folder, limit)
    if not scenes:
        raise InputError(f"{folder}: expected files of shapes ({' '.join(ALL_ENDINGS)}), got none")
    return evaluate_scenes(scenes, models, **options)


def evaluate_scenes(
    scenes: Scenes,
    models: Sequence[Weights] = MODELS,
    *,
    size: tuple[int, int] = (256, 256),
    views: int = 1,
    fractions: Sequence[float] = FRACTIONS,
    orders: Sequence[str] = ORDERS,
    fillings: Sequence[str] = tuple(FILLINGS),
    repainting: bool = True,
    fov: float = 0,
    channel: str = "gray",
    seconds: float = inf,
) -> Evaluation:
    """Evaluate models on views of scenes.

    Parameters
    ----------
    scenes : functions that make them, by name
    models, fractions, fillings, repainting : as in `evaluate_dataset`
    size : (height, width)
        At least 11 each.
    views : pictures of each scene
        Azimuths are spread evenly, offset by 30° from scene to scene; elevations alternate between 20° and 45°.
    orders : pixel orders, as in `evaluate_dataset`
        Seeded by the picture's number.
    fov : of the cameras, in degrees; 0 is orthographic
    channel : "gray" or "color"
        The channel to complete and measure. Colours need `repainting=False`: networks repaint gray alone.
    seconds : as in `evaluate_dataset`

    Returns
    -------
    Evaluation

    Raises
    ------
    InputError
        If an argument is invalid, or no scene can be made.

    Warns
    -----
    InputWarning
        If a scene is omitted because its file can't be loaded.
    """
    check_measured(size)
    check_integer("views", views, 1, MAX_VIEWS)
    methods = all_methods(models, fillings, repainting=repainting, channel=channel)
    pictures = _begun_within(seconds, _pictures_of_scenes(scenes, size, views, fov, channel))
    result = _evaluate(pictures, methods, fractions, orders)
    if not result.pictures:
        raise InputError("scenes: expected at least one that can be loaded, got none")
    return result


def _begun_within(seconds: float, pictures: Iterable[_Picture]) -> Iterator[_Picture]:
    """Yield pictures until a time has passed, at least one."""
    end = time.monotonic() + seconds
    for picture in pictures:
        yield picture
        if time.monotonic() >= end:
            return


def _pictures_of_dataset(dataset: Dataset, numbers: Sequence[NDArray[np.int64]]) -> Iterator[_Picture]:
    """Yield pictures of the samples `numbers`, (PATCHES, STAGES) for each shape."""
    for k, of_shape in enumerate(numbers):
        shape = dataset.plan.sample(int(of_shape[0, 0])).shape
        for i, (patch, of_patch) in enumerate(zip(dataset.patches(shape), of_shape.tolist(), strict=True)):
            _, size, row, column, _ = dataset.plan.sample(of_patch[0])
            whole = patch.astype(np.float32)
            yield _Picture(
                name=f"{size}x{size} row {row} column {column}",
                shape=dataset.sources[shape],
                reference=whole[0],
                part=partial(_part_of_patch, dataset.plan, of_patch, whole),
                done=(k + (i + 1) / PATCHES) / len(numbers),
            )


def _part_of_patch(
    plan: Plan, numbers: Sequence[int], whole: NDArray[np.float32], order: str, fraction: float
) -> bob.GBuffer:
    """Return a patch's sample, of `numbers` by stage; adaptive orders choose other pixels than the sample's."""
    number = numbers[STAGES.index(fraction) if fraction in STAGES else 0]
    if order in ORDERS_BY_SIGHT:
        return part_of(whole, np.ones(whole[0].shape)).sample(fraction, order=order, seed=number)
    return part_of(whole, plan.mask(number, fraction, order=order))


def _pictures_of_scenes(
    scenes: Scenes, size: tuple[int, int], views: int, fov: float, channel: str
) -> Iterator[_Picture]:
    for number, name, scene in each_scene(scenes, stacklevel=6):  # reported at the call of evaluate_scenes
        for view in range(views):
            azimuth = (30 * number + 360 * view / views) % 360
            camera = bob.Camera(azimuth=azimuth, elevation=(20, 45)[view % 2], fov=fov)
            full = bob.trace(scene, camera, size=size)
            yield _Picture(
                name=f"view {view}",
                shape=name,
                reference=full.channel(channel),
                part=partial(_part_of_view, full, number * views + view),
                done=(number + (view + 1) / views) / len(scenes),
            )


def _part_of_view(full: bob.GBuffer, seed: int, order: str, fraction: float) -> bob.GBuffer:
    return full.sample(fraction, order=order, seed=seed)


# ---- Measuring -------------------------------------------------------------------------------------------


def _evaluate(
    pictures: Iterable[_Picture], methods: Mapping[str, Method], fractions: Sequence[float], orders: Sequence[str]
) -> Evaluation:
    """Measure methods on pictures, with a few pictures in memory at a time."""
    orders = check_orders(orders)
    fractions = tuple(check_number("fractions", fraction, 0, 1, above=True) for fraction in fractions)
    if not fractions:
        raise InputError("fractions: expected at least one share of the pixels, got none")

    names_of_pictures, shapes = [], []
    scores: list[NDArray[np.float64]] = []  # of each picture
    with progress("evaluating") as report:
        for picture, of_picture in _scored(pictures, list(methods.values()), orders, fractions):
            scores.append(of_picture)
            names_of_pictures.append(picture.name)
            shapes.append(picture.shape)
            report(picture.done, picture.shape)

    runs = [(method, order) for method in methods for order in orders]
    by_picture = np.reshape(scores, (-1, len(runs), len(fractions), len(METRICS)))
    by_run = dict(zip(runs, np.moveaxis(by_picture, 1, 0), strict=True))
    return Evaluation(tuple(names_of_pictures), tuple(shapes), fractions, by_run)


def _scored(
    pictures: Iterable[_Picture], methods: Sequence[Method], orders: Sequence[str], fractions: Sequence[float]
) -> Iterator[tuple[_Picture, NDArray[np.float64]]]:
    """Yield each picture with its scores, (M, O, F, 3), in order.

    Parts are scored on all threads: numpy, scipy and the core take most of the time, and release the GIL.
    """
    shape = (len(orders), len(fractions), len(methods), len(METRICS))
    threads = bob.thread_count()
    ahead: deque[tuple[_Picture, list[Future[list[list[float]]]]]] = deque()

    def first_of_them() -> tuple[_Picture, NDArray[np.float64]]:
        picture, parts = ahead.popleft()
        scores = np.reshape([part.result() for part in parts], shape)
        return picture, np.moveaxis(scores, 2, 0)

    pool = ThreadPoolExecutor(threads)
    try:
        for picture in pictures:
            parts = itertools.product(orders, fractions)
            ahead.append((picture, [pool.submit(_score, picture, methods, *part) for part in parts]))
            if len(ahead) > threads:
                yield first_of_them()
        while ahead:
            yield first_of_them()
    finally:
        pool.shutdown(cancel_futures=True)


def _score(picture: _Picture, methods: Sequence[Method], order: str, fraction: float) -> list[list[float]]:
    """Return the scores of one partial picture, one of each of the `METRICS` for each method."""
    part, reference = picture.part(order, fraction), picture.reference
    scores = []
    for method in methods:
        image = method(part)
        # Frequent: background, and wholly traced pictures with the pixels kept.
        exact = np.array_equal(image, reference)
        measures = [metric.measure if reference.ndim == 2 else metric.of_color for metric in METRICS.values()]
        bests = [metric.best for metric in METRICS.values()]
        scores.append(bests if exact else [measure(image, reference) for measure in measures])
    return scores
