"""The machine: its name, and the memory and time that this process takes of it, or may take."""

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

MAX_PROCESSES = 61 if sys.platform == "win32" else 256
"""At once: Windows waits for at most 64 things, and Python's pools need three of them for themselves."""


def processor() -> str:
    """Return the processor's name."""
    for line in Path("/proc/cpuinfo").read_text("utf-8").splitlines() if Path("/proc/cpuinfo").exists() else []:
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def extra_memory(run: Callable[[], object]) -> int | None:
    """Return how many bytes the process held at most while `run()` ran, beyond what it held before; None where the
    system does not report it."""
    try:
        ctypes.CDLL(None).malloc_trim(0)  # memory that was freed but is still held would hide the need for more
        Path("/proc/self/clear_refs").write_text("5", "utf-8")  # the peak starts anew, from what is held now
    except (AttributeError, OSError, TypeError):  # another C library or system
        return None
    before = _status_bytes("VmRSS")
    run()
    return _status_bytes("VmHWM") - before


def limit_memory(more: int | None = None) -> None:
    """Let allocations fail that go beyond a limit, so that an absurd file ends in an error message, not in a frozen
    machine. Only Linux has this.

    Parameters
    ----------
    more : bytes in addition to those that the process holds; by default it may have all memory of the machine
    """
    if sys.platform != "linux":
        return
    import resource

    if more is None:
        limit = resource.getpagesize() * os.sysconf("SC_PHYS_PAGES")
    else:
        pages = int(Path("/proc/self/statm").read_text("utf-8").split()[5])  # what RLIMIT_DATA counts
        limit = resource.getpagesize() * pages + more
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (limit if soft == resource.RLIM_INFINITY else min(limit, soft), hard))


def limit_processor(more: float) -> None:
    """Have this process end with SIGXCPU after so many more seconds of the processor. Only Linux has this."""
    if sys.platform != "linux":
        return
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_CPU)
    limit = math.ceil(time.process_time() + more)
    resource.setrlimit(resource.RLIMIT_CPU, (limit if soft == resource.RLIM_INFINITY else min(limit, soft), hard))


def was_too_slow(status: int) -> bool:
    """Return whether `limit_processor` ended the process with this exit status."""
    return sys.platform == "linux" and status == -signal.SIGXCPU


def limits() -> dict[int, tuple[int, int]]:
    """Return this process's limits of memory and processor, for `set_limits`. Only Linux has them."""
    if sys.platform != "linux":
        return {}
    import resource

    return {kind: resource.getrlimit(kind) for kind in (resource.RLIMIT_DATA, resource.RLIMIT_CPU)}


def set_limits(limits: dict[int, tuple[int, int]]) -> None:
    """Set what `limits` returned before."""
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
    """Set the number of threads that trace and complete, 1..1024."""
    _core.set_thread_count(check_integer("count", count, 1, 1024))
