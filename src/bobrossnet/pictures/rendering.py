"""Final colour pictures, antialiased, on any background."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from math import isqrt

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.adapters.files import load
from bobrossnet.completion.complete import GUIDED, complete
from bobrossnet.completion.guided import noise_shown, smoothed
from bobrossnet.completion.network import NetworkLike
from bobrossnet.picture.camera import Camera, CameraLike, as_camera
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.order import DEFAULT_ORDER, SizeLike, check_size
from bobrossnet.picture.samples import averaged, grid_side, scatter
from bobrossnet.pictures.background import Background, background_rows, picture_of
from bobrossnet.pictures.drawing import Drawing, EdgesLike, check_edges, drawing_of
from bobrossnet.pictures.fitting import fitted, margin_of
from bobrossnet.pictures.rendered import Picture
from bobrossnet.support.errors import InputError, InputWarning
from bobrossnet.support.paths import is_path
from bobrossnet.tracing.light import HEADLIGHT, LightLike, check_light
from bobrossnet.tracing.lit import LitTracer, lit_tracer
from bobrossnet.tracing.scene import Scene, SceneLike, as_scene
from bobrossnet.tracing.section import SectionLike
from bobrossnet.tracing.trace import BATCH, SceneTracer, trace, traced_light

PATHS_OF_SAMPLE = 4
"""Light paths for each sample; they also antialias edges."""

MOST_ACROSS = 2**31 - 1
"""Maximum number of rays in a row or a column of the picture: the core counts them in int32."""

COVERED = 0.75
"""Coverage by lines above which a pixel's edge needs no smoothing: too little of it is visible."""


def render(
    scene: SceneLike,
    camera: CameraLike | None = None,
    *,
    size: SizeLike = (480, 640),
    samples: int = 4,
    background: Background = None,
    fraction: float = 1.0,
    model: NetworkLike = "default",
    light: LightLike = None,
    ground: bool | None = None,
    edges: EdgesLike = False,
    section: SectionLike = None,
    progress: Callable[[float], None] | None = None,
) -> Picture:
    """Render a picture with every pixel traced and edges antialiased, or with some traced and the others completed.

    Parameters
    ----------
    scene : Scene, Shape, Instance, path or iterable of these
    camera : Camera, optional
        By default, the file of a single path is turned upright, as by `load` with up="auto", and fitted to the picture,
        as by `fitted`. Other scenes are seen by `Camera()`, from their front if they have one.
    size : (height, width) or "WIDTHxHEIGHT"
    samples : 1, 4, 9, 16, 25, 36, 49 or 64
        Maximum number of rays in each pixel, on an n x n grid. Only pixels at edges get more than one. With a fraction
        below 1, each pixel has at most one.
    background : colour, two colours, or None
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
    edges : bool or Edges
        Whether to draw lines at edges, as in `draw`, and which.
    section : Section, text such as "x=0", or up to six of them, optional
        As in `Scene`; by default the scene's.
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

    Warns
    -----
    InputWarning
        If sections leave nothing in the picture.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> red = bob.Instance(bob.happy_tree(), material=bob.Material("#c33"))
    >>> picture = bob.render(red, size="160x120", background="#fff")
    >>> picture.rgba.shape, picture.rgba[0, 0].tolist()
    ((120, 160, 4), [255, 255, 255, 255])
    """
    check_picture(samples, background, size)
    light = check_light(light)
    if camera is None and is_path(scene):
        scene = load(scene, up="auto")
        camera = fitted(scene.sectioned(None), size=size, margin=margin_of(scene, light, ground))
    scene = as_scene(scene, section)
    camera = as_camera(camera, scene)
    lines = check_edges(edges)
    gbuffer = traced_to_be_seen(
        scene, camera, size=size, samples=samples, fraction=fraction, light=light, ground=ground, progress=progress
    )
    drawing = None if lines is None else drawing_of(scene, camera, gbuffer.mask.shape, lines)
    return finished(gbuffer, scene, camera, samples=samples, background=background, model=model, drawing=drawing)


