"""Shared by the benchmarks: the machine's description, interleaved timings of rivals, and tables."""

from __future__ import annotations

import os
import platform
import statistics
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import date
from pathlib import Path
from types import ModuleType
from typing import Any

from bobrossnet import _core
from bobrossnet.support import tables
from bobrossnet.support.machine import processor

MODELS = Path(os.environ.get("BOBROSSNET_MODELS", Path(__file__).parents[2] / "shared" / "models"))


def shape_files(*names: str) -> list[Path]:
    """Return files in the folder of shapes; the benchmark is skipped, with a reason, if the folder is missing."""
    if not MODELS.is_dir():
        print(f"skipped {Path(sys.argv[0]).name}: no shapes at {MODELS}; name their folder in BOBROSSNET_MODELS")
        sys.exit(0)
    return [MODELS / name for name in names]


def in_turn(
    rivals: Mapping[str, Callable[[], object]],
    runs: int,
    clock: Callable[[], float] = time.perf_counter,
    rest: float = 0,
    again: bool = False,
) -> dict[str, list[float]]:
    """Return the seconds of each rival's runs, interleaved after a warm-up, so that other load affects all equally.

    Each run waits `rest` seconds, until the previous rival's spinning threads sleep. `again` also measures a
    second run at once after it, as for consecutive pictures.
    """
    for run in rivals.values():
        run()
    seconds: dict[str, list[float]] = {name: [] for name in rivals}
    for _ in range(runs):
        for name, run in rivals.items():
            if rest:
                time.sleep(rest)
            if again:
                run()
            start = clock()
            run()
            seconds[name].append(clock() - start)
    return seconds


def median_ratio(over: Sequence[float], under: Sequence[float]) -> float:
    """Return the median of the ratios within each round."""
    return statistics.median(a / b for a, b in zip(over, under, strict=True))


def spread(values: Sequence[float], scale: float = 1, digits: int = 1) -> str:
    """Format median and range, e.g. "9.8 (9.6..10.4)"."""
    low, middle, high = (f"{scale * f(values):.{digits}f}" for f in (min, statistics.median, max))
    return f"{middle} ({low}..{high})"


def heading(title: str) -> None:
    """Print the title, and the machine and date of the figures."""
    print(f"\n## {title}\n")
    print(f"{processor()}, {os.cpu_count()} cores, {_core.isa()}, {platform.system()}, {date.today().isoformat()}\n")


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table in Markdown."""
    print(tables.table(columns, rows, left=True), flush=True)


@contextmanager
def replaced(*changes: tuple[ModuleType | type, str, Any]) -> Iterator[None]:
    """Replace attributes for the duration of the block."""
    before = [(where, name, getattr(where, name)) for where, name, _ in changes]
    for where, name, value in changes:
        setattr(where, name, value)
    try:
        yield
    finally:
        for where, name, value in before:
            setattr(where, name, value)
