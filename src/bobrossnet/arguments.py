"""What arguments of the command line may be, for argparse."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Sequence


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


def background(text: str | None) -> str | tuple[str, str] | None:
    """What `render` takes, from transparent, a color, or two with a comma between them; black by default."""
    if text == "transparent":
        return None
    first, comma, second = (text or "#000000").partition(",")
    return (first, second) if comma else first


def numbers(text: str) -> tuple[float, ...]:
    """Coordinates from a list such as 1,-0.5,2."""
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected numbers with commas between them, got {text!r}") from None


def with_lists_joined(arguments: Sequence[str]) -> list[str]:
    """The same with lists that begin with a minus joined to their options, since argparse takes them for options."""
    joined: list[str] = []
    for argument in arguments:
        if joined and re.fullmatch(r"--\w+", joined[-1]) and re.match(r"-[\d.]+,", argument):
            joined[-1] += f"={argument}"
        else:
            joined.append(argument)
    return joined


def fractions(text: str) -> tuple[float, ...]:
    """Shares of the pixels from a list such as 1%,5%."""
    return tuple(fraction(part) for part in text.split(","))
