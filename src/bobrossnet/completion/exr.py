"""OpenEXR files, completed: of other programs, and of what the core's tracer found."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet.completion.complete import complete
from bobrossnet.completion.network import NetworkLike
from bobrossnet.picture.exr import ExrFile, Planes
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.guides import Guides


def completed_channels(file: ExrFile, model: NetworkLike = "default") -> Planes:
    """All channels of a file at all pixels: colours as `complete` has them; others, where they are not known already,
    as light of their own. Whole numbers and the mask stay; alpha that was the mask becomes 1."""
    gbuffer, traced, colors = file.gbuffer(), file.traced(), file.roles["color"]
    color = complete(gbuffer, model, channel="gray" if len(colors) == 1 else "color").reshape(*file.size, -1)
    result: Planes = {}
    for name, values in file.planes.items():
        if name in colors:
            whole = color[..., colors.index(name)]
        elif [name] == file.roles.get("mask"):
            is_alpha = name.rpartition(".")[2].upper() == "A"
            result[name] = np.ones_like(values) if is_alpha else values
            continue
        elif values.dtype.kind != "f" or file.is_dense(name):
            whole = values
        else:
            whole = _completed(values.astype(np.float32), gbuffer, model)
        result[name] = np.where(traced, values, whole).astype(values.dtype)
    return result


def _completed(values: NDArray[np.float32], gbuffer: GBuffer, model: NetworkLike) -> NDArray[np.float32]:
    """One channel of any values."""
    known, values = gbuffer.mask > 0, np.nan_to_num(values)
    low = values[known].min(initial=0)
    guides = gbuffer.guides
    if guides is not None:  # whose albedo is what light is divided by, and nothing else
        guides = Guides(guides.depth, guides.normal, hit=guides.hit)
    light = np.where(known, values - low, 0).astype(np.float32)
    completed: NDArray[np.float32] = complete(GBuffer(mask=gbuffer.mask, gray=light, guides=guides), model) + low
    return completed


def channels_of(gbuffer: GBuffer, image: NDArray[np.float32], model: NetworkLike) -> Planes:
    """What the core's tracer found as channels of a file: colours in linear light, completed, and what was traced, as
    CONVENTIONS.md has it. `image` is the completed gray."""
    is_colored = "color" in gbuffer.layout.places
    color = complete(gbuffer, model, channel="color") if is_colored else np.repeat(image[..., None], 3, axis=-1)
    planes = {"mask": gbuffer.mask, "depth": gbuffer.depth, "gray": gbuffer.gray}
    planes["A"] = complete(gbuffer, model, channel="alpha")
    planes |= {name: color[..., i] for i, name in enumerate("RGB")}
    planes |= {f"N.{name}": gbuffer.normal[..., i] for i, name in enumerate("XY")}
    planes |= {f"albedo.{name}": gbuffer.albedo[..., i] for i, name in enumerate("RGB")}
    return {name: np.asarray(values, np.float32) for name, values in planes.items()}
