"""Inputs and results of figures."""

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
    """The inputs of figures; each figure uses some of them."""

    weights: str = "paper"
    """Name of shipped weights, or a .safetensors file."""
    scene: Scene = field(default_factory=lambda: Scene(happy_tree()))
    """Scene of the figures with one shape: by default the built-in scene."""
    camera: Camera = field(default_factory=Camera)
    """Camera of `scene`."""
    data: Dataset | None = None
    scores: Path | None = None
    """CSV file of an evaluation, one row for each method, picture and share of traced pixels."""
    size: int = 512
    """Height and width in pixels of the pictures of `scene`."""
    seed: int = 0
    """Seed of pixel orders and random choices."""
    steps: int = 400
    """Mini-batches of each training in the comparison of losses: on two cores all five take 6 minutes."""
    frames: int = 60
    """Frames of the converging picture in the stability figure."""


class Drawing(NamedTuple):
    """A figure with its caption."""

    figure: Figure
    caption: str
    csv: str = ""
    """Its data as CSV, if worth keeping."""


class LeftOutError(Exception):
    """A figure can't be drawn; the message names the missing input."""


Draw: TypeAlias = Callable[[Sources], Drawing]


def data_of(sources: Sources) -> Dataset:
    """Return the data set; raise LeftOutError if it is missing."""
    if sources.data is None:
        raise LeftOutError("it needs a data set (--data DIR)")
    return sources.data
