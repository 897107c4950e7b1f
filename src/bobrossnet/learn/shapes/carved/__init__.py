"""Solids of constructive geometry: machined parts, buildings and objects, with hard and rounded edges."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bobrossnet.learn.shapes.carved import parts, things
from bobrossnet.tracing.scene import SceneLike

FAMILIES: dict[str, Callable[[np.random.Generator], SceneLike]] = {**parts.FAMILIES, **things.FAMILIES}
