"""One-line messages about files."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bobrossnet.support.errors import InputError, InputWarning


def one_line(text: object) -> str:
    """Shorten any text to one line of at most 200 characters."""
    line = " ".join("".join(c if c.isprintable() else " " for c in str(text)).split())
    return line if len(line) <= 200 else line[:197] + "..."


def counted(count: int, noun: str) -> str:
    """Return a number and a noun: 1 face, 2 faces."""
    return f"{count:,} {noun}{'s' * (count != 1)}"


def were(count: int, noun: str) -> str:
    """Return a number, a noun and a verb: 1 face was, 2 faces were."""
    return f"{counted(count, noun)} {'was' if count == 1 else 'were'}"


def kept_and_failed(kept: int, noun: str, failed: int) -> str:
    """Return the end of the line about the files of a folder."""
    return f"{were(kept, noun)} there, {counted(failed, 'file')} left out"


def left_out(file: Path, error: str) -> str:
    """Return the line about a file of a folder that failed: its whole path, since names repeat in subfolders."""
    return f"left out: {one_line(file)}: {error.removeprefix(f'{name_of(file)}: ')}"


def name_of(file: Path) -> str:
    """Return a file's name as the prefix of errors and warnings."""
    return one_line(file.name or str(file))


def warn_of(file: Path, text: str) -> None:
    """Warn that a part of a file is omitted or shown differently."""
    warnings.warn(f"{name_of(file)}: {text}", InputWarning, stacklevel=2)


@contextmanager
def errors_at(place: str) -> Iterator[None]:
    """Prefix InputErrors with a part of a file: "surface 3: knots_u: expected ..."."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{place}: {error}") from error
