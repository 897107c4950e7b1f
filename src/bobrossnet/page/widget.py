"""<bob-view> as a notebook widget, by anywidget, for JupyterLab, VS Code, Marimo and others."""

from __future__ import annotations

import zlib
from typing import Any

import anywidget
import traitlets

from bobrossnet.adapters.container import packed
from bobrossnet.page.export import single_file_parts
from bobrossnet.page.joining import BROUGHT, WIDGET, Modules, brought, joined
from bobrossnet.page.look import css
from bobrossnet.picture.camera import Camera
from bobrossnet.picture.order import Size
from bobrossnet.pictures.background import Background
from bobrossnet.pictures.rendered import Picture
from bobrossnet.pictures.rendering import render
from bobrossnet.support.errors import InputError
from bobrossnet.support.paths import VIEWER
from bobrossnet.tracing.light import HEADLIGHT
from bobrossnet.tracing.scene import Scene

OWN = "scene"
"""The name of a scene's own lights, for <bob-view>."""

NUMBERS = ("azimuth", "elevation", "roll", "zoom", "fov")


def script(scene: Scene) -> str:
    """Return the widget's module with everything that it needs to show a scene, in any light."""
    modules = Modules(VIEWER)
    parts = single_file_parts(scene)
    return joined(Modules(VIEWER, {BROUGHT: brought(modules, parts)}), WIDGET)


def _to_page(camera: Camera, _: Any = None) -> dict[str, float]:
    pan_x, pan_y = camera.pan
    return {**{name: getattr(camera, name) for name in NUMBERS}, "panX": pan_x, "panY": pan_y}


def _from_page(numbers: dict[str, Any], _: Any = None) -> Camera:
    pan = numbers["panX"], numbers["panY"]
    return Camera(**{name: numbers[name] for name in NUMBERS}, pan=pan)


class SceneView(anywidget.AnyWidget):
    """A scene in a notebook, turned by mouse or touch; `bobrossnet.view` makes it.

    Attributes
    ----------
    camera : Camera
        The current camera; setting it turns the scene. Must orbit: a camera with a position is refused.
    """

    _esm = traitlets.Unicode().tag(sync=True)
    scene = traitlets.Bytes().tag(sync=True)  # a .bob file, deflated
    size = traitlets.Tuple(traitlets.Int(), traitlets.Int()).tag(sync=True)
    background = traitlets.Unicode().tag(sync=True)
    light = traitlets.Unicode(HEADLIGHT).tag(sync=True)  # the attribute of <bob-view>
    camera = traitlets.Instance(Camera).tag(sync=True, to_json=_to_page, from_json=_from_page)

    def __init__(self, scene: Scene, camera: Camera, size: Size, background: Background) -> None:
        self._shown = scene
        self._behind = background
        super().__init__(
            _esm=script(scene),
            light=OWN if isinstance(scene.light, list) else scene.light or HEADLIGHT,
            scene=zlib.compress(packed(scene), 9),
            camera=camera,
            size=size,
            background=css(background),
        )

    @traitlets.validate("camera")
    def _check_camera(self, proposal: Any) -> Camera:
        camera: Camera = proposal["value"]
        if camera.position is not None:
            raise InputError("camera: expected an orbiting camera, got one at a position")
        return camera

    def __repr__(self) -> str:
        return f"SceneView({self._shown!r}, {self.camera!r})"

    @property
    def _look(self) -> dict[str, Any]:
        light = None if self.light == OWN else self.light
        return {"size": tuple(self.size), "background": self._behind, "light": light}

    def snapshot(self, **options: Any) -> Picture:
        """Render the current view with antialiasing, every pixel traced, in the kernel.

        Parameters
        ----------
        **options
            As in `bobrossnet.render`; size, background and light default to the widget's.
        """
        return render(self._shown, self.camera, **{**self._look, **options})

    def _repr_mimebundle_(self, **kwargs: Any) -> Any:
        """Include a picture, for programs that show notebooks without widgets."""
        bundle = super()._repr_mimebundle_(**kwargs)
        if bundle is None:
            return None
        data, metadata = bundle if isinstance(bundle, tuple) else (bundle, {})
        return {**data, "image/png": self.snapshot(samples=1)._repr_png_()}, metadata
