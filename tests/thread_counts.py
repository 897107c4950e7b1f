"""Results with several numbers of threads."""

from collections.abc import Callable
from typing import TypeVar

import bobrossnet as bob

Result = TypeVar("Result")


def with_threads(counts: tuple[int, ...], make: Callable[[], Result]) -> list[Result]:
    """Return the results of `make` with each number of threads."""
    before = bob.thread_count()
    results = []
    try:
        for count in counts:
            bob.set_thread_count(count)
            results.append(make())
    finally:
        bob.set_thread_count(before)
    return results
