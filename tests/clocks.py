"""Times on a shared machine: other processes lengthen some measurements, a fault lengthens all."""

from __future__ import annotations

import os
from collections.abc import Callable

SLOWER = 10 if "san.so" in os.environ.get("LD_PRELOAD", "") else 1
"""By which sanitizers lengthen work (checks.mk)."""


def least(measure: Callable[[], float], enough: float, tries: int = 5) -> float:
    """Return the least of up to `tries` measurements; the first below `enough` is the last."""
    found = float("inf")
    for _ in range(tries):
        if (found := min(found, measure())) < enough:
            break
    return found
