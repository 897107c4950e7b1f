"""Readers in separate processes.

Libraries written in C++ can crash on a damaged file, print unwanted output, and ignore Ctrl-C until they are done. In a
separate process a crash takes nothing else down, the output is discarded, and Ctrl-C ends the reader. The process
inherits memory limits; under Linux it never outlives its parent.
"""

from __future__ import annotations

import ctypes
import importlib
import json
import os
import pickle
import signal
import subprocess
import sys
from typing import Any

from bobrossnet.errors import InputError

# Not multiprocessing, which would run the user's script a second time where it has no `if __name__ == "__main__"`.
# Isolated (-I), so that only the parent's path decides what is imported.
COMMAND = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from bobrossnet.adapters import apart; apart._answer()"
)

PR_SET_PDEATHSIG = 1  # of Linux's prctl


def call_apart(module: str, function: str, *arguments: str) -> Any:
    """What `function` of `module` returns for these arguments in a new process; it must be picklable.

    Raises
    ------
    InputError
        The function's own, or one that says that it crashed.
    RuntimeError
        With the type and the text of any other exception of the function.
    """
    command = [
        sys.executable,
        "-I",
        "-c",
        COMMAND,
        json.dumps(sys.path),
        str(os.getpid()),
        module,
        function,
        *arguments,
    ]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}  # which start with numpy, and are of no use to readers
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
    )
    if done.returncode:
        raise InputError("expected a file that its reader can handle, but the reader crashed; is it damaged?")
    result, error = pickle.loads(done.stdout)  # our own child wrote it
    if error is not None:
        raise error
    return result


def _answer() -> None:
    """The child's side: arguments come in `sys.argv`, the answer goes to what was stdout before it was silenced."""
    parent, module, function, *arguments = sys.argv[2:]
    _die_with(int(parent))
    answer = os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    result: Any = None
    error: Exception | None = None
    try:
        result = getattr(importlib.import_module(module), function)(*arguments)
    except (InputError, MemoryError, RecursionError) as raised:
        error = raised
    except Exception as raised:  # of a library that the parent need not have
        error = RuntimeError(f"{type(raised).__name__}: {raised}")
    with answer:
        pickle.dump((result, error), answer, protocol=pickle.HIGHEST_PROTOCOL)
    os._exit(0)  # the library may crash during its clean-up, too


def _die_with(parent: int) -> None:
    """Have the system kill this process when its parent is gone: a reader holds the interpreter's lock for seconds, so
    no thread could watch for that."""
    if sys.platform != "linux":
        return
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # gone before
        os._exit(1)
