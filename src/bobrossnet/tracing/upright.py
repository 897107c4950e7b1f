"""Guess of the up axis of meshes from files that store y up without a declaration."""

from __future__ import annotations

import numpy as np

from bobrossnet import _core
from bobrossnet.shapes.affine import mapped
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.tracing.scene import Scene


def seems_to_lie(scene: Scene) -> bool:
    """Return whether y is more likely the up axis than z, as core/shapes/mesh/lying.h decides.

    Parameters
    ----------
    scene : Scene
        Scenes with other shapes than meshes give False.

    Returns
    -------
    bool
        True only if the evidence is clear.
    """
    vertices, triangles, count = [np.empty((0, 3))], [np.empty((0, 3), np.int32)], 0
    for instance in scene.instances:
        if not isinstance(instance.shape, Mesh):
            return False
        vertices.append(mapped(instance.transform, instance.shape.vertices))
        triangles.append(instance.shape.triangles + count)
        count += len(vertices[-1])
    return _core.seems_to_lie(np.concatenate(vertices), np.concatenate(triangles))
