"""The page of results, docs/sparsebench.md, made from the results of all methods."""

from __future__ import annotations

import json
import math
import statistics
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import protocol
from measure import Group, middle

from bobrossnet.learn.evaluation.runs import Run
from bobrossnet.learn.evaluation.scores import METRICS, Evaluation
from bobrossnet.support.errors import InputError
from bobrossnet.support.tables import cell, plus_minus, table

RESULTS = Path(__file__).parent / "results"
PAGE = Path(__file__).parents[2] / "docs/sparsebench.md"

RIVAL = "delaunay-linear"
ISOSURFACE = "isosurface"
ABOUT = {
    "made": "The package's pictures",
    "models": "Models from files",
    "mitsuba": "Path-traced pictures",
    "measured": "Measured images",
}
INTRODUCTION = """# SparseBench

Pictures from 0.5 to 25 % of their pixels. `python bench/sparse/run.py --page` makes this page from
`bench/sparse/results`. [The README](../bench/sparse/README.md) has the protocol, version {version}, and the
way to enter a method.

- **Given masks**: every method gets the same pixels, `uniform` or `lattice`.
- **Free placement**: the method asks for pixels in rounds.
- **ms**: processor time of a picture at 5 %, one thread. **Flicker**: gray levels of 255, on orbits at 5 %.
- Rows are sorted by SSIM at 5 %. The best value of each column is bold.
- `squares` refines row by row from the top: below 2 % of the pixels it does not reach the bottom.
- `progiso` was trained on the first passes of isosurfaces, which know most pixels. Its pictures are 640x360.
"""


class Result(NamedTuple):
    """The results of a method."""

    method: str
    about: str
    places: bool
    groups: Mapping[str, Group]
    machine: str
    date: str


def file_name(method: str) -> str:
    """Return the name of a method's file of results."""
    return method.replace(", ", "-").replace(" ", "-").lower() + ".json"


def read_results(folder: Path) -> list[Result]:
    """Return the results in a folder, by the names of the files.

    Raises
    ------
    InputError
        If a file is not of this version of the protocol.
    """
    results = []
    for path in sorted(folder.glob("*.json")):
        content: dict[str, Any] = json.loads(path.read_text("utf-8"))
        if content.get("protocol") != protocol.VERSION:
            raise InputError(f"{path}: expected protocol {protocol.VERSION}, got {content.get('protocol')}")
        results.append(Result(*(content[name] for name in Result._fields)))
    return results


def page(results: Sequence[Result]) -> str:
    """Return the page, in Markdown."""
    parts = [INTRODUCTION.format(version=protocol.VERSION)]
    rows = [[r.method, r.about, r.machine, r.date] for r in results]
    for group, title in ABOUT.items():
        chosen = [result for result in results if group in result.groups]
        if not chosen:
            continue
        count = max(len(result.groups[group]["pictures"]) for result in chosen)
        parts += [f"## {title}", f"{count} pictures." if count > 1 else "One picture."]
        for places, track in ((False, "Given masks"), (True, "Free placement")):
            entered = [r for r in chosen if r.places == places]
            whole = [r for r in entered if len(r.groups[group]["pictures"]) == count]
            if whole:
                parts += [f"### {track}", *tables(whole, group)]
            if len(whole) < len(entered):
                fewest = min(len(r.groups[group]["pictures"]) for r in entered)
                parts += [
                    f"SSIM on the first {fewest} pictures, slow methods included.",
                    means(entered, group, "ssim", fewest),
                ]
            if whole and not places and any(name.startswith(ISOSURFACE) for name in whole[0].groups[group]["pictures"]):
                parts += ["Isosurfaces alone: SSIM.", means(whole, group, "ssim", kind=ISOSURFACE)]
    parts += ["## Methods and machines", table(["method", "description", "machine", "date"], rows, left=True)]
    return "\n\n".join(part.strip("\n") for part in parts) + "\n"


