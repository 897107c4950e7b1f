"""What shows itself as the value of a notebook's cell. Pictures and films do by themselves; here, what knows nothing of
pictures.
"""

from __future__ import annotations

from typing import Any

from bobrossnet.picture.camera import Camera
from bobrossnet.picture.files import png, traced_on_green
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.order import SizeLike, check_size
from bobrossnet.pictures.fitting import fitted, margin_of
from bobrossnet.pictures.rendering import Background, render
from bobrossnet.shapes.shape import Shape
from bobrossnet.support.errors import InputError
from bobrossnet.tracing.instance import Instance
from bobrossnet.tracing.scene import Scene, SceneLike, as_scene

SIZE = (256, 256)


def _drawn(scene: SceneLike) -> bytes:
    """A small picture that the silhouette fills."""
    scene = as_scene(scene)
    camera = fitted(scene, size=SIZE, margin=margin_of(scene, None, None))
    return render(scene, camera, size=SIZE)._repr_png_()


def _traced(gbuffer: GBuffer) -> bytes:
    """What was traced, and green where nothing was."""
    return png(traced_on_green(gbuffer))


def view(
    scene: SceneLike,
    camera: Camera | None = None,
    *,
    size: SizeLike = (480, 640),
    background: Background = None,
) -> Any:
    """Show a scene in a notebook, where hands turn it; needs the extra `notebook`.

    It is traced in the browser, by what the notebook itself holds, so that it still turns when the kernel has ended.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these
    camera : Camera, optional
        One that orbits.
    size : (height, width), or "WIDTHxHEIGHT"
        In the pixels of the notebook, which may be less wide.
    background : color, two colors, or None
        As in `render`.

    Returns
    -------
    SceneView
        A widget. `widget.camera` is the camera at any time, and may be set; `widget.snapshot()` returns a Picture of
        what it shows.

    Raises
    ------
    InputError
        If anywidget is not installed, or the camera stands at a position.
    """
    scene, camera, size = as_scene(scene), Camera() if camera is None else camera, check_size(size)
    try:
        from bobrossnet.page.widget import SceneView
    except ModuleNotFoundError as error:
        raise InputError(f"view: this needs {error.name}: pip install 'bobrossnet[notebook]'") from error
    return SceneView(scene, camera, size, background)


def register() -> None:
    """Let shapes, instances, scenes and G-buffers show themselves."""
    for kind in (Shape, Instance, Scene):
        setattr(kind, "_repr_png_", _drawn)  # noqa: B010  types know no such method
    setattr(GBuffer, "_repr_png_", _traced)  # noqa: B010
