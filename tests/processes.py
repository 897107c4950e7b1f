"""Processes that tests start and stop."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

COMMAND = [sys.executable, "-c", "import sys; from bobrossnet.command_line.cli import main; sys.exit(main())"]
"""The command line of the package that this Python imports."""


@contextmanager
def running(command: Sequence[str], **options: Any) -> Iterator[subprocess.Popen[str]]:
    """Run a process that SIGINT, SIGTERM and SIGHUP stop, and end it with its children afterwards.

    A script's background job ignores SIGINT, and commands under nohup ignore SIGHUP. Children inherit ignored signals,
    but not handlers.
    """
    stopping = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    handlers = {sent: signal.signal(sent, signal.default_int_handler) for sent in stopping}
    try:
        process = subprocess.Popen(command, text=True, start_new_session=True, **options)
    finally:
        for sent, handler in handlers.items():
            signal.signal(sent, handler)
    with process:
        try:
            yield process
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
