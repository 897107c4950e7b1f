"""Time of an edit: a fresh clone of the last commit is built, edited and tested.

The limits hold on two otherwise idle cores; CPU seconds hold on a busy machine too. The clone and its environment are
removed afterwards.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
CPP, CPP_TEST = "core/sampling/adaptive.cpp", "adaptive_orders"
PYTHON, PYTHON_TEST = "src/bobrossnet/tracing/upright.py", "tests/test_order.py::test_seeds_differ"


def cpu() -> float:
    """Return the CPU seconds of all child processes so far."""
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def run(folder: Path, *commands: str) -> tuple[str, str]:
    """Return the seconds and CPU seconds of shell commands in a folder; exit if one fails."""
    start, before = time.perf_counter(), cpu()
    for command in commands:
        done = subprocess.run(command, shell=True, cwd=folder, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{command}: failed\n{done.stdout}{done.stderr}")
    return f"{time.perf_counter() - start:.1f} s", f"{cpu() - before:.1f} s"


def compiled(folder: Path) -> int:
    """Return the number of steps that ninja has made in a clone."""
    log = folder / "build/native/.ninja_log"
    return len(log.read_text("utf-8").splitlines()) if log.is_file() else 0


def touched(file: Path) -> None:
    """Append a comment to a file."""
    mark = "//" if file.suffix == ".cpp" else "#"
    file.write_text(f"{file.read_text('utf-8')}{mark} edited at {time.time()}\n", "utf-8")


def main() -> None:
    rows: list[tuple[str, ...]] = []
    with tempfile.TemporaryDirectory(prefix="bobrossnet-loop-") as name:
        clone = Path(name) / "clone"
        run(ROOT, f"git clone --quiet {ROOT} {clone}")
        rows.append(("make demo, fresh clone", *run(clone, "make demo"), "120 s"))
        run(clone, "make .venv/installed-test")
        before = compiled(clone)
        run(clone, "touch -d '1 hour ago' .venv/installed-test", "make .venv/installed-test")
        rows.append(("steps that ninja makes for the next make test", str(compiled(clone) - before), "", "0"))
        run(clone, "make dev", f"build/dev/core_tests {CPP_TEST}")
        touched(clone / CPP)
        edited = run(clone, "make dev", f"build/dev/core_tests {CPP_TEST}")
        rows.append((f"{CPP} edited, one named test", *edited, "10 s"))
        touched(clone / PYTHON)
        edited = run(clone, f".venv/bin/pytest -q {PYTHON_TEST}")
        rows.append((f"{PYTHON} edited, one test", *edited, "3 s"))
    load = os.getloadavg()[2]
    print(f"{os.cpu_count()} cores, load {load:.1f}\n\n| | measured | CPU | at most |\n|---|---|---|---|")
    for row in rows:
        print(f"| {' | '.join(row)} |")


if __name__ == "__main__":
    main()
