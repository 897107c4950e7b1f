"""The camera."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields

from bobrossnet import _core
from bobrossnet.errors import check_number

MAX_ANGLE = 1e6
"""Degrees either way; there float32 still tells angles apart that differ by a sixteenth of a degree."""


@dataclass(frozen=True)
class Camera:
    """An orthographic camera that orbits the scene's bounding sphere.

    Raises
    ------
    InputError
        If a value is not a finite number, azimuth or roll are beyond `MAX_ANGLE`, the elevation lies beyond the poles,
        or the zoom is not above 0.
    """

    azimuth: float = 30.0
    """Degrees; 0 looks along -x from +x, growing anticlockwise seen from +z."""
    elevation: float = 20.0
    """Degrees above the horizon, -90..90; 90 looks straight down."""
    roll: float = 0.0
    """Degrees; turns the camera anticlockwise about its line of sight, so that the picture turns clockwise."""
    zoom: float = 1.0
    """1 fits the bounding sphere exactly into the shorter side of the image, 2 shows half as much."""

    def __post_init__(self) -> None:
        for name, angle in (("azimuth", self.azimuth), ("roll", self.roll)):
            check_number(name, check_number(name, angle), -MAX_ANGLE, MAX_ANGLE)
        check_number("elevation", self.elevation, -90, 90)
        check_number("zoom", self.zoom, 1e-3, 1e6)
        for field in fields(self):
            object.__setattr__(self, field.name, float(getattr(self, field.name)))

    def core(self) -> _core.Camera:
        """The camera in the core."""
        return _core.Camera(**asdict(self))
