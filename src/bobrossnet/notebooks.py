"""What shows itself as the value of a notebook's cell. Pictures and films do by themselves; here, what knows nothing of
pictures.
"""

from __future__ import annotations

from bobrossnet.fitting import fitted
from bobrossnet.picture.files import png, traced_on_green
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.rendering import render
from bobrossnet.shapes.shape import Shape
from bobrossnet.tracing.instance import Instance
from bobrossnet.tracing.scene import Scene, SceneLike

SIZE = (256, 256)


def _drawn(scene: SceneLike) -> bytes:
    """A small picture that the silhouette fills."""
    return render(scene, fitted(scene, size=SIZE), size=SIZE)._repr_png_()


def _traced(gbuffer: GBuffer) -> bytes:
    """What was traced, and green where nothing was."""
    return png(traced_on_green(gbuffer))


def register() -> None:
    """Let shapes, instances, scenes and G-buffers show themselves."""
    for kind in (Shape, Instance, Scene):
        setattr(kind, "_repr_png_", _drawn)  # noqa: B010  types know no such method
    setattr(GBuffer, "_repr_png_", _traced)  # noqa: B010
