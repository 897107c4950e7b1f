"""Tracing of pixels to a G-buffer."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.picture.camera import CameraLike, as_camera, check_camera
from bobrossnet.picture.channels import COLORED, TRACED, Layout
from bobrossnet.picture.gbuffer import GBuffer, untraced_planes
from bobrossnet.picture.guides import Guides
from bobrossnet.picture.light_shown import shown_to_orders
from bobrossnet.picture.order import Size, SizeLike, check_order, check_pixels, check_size, pixel_count
from bobrossnet.picture.samples import Samples, scatter
from bobrossnet.picture.sequence import PixelSequence
from bobrossnet.support.errors import InputError, InputTypeError, check_callable, check_flag
from bobrossnet.tracing.light import LightLike
from bobrossnet.tracing.lit import LIT, LitTracer, lit_tracer
from bobrossnet.tracing.scene import SceneLike, as_scene
from bobrossnet.tracing.section import SectionLike

Tracer: TypeAlias = Callable[[NDArray[np.int32]], Samples]
"""Maps pixels, (n, 2) int32 rows and columns, to the samples of one ray through each pixel's centre."""

BATCH = 2**17
"""Pixels of one call of the tracer: a few hundredths of a second, and a few MB."""

LIT_BATCH = 2**12
"""Pixels of one call of the light tracer."""


class SceneTracer:
    """The core's ray tracer as a `Tracer`, for a scene, a camera and an image size.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these
    camera : Camera
    size : (height, width) or "WIDTHxHEIGHT"
    layout : Layout, optional
        Channels of the samples; by default with colours if the scene has any.
    """

    def __init__(self, scene: SceneLike, camera: CameraLike, size: SizeLike, layout: Layout | None = None) -> None:
        camera = check_camera(camera)
        if layout is not None and not isinstance(layout, Layout):
            raise InputTypeError(f"layout: expected a Layout, got {type(layout).__name__}")
        self.size = check_size(size)
        self.camera = camera
        self.scene = as_scene(scene)
        self.layout = layout or (COLORED if self.scene.is_colored else TRACED)
        self.camera_in_core = camera.core(self.scene.center, self.scene.radius)
        self._core = self.scene.core

    def __reduce__(self) -> tuple[Any, ...]:
        return SceneTracer, (self.scene, self.camera, self.size, self.layout)  # the core's objects can't be copied

    def __call__(self, pixels: NDArray[np.int32]) -> Samples:
        """Trace one ray through the centre of each pixel.

        Parameters
        ----------
        pixels : (n, 2) integers, row and column, inside the picture

        Raises
        ------
        InputError
            If the pixels have another type, shape or range.
        """
        pixels = check_pixels(pixels)
        values = np.empty((len(pixels), self.layout.width), np.float32)
        try:
            self._core.trace(self.camera_in_core, *self.size, pixels, self.layout.core, values)
        except ValueError as error:
            raise InputError(str(error)) from None
        return Samples.from_values(values, self.layout)

    def means(self, pixels: NDArray[np.int32], side: int) -> NDArray[np.float32]:
        """Return means over side x side rays in each pixel, (n, 5): linear RGB and coverage after 1 or 0.

        The first is 1 where the rays differ enough to need more.
        """
        return self._core.trace_means(self.camera_in_core, *self.size, check_pixels(pixels), side)

    def picture(self, order: str, seed: int = 0, layout: Layout | None = None) -> _core.PictureTracing:
        """Return the core's loop over the pixels of an order."""
        return _core.PictureTracing(
            self._core, self.camera_in_core, *self.size, (layout or self.layout).core, order, seed
        )

    def guides(self) -> Guides:
        """Return the first hits at all pixels, unlit, as `Guides`."""
        layout = Layout("mask,depth,normal,albedo,alpha")
        planes = untraced_planes(self.size, layout)
        self.picture("tiles", layout=layout).trace(planes[0].size, planes)
        _, depth, x, y, *albedo, hit = planes
        return Guides(depth, np.stack([x, y], -1), np.stack(albedo, -1), hit)


