"""Materials: what a surface looks like under the headlight."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TypeAlias

from bobrossnet import _core
from bobrossnet.color import from_srgb
from bobrossnet.errors import InputError, InputTypeError, check_number

Color: TypeAlias = str | Sequence[float]


@dataclass(frozen=True, init=False)
class Material:
    """How a surface reflects light: after Blinn and Phong, or by metallicity and roughness, as glTF 2.0 has it
    (CONVENTIONS.md has the formulas).

    Parameters
    ----------
    color : 3 numbers in 0..1, or str
        Linear RGB; or sRGB as "#rrggbb" or "#rgb", which is converted to linear. A shape's own colours are
        multiplied by it.
    ambient, diffuse, specular : float in 0..1
        Of Blinn-Phong: how much there is of each term.
    shininess : float in 0..10000
        Of Blinn-Phong: the exponent of the highlight.
    metallic, roughness : float in 0..1, optional
        Either of them chooses glTF's model; the other one is then 0, or 0.5. Metals reflect in their colour,
        others are like plastic; the rougher, the wider the highlight.
    emissive : like color
        Light that the surface gives off, added to what it reflects.

    Raises
    ------
    InputError
        If a value is out of range or not a number, or there are values of both models.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> copper = bob.Material(color="#b87333", metallic=1, roughness=0.3)
    >>> scene = bob.Scene(bob.Instance(bob.happy_tree(), material=copper))
    >>> bob.trace(scene, size=(60, 80)).color.shape
    (60, 80, 3)
    """

    color: tuple[float, float, float]
    """Linear RGB, 0..1."""
    ambient: float
    diffuse: float
    specular: float
    shininess: float
    metallic: float | None
    """None of Blinn-Phong."""
    roughness: float | None
    emissive: tuple[float, float, float]
    """Linear RGB, 0..1."""

    def __init__(
        self,
        color: Color = (1.0, 1.0, 1.0),
        ambient: float = 0.1,
        diffuse: float = 0.7,
        specular: float = 0.2,
        shininess: float = 32.0,
        metallic: float | None = None,
        roughness: float | None = None,
        emissive: Color = (0.0, 0.0, 0.0),
    ) -> None:
        if metallic is not None or roughness is not None:
            if (ambient, diffuse, specular, shininess) != (0.1, 0.7, 0.2, 32.0):
                raise InputError(
                    "material: expected metallic and roughness, or ambient, diffuse, specular and shininess, got both"
                )
            metallic = check_number("metallic", 0.0 if metallic is None else metallic, 0, 1)
            roughness = check_number("roughness", 0.5 if roughness is None else roughness, 0, 1)
        for name, value in (
            ("color", linear("color", color)),
            ("ambient", check_number("ambient", ambient, 0, 1)),
            ("diffuse", check_number("diffuse", diffuse, 0, 1)),
            ("specular", check_number("specular", specular, 0, 1)),
            ("shininess", check_number("shininess", shininess, 0, 10_000)),
            ("metallic", metallic),
            ("roughness", roughness),
            ("emissive", linear("emissive", emissive)),
        ):
            object.__setattr__(self, name, value)

    @property
    def is_white(self) -> bool:
        """Whether what reflects is gray as light is."""
        return self.color == (1, 1, 1) and self.emissive == (0, 0, 0)

    def core(self) -> _core.Material:
        """The material in the core."""
        fields = asdict(self)
        if self.roughness is None:
            fields |= {"metallic": 0, "roughness": -1}
        return _core.Material(**fields)


def linear(name: str, color: Color) -> tuple[float, float, float]:
    """Linear RGB of a colour as users give it; `name` is the argument's, for errors."""
    if isinstance(color, str):
        if not re.fullmatch("#([0-9a-fA-F]{3}){1,2}", color):
            raise InputError(f"{name}: expected #rrggbb or 3 numbers, got {color[:40]!r}")
        digits = color[1:] if len(color) == 7 else "".join(2 * digit for digit in color[1:])
        red, green, blue = (float(from_srgb(int(digits[i : i + 2], 16) / 255)) for i in (0, 2, 4))
        return red, green, blue
    try:
        red, green, blue = color
    except (TypeError, ValueError):
        raise InputTypeError(f"{name}: expected #rrggbb or 3 numbers, got {color!r:.40}") from None
    return check_number(name, red, 0, 1), check_number(name, green, 0, 1), check_number(name, blue, 0, 1)
