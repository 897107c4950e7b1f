"""Ctrl-C while the command starts: imports take half of that, and Python would print a traceback out of them.

The package imports this before anything else, and it does nothing unless the package is imported by the command.
"""

from __future__ import annotations

import os
import signal
import sys
from typing import Any, NoReturn

INTERRUPTED = 130
"""The exit status after Ctrl-C."""


def _leave(*_: Any) -> NoReturn:
    os._exit(INTERRUPTED)  # nothing is there yet to be cleaned up


def _is_command() -> bool:
    """Whether this process was started as `bobrossnet` or `python -m bobrossnet.cli`."""
    program = os.path.basename(sys.argv[0] if sys.argv else "")
    return program == "bobrossnet" or (program == "-m" and "bobrossnet.cli" in sys.orig_argv)


def done() -> None:
    """Have Ctrl-C raise KeyboardInterrupt again."""
    if signal.getsignal(signal.SIGINT) is _leave:
        signal.signal(signal.SIGINT, signal.default_int_handler)


if _is_command() and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    signal.signal(signal.SIGINT, _leave)
