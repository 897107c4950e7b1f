"""Channels, the named values of a pixel declared in core/picture/channels.h, and layouts of several."""

from __future__ import annotations

from typing import NamedTuple

from bobrossnet import _core


class Channel(NamedTuple):
    """A named value of a pixel, with one or more components."""

    name: str
    components: int
    low: float
    """The minimum value; the maximum is `high`."""
    high: float
    missed: float
    """The value of all components where a ray missed."""
    seen: bool
    """Whether the background behind all surfaces has a value."""


CHANNELS = {row[0]: Channel(*row) for row in _core.channels()}
"""All channels by name."""


class Layout:
    """The channels of an array, in sequence: planes (C, H, W), or samples (n, C).

    The first channel of a G-buffer and of samples is the mask; in samples it is 1 where the ray hit.

    Of a G-buffer and of samples the first channel is the mask; in samples it says whether the ray hit.

    Parameters
    ----------
    names : str
        Comma-separated names of channels. ValueError for an unknown name.
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
        return Layout, (self.names,)  # the core's objects can't be copied


TRACED = Layout(_core.gbuffer_layout().names)
"""Channels of the core's tracer in scenes without colours."""

COLORED = Layout(f"{TRACED.names},color,albedo")
"""Channels of the core's tracer in scenes with colours."""

GIVEN = Layout("mask,gray,depth,normal")
"""Channels of `GBuffer.stack`, and of users' G-buffers and samples."""

GUIDES = Layout("mask,depth,normal,albedo")
"""Channels known at all pixels, where shading is known at a few."""
