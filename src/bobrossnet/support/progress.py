"""Progress of long work: a bar on a terminal, otherwise plain lines."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Protocol

PATIENCE = 1.0  # seconds before the first output: short work needs no bar
LINE_EVERY = 10.0  # seconds between plain lines


class Report(Protocol):
    def __call__(self, share: float, note: str = "") -> None:
        """Report the share of work done, 0..1, with a short note."""


@contextmanager
def progress(what: str) -> Iterator[Report]:
    """Show the progress of `what` on stderr, once it has taken a second.

    Yields
    ------
    callable
        Called from time to time with the share of the work done, 0..1, and an optional note.
    """
    bar = _Bar(what) if sys.stderr is not None and sys.stderr.isatty() else _Lines(what)
    try:
        yield bar.report
    finally:
        bar.close()


class _Bar:
    def __init__(self, what: str) -> None:
        self.what = what
        self.start = time.monotonic()
        self.bar: Any = None  # rich is imported at the first output

    def report(self, share: float, note: str = "") -> None:
        if self.bar is None:
            if time.monotonic() - self.start < PATIENCE:
                return
            from rich.console import Console
            from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

            columns = ("{task.description}", BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
            self.bar = Progress(
                *columns, TextColumn("{task.fields[note]}"), console=Console(stderr=True), transient=True
            )
            self.task = self.bar.add_task(self.what, total=1.0, note="")
            self.bar.start()
        self.bar.update(self.task, completed=share, note=note)

    def close(self) -> None:
        if self.bar is not None:
            self.bar.stop()


class _Lines:
    def __init__(self, what: str) -> None:
        self.what = what
        self.start = time.monotonic()
        self.next = self.start + PATIENCE
        self.first: tuple[float, float] | None = None  # time and share at the first report: work may resume partway

    def report(self, share: float, note: str = "") -> None:
        now = time.monotonic()
        if self.first is None:
            self.first = now, share
        begin, had = self.first
        if now < self.next or share <= had:
            return
        self.next = now + LINE_EVERY
        left = (now - begin) * (1 - share) / (share - had)
        print(
            f"{self.what}: {100 * share:.0f} %, {_duration(left)} left {note}".rstrip(),
            file=sys.stderr,
            flush=True,
        )

    def close(self) -> None:
        pass


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"
