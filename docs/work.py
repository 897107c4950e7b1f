"""Shared by measured pages: the folder of real shapes, a resumable work folder, and the machine's description."""

from __future__ import annotations

import importlib.metadata
import json
import os
import platform
import resource
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import date
from pathlib import Path

from bobrossnet import _core
from bobrossnet.support.machine import processor

ROOT = Path(__file__).parent.parent
MODELS = Path(os.environ.get("BOBROSSNET_MODELS", ROOT.parent / "shared" / "models"))


class Work:
    """A folder with the inputs of a page, and the time of each part."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._seconds_file = folder / "seconds.json"
        folder.mkdir(parents=True, exist_ok=True)
        self.seconds: dict[str, float] = (
            json.loads(self._seconds_file.read_text("utf-8")) if self._seconds_file.exists() else {}
        )

    @contextmanager
    def timed(self, part: str) -> Iterator[None]:
        """Add the time of a part of the work to its time in earlier runs."""
        print(f"== {part}", flush=True)
        start = time.monotonic()
        try:
            yield
        finally:
            self.seconds[part] = self.seconds.get(part, 0) + time.monotonic() - start
            self._seconds_file.write_text(json.dumps(self.seconds, indent=2) + "\n", "utf-8")

    def circumstances(self, packages: Sequence[str]) -> list[str]:
        """Return the machine, the hours spent, and versions, as lines of markdown."""
        versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in packages)
        times = ", ".join(f"{part} {seconds / 3600:.2f} h" for part, seconds in self.seconds.items())
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        return [
            f"- **Machine**: {processor()}, {os.cpu_count()} cores, {_core.isa()}, {platform.system()}; "
            f"at most {memory:.1f} GiB of memory. {date.today().isoformat()}.",
            f"- **Hours**: {times}.",
            f"- **Versions**: Python {platform.python_version()}, {versions}.",
        ]
