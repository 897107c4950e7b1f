"""Readers in separate processes.

Libraries written in C++ can crash on a damaged file, print unwanted output, and ignore Ctrl-C until they are done. In a
separate process a crash takes nothing else down, the output is discarded, and Ctrl-C ends the reader. Under Linux the
process never outlives its parent, and has limits of memory and time in proportion to the file, beside the parent's own:
a damaged count could have a library fill all of the memory, or count for years.
"""

from __future__ import annotations

import ctypes
import importlib.util
import json
import os
import pickle
import signal
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

from bobrossnet.support.errors import InputError
from bobrossnet.support.machine import limit_memory, limit_processor, limits, set_limits, was_too_slow

# Not multiprocessing, which would run the user's script a second time where it has no `if __name__ == "__main__"`.
# Isolated (-I), so that only the parent's path decides what is imported.
COMMAND = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from bobrossnet.adapters import apart; apart._answer()"
)

PR_SET_PDEATHSIG = 1  # of Linux's prctl

# What reading a file may cost, in bytes and seconds of the processor. Real files take 40 MB and some ten bytes a byte,
# and up to 2 microseconds a byte.
SPARE_MEMORY, MEMORY_PER_BYTE = 2**28, 64
SPARE_SECONDS, SECONDS_PER_BYTE = 10.0, 5e-5


_is_apart = False


def check_library(module: str, name: str, file: Path) -> None:
    """Refuse a file whose reader, a library of that name, can't run here.

    Raises
    ------
    InputError
        If there is no such module, or the system starts no processes.
    """
    reading = f"reading {file.suffix.lower()} files needs"
    if sys.platform == "emscripten":
        raise InputError(
            f"{reading} a process, which browsers don't start; make a .bob of it elsewhere: bobrossnet pack"
        )
    if importlib.util.find_spec(module) is None:
        raise InputError(f"{reading} {name}: pip install 'bobrossnet[cad]'")


def call_apart(module: str, function: str, *arguments: str) -> Any:
    """What `function` of `module` returns for these arguments in a new process; it must be picklable.

    Raises
    ------
    InputError
        The function's own, or one that says that it crashed or exceeded its time.
    RuntimeError
        With the type and the text of any other exception of the function.
    """
    if _is_apart:
        try:
            return getattr(importlib.import_module(module), function)(*arguments)
        finally:
            _lift_limits()
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
    if was_too_slow(done.returncode):
        raise InputError("expected a file that can be read in the time that its size allows, but it takes longer")
    if done.returncode:
        raise InputError("expected a file that its reader can handle, but the reader crashed; is it damaged?")
    result, error = pickle.loads(done.stdout)  # our own child wrote it
    if error is not None:
        raise error
    return result


_inherited = cache(limits)


def limit(size: int) -> None:
    """Have this process, in which files of `size` bytes are about to be read, stop at what these may cost.

    It may find more of them and say so: the last word counts, but no limit exceeds those that the process began with.
    """
    _lift_limits()
    limit_memory(SPARE_MEMORY + MEMORY_PER_BYTE * size)
    limit_processor(SPARE_SECONDS + SECONDS_PER_BYTE * size)


def _lift_limits() -> None:
    set_limits(_inherited())


def be_apart() -> None:
    """Declare this process, which exists to read files, to be one that may crash: its readers need no other, and what
    libraries print is discarded."""
    global _is_apart
    _is_apart = True
    _inherited()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for output in (1, 2):
        os.dup2(nowhere, output)


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
