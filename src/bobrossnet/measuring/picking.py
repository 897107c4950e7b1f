"""Picking: the part, face, point and normal at a pixel of a picture."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.picture.camera import Camera, CameraLike, as_camera
from bobrossnet.picture.channels import Layout
from bobrossnet.picture.order import Size, SizeLike, check_size
from bobrossnet.shapes.affine import Point, mapped
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.shapes.nurbs import Brep
from bobrossnet.support.errors import check_integer, check_number
from bobrossnet.tracing.parts import Part, part_at
from bobrossnet.tracing.pixels import pixel_rays
from bobrossnet.tracing.scene import Scene, SceneLike, as_scene
from bobrossnet.tracing.trace import SceneTracer


@dataclass(frozen=True, eq=False)
class Pick:
    """The surface at a pixel. `measure` takes one or two of these."""

    part: Part
    instance: int
    """Index into `Scene.instances`."""
    face: int | None
    """Number of the shape's triangle or face; None for other shapes and for caps of sections."""
    point: Point
    """(3,) in the scene's unit: exactly on a triangle or face, elsewhere to a millionth of the scene."""
    normal: Point
    """(3,) unit vector of the triangle or face, on the camera's side."""
    parameters: tuple[float, float]
    """(u, v) on the face; barycentric weights of a triangle's first and second corner."""
    direction: Point
    """(3,) unit vector along the line of sight, away from the camera."""
    unit: str | None
    """The scene's."""
    scene: Scene = field(repr=False)
    section: int | None = None
    """Index into `Scene.section` if the point is on a cap."""
    snapped: str | None = None
    """corner, middle (of an edge), center (of a circle) or edge, if the point was snapped to one."""
    radius: float | None = None
    """Radius of the circle whose centre or edge the point was snapped to."""


def pick(
    scene: SceneLike,
    row: int,
    column: int,
    camera: CameraLike | None = None,
    *,
    size: SizeLike = (480, 640),
    snap: float = 0,
) -> Pick | None:
    """Return the surface that a camera sees at the centre of a pixel; None on the background.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these
    row, column : int
        Pixel, from the picture's top left.
    camera, size
        As of the picture.
    snap : float
        Pixels within which the point snaps to a visible corner, the middle of an edge, the centre of a circular edge
        or of a tube's round end, or else to the nearest edge. Edges are borders of NURBS faces, and creases and open
        borders of meshes; formulas and caps of sections have none. The face is one next to the edge.

    Raises
    ------
    InputError
        If there is no such pixel, or snap is below 0.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> found = bob.pick(bob.happy_tree(), 40, 60, size=(90, 120))
    >>> found.part.name, found.unit
    ('mesh', None)
    """
    scene = as_scene(scene)
    camera = as_camera(camera, scene)
    height, width = check_size(size)
    row, column = check_integer("row", row, 0, height - 1), check_integer("column", column, 0, width - 1)
    reach = check_number("snap", snap, 0, max(height, width))
    found = _snapped(scene, camera, row, column, (height, width), reach) if reach > 0 else None
    if found is not None:
        return found
    pixel = np.array([[row, column]], np.int32)
    _, origins, directions = pixel_rays(camera, scene.center, scene.radius, (height, width), pixel)
    if not len(origins):  # a ray that passes the bounding sphere
        return None
    direction = directions[0] / np.linalg.norm(directions[0])
    found = first_surface(scene, origins[0], direction)
    if found is None or found.normal.any():
        return found
    # Only the tracer has normals of these shapes, in screen space.
    x, y = SceneTracer(scene, camera, (height, width), Layout("mask,normal"))(pixel).values[0, 1:3]
    on_screen = np.array([[x, y, np.sqrt(max(1 - x * x - y * y, 0))]], np.float32)
    core = camera.core(scene.center, scene.radius)
    normal = core.in_scene(height, width, on_screen, pixel.astype(np.float32))[0].astype(np.float64)
    return replace(found, normal=_unit(normal))


def _snapped(scene: Scene, camera: Camera, row: int, column: int, size: Size, reach: float) -> Pick | None:
    core = camera.core(scene.center, scene.radius)
    snapped = _core.snap(scene.core, core, *size, row, column, reach)
    if snapped is None:
        return None
    kind, point, radius, origin, direction = snapped
    found = first_surface(scene, np.array(origin) * scene.radius + scene.center, _unit(np.array(direction)))
    if found is None:
        return None
    place = scene.center + scene.radius * np.array(point)
    return replace(found, point=place, snapped=kind, radius=None if radius is None else radius * scene.radius)


def first_surface(scene: Scene, origin: Point, direction: Point) -> Pick | None:
    """Return the first surface along a ray; its normal is 0 where only a tracer has it."""
    hits = scene.closest_hits(origin[None], direction[None])
    number = int(hits.instance[0])
    if number < 0:
        return None
    primitive, parameters = int(hits.primitive[0]), (float(hits.u[0]), float(hits.v[0]))
    section = -2 - primitive if primitive < -1 else None
    if section is not None:
        point, normal = None, np.array(scene.section[section].normal)
    else:
        point, normal = surface_at(scene, number, primitive, parameters)
    if point is None:
        point = origin + hits.distance[0] * direction
    if normal @ direction > 0:
        normal = -normal
    shape = scene.instances[number].shape
    face = primitive if isinstance(shape, Mesh | Brep) and section is None else None
    part = part_at(scene, number, primitive if face is not None else 0)
    return Pick(part, number, face, point, normal, parameters, direction, scene.unit, scene, section)


def surface_at(
    scene: Scene, number: int, primitive: int, parameters: tuple[float, float]
) -> tuple[Point | None, Point]:
    """Return the point of a triangle or face in the scene, and its unit normal; None and 0 for other shapes."""
    instance = scene.instances[number]
    matrix, shape = instance.transform, instance.shape
    u, v = parameters
    if isinstance(shape, Mesh):
        corners = mapped(matrix, shape.vertices[shape.triangles[primitive]])
        point = np.array([u, v, 1 - u - v]) @ corners
        return point, _unit(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
    if isinstance(shape, Brep):
        face = shape.faces[primitive]
        (u0, u1), (v0, v1) = face.domain
        u, v = min(max(u, u0), u1), min(max(v, v0), v1)
        by = face.derivatives(u, v, 1)
        across = by[1, 0] @ matrix[:3, :3].T, by[0, 1] @ matrix[:3, :3].T
        return mapped(matrix, by[0, 0][None])[0], _unit(np.cross(*across))
    return None, np.zeros(3)


def _unit(vector: NDArray[np.float64]) -> Point:
    length = np.linalg.norm(vector)
    result: Point = vector / length if length > 0 else np.zeros(3)
    return result
