"""The look of a page: attributes of <bob-view>."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from bobrossnet.picture.camera import Camera
from bobrossnet.picture.files import color_to_8_bit
from bobrossnet.pictures.background import BLACK, Background, background_rows
from bobrossnet.tracing.light import LightLike, check_light


def attributes(fov: float, background: Background, light: LightLike = None) -> dict[str, str]:
    """Return the attributes of a field of view, a background and a light, without the defaults.

    Raises
    ------
    InputError
        If one is out of range.
    """
    chosen = check_light(light)
    lens, behind, black = Camera(fov=fov).fov, css(background), css(BLACK)
    return {
        **({"field-of-view": f"{lens:g}deg"} if lens else {}),
        **({"background": behind} if behind != black else {}),
        **({"light": chosen} if isinstance(chosen, str) else {}),
    }


def css(background: Background) -> str:
    """Return a background as a CSS value."""
    rows = background_rows(background, 2)
    if rows is None:
        return "transparent"
    top, bottom = (f"rgb({', '.join(map(str, color_to_8_bit(row)[0]))})" for row in rows)
    return f"linear-gradient({top}, {bottom})"


def written(look: Mapping[str, str], prefix: str = "") -> str:
    """Return attributes as HTML, each after a space."""
    return "".join(f' {prefix}{name}="{escape(value)}"' for name, value in look.items())
