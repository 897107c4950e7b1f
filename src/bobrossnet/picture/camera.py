"""The camera."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from bobrossnet import _core
from bobrossnet.support.errors import InputError, InputTypeError, check_array, check_choice, check_finite, check_number

MAX_ANGLE = 1e6
"""Degrees in either direction; here float32 still resolves a sixteenth of a degree."""

MIN_FOV, MAX_FOV = 0.1, 175.0
"""Degrees. Below, a picture is nearly orthographic; above, nearly all of it lies at its edges."""

MAX_DISTANCE = 1e6
"""Maximum distance of a camera, in radii of the scene; rounding is still far below a pixel's width."""

Triple: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True)
class Camera:
    """A camera, orthographic or, with a `fov`, in perspective.

    It orbits the scene's bounding sphere, or stands at a `position` outside or inside the scene.

    Raises
    ------
    InputError
        If a value is not a finite number; if azimuth or roll exceed `MAX_ANGLE`, the elevation passes the poles, the
        zoom is not positive, the fov is neither 0 nor within `MIN_FOV` and `MAX_FOV`, or the pan exceeds a million; if
        a position comes without a fov or with angles of an orbit, or target or up without a position; or if target and
        position coincide, or up is parallel to the line of sight. Without a target, the last two are checked once a
        scene is given.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> bob.Camera(azimuth=60, fov=35)
    Camera(azimuth=60.0, elevation=20.0, fov=35.0)
    >>> bob.Camera(position=(3, 0, 1), target=(0, 0, 1), fov=50)
    Camera(fov=50.0, position=(3.0, 0.0, 1.0), target=(0.0, 0.0, 1.0))
    """

    azimuth: float = 30.0
    """Degrees; 0 looks along -x from +x, growing anticlockwise seen from +z."""
    elevation: float = 20.0
    """Degrees above the horizon, -90..90; 90 looks straight down."""
    roll: float = 0.0
    """Degrees; turns the camera anticlockwise about its line of sight, and so the picture clockwise."""
    zoom: float = 1.0
    """Enlargement; 1 fits the bounding sphere exactly into the shorter side of the image, 2 doubles its size.

    In perspective it scales the focal length: the camera does not move.
    """
    fov: float = field(default=0.0, kw_only=True)
    """Vertical field of view in degrees at zoom 1; 0 or None is orthographic.

    In an orbit, the camera stands where the bounding sphere fits exactly into the shorter side.
    """
    pan: tuple[float, float] = field(default=(0.0, 0.0), kw_only=True)
    """Translation of camera and target to the right and up, in radii of the bounding sphere."""
    position: Triple | None = field(default=None, kw_only=True)
    """Position of the camera, (3,) in the scene's units, instead of azimuth and elevation."""
    target: Triple | None = field(default=None, kw_only=True)
    """Target of a camera at a position, (3,) in the scene's units; by default the bounding sphere's centre."""
    up: Triple = field(default=(0.0, 0.0, 1.0), kw_only=True)
    """Up direction of a camera at a position, (3,), of any nonzero length, not along the line of sight."""

    @classmethod
    def named(cls, view: str, *, roll: float = 0.0, zoom: float = 1.0, fov: float = 0.0) -> Camera:
        """Return the camera of a view: front, back, right, left, top, bottom or isometric.

        >>> import bobrossnet as bob
        >>> bob.Camera.named("front", fov=35)
        Camera(azimuth=-90.0, elevation=0.0, fov=35.0)
        """
        azimuth, elevation = VIEWS[check_choice("camera", view, tuple(VIEWS))]
        return cls(azimuth, elevation, roll, zoom, fov=fov)

    def __post_init__(self) -> None:
        if self.fov is None:
            object.__setattr__(self, "fov", 0.0)
        for name, angle in (("azimuth", self.azimuth), ("roll", self.roll)):
            check_number(name, check_number(name, angle), -MAX_ANGLE, MAX_ANGLE)
        check_number("elevation", self.elevation, -90, 90)
        check_number("zoom", self.zoom, 1e-3, 1e6)
        if check_number("fov", self.fov) and not MIN_FOV <= self.fov <= MAX_FOV:
            raise InputError(
                f"fov: expected degrees in [{MIN_FOV:g}, {MAX_FOV:g}], or 0, which is orthographic, got {self.fov:g}"
            )
        for name in ("azimuth", "elevation", "roll", "zoom", "fov"):
            object.__setattr__(self, name, float(getattr(self, name)))
        pan = _vector("pan", self.pan, 2)
        check_number("pan", max(map(abs, pan)), 0, MAX_DISTANCE)
        object.__setattr__(self, "pan", pan)
        for name in ("position", "target", "up"):
            if name == "up" or getattr(self, name) is not None:
                object.__setattr__(self, name, _vector(name, getattr(self, name), 3))
        self._check_place()

    def _check_place(self) -> None:
        default = {each.name: each.default for each in fields(self)}
        if self.position is None:
            for name in ("target", "up"):
                if getattr(self, name) != default[name]:
                    raise InputError(f"{name}: expected none without a position, as the camera then orbits the scene")
            return
        for name in ("azimuth", "elevation"):
            if getattr(self, name) != default[name]:
                raise InputError(f"{name}: expected none with a position, got {getattr(self, name):g}; use target")
        if not self.fov:
            raise InputError("position: expected a fov above 0 with it, such as fov=35, got 0, which is orthographic")
        if self.target is not None:
            self._check_sight(self.target)

    def _check_sight(self, target: ArrayLike) -> None:
        assert self.position is not None
        position, at, up = np.array(self.position), np.asarray(target, float), np.array(self.up)
        sight = at - position
        distance = np.linalg.norm(sight)
        if not distance > 1e-12 * np.linalg.norm(position):
            default = "" if self.target is not None else ", the centre of the bounding sphere"
            raise InputError(f"target: expected another place than the position, got {_text(at)}{default}, for both")
        length = np.linalg.norm(up)
        if not np.linalg.norm(np.cross(up / (length or 1), sight / distance)) > 1e-6:
            other = "(0, 0, 1)" if abs(sight[1]) > abs(sight[2]) else "(0, 1, 0)"
            raise InputError(f"up: expected a direction across the line of sight, such as {other}, got {_text(up)}")

    def __repr__(self) -> str:
        shown = [
            f"{each.name}={getattr(self, each.name)!r}"
            for each in fields(self)
            if getattr(self, each.name) != each.default
            or (self.position is None and each.name in ("azimuth", "elevation"))
        ]
        return f"Camera({', '.join(shown)})"

    def core(self, center: ArrayLike, radius: float) -> _core.Camera:
        """Return the core's camera, for the scene scaled to the unit sphere.

        Parameters
        ----------
        center : (3,) float
            Centre of the scene's bounding sphere.
        radius : float
            Radius of the scene's bounding sphere.
        """
        standpoint = None
        if self.position is not None:
            middle = np.asarray(center, float)
            target = middle if self.target is None else np.array(self.target)
            if self.target is None:
                self._check_sight(target)
            place, at = (np.array(self.position) - middle) / radius, (target - middle) / radius
            if not np.linalg.norm(place) <= MAX_DISTANCE:
                raise InputError(
                    f"position: expected at most {MAX_DISTANCE:,.0f} radii from the scene, whose bounding sphere has"
                    f" centre {_text(middle)} and radius {radius:g}, got {_text(self.position)}"
                )
            standpoint = (tuple(place), tuple(at), self.up)
        return _core.Camera(
            azimuth=self.azimuth,
            elevation=self.elevation,
            roll=self.roll,
            zoom=self.zoom,
            pan=self.pan,
            fov=self.fov,
            standpoint=standpoint,
        )


