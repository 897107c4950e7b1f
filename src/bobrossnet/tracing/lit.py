"""Tracing of light: many paths in each pixel, first hits at all pixels."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.picture.camera import Camera, check_camera
from bobrossnet.picture.channels import Layout
from bobrossnet.picture.guides import Edges, Guides
from bobrossnet.picture.order import SizeLike, check_pixels, check_size
from bobrossnet.picture.samples import Samples
from bobrossnet.support.errors import InputError, InputTypeError, check_flag, check_integer
from bobrossnet.tracing.light import (
    BOUNCES,
    HEADLIGHT,
    MAX_BOUNCES,
    STUDIO,
    Light,
    LightLike,
    Sky,
    check_light,
    lights_of,
)
from bobrossnet.tracing.scene import Scene, SceneLike, as_scene

LIT = Layout("mask,gray,depth,normal,color,albedo,shadow,variance")
"""Channels of a lit pixel."""

PATHS: int = _core.LIGHT_PATHS
"""Paths of a pixel at each visit."""

MAX_PATHS = 4096

HITS = 10
"""Numbers of a first hit: mask, depth, normal and albedo, mask and depth of the ground, and `Guides.behind`."""

EDGE_RAYS: int = _core.EDGE_RAYS
"""Rays of first hits at edges, down and across a pixel."""

FIRST_EDGE_RAYS: int = _core.MOVING_EDGE_RAYS
"""The same for a first picture, which is soon replaced."""


class LitTracer:
    """Light in a scene as a `Tracer`: each call adds paths to its pixels, other ones each time.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these
    camera : Camera
    size : (height, width) or "WIDTHxHEIGHT"
    light : as in `render`, except the headlight
    ground : bool
        Whether a plane under the scene catches shadows.
    paths : int, 1..4096
        Paths of each pixel in a call.
    bounces : int, 1..8
        Maximum number of surfaces on a path, mirrors excluded: 1 is direct light alone.
    seed : int, 0..2**64 - 1
    apart : bool
        Whether each path starts at a different point of its pixel, not at the centre. Pixels are then area means, and
        need enough paths to converge.
    """

    def __init__(
        self,
        scene: SceneLike,
        camera: Camera,
        size: SizeLike,
        light: LightLike,
        *,
        ground: bool = False,
        paths: int = PATHS,
        bounces: int = BOUNCES,
        seed: int = 0,
        apart: bool = False,
    ) -> None:
        camera = check_camera(camera)
        self.size = check_size(size)
        self.scene, self.camera = as_scene(scene), camera
        self.lights: list[Light | Sky] = lights_of(light, camera) or []
        self.paths = check_integer("paths", paths, 1, MAX_PATHS)
        self.seed = check_integer("seed", seed, 0, 2**64 - 1)
        lights = lights_in_core(self.scene, self.lights, check_flag("ground", ground), bounces)
        self._core = _core.Lighting(self.scene.core, lights)
        self._has_ground, self._apart = ground, check_flag("apart", apart)
        self.camera_in_core = camera.core(self.scene.center, self.scene.radius)
        self._drawn = np.zeros(self.size, np.uint32)

    def __call__(self, pixels: NDArray[np.int32]) -> Samples:
        """The means of paths through each pixel. Later calls go on with each pixel's sequence."""
        pixels = check_pixels(pixels)
        rows, columns = pixels.T
        values = np.empty((len(pixels), LIT.width), np.float32)
        self._core.trace(
            self.camera_in_core,
            *self.size,
            pixels,
            self._drawn[rows, columns],
            self.paths,
            self.seed,
            self._apart,
            LIT.core,
            values,
        )
        self._drawn[rows, columns] += np.uint32(self.paths)
        return Samples.from_values(values, LIT)

    def guides(self) -> Guides:
        """First surfaces at all pixels' centres, with `EDGE_RAYS`^2 within pixels at edges; means over pixels if paths
        are apart."""
        return self._guides(self._first_hits(), EDGE_RAYS)

    def guides_in_steps(self) -> Iterator[Guides]:
        """Yield guides for a first picture, with `FIRST_EDGE_RAYS`^2 within pixels at edges, then those of `guides`."""
        planes = self._first_hits()
        for rays in (FIRST_EDGE_RAYS, EDGE_RAYS):
            yield self._guides(planes, rays)

    def _first_hits(self) -> NDArray[np.float32]:
        planes = np.empty((HITS, *self.size), np.float32)
        self._core.first_hits(self.camera_in_core, planes)
        return planes

    def _guides(self, planes: NDArray[np.float32], edge_rays: int) -> Guides:
        edges = Edges(*self._core.hits_at_edges(self.camera_in_core, planes, edge_rays))
        if self._apart:
            planes[:, edges.pixels[:, 0], edges.pixels[:, 1]] = _means(edges.hits).T
            planes[4:7] *= planes[0]  # light over a pixel is the light of its covered part
        return first_surfaces(planes, None if self._apart else edges, self._has_ground)

    def __reduce__(self) -> tuple[Any, ...]:
        raise InputTypeError("LitTracer: expected to stay where it was made; make another of the same scene")


