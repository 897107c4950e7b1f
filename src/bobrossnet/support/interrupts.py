"""Interrupts that other people's code swallows: `except BaseException` around its imports, for example."""

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
"""What ends a program from outside. A console that is closed sends SIGBREAK on Windows, SIGHUP elsewhere."""

SIGNALS = [signal.SIGINT, *ENDING]


class Process(Protocol):
    """What `multiprocessing` and `subprocess` start."""

    @property
    def pid(self) -> int | None: ...


def interrupt(process: Process) -> None:
    """Interrupt a process that this one started, as Ctrl-C does. On Windows, Ctrl-C itself has reached it already."""
    if sys.platform != "win32" and process.pid is not None:
        os.kill(process.pid, signal.SIGINT)


@contextmanager
def heard(package: str) -> Iterator[None]:
    """Have what signals raise leave this block, whatever `package` does about it.

    It is raised again by each import that follows, and at the latest at the end; modules of the package that were
    imported meanwhile are forgotten, since they may lack what the interrupt kept from them.
    """
    if threading.current_thread() is not threading.main_thread():  # in which alone signals are handled
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
    """Finds no module; raises once more what a signal's handler raised."""

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