CameraLike: TypeAlias = Camera | str
"""A camera, or the name of a view."""

VIEWS = {
    "front": (-90.0, 0.0),
    "back": (90.0, 0.0),
    "right": (0.0, 0.0),
    "left": (180.0, 0.0),
    "top": (-90.0, 90.0),
    "bottom": (-90.0, -90.0),
    "isometric": (-45.0, 35.26438968),
}
"""Azimuth and elevation of each view, in degrees. The front faces -y, like an upright glTF."""


def check_camera(camera: Any) -> Camera:
    """Return `camera`, or the camera of a view's name; raise InputTypeError for other types."""
    if isinstance(camera, str):
        return Camera.named(camera)
    if not isinstance(camera, Camera):
        raise InputTypeError(
            f"camera: expected a Camera, got {type(camera).__name__}; names of views, such as front, do as well"
        )
    return camera


class Fronted(Protocol):
    """The member of `Scene` that chooses a default camera."""

    has_front: bool


FRONT = -60.0
"""Azimuth of the default camera of scenes with a front: 30 degrees to the right of it."""


def as_camera(camera: Any, scene: Fronted | None = None) -> Camera:
    """Return `camera`, the camera of a view's name, or for None the default: on the scene's front, if it has one."""
    if camera is None:
        return Camera(FRONT) if scene is not None and scene.has_front else Camera()
    return check_camera(camera)


def orbiting(camera: CameraLike | None, scene: Fronted | None = None) -> Camera:
    """Return an orbiting camera, by default as `as_camera`; raise InputError if it has a position."""
    camera = as_camera(camera, scene)
    if camera.position is not None:
        raise InputError("camera: expected an orbiting camera, got one at a position")
    return camera


def _vector(name: str, value: Any, count: int) -> tuple[float, ...]:
    array = check_finite(name, check_array(name, value, (count,)))
    return tuple(float(x) for x in array)


def _text(vector: ArrayLike) -> str:
    return "(" + ", ".join(f"{x:g}" for x in np.asarray(vector, float)) + ")"
