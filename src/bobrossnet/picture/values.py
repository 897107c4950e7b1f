"""Values of channels by their names, as G-buffers, samples and guides have them, and what they may be."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.channels import CHANNELS, COLORED, GIVEN, Layout
from bobrossnet.support.errors import InputError, InputTypeError, check_array, check_finite

F32 = NDArray[np.float32]


class Channels:
    """Values by the names of their channels, one after the other in the order of a layout."""

    __slots__ = ()

    def channel(self, name: str) -> F32:
        """A channel by its name, its components last where it has several. KeyError if it is not there."""
        raise NotImplementedError

    @property
    def gray(self) -> F32:
        return self.channel("gray")

    @property
    def color(self) -> F32:
        """Linear RGB, 0..1, components last; gray where there are no colours."""
        return self.channel("color")

    @property
    def albedo(self) -> F32:
        """Linear RGB of the surface itself, 0..1, components last; white where there are no colours, 0 without a
        surface."""
        return self.channel("albedo")

    @property
    def alpha(self) -> F32:
        """1 where a surface was hit, else 0."""
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
"""What follows from the other channels where all surfaces are white, and samples exact: a surface is not exactly at
the depth 0."""

UNBOUNDED = ("gray", "color", "variance")
"""Of any size from 0 on. `depth` has any unit, the others are in the ranges of `CHANNELS`."""


def check_float32(name: str, value: Any, shape: tuple[int | None, ...], *, hint: str = "") -> F32:
    """Return `value` as a float32 array of `shape`; other dtypes are refused, not converted."""
    array = check_array(name, value, shape, hint=hint)
    if array.dtype != np.float32:
        raise InputTypeError(f"{name}: expected float32, got {array.dtype}; convert with .astype(np.float32)")
    return array


def layout_of(is_colored: bool, is_random: bool) -> Layout:
    """The channels of a G-buffer or of samples that have colours, or a variance."""
    layout = COLORED if is_colored else GIVEN
    return Layout(f"{layout.names},variance") if is_random else layout


def check_range(channel: str, array: NDArray[Any], name: str = "") -> NDArray[Any]:
    """Return `array` if its values are finite and in the range of a channel, but for rounding; `name` is what it is
    called in the error."""
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
    """The shape of a channel's values for users: components last where there are several."""
    components = CHANNELS[name].components
    return shape if components == 1 else (*shape, components)


def of_planes(planes: F32, layout: Layout, name: str) -> F32:
    """A channel of planes, (C, H, W) of a layout that has it, for users: (H, W), or (H, W, components)."""
    values = planes[layout.places[name]]
    return values[0] if CHANNELS[name].components == 1 else np.moveaxis(values, 0, -1)
