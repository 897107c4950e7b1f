"""Mapping of values of any range to the display-referred range of the networks, and back."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.channels import Layout

F32 = NDArray[np.float32]

BRIGHTEST = 1.001
"""Maximum of display-referred gray and colour, with a margin for rounding."""

DARKEST = 1 / 256
"""A picture whose gray and colour stay below this would look black, so it is not taken as display-referred."""

DEPTH_MARGIN = 1 / 16
"""Margin behind the farthest depth, as a fraction of the depth range, so that it stays above 0, the background."""


class Transfer(NamedTuple):
    """The mapping of one picture's gray, colour and depth to display-referred values, and back.

    A gray or colour component x becomes log(1 + x / middle) / log(1 + peak / middle): 0 stays 0, the largest traced
    value becomes 1, and above the middle, equal ratios become equal differences. A depth d becomes
    1 - (d - near) / (far - near), where far is slightly beyond the farthest traced depth.
    """

    middle: float | None
    """The median of positive gray; None if gray and colour are in 0..1."""
    peak: float
    """The maximum of gray and of the components of colour."""
    near: float | None
    """The minimum depth; None if depth is in 0..1."""
    far: float

    def encode(self, values: F32) -> F32:
        """Map gray or colours to 0..1."""
        if self.middle is None:
            return values
        encoded: F32 = np.log1p(values / np.float32(self.middle)) * np.float32(1 / self._range)
        return encoded

    def decode(self, values: F32) -> F32:
        """Invert `encode`, up to rounding."""
        if self.middle is None:
            return values
        decoded: F32 = np.expm1(values * np.float32(self._range)) * np.float32(self.middle)
        return decoded

    def slope(self, values: F32) -> F32 | float:
        """Return the derivative of `encode` at these values."""
        if self.middle is None:
            return 1.0
        return np.float32(1 / self._range) / (values + np.float32(self.middle))

    @property
    def _range(self) -> float:
        assert self.middle is not None
        return math.log1p(self.peak / self.middle)

    def planes(self, planes: F32, layout: Layout) -> F32:
        """Return a copy of a G-buffer's planes, (C, H, W), with all channels in the ranges of `CHANNELS`."""
        planes = planes.copy()
        if self.middle is not None:
            for name in ("gray", "color"):
                if name in layout.places:
                    planes[layout.places[name]] = self.encode(planes[layout.places[name]])
        if self.near is not None:
            depth = planes[layout.places["depth"]]
            nearness = (np.float32(self.far) - depth) / np.float32(self.far - self.near)
            np.copyto(depth, np.minimum(nearness, 1), where=depth != 0)
        return planes


def transfer_of(planes: F32, layout: Layout) -> Transfer | None:
    """Return the transfer of traced planes, (C, H, W) of a layout; None if all are display-referred."""
    gray, depth = planes[layout.places["gray"].start], planes[layout.places["depth"].start]
    peak = max(float(planes[layout.places[name]].max()) for name in ("gray", "color") if name in layout.places)
    middle = float(np.median(gray[gray > 0])) if peak > BRIGHTEST or 0 < peak < DARKEST else None
    near = far = None
    if depth.max() > 1 or depth.min() < 0:
        distances = depth[depth != 0]
        near, far = float(distances.min()), float(distances.max())
        far += DEPTH_MARGIN * (far - near) or 1.0
    if middle is None and near is None:
        return None
    return Transfer(middle, peak, near, 0.0 if far is None else far)