def tables(results: Sequence[Result], group: str) -> list[str]:
    """Return the tables of methods that have the same pictures."""
    parts = ["SSIM:", means(results, group, "ssim", costs=True)]
    evaluation = evaluated(results, group)
    rows = []
    for run in evaluation.scores:
        rival = (RIVAL, run[1]) if run[1] != protocol.FREE else (f"adaptive, {RIVAL}", run[1])
        if rival not in evaluation.scores or run == rival:
            continue
        changes = 100 * evaluation.change_of_error(run, rival)
        rows.append([*_labels(run), *(plus_minus(mean, half, 1) for mean, half in changes)])
    if rows and len(evaluation.pictures) > 1:
        rival_name = f"adaptive, {RIVAL}" if results[0].places else f"{RIVAL} with the same mask"
        parts += [f"1 - SSIM, change from {rival_name} in percent, with 95 % confidence intervals:"]
        parts += [table([*_columns(evaluation.scores), *_shares(evaluation)], rows)]
    for metric in ("psnr", "flip"):
        parts += [f"{METRICS[metric].label}:", means(results, group, metric)]
    return parts


def means(
    results: Sequence[Result],
    group: str,
    metric: str,
    pictures: int | None = None,
    *,
    kind: str = "",
    costs: bool = False,
) -> str:
    """Return mean scores as a table, on the first pictures, or on those whose names begin with a kind."""
    evaluation = evaluated(results, group, pictures)
    if kind:
        evaluation = evaluation.of_shapes([name for name in evaluation.shapes if name.startswith(kind)])
    better = METRICS[metric].better
    runs = {run: evaluation.mean(run, metric) for run in evaluation.scores}
    best = better * np.nanmax([better * values for values in runs.values()], 0)
    at = evaluation.fractions.index(protocol.ORBIT_SHARE)
    rows = []
    for run in sorted(runs, key=lambda run: -better * np.nan_to_num(runs[run][at])):
        marks = ["**" if value == top else "" for value, top in zip(runs[run], best, strict=True)]
        digits = METRICS[metric].digits
        row = [*_labels(run), *(f"{m}{cell(v, digits)}{m}" for m, v in zip(marks, runs[run], strict=True))]
        if costs:
            found = next(r.groups[group]["masks"][run[1]] for r in results if r.method == run[0])
            flicker = statistics.fmean(found["flicker"]) if found["flicker"] else math.nan
            row += [cell(middle(found["ms"], at), 1), cell(flicker, 2)]
        rows.append(row)
    further = ["ms", "flicker"] if costs else []
    return table([*_columns(runs), *_shares(evaluation), *further], rows)


def evaluated(results: Sequence[Result], group: str, pictures: int | None = None) -> Evaluation:
    """Return the scores of methods on the first pictures of a group; NaN for shares that were not measured."""
    scores: dict[Run, Any] = {}
    first = results[0].groups[group]
    names = tuple(first["pictures"][:pictures])
    for result in results:
        found = result.groups[group]
        if (tuple(found["pictures"][: len(names)]), found["shares"]) != (names, first["shares"]):
            raise InputError(f"{result.method}: expected the pictures of {results[0].method}, got others; run it again")
        for mask, by_metric in found["masks"].items():
            scores[(result.method, mask)] = np.stack([_array(by_metric, m, len(names)) for m in METRICS], -1)
    return Evaluation(names, names, tuple(first["shares"]), scores)


def _array(by_metric: Mapping[str, Any], metric: str, count: int) -> Any:
    """Return a metric's values, (P, F). A missing value is an infinite PSNR, or NaN if the share was not measured."""
    values = np.array(by_metric[metric][:count], np.float64)
    missed = np.array([[value is None for value in row] for row in by_metric["ms"][:count]])
    return np.where(np.isnan(values) & ~missed, math.inf, values) if metric == "psnr" else values


def _labels(run: Run) -> list[str]:
    return [run[0]] if run[1] == protocol.FREE else list(run)


def _columns(runs: Mapping[Run, object]) -> list[str]:
    return ["method", "mask"] if any(run[1] != protocol.FREE for run in runs) else ["method"]


def _shares(evaluation: Evaluation) -> list[str]:
    return [f"{100 * share:g} %" for share in evaluation.fractions]
