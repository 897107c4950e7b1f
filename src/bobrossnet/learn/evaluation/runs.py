"""Runs of an evaluation: a method with a pixel order."""

from __future__ import annotations

from collections.abc import Collection
from typing import TypeAlias

from bobrossnet.learn.evaluation.methods import repaints
from bobrossnet.support.errors import InputError

Run: TypeAlias = tuple[str, str]
"""Names of the method and the order."""


def orders_of(runs: Collection[Run]) -> tuple[str, ...]:
    """Return the pixel orders of runs, each once."""
    return tuple(dict.fromkeys(order for _, order in runs))


def find_run(runs: Collection[Run], run: str | Run) -> Run:
    """Return one of `runs`; a method's name alone selects its run with the first of the orders.

    Raises
    ------
    InputError
        If there is no such run.
    """
    found = (run, orders_of(runs)[0]) if isinstance(run, str) else run
    if found not in runs:
        methods = ", ".join(dict.fromkeys(method for method, _ in runs))
        raise InputError(f"method: expected one of {methods} in order {', '.join(orders_of(runs))}, got {run!r}")
    return found


def label(runs: Collection[Run], run: str | Run) -> str:
    """Return the label of one of `runs`: its method, and its order if they have several."""
    method, order = find_run(runs, run)
    return method if len(orders_of(runs)) == 1 else f"{method}, {order}"


def rivals(runs: Collection[Run], run: str | Run) -> list[Run]:
    """Return the other runs with the traced pixels kept, with the run's own order or with the first one."""
    own = find_run(runs, run)
    orders = (own[1], orders_of(runs)[0])
    return [other for other in runs if other != own and other[1] in orders and not repaints(other[0])]
