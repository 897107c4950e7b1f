"""Text tables."""

from __future__ import annotations

import math
from collections.abc import Sequence


def table(heading: Sequence[str], rows: Sequence[Sequence[str]], *, left: bool = False) -> str:
    """Return a markdown table, aligned in plain text too, all columns except the first to the right.

    Parameters
    ----------
    heading : the columns' names
    rows : equally many cells each
    left : whether all columns are aligned to the left
    """
    widths = [max(map(len, column)) for column in zip(heading, *rows, strict=True)]
    align = str.ljust if left else str.rjust
    lines = [
        " | ".join([first.ljust(widths[0]), *map(align, others, widths[1:])]) for first, *others in (heading, *rows)
    ]
    rule = " | ".join(["-" * widths[0], *("-" * width if left else "-" * (width - 1) + ":" for width in widths[1:])])
    return "\n".join(f"| {line} |" for line in (lines[0], rule, *lines[1:]))


def cell(number: float, digits: int, sign: str = "") -> str:
    """Format a number for a table; NaN becomes a dash.

    Parameters
    ----------
    number : float, or infinity, or NaN for a missing value
    digits : after the point
    sign : "+" to write the sign of positive numbers too
    """
    if math.isnan(number):
        return "–"
    return "∞" if number == math.inf else f"{number:{sign}.{digits}f}"


def best_bold(numbers: Sequence[float], best: Sequence[float], digits: int) -> list[str]:
    """Return a row's cells, with each column's best number in bold."""
    marks = ["**" if number == top else "" for number, top in zip(numbers, best, strict=True)]
    return [f"{mark}{cell(number, digits)}{mark}" for number, mark in zip(numbers, marks, strict=True)]


def plus_minus(mean: float, half: float, digits: int) -> str:
    """Format a difference with half of its confidence interval."""
    return f"{cell(mean, digits, '+')} ± {cell(half, digits)}"
