"""Films: pictures along a camera path, such as turntables."""

from __future__ import annotations

import base64
import io
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.completion.network import Network, NetworkLike, load_network
from bobrossnet.picture.camera import Camera, CameraLike, as_camera, orbiting
from bobrossnet.picture.files import before, check_sides
from bobrossnet.picture.order import Size, SizeLike, check_size
from bobrossnet.pictures.background import Background
from bobrossnet.pictures.drawing import EdgesLike, check_edges
from bobrossnet.pictures.rendered import Picture
from bobrossnet.pictures.rendering import check_picture, render
from bobrossnet.support.atomic import check_writable, write_whole
from bobrossnet.support.cluster import as_done, connected
from bobrossnet.support.errors import InputError, InputTypeError, check_flag, check_integer, check_number, each_of
from bobrossnet.support.messages import counted
from bobrossnet.tracing.light import LightLike, check_light
from bobrossnet.tracing.scene import SceneLike, as_scene
from bobrossnet.tracing.section import SectionLike

if TYPE_CHECKING:
    from PIL.Image import Image

FORMATS = {".webp": "WebP", ".png": "PNG", ".gif": "GIF", ".avif": "AVIF", ".mp4": "MP4"}
"""File endings of films."""

MAX_FRAMES = 10_000

FPS = 0.1, 100.0
"""Minimum and maximum of frames per second."""

OPTIONS: dict[str, dict[str, Any]] = {
    "WebP": {"quality": 90, "method": 2, "minimize_size": False},
    "PNG": {"default_image": False, "blend": 0, "disposal": 0},
    "GIF": {"disposal": 2, "optimize": False},
    "AVIF": {"quality": 80, "speed": 9},
}
"""Pillow's options for each format: good quality at a few milliseconds a frame."""


class Film:
    """Pictures of a scene along a camera path, rendered one at a time during iteration.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these
    cameras : iterable of Camera or names of views
        One camera for each picture.
    size, samples, background, fraction, model, light, ground, edges, section
        As in `render`.
    scheduler : address of a Dask scheduler, optional
        The scheduler's workers, with this package installed, render the pictures.

    Raises
    ------
    InputError
        If an argument is out of range or there is no camera; during iteration, if the scheduler can't be reached.
    """

    def __init__(
        self,
        scene: SceneLike,
        cameras: Iterable[CameraLike],
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
        scheduler: str | None = None,
    ) -> None:
        self.scene = as_scene(scene, section)
        if isinstance(cameras, Camera | str):
            raise InputTypeError("cameras: expected several cameras, got one; put it in a list")
        self.cameras: Sequence[Camera] = tuple(as_camera(each) for each in each_of("cameras", cameras, "cameras"))
        if not self.cameras:
            raise InputError("cameras: expected at least one, got none")
        self.size = check_size(size)
        check_picture(samples, background, self.size)
        check_number("fraction", fraction, 0, 1, above=True)
        self._options: dict[str, Any] = {
            "samples": samples,
            "background": background,
            "fraction": fraction,
            "model": load_network(model) if scheduler is None else _by_name(model),
            "light": check_light(light),
            "ground": ground if ground is None else check_flag("ground", ground),
            "edges": check_edges(edges) or False,
        }
        self._scheduler = scheduler

    def __len__(self) -> int:
        return len(self.cameras)

    def __iter__(self) -> Iterator[Picture]:
        if self._scheduler is None:
            for camera in self.cameras:
                yield render(self.scene, camera, size=self.size, **self._options)
            return
        with connected(self._scheduler) as client:
            draw = partial(render, size=self.size, **self._options)
            scene = client.scatter(self.scene, broadcast=True)  # once for each worker, not for each picture
            early: dict[int, Picture] = {}  # finished before their predecessors in the film
            shown = 0
            for index, future in as_done(client, draw, [(scene, camera) for camera in self.cameras]):
                early[index] = future.result()
                while shown in early:
                    yield early.pop(shown)
                    shown += 1

    def save(
        self, path: str | os.PathLike[str], *, fps: float = 25, progress: Callable[[float], None] | None = None
    ) -> None:
        """Render the pictures and write them to a file that loops forever.

        Parameters
        ----------
        path : str or path
            Ends in .webp, .png (APNG), .gif, .avif, or .mp4, which needs the package av and has no transparency.
        fps : float in 0.1..100
            Frames per second.
        progress : callable, optional
            Called with the share of finished pictures, 0..1.

        Raises
        ------
        InputError
            If an argument is out of range, or the file can't be written.
        """
        file = check_film_path(path, self.size)
        check_number("fps", fps, *FPS)
        frames: list[NDArray[np.uint8]] = []
        for picture in self:
            frames.append(picture.rgba)
            if progress is not None:
                progress(len(frames) / len(self))
        try:
            content = _encoded(FORMATS[file.suffix.lower()], frames, fps)
        except (OSError, ValueError, KeyError) as error:  # such as a Pillow without AVIF
            height, width = self.size
            raise InputError(f"{file}: can't write pictures of {width} x {height} pixels: {error}") from error
        write_whole(file, content)

    def _repr_html_(self) -> str:
        content = _encoded("WebP", [picture.rgba for picture in self], 25)
        return f'<img alt="" src="data:image/webp;base64,{base64.b64encode(content).decode()}">'

    def __repr__(self) -> str:
        height, width = self.size
        return f"Film({counted(len(self), 'picture')} of {width} x {height})"


