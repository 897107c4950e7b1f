"""Runs each target of core/fuzz for a given time, two at once, and reports the results; `make fuzz` calls it."""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

CORPUS = Path(__file__).parent / "corpus"
LONGEST = 1 << 10
"""Bytes of an input; of texts, which take words, four times as many."""
WORDS = {
    "files": "files/*.cpp",
    "gltf": "files/gltf*.cpp",
    "script": "modelling/*.cpp",
    "threemf": "files/threemf/*.cpp",
    "vm": "formula/vm.cpp",
}
"""Targets that read text. libFuzzer inserts the quoted words of each file."""


def run(binary: Path, seconds: int) -> bool:
    """Run one target, print one line, or more about a crash; return True without a crash."""
    name = binary.name.removeprefix("fuzz_")
    found, crashes = (binary.parent / folder / name for folder in ("corpus", "crashes"))
    found.mkdir(parents=True, exist_ok=True)
    crashes.mkdir(parents=True, exist_ok=True)
    dictionary = found.parent / f"{name}.dict"
    sources = [path.read_text("utf-8") for path in CORPUS.parent.parent.glob(WORDS.get(name, "none"))]
    words = {f"{word}\n" for source in sources for word in re.findall(r'"[\w*/+-]+"', source)}
    dictionary.write_text("".join(sorted(words)), "utf-8")
    command = [
        binary,
        f"-max_total_time={seconds}",
        f"-max_len={LONGEST * (4 if name in WORDS else 1)}",
        "-timeout=10",
        "-rss_limit_mb=3000",
        f"-artifact_prefix={crashes}/",
        "-print_final_stats=1",
        *([f"-dict={dictionary}"] if words else []),
        found,
        CORPUS / name,
    ]
    result = subprocess.run(command, capture_output=True, text=True, errors="replace")
    told = dict(re.findall(r"stat::(\w+): +(\d+)", result.stderr))
    executions = int(told.get("number_of_executed_units", 0))
    rate = int(told.get("average_exec_per_sec", 0))
    inputs = len(list(found.iterdir())) + len(list((CORPUS / name).iterdir()))
    good = result.returncode == 0
    line = f"{name:12} {executions:>12,} executions {rate:>7,} a second {inputs:>6,} inputs"
    if not good:
        where = re.search(r"Test unit written to (.+)", result.stderr)
        what = re.findall(r"^(?:expected: |SUMMARY: |.+ runtime error: |terminate called ).+$", result.stderr, re.M)
        line = "\n    ".join([f"{line}  CRASHED", *what, where.group(1) if where else result.stderr[-1000:]])
    print(line, flush=True)
    return good


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="the folder of the built targets, which also receives their findings")
    parser.add_argument("--seconds", type=int, default=60, help="for each target")
    parser.add_argument("--target", default="*", help="one of them")
    options = parser.parse_args()
    binaries = sorted(path for path in options.folder.glob(f"fuzz_{options.target}") if path.is_file())
    if not binaries:
        print(f"TARGET: expected one of core/fuzz/*.cpp, got {options.target}", file=sys.stderr)
        return 2
    with ThreadPoolExecutor(2) as pool:
        results = list(pool.map(lambda binary: run(binary, options.seconds), binaries))
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main())
