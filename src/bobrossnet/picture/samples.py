"""Samples: a tracer's results at some pixels."""

from __future__ import annotations

from math import isqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import LUMINANCE, luminance
from bobrossnet.picture.channels import CHANNELS, Layout
from bobrossnet.picture.values import DERIVED, F32, Channels, check_range, layout_of, values_shape
from bobrossnet.support.errors import InputError, check_array, check_integer, shape_of

MOST_SAMPLES = 64
"""Maximum number of samples of a pixel, on a grid of 8 x 8."""


def grid_side(samples: Any) -> int:
    """Return the side of a pixel's grid of samples; raise InputError unless their number is a square."""
    side = isqrt(check_integer("samples", samples, 1, MOST_SAMPLES))
    if side * side != samples:
        squares = ", ".join(str(root * root) for root in range(1, isqrt(MOST_SAMPLES) + 1))
        raise InputError(f"samples: expected one of {squares}, got {samples}")
    return side


class Samples(Channels):
    """A tracer's results at n pixels.

    Parameters
    ----------
    gray : (n,) numbers of at least 0, optional
        By default the luminance of `color`. Of any range: traced values are kept unchanged, and completion maps them
        by `GBuffer.transfer`.
    depth : (n,) numbers, optional
        In 0..1: 1 at the point of the scene's bounding sphere nearest the camera, 0 at the farthest, linear along the
        line of sight; in perspective linear in the distance from the camera, which may stand within the sphere. If any
        sample of a picture exceeds this range, all are distances from the camera, in any unit. By default 0.5.
    normal : (n, 2) numbers in -1..1, optional
        In screen space, x right and y up. By default 0, towards the camera.
    hit : (n,) bool, optional
        False where the ray missed: depth, normal and albedo are ignored, and gray and color are the background. NaN
        and infinity become black there. By default true.
    color : (n, 3) numbers of at least 0, optional
        Linear RGB, in the range of gray.
    albedo : (n, 3) numbers in 0..1, optional
        Linear RGB of the surface, white by default.
    variance : (n,) or (n, 3) numbers of at least 0, optional
        Variance of the mean of gray, or of each component of color, for noisy samples; later samples of the pixel are
        averaged with it. By default 0, exact.

    Raises
    ------
    InputError
        If the lengths differ, or a value is not finite or out of range where `hit` is true.
    """

    __slots__ = ("given", "layout", "values")

    given: frozenset[str]
    """The parameters given, except `hit`."""
    layout: Layout
    """The channels of the values."""
    values: F32
    """All values, (n, C) in the layout's order; the mask is 1 where the ray hit."""

    def __init__(
        self,
        gray: Any = None,
        depth: Any = None,
        normal: Any = None,
        hit: Any = None,
        color: Any = None,
        albedo: Any = None,
        variance: Any = None,
    ) -> None:
        first = "color" if gray is None else "gray"
        if gray is None and color is None:
            raise InputError("gray: expected gray or color, got neither")
        if hit is None:
            n = len(check_array(first, color if gray is None else gray, (None,) if first == "gray" else (None, 3)))
            hits = np.ones(n, np.bool_)
        else:
            hits = check_array("hit", hit, (None,))
            if not np.isin(hits, (0, 1)).all():
                raise InputError(f"hit: expected booleans, got other values of dtype {hits.dtype}")
            n = len(hits)
        self.layout = layout_of(color is not None or albedo is not None, variance is not None)
        self.values = np.zeros((n, self.layout.width), np.float32)
        self.values[:, 0] = hits
        hits = self.hit

        def put(name: str, value: Any) -> None:
            hint = f"one for each of {'hit' if hit is not None else first}"
            array = check_array(name, value, values_shape(name, n), hint=hint).reshape(n, CHANNELS[name].components)
            with np.errstate(over="ignore"):  # values too large for float32 are reported as infinite
                array = array.astype(np.float32)
            check_range(name, array[hits])
            if not hits.all():
                shines = CHANNELS[name].seen
                behind = np.where(np.isfinite(array), array, 0) if shines else CHANNELS[name].missed
                array = np.where(hits[:, None], array, behind)
                if shines:
                    check_range(name, array)
            self.values[:, self.layout.places[name]] = array

        if variance is not None and len(shape_of(variance)) == 2:
            variance = check_array("variance", variance, (n, 3), hint=f"one or three for each of {first}")
            check_range("variance", variance)
            # The components of a path are correlated: this is the upper bound.
            variance = np.square(np.sqrt(np.maximum(variance, 0)) @ LUMINANCE)
        parameters = (
            ("color", color, None),
            ("gray", gray, None),
            ("depth", depth, 0.5),
            ("normal", normal, 0),
            ("albedo", albedo, 1),
            ("variance", variance, None),
        )
        self.given = frozenset(name for name, value, _ in parameters if value is not None)
        for name, value, default in parameters:
            if value is not None:
                put(name, value)
            elif default is not None and name in self.layout.places:
                self.values[:, self.layout.places[name]] = np.where(hits[:, None], default, CHANNELS[name].missed)
        if gray is None:
            self.values[:, self.layout.places["gray"].start] = luminance(self.channel("color"))
        elif color is None and "color" in self.layout.places:
            self.values[:, self.layout.places["color"]] = self.gray[:, None]

    @classmethod
    def from_values(cls, values: F32, layout: Layout) -> Samples:
        """Make samples from values of a layout, without checks or a copy."""
        samples = object.__new__(cls)
        samples.layout, samples.values = layout, values
        samples.given = frozenset(layout.places) - {"mask"}
        return samples

    def in_layout(self, layout: Layout) -> F32:
        """Return a copy of the values, (n, C), in another layout of channels that they have."""
        columns = [self.values[:, :1] if name == "mask" else self.channel(name) for name in layout.places]
        return np.concatenate([column.reshape(len(self), -1) for column in columns], axis=1)

    @property
    def hit(self) -> NDArray[np.bool_]:
        hit: NDArray[np.bool_] = self.values[:, 0] != 0
        return hit

    def channel(self, name: str) -> F32:
        """Return a channel, (n,) or (n, components)."""
        if name not in self.layout.places and name in DERIVED:
            return DERIVED[name](self)
        values = self.values[:, self.layout.places[name]]
        return values[:, 0] if CHANNELS[name].components == 1 else values

    def __len__(self) -> int:
        return len(self.values)


def averaged(
    samples: Samples, pixels: NDArray[np.int32], planes: F32, layout: Layout, passes: NDArray[np.int32] | int
) -> Samples:
    """Return the means of the samples and of the planes at their pixels, which are means of `passes` samples, (n,)."""
    rows, columns = pixels.T
    passes = np.reshape(passes, (-1, 1))
    values = samples.in_layout(layout)
    for name in ("gray", "color", "shadow", "variance"):
        if name in layout.places:
            place = layout.places[name]
            # The variance of a mean of n independent samples is their summed variance over n².
            weights = (passes, 1) if name != "variance" else (passes**2 / (passes + 1), 1 / (passes + 1))
            values[:, place] = (weights[0] * planes[place, rows, columns].T + weights[1] * values[:, place]) / (
                passes + 1
            )
    return Samples.from_values(values, layout)


def scatter(samples: Samples, pixels: NDArray[np.int32], planes: F32, layout: Layout) -> None:
    """Write samples to their pixels, (n, 2) rows and columns, in `planes`, (C, H, W) of a layout.

    The samples must have all channels of the layout.
    """
    values = samples.values if samples.layout == layout else samples.in_layout(layout)
    _core.scatter(layout.core, pixels, values, planes)
