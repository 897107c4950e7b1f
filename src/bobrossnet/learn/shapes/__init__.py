"""Procedural training shapes, each from a seed: meshes, implicit surfaces, carved solids, NURBS.

They replace real shapes, which are reserved for testing, and are as varied: organic and mechanical, simple and
intricate, smooth and hard-edged, solid and thin.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from bobrossnet.learn.shapes import carved, implicit, splines
from bobrossnet.learn.shapes.meshes import procedural_mesh
from bobrossnet.shapes.affine import rotation, scaling, to_unit_sphere, translation
from bobrossnet.support.errors import InputError
from bobrossnet.tracing.instance import Instance
from bobrossnet.tracing.scene import Scene, SceneLike

Family = Callable[[np.random.Generator], SceneLike]

KINDS: dict[str, tuple[float, Mapping[str, Family] | None]] = {
    "mesh": (0.5, None),  # `procedural_mesh` chooses its family, and assembles
    "implicit": (0.15, implicit.FAMILIES),
    "carved": (0.25, carved.FAMILIES),
    "nurbs": (0.1, splines.FAMILIES),
}
"""Weight and families of each kind; the families of a kind are equally likely."""

ALONE = 0.7  # probability that a shape other than a mesh is not part of an assembly


def procedural_scene(seed: int) -> Scene:
    """Return the shape of a seed, of any size and position. It is single, or an assembly of several of its kind.

    Parameters
    ----------
    seed : int of at least 0
    """
    rng = np.random.Generator(np.random.Philox(key=[seed, 0x5A4E]))
    kind = _some_kind(rng)
    if kind == "mesh":
        return Scene(procedural_mesh(seed))  # assembles itself
    first = _some_shape(rng, kind)
    if rng.random() < ALONE:
        return first
    return assembly(rng, first, int(rng.integers(1, 8)), lambda: _some_shape(rng, _some_kind(rng)))


def assembly(rng: np.random.Generator, first: Scene, count: int, another: Callable[[], Scene]) -> Scene:
    """Return a shape with `count` smaller ones of a few sorts, each placed on a random point of the previous ones."""
    instances = _fitted(first)
    sort: list[Instance] = []
    for _ in range(count):
        if not sort or rng.random() < 0.5:
            sort = _fitted(another())
        turn = rotation(float(rng.choice([0, np.pi / 2, rng.uniform(0, 6.3)])), rng.normal(size=3))
        stretch = scaling(rng.uniform(0.6, 1.2, 3) * rng.choice([0.2, 0.3, 0.45, 0.7]))
        place = translation(_some_place(rng, Scene(instances)))
        instances += [instance.transformed(place @ turn @ stretch) for instance in sort]
    return Scene(instances)


def _some_kind(rng: np.random.Generator) -> str:
    return str(rng.choice(list(KINDS), p=[chance for chance, _ in KINDS.values()]))


def _some_shape(rng: np.random.Generator, kind: str) -> Scene:
    _, families = KINDS[kind]
    if families is None:
        return Scene(procedural_mesh(int(rng.integers(2**31))))
    while True:
        shape = families[str(rng.choice(list(families)))](rng)
        with suppress(InputError):  # about one formula in a thousand is negative nowhere: draw another
            return Scene(shape)


def _fitted(scene: Scene) -> list[Instance]:
    """Return a scene's instances, scaled to the unit sphere."""
    matrix = to_unit_sphere(scene.center, scene.radius)
    return [instance.transformed(matrix) for instance in scene.instances]


def _some_place(rng: np.random.Generator, scene: Scene) -> NDArray[np.float64]:
    """Return the first hit of a random ray, or the centre if several rays miss."""
    origins = rng.normal(size=(16, 3))
    origins *= 2 * scene.radius / np.linalg.norm(origins, axis=1, keepdims=True)
    targets = rng.uniform(-0.7, 0.7, (16, 3)) * scene.radius
    directions = targets - origins
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    distance = scene.closest_hits(scene.center + origins, directions).distance
    hit = np.flatnonzero(np.isfinite(distance))
    if not len(hit):
        return scene.center
    place: NDArray[np.float64] = scene.center + origins[hit[0]] + distance[hit[0]] * directions[hit[0]]
    return place
