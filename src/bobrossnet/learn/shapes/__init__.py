"""Shapes to learn from, which the package makes itself, each from its seed: meshes, implicit surfaces, carved solids,
NURBS.

They stand in for the models that people will bring, which are kept for testing: as varied as these are, organic and
mechanical, simple and intricate, smooth and with hard edges, solid and thin.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from bobrossnet.learn.shapes import carved, implicit, splines
from bobrossnet.learn.shapes.meshes import procedural_mesh
from bobrossnet.shapes.scene import Scene, SceneLike

Family = Callable[[np.random.Generator], SceneLike]

KINDS: dict[str, tuple[float, Mapping[str, Family] | None]] = {
    "mesh": (0.46, None),  # `procedural_mesh` chooses by itself, and assembles
    "implicit": (0.18, implicit.FAMILIES),
    "carved": (0.18, carved.FAMILIES),
    "nurbs": (0.18, splines.FAMILIES),
}
"""By kind: how often it comes up, and its families, which come up equally often."""


def procedural_scene(seed: int) -> Scene:
    """Return the shape of a seed, of any size and place; some are made of several.

    Parameters
    ----------
    seed : int of at least 0
    """
    rng = np.random.Generator(np.random.Philox(key=[seed, 0x5A4E]))
    kinds = list(KINDS)
    _, families = KINDS[kinds[rng.choice(len(kinds), p=[chance for chance, _ in KINDS.values()])]]
    if families is None:
        return Scene(procedural_mesh(seed))
    name = list(families)[rng.integers(len(families))]
    return Scene(families[name](rng))
