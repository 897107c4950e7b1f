"""Colours for the training shapes, each from a seed: materials, parts, vertex colours, textures, formulas.

Solid patterns are functions of x, y and z in the shape's unit sphere, of numbers or symbols, so that vertices and
formulas share them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from bobrossnet.color import from_srgb
from bobrossnet.learn.shapes import procedural_scene
from bobrossnet.learn.shapes.meshes.parts import Array, Rng, random_rotation
from bobrossnet.learn.shapes.textures import palette, some_color, some_texture
from bobrossnet.sdf.symbols import color_formula_of
from bobrossnet.shapes.implicit import Implicit
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.shapes.nurbs import Brep, Face
from bobrossnet.shapes.shape import Shape
from bobrossnet.tracing.instance import Instance
from bobrossnet.tracing.material import Material
from bobrossnet.tracing.scene import Scene

Pattern = Callable[[Any, Any, Any], tuple[Any, Any, Any]]
"""Maps x, y and z to linear RGB."""

Look = Callable[[Rng, Scene], Scene]
"""Recolours the shapes of a scene."""


def colored_scene(seed: int) -> Scene:
    """Return the shape of a seed, `procedural_scene`, in the seed's colours; a quarter of the shapes are white.

    Parameters
    ----------
    seed : int of at least 0
    """
    rng = _generator(seed)
    return _some_look(rng)(rng, procedural_scene(seed))


def is_white(seed: int) -> bool:
    """Return whether `colored_scene` leaves the shape of a seed white."""
    return _some_look(_generator(seed)) is white


def _generator(seed: int) -> Rng:
    return np.random.Generator(np.random.Philox(key=[seed, 0xC0105]))


def _some_look(rng: Rng) -> Look:
    return list(LOOKS)[rng.choice(len(LOOKS), p=list(LOOKS.values()))]


# ---- looks ------------------------------------------------------------------------------------------------------


def white(rng: Rng, scene: Scene) -> Scene:
    """Leave the scene unchanged."""
    return scene


def material(rng: Rng, scene: Scene) -> Scene:
    """Give every shape the same material."""
    one = some_material(rng)
    return Scene(replaced(instance, instance.shape, one) for instance in scene.instances)


def parts(rng: Rng, scene: Scene) -> Scene:
    """Colour each shape, connected part of a mesh and face of a brep by one of a few colours; formulas in patches."""
    colors = from_srgb(palette(rng, int(rng.integers(2, 7))))
    return _each_shape(rng, scene, lambda shape: _in_parts(rng, shape, colors))


def patterns(rng: Rng, scene: Scene) -> Scene:
    """Apply a solid pattern of stains, stripes or patches at mesh vertices and at every point of formulas."""
    return _each_shape(rng, scene, lambda shape: _with_pattern(rng, shape))


def textured(rng: Rng, scene: Scene) -> Scene:
    """Project a texture on meshes; give formulas a solid pattern."""
    texture = some_texture(rng)

    def look(shape: Shape) -> Shape:
        return with_texture(rng, shape, texture) if isinstance(shape, Mesh) else _with_pattern(rng, shape)

    return _each_shape(rng, scene, look)


LOOKS: dict[Look, float] = {
    white: 0.25,
    material: 0.13,
    parts: 0.14,
    patterns: 0.18,
    textured: 0.3,
}
"""Weight of each look. A seed's colours depend on every entry and on their order."""


def some_material(rng: Rng, plain: bool = False) -> Material:
    """Return a material of either model; a `plain` one leaves the shape's colours unchanged."""
    color = tuple(from_srgb(np.ones(3) if plain else some_color(rng)).tolist())
    if rng.random() < 0.5:
        ambient, specular = rng.uniform(0.05, 0.3), rng.uniform(0, 0.5)
        diffuse = rng.uniform(0.6, 1) - ambient
        return Material(color, ambient, diffuse, specular, float(np.exp(rng.uniform(np.log(4), np.log(200)))))
    metallic = 0.0 if plain or rng.random() < 0.6 else rng.uniform(0.5, 1)
    return Material(color, metallic=metallic, roughness=rng.uniform(0.15, 1))


def replaced(instance: Instance, shape: Shape, one: Material) -> Instance:
    """Return the instance with another shape and another material."""
    return Instance(shape, instance.transform, one, instance.name)


