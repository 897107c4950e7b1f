"""Signals that end a program, and child processes that are interrupted."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread
from typing import Any, Protocol

ENDING = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name)]
"""Signals that terminate a program. A closed console sends SIGBREAK on Windows, SIGHUP elsewhere."""


class Process(Protocol):
    """A process started by `multiprocessing` or `subprocess`."""

    @property
    def pid(self) -> int | None: ...


def interrupt(process: Process) -> None:
    """Interrupt a child process, as Ctrl-C does. On Windows, Ctrl-C has already reached it."""
    if sys.platform != "win32" and process.pid is not None:
        os.kill(process.pid, signal.SIGINT)


@contextmanager
def delayed() -> Iterator[None]:
    """Delay Ctrl-C. Processes started meanwhile ignore it until they call `heed`: their imports would print tracebacks.

    Other threads than the main one get no Ctrl-C. On Windows, nothing is delayed.
    """
    handler = signal.getsignal(signal.SIGINT)
    if sys.platform == "win32" or current_thread() is not main_thread() or not callable(handler):
        yield
        return
    sent: list[tuple[Any, ...]] = []
    signal.signal(signal.SIGINT, lambda *signal_and_frame: sent.append(signal_and_frame))
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # inherited, as no handler is
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        signal.signal(signal.SIGINT, handler)
        if sent:
            handler(*sent[0])


def heed() -> None:
    """Heed Ctrl-C in a process started while it was delayed."""
    if sys.platform != "win32":
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
