"""Measuring a method: scores, milliseconds and flicker on the pictures of a group."""

from __future__ import annotations

import math
import os
import platform
import statistics
import time
from collections.abc import Callable, Sequence
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from typing import Any, TypeAlias

import inputs
import numpy as np
import protocol
from asking import F32, Ask
from methods import Entry

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.learn.evaluation.scores import METRICS
from bobrossnet.learn.evaluation.stability import LEVELS, moving_flicker
from bobrossnet.support.errors import InputError
from bobrossnet.support.machine import processor

Group: TypeAlias = dict[str, Any]
"""Results on a group: `pictures`, `seeds` and, by mask, for each picture and share the scores and milliseconds."""

Run: TypeAlias = Callable[[bob.GBuffer, str, float, int], tuple[F32, float]]
"""Maps a whole G-buffer, a mask, a share and a seed to the picture and its milliseconds."""

PACKAGES = ("bobrossnet", "numpy", "scipy", "opencv-python-headless", "scikit-image", "onnxruntime", "pyoidn")


def measure(
    name: str,
    entry: Entry,
    group: str,
    limit: int,
    *,
    shares: Sequence[float] = protocol.SHARES,
    images: Sequence[str] = (),
    **options: Any,
) -> Group:
    """Measure a method on the first pictures of a group.

    Raises
    ------
    InputError, ModuleNotFoundError
        If a package or file is missing.
    """
    bob.set_thread_count(1)
    run = _runner(name, entry)
    limit = limit if entry.pictures is None else min(limit, entry.pictures)
    masks = (protocol.FREE,) if entry.places else protocol.MASKS
    tables: dict[str, dict[str, list[Any]]] = {mask: {m: [] for m in (*METRICS, "ms", "flicker")} for mask in masks}
    names: list[str] = []
    for picture in inputs.pictures(group, limit, images, **options):
        if not names:  # the first call allocates memory and imports modules
            run(picture.full, masks[0], shares[0], 0)
        names.append(picture.name)
        has_orbit = picture.view is not None and entry.pictures is None and picture.number % protocol.ORBIT_EVERY == 0
        for mask, table in tables.items():
            cells = [_scores(run, picture, mask, share) if share <= entry.most else None for share in shares]
            for k, measure_name in enumerate((*METRICS, "ms")):
                table[measure_name].append([cell and _short(cell[k]) for cell in cells])
            if has_orbit:
                table["flicker"].append(_short(_flicker(run, picture, mask)))
    return {"pictures": names, "shares": list(shares), "masks": tables}


def described(name: str, entry: Entry) -> dict[str, Any]:
    """Return the description of a result: protocol, method, machine, versions, date."""
    versions = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            continue
    return {
        "protocol": protocol.VERSION,
        "method": name,
        "about": entry.about,
        "places": entry.places,
        "machine": f"{processor()}, {os.cpu_count()} cores, {_core.isa()}, {platform.system()}",
        "versions": versions,
        "date": date.today().isoformat(),
    }


def _runner(name: str, entry: Entry) -> Run:
    method: Any = entry.make()

    def run(full: bob.GBuffer, mask: str, share: float, seed: int) -> tuple[F32, float]:
        given = Ask(full, share) if entry.places else full.sample(share, order=mask, seed=seed)
        start = time.process_time()
        image = method(given)
        seconds = time.process_time() - start - (given.seconds if isinstance(given, Ask) else 0)
        image = np.asarray(image)
        if image.shape != full.size or not np.isfinite(image).all():
            raise InputError(f"{name}: expected finite values of shape {full.size}, got shape {image.shape}")
        return np.clip(image, 0, 1).astype(np.float32), 1000 * seconds

    return run


def _scores(run: Run, picture: inputs.Picture, mask: str, share: float) -> list[float]:
    """Return one of each of the `METRICS`, then milliseconds."""
    image, milliseconds = run(picture.full, mask, share, picture.number)
    return [*(metric.measure(image, picture.full.gray) for metric in METRICS.values()), milliseconds]


def _flicker(run: Run, picture: inputs.Picture, mask: str) -> float:
    assert picture.view is not None
    views = [picture.view(protocol.ORBIT_STEP * i) for i in range(protocol.ORBIT_FRAMES)]
    images = [run(view, mask, protocol.ORBIT_SHARE, i)[0] for i, view in enumerate(views)]
    return LEVELS * moving_flicker(images, [view.gray for view in views])


def _short(value: float) -> float | None:
    """Return six digits of a number; None of an infinite PSNR."""
    return None if math.isinf(value) else float(f"{value:.6g}")


def middle(values: Sequence[Sequence[float | None]], column: int) -> float:
    """Return the median of a column; NaN if it is empty."""
    found = [row[column] for row in values]
    kept = [value for value in found if value is not None]
    return statistics.median(kept) if kept else math.nan
