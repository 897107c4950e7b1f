"""Runs SparseBench: measures methods, writes a JSON file for each, and makes the page of results. See README.md."""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import inputs
import protocol
from measure import Group, described, measure
from methods import ENTRIES, entry_of
from page import PAGE, RESULTS, file_name, means, page, read_results

from bobrossnet.support.errors import InputError

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables of the environment that processes read when they import numpy."""


def measured(name: str, group: str, limit: int, images: Sequence[str]) -> tuple[Group | str, float]:
    """Return a method's results on a group, or the reason why it is skipped; and the seconds."""
    start = time.perf_counter()
    try:
        result: Group | str = measure(*entry_of(name), group, limit, images=images)
    except ModuleNotFoundError as error:
        result = f"needs {error.name}"
    except InputError as error:
        result = str(error)
    return result, time.perf_counter() - start


def write(folder: Path, name: str, group: str, found: Group) -> None:
    """Write a method's results on a group, next to those on others."""
    method, entry = entry_of(name)
    path = folder / file_name(method)
    before: dict[str, Any] = json.loads(path.read_text("utf-8")) if path.exists() else {}
    groups = before["groups"] if before.get("protocol") == protocol.VERSION else {}
    content = {**described(method, entry), "groups": {**groups, group: found}}
    folder.mkdir(parents=True, exist_ok=True)
    path.write_text(_lines(content) + "\n", "utf-8")


def _lines(content: Any, indent: int = 0) -> str:
    """Return JSON with a line for each list."""
    if not isinstance(content, dict):
        return json.dumps(content)
    inner = ",\n".join(f"{' ' * (indent + 1)}{json.dumps(k)}: {_lines(v, indent + 1)}" for k, v in content.items())
    return f"{{\n{inner}\n{' ' * indent}}}"


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--methods", nargs="+", default=["all"], help="all, names, .py files, .onnx files")
    parser.add_argument("--limit", type=int, default=20, help="number of pictures of each group, 20 by default")
    parser.add_argument("--inputs", nargs="+", default=["made"], choices=list(inputs.GROUPS), help="groups of pictures")
    parser.add_argument("--images", nargs="*", default=[], help="image files of the group measured")
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1), help="processes, at most 2 by default")
    parser.add_argument("--out", type=Path, default=Path("out/sparsebench"), help="folder of the results")
    parser.add_argument("--page", action="store_true", help="write docs/sparsebench.md from bench/sparse/results alone")
    parser.add_argument("--list", action="store_true", help="list the methods")
    options = parser.parse_args(arguments)
    if options.page:
        PAGE.write_text(page(read_results(RESULTS)), "utf-8")
        return
    if options.list:
        print("\n".join(f"{name}: {entry.about}" for name, entry in ENTRIES.items()))
        return
    try:
        names = list(ENTRIES) if options.methods == ["all"] else options.methods
        tasks = [(name, group) for group in options.inputs for name in names if group in entry_of(name)[1].groups]
    except InputError as error:
        parser.error(str(error))
    os.environ.update(dict.fromkeys(THREADS, "1"))
    # Spawned, so that the processes import numpy with these.
    with ProcessPoolExecutor(max(1, options.jobs), mp_context=get_context("spawn")) as pool:
        waiting = {
            pool.submit(measured, name, group, options.limit, options.images): (name, group) for name, group in tasks
        }
        for done in as_completed(waiting):
            name, group = waiting[done]
            found, seconds = done.result()
            if isinstance(found, str):
                print(f"skipped {name} on {group}: {found}", flush=True)
            else:
                write(options.out, name, group, found)
                print(f"{name} on {group}: {seconds:.0f} s", flush=True)
    for group in options.inputs:
        found_there = [result for result in read_results(options.out) if group in result.groups]
        for places in (False, True):
            if entered := [result for result in found_there if result.places == places]:
                fewest = min(len(result.groups[group]["pictures"]) for result in entered)
                print(f"\nSSIM, {group}, {fewest} pictures:\n\n{means(entered, group, 'ssim', fewest, costs=True)}")


if __name__ == "__main__":
    main()
