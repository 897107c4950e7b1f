"""Lights in scene files: the entry `light` of the metadata, and the tensor of an environment."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.json import numbers, read_json
from bobrossnet.support.errors import InputError, InputTypeError, brief, check_flag
from bobrossnet.tracing.light import HEADLIGHT, STUDIO, Light, LightLike, Sky, check_light
from bobrossnet.tracing.scene import Scene

ENTRY = "light"
"""The entry of the metadata; readers may ignore it, unless there is an environment."""

ENVIRONMENT = "environment"
"""The tensor of a sky's image, (H, W, 3) float32."""

DISC = ("direction", "angle", "color", "intensity")
SKY = ("top", "bottom", "turn", "intensity")


def stored(scene: Scene) -> tuple[dict[str, Any] | None, NDArray[np.float32] | None]:
    """Return the entry of a scene's light and ground, or None, and the image of its sky, or None."""
    if scene.light is None and scene.ground is None:
        return None, None
    if scene.light is None or isinstance(scene.light, str):
        return {"lights": scene.light, "ground": scene.ground}, None
    fields = [
        {name: getattr(light, name) for name in (SKY if isinstance(light, Sky) else DISC)} for light in scene.light
    ]
    image = next((light.image for light in scene.light if isinstance(light, Sky)), None)
    return {"lights": fields, "ground": scene.ground}, image


def restored(text: str | None, image: NDArray[Any] | None) -> tuple[LightLike, bool | None]:
    """Return a scene's light and ground.

    Raises
    ------
    InputError
        If the entry has other fields, or values out of range, or there is an image without a sky.
    """
    content = {"lights": None, "ground": None} if text is None else read_json(text)
    if not isinstance(content, dict) or content.keys() != {"lights", "ground"}:
        raise InputTypeError(f"{ENTRY}: expected an object of lights, ground")
    lights, ground = content["lights"], content["ground"]
    if image is not None and (image.dtype != np.float32 or not isinstance(lights, list)):
        raise InputTypeError(f"{ENVIRONMENT}: expected float32, of a scene with a sky")
    if isinstance(lights, list):
        lights = [_light(f"{ENTRY}.lights[{i}]", fields, image) for i, fields in enumerate(lights)]
        if image is not None and not any(isinstance(light, Sky) for light in lights):
            raise InputError(f"{ENVIRONMENT}: expected a sky that has it")
    elif lights not in (None, HEADLIGHT, STUDIO):  # any other text would be the path of an environment
        raise InputTypeError(f"{ENTRY}.lights: expected a list, {HEADLIGHT} or {STUDIO}, got {brief(lights)}")
    return check_light(lights), None if ground is None else check_flag(f"{ENTRY}.ground", ground)


def _light(place: str, fields: Any, image: NDArray[Any] | None) -> Light | Sky:
    given = set(fields) if isinstance(fields, dict) else set()
    if given not in (set(DISC), set(SKY)):
        raise InputTypeError(f"{place}: expected an object of {', '.join(DISC)} or of {', '.join(SKY)}")
    try:
        for name in {"direction", "color", "top", "bottom"} & given:
            numbers(name, fields[name])
        if given == set(SKY):
            if image is None:
                return Sky(**fields)
            if fields["bottom"] != fields["top"]:
                raise InputError("bottom: expected top's colour with an environment")
            return Sky(fields["top"], image=image, turn=fields["turn"], intensity=fields["intensity"])
        light = Light(**fields)
        if not math.dist(light.direction, fields["direction"]) < 1e-9:
            raise InputError("direction: expected unit length")
        object.__setattr__(light, "direction", tuple(map(float, fields["direction"])))  # to the bit
        return light
    except InputError as error:
        raise InputError(f"{place}.{error}") from error