def first_surfaces(planes: NDArray[np.float32], edges: Edges | None, has_ground: bool) -> Guides:
    """Return guides from first hits, (`HITS`, H, W), and those within pixels at edges."""
    ground = None
    if has_ground:
        share, depth = planes[7:9]
        flat = np.zeros_like(planes[:2])
        ground = Guides.from_planes(np.stack([share, depth, *flat, share, share, share]))
    return Guides.from_planes(planes[:7], ground, edges if edges and len(edges.pixels) else None, planes[9])


def lights_in_core(
    scene: Scene, lights: list[Light | Sky], ground: bool = False, bounces: int = BOUNCES
) -> _core.Lights:
    """Return the core's lights of a scene."""
    sky = next((light for light in lights if isinstance(light, Sky)), Sky((0.0, 0.0, 0.0)))
    top, bottom = (tuple(sky.intensity * c for c in color) for color in (sky.top, sky.bottom))
    environment = None if sky.image is None else _core.environment(sky.image)
    return _core.Lights(
        [light.core() for light in lights if isinstance(light, Light)],
        top,
        bottom,
        environment,
        math.radians(sky.turn),
        ground,
        scene.radius,
        check_integer("bounces", bounces, 1, MAX_BOUNCES),
    )


def relit(scene: Scene, light: LightLike, ground: bool | None) -> Scene:
    """Return the scene with another light and ground of its own; None keeps them."""
    if light is None and ground is None:
        return scene
    result = scene.of(scene.instances)
    result.light = scene.light if light is None else check_light(light)
    result.ground = scene.ground if ground is None else check_flag("ground", ground)
    shows_shadows(result, None, ground)  # checks that they go together
    return result


def _means(hits: NDArray[np.float32]) -> NDArray[np.float32]:
    """(n, HITS): first hits over whole pixels, depth, normal and albedo over what of them is covered."""
    covered = hits[..., :1].mean(1)
    of_surface = (hits[..., 1:7] * hits[..., :1]).mean(1) / np.maximum(covered, 1 / hits.shape[1])
    return np.concatenate(
        [covered, of_surface, hits[..., 7:8].mean(1), np.zeros_like(covered), hits[..., 9:].mean(1)], -1
    )


def lit_tracer(
    scene: SceneLike,
    camera: Camera,
    size: SizeLike,
    light: LightLike,
    ground: bool | None,
    *,
    paths: int = PATHS,
    seed: int = 0,
) -> LitTracer | None:
    """Return the tracer of the requested light, or of the scene's light; None for the headlight."""
    scene = as_scene(scene)
    lights = lights_and_ground(scene, light, ground)
    if lights is None:
        return None
    return LitTracer(scene, camera, size, lights[0], ground=lights[1], paths=paths, seed=seed)


def lights_and_ground(scene: Scene, light: LightLike, ground: bool | None) -> tuple[LightLike, bool] | None:
    """Return the requested light, otherwise the scene's, and whether there is a ground; None for the headlight."""
    chosen = check_light(scene.light if light is None else light)
    has_ground = shows_shadows(scene, chosen, ground)
    return None if chosen is None or chosen == HEADLIGHT else (chosen, has_ground)


def shows_shadows(scene: Scene, light: LightLike, ground: bool | None) -> bool:
    """Return whether a scene has a ground: as requested, otherwise as the scene has it, otherwise in the studio."""
    light = scene.light if light is None else light
    asked = ground if ground is None else check_flag("ground", ground)
    if light is None or (isinstance(light, str) and light == HEADLIGHT):
        if asked:
            raise InputError("ground: expected none under the headlight, which casts no shadows; light='studio' does")
        return False
    stands = scene.ground if asked is None else asked
    return (isinstance(light, str) and light == STUDIO) if stands is None else stands
