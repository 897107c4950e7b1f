"""Readers in separate processes.

Libraries written in C++ can crash on a damaged file, print unwanted output, and ignore Ctrl-C until they are done. In a
separate process a crash is contained, output is discarded, and Ctrl-C ends the reader. On Linux the process never
outlives its parent, and has limits of memory and time in proportion to the file, in addition to the parent's: a damaged
count could fill all memory, or take years.
"""

from __future__ import annotations

import ctypes
import importlib.util
import json
import os
import pickle
import signal
import sys
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from bobrossnet.adapters import reader
from bobrossnet.support.errors import InputError
from bobrossnet.support.machine import limit_memory, limit_processor, limits, set_limits, was_too_slow

PR_SET_PDEATHSIG = 1  # of Linux's prctl

# Minimum number of calls that repays a copy of the process, which takes 10 ms: a call is a face, 2 to 10 ms.
MIN_DIVIDED = 8

# Maximum memory in bytes and CPU time in seconds of reading a file. Real files need 40 MB plus some ten bytes per byte,
# and up to 2 microseconds per byte.
SPARE_MEMORY, MEMORY_PER_BYTE = 2**28, 64
SPARE_SECONDS, SECONDS_PER_BYTE = 10.0, 5e-5


_is_apart = False
_is_reader = False  # this process does nothing else


def check_library(module: str, name: str, file: Path) -> None:
    """Check that a library can read a file here.

    Raises
    ------
    InputError
        If the module is missing, or the system can't start processes.
    """
    reading = f"reading {file.suffix.lower()} files needs"
    if sys.platform == "emscripten":
        raise InputError(
            f"{reading} a process, which browsers don't start; make a .bob of it elsewhere: bobrossnet pack"
        )
    if importlib.util.find_spec(module) is None:
        raise InputError(f"{reading} {name}: pip install 'bobrossnet[cad]'")


def call_apart(module: str, function: str, *arguments: str) -> Any:
    """Call `function` of `module` in a new process; its result must be picklable.

    Raises
    ------
    InputError
        The function's own, or one that reports a crash or a timeout.
    RuntimeError
        With the type and text of any other exception of the function.
    """
    if _is_apart:
        try:
            return getattr(_imported(module), function)(*arguments)
        finally:
            _lift_limits()
    with reader.take(module) as process:
        try:
            output, _ = process.communicate(json.dumps([function, *arguments]).encode())
        except BaseException:
            process.kill()
            raise
    if was_too_slow(process.returncode):
        raise InputError("expected a file that is read within the time limit for its size, got one that takes longer")
    if process.returncode:
        raise InputError("expected a file that its reader can handle, but the reader crashed; is it damaged?")
    result, error = pickle.loads(output)  # our own child wrote it
    if error is not None:
        raise error
    return result


def _imported(module: str) -> Any:
    """Import a module; raise InputError if its library lacks one of the system, as in slim containers."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError:
        raise
    except ImportError as error:
        hint = "; Debian has it in the package libgl1" if "libGL.so" in str(error) else ""
        raise InputError(f"expected the libraries of its reader, got {error}{hint}") from None


_inherited = cache(limits)


def limit(size: int) -> None:
    """Limit this process to the cost of reading files of `size` bytes.

    Later calls may raise the limits for further files, up to those at the start of the process.
    """
    _lift_limits()
    limit_memory(SPARE_MEMORY + MEMORY_PER_BYTE * size)
    limit_processor(SPARE_SECONDS + SECONDS_PER_BYTE * size)


def divided(calls: Sequence[Callable[[], Any]]) -> list[Any]:
    """Return the results of calls, which must be picklable and raise nothing.

    In a reader's own process, a copy of it makes every second call: threads would wait for the GIL, which libraries
    hold. Linux only.
    """
    if not _is_reader or len(calls) < MIN_DIVIDED or sys.platform != "linux" or len(os.sched_getaffinity(0)) < 2:
        return [call() for call in calls]
    source, sink = os.pipe()
    reader_id = os.getpid()
    copy = os.fork()
    if copy == 0:
        try:
            _die_with(reader_id)
            with os.fdopen(sink, "wb") as stream:
                pickle.dump([call() for call in calls[1::2]], stream, protocol=pickle.HIGHEST_PROTOCOL)
            os._exit(0)
        finally:
            os._exit(1)
    os.close(sink)
    results = [None] * len(calls)
    results[::2] = [call() for call in calls[::2]]
    with os.fdopen(source, "rb") as stream:
        others = stream.read()
    status = os.waitpid(copy, 0)[1]
    if os.WIFSIGNALED(status):  # a crash, or the time limit
        os.kill(reader_id, os.WTERMSIG(status))
    if status:
        raise MemoryError
    results[1::2] = pickle.loads(others)  # our own copy wrote it
    return results


def _lift_limits() -> None:
    set_limits(_inherited())


def be_apart() -> None:
    """Mark this process as a reader that may crash: readers run in it, and output of libraries is discarded."""
    global _is_apart
    _is_apart = True
    _inherited()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for output in (1, 2):
        os.dup2(nowhere, output)


def answer() -> None:
    """Run in the child: read the request from stdin, and write the result to the original stdout."""
    global _is_reader
    _is_reader = True
    parent, module = sys.argv[2:]
    _die_with(int(parent))
    limit_memory()
    output = os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    result: Any = None
    error: Exception | None = None
    try:
        library = _imported(module)  # the slow part; the request may arrive later
        request = sys.stdin.buffer.read()
        if not request:  # the parent has nothing to read
            os._exit(0)
        function, *arguments = json.loads(request)
        result = getattr(library, function)(*arguments)
    except (InputError, MemoryError, RecursionError) as raised:
        error = raised
    except Exception as raised:  # its type may be unknown to the parent
        error = RuntimeError(f"{type(raised).__name__}: {raised}")
    with output:
        pickle.dump((result, error), output, protocol=pickle.HIGHEST_PROTOCOL)
    os._exit(0)  # the library may crash during its cleanup, too


def _die_with(parent: int) -> None:
    """Have the system kill this process with its parent: a reader holds the GIL for seconds, so no thread can watch."""
    if sys.platform != "linux":
        return
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # the parent has already ended
        os._exit(1)
