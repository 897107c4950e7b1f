"""Cost of completion: parameters, multiply-adds, milliseconds."""

from __future__ import annotations

import time
from collections.abc import Sequence
from statistics import median
from typing import NamedTuple

import bobrossnet as bob
from bobrossnet.completion.filling import FILLINGS
from bobrossnet.completion.weights import weights_path
from bobrossnet.learn import checkpoint
from bobrossnet.learn.evaluation.methods import Weights, all_methods, kept, model_names
from bobrossnet.support.tables import cell, table

SIZE = (480, 640)
FRACTION = 0.05
RUNS = 11
RUNS_OF_FILLINGS = 3  # the slowest takes hundreds of milliseconds


class Cost(NamedTuple):
    """Cost of a method; fillings have no parameters and no counted multiply-adds."""

    milliseconds: float  # median
    parameters: int | None = None
    multiply_adds: float | None = None  # for each pixel


def measure_costs(
    models: Sequence[Weights], fillings: Sequence[str] = tuple(FILLINGS), *, runs: int = RUNS
) -> dict[str, Cost]:
    """Measure the completion of the built-in scene in 640x480 from 5 % of its pixels, in the core.

    Parameters
    ----------
    models : names of shipped weights, or .safetensors files
    fillings : names in `FILLINGS`, each completed at most `RUNS_OF_FILLINGS` times
    runs : completions of each model, interleaved, so that other load on the machine affects all models equally

    Returns
    -------
    dict by method, "NAME kept" of each model and then the fillings

    Raises
    ------
    InputError
        If a model or a filling is unusable.
    """
    part = bob.trace(bob.happy_tree(), size=SIZE, fraction=FRACTION)
    names = [kept(name) for name in model_names(models)]
    methods = all_methods(models, fillings)
    elapsed_ms: dict[str, list[float]] = {name: [] for name in (*names, *fillings)}
    for run in range(1 + runs):
        for name, elapsed in elapsed_ms.items():
            if name in fillings and run > RUNS_OF_FILLINGS:
                continue
            start = time.perf_counter()
            methods[name](part)
            if run > 0:  # the first run allocates memory and imports modules
                elapsed.append(1000 * (time.perf_counter() - start))
    costs = {name: Cost(median(elapsed)) for name, elapsed in elapsed_ms.items()}
    for name, model in zip(names, models, strict=True):
        network, _ = checkpoint.load(weights_path(model))
        parameters = sum(parameter.numel() for parameter in network.parameters())
        costs[name] = Cost(costs[name].milliseconds, parameters, network.multiply_adds(*SIZE))
    return costs


def cost_table(costs: dict[str, Cost]) -> str:
    """Return costs as a markdown table with a title."""
    rows = [
        [
            name,
            "–" if cost.parameters is None else f"{cost.parameters:,}",
            "–" if cost.multiply_adds is None else f"{cost.multiply_adds:,.0f}",
            cell(cost.milliseconds, 1),
        ]
        for name, cost in costs.items()
    ]
    return f"Cost, {bob.thread_count()} threads:\n\n" + table(
        ["method", "parameters", "multiply-adds a pixel", f"ms for {SIZE[1]}x{SIZE[0]}"], rows
    )
