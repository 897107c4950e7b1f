"""The look of a page: attributes of <bob-view>."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from bobrossnet.picture.camera import Camera
from bobrossnet.picture.files import color_to_8_bit
from bobrossnet.pictures.background import BLACK, Background, background_rows


def attributes(fov: float, background: Background, camera: Camera | None = None) -> dict[str, str]:
    """Return the attributes of a field of view, a background and a first orbit, without the defaults.

    Raises
    ------
    InputError
        If either is out of range.
    """
    lens, behind, black = Camera(fov=fov).fov, css(background), css(BLACK)
    return {
        **({"field-of-view": f"{lens:g}deg"} if lens else {}),
        **({"background": behind} if behind != black else {}),
        **({} if camera is None or camera == Camera() else {"camera-orbit": camera_orbit(camera)}),
    }


def camera_orbit(camera: Camera) -> str:
    """Return an orbit as the page has it: its angles are 0 at the front, and straight above."""
    return f"{(camera.azimuth + 90) % 360:.6g}deg {90 - camera.elevation:.6g}deg {100 / camera.zoom:.6g}%"


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
