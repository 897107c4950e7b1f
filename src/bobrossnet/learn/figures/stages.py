"""Figures 6.3 and 6.4: a shape at increasing shares of traced pixels, completed, and the reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.completion.network import NetworkLike, load_network
from bobrossnet.learn.evaluation.methods import own_output
from bobrossnet.learn.figures.figure import Drawing, Sources
from bobrossnet.learn.figures.style import picture_grid, show_picture
from bobrossnet.picture.files import traced_on_green
from bobrossnet.support.errors import InputError

SPARSE = (0.01, 0.02, 0.05, 0.10)  # figure 6.3
DENSE = (0.25, 0.50, 0.75, 1.0)  # figure 6.4

F32 = NDArray[np.float32]


@dataclass(frozen=True)
class Stage:
    """A view at one share of traced pixels.

    Attributes
    ----------
    part : GBuffer, the traced pixels
    completed : (H, W) float32 in 0..1, traced pixels kept
    raw : (H, W) float32 in 0..1, the raw network output, clamped
    completed_ssim, raw_ssim : SSIM of the two
    """

    part: bob.GBuffer
    completed: F32 = field(repr=False)
    raw: F32 = field(repr=False)
    completed_ssim: float
    raw_ssim: float


def complete_stages(
    full: bob.GBuffer, fractions: Sequence[float], *, model: NetworkLike = "default", seed: int = 0
) -> list[Stage]:
    """Complete a view from increasing shares of its pixels, as in a converging picture.

    Parameters
    ----------
    full : GBuffer, every pixel traced
    fractions : shares of the pixels, each in (0, 1]
    model : name of shipped weights, a .safetensors file, or a loaded network
    seed : of the pixel order

    Raises
    ------
    InputError
        If pixels of `full` are untraced, or another argument is invalid.
    """
    if not full.mask.all():
        raise InputError(f"full: expected every pixel traced, got {full!r}")
    network = load_network(model)
    stages = []
    for fraction in fractions:
        part = full.sample(fraction, order="uniform", seed=seed)
        completed, raw = bob.complete(part, model=network), own_output(network, part)
        stages.append(Stage(part, completed, raw, bob.ssim(completed, full.gray), bob.ssim(raw, full.gray)))
    return stages


def draw_sparse(sources: Sources) -> Drawing:
    """Draw the shape at low shares of traced pixels."""
    return _draw(sources, SPARSE)


def draw_dense(sources: Sources) -> Drawing:
    """Draw the shape at high shares of traced pixels, up to all."""
    return _draw(sources, DENSE)


def _draw(sources: Sources, fractions: Sequence[float]) -> Drawing:
    size = (sources.size, sources.size)
    full = bob.trace(sources.scene, sources.camera, size=size)
    stages = complete_stages(full, fractions, model=sources.weights, seed=sources.seed)
    figure, grid = picture_grid(3, 1 + len(stages), size)
    show_picture(grid[1, 0], full.gray, "reference")
    for empty in grid[[0, 2], 0]:
        empty.set_axis_off()
    for column, stage in zip(grid[:, 1:].T, stages, strict=True):
        show_picture(column[0], traced_on_green(stage.part), f"{round(100 * stage.part.fraction, 1):g} % traced")
        show_picture(column[1], stage.completed, f"completed: SSIM {_text(stage.completed_ssim)}")
        show_picture(column[2], stage.raw, f"output: SSIM {_text(stage.raw_ssim)}")
    return Drawing(
        figure,
        f"A shape in {size[1]} x {size[0]} pixels, partly traced. Top: the traced pixels, the others green. "
        "Middle: completed, with traced pixels kept. Bottom: the network's output at every pixel. SSIM against the "
        "reference at the left.",
        stages_csv(stages),
    )


def stages_csv(stages: Sequence[Stage]) -> str:
    """Return the scores as CSV, a row for each stage."""
    lines = [f"{stage.part.fraction:.6f},{stage.completed_ssim:.6f},{stage.raw_ssim:.6f}" for stage in stages]
    return "\n".join(["fraction,completed_ssim,raw_ssim", *lines, ""])


def _text(ssim: float) -> str:
    """Format an SSIM with three digits; 1 is reserved for exact pictures."""
    return "1" if ssim == 1 else f"{min(ssim, 0.999):.3f}"
