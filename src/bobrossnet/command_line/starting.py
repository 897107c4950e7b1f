"""The first import of the package.

It refuses sub-interpreters. In the command, it starts the reader of a CAD file, which imports its library meanwhile,
and makes Ctrl-C exit at once during the imports; Python would print a traceback instead.
"""

from __future__ import annotations

import os
import signal
import sys
from importlib import import_module
from typing import Any, NoReturn

from bobrossnet.adapters import reader

INTERRUPTED = 130
"""Exit status after Ctrl-C."""


def _leave(*_: Any) -> NoReturn:
    os._exit(INTERRUPTED)  # there is nothing to clean up yet


def _is_command() -> bool:
    """Return whether this process was started as `bobrossnet` or `python -m bobrossnet`."""
    program = os.path.basename(sys.argv[0] if sys.argv else "")
    return program in ("bobrossnet", "bobrossnet.exe") or (program == "-m" and "bobrossnet" in sys.orig_argv)


def done() -> None:
    """Restore KeyboardInterrupt on Ctrl-C."""
    if signal.getsignal(signal.SIGINT) is _leave:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _check_interpreter() -> None:
    """Raise ImportError in a sub-interpreter: the core needs the main interpreter's GIL."""
    for name in ("_interpreters", "_xxsubinterpreters"):  # from Python 3.13 on, and earlier
        try:
            interpreters = import_module(name)
        except ImportError:
            continue
        current, main = interpreters.get_current(), interpreters.get_main()
        if current != main:
            raise ImportError(
                "bobrossnet: expected the main interpreter, got a sub-interpreter; use threads or processes"
            )
        return


_check_interpreter()

if _is_command():
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _leave)
    if "_ARGCOMPLETE" not in os.environ:  # a shell asks for completions
        reader.start_early(sys.argv[1:])
