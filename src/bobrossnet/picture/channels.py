"""Channels: what is known of a pixel, as the core declares it (core/picture/channels.h)."""

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


CHANNELS = {row[0]: Channel(*row) for row in _core.channels()}
"""By their names."""

GBUFFER = _core.gbuffer_layout()
"""What a G-buffer and samples hold, one after the other, the mask first; in samples it says whether the ray hit."""


def channels_of(layout: _core.Layout) -> dict[str, slice]:
    """Where each channel of a layout has its components, by its name."""
    places, start = {}, 0
    for name in layout.names.split(","):
        stop = start + CHANNELS[name].components
        places[name] = slice(start, stop)
        start = stop
    return places


PLACES = channels_of(GBUFFER)
"""Where each channel of a G-buffer has its components."""
