"""The instruction set that the core has to choose on this machine."""

import re
from pathlib import Path

AVX2 = {"avx2", "fma", "bmi1", "bmi2", "abm", "f16c", "movbe", "popcnt"}
AVX512 = AVX2 | {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}
"""Features required by each instruction set, by Linux' names; abm includes lzcnt."""


def best_instruction_set() -> str | None:
    """Return its name; None except on Linux with an x86-64, which lists the processor's features."""
    cpuinfo = Path("/proc/cpuinfo")
    flags = re.search(r"^flags\s*: (.*)$", cpuinfo.read_text("utf-8"), re.MULTILINE) if cpuinfo.is_file() else None
    if flags is None:
        return None
    has = set(flags[1].split())
    return "avx512" if has >= AVX512 else "avx2" if has >= AVX2 else "baseline"
