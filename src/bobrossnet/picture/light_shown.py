"""Light as pixel orders look at it."""

from __future__ import annotations

import numpy as np

from bobrossnet.color import luminance
from bobrossnet.picture.channels import GIVEN
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.transfer import transfer_of

LEAST_ALBEDO = np.float32(0.02)
"""Minimum divisor when light is demodulated, as in core/completion/guided_surfaces.cpp."""


def shown_to_orders(gbuffer: GBuffer) -> GBuffer:
    """The picture that pixel orders follow where guides are known: demodulated light, and the guides' normals.

    Edges of albedo and coverage need no samples, since guides have them.
    """
    assert gbuffer.guides is not None
    mask, albedo = gbuffer.mask, gbuffer.guides.albedo
    light = np.where(mask > 0, gbuffer.gray / np.maximum(luminance(albedo), LEAST_ALBEDO), 0)
    if "shadow" in gbuffer.layout.places:
        light += gbuffer.channel("shadow")
    planes = np.stack([mask, light, 0.5 * mask, *np.moveaxis(gbuffer.guides.normal * mask[..., None], -1, 0)])
    transfer = transfer_of(planes, GIVEN)
    return GBuffer.from_stack(planes if transfer is None else transfer.planes(planes, GIVEN))
