"""The look of a page: attributes of <bob-view>."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from bobrossnet.picture.camera import Camera
from bobrossnet.picture.files import color_to_8_bit
from bobrossnet.pictures.background import BLACK, Background, background_rows
from bobrossnet.support.errors import InputError, brief
from bobrossnet.tracing.light import HEADLIGHT, STUDIO, LightLike
from bobrossnet.tracing.scene import Scene


def attributes(fov: float, background: Background, light: LightLike = None) -> dict[str, str]:
    """Return the attributes of a field of view, a background and a light, without the defaults.

    Raises
    ------
    InputError
        If one is out of range, or the page does not have the light.
    """
    if light not in (None, HEADLIGHT, STUDIO):
        raise InputError(f"light: expected {HEADLIGHT} or {STUDIO} in a page, got {brief(light)}")
    lens, behind, black = Camera(fov=fov).fov, css(background), css(BLACK)
    return {
        **({"field-of-view": f"{lens:g}deg"} if lens else {}),
        **({"background": behind} if behind != black else {}),
        **({"light": STUDIO} if light == STUDIO else {}),
    }


def light_in_page(scene: Scene) -> str | None:
    """Return the light of a scene if the page has it; others are shown under the headlight."""
    return scene.light if isinstance(scene.light, str) else None


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