def _each_shape(rng: Rng, scene: Scene, look: Callable[[Shape], Shape]) -> Scene:
    """Apply the look to every shape once, shared by its instances, with a plain material."""
    seen: dict[int, Shape] = {}
    plain = some_material(rng, plain=True) if rng.random() < 0.6 else Material()
    for instance in scene.instances:
        if id(instance.shape) not in seen:
            seen[id(instance.shape)] = look(instance.shape)
    shapes = [seen[id(instance.shape)] for instance in scene.instances]
    # Tubes can't have colours; they get a coloured material.
    materials = [plain if shape.is_colored else some_material(rng) for shape in shapes]
    return Scene(map(replaced, scene.instances, shapes, materials))


def _in_parts(rng: Rng, shape: Shape, colors: Array) -> Shape:
    if isinstance(shape, Mesh):
        of_face = _parts_of(shape)
        chosen = colors[rng.integers(len(colors), size=of_face.max() + 1)]
        return Mesh(shape.vertices, shape.triangles, shape.normals, face_colors=chosen[of_face])
    if isinstance(shape, Brep):
        chosen = colors[rng.integers(len(colors), size=len(shape.faces))]
        painted = [_colored(face, color) for face, color in zip(shape.faces, chosen, strict=True)]
        return Brep(painted, shape.tolerance, shape.face_numbers)
    if isinstance(shape, Implicit):
        return _painted(shape, patches(rng, colors))
    return shape


def _with_pattern(rng: Rng, shape: Shape) -> Shape:
    if isinstance(shape, Mesh):
        scene = Scene(shape)
        x, y, z = ((shape.vertices - scene.center) / scene.radius).T
        values = np.stack(np.broadcast_arrays(*some_pattern(rng, most=14)(x, y, z), x)[:3], -1)
        return Mesh(shape.vertices, shape.triangles, shape.normals, colors=np.clip(values, 0, 1))
    if isinstance(shape, Implicit):
        return _painted(shape, some_pattern(rng, most=40))
    return _in_parts(rng, shape, from_srgb(palette(rng, 4)))


# ---- patterns in space ------------------------------------------------------------------------------------------


def some_pattern(rng: Rng, most: float) -> Pattern:
    """Return a pattern of up to `most` radians a unit: further colours blended in one after another."""
    colors = from_srgb(palette(rng, 3))
    shares = [_some_share(rng, most) for _ in range(1 + int(rng.integers(2)))]

    def pattern(x: Any, y: Any, z: Any) -> tuple[Any, Any, Any]:
        rgb: list[Any] = list(colors[0])
        for share, color in zip(shares, colors[1:], strict=False):
            amount = share(x, y, z)
            rgb = [before + amount * (after - before) for before, after in zip(rgb, color, strict=True)]
        return rgb[0], rgb[1], rgb[2]

    return pattern


def patches(rng: Rng, colors: Array) -> Pattern:
    """Return a pattern of hard patches: colours separated by wavy surfaces."""
    shares = [_waves(rng, float(rng.uniform(1, 6))) for _ in colors[1:]]

    def pattern(x: Any, y: Any, z: Any) -> tuple[Any, Any, Any]:
        rgb: list[Any] = list(colors[0])
        for share, color in zip(shares, colors[1:], strict=True):
            amount = np.where(share(x, y, z) > 0.3, 1.0, 0.0)
            rgb = [before + amount * (after - before) for before, after in zip(rgb, color, strict=True)]
        return rgb[0], rgb[1], rgb[2]

    return pattern


def _some_share(rng: Rng, most: float) -> Callable[[Any, Any, Any], Any]:
    """Return a blend weight, 0..1: stripes, rings, checks or stains, soft or hard."""
    frequency = float(np.exp(rng.uniform(np.log(2), np.log(most))))
    kind, hard, level = int(rng.integers(4)), rng.random() < 0.5, float(rng.uniform(-0.4, 0.4))
    turn, phase = random_rotation(rng), rng.uniform(0, 6.3, 3)
    waves = _waves(rng, frequency)

    def share(x: Any, y: Any, z: Any) -> Any:
        along = [row[0] * x + row[1] * y + row[2] * z for row in turn.tolist()]
        if kind == 0:
            height = np.sin(frequency * along[0] + phase[0])
        elif kind == 1:
            height = np.sin(frequency * np.sqrt(along[0] * along[0] + along[1] * along[1]) + phase[0])
        elif kind == 2:
            height = np.sin(frequency * along[0] + phase[0]) * np.sin(frequency * along[1] + phase[1])
            height = height * np.sin(frequency * along[2] + phase[2])
        else:
            height = waves(x, y, z)
        return np.where(height > level, 1.0, 0.0) if hard else 0.5 + 0.5 * np.sin(1.5 * height)

    return share


