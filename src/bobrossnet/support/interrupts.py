"""Signals that end a program, and child processes that are interrupted."""

from __future__ import annotations

import os
import signal
import sys
from typing import Protocol

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
