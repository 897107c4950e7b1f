"""Processes in which readers of `apart.py` run, and their start.

The command starts the process of a CAD file before its own imports, because OpenCascade takes a second to import. So
this module imports nothing slow.
"""

from __future__ import annotations

import atexit
import json
import os
import subprocess
import sys
from collections.abc import Sequence

OPENCASCADE, RHINO = "bobrossnet.adapters.occ", "bobrossnet.adapters.rhino"
"""Modules of readers that run in processes."""

MODULES = dict.fromkeys((".step", ".stp", ".iges", ".igs"), OPENCASCADE) | {".3dm": RHINO}
"""The reader of each ending."""

# Not multiprocessing, which would rerun a user's script without `if __name__ == "__main__"`.
# Isolated (-I), so only the parent's path is searched for imports. Without the collector of cycles: it would visit the
# hundred thousand objects of OpenCascade's classes over and over, a fifth of the time, and the process soon ends.
# The package's own __init__ does not run: it imports everything, 0.2 s.
COMMAND = (
    "import gc, json, sys; gc.disable(); sys.path[:] = json.loads(sys.argv[1]); "
    "from importlib.util import find_spec, module_from_spec; "
    "sys.modules['bobrossnet'] = module_from_spec(find_spec('bobrossnet')); "
    "from bobrossnet.adapters import apart; apart.answer()"
)

_early: dict[str, subprocess.Popen[bytes]] = {}


def start_early(arguments: Sequence[str]) -> None:
    """Start the process that reads the first CAD file among a command's arguments."""
    for argument in arguments:
        module = MODULES.get(os.path.splitext(argument)[1].lower())
        if module is not None and os.path.isfile(argument):
            _early[module] = _start(module)
            atexit.register(_end_early)
            return


def take(module: str) -> subprocess.Popen[bytes]:
    """Return a process that imports a module, and then answers one request on its stdin, for `call_apart`."""
    return _early.pop(module, None) or _start(module)


def _start(module: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-I", "-c", COMMAND, json.dumps(sys.path), str(os.getpid()), module],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},  # threads that start with numpy are useless to readers
    )


def _end_early() -> None:
    """End the process of a file that was not read after all, such as after a wrong argument."""
    while _early:
        _, process = _early.popitem()
        process.kill()
        process.communicate()
