"""Units of length, and their names in files."""

from __future__ import annotations

from typing import Any

from bobrossnet import _core
from bobrossnet.support.errors import InputError, check_choice

METRES: dict[str, float] = dict(_core.units())
"""Length of each unit."""

WORDS = {
    "nanometer": "nm",
    "micron": "um",
    "millimeter": "mm",
    "centimeter": "cm",
    "decimeter": "dm",
    "meter": "m",
    "kilometer": "km",
    "mil": "mil",
    "inch": "in",
    "foot": "ft",
    "yard": "yd",
    "mile": "mi",
}
"""Units of openNURBS, which writes them in the plural and with capitals."""

PLURALS = {"feet": "foot", "inches": "inch"}


def unit_of_word(word: str) -> str | None:
    """Return the unit that a file calls "millimeter" or "Millimeters"; None for an unknown word."""
    word = word.lower()
    return WORDS.get(PLURALS.get(word, word.removesuffix("s")))


def check_unit(name: str, unit: Any) -> str | None:
    """Return `unit` if it is None or one of `METRES`."""
    return None if unit is None else check_choice(name, unit, tuple(METRES))


def factor(unit: str | None, to: str | None) -> float:
    """Return the number of `to` in one `unit`; raise InputError if one of them is unknown."""
    if unit == to:
        return 1.0
    if unit is None or to is None:
        raise InputError(
            f"unit: expected a scene whose unit is known to convert it to {to}, got none; give Scene a unit"
        )
    return METRES[unit] / METRES[to]
