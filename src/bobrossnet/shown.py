"""What shows itself in notebooks."""

from __future__ import annotations

from typing import Any


class Shown:
    """Shapes, instances and scenes: their silhouette fills a small picture."""

    __slots__ = ()

    def _repr_png_(self) -> bytes:
        from bobrossnet.fitting import fitted
        from bobrossnet.rendering import render

        shown: Any = self
        return render(shown, fitted(shown, size=(256, 256)), size=(256, 256))._repr_png_()
