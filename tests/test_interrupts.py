"""Interrupts are answered soon, and leave the block in which a package swallows them; nothing half imported stays."""

from __future__ import annotations

import gc
import importlib
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType

import numpy as np
import pytest
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.adapters.container import layout, sealed
from bobrossnet.support.interrupts import heard

SWALLOWING = """
import builtins
try:
    from swallowing import inner
except BaseException as error:
    inner = None
    builtins.swallowed.append(type(error))
try:
    from swallowing import later
except BaseException as error:
    later = None
    builtins.swallowed.append(type(error))
"""
INTERRUPTED = """
import builtins, signal
if builtins.interrupted_by is not None:
    signal.raise_signal(builtins.interrupted_by)
whole = True
"""
BESIDE = """
try:
    from swallowing import half
except BaseException:
    half = None
"""


class Ended(BaseException):
    """What a handler raises, as the command line's does at SIGTERM."""


def end(sent: int, frame: FrameType | None) -> None:
    raise Ended


@pytest.fixture
def swallowed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[type]]:
    """What the made-up package `swallowing` swallowed; SIGINT arrives while its module `inner` is imported."""
    for name, text in {"__init__": SWALLOWING, "inner": INTERRUPTED, "later": "", "half": INTERRUPTED}.items():
        (tmp_path / "swallowing").mkdir(exist_ok=True)
        (tmp_path / "swallowing" / f"{name}.py").write_text(text)
    (tmp_path / "beside_swallowing.py").write_text(BESIDE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr("builtins.swallowed", [], raising=False)
    monkeypatch.setattr("builtins.interrupted_by", signal.SIGINT, raising=False)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background ignores it
    import builtins

    yield builtins.swallowed  # type: ignore[attr-defined]
    signal.signal(signal.SIGINT, before)
    forget()


def forget() -> None:
    for name in [name for name in sys.modules if "swallowing" in name]:
        del sys.modules[name]


def test_an_interrupt_leaves_the_block(swallowed: list[type], monkeypatch: pytest.MonkeyPatch) -> None:
    importlib.import_module("swallowing")
    assert swallowed == [KeyboardInterrupt]  # as it is otherwise
    swallowed.clear()
    forget()

    before = sys.meta_path[:]
    with pytest.raises(KeyboardInterrupt), heard("swallowing"):
        importlib.import_module("swallowing")
    assert swallowed == [KeyboardInterrupt] * 2  # the next import raises it again
    assert not [name for name in sys.modules if name.startswith("swallowing")]
    assert sys.meta_path == before
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler

    monkeypatch.setattr("builtins.interrupted_by", None)
    with heard("swallowing"):
        assert importlib.import_module("swallowing").inner.whole


def test_only_modules_that_came_meanwhile_are_forgotten(swallowed: list[type], monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of other packages stay, and those that were there before."""
    monkeypatch.setattr("builtins.interrupted_by", None)
    whole = importlib.import_module("swallowing")
    monkeypatch.setattr("builtins.interrupted_by", signal.SIGINT)
    with pytest.raises(KeyboardInterrupt), heard("swallowing"):
        importlib.import_module("beside_swallowing")
    assert sys.modules["swallowing"] is whole
    assert "swallowing.half" not in sys.modules
    assert "beside_swallowing" in sys.modules


def test_a_handler_raises_what_it_raises(swallowed: list[type], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("builtins.interrupted_by", signal.SIGTERM)
    before = signal.signal(signal.SIGTERM, end)
    try:
        with pytest.raises(Ended), heard("swallowing"):
            importlib.import_module("swallowing")
        assert swallowed == [Ended] * 2
        assert signal.getsignal(signal.SIGTERM) is end

        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        with heard("swallowing"):
            assert importlib.import_module("swallowing").inner.whole
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGTERM, before)


def test_other_errors_are_left_to_the_package(swallowed: list[type], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("builtins.interrupted_by", "none")  # of which no signal is made
    with heard("swallowing"):
        assert importlib.import_module("swallowing").inner is None
    assert swallowed == [TypeError]


def test_other_threads_are_left_alone(swallowed: list[type], monkeypatch: pytest.MonkeyPatch) -> None:
    """Signals arrive in the main one, and handlers can't be set elsewhere."""
    monkeypatch.setattr("builtins.interrupted_by", None)
    before, handler, seen = sys.meta_path[:], signal.getsignal(signal.SIGINT), []

    def work() -> None:
        with heard("swallowing"):
            seen.append(importlib.import_module("swallowing").inner.whole)
            seen.append(sys.meta_path == before and signal.getsignal(signal.SIGINT) is handler)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [True, True]


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
    bob.load(tmp_path / name)  # once, with what it imports
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
    assert np.diff(times).max() < max(0.04, 0.14 * (times[-1] - times[0]))
