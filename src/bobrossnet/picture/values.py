"""Named channel values, shared by G-buffers, samples and guides, and their checks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.channels import CHANNELS, COLORED, GIVEN, Layout
from bobrossnet.support.errors import InputError, InputTypeError, check_array, check_finite

F32 = NDArray[np.float32]


class Channels:
    """Values of several channels, in the order of a layout."""

    __slots__ = ()

    def channel(self, name: str) -> F32:
        """Return a channel, with components last if it has several. KeyError if the channel is absent."""
        raise NotImplementedError

    @property
    def gray(self) -> F32:
        return self.channel("gray")

    @property
    def color(self) -> F32:
        """Linear RGB, 0..1, components last; gray if there are no colours."""
        return self.channel("color")

    @property
    def albedo(self) -> F32:
        """Linear RGB of the surface, 0..1, components last; white if there are no colours, 0 on background."""
        return self.channel("albedo")

    @property
    def alpha(self) -> F32:
        """Coverage: 1 where a ray hit a surface, otherwise 0."""
        return self.channel("alpha")

    @property
    def depth(self) -> F32:
        return self.channel("depth")

    @property
    def normal(self) -> F32:
        return self.channel("normal")


DERIVED: dict[str, Callable[[Channels], F32]] = {
    "color": lambda held: np.repeat(held.gray[..., None], 3, -1),
    "albedo": lambda held: np.repeat(held.alpha[..., None], 3, -1),
    "alpha": lambda held: (held.depth != 0).astype(np.float32),
    "variance": lambda held: np.zeros_like(held.gray),
}
"""Channels derived from the others if all surfaces are white and the samples exact.

Hits have a depth above 0.
"""

UNBOUNDED = ("gray", "color", "variance")
"""Ranges of users' values. `depth` has any unit; the others have the ranges of `CHANNELS`."""


def check_float32(name: str, value: Any, shape: tuple[int | None, ...], *, hint: str = "") -> F32:
    """Return `value` as a float32 array of `shape`; other dtypes are refused, not converted."""
    array = check_array(name, value, shape, hint=hint)
    if array.dtype != np.float32:
        raise InputTypeError(f"{name}: expected float32, got {array.dtype}; convert with .astype(np.float32)")
    return array


def layout_of(is_colored: bool, is_random: bool) -> Layout:
    """Return the channels of a G-buffer or of samples with colours, or with a variance."""
    layout = COLORED if is_colored else GIVEN
    return Layout(f"{layout.names},variance") if is_random else layout


def check_range(channel: str, array: NDArray[Any], name: str = "") -> NDArray[Any]:
    """Return `array` if its values are finite and in a channel's range, up to rounding; `name` appears in errors."""
    name = name or channel
    check_finite(name, array)
    low, high, slack = CHANNELS[channel].low, CHANNELS[channel].high, 1e-3
    if channel in UNBOUNDED:
        if array.size and not array.min() >= -slack:
            raise InputError(f"{name}: expected values of at least 0, got {array.min():g}")
        return array
    if channel == "depth":
        return array
    if array.size and not (array.min() >= low - slack and array.max() <= high + slack):
        raise InputError(f"{name}: expected values in {low:g}..{high:g}, got {array.min():g}..{array.max():g}")
    return array


def values_shape(name: str, *shape: int) -> tuple[int, ...]:
    """Return the shape of a channel's values for users: components last if there are several."""
    components = CHANNELS[name].components
    return shape if components == 1 else (*shape, components)


def of_planes(planes: F32, layout: Layout, name: str) -> F32:
    """Return a channel of planes, (C, H, W) of a layout, for users: (H, W), or (H, W, components)."""
    values = planes[layout.places[name]]
    return values[0] if CHANNELS[name].components == 1 else np.moveaxis(values, 0, -1)
