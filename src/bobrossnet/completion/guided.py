"""Completing light along guides: what is known of the first surface at every pixel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import luminance
from bobrossnet.picture.channels import Layout
from bobrossnet.picture.gbuffer import GBuffer

LOST = ("mask", "shadow", "variance")
SHADOWS = Layout("mask,gray,variance")
"""Shadows on the ground, in gray's place."""


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


def guided_alpha(gbuffer: GBuffer) -> NDArray[np.float32]:
    """Alpha of a G-buffer with guides, (H, W): how much of each pixel surfaces cover, and shadows on the ground, which
    are completed along it."""
    assert gbuffer.guides is not None
    alpha, ground = gbuffer.guides.hit, gbuffer.guides.ground
    if ground is None or "shadow" not in gbuffer.layout.places:
        return alpha
    lost = GBuffer.from_stack(np.concatenate([gbuffer.planes[gbuffer.layout.places[name]] for name in LOST]), SHADOWS)
    output = np.empty((1, *gbuffer.size), np.float32)
    _core.complete_guided(SHADOWS.core, lost.planes, ground.layout.core, ground.planes, _core.Layout("gray"), output)
    whole: NDArray[np.float32] = np.minimum(alpha + output[0], 1)
    return whole
