"""The pictures of SparseBench, every pixel traced: the package's own, models, Mitsuba's scenes, measurements."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import protocol
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.color import luminance, to_srgb
from bobrossnet.learn.shape_files import shape_files, spread
from bobrossnet.learn.shapes import implicit, procedural_scene, splines
from bobrossnet.learn.shapes.colors import textured
from bobrossnet.support.errors import InputError

sys.path.append(str(Path(__file__).parents[1]))  # for bench/mitsuba_scenes.py

FAMILIES = {"isosurface": implicit.FAMILIES, "nurbs": splines.FAMILIES}


class Picture(NamedTuple):
    """A picture to complete."""

    number: int
    name: str
    view: Callable[[float], bob.GBuffer] | None
    """Traces every pixel, with the camera turned by this angle in degrees; None if there is one view only."""
    full: bob.GBuffer


def camera(index: int, turn: float = 0) -> bob.Camera:
    """Return the camera of a picture, turned by `turn` degrees."""
    azimuth = protocol.AZIMUTH_STEP * index + turn
    return bob.Camera(azimuth=azimuth, elevation=protocol.ELEVATIONS[index % 2], fov=protocol.FOVS[index // 2 % 2])


def made_scene(index: int) -> bob.Scene:
    """Return the shape of the package's picture with this index."""
    kind, turn = protocol.KINDS[index % len(protocol.KINDS)], index // len(protocol.KINDS)
    if kind == "shape":
        return procedural_scene(protocol.SEED + index)
    rng = np.random.Generator(np.random.Philox(key=[protocol.SEED + index, 0]))
    if kind == "texture":
        return bright_scene(rng, index)
    families = list(FAMILIES[kind].values())
    while True:
        try:
            return bob.Scene(families[turn % len(families)](rng))
        except InputError:  # about one formula in a thousand is negative nowhere: draw another
            continue


def bright_scene(rng: np.random.Generator, index: int) -> bob.Scene:
    """Return a textured shape whose surface is bright enough for scores in linear light; many textures are dark."""
    while True:
        scene = textured(rng, procedural_scene(int(rng.integers(protocol.SEED, 2 * protocol.SEED))))
        view = bob.trace(scene, camera(index), size=(64, 64))
        if view.gray.sum() > protocol.BRIGHT * max(view.channel("alpha").sum(), 1):
            return scene


def made(limit: int, size: tuple[int, int] = protocol.SIZE) -> Iterator[Picture]:
    """Yield the package's pictures."""
    for index in range(min(limit, protocol.COUNT)):
        scene = made_scene(index)
        yield _picture(index, f"{protocol.KINDS[index % len(protocol.KINDS)]} {index}", scene, size)


def models(limit: int, size: tuple[int, int] = protocol.SIZE) -> Iterator[Picture]:
    """Yield pictures of the files below the folder in BOBROSSNET_MODELS."""
    folder = Path(os.environ.get("BOBROSSNET_MODELS", ""))
    if not (os.environ.get("BOBROSSNET_MODELS") and folder.is_dir()):
        raise InputError("models: expected a folder of shapes in BOBROSSNET_MODELS, got none")
    for index, path in enumerate(spread(shape_files(folder), limit)):
        yield _picture(index, path.relative_to(folder).as_posix(), bob.Scene(bob.load(path)), size)


def mitsuba_scenes(limit: int, size: tuple[int, int] = protocol.SIZE) -> Iterator[Picture]:
    """Yield path-traced pictures, denoised: gray is the luminance of their sRGB."""
    try:
        import mitsuba as mi
        from mitsuba_scenes import scene

        from bobrossnet.adapters import mitsuba, oidn
    except ModuleNotFoundError as error:
        raise InputError(f"mitsuba: this needs {error.name}: pip install 'bobrossnet[mitsuba,oidn]'") from None
    if mi.variant() is None:
        mi.set_variant("scalar_rgb")
    pixels = bob.pixel_order(size)
    for index, name in enumerate(protocol.MITSUBA_SCENES[:limit]):
        tracer = mitsuba.tracer(scene(name, size=size), spp=protocol.MITSUBA_PATHS, seed=index)
        samples, guides = tracer(pixels), tracer.guides()
        color = np.empty((*size, 3), np.float32)
        color[tuple(pixels.T)] = samples.color
        gray = luminance(to_srgb(np.clip(oidn.denoise(color, guides), 0, 1)))
        far = guides.depth.max()
        depth = np.where(guides.hit > 0, 1 - 0.9 * guides.depth / far, 0).astype(np.float32)
        full = bob.GBuffer(
            mask=np.ones(size, np.float32), gray=gray.astype(np.float32), depth=depth, normal=guides.normal
        )
        yield Picture(index, name, None, full)


def measured(limit: int, files: Sequence[str]) -> Iterator[Picture]:
    """Yield image files in full size: gray from 0 at their least value to 1 at their greatest."""
    if not files:
        raise InputError("measured: expected image files in --images, got none")
    for index, file in enumerate(files[:limit]):
        gray = image_file(file)
        yield Picture(index, Path(file).name, None, bob.GBuffer(mask=np.ones_like(gray), gray=gray))


def image_file(path: str) -> NDArray[np.float32]:
    """Return an image file's values, from 0 at the least to 1 at the greatest, (H, W)."""
    import cv2

    image = cv2.imread(path, cv2.IMREAD_UNCHANGED)  # TIFFs of 64-bit floats too
    if image is None:
        raise InputError(f"{path}: expected an image file, got none that OpenCV reads")
    values = image.astype(np.float64)
    values = values if values.ndim == 2 else values[..., :3].mean(2)
    low, high = float(values.min()), float(values.max())
    return ((values - low) / ((high - low) or 1)).astype(np.float32)


def pictures(group: str, limit: int, files: Sequence[str] = (), **options: Any) -> Iterator[Picture]:
    """Yield the pictures of a group. InputError if it lacks a file or a package."""
    return measured(limit, files) if group == "measured" else GROUPS[group](limit, **options)


GROUPS: dict[str, Callable[..., Iterator[Picture]]] = {
    "made": made,
    "models": models,
    "mitsuba": mitsuba_scenes,
    "measured": measured,
}


def _picture(index: int, name: str, scene: bob.Scene, size: tuple[int, int]) -> Picture:
    view = partial(_view, scene, index, size)
    return Picture(index, name, view, view(0))


def _view(scene: bob.Scene, index: int, size: tuple[int, int], turn: float) -> bob.GBuffer:
    return bob.trace(scene, camera(index, turn), size=size)
