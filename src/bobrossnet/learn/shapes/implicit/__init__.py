"""Implicit surfaces: organic blends of simple solids, and formulas."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bobrossnet.learn.shapes.implicit import formulas, grown
from bobrossnet.tracing.scene import SceneLike

FAMILIES: dict[str, Callable[[np.random.Generator], SceneLike]] = {**grown.FAMILIES, **formulas.FAMILIES}
