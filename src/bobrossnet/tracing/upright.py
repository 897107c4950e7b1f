"""Guess of the up axis of meshes from files that store y up without a declaration."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet.shapes.affine import mapped
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.tracing.scene import Scene

POINTS = 50_000
"""Number of random points on the surfaces."""

BASE = 0.02
"""Thickness of the base, as a share of the height: lower points touch the ground."""

CELLS = 16
"""Cells of the bounding box along each axis, for the symmetry measure."""

CLEAR = 0.5
"""Threshold on the log ratio of the two axes' scores.

Of 96 files with an obvious up axis, it finds 63 of the 76 that lie and misjudges no other; of 32 machine parts,
which have no up axis, it takes 7 for lying.
"""


def seems_to_lie(scene: Scene) -> bool:
    """Return whether y is more likely the up axis than z.

    Objects stand on a wide base below their centre, and are less symmetric between up and down than between left and
    right or front and back (after Fu, Cohen-Or, Dror and Sheffer, *Upright orientation of man-made objects*, 2008).

    Parameters
    ----------
    scene : Scene
        Scenes with other shapes than meshes give False.

    Returns
    -------
    bool
        True only if the evidence is clear.
    """
    if not all(isinstance(instance.shape, Mesh) for instance in scene.instances):
        return False
    points = _points(scene)
    if len(points) == 0:
        return False
    size = np.ptp(points, axis=0)
    if not (size > 0).all():  # flat: it may lie or stand
        return False
    inside = (points - points.min(axis=0)) / size
    y, z = 1, 2
    base = np.log((_base(inside, y) + 0.02) / (_base(inside, z) + 0.02))
    asymmetry = np.log((_asymmetry(inside, y) + 0.1) / (_asymmetry(inside, z) + 0.1))
    return bool(base + 2 * asymmetry > CLEAR)


def _points(scene: Scene) -> NDArray[np.float64]:
    """Return random points on the scene's triangles, uniform by area, (n, 3)."""
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
    """Return the base's share of the box's floor, for points in the unit cube; less for a centre off the base."""
    floor = [axis for axis in range(3) if axis != up]
    near = points[points[:, up] <= BASE][:, floor]
    low, high, centre = near.min(axis=0), near.max(axis=0), points.mean(axis=0)[floor]
    stands = bool(((low <= centre) & (centre <= high)).all())
    return float(np.prod(high - low)) * (1 if stands else 0.3)


def _asymmetry(points: NDArray[np.float64], axis: int) -> float:
    """Return 1 - IoU of the occupied cells and their mirror image across an axis, 0..1."""
    is_there = np.zeros((CELLS,) * 3, bool)
    is_there[tuple(np.minimum((points * CELLS).astype(int), CELLS - 1).T)] = True
    mirrored = np.flip(is_there, axis)
    return float(1 - (is_there & mirrored).sum() / (is_there | mirrored).sum())
