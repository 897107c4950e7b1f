"""What arguments of the command line may be, for argparse."""

from __future__ import annotations

import argparse
import math


def add_up(parser: argparse.ArgumentParser) -> None:
    """Add --up, which says how the files' axes are meant."""
    what = "the shapes' axis that points up; y turns them upright (default: z)"
    parser.add_argument("--up", choices=("y", "z"), default="z", help=what)


def size(text: str) -> tuple[int, int]:
    """(height, width) from WIDTHxHEIGHT."""
    from bobrossnet.errors import InputError
    from bobrossnet.picture.order import check_size

    try:
        return check_size(text)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix("size: ")) from None


def fraction(text: str) -> float:
    number, percent, rest = text.partition("%")
    try:
        value = float(number) / (100 if percent else 1)
    except ValueError:
        value = -1
    if rest or not 0 < value <= 1:
        raise argparse.ArgumentTypeError(f"expected a share of the pixels, above 0% to 100% or 0 to 1, got {text!r}")
    return value


def positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"expected a number above 0, got {text!r}")
    return value


def fractions(text: str) -> tuple[float, ...]:
    """Shares of the pixels from a list such as 1%,5%."""
    return tuple(fraction(part) for part in text.split(","))
