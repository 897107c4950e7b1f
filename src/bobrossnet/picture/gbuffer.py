"""The G-buffer: what is known of the first visible surface at the traced pixels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import LUMINANCE, luminance
from bobrossnet.errors import InputError, InputTypeError, check_array, check_finite
from bobrossnet.picture.channels import CHANNELS, COLORED, GIVEN, GUIDES, Layout
from bobrossnet.picture.order import Size, check_size, pixel_count
from bobrossnet.picture.sequence import PixelSequence
from bobrossnet.picture.transfer import Transfer, transfer_of

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


class GBuffer(Channels):
    """A picture of which some pixels were traced. Immutable; all arrays are float32 and read-only.

    Parameters
    ----------
    mask : (H, W) float32
        1 where a ray was traced, else 0.
    gray : (H, W) float32 of at least 0, optional
        By default the luminance of `color`. Display-referred in 0..1, or of any range: see `transfer`.
    depth : (H, W) float32, optional
        0..1: 1 at the point of the scene's bounding sphere nearest the camera, 0 at the farthest; between them along
        the line of sight, in perspective by the distance from the camera, which may stand within the sphere. If any
        value is outside of that, distances from the camera in any unit. By default 0.5 where traced.
    normal : (H, W, 2) float32 in -1..1, optional
        In screen space, x right and y up; of unit length together with a z >= 0 towards the camera. In perspective
        relative to each pixel's own ray, which z points back along. By default 0: towards the camera.
    color : (H, W, 3) float32 of at least 0, optional
        Linear RGB of the picture, in the range of gray.
    albedo : (H, W, 3) float32 in 0..1, optional
        Linear RGB of the surface itself, white by default.
    variance : (H, W) float32 of at least 0, optional
        Of the gray, where it was drawn at random: the variance of its mean. By default 0.
    guides : Guides, optional
        What is known of all pixels, also where the mask is 0: completion then follows them.

    Values where the mask is 0 are discarded: all arrays but the guides are 0 there. Where a ray missed, the mask is 1
    and depth, normal and albedo are 0: known background, which is black, or shines in gray or color.

    Raises
    ------
    InputTypeError
        If an array is not float32.
    InputError
        If a shape differs from the mask's, or a value is not finite or out of range.
    """

    __slots__ = ("guides", "is_display_referred", "layout", "planes")

    layout: Layout
    """The channels that it holds."""
    planes: F32
    """All of them, (C, H, W) in the layout's order."""
    guides: Guides | None
    is_display_referred: bool
    """Whether gray, colour and depth are known to be in 0..1, as of the core's tracer; else they are looked at."""

    def __init__(
        self,
        *,
        mask: Any,
        gray: Any = None,
        depth: Any = None,
        normal: Any = None,
        color: Any = None,
        albedo: Any = None,
        variance: Any = None,
        guides: Guides | None = None,
    ) -> None:
        mask = check_float32("mask", mask, (None, None))
        size = check_size(mask.shape)
        if not np.isin(mask, (0, 1)).all():
            raise InputError("mask: expected only 0 and 1, got other values")
        if guides is not None:
            guides = check_guides(guides, size)
        layout = layout_of(color is not None or albedo is not None, variance is not None)
        planes = np.empty((layout.width, *size), np.float32)
        planes[0] = mask
        traced = mask > 0

        def put(name: str, values: Any) -> F32:
            shape = _values_shape(name, *size)
            hint = {1: "", 2: "x and y last, to match mask", 3: "red, green and blue last, to match mask"}
            array = check_float32(name, values, shape, hint=hint[CHANNELS[name].components])
            check_range(name, array)
            planes[layout.places[name]] = np.where(traced, np.moveaxis(array.reshape(*size, -1), -1, 0), 0)
            return array

        if gray is None and color is None:
            raise InputError("gray: expected gray or color, got neither")
        put("depth", np.full(size, 0.5, np.float32) if depth is None else depth)
        put("normal", np.zeros((*size, 2), np.float32) if normal is None else normal)
        if variance is not None:
            put("variance", variance)
        if color is not None:
            color = put("color", color)
        gray = put("gray", luminance(color) if gray is None else gray)
        if "color" in layout.places:
            if color is None:
                put("color", np.repeat(gray[..., None], 3, -1))
            surface = (planes[layout.places["depth"]][0] != 0).astype(np.float32)
            put("albedo", np.repeat(surface[..., None], 3, -1) if albedo is None else albedo)
        self._own(planes, layout, guides, False)

    @classmethod
    def from_stack(
        cls, planes: F32, layout: Layout = GIVEN, guides: Guides | None = None, is_display_referred: bool = True
    ) -> GBuffer:
        """A G-buffer that takes over planes of a layout, by default as `stack` returns them, unchecked and without a
        copy."""
        gbuffer = object.__new__(cls)
        gbuffer._own(planes, layout, guides, is_display_referred)
        return gbuffer

    def _own(self, planes: F32, layout: Layout, guides: Guides | None, is_display_referred: bool) -> None:
        planes.flags.writeable = False
        object.__setattr__(self, "planes", planes)
        object.__setattr__(self, "layout", layout)
        object.__setattr__(self, "guides", guides)
        object.__setattr__(self, "is_display_referred", is_display_referred)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a GBuffer can't be changed ({name})")

    @property
    def mask(self) -> F32:
        return self.channel("mask")

    @property
    def channels(self) -> tuple[str, ...]:
        """The names of all channels, in the order of their planes."""
        return tuple(self.layout.places)

    def channel(self, name: str) -> F32:
        """A channel by its name: (H, W), or (H, W, components) where it has several. KeyError if there is none."""
        if name not in self.layout.places and name in DERIVED:
            return DERIVED[name](self)
        planes = self.planes[self.layout.places[name]]
        return planes[0] if CHANNELS[name].components == 1 else np.moveaxis(planes, 0, -1)

    @property
    def transfer(self) -> Transfer | None:
        """How gray, colour and depth of any range become those that networks know; None where they are in 0..1."""
        return None if self.is_display_referred else transfer_of(self.planes, self.layout)

    @property
    def size(self) -> Size:
        """(height, width)"""
        return self.planes.shape[1], self.planes.shape[2]

    @property
    def fraction(self) -> float:
        """Share of the pixels that were traced."""
        return int(np.count_nonzero(self.mask)) / self.mask.size

    def stack(self) -> F32:
        """Five planes, (5, H, W): mask, gray, depth, normal x, normal y. Read-only."""
        if self.layout == GIVEN:
            return self.planes
        planes = np.concatenate([self.planes[self.layout.places[name]] for name in GIVEN.places])
        planes.flags.writeable = False
        return planes

    def sample(self, fraction: float, *, order: str = "default", seed: int = 0) -> GBuffer:
        """Keep the first pixels of an order, as if only they had been traced.

        For a full G-buffer this equals `trace` with the same fraction, order and seed. In a partial one, pixels of the
        order that were not traced stay untraced.

        Parameters
        ----------
        fraction : float in (0, 1]
        order, seed
            As in `trace`.
        """
        sequence, count = PixelSequence(self.size, order, seed), pixel_count(fraction, self.size)
        planes = np.zeros_like(self.planes)
        while sequence.done < count:
            rows, columns = sequence.next(count - sequence.done, planes, self.layout).T
            planes[:, rows, columns] = self.planes[:, rows, columns]
        return GBuffer.from_stack(planes, self.layout, self.guides, self.is_display_referred)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, GBuffer):
            return False
        same = self.layout == other.layout and np.array_equal(self.planes, other.planes)
        return same and self.guides == other.guides

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"GBuffer({self.size[0]} x {self.size[1]}, {100 * self.fraction:.4g} % traced)"

    def __reduce__(self) -> tuple[Any, ...]:
        return GBuffer.from_stack, (np.array(self.planes), self.layout, self.guides, self.is_display_referred)