def orbit(
    scene: SceneLike,
    camera: CameraLike | None = None,
    *,
    frames: int = 75,
    size: SizeLike = (480, 640),
    samples: int = 4,
    background: Background = None,
    fraction: float = 1.0,
    model: NetworkLike = "default",
    light: LightLike = None,
    ground: bool | None = None,
    edges: EdgesLike = False,
    section: SectionLike = None,
    scheduler: str | None = None,
) -> Film:
    """Make a film of one turn around a scene, anticlockwise seen from above.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these
    camera : Camera, optional
        First camera, on an orbit.
    frames : int, 1..10000
        Number of pictures in the turn.
    size, samples, background, fraction, model, light, ground, edges, section
        As in `render`.
    scheduler
        As in `Film`.

    Returns
    -------
    Film
        A notebook displays it; `save` writes it.

    Raises
    ------
    InputError
        If an argument is out of range, or the camera has a position.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> bob.orbit(bob.happy_tree(), frames=50, size="320x240")
    Film(50 pictures of 320 x 240)
    """
    scene = as_scene(scene)
    first = orbiting(camera, scene)
    check_integer("frames", frames, 1, MAX_FRAMES)
    cameras = [replace(first, azimuth=first.azimuth + 360 * i / frames) for i in range(frames)]
    return Film(
        scene, cameras, size=size, samples=samples, background=background, fraction=fraction, model=model,
        light=light, ground=ground, edges=edges, section=section, scheduler=scheduler,
    )  # fmt: skip


def check_film_path(path: str | os.PathLike[str], size: Size) -> Path:
    """Return `path` if a film of a size can be written there; checked before any time is spent on the film."""
    path = check_writable(path, "a film", FORMATS)
    check_sides(path, FORMATS[path.suffix.lower()], size)
    if path.suffix.lower() == ".mp4":
        try:
            import av  # noqa: F401
        except ModuleNotFoundError as error:
            raise InputError(f"{path}: writing .mp4 needs av: pip install 'bobrossnet[video]'") from error
    return path


def _by_name(model: NetworkLike) -> NetworkLike:
    """Check a name or a path of a network; a cluster's workers load it themselves."""
    if isinstance(model, Network):
        raise InputTypeError("model: expected a name or a path for a cluster, got a Network")
    load_network(model)
    return model


def _encoded(kind: str, frames: Sequence[NDArray[np.uint8]], fps: float) -> bytes:
    from PIL import Image

    content = io.BytesIO()
    if kind == "MP4":
        _write_mp4(content, frames, fps)
        return content.getvalue()
    images = [_shown(Image.fromarray(frame), kind) for frame in frames]
    duration = [round(1000 * (i + 1) / fps) - round(1000 * i / fps) for i in range(len(frames))]
    loop: dict[str, Any] = {"save_all": True, "append_images": images[1:], "duration": duration, "loop": 0}
    images[0].save(content, kind, **loop, **OPTIONS[kind])
    return content.getvalue()


def _shown(image: Image, kind: str) -> Image:
    """Convert a frame to a format's pixels: opaque pictures drop alpha."""
    return image.convert("RGB") if kind != "GIF" and image.getextrema()[-1] == (255, 255) else image


def _write_mp4(content: io.BytesIO, frames: Sequence[NDArray[np.uint8]], fps: float) -> None:
    from fractions import Fraction

    import av

    height, width = (side + side % 2 for side in frames[0].shape[:2])  # H.264 halves the chroma resolution
    with av.open(content, "w", format="mp4") as file:
        stream = file.add_stream("libx264", rate=Fraction(fps).limit_denominator(1000), options={"crf": "18"})
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        for frame in frames:
            rgb = before("black", frame)
            padded = np.pad(rgb, [(0, height - rgb.shape[0]), (0, width - rgb.shape[1]), (0, 0)], "edge")
            for packet in stream.encode(av.VideoFrame.from_ndarray(padded, format="rgb24")):
                file.mux(packet)
        for packet in stream.encode():
            file.mux(packet)
