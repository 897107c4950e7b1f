"""Completion of OpenEXR files, from other renderers and from the core's tracer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet.completion.complete import complete
from bobrossnet.completion.network import NetworkLike
from bobrossnet.picture.exr import ExrFile, Planes
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.guides import Guides


def completed_channels(file: ExrFile, model: NetworkLike = "default") -> Planes:
    """Complete every channel of a file at every pixel.

    Colours are completed by `complete`; other channels, unless they are known everywhere, as separate radiance.
    Integer channels and the mask are copied; an alpha channel that served as the mask becomes 1.
    """
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
    """Complete one channel of arbitrary values."""
    known, values = gbuffer.mask > 0, np.nan_to_num(values)
    low = values[known].min(initial=0)
    guides = gbuffer.guides
    if guides is not None:  # the albedo only demodulates radiance
        guides = Guides(guides.depth, guides.normal, hit=guides.hit)
    light = np.where(known, values - low, 0).astype(np.float32)
    completed: NDArray[np.float32] = complete(GBuffer(mask=gbuffer.mask, gray=light, guides=guides), model) + low
    return completed


def channels_of(gbuffer: GBuffer, image: NDArray[np.float32], model: NetworkLike) -> Planes:
    """Return the G-buffer of the core's tracer as channels of a file.

    The colours are linear and completed, next to the traced samples (layout: docs/reference/openexr.md). `image` is the
    completed gray.
    """
    is_colored = "color" in gbuffer.layout.places
    color = complete(gbuffer, model, channel="color") if is_colored else np.repeat(image[..., None], 3, axis=-1)
    planes = {"mask": gbuffer.mask, "depth": gbuffer.depth, "gray": gbuffer.gray}
    planes["A"] = complete(gbuffer, model, channel="alpha")
    planes |= {name: color[..., i] for i, name in enumerate("RGB")}
    planes |= {f"N.{name}": gbuffer.normal[..., i] for i, name in enumerate("XY")}
    planes |= {f"albedo.{name}": gbuffer.albedo[..., i] for i, name in enumerate("RGB")}
    return {name: np.asarray(values, np.float32) for name, values in planes.items()}
