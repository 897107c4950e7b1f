"""Completing light along guides: what is known of the first surface at every pixel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import luminance
from bobrossnet.picture.channels import GIVEN
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.transfer import transfer_of

LEAST_ALBEDO = np.float32(0.02)
"""By less than this light is not divided, as in core/completion/guided.cpp."""


def complete_guided(gbuffer: GBuffer, channel: str) -> NDArray[np.float32]:
    """Gray or color of a G-buffer with guides, at all pixels.

    Returns
    -------
    (H, W) float32, or (H, W, 3) of color
        At least 0, in the units of what was traced. Pixels of which the variance is 0 are returned unchanged; of noisy
        ones, what is made of them and of those around them.
    """
    assert gbuffer.guides is not None
    is_colored = "color" in gbuffer.layout.places
    completed = _core.Layout("color" if is_colored else "gray")
    output = np.empty((completed.width, *gbuffer.size), np.float32)
    guides = gbuffer.guides
    _core.complete_guided(gbuffer.layout.core, gbuffer.planes, guides.layout.core, guides.planes, completed, output)
    if channel == "color":
        return np.moveaxis(output if is_colored else np.repeat(output, 3, axis=0), 0, -1)
    if not is_colored:
        gray: NDArray[np.float32] = output[0]
        return gray
    gray = luminance(np.moveaxis(output, 0, -1))
    exact = (gbuffer.mask > 0) & (gbuffer.channel("variance") == 0)
    return np.where(exact, gbuffer.gray, gray)


def shown_to_orders(gbuffer: GBuffer) -> GBuffer:
    """What pixel orders are to go by where guides are known: the light that is completed, and not what it falls on.

    Beside light the guides' normals, along which it bends. Where albedo or coverage ends, the guides tell.
    """
    assert gbuffer.guides is not None
    mask, albedo = gbuffer.mask, gbuffer.guides.albedo
    light = np.where(mask > 0, gbuffer.gray / np.maximum(luminance(albedo), LEAST_ALBEDO), 0)
    planes = np.stack([mask, light, 0.5 * mask, *np.moveaxis(gbuffer.guides.normal * mask[..., None], -1, 0)])
    transfer = transfer_of(planes, GIVEN)
    return GBuffer.from_stack(planes if transfer is None else transfer.planes(planes, GIVEN))