def _waves(rng: Rng, frequency: float) -> Callable[[Any, Any, Any], Any]:
    """Return smooth noise of about unit variance: a sum of a few plane waves."""
    count = 5
    directions = (frequency / np.sqrt(3) * rng.normal(size=(count, 3))).tolist()
    phases = rng.uniform(0, 6.3, count).tolist()

    def waves(x: Any, y: Any, z: Any) -> Any:
        total: Any = 0.0
        for (a, b, c), phase in zip(directions, phases, strict=True):
            total = total + np.sin(a * x + b * y + c * z + phase)
        return total * float(np.sqrt(2 / count))

    return waves


def _painted(shape: Implicit, pattern: Pattern) -> Implicit:
    scene = Scene(shape)
    (x0, y0, z0), radius = scene.center.tolist(), scene.radius
    formula = color_formula_of(lambda x, y, z: pattern((x - x0) / radius, (y - y0) / radius, (z - z0) / radius))
    return Implicit(shape.expression, shape.bounds, formula)


# ---- meshes and breps -------------------------------------------------------------------------------------------


def with_texture(rng: Rng, mesh: Mesh, texture: NDArray[np.uint8]) -> Mesh:
    """Return the mesh with a texture, projected by planes along three axes, a cylinder around one, or one plane."""
    scene = Scene(mesh)
    turn = random_rotation(rng) if rng.random() < 0.3 else np.eye(3)[rng.permutation(3)]
    repeats = float(np.exp(rng.uniform(np.log(0.4), np.log(3))))  # of the texture in a radius
    kind = int(rng.choice(3, p=[0.5, 0.25, 0.25]))
    offset = rng.uniform(0, 1, (3, 2))
    points = ((mesh.vertices - scene.center) / scene.radius) @ turn.T
    corners = points[mesh.triangles]  # (T, 3, 3)
    if kind == 0:
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        axis = np.argmax(np.abs(normal), -1)[:, None]
        uv = np.stack([np.take_along_axis(corners, (axis + i)[..., None] % 3, -1)[..., 0] for i in (1, 2)], -1)
        uv = repeats * uv + offset[axis]
    elif kind == 1:
        angle = np.arctan2(corners[..., 1], corners[..., 0]) / (2 * np.pi)
        angle -= np.rint(angle - angle[:, :1])  # no triangle wraps around the seam
        uv = np.stack([max(round(6 * repeats), 1) * angle, repeats * corners[..., 2]], -1) + offset[0]
    else:
        uv = repeats * corners[..., :2] + offset[0]
    # A vertex is repeated for each texture coordinate that its triangles give it.
    keys = np.concatenate([mesh.triangles[..., None], np.rint(uv * 65536).astype(np.int64)], -1).reshape(-1, 3)
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    vertex = mesh.triangles.ravel()[first]
    normals = None if mesh.normals is None else mesh.normals[vertex]
    places = uv.reshape(-1, 2)[first]
    return Mesh(mesh.vertices[vertex], inverse.reshape(-1, 3), normals, uv=places, texture=texture)


def _parts_of(mesh: Mesh) -> NDArray[np.int64]:
    """Return each triangle's connected part, (T,); vertices at equal positions are connected."""
    places, place = np.unique(mesh.vertices, axis=0, return_inverse=True)
    triangles, count = place.reshape(-1)[mesh.triangles], len(places)
    ends = np.concatenate([triangles[:, :2], triangles[:, 1:]])
    edges = coo_array((np.ones(len(ends), np.int8), (ends[:, 0], ends[:, 1])), shape=(count, count))
    _, labels = connected_components(edges, directed=False)
    return np.asarray(labels[triangles[:, 0]], np.int64)


def _colored(face: Face, color: Array) -> Face:
    return Face(face.control_points, face.knots_u, face.knots_v, face.weights, face.trims, color=tuple(color.tolist()))
