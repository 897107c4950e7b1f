"""The G-buffer: AOVs of the first visible surface at the traced pixels."""

from __future__ import annotations

from typing import Any

import numpy as np

from bobrossnet.color import luminance
from bobrossnet.picture.channels import CHANNELS, GIVEN, Layout
from bobrossnet.picture.guides import Guides, check_guides
from bobrossnet.picture.order import Size, check_order, check_size, pixel_count
from bobrossnet.picture.sequence import PixelSequence
from bobrossnet.picture.transfer import Transfer, transfer_of
from bobrossnet.picture.values import (
    DERIVED,
    F32,
    Channels,
    check_float32,
    check_range,
    layout_of,
    of_planes,
    values_shape,
)
from bobrossnet.support.errors import InputError


class GBuffer(Channels):
    """A partly traced picture. Immutable; all arrays are float32 and read-only.

    Parameters
    ----------
    mask : (H, W) float32
        1 where a ray was traced, else 0.
    gray : (H, W) float32 of at least 0, optional
        By default the luminance of `color`. Display-referred in 0..1, or of any range: see `transfer`.
    depth : (H, W) float32, optional
        In 0..1: 1 at the point of the scene's bounding sphere nearest the camera, 0 at the farthest, linear along the
        line of sight; in perspective linear in the distance from the camera, which may stand within the sphere. If any
        value exceeds this range, all are distances from the camera in any unit. By default 0.5 where traced.
    normal : (H, W, 2) float32 in -1..1, optional
        In screen space, x right and y up; unit length together with z >= 0 towards the camera. In perspective,
        relative to each pixel's ray: z points back along it. By default 0, towards the camera.
    color : (H, W, 3) float32 of at least 0, optional
        Linear RGB of the picture, in the range of gray.
    albedo : (H, W, 3) float32 in 0..1, optional
        Linear RGB of the surface, white by default.
    variance : (H, W) float32 of at least 0, optional
        Variance of the mean of a noisy gray, for path-traced pixels. By default 0.
    guides : Guides, optional
        Channels known at all pixels, also where the mask is 0; completion then follows them.

    Values where the mask is 0 are discarded: there all arrays except the guides are 0. Where a ray missed, the mask is
    1 and depth, normal and albedo are 0: known background, black unless gray or color is above 0.

    Raises
    ------
    InputTypeError
        If an array is not float32.
    InputError
        If a shape differs from the mask's, or a value is not finite or out of range.
    """

    __slots__ = ("guides", "is_display_referred", "layout", "planes")

    layout: Layout
    """The channels of the planes."""
    planes: F32
    """All planes, (C, H, W) in the layout's order."""
    guides: Guides | None
    is_display_referred: bool
    """Whether gray, colour and depth are known to be in 0..1, as from the core's tracer; otherwise they are checked."""

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
            shape = values_shape(name, *size)
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
        """Make a G-buffer from planes of a layout, by default the layout of `stack`, without checks or a copy."""
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
        """Names of all channels, in the order of their planes."""
        return tuple(self.layout.places)

    def channel(self, name: str) -> F32:
        """Return a channel, (H, W) or (H, W, components). KeyError if the G-buffer lacks it."""
        if name not in self.layout.places and name in DERIVED:
            return DERIVED[name](self)
        return of_planes(self.planes, self.layout, name)

    @property
    def transfer(self) -> Transfer | None:
        """The mapping of gray, colour and depth to the networks' range; None if they are in 0..1."""
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
        """Keep the first pixels of an order, as if only these had been traced.

        For a full G-buffer this equals `trace` with the same fraction, order and seed. In a partial one, untraced
        pixels of the order stay untraced.

        Parameters
        ----------
        fraction : float in (0, 1]
        order, seed
            As in `trace`.
        """
        order, count = check_order(order, seed), pixel_count(fraction, self.size)
        sequence = PixelSequence(self.size, order, seed)
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


def untraced_planes(size: Size, layout: Layout) -> F32:
    """Allocate zeros, (C, H, W), for `scatter` to fill.

    For pictures of gigabytes the system takes seconds to provide the memory, page by page at first touch. That happens
    here in steps, where Ctrl-C is noticed, not all at once at the first random pixels.
    """
    planes = np.empty((layout.width, *size), np.float32)
    flat = planes.reshape(-1)
    piece = 2**22
    for start in range(0, flat.size, piece):
        flat[start : start + piece] = 0
    return planes