class Guides(Channels):
    """What is known of the first visible surface at all pixels, traced or not: cheap first hits, while light is not.

    Completion follows them: between two traced pixels it goes along surfaces, and what lies across an edge has no say.

    Parameters
    ----------
    depth : (H, W) numbers, optional
        As in `Samples`: 0..1, or distances from the camera in any unit.
    normal : (H, W, 2) or (H, W, 3) numbers in -1..1, optional
        In screen space, x right and y up, perhaps with z.
    albedo : (H, W, 3) numbers in 0..1, optional
        Linear RGB of the surfaces, by which light is divided before it is completed; 1 where there is nothing to divide
        by, as of mirrors and lamps.
    hit : (H, W) numbers in 0..1, optional
        How much of each pixel a surface covers. By default all where the depth is not 0.

    All may be means over a pixel, and are better so. At least one is needed. Where nothing was hit, the others do not
    matter.

    Raises
    ------
    InputError
        If the shapes differ, or a value is not finite or out of range.
    """

    __slots__ = ("layout", "planes")

    layout: Layout
    """mask, which says where surfaces are, depth, normal and albedo."""
    planes: F32
    """All of them, (C, H, W) in the layout's order."""

    def __init__(self, depth: Any = None, normal: Any = None, albedo: Any = None, hit: Any = None) -> None:
        given = {"depth": depth, "normal": normal, "albedo": albedo, "hit": hit}
        first = next((name for name, value in given.items() if value is not None), None)
        if first is None:
            raise InputError("guides: expected depth, normal, albedo or hit, got none of them")
        dimensions = 2 if first in ("depth", "hit") else 3
        array = check_array(first, given[first], (None,) * dimensions)
        size = check_size(array.shape[:2])
        self.layout = GUIDES
        if hit is None:
            hit = np.ones(size) if depth is None else np.isfinite(array) & (array != 0)
        empty = check_array("hit", hit, size, hint=f"to match {first}") == 0
        self.planes = np.zeros((self.layout.width, *size), np.float32)

        def put(name: str, value: Any, channel: str) -> None:
            shape = _values_shape(channel, *size)
            if name == "normal" and np.shape(value)[2:] == (3,):
                check_array(name, value, (*size, 3), hint=f"to match {first}")
                value = np.asarray(value)[..., :2]
            array = check_array(name, value, shape, hint=f"to match {first}").reshape(*size, -1)
            array = np.where(empty[..., None], 1 if name == "albedo" else 0, array).astype(np.float32)
            check_range(channel, array, name)
            self.planes[self.layout.places[channel]] = np.moveaxis(array, -1, 0)

        put("hit", hit, "mask")
        put("depth", np.full(size, 0.5) if depth is None else depth, "depth")
        put("normal", np.zeros((*size, 2)) if normal is None else normal, "normal")
        put("albedo", np.ones((*size, 3)) if albedo is None else albedo, "albedo")
        self.planes.flags.writeable = False

    @property
    def hit(self) -> F32:
        """(H, W): how much of each pixel a surface covers."""
        return self.channel("mask")

    @property
    def size(self) -> Size:
        """(height, width)"""
        return self.planes.shape[1], self.planes.shape[2]

    def channel(self, name: str) -> F32:
        """A channel by its name: (H, W), or (H, W, components) where it has several. KeyError if there is none."""
        planes = self.planes[self.layout.places[name]]
        return planes[0] if CHANNELS[name].components == 1 else np.moveaxis(planes, 0, -1)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Guides) and np.array_equal(self.planes, other.planes)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Guides({self.size[0]} x {self.size[1]})"


