"""How a page shows its scene: attributes of <bob-view>."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from bobrossnet.picture.camera import Camera
from bobrossnet.picture.files import color_to_8_bit
from bobrossnet.pictures.rendering import BLACK, Background, background_rows


def attributes(fov: float, background: Background) -> dict[str, str]:
    """Those of a lens and a background, as `Camera` and `render` take them; none of what pages have anyhow.

    Raises
    ------
    InputError
        If either is out of range.
    """
    lens, behind, black = Camera(fov=fov).fov, css(background), css(BLACK)
    return {
        **({"field-of-view": f"{lens:g}deg"} if lens else {}),
        **({"background": behind} if behind != black else {}),
    }


def css(background: Background) -> str:
    """A background as pages have it."""
    rows = background_rows(background, 2)
    if rows is None:
        return "transparent"
    top, bottom = (f"rgb({', '.join(map(str, color_to_8_bit(row)[0]))})" for row in rows)
    return f"linear-gradient({top}, {bottom})"


def written(look: Mapping[str, str], prefix: str = "") -> str:
    """Attributes as HTML has them, each after a space."""
    return "".join(f' {prefix}{name}="{escape(value)}"' for name, value in look.items())