def trace(
    scene: SceneLike,
    camera: CameraLike | None = None,
    *,
    size: SizeLike = (480, 640),
    fraction: float = 1.0,
    order: str = "default",
    seed: int = 0,
    guides: bool = False,
    light: LightLike = None,
    ground: bool | None = None,
    section: SectionLike = None,
    progress: Callable[[float], None] | None = None,
) -> GBuffer:
    """Trace a share of an image's pixels, one ray through the centre of each.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these
    camera : Camera, optional
    size : (height, width) or "WIDTHxHEIGHT"
        (480, 640) and "640x480" are the same.
    fraction : float in (0, 1]
        Share of the pixels; 1 traces them all.
    order : "uniform", "lattice", "adaptive", "squares", "priority" or "default"
        Order of the pixels. Three orders refine silhouettes and creases. "adaptive" chooses pixel by pixel, in rounds:
        8 up to 5 % of the pixels, 16 up to 25 %. "priority" starts with every 16th pixel of every 16th row and
        subdivides squares of unequal pixels, by decreasing difference times area: less detail for the same number of
        pixels, but sooner. "squares" starts with every 8th and subdivides the most different squares. The other orders
        take the first pixels of `pixel_order(size, order=order, seed=seed)`. "default" is "priority" from 512x512
        pixels on, and "adaptive" for smaller pictures and with light paths.
    seed : int, 0..2**64 - 1
    guides : bool
        Also find the first surface at all pixels, for `complete` to follow. It pays where shading takes longer than
        rays, unlike the core's materials.
    light, ground
        As in `render`. Except under the headlight, a pixel's color is the mean of 16 light paths, gray its luminance,
        both unbounded, with a variance; the G-buffer has guides and, with a ground, its `shadow`.
    section : Section, text such as "x=0", or up to six of them, optional
        As in `Scene`; by default the scene's.
    progress : callable, optional
        Called from time to time with the share of the work done, 0..1.

    Returns
    -------
    GBuffer
        Depends on the arguments alone, not on the number of threads.

    Raises
    ------
    InputError
        If an argument is out of range.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> part = bob.trace(bob.happy_tree(), bob.Camera(azimuth=30), size=(120, 160), fraction=0.05)
    >>> int(part.mask.sum())
    960
    """
    scene = as_scene(scene)
    camera = as_camera(camera, scene)
    named = check_order(order, seed)
    check_callable("progress", progress)
    guides = check_flag("guides", guides)
    size = check_size(size)
    count = pixel_count(fraction, size)
    scene = as_scene(scene, section)
    lit = lit_tracer(scene, camera, size, light, ground, seed=seed)
    if lit is not None:
        return traced_light(lit, fraction, named, seed, progress)
    tracer = SceneTracer(scene, camera, size)
    planes = untraced_planes(tracer.size, tracer.layout)
    if count == planes[0].size:
        named = "tiles"  # successive rays visit the same parts of a BVH
    elif order == "default":
        named = order  # the core's
    picture = tracer.picture(named, seed)
    while picture.done < count:
        picture.trace(count if progress is None else min(picture.done + BATCH, count), planes)
        if progress is not None:
            progress(picture.done / count)
    return GBuffer.from_stack(planes, tracer.layout, tracer.guides() if guides else None)


def traced_light(
    tracer: LitTracer, fraction: float, order: str, seed: int, progress: Callable[[float], None] | None
) -> GBuffer:
    """Trace a share of the pixels, each once, to a G-buffer with guides at all pixels.

    Background pixels are free: the share counts only pixels where the guides hit a surface or the ground.
    """
    guides, planes = tracer.guides(), untraced_planes(tracer.size, LIT)
    batches = _all_in_rows(tracer.size) if fraction == 1 else _chosen(guides, planes, fraction, order, seed)
    for pixels, share in batches:
        scatter(tracer(pixels), pixels, planes, LIT)
        if progress is not None:
            progress(share)
    return GBuffer.from_stack(planes, LIT, guides, is_display_referred=False)


def _all_in_rows(size: Size) -> Iterator[tuple[NDArray[np.int32], float]]:
    """Yield batches of neighbouring pixels, whose paths share more of the scene, and the share done by then."""
    height, width = size
    pixels = np.arange(height * width, dtype=np.int32)
    for first in range(0, len(pixels), LIT_BATCH):
        batch = pixels[first : first + LIT_BATCH]
        yield np.stack(np.divmod(batch, np.int32(width)), -1), (batch[-1] + 1) / len(pixels)


def _chosen(
    guides: Guides, planes: NDArray[np.float32], fraction: float, order: str, seed: int
) -> Iterator[tuple[NDArray[np.int32], float]]:
    """Yield batches of an order, until a share of the pixels that show something, and the share of these done by then.

    Each batch must be in the planes before the next is asked for.
    """
    size = planes.shape[1], planes.shape[2]
    shows = guides.hit > 0 if guides.ground is None else (guides.hit > 0) | (guides.ground.hit > 0)
    count = max(1, round(fraction * np.count_nonzero(shows)))
    sequence = PixelSequence(size, order, seed, guides)
    done = 0
    while done < count and (wanted := min(LIT_BATCH, count - done, planes[0].size - sequence.done)) > 0:
        shown = GBuffer.from_stack(planes.view(), LIT, guides, is_display_referred=False)
        shown = shown_to_orders(shown) if sequence.looks else shown
        pixels = sequence.next(wanted, shown.planes, shown.layout)
        done += int(np.count_nonzero(shows[pixels[:, 0], pixels[:, 1]]))
        yield pixels, min(1, done / count)


def check_samples(samples: Any, count: int) -> Samples:
    """Return the samples from a user's tracer after checking their number; an array is gray or colour."""
    if isinstance(samples, np.ndarray):
        samples = Samples(samples) if samples.ndim == 1 else Samples(color=samples)
    if not isinstance(samples, Samples):
        raise InputTypeError(f"tracer: expected it to return bobrossnet.Samples, got {type(samples).__name__}")
    if len(samples) != count:
        raise InputError(f"tracer: expected it to return {count} samples, one per pixel, got {len(samples)}")
    return samples
