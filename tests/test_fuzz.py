"""Every seed, every input that once broke a reader, and a few mutants; fuzz/run.py describes the checks."""

import importlib.util
import re
import subprocess
import sys
from pathlib import Path

FUZZ = Path(__file__).parent / "fuzz"
PACKAGES = {"step": "OCP", "iges": "OCP", "3dm": "rhino3dm"}
MUTANTS = 5


def test_readers_keep_their_promises():
    formats = [folder.name for folder in (FUZZ / "seeds").iterdir()]
    formats = [name for name in formats if name not in PACKAGES or importlib.util.find_spec(PACKAGES[name])]
    command = [sys.executable, str(FUZZ / "run.py"), "--no-page", "--mutants", str(MUTANTS)]
    for name in formats:
        command += ["--format", name]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    read = {name: int(count) for name, count in re.findall(r"^(\w+): (\d+) executions", done.stdout, re.MULTILINE)}
    for name in formats:
        files = [*(FUZZ / "seeds" / name).glob(f"*.{name}"), *(FUZZ / "found" / name).glob("*")]
        assert read[name] == len(files) + MUTANTS


def test_seeds_are_small():
    sizes = [file.stat().st_size for file in FUZZ.glob("*/*/*")]
    assert sum(sizes) < 300_000
    assert max(sizes) < 16_000
