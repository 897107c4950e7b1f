"""Final colour pictures, antialiased, on any background."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isqrt
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import Color, from_srgb, linear, to_srgb
from bobrossnet.completion.complete import GUIDED, complete
from bobrossnet.completion.guided import smoothed
from bobrossnet.completion.network import NetworkLike
from bobrossnet.picture.camera import Camera
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.order import DEFAULT_ORDER, SizeLike, check_size
from bobrossnet.pictures.rendered import Picture
from bobrossnet.support.errors import InputError, check_integer
from bobrossnet.tracing.light import HEADLIGHT, LightLike
from bobrossnet.tracing.lit import lit_tracer
from bobrossnet.tracing.scene import Scene, SceneLike, as_scene
from bobrossnet.tracing.trace import BATCH, SceneTracer, trace, traced_light

BLACK = "#000000"
"""Default background of the page and of sparse pictures."""

Background: TypeAlias = Color | Sequence[Color] | None

MOST_SAMPLES = 64

PATHS_OF_SAMPLE = 4
"""Light paths for each sample; they also antialias edges."""

MOST_ACROSS = 2**31 - 1
"""Maximum number of rays in a row or a column of the picture: the core counts them in int32."""


def render(
    scene: SceneLike,
    camera: Camera | None = None,
    *,
    size: SizeLike = (480, 640),
    samples: int = 4,
    background: Background = None,
    fraction: float = 1.0,
    model: NetworkLike = "default",
    light: LightLike = None,
    ground: bool | None = None,
    progress: Callable[[float], None] | None = None,
) -> Picture:
    """Render a picture with every pixel traced and edges antialiased, or with some traced and the others completed.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these
    camera : Camera, optional
    size : (height, width) or "WIDTHxHEIGHT"
    samples : int, 1..64
        Maximum number of rays in each pixel, on an n x n grid: 1, 4, 9, 16 and so on. Only pixels at edges get more
        than one. With a fraction below 1, each pixel has at most one.
    background : color, two colors, or None
        As a material's color; two are the colours of the top and the bottom row. None leaves it transparent.
    fraction : float in (0, 1]
        Share of the pixels to trace; the others are completed.
    model : str, path or Network
        As in `complete`. Under another light than the headlight, the picture is completed along first hits instead.
    light : "headlight", "studio", Light, Sky, several of them, or path of an environment, optional
        By default the scene's light, otherwise the headlight, which casts no shadows. "studio" is a soft key light
        from the camera's upper left under a gentle sky. Each pixel then takes four light paths for each of `samples`,
        denoised along first hits.
    ground : bool, optional
        Whether to add a plane through the lowest point of the scene, which shows only its shadows. By default as the
        scene has it, otherwise with "studio" alone.
    progress : callable, optional
        Called from time to time with the share of first rays traced, 0..1.

    Returns
    -------
    Picture
        A notebook displays it; `save` writes it.

    Raises
    ------
    InputError
        If an argument is out of range.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> red = bob.Instance(bob.happy_tree(), material=bob.Material("#c33"))
    >>> picture = bob.render(red, size="160x120", background="#fff")
    >>> picture.rgba.shape, picture.rgba[0, 0].tolist()
    ((120, 160, 4), [255, 255, 255, 255])
    """
    scene = as_scene(scene)
    camera = Camera() if camera is None else camera
    check_picture(samples, background, size)
    lit = lit_tracer(scene, camera, size, light, ground, paths=PATHS_OF_SAMPLE * samples)
    if lit is not None:
        gbuffer = traced_light(lit, fraction, DEFAULT_ORDER, 0, progress)
    else:
        gbuffer = trace(scene, camera, size=size, fraction=fraction, light=HEADLIGHT, progress=progress)
    return finished(gbuffer, scene, camera, samples=samples, background=background, model=model)


def check_picture(samples: int, background: Background, size: SizeLike) -> None:
    """Raise InputError unless a picture can be made with these arguments; checked before any time is spent on it."""
    side = isqrt(check_integer("samples", samples, 1, MOST_SAMPLES))
    longest = max(check_size(size))
    if side * longest > MOST_ACROSS:
        raise InputError(
            f"size: expected at most {MOST_ACROSS // side:,} pixels a side with {samples} samples, got {longest:,}"
        )
    background_rows(background, 1)


def finished(
    gbuffer: GBuffer, scene: Scene, camera: Camera, *, samples: int, background: Background, model: NetworkLike
) -> Picture:
    """Make the picture of a traced G-buffer; the arguments are those of `render`."""
    model = GUIDED if "shadow" in gbuffer.layout.places else model
    color = complete(gbuffer, model, channel="color")
    if samples >= 4 and gbuffer.guides is not None and gbuffer.guides.edges is not None:
        return picture_of(*smoothed(gbuffer, color), background)
    alpha = complete(gbuffer, model, channel="alpha")
    if gbuffer.mask.all() and samples >= 4 and gbuffer.guides is None:
        _smooth_edges(scene, camera, color, alpha, isqrt(samples))
    return picture_of(color, alpha, background)


def picture_of(color: NDArray[np.float32], alpha: NDArray[np.float32], background: Background = None) -> Picture:
    """Composite linear light, (H, W, 3), with coverage, (H, W), over a background.

    Every picture, traced or completed, passes through here, so that all look the same.
    """
    behind = background_rows(background, len(alpha))
    if behind is None:
        return Picture(color, alpha)
    return Picture(color + (1 - alpha[..., None]) * behind, np.ones_like(alpha))


def _smooth_edges(
    scene: Scene, camera: Camera, color: NDArray[np.float32], alpha: NDArray[np.float32], side: int
) -> None:
    """Replace pixels at edges by the mean of side x side rays. Where 2 x 2 rays agree, their mean suffices."""
    pixels = _at_edges(color, alpha)
    tracer = SceneTracer(scene, camera, alpha.shape)
    for times in (2, side) if side > 2 else (2,):
        unsettled = [pixels[:0]]
        for start in range(0, len(pixels), BATCH // times**2):
            piece = pixels[start : start + BATCH // times**2]
            rows, columns = piece.T
            means = tracer.means(piece, times)
            color[rows, columns], alpha[rows, columns] = means[:, 1:4], means[:, 4]
            unsettled.append(piece[means[:, 0] > 0])
        pixels = np.concatenate(unsettled)


def _at_edges(color: NDArray[np.float32], alpha: NDArray[np.float32]) -> NDArray[np.int32]:
    """Return the pixels, (n, 2), far from the mean of their two neighbours in any of the four directions."""
    return _core.pixels_at_edges(np.ascontiguousarray(color), np.ascontiguousarray(alpha))


def background_rows(background: Any, height: int) -> NDArray[np.float32] | None:
    """Return the linear RGB of each row, (H, 1, 3), or None for None.

    Two colours are blended in sRGB, which looks even to the eye.
    """
    if background is None:
        return None
    are_two = not isinstance(background, str) and isinstance(background, Sequence) and len(background) == 2
    top, bottom = background if are_two else (background, background)
    ends = to_srgb(np.array([linear("background", top), linear("background", bottom)], np.float32))
    share = np.linspace(0, 1, height, dtype=np.float32)[:, None]
    return np.asarray(from_srgb((1 - share) * ends[0] + share * ends[1]), np.float32)[:, None]
