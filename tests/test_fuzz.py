"""Every seed and every input that once broke a reader, and a few mutants of them: fuzz/run.py says what is checked."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

FUZZ = Path(__file__).parent / "fuzz"
PACKAGES = {"step": "OCP", "iges": "OCP", "3dm": "rhino3dm"}
SLOW = ("step", "iges", "3dm", "bob", "vm")
"""Formats of which few mutants are read: libraries that crash, and shapes that take a while to build."""


def formats():
    return sorted([folder.name for folder in (FUZZ / "seeds").iterdir()] + ["safetensors"])


@pytest.mark.parametrize("ending", formats())
def test_readers_keep_their_promises(ending):
    if ending in PACKAGES:
        pytest.importorskip(PACKAGES[ending])
    mutants = 10 if ending in SLOW else 40
    command = [sys.executable, str(FUZZ / "run.py"), "--no-page", "--format", ending, "--mutants", str(mutants)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    files = len(list((FUZZ / "seeds" / ending).glob(f"*.{ending}"))) + len(list((FUZZ / "found" / ending).glob("*")))
    told = re.match(rf"{ending}: ([\d,]+) executions, ", done.stdout)
    assert told, done.stdout
    assert int(told[1].replace(",", "")) >= files + mutants


def test_seeds_are_small():
    sizes = [file.stat().st_size for file in FUZZ.glob("*/*/*")]
    assert sum(sizes) < 300_000
    assert max(sizes) < 16_000
