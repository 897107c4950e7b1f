"""Guides: first surfaces of all pixels."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.channels import GUIDES, Layout
from bobrossnet.picture.order import Size, check_size
from bobrossnet.picture.values import F32, Channels, check_range, of_planes, values_shape
from bobrossnet.support.errors import InputError, InputTypeError, check_array, shape_of


class Edges(NamedTuple):
    """First hits within pixels that show more than one surface."""

    pixels: NDArray[np.int32]
    """(n, 2), rows and columns."""
    hits: F32
    """(n, k, 10) of k rays each: the channels of guides, mask and depth of the ground, and `behind`."""


class Guides(Channels):
    """The first visible surface at each pixel, traced or not: first hits are cheap, light is not.

    Completion follows the surfaces: traced pixels across an edge have no influence.

    Parameters
    ----------
    depth : (H, W) numbers, optional
        As in `Samples`: 0..1, or distances from the camera in any unit.
    normal : (H, W, 2) or (H, W, 3) numbers in -1..1, optional
        In screen space, x right and y up, perhaps with z.
    albedo : (H, W, 3) numbers in 0..1, optional
        Linear RGB of the surfaces. Light is divided by it before completion; use 1 for mirrors and lamps.
    hit : (H, W) numbers in 0..1, optional
        Covered share of each pixel; by default 1 where the depth is not 0.

    At least one is required. Means over each pixel give better edges than values at its centre. Values at misses are
    ignored.

    Raises
    ------
    InputError
        If the shapes differ, or a value is not finite or out of range.
    """

    __slots__ = ("behind", "edges", "ground", "layout", "planes")

    behind: F32 | None
    """(H, W): 1 where they describe the first surface behind smooth mirrors and glass; depth is then that of the
    unfolded path. None for users' guides."""
    edges: Edges | None
    """First hits within pixels at edges; all other values are at pixels' centres."""

    ground: Guides | None
    """The ground that receives shadows; its mask is the visible share of each pixel."""
    layout: Layout
    """mask (coverage by surfaces), depth, normal and albedo."""
    planes: F32
    """(C, H, W) in the layout's order."""

    def __init__(self, depth: Any = None, normal: Any = None, albedo: Any = None, hit: Any = None) -> None:
        given = {"depth": depth, "normal": normal, "albedo": albedo, "hit": hit}
        first = next((name for name, value in given.items() if value is not None), None)
        if first is None:
            raise InputError("guides: expected depth, normal, albedo or hit, got none of them")
        dimensions = 2 if first in ("depth", "hit") else 3
        array = check_array(first, given[first], (None,) * dimensions)
        size = check_size(array.shape[:2])
        self.layout, self.ground, self.edges, self.behind = GUIDES, None, None, None
        if hit is None:
            hit = np.ones(size) if depth is None else np.isfinite(array) & (array != 0)
        empty = check_array("hit", hit, size, hint=f"to match {first}") == 0
        self.planes = np.zeros((self.layout.width, *size), np.float32)

        def put(name: str, value: Any, channel: str) -> None:
            shape = values_shape(channel, *size)
            if name == "normal" and shape_of(value)[2:] == (3,):
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

    @classmethod
    def from_planes(
        cls, planes: F32, ground: Guides | None = None, edges: Edges | None = None, behind: F32 | None = None
    ) -> Guides:
        """Make guides from planes in the layout of `planes`, without checks or a copy."""
        guides = object.__new__(cls)
        guides.layout, guides.planes, guides.ground, guides.edges = GUIDES, planes, ground, edges
        guides.behind = behind
        planes.flags.writeable = False
        return guides

    def __reduce__(self) -> tuple[Any, ...]:
        return Guides.from_planes, (np.array(self.planes), self.ground, self.edges, self.behind)

    @property
    def hit(self) -> F32:
        """(H, W): covered share of each pixel."""
        return self.channel("mask")

    @property
    def size(self) -> Size:
        """(height, width)"""
        return self.planes.shape[1], self.planes.shape[2]

    def channel(self, name: str) -> F32:
        """Return a channel by name, (H, W) or (H, W, components). Raises KeyError for unknown names."""
        return of_planes(self.planes, self.layout, name)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Guides) and np.array_equal(self.planes, other.planes) and self.ground == other.ground

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Guides({self.size[0]} x {self.size[1]})"


def check_guides(guides: Any, size: Size) -> Guides:
    """Return guides given by a user or a user's tracer, if they have this size."""
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
