"""How long an edit takes: a fresh clone of the last commit is built, edited and tested.

The limits hold on two cores. The clone and its environment are removed afterwards.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
CPP, CPP_TEST = "core/sampling/adaptive.cpp", "adaptive_orders"
PYTHON, PYTHON_TEST = "src/bobrossnet/pictures/upright.py", "tests/test_order.py::test_seeds_differ"


def run(folder: Path, *commands: str) -> float:
    """Seconds that shell commands take in a folder; ends the program if one fails."""
    start = time.perf_counter()
    for command in commands:
        done = subprocess.run(command, shell=True, cwd=folder, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{command}: failed\n{done.stdout}{done.stderr}")
    return time.perf_counter() - start


def compiled(folder: Path) -> int:
    """How many steps ninja has made in a clone."""
    log = folder / "build/native/.ninja_log"
    return len(log.read_text("utf-8").splitlines()) if log.is_file() else 0


def touched(file: Path) -> None:
    """A comment more at a file's end."""
    mark = "//" if file.suffix == ".cpp" else "#"
    file.write_text(f"{file.read_text('utf-8')}{mark} edited at {time.time()}\n", "utf-8")


def main() -> None:
    rows: list[tuple[str, str, str]] = []
    with tempfile.TemporaryDirectory(prefix="bobrossnet-loop-") as name:
        clone = Path(name) / "clone"
        run(ROOT, f"git clone --quiet {ROOT} {clone}")
        rows.append(("make demo, fresh clone", f"{run(clone, 'make demo'):.0f} s", "120 s"))
        run(clone, "make .venv/installed-test")
        before = compiled(clone)
        run(clone, "touch -d '1 hour ago' .venv/installed-test", "make .venv/installed-test")
        rows.append(("steps that ninja makes for the next make test", str(compiled(clone) - before), "0"))
        run(clone, "make dev", f"build/native/core_tests {CPP_TEST}")
        touched(clone / CPP)
        edited = run(clone, "make dev", f"build/native/core_tests {CPP_TEST}")
        rows.append((f"{CPP} edited, one named test", f"{edited:.1f} s", "10 s"))
        touched(clone / PYTHON)
        edited = run(clone, f".venv/bin/pytest -q {PYTHON_TEST}")
        rows.append((f"{PYTHON} edited, one test", f"{edited:.1f} s", "3 s"))
    print(f"{os.cpu_count()} cores\n\n| | measured | at most |\n|---|---|---|")
    for row in rows:
        print("| {} | {} | {} |".format(*row))


if __name__ == "__main__":
    main()
