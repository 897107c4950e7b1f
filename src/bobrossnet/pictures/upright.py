"""A guess whether scenes of meshes lie: whether their files have y up, and do not say so."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet.shapes.affine import mapped
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.tracing.scene import Scene

POINTS = 50_000
"""On the surfaces, at random."""

BASE = 0.02
"""Of the height: what is lower touches the ground."""

CELLS = 16
"""Of the box along each axis, for symmetry."""

CLEAR = 0.5
"""Of the logarithm of how much better one axis is. Of 96 files whose up is clear to the eye it finds 63 of the 76 that
lie, and takes none of the others for such; of 32 machine parts, which have no up, 7."""


def seems_to_lie(scene: Scene) -> bool:
    """Whether y is more likely the axis that points up than z.

    Things stand on a wide base with their centre above it, and have less symmetry between up and down than between left
    and right or front and back (after Fu, Cohen-Or, Dror and Sheffer, *Upright orientation of man-made objects*, 2008).

    Parameters
    ----------
    scene : Scene
        What is not made of meshes alone never seems to lie.

    Returns
    -------
    bool
        True only where it is clear.
    """
    if not all(isinstance(instance.shape, Mesh) for instance in scene.instances):
        return False
    points = _points(scene)
    if len(points) == 0:
        return False
    size = np.ptp(points, axis=0)
    if not (size > 0).all():  # what is flat lies on its face, or stands: who knows
        return False
    inside = (points - points.min(axis=0)) / size
    y, z = 1, 2
    base = np.log((_base(inside, y) + 0.02) / (_base(inside, z) + 0.02))
    asymmetry = np.log((_asymmetry(inside, y) + 0.1) / (_asymmetry(inside, z) + 0.1))
    return bool(base + 2 * asymmetry > CLEAR)


def _points(scene: Scene) -> NDArray[np.float64]:
    """Points on the scene's triangles, as many as each one's area deserves, (n, 3)."""
    corners = [np.empty((0, 3, 3))]
    for instance in scene.instances:
        assert isinstance(instance.shape, Mesh)
        corners.append(mapped(instance.transform, instance.shape.vertices)[instance.shape.triangles])
    a, b, c = np.concatenate(corners).transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    if not 0 < areas.sum() < np.inf:
        return np.empty((0, 3))
    random = np.random.Generator(np.random.Philox(0))
    chosen = random.choice(len(areas), POINTS, p=areas / areas.sum())
    u, v = random.random((2, POINTS, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    points: NDArray[np.float64] = a[chosen] + u * (b - a)[chosen] + v * (c - a)[chosen]
    return points


def _base(points: NDArray[np.float64], up: int) -> float:
    """How much of the box's floor the base takes, from points in the unit cube; less if the centre is not above it."""
    floor = [axis for axis in range(3) if axis != up]
    near = points[points[:, up] <= BASE][:, floor]
    low, high, centre = near.min(axis=0), near.max(axis=0), points.mean(axis=0)[floor]
    stands = bool(((low <= centre) & (centre <= high)).all())
    return float(np.prod(high - low)) * (1 if stands else 0.3)


def _asymmetry(points: NDArray[np.float64], axis: int) -> float:
    """How little the cells that a surface is in are those of its mirror image across an axis, 0..1."""
    is_there = np.zeros((CELLS,) * 3, bool)
    is_there[tuple(np.minimum((points * CELLS).astype(int), CELLS - 1).T)] = True
    mirrored = np.flip(is_there, axis)
    return float(1 - (is_there & mirrored).sum() / (is_there | mirrored).sum())
