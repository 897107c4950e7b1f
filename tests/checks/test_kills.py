"""Work killed at random moments, repeatedly, ends with the bytes of uninterrupted work."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest
from processes import COMMAND, running

KILLS = int(os.environ.get("KILLS", "50"))  # of each kind of work
TIMED = ("log.csv", "checkpoint.safetensors", "events.out")  # name prefixes of files that record times


def run(*arguments: str) -> None:
    subprocess.run([*COMMAND, *arguments], check=True, capture_output=True)


def contents(folder: Path) -> dict[str, bytes]:
    """Return the deterministic files of the work."""
    paths = [path for path in folder.rglob("*") if path.is_file() and not path.name.startswith(TIMED)]
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def kill_until_done(arguments: list[str], seconds: float, moments: random.Random, left: int) -> int:
    """Start the work, kill it, and restart it until it ends or `left` kills are used; return the number of kills."""
    used = 0
    while True:
        with running([*COMMAND, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
            end = time.monotonic() + moments.uniform(0, 1.2 * seconds)
            while used < left and process.poll() is None and time.monotonic() < end:
                time.sleep(0.005)
            if used < left and process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
                used += 1
                continue
            _, complaint = process.communicate()
            assert process.returncode == 0, complaint
            return used


def check_kills(arguments: list[str], place: Path, seed: int) -> None:
    """Check the kills of a command with `arguments`, which writes to the folder `place`."""
    start = time.monotonic()
    run(*arguments)
    seconds = time.monotonic() - start
    whole = contents(place)
    assert whole
    moments, left = random.Random(seed), KILLS
    while left:
        shutil.rmtree(place)
        left -= kill_until_done(arguments, seconds, moments, left)
        assert contents(place) == whole


def test_data_sets(tmp_path: Path) -> None:
    place = tmp_path / "data"
    check_kills(["dataset", "build", str(place), "--shapes", "6", "--test-shapes", "1"], place, seed=1)


@pytest.mark.parametrize("optimizer", ["adadelta", "muon"])
def test_trainings(optimizer: str, tmp_path: Path) -> None:
    data, place = tmp_path / "data", tmp_path / "run"
    run("dataset", "build", str(data), "--shapes", "3", "--test-shapes", "1")
    arguments = ["train", str(data), str(place), "epochs=2", "checkpoint_every=1", f"optimizer={optimizer}"]
    check_kills(arguments, place, seed=2)


def test_packing(tmp_path: Path) -> None:
    """The file is either complete or absent."""
    moments, path = random.Random(3), tmp_path / "scene.bob"
    script = tmp_path / "scene.sdf"
    script.write_text("f = sphere(1) - box(1.3)\n")
    start = time.monotonic()
    run("pack", str(path), str(script))
    seconds, whole = time.monotonic() - start, path.read_bytes()
    for _ in range(KILLS):
        path.unlink(missing_ok=True)
        with running([*COMMAND, "pack", str(path), str(script)], stdout=subprocess.DEVNULL) as process:
            time.sleep(moments.uniform(0.5, 1.1) * seconds)
            os.killpg(process.pid, signal.SIGKILL)
        assert not path.exists() or path.read_bytes() == whole
