"""Guides: what is known of the first surface at all pixels."""

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

    __slots__ = ("behind", "edges", "ground", "layout", "planes")

    behind: F32 | None
    """(H, W), 1 where they are of the first surface behind smooth mirrors and glass; depth is then as far as it seems.
    None of guides that users give."""
    edges: Edges | None
    """What is known within pixels at edges, where the others are of pixels' centres."""

    ground: Guides | None
    """Of the ground that shows the surfaces' shadows; its mask is the share of a pixel that shows it."""
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
        """Guides that take over planes as `planes` has them, unchecked and without a copy."""
        guides = object.__new__(cls)
        guides.layout, guides.planes, guides.ground, guides.edges = GUIDES, planes, ground, edges
        guides.behind = behind
        planes.flags.writeable = False
        return guides

    def __reduce__(self) -> tuple[Any, ...]:
        return Guides.from_planes, (np.array(self.planes), self.ground, self.edges, self.behind)

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
        return of_planes(self.planes, self.layout, name)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Guides) and np.array_equal(self.planes, other.planes) and self.ground == other.ground

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
