"""Interrupts that foreign code swallows, for example by `except BaseException` around its imports."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.abc import MetaPathFinder
from types import FrameType, ModuleType
from typing import Any, Protocol

ENDING = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name)]
"""Signals that terminate a program. A closed console sends SIGBREAK on Windows, SIGHUP elsewhere."""

SIGNALS = [signal.SIGINT, *ENDING]


class Process(Protocol):
    """A process started by `multiprocessing` or `subprocess`."""

    @property
    def pid(self) -> int | None: ...


def interrupt(process: Process) -> None:
    """Interrupt a child process, as Ctrl-C does. On Windows, Ctrl-C has already reached it."""
    if sys.platform != "win32" and process.pid is not None:
        os.kill(process.pid, signal.SIGINT)


@contextmanager
def heard(package: str) -> Iterator[None]:
    """Ensure that exceptions of signal handlers leave this block, whatever `package` does with them.

    They are raised again by each later import, and at the latest at the end. Modules of the package imported in the
    meantime are removed, since the interrupt may have left them incomplete.
    """
    if threading.current_thread() is not threading.main_thread():  # only the main thread handles signals
        yield
        return
    handlers = {sent: signal.getsignal(sent) for sent in SIGNALS}
    ours = {sent: handler for sent, handler in handlers.items() if callable(handler)}
    before = set(sys.modules)
    again = _Again(ours)
    sys.meta_path.insert(0, again)
    for sent in ours:
        signal.signal(sent, again.handle)
    try:
        yield
    finally:
        for sent, handler in ours.items():
            signal.signal(sent, handler)
        sys.meta_path.remove(again)
        if again.sent is not None:
            for name in set(sys.modules) - before:
                if name.partition(".")[0] == package:
                    del sys.modules[name]
            again.raise_it()


class _Again(MetaPathFinder):
    """A finder that finds no module, and raises the signal handler's exception again."""

    def __init__(self, handlers: dict[Any, Any]) -> None:
        self.handlers = handlers
        self.sent: int | None = None

    def handle(self, sent: int, frame: FrameType | None) -> None:
        self.sent = sent
        self.handlers[sent](sent, frame)

    def raise_it(self) -> None:
        if self.sent is not None:
            self.handlers[self.sent](self.sent, None)

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> None:
        self.raise_it()
