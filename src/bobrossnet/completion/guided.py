"""Completing light along guides: what is known of the first surface at every pixel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import luminance
from bobrossnet.picture.channels import Layout
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.light_shown import LEAST_ALBEDO

UNLIKE = np.float32(30)
"""Squared pixels that a difference of 1 in depth or normal counts for, where light is taken from a neighbour."""

EDGES_AT_ONCE = 4096
"""For a picture's memory."""

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
    if "shadow" in gbuffer.layout.places:  # of the core's light, which does not show what is behind surfaces
        output *= guides.hit > 0
    if channel == "color":
        return np.moveaxis(output if is_colored else np.repeat(output, 3, axis=0), 0, -1)
    if not is_colored:
        gray: NDArray[np.float32] = output[0]
        return gray
    gray = luminance(np.moveaxis(output, 0, -1))
    exact = (gbuffer.mask > 0) & (gbuffer.channel("variance") == 0)
    return np.where(exact, gbuffer.gray, gray)


def guided_alpha(gbuffer: GBuffer) -> NDArray[np.float32]:
    """Alpha of a G-buffer with guides, (H, W): coverage by surfaces, plus the completed shadows on the ground."""
    assert gbuffer.guides is not None
    alpha, ground = gbuffer.guides.hit, gbuffer.guides.ground
    if ground is None or "shadow" not in gbuffer.layout.places:
        return alpha
    lost = GBuffer.from_stack(np.concatenate([gbuffer.planes[gbuffer.layout.places[name]] for name in LOST]), SHADOWS)
    output = np.empty((1, *gbuffer.size), np.float32)
    _core.complete_guided(SHADOWS.core, lost.planes, ground.layout.core, ground.planes, _core.Layout("gray"), output)
    whole: NDArray[np.float32] = np.minimum(alpha + output[0] * (ground.hit > 0), 1)
    return whole


def smoothed(gbuffer: GBuffer, color: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Colour and alpha of whole pixels, from the completed colour of pixels' centres, (H, W, 3).

    Light changes little within a pixel, while surfaces end. Each first hit within a pixel at an edge takes the light
    of the neighbour with the most similar surface, times its own albedo.
    """
    assert gbuffer.guides is not None
    guides, alpha = gbuffer.guides, guided_alpha(gbuffer)
    edges = guides.edges
    if edges is None:
        return color, alpha
    light, shadows = color / np.maximum(guides.albedo, LEAST_ALBEDO), alpha
    color, alpha = color.copy(), alpha.copy()
    for begin in range(0, len(edges.pixels), EDGES_AT_ONCE):
        part = slice(begin, begin + EDGES_AT_ONCE)
        rows, columns = edges.pixels[part].T
        surfaces, on_ground = edges.surfaces[part], edges.ground[part]
        least = np.full(surfaces.shape[:2], np.inf, np.float32)
        lit = np.zeros((*surfaces.shape[:2], 3), np.float32)
        lost, nearest = np.zeros(surfaces.shape[:2], np.float32), least.copy()
        for down in (0, -1, 1):
            for right in (0, -1, 1):
                at = np.clip(rows + down, 0, gbuffer.size[0] - 1), np.clip(columns + right, 0, gbuffer.size[1] - 1)
                own = guides.planes[:, at[0], at[1]].T[:, None]
                apart = UNLIKE * np.abs(surfaces[..., 1:4] - own[..., 1:4]).sum(-1) + down * down + right * right
                apart[np.broadcast_to(own[..., 0] == 0, apart.shape)] = np.inf
                better = apart < least
                least = np.where(better, apart, least)
                lit = np.where(better[..., None], light[at][:, None], lit)
                if guides.ground is not None:
                    is_ground = guides.ground.hit[at] > 0
                    apart = np.where(is_ground, np.float32(down * down + right * right), np.inf)[:, None]
                    better = apart < nearest
                    nearest = np.where(better, apart, nearest)
                    lost = np.where(better, shadows[at][:, None], lost)
        hits = surfaces[..., 0]
        color[rows, columns] = (lit * surfaces[..., 4:7] * hits[..., None]).mean(1)
        alpha[rows, columns] = (hits + lost * on_ground).mean(1)
    return color, alpha
