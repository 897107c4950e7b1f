"""Runs the tests of changes since a commit: ``make quick``, or ``make quick REV=main``.

A test file is chosen if it changed, or if it names a changed module or one of its public names. A test file of the core
is chosen if it includes a header of a changed file. If a changed file of the core has no such test, all of the core's
tests run.
"""

from __future__ import annotations

import argparse
import ast
import re
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).parent.parent
CORE_TESTS = ROOT / "build/dev/core_tests"


def changed_files(since: str) -> list[Path]:
    """Return the files that differ from a commit, and untracked files."""
    commands = (["diff", "--name-only", since], ["ls-files", "--others", "--exclude-standard"])
    names = [name for command in commands for name in git(*command).splitlines()]
    return [path for path in map(ROOT.joinpath, dict.fromkeys(names)) if path.is_file()]


def git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], cwd=ROOT, check=True, capture_output=True, text=True).stdout


def words(file: Path) -> set[str]:
    """Return the names that tests use for a file: a module's import, and its public functions and classes."""
    if file.is_relative_to(ROOT / "bindings"):
        return {f"_core.{name}" for name in re.findall(r'\bm(?:\.def\(|,) ?"(\w+)"', file.read_text())}
    if file.suffix != ".py":
        return {file.stem}
    module = ".".join(file.relative_to(ROOT / "src").with_suffix("").parts)
    defined = ast.parse(file.read_text()).body
    public = {node.name for node in defined if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    return {module} | {name for name in public if not name.startswith("_")}


def naming(tests: Iterable[Path], names: set[str]) -> list[Path]:
    """Return the tests that contain any of the names as a whole word."""
    pattern = re.compile(rf"\b(?:{'|'.join(map(re.escape, names))})\b")
    return [test for test in tests if pattern.search(test.read_text())]


def headers(file: Path) -> set[str]:
    """Return the headers that lead from tests to a core file: its header, or for a source without one its includes."""
    own = file.with_suffix(".h")
    if own.is_file():
        return {own.relative_to(ROOT / "core").as_posix()}
    return set(re.findall(r'#include "(.+?)"', file.read_text()))


def core_tests(changed: Iterable[Path]) -> list[str] | None:
    """Return the names of core tests to run, an empty list for all, None if the core did not change."""
    files = [file for file in changed if file.is_relative_to(ROOT / "core") and file.suffix in (".cpp", ".h")]
    if not files:
        return None
    chosen = []
    for file in files:
        tests = [file] if file.parent.name == "tests" else list((ROOT / "core/tests").glob("*_test.cpp"))
        tests = tests if file.parent.name == "tests" else naming(tests, headers(file))
        if not tests:
            return []
        chosen += tests
    return [
        name for test in dict.fromkeys(chosen) for name in re.findall(r"^TEST\((\w+)\)", test.read_text(), re.MULTILINE)
    ]


def python_tests(changed: Iterable[Path]) -> list[Path]:
    tests = sorted((ROOT / "tests").glob("test_*.py"))
    chosen = [test for test in tests if test in changed]
    for folder, suffixes in (("src", (".py",)), ("viewer", (".js",)), ("bindings", (".cpp",))):
        for file in changed:
            if file.is_relative_to(ROOT / folder) and file.suffix in suffixes:
                chosen += naming(tests, words(file))
    return list(dict.fromkeys(chosen))


def run(*command: str | Path) -> bool:
    print(
        "+",
        *(c.relative_to(ROOT) if isinstance(c, Path) and c.is_relative_to(ROOT) else c for c in command),
        flush=True,
    )
    return subprocess.run(command, cwd=ROOT).returncode == 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--since", default="HEAD")
    changed = changed_files(parser.parse_args().since)
    passed = True
    if python := [file for file in changed if file.suffix == ".py"]:
        passed &= run(sys.executable, "-m", "ruff", "check", *python)
        passed &= run(sys.executable, "-m", "ruff", "format", "--check", *python)
    if (names := core_tests(changed)) is not None:
        passed &= run(CORE_TESTS, *names)
    if tests := python_tests(changed):
        passed &= run(sys.executable, "-m", "pytest", "-q", *tests)
    return not passed


if __name__ == "__main__":
    sys.exit(main())
