"""Samples: what a tracer found at some pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import LUMINANCE, luminance
from bobrossnet.picture.channels import CHANNELS, Layout
from bobrossnet.picture.values import DERIVED, F32, Channels, check_range, layout_of, values_shape
from bobrossnet.support.errors import InputError, check_array, shape_of


class Samples(Channels):
    """What a tracer found at n pixels.

    Parameters
    ----------
    gray : (n,) numbers of at least 0, optional
        By default the luminance of `color`. Of any range: traced values come back as they are, and what is completed
        between them goes through `GBuffer.transfer`.
    depth : (n,) numbers, optional
        0..1: 1 at the point of the scene's bounding sphere nearest the camera, 0 at the farthest; between them along
        the line of sight, in perspective by the distance from the camera, which may stand within the sphere. If any
        sample of a picture is outside of that, all are distances from the camera, in any unit. By default 0.5.
    normal : (n, 2) numbers in -1..1, optional
        In screen space, x right and y up. By default 0: towards the camera.
    hit : (n,) bool, optional
        False where the ray hit nothing; depth, normal and albedo are ignored there, while gray and color are what is
        seen behind everything: NaN and infinity are black. By default true.
    color : (n, 3) numbers of at least 0, optional
        Linear RGB of what is seen, in the range of gray.
    albedo : (n, 3) numbers in 0..1, optional
        Linear RGB of the surface itself, white by default.
    variance : (n,) or (n, 3) numbers of at least 0, optional
        Of the mean that gray or each component of color is, where that was drawn at random; what is traced of a pixel
        later on is averaged with it. By default 0: exact.

    Raises
    ------
    InputError
        If the lengths differ, or a value is not finite or out of range where `hit` is true.
    """

    __slots__ = ("given", "layout", "values")

    given: frozenset[str]
    """Which of the parameters, but for `hit`, they were made of."""
    layout: Layout
    """The channels that they have."""
    values: F32
    """All of them, (n, C) in the layout's order, whether the ray hit in the place of the mask."""

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
            with np.errstate(over="ignore"):  # what is too large for float32 is said to be infinite
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
            # Components are drawn together, as those of a path's light: the largest that it can be.
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
        """Samples that take over values of a layout, unchecked and without a copy."""
        samples = object.__new__(cls)
        samples.layout, samples.values = layout, values
        samples.given = frozenset(layout.places) - {"mask"}
        return samples

    def in_layout(self, layout: Layout) -> F32:
        """A copy of the values, (n, C) of another layout whose channels they have."""
        columns = [self.values[:, :1] if name == "mask" else self.channel(name) for name in layout.places]
        return np.concatenate([column.reshape(len(self), -1) for column in columns], axis=1)

    @property
    def hit(self) -> NDArray[np.bool_]:
        hit: NDArray[np.bool_] = self.values[:, 0] != 0
        return hit

    def channel(self, name: str) -> F32:
        """A channel by its name: (n,), or (n, components) where it has several."""
        if name not in self.layout.places and name in DERIVED:
            return DERIVED[name](self)
        values = self.values[:, self.layout.places[name]]
        return values[:, 0] if CHANNELS[name].components == 1 else values

    def __len__(self) -> int:
        return len(self.values)


def scatter(samples: Samples, pixels: NDArray[np.int32], planes: F32, layout: Layout) -> None:
    """Write samples to their pixels, (n, 2) rows and columns, in `planes`, (C, H, W) of a layout whose channels the
    samples have."""
    values = samples.values if samples.layout == layout else samples.in_layout(layout)
    _core.scatter(layout.core, pixels, values, planes)
