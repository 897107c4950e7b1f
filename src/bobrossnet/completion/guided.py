"""Completion of light along guides: first surfaces of all pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import luminance
from bobrossnet.picture.gbuffer import GBuffer


def complete_guided(gbuffer: GBuffer, channel: str) -> NDArray[np.float32]:
    """Complete gray or color of a G-buffer with guides.

    Parameters
    ----------
    gbuffer : GBuffer
    channel : "gray" or "color"

    Returns
    -------
    (H, W) float32, or (H, W, 3) for color
        At least 0, in the units of the samples. Pixels of variance 0 are unchanged; noisy ones are combined with their
        neighbours.
    """
    assert gbuffer.guides is not None
    is_colored = "color" in gbuffer.layout.places
    completed = _core.Layout("color" if is_colored else "gray")
    output = np.empty((completed.width, *gbuffer.size), np.float32)
    guides = gbuffer.guides
    covered_only = "shadow" in gbuffer.layout.places  # the core's light shows surfaces only
    _core.complete_guided(
        gbuffer.layout.core, gbuffer.planes, guides.layout.core, guides.planes, completed, covered_only, output
    )
    if channel == "color":
        return np.moveaxis(output if is_colored else np.repeat(output, 3, axis=0), 0, -1)
    if not is_colored:
        gray: NDArray[np.float32] = output[0]
        return gray
    return completed_gray(gbuffer, np.moveaxis(output, 0, -1))


def completed_gray(gbuffer: GBuffer, color: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return gray of a coloured G-buffer from its completed color."""
    gray = luminance(color)
    exact = (gbuffer.mask > 0) & (gbuffer.channel("variance") == 0)
    return np.where(exact, gbuffer.gray, gray)


def guided_alpha(gbuffer: GBuffer) -> NDArray[np.float32]:
    """Return alpha of a G-buffer with guides, (H, W): coverage by surfaces plus completed shadows on the ground."""
    assert gbuffer.guides is not None
    alpha, ground = gbuffer.guides.hit, gbuffer.guides.ground
    if ground is None or "shadow" not in gbuffer.layout.places:
        return alpha
    whole = np.empty(gbuffer.size, np.float32)
    _core.complete_alpha(gbuffer.layout.core, gbuffer.planes, alpha, ground.planes, whole)
    return whole


def noise_shown(gbuffer: GBuffer) -> NDArray[np.float32]:
    """Return the standard deviation that noise leaves in the completed picture, (H, W), in sRGB 0..1."""
    guides = gbuffer.guides
    assert guides is not None
    ground = None if guides.ground is None else guides.ground.planes
    noise = np.empty(gbuffer.size, np.float32)
    _core.noise_shown(gbuffer.layout.core, gbuffer.planes, guides.layout.core, guides.planes, ground, noise)
    return noise


def smoothed(
    gbuffer: GBuffer, color: NDArray[np.float32], alpha: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return colour and alpha averaged over pixels, from those completed at pixels' centres, (H, W, 3) and (H, W).

    Pixels at edges are means over their first hits."""
    assert gbuffer.guides is not None
    guides = gbuffer.guides
    if guides.edges is None:
        return color, alpha
    planes, alpha = np.array(np.moveaxis(color, -1, 0), order="C"), np.array(alpha)
    ground = None if guides.ground is None else guides.ground.hit
    _core.smooth_edges(*guides.edges, guides.planes, ground, planes, alpha)
    return np.moveaxis(planes, 0, -1), alpha
