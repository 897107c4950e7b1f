"""Figure 5.2: samples of the data set."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bobrossnet.learn.dataset import Dataset
from bobrossnet.learn.dataset.plan import PATCH, PATCHES, SIZES, STAGES
from bobrossnet.learn.dataset.store import part_of
from bobrossnet.learn.figures.figure import Drawing, Sources, data_of
from bobrossnet.learn.figures.style import picture_grid, show_picture
from bobrossnet.picture.files import traced_on_green

SHAPES = 5
LEAST = 0.25  # minimum share of hit pixels in a patch: with fewer, the shape is not recognisable


def draw_samples(sources: Sources) -> Drawing:
    """Draw a patch of several shapes: its five samples over green, and their reference."""
    data = data_of(sources)
    rng = np.random.default_rng(sources.seed)
    shapes = np.sort(rng.permutation(data.plan.shapes)[:SHAPES])
    figure, axes = picture_grid(len(shapes), len(STAGES) + 1, (PATCH, PATCH), between=0.05, left=0.3)
    for panel, title in zip(axes[0], [*(f"{100 * stage:g} %" for stage in STAGES), "reference"], strict=True):
        panel.set_title(title, pad=3)
    for i, (row, shape) in enumerate(zip(axes, shapes.tolist(), strict=True)):
        size = SIZES[i % len(SIZES)]
        patches = data.patches(shape)
        first_samples = [(shape * PATCHES + patch) * len(STAGES) for patch in range(PATCHES)]
        covered = np.count_nonzero(patches[:, 1], axis=(1, 2)) / PATCH**2
        covered *= [data.plan.sample(first).size == size for first in first_samples]
        patch = int(rng.choice(np.flatnonzero(covered >= min(LEAST, covered.max()))))
        first = first_samples[patch]
        known = patches[patch].astype(np.float32)  # (4, 128, 128)
        for stage, fraction in enumerate(STAGES):
            mask = data.plan.mask(first + stage, fraction)
            show_picture(row[stage], traced_on_green(part_of(known, mask)))
        show_picture(row[-1], known[0])
        label = f"{_name(data, shape)}\n{size} x {size}"
        row[0].text(-0.05, 0.5, label, transform=row[0].transAxes, rotation=90, ha="right", va="center")
    return Drawing(
        figure,
        f"Samples of the data set of {data.plan.samples:,}: patches of {PATCH} x {PATCH} pixels and their reference. "
        "The sizes of the views are at the left, the traced shares above. Green: not traced. "
        f"The patches are random among all with a surface on at least {100 * LEAST:g} % of their pixels.",
    )


def _name(data: Dataset, shape: int) -> str:
    """Return a short name for a shape: its number, or its file's name."""
    source = data.sources[shape]
    return f"shape {shape}" if source.startswith("made ") else Path(source).stem[:16]
