"""Channels: what is known of a pixel, as the core declares it (core/picture/channels.h), and layouts of several."""

from __future__ import annotations

from typing import NamedTuple

from bobrossnet import _core


class Channel(NamedTuple):
    """One named value of a pixel, or several together."""

    name: str
    components: int
    low: float
    """The least value; the largest is `high`."""
    high: float
    missed: float
    """The value of all components where a ray missed."""
    seen: bool
    """Whether what lies behind all surfaces has a value of its own."""


CHANNELS = {row[0]: Channel(*row) for row in _core.channels()}
"""By their names."""


class Layout:
    """Which channels an array holds, one after the other: planes (C, H, W), or samples (n, C).

    Of a G-buffer and of samples the first channel is the mask; in samples it says whether the ray hit.

    Parameters
    ----------
    names : str
        Names of channels, with commas between them. ValueError if there is no such channel.
    """

    def __init__(self, names: str) -> None:
        self.core = _core.Layout(names)
        self.names = names
        self.width = self.core.width
        self.places: dict[str, slice] = {}
        start = 0
        for name in names.split(","):
            stop = start + CHANNELS[name].components
            self.places[name] = slice(start, stop)
            start = stop

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Layout) and self.names == other.names

    def __hash__(self) -> int:
        return hash(self.names)

    def __repr__(self) -> str:
        return f"Layout({self.names!r})"

    def __reduce__(self) -> tuple[type[Layout], tuple[str]]:
        return Layout, (self.names,)  # what is in the core can't be copied


TRACED = Layout(_core.gbuffer_layout().names)
"""What the core's tracer finds."""

COLORED = Layout(f"{TRACED.names},color,albedo")
"""What it finds in scenes that have colours."""

GIVEN = Layout("mask,gray,depth,normal")
"""What users give for a G-buffer or samples, and `GBuffer.stack` returns."""

GUIDES = Layout("mask,depth,normal,albedo")
"""What is known of all pixels, where shading is known of few."""
