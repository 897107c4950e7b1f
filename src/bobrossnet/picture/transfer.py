"""Values of any range, as other tracers have them, to those that networks know, and back."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.channels import Layout

F32 = NDArray[np.float32]

BRIGHTEST = 1.001
"""Of display-referred gray and colour, but for rounding."""

DARKEST = 1 / 256
"""A picture without any brighter gray or colour shows nothing as it is: it is one of another range, too."""

DEPTH_MARGIN = 1 / 16
"""What lies at the back still has a depth above 0, where nothing is: this much of the picture's range."""


class Transfer(NamedTuple):
    """How gray, colour and depth of one picture become display-referred, and back.

    A gray or a component x of a colour becomes log(1 + x / middle) / log(1 + peak / middle): 0 stays 0, the largest
    that was traced becomes 1, and from the middle on, equal ratios become equal differences. A depth d becomes
    1 - (d - near) / (far - near) of the distances that were traced, where far is a little farther than they are.
    """

    middle: float | None
    """The median of gray where it is above 0; None where gray and colour are in 0..1 as they are."""
    peak: float
    """The largest gray, or component of a colour."""
    near: float | None
    """The least depth; None where it is in 0..1 as it is."""
    far: float

    def encode(self, values: F32) -> F32:
        """Gray or colours to 0..1."""
        if self.middle is None:
            return values
        encoded: F32 = np.log1p(values / np.float32(self.middle)) * np.float32(1 / self._range)
        return encoded

    def decode(self, values: F32) -> F32:
        """The inverse, but for rounding."""
        if self.middle is None:
            return values
        decoded: F32 = np.expm1(values * np.float32(self._range)) * np.float32(self.middle)
        return decoded

    def slope(self, values: F32) -> F32 | float:
        """By how much more or less differences from these values count once they are encoded."""
        if self.middle is None:
            return 1.0
        return np.float32(1 / self._range) / (values + np.float32(self.middle))

    @property
    def _range(self) -> float:
        assert self.middle is not None
        return math.log1p(self.peak / self.middle)

    def planes(self, planes: F32, layout: Layout) -> F32:
        """A copy of the planes of a G-buffer, (C, H, W), with all channels in the ranges of `CHANNELS`."""
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
    """The transfer of what was traced, planes (C, H, W) of a layout; None where all is display-referred as it is."""
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
