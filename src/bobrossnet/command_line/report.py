"""Output of a command: lines for people, or with --json one object for programs."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from bobrossnet.picture.files import U8, png, write_picture
from bobrossnet.support.errors import InputError

STANDARD_OUTPUT = "-"


def add_report(parser: argparse.ArgumentParser) -> None:
    """Add --json and --quiet."""
    told = parser.add_mutually_exclusive_group()
    told.add_argument("--json", action="store_true", help="print one JSON object instead of lines")
    told.add_argument("--quiet", action="store_true", help="print nothing but warnings and errors")


class Report:
    """Lines and fields of one command, and its picture; lines are on stderr if the picture is on standard output.

    Parameters
    ----------
    options : argparse.Namespace
        With `json`, `quiet`, `warnings`, a list of the warnings so far, and perhaps `out`.
    """

    def __init__(self, options: argparse.Namespace) -> None:
        self.fields: dict[str, Any] = {}
        self._options = options
        self.to_stdout = getattr(options, "out", None) == STANDARD_OUTPUT
        if self.to_stdout and sys.stdout is None:
            raise InputError("--out: expected standard output, which is closed")
        self._stream = sys.stderr if self.to_stdout else sys.stdout

    def line(self, text: str = "") -> None:
        """A line for people."""
        if not (self._options.json or self._options.quiet):
            print(text, file=self._stream)

    def write(self, picture: U8) -> str:
        """Write (H, W, 3) or (H, W, 4) uint8 to `out`, and return its name for people."""
        if not self.to_stdout:
            write_picture(self._options.out, picture)
            return str(self._options.out)
        sys.stdout.buffer.write(png(picture))
        return "standard output"

    def end(self) -> None:
        """Print the fields, if they were asked for."""
        if self._options.json:
            print(json.dumps(self.fields | {"warnings": self._options.warnings}), file=self._stream)


def plural(counts: dict[str, int]) -> dict[str, int]:
    """`counts` of a scene or a shape, as programs read them: `triangles`, whatever their number."""
    return {f"{noun}s": count for noun, count in counts.items()}
