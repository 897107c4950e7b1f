"""Lights of a scene, in place of the headlight."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import Color, linear
from bobrossnet.picture.camera import Camera
from bobrossnet.picture.environment import read_environment
from bobrossnet.support.errors import InputError, InputTypeError, brief, check_direction, check_number

HEADLIGHT, STUDIO = "headlight", "studio"

MAX_INTENSITY = 1e6
"""Maximum intensity of a light: products with colours stay in float32's range."""

MAX_LIGHTS = 32
"""Maximum number of lights: each costs a ray at every surface of a path."""

BOUNCES, MAX_BOUNCES = 2, 8


@dataclass(frozen=True, init=False)
class Light:
    """A distant disc, such as the sun or a soft box. A larger angle makes softer shadows.

    Parameters
    ----------
    direction : (x, y, z)
        Towards the light, in the scene's coordinates; of any length but zero.
    angle : float in 0..180
        Angular diameter in degrees. The sun has 0.5; 0 makes sharp shadows.
    color : like a material's
        The colour of a white rough surface facing the light.
    intensity : float, at least 0
        Factor of the colour.

    Raises
    ------
    InputError
        If a value is out of range or not a number.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> sun = bob.Light(direction=(1, -1, 2), angle=0.5, color="#fff4e0")
    >>> bob.render(bob.happy_tree(), size="160x120", light=[sun, bob.Sky("#456")]).size
    (120, 160)
    """

    direction: tuple[float, float, float]
    """Unit vector towards the light."""
    angle: float
    color: tuple[float, float, float]
    """Linear RGB, 0..1."""
    intensity: float

    def __init__(self, direction: Any, *, angle: float = 2.0, color: Color = (1.0, 1.0, 1.0), intensity: float = 1.0):
        x, y, z = check_direction("direction", direction)[0].tolist()
        object.__setattr__(self, "direction", (x, y, z))
        object.__setattr__(self, "angle", check_number("angle", angle, 0, 180))
        object.__setattr__(self, "color", linear("color", color))
        object.__setattr__(self, "intensity", check_number("intensity", intensity, 0, MAX_INTENSITY))

    def core(self) -> _core.DiscLight:
        """The light in the core."""
        half = math.radians(self.angle) / 2
        red, green, blue = (self.intensity * c for c in self.color)
        return _core.DiscLight(self.direction, 2 * math.sin(half / 2) ** 2, (red, green, blue))


@dataclass(frozen=True, init=False, eq=False)
class Sky:
    """Light from all directions: one colour, a gradient of two, or an environment image.

    Parameters
    ----------
    top : like a material's color
        Light from above, and from all directions if `bottom` is omitted: the colour of a white rough surface under it.
    bottom : like a material's color, optional
        Light from below; the colour between is linear in height.
    image : path, or (H, W, 3) numbers of at least 0, optional
        An equirectangular environment: .hdr, .exr, an sRGB picture, or an array of linear radiance. Rows run from
        straight up to straight down; the middle column is the direction -x. It is multiplied by `top`.
    turn : float
        Rotation of the image about z, in degrees, anticlockwise as seen from above.
    intensity : float, at least 0
        Factor of all colours.

    Raises
    ------
    InputError
        If a value is out of range or not a number, or the image can't be read or has more than 8192 x 4096 pixels.
    """

    top: tuple[float, float, float]
    """Linear RGB, 0..1."""
    bottom: tuple[float, float, float]
    image: NDArray[np.float32] | None = field(repr=False)
    """(H, W, 3), read-only."""
    turn: float
    intensity: float

    def __init__(
        self,
        top: Color = (1.0, 1.0, 1.0),
        bottom: Color | None = None,
        *,
        image: str | os.PathLike[str] | Any = None,
        turn: float = 0.0,
        intensity: float = 1.0,
    ) -> None:
        if image is not None and bottom is not None:
            raise InputError("bottom: expected none with an image")
        object.__setattr__(self, "top", linear("top", top))
        object.__setattr__(self, "bottom", self.top if bottom is None else linear("bottom", bottom))
        object.__setattr__(self, "image", None if image is None else read_environment(image))
        object.__setattr__(self, "turn", check_number("turn", turn, -1e6, 1e6))
        object.__setattr__(self, "intensity", check_number("intensity", intensity, 0, MAX_INTENSITY))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Sky) or (self.image is None) != (other.image is None):
            return False
        numbers = (self.top, self.bottom, self.turn, self.intensity)
        same = numbers == (other.top, other.bottom, other.turn, other.intensity)
        return same and (self.image is None or np.array_equal(self.image, np.asarray(other.image)))

    __hash__ = None  # type: ignore[assignment]


LightLike: TypeAlias = str | os.PathLike[str] | Light | Sky | Iterable[Light | Sky] | None
"""`"headlight"`, `"studio"`, a light, a sky, several lights and at most one sky, or the path of an environment."""


def studio(camera: Camera) -> list[Light | Sky]:
    """Return a soft key light from the camera's upper left, a rim light from behind, and a dim sky."""
    azimuth = camera.azimuth
    if camera.position is not None:
        target = (0.0, 0.0, 0.0) if camera.target is None else camera.target
        x, y, _ = (p - t for p, t in zip(camera.position, target, strict=True))
        azimuth = math.degrees(math.atan2(y, x))
    lights: list[Light | Sky] = [
        Light(direction, angle=angle, color=(r, g, b), intensity=intensity)
        for direction, angle, (r, g, b), intensity in _core.studio_lights(azimuth)
    ]
    top, bottom, intensity = _core.studio_sky()
    return [*lights, Sky((top[0], top[1], top[2]), (bottom[0], bottom[1], bottom[2]), intensity=intensity)]


def lights_of(light: LightLike, camera: Camera) -> list[Light | Sky] | None:
    """Resolve a light argument to lights; None for the headlight."""
    chosen = check_light(light)
    if chosen is None or isinstance(chosen, str):
        return studio(camera) if chosen == STUDIO else None
    return chosen


def check_light(light: LightLike) -> str | list[Light | Sky] | None:
    """Return "headlight", "studio", or the user's lights, with environments read from files."""
    if light is None:
        return None
    if isinstance(light, str) and light in (HEADLIGHT, STUDIO):
        return light
    if isinstance(light, str | os.PathLike):
        if isinstance(light, str) and "." not in light:
            known = f"{HEADLIGHT}, {STUDIO} or the path of an environment"
            raise InputError(f"light: expected {known}, got {brief(light, of_type=False)}")
        return [Sky(image=light)]
    if isinstance(light, Light | Sky):
        return [light]
    try:
        several = list(light)
    except TypeError:
        raise InputTypeError(f"light: expected a Light, a Sky or several, got {type(light).__name__}") from None
    for one in several:
        if not isinstance(one, Light | Sky):
            raise InputTypeError(f"light: expected a Light, a Sky or several, got {type(one).__name__} among them")
    if sum(isinstance(one, Sky) for one in several) > 1:
        raise InputError("light: expected at most one Sky, got several")
    if len(several) > MAX_LIGHTS:
        raise InputError(f"light: expected at most {MAX_LIGHTS}, got {len(several)}")
    return several
