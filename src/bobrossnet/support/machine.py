"""The machine: its processor's name, and this process's memory, processor time and threads."""

from __future__ import annotations

import ctypes
import math
import os
import platform
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

from bobrossnet import _core
from bobrossnet.support.errors import check_integer

MAX_PORT = 65535

MAX_PROCESSES = 61 if sys.platform == "win32" else 256
"""Maximum number of processes: Windows waits for at most 64 objects, and Python's pools reserve three."""


def processor() -> str:
    """Return the processor's name."""
    for line in Path("/proc/cpuinfo").read_text("utf-8").splitlines() if Path("/proc/cpuinfo").exists() else []:
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def extra_memory(run: Callable[[], object]) -> int | None:
    """Return the peak memory of `run()` in bytes, above the memory before it; None if the system can't report it."""
    try:
        ctypes.CDLL(None).malloc_trim(0)  # freed memory that is still held would hide new use
        Path("/proc/self/clear_refs").write_text("5", "utf-8")  # resets the peak to the current use
    except (AttributeError, OSError, TypeError):  # other C library or system
        return None
    before = _status_bytes("VmRSS")
    run()
    return _status_bytes("VmHWM") - before


def limit_memory(more: int | None = None) -> None:
    """Limit memory, so that an absurd file ends in an error message, not in a frozen machine. Linux only.

    Parameters
    ----------
    more : bytes above the current use; by default up to the machine's memory
    """
    if sys.platform != "linux":
        return
    import resource

    if more is None:
        limit = resource.getpagesize() * os.sysconf("SC_PHYS_PAGES")
    else:
        pages = int(Path("/proc/self/statm").read_text("utf-8").split()[5])  # as counted by RLIMIT_DATA
        limit = resource.getpagesize() * pages + more
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (limit if soft == resource.RLIM_INFINITY else min(limit, soft), hard))


def limit_processor(more: float) -> None:
    """End this process by SIGXCPU after `more` further seconds of processor time. Linux only."""
    if sys.platform != "linux":
        return
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_CPU)
    limit = math.ceil(time.process_time() + more)
    resource.setrlimit(resource.RLIMIT_CPU, (limit if soft == resource.RLIM_INFINITY else min(limit, soft), hard))


def was_too_slow(status: int) -> bool:
    """Return whether an exit status is that from `limit_processor`."""
    return sys.platform == "linux" and status == -signal.SIGXCPU


def limits() -> dict[int, tuple[int, int]]:
    """Return this process's limits of memory and processor time, for `set_limits`. Linux only."""
    if sys.platform != "linux":
        return {}
    import resource

    return {kind: resource.getrlimit(kind) for kind in (resource.RLIMIT_DATA, resource.RLIMIT_CPU)}


def set_limits(limits: dict[int, tuple[int, int]]) -> None:
    """Restore the limits from `limits`."""
    if sys.platform != "linux":
        return
    import resource

    for kind, both in limits.items():
        resource.setrlimit(kind, both)


def _status_bytes(field: str) -> int:
    for line in Path("/proc/self/status").read_text("utf-8").splitlines():
        if line.startswith(field + ":"):
            return 1024 * int(line.split()[1])
    return 0


def set_thread_count(count: int) -> None:
    """Set the number of threads for tracing and completion, 1..1024."""
    _core.set_thread_count(check_integer("count", count, 1, 1024))
