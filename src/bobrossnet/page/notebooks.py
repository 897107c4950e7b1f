"""Displays of shapes, scenes and G-buffers as values of notebook cells.

Pictures and films display themselves; these types do not depend on pictures.
"""

from __future__ import annotations

from typing import Any

from bobrossnet.picture.camera import CameraLike, as_camera
from bobrossnet.picture.files import png, traced_on_green
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.order import SizeLike, check_size
from bobrossnet.pictures.background import Background
from bobrossnet.pictures.fitting import fitted, margin_of
from bobrossnet.pictures.rendering import render
from bobrossnet.shapes.shape import Shape
from bobrossnet.support.errors import InputError
from bobrossnet.tracing.instance import Instance
from bobrossnet.tracing.light import LightLike
from bobrossnet.tracing.lit import relit
from bobrossnet.tracing.scene import Scene, SceneLike, as_scene

SIZE = (256, 256)


def _drawn(scene: SceneLike) -> bytes:
    """Render a small picture, filled by the silhouette."""
    scene = as_scene(scene)
    camera = fitted(scene, size=SIZE, margin=margin_of(scene, None, None))
    return render(scene, camera, size=SIZE)._repr_png_()


def _traced(gbuffer: GBuffer) -> bytes:
    """Draw the traced pixels over green."""
    return png(traced_on_green(gbuffer))


def view(
    scene: SceneLike,
    camera: CameraLike | None = None,
    *,
    size: SizeLike = (480, 640),
    background: Background = None,
    light: LightLike = None,
    ground: bool | None = None,
) -> Any:
    """Show a scene in a notebook, to be turned by mouse or touch; needs the extra `notebook`.

    The browser traces it from data within the notebook, so that it still turns after the kernel has ended.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these
    camera : Camera, optional
        An orbiting camera.
    size : (height, width), or "WIDTHxHEIGHT"
        Size in CSS pixels; the notebook may be narrower.
    background : colour, two colours, or None
        As in `render`.
    light, ground
        As in `render`.

    Returns
    -------
    SceneView
        A widget. `widget.camera` is the current camera and can be set; `widget.snapshot()` returns a Picture of the
        current view.

    Raises
    ------
    InputError
        If anywidget is not installed, or the camera has a position.
    """
    scene, size = relit(as_scene(scene), light, ground), check_size(size)
    camera = as_camera(camera, scene)
    try:
        from bobrossnet.page.widget import SceneView
    except ModuleNotFoundError as error:
        raise InputError(f"view: this needs {error.name}: pip install 'bobrossnet[notebook]'") from error
    return SceneView(scene, camera, size, background)


def register() -> None:
    """Register notebook displays of shapes, instances, scenes and G-buffers."""
    for kind in (Shape, Instance, Scene):
        setattr(kind, "_repr_png_", _drawn)  # noqa: B010  unknown to the type
    setattr(GBuffer, "_repr_png_", _traced)  # noqa: B010
