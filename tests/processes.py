"""Processes that tests start and stop."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

COMMAND = [sys.executable, "-c", "import sys; from bobrossnet.cli import main; sys.exit(main())"]
"""The command line of the package that this Python imports."""


@contextmanager
def running(command: Sequence[str], **options: Any) -> Iterator[subprocess.Popen[str]]:
    """A process that SIGINT stops; in the end it is gone, and with it whatever it started.

    A job that a script starts in the background ignores SIGINT, and would hand this down: being ignored is inherited,
    a handler is not.
    """
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        process = subprocess.Popen(command, text=True, start_new_session=True, **options)
    finally:
        signal.signal(signal.SIGINT, handler)
    with process:
        try:
            yield process
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
