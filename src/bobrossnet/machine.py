"""The machine in words, for what is measured on it."""

from __future__ import annotations

import ctypes
import platform
from collections.abc import Callable
from pathlib import Path


def processor() -> str:
    """Return the processor's name."""
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []:
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def extra_memory(run: Callable[[], object]) -> int | None:
    """Return how many bytes the process held at most while `run()` ran, beyond those that it held before; None where
    the system does not tell."""
    try:
        ctypes.CDLL(None).malloc_trim(0)  # what was freed but is still held would hide what is needed
        Path("/proc/self/clear_refs").write_text("5")  # the peak starts anew, from what is held now
    except (AttributeError, OSError, TypeError):  # another C library or system
        return None
    before = _status_bytes("VmRSS")
    run()
    return _status_bytes("VmHWM") - before


def _status_bytes(field: str) -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(field + ":"):
            return 1024 * int(line.split()[1])
    return 0
