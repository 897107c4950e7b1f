"""Messages about files, one line each."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bobrossnet.support.errors import InputError, InputWarning


def one_line(text: object) -> str:
    """Any text as one line of at most 200 characters."""
    line = " ".join("".join(c if c.isprintable() else " " for c in str(text)).split())
    return line if len(line) <= 200 else line[:197] + "..."


def name_of(file: Path) -> str:
    """A file's name, as errors and warnings about it begin."""
    return one_line(file.name or str(file))


def warn_of(file: Path, text: str) -> None:
    """Warn that a part of a file was left out or is not shown as it is."""
    warnings.warn(f"{name_of(file)}: {text}", InputWarning, stacklevel=2)


@contextmanager
def errors_at(place: str) -> Iterator[None]:
    """Add to an InputError which part of a file it is about: "surface 3: knots_u: expected ..."."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{place}: {error}") from error
