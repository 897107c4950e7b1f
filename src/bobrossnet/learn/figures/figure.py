"""What figures are drawn from, and what drawing one gives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, TypeAlias

from matplotlib.figure import Figure

from bobrossnet.learn.dataset import Dataset
from bobrossnet.picture.camera import Camera
from bobrossnet.shapes.tree import happy_tree
from bobrossnet.tracing.scene import Scene


@dataclass(frozen=True)
class Sources:
    """What figures are drawn from; each takes what it needs."""

    weights: str = "paper"
    """Name of shipped weights, or a .safetensors file."""
    scene: Scene = field(default_factory=lambda: Scene(happy_tree()))
    """What is seen in the figures of one shape: by default the built-in scene."""
    camera: Camera = field(default_factory=Camera)
    """From where `scene` is seen."""
    data: Dataset | None = None
    scores: Path | None = None
    """CSV file of an evaluation, one row for each method, picture and share of traced pixels."""
    size: int = 512
    """Height and width in pixels of the pictures of `scene`."""
    seed: int = 0
    """Of the order of the pixels, and of what is drawn at random."""
    steps: int = 400
    """Mini-batches of each training that compares losses: on two cores all five take 6 minutes."""
    frames: int = 60
    """Of a converging picture whose stability is measured."""


class Drawing(NamedTuple):
    """A figure, and the caption that belongs below it."""

    figure: Figure
    caption: str
    csv: str = ""
    """The numbers that it shows, where they are worth keeping."""


class LeftOutError(Exception):
    """A figure can't be drawn because what the message names is missing."""


Draw: TypeAlias = Callable[[Sources], Drawing]


def data_of(sources: Sources) -> Dataset:
    """Return the data set; the figure is left out if there is none."""
    if sources.data is None:
        raise LeftOutError("it needs a data set (--data DIR)")
    return sources.data
