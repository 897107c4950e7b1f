"""Interrupts leave the block in which a package swallows them, and nothing half imported stays behind."""

from __future__ import annotations

import importlib
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from types import FrameType

import pytest

from bobrossnet.interrupts import heard

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
