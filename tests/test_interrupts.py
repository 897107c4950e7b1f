"""Interrupts are answered soon, whatever is read or built."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from clocks import least
from numpy.typing import NDArray
from processes import COMMAND, running

import bobrossnet as bob
from bobrossnet.adapters.container import layout, sealed
from bobrossnet.support.interrupts import delayed

# ---- Large files -----------------------------------------------------------------------------------------


def grid(count: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A wavy sheet of 2 · count² triangles."""
    u, v = np.meshgrid(*2 * [np.linspace(0, 1, count + 1)], indexing="ij")
    points = np.stack([u, v, 0.1 * np.sin(7 * u) * np.cos(9 * v)], axis=-1).reshape(-1, 3)
    corner = np.arange(len(points)).reshape(count + 1, count + 1)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    return points, np.concatenate([np.stack(three, -1).reshape(-1, 3) for three in ((a, b, c), (a, c, d))])


def large_ply() -> bytes:
    points, triangles = grid(250)
    axes = "".join(f"property double {axis}\n" for axis in "xyz")
    head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n{axes}element face {len(triangles)}\n"
    rows = [f"{x:.9f} {y:.9f} {z:.9f}" for x, y, z in points.tolist()] + [f"3 {a} {b} {c}" for a, b, c in triangles]
    return "\n".join([f"{head}property list uchar int vertex_indices\nend_header", *rows, ""]).encode()


def large_stl() -> bytes:
    points, triangles = grid(600)
    facets = np.zeros(len(triangles), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    facets["corners"] = points[triangles]
    return bytes(80) + len(triangles).to_bytes(4, "little") + facets.tobytes()


def large_scene() -> bytes:
    places = np.tile(np.eye(4), (20_000, 1, 1))
    places[:, :3, 3] = np.random.default_rng(0).standard_normal((len(places), 3))
    material = vars(bob.Material())
    instances = [{"shape": 0, "transform": p, "material": material, "name": None} for p in places.tolist()]
    tensors = {"0.vertices": np.eye(3), "0.triangles": np.array([[0, 1, 2]], np.int32)}
    return sealed(layout({"shapes": ["mesh"], "instances": instances}, tensors))


@pytest.mark.parametrize(("name", "make"), [("a.ply", large_ply), ("a.stl", large_stl), ("a.bob", large_scene)])
def test_large_files_are_read_in_pieces(name: str, make: Callable[[], bytes], tmp_path: Path) -> None:
    """Signals are handled between Python's own steps, and every 20 ms within the core's, so no single one may take
    long. A file of 100 MB takes up to some seconds of the processor, and should be left within 0.3 s."""
    (tmp_path / name).write_bytes(make())
    bob.load(tmp_path / name)  # once, with its imports

    def longest_step() -> float:
        """Return the longest time between signals, as a share of the most that is allowed."""
        gc.disable()
        times = [time.thread_time()]
        before = signal.signal(signal.SIGALRM, lambda sent, frame: times.append(time.thread_time()))
        signal.setitimer(signal.ITIMER_REAL, 1e-3, 1e-3)
        try:
            bob.load(tmp_path / name)
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, before)
            gc.enable()
        times.append(time.thread_time())
        return float(np.diff(times).max()) / max(0.04, 0.14 * (times[-1] - times[0]))

    assert least(longest_step, 1) < 1


# ---- Processes -------------------------------------------------------------------------------------------

needs_signals = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals for processes")


@needs_signals
def test_ctrl_c_is_delayed_for_a_process_and_its_children() -> None:
    code = "import time; print(flush=True); time.sleep(0.3)"
    ended = []

    def interrupt_both() -> None:
        with delayed():
            os.kill(os.getpid(), signal.SIGINT)
            with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE) as child:
                assert child.stdout is not None
                child.stdout.readline()
                child.send_signal(signal.SIGINT)
            ended.append(child.returncode)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # background processes of a shell ignore it
    try:
        with pytest.raises(KeyboardInterrupt):
            interrupt_both()
    finally:
        signal.signal(signal.SIGINT, before)
    assert ended == [0]


@needs_signals
def test_interrupted_thumbnails_are_not_made(tmp_path: Path) -> None:
    (tmp_path / "0.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n")
    for number in range(1, 400):
        (tmp_path / f"{number}.obj").symlink_to("0.obj")
    out = tmp_path / "out"
    with running([*COMMAND, "thumbs", str(tmp_path), "-o", str(out)], stderr=subprocess.PIPE) as process:
        while process.poll() is None and not out.exists():
            time.sleep(0.01)
        os.killpg(process.pid, signal.SIGINT)
        _, told = process.communicate(timeout=60)
    assert process.returncode == 130
    assert told.splitlines()[-1] == "bobrossnet: interrupted"
    assert len([*out.iterdir()]) < 300