def check_picture(samples: int, background: Background, size: SizeLike) -> None:
    """Raise InputError unless a picture can be made with these arguments; checked before any time is spent on it."""
    side = grid_side(samples)
    longest = max(check_size(size))
    if side * longest > MOST_ACROSS:
        raise InputError(
            f"size: expected at most {MOST_ACROSS // side:,} pixels a side with {samples} samples, got {longest:,}"
        )
    background_rows(background, 1)


def traced_to_be_seen(
    scene: Scene,
    camera: Camera,
    *,
    size: SizeLike,
    samples: int,
    fraction: float,
    light: LightLike,
    ground: bool | None,
    order: str = DEFAULT_ORDER,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> GBuffer:
    """Trace as `trace`, but light by `PATHS_OF_SAMPLE` paths for each sample, and as `light_to_be_seen`."""
    lit = lit_tracer(scene, camera, size, light, ground, paths=PATHS_OF_SAMPLE * samples, seed=seed)
    if lit is None:
        return trace(
            scene, camera, size=size, fraction=fraction, order=order, seed=seed, light=HEADLIGHT, progress=progress
        )
    return light_to_be_seen(lit, fraction, order, seed, progress)


def light_to_be_seen(
    tracer: LitTracer,
    fraction: float = 1,
    order: str = DEFAULT_ORDER,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> GBuffer:
    """Trace light as `traced_light`. If all pixels are traced, those that stay noisy after completion are traced again.

    In steep penumbrae, neighbours tell little of a pixel.
    """
    gbuffer = traced_light(tracer, fraction, order, seed, progress)
    if fraction < 1:
        return gbuffer
    pixels = np.argwhere(noise_shown(gbuffer) > _core.VISIBLE_NOISE).astype(np.int32, order="C")
    if len(pixels) == 0:
        return gbuffer
    planes = np.array(gbuffer.planes)
    for passes in range(1, _core.NOISY_PASSES):
        means = averaged(tracer(pixels), pixels, planes, gbuffer.layout, passes)
        scatter(means, pixels, planes, gbuffer.layout)
    return GBuffer.from_stack(planes, gbuffer.layout, gbuffer.guides, gbuffer.is_display_referred)


def finished(
    gbuffer: GBuffer,
    scene: Scene,
    camera: Camera,
    *,
    samples: int,
    background: Background,
    model: NetworkLike,
    drawing: Drawing | None = None,
) -> Picture:
    """Make the picture of a traced G-buffer, with a drawing over it; other arguments as in `render`."""
    model = GUIDED if "shadow" in gbuffer.layout.places else model
    color, alpha = (complete(gbuffer, model, channel=channel) for channel in ("color", "alpha"))
    if scene.section and not alpha.any():
        _warn_of_nothing(scene)
    lines = None if drawing is None else drawing.coverage()
    if samples >= 4 and gbuffer.guides is not None:
        color, alpha = smoothed(gbuffer, color, alpha)
    elif samples >= 4 and gbuffer.mask.all():
        _smooth_edges(scene, camera, color, alpha, isqrt(samples), lines)
    picture = picture_of(color, alpha, background)
    return picture if drawing is None else drawing.over(picture, lines)


def _warn_of_nothing(scene: Scene) -> None:
    """Warn of a picture without a surface, which sections have removed."""
    rounded = np.round(np.array(scene.extent) / scene.radius, 5) * scene.radius + 0.0
    low, high = (", ".join(f"{x:.4g}" for x in corner) for corner in rounded)
    cut = ", ".join(map(str, scene.section))
    text = (
        f"section: expected some of the scene in the picture, got nothing by {cut}; it reaches from ({low}) to ({high})"
    )
    warnings.warn(text, InputWarning, stacklevel=2)


def _smooth_edges(
    scene: Scene,
    camera: Camera,
    color: NDArray[np.float32],
    alpha: NDArray[np.float32],
    side: int,
    lines: NDArray[np.float32] | None,
) -> None:
    """Replace pixels at edges by the mean of side x side rays. Where 2 x 2 rays agree, their mean suffices.

    Pixels that lines cover, given by their coverage, stay as they are.
    """
    pixels = _at_edges(color, alpha)
    if lines is not None:
        pixels = pixels[lines[tuple(pixels.T)] < COVERED]
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
