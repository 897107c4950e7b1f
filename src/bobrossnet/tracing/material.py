"""Materials: what a surface looks like under the headlight."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TypeAlias

from bobrossnet import _core
from bobrossnet.errors import InputError, InputTypeError, check_number

Color: TypeAlias = str | Sequence[float]


@dataclass(frozen=True, init=False)
class Material:
    """How a surface reflects light, after Blinn and Phong (CONVENTIONS.md has the formula).

    Parameters
    ----------
    color : 3 numbers in 0..1, or str
        Linear RGB; or sRGB as "#rrggbb", which is converted to linear.
    ambient, diffuse, specular : float in 0..1
        How much there is of each term.
    shininess : float in 0..10000
        The exponent of the highlight.

    Raises
    ------
    InputError
        If a value is out of range or not a number.
    """

    color: tuple[float, float, float]
    """Linear RGB, 0..1."""
    ambient: float
    diffuse: float
    specular: float
    shininess: float

    def __init__(
        self,
        color: Color = (1.0, 1.0, 1.0),
        ambient: float = 0.1,
        diffuse: float = 0.7,
        specular: float = 0.2,
        shininess: float = 32.0,
    ) -> None:
        for name, value in (
            ("color", _linear(color)),
            ("ambient", check_number("ambient", ambient, 0, 1)),
            ("diffuse", check_number("diffuse", diffuse, 0, 1)),
            ("specular", check_number("specular", specular, 0, 1)),
            ("shininess", check_number("shininess", shininess, 0, 10_000)),
        ):
            object.__setattr__(self, name, value)

    def core(self) -> _core.Material:
        """The material in the core."""
        return _core.Material(**asdict(self))


def _linear(color: Color) -> tuple[float, float, float]:
    if isinstance(color, str):
        if not re.fullmatch("#[0-9a-fA-F]{6}", color):
            raise InputError(f"color: expected #rrggbb or 3 numbers, got {color[:40]!r}")
        red, green, blue = (_from_srgb(int(color[i : i + 2], 16) / 255) for i in (1, 3, 5))
        return red, green, blue
    try:
        red, green, blue = color
    except (TypeError, ValueError):
        raise InputTypeError(f"color: expected #rrggbb or 3 numbers, got {color!r:.40}") from None
    return check_number("color", red, 0, 1), check_number("color", green, 0, 1), check_number("color", blue, 0, 1)


def _from_srgb(value: float) -> float:
    """IEC 61966-2-1: sRGB's curve, undone."""
    return float(value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4)