def check_guides(guides: Any, size: Size) -> Guides:
    """Return what a user's tracer or a user gave as guides, if they are of a picture of this size."""
    if isinstance(guides, dict):
        unknown = sorted(set(guides) - {"depth", "normal", "albedo", "hit"})
        if unknown:
            raise InputError(f"guides: expected depth, normal, albedo and hit, got {', '.join(map(str, unknown))}")
        guides = Guides(**guides)
    if not isinstance(guides, Guides):
        raise InputTypeError(f"guides: expected bobrossnet.Guides or a dict of arrays, got {type(guides).__name__}")
    if guides.size != size:
        raise InputError(f"guides: expected the picture's size {size}, got {guides.size}")
    return guides


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

    __slots__ = ("layout", "values")

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
            array = check_array(name, value, _values_shape(name, n), hint=hint).reshape(n, -1)
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

        if variance is not None and np.ndim(variance) == 2:
            variance = check_array("variance", variance, (n, 3), hint=f"one or three for each of {first}")
            check_range("variance", variance)
            # Components are drawn together, as those of a path's light: the largest that it can be.
            variance = np.square(np.sqrt(np.maximum(variance, 0)) @ LUMINANCE)
        for name, value, default in (
            ("color", color, None),
            ("gray", gray, None),
            ("depth", depth, 0.5),
            ("normal", normal, 0),
            ("albedo", albedo, 1),
            ("variance", variance, None),
        ):
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


def untraced_planes(size: Size, layout: Layout) -> F32:
    """Zeros, (C, H, W), for `scatter` to fill.

    For pictures of gigabytes the system takes seconds to provide the memory, page by page as it is first touched. That
    happens here, piece by piece, where Ctrl-C is noticed, rather than all at once at the first random pixels.
    """
    planes = np.empty((layout.width, *size), np.float32)
    flat = planes.reshape(-1)
    piece = 2**22
    for start in range(0, flat.size, piece):
        flat[start : start + piece] = 0
    return planes


def scatter(samples: Samples, pixels: NDArray[np.int32], planes: F32, layout: Layout) -> None:
    """Write samples to their pixels, (n, 2) rows and columns, in `planes`, (C, H, W) of a layout whose channels the
    samples have."""
    values = samples.values if samples.layout == layout else samples.in_layout(layout)
    _core.scatter(layout.core, pixels, values, planes)


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


def _values_shape(name: str, *shape: int) -> tuple[int, ...]:
    """The shape of a channel's values for users: components last where there are several."""
    components = CHANNELS[name].components
    return shape if components == 1 else (*shape, components)
