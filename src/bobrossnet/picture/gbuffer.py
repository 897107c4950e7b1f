"""The G-buffer: what is known of the first visible surface at the traced pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.errors import InputError, InputTypeError, check_array, check_finite
from bobrossnet.picture.order import Size, check_size, pixel_count, pixel_order

F32 = NDArray[np.float32]


class GBuffer:
    """A picture of which some pixels were traced. Immutable; all arrays are float32 and read-only.

    Parameters
    ----------
    mask : (H, W) float32
        1 where a ray was traced, else 0.
    gray : (H, W) float32 in 0..1
    depth : (H, W) float32 in 0..1
        1 at the point of the scene's bounding sphere nearest the camera, 0 at the farthest.
    normal : (H, W, 2) float32 in -1..1
        In screen space, x right and y up; of unit length together with a z >= 0 towards the camera.

    What is given where the mask is 0 is dropped: there all arrays are 0. Where a ray missed, the mask is 1 and the
    others are 0 (background, known to be so).

    Raises
    ------
    InputTypeError
        If an array is not float32.
    InputError
        If a shape differs from the mask's, or a value is not finite or out of range.
    """

    __slots__ = ("_planes",)

    _planes: F32  # (5, H, W)

    def __init__(self, *, mask: Any, gray: Any, depth: Any, normal: Any) -> None:
        mask = check_float32("mask", mask, (None, None))
        size = check_size(mask.shape)
        if not np.isin(mask, (0, 1)).all():
            raise InputError("mask: expected only 0 and 1, got other values")
        gray = check_range("gray", check_float32("gray", gray, size), 0)
        depth = check_range("depth", check_float32("depth", depth, size), 0)
        hint = "x and y last, to match mask"
        normal = check_range("normal", check_float32("normal", normal, (*size, 2), hint=hint), -1)
        planes = np.empty((5, *size), np.float32)
        planes[0] = mask
        traced = mask > 0
        for plane, values in zip(planes[1:], (gray, depth, normal[..., 0], normal[..., 1]), strict=True):
            plane[...] = np.where(traced, values, 0)
        self._own(planes)

    @classmethod
    def from_stack(cls, planes: F32) -> GBuffer:
        """A G-buffer that takes over `planes`, (5, H, W) as `stack` returns them, unchecked and without a copy."""
        gbuffer = object.__new__(cls)
        gbuffer._own(planes)
        return gbuffer

    def _own(self, planes: F32) -> None:
        planes.flags.writeable = False
        object.__setattr__(self, "_planes", planes)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a GBuffer can't be changed ({name})")

    @property
    def mask(self) -> F32:
        return self._planes[0, :, :]

    @property
    def gray(self) -> F32:
        return self._planes[1, :, :]

    @property
    def depth(self) -> F32:
        return self._planes[2, :, :]

    @property
    def normal(self) -> F32:
        return np.moveaxis(self._planes[3:], 0, -1)

    @property
    def size(self) -> Size:
        """(height, width)"""
        return self._planes.shape[1], self._planes.shape[2]

    @property
    def fraction(self) -> float:
        """Share of the pixels that were traced."""
        return int(np.count_nonzero(self.mask)) / self.mask.size

    def stack(self) -> F32:
        """The input of the networks, (5, H, W): mask, gray, depth, normal x, normal y. Read-only."""
        return self._planes

    def sample(self, fraction: float, *, order: str = "default", seed: int = 0) -> GBuffer:
        """Keep the first pixels of an order, as if only they had been traced.

        Of a full G-buffer this equals `trace` with the same fraction, order and seed. Of a partial one, pixels of the
        order that were not traced stay so.

        Parameters
        ----------
        fraction : float in (0, 1]
        order, seed
            As in `pixel_order`.
        """
        rows, columns = pixel_order(self.size, order=order, seed=seed, count=pixel_count(fraction, self.size)).T
        planes = np.zeros_like(self._planes)
        planes[:, rows, columns] = self._planes[:, rows, columns]
        return GBuffer.from_stack(planes)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, GBuffer) and np.array_equal(self._planes, other._planes)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"GBuffer({self.size[0]} x {self.size[1]}, {100 * self.fraction:.4g} % traced)"

    def __reduce__(self) -> tuple[Any, ...]:
        return GBuffer.from_stack, (np.array(self._planes),)


class Samples:
    """What a tracer found at n pixels.

    Parameters
    ----------
    gray : (n,) numbers in 0..1
    depth : (n,) numbers in 0..1
        1 at the point of the scene's bounding sphere nearest the camera, 0 at the farthest.
    normal : (n, 2) numbers in -1..1
        In screen space, x right and y up.
    hit : (n,) bool
        False where the ray met nothing; what the other arrays hold there does not matter.

    Raises
    ------
    InputError
        If the lengths differ, or a value is not finite or out of range where `hit` is true.
    """

    __slots__ = ("depth", "gray", "hit", "normal")

    gray: F32
    depth: F32
    normal: F32
    hit: NDArray[np.bool_]

    def __init__(self, gray: Any, depth: Any, normal: Any, hit: Any) -> None:
        hits = check_array("hit", hit, (None,))
        if not np.isin(hits, (0, 1)).all():
            raise InputError(f"hit: expected booleans, got other values of dtype {hits.dtype}")
        self.hit = np.ascontiguousarray(hits, dtype=np.bool_)
        n = len(self.hit)
        self.gray = self._values("gray", gray, (n,), 0)
        self.depth = self._values("depth", depth, (n,), 0)
        self.normal = self._values("normal", normal, (n, 2), -1)

    def _values(self, name: str, value: Any, shape: tuple[int, ...], low: float) -> F32:
        array = check_array(name, value, shape, hint="one for each of hit")
        check_range(name, array[self.hit], low)
        return np.ascontiguousarray(array, dtype=np.float32)

    def __len__(self) -> int:
        return len(self.hit)


def untraced_planes(size: Size) -> F32:
    """Zeros, (5, H, W), for `scatter` to fill.

    In pictures of gigabytes the system takes seconds to hand out the memory, which it does when a page is first
    touched: here, piece by piece, where Ctrl-C is heard, and not all at once under the first random pixels.
    """
    planes = np.empty((5, *size), np.float32)
    flat = planes.reshape(-1)
    piece = 2**22
    for start in range(0, flat.size, piece):
        flat[start : start + piece] = 0
    return planes


def scatter(samples: Samples, pixels: NDArray[np.int32], planes: F32) -> None:
    """Write samples to their pixels, (n, 2) rows and columns, in `planes`, (5, H, W) as `GBuffer.stack` has them."""
    _core.scatter(pixels, samples.gray, samples.depth, samples.normal, samples.hit, planes)


def check_float32(name: str, value: Any, shape: tuple[int | None, ...], *, hint: str = "") -> F32:
    """Return `value` as a float32 array of `shape`; other dtypes are refused, not converted."""
    array = check_array(name, value, shape, hint=hint)
    if array.dtype != np.float32:
        raise InputTypeError(f"{name}: expected float32, got {array.dtype}; convert with .astype(np.float32)")
    return array


def check_range(name: str, array: NDArray[Any], low: float) -> NDArray[Any]:
    """Return `array` if its values are finite and in low..1, but for rounding."""
    check_finite(name, array)
    slack = 1e-3
    if array.size and not (array.min() >= low - slack and array.max() <= 1 + slack):
        raise InputError(f"{name}: expected values in {low:g}..1, got {array.min():g}..{array.max():g}")
    return array
