"""Figure 2.1: convergence of a picture."""

from __future__ import annotations

import bobrossnet as bob
from bobrossnet.learn.figures.figure import Drawing, Sources
from bobrossnet.learn.figures.style import picture_grid, show_picture
from bobrossnet.picture.files import traced_on_green

FRACTIONS = (0.01, 0.05, 0.25, 0.5, 1.0)
PIXELS = 192  # maximum size: in larger pictures single pixels are invisible in print


def draw_convergence(sources: Sources) -> Drawing:
    """Draw the traced pixels at several stages over green."""
    size = (min(sources.size, PIXELS),) * 2
    figure, axes = picture_grid(1, len(FRACTIONS), size)
    full = bob.trace(sources.scene, sources.camera, size=size)
    for panel, fraction in zip(axes[0], FRACTIONS, strict=True):
        show_picture(
            panel, traced_on_green(full.sample(fraction, order="uniform", seed=sources.seed)), f"{100 * fraction:g} %"
        )
    return Drawing(
        figure,
        f"A picture of {size[1]} x {size[0]} pixels converges: the share that has been traced, in uniformly random "
        "order. Green: not yet traced.",
    )
