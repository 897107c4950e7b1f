"""Implicit surfaces: what grows, as blends of simple solids, and what formulas of space give."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bobrossnet.learn.shapes.implicit import formulas, grown
from bobrossnet.tracing.scene import SceneLike

FAMILIES: dict[str, Callable[[np.random.Generator], SceneLike]] = {**grown.FAMILIES, **formulas.FAMILIES}
