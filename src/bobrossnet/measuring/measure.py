"""Measures: sizes, areas and volumes of scenes and parts; radii, distances and angles of picked faces and points."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import overload

import numpy as np
from numpy.typing import NDArray

from bobrossnet.measuring.crossings import APART
from bobrossnet.measuring.picking import Pick, first_surface
from bobrossnet.measuring.surfaces import Surface, recognised
from bobrossnet.measuring.volumes import Amount, of_brep, of_shape, of_triangles, placed_brep
from bobrossnet.shapes.affine import Point, mapped
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.shapes.nurbs import Brep, Face
from bobrossnet.support.errors import InputError, InputTypeError
from bobrossnet.support.units import check_unit, factor
from bobrossnet.tracing.instance import primitive_count
from bobrossnet.tracing.parts import Part, Selected, extent_of, shape_of_primitives
from bobrossnet.tracing.scene import Scene, SceneLike, as_scene

BORDER_POINTS = 9
"""Points of each trim or border of a face, which say whether faces touch."""


@dataclass(frozen=True, eq=False)
class Measures:
    """Size, area and volume of a scene or a part."""

    name: str
    """Path of the part; empty for a scene."""
    low: Point
    """(3,) of the smallest box along the axes."""
    high: Point
    """(3,)"""
    area: float
    """Area of all surfaces, in squares of the unit."""
    volume: float | None
    """Volume in cubes of the unit; None unless all surfaces are closed. Where parts overlap, both count."""
    error: float
    """Estimated relative error of area and volume."""
    unit: str | None
    """None where the file does not say."""
    parts: tuple[Measures, ...] = ()
    """The parts with surfaces, in the sequence of the tree, without parts that only group others."""

    @property
    def size(self) -> Point:
        """(3,): lengths of the box's sides."""
        return self.high - self.low

    @property
    def is_closed(self) -> bool:
        """Whether there is a volume."""
        return self.volume is not None

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        square, cube = (f" {self.unit}{power}" if self.unit else "" for power in "²³")
        size = " x ".join(f"{side:.6g}" for side in self.size)
        volume = "open" if self.volume is None else f"volume {self.volume:.7g}{cube}"
        return f"{size}{unit}, area {self.area:.7g}{square}, {volume}"


@dataclass(frozen=True, eq=False)
class FaceMeasures:
    """The face at a pick."""

    kind: str
    """plane (also of a cap), cylinder, sphere, cone, torus or freeform; triangle of a mesh; else the shape's kind."""
    point: Point
    """(3,), as picked."""
    normal: Point
    """(3,)"""
    radius: float | None
    """Radius of a cylinder, a sphere or a torus' tube; of a cone, at the point."""
    major_radius: float | None
    """Radius of a torus' centre line."""
    half_angle: float | None
    """Half the angle of a cone, in degrees."""
    center: Point | None
    """(3,) of a sphere or torus, a cone's apex, or a point of a cylinder's axis."""
    axis: Point | None
    """(3,) unit vector of a cylinder, cone or torus; a plane's normal."""
    area: float | None
    """Area of the face, in squares of the unit, with the neighbours that continue a cylinder, cone, sphere or torus."""
    thickness: float | None
    """Length from the point to the next surface, along the normal into the shape; None without a second surface, and
    for a snapped point."""
    thickness_along_ray: float | None
    """The same along the line of sight."""
    unit: str | None


@dataclass(frozen=True, eq=False)
class Between:
    """Two picks."""

    distance: float
    """Distance of the points."""
    offset: Point
    """(3,): from the first to the second."""
    angle: float
    """Between the normals, in degrees: 0 where faces look the same way, 180 where they look at each other."""
    gap: float | None
    """Between the planes or the axes of two faces, if these are parallel."""
    unit: str | None
    ends: tuple[str, str]
    """The two points in words, such as "corner" or "centre of a circle, radius 4 mm"; "point" if not snapped."""


@overload
def measure(what: Pick, other: Pick, *, unit: str | None = None) -> Between: ...
@overload
def measure(what: Pick, other: None = None, *, unit: str | None = None) -> FaceMeasures: ...
@overload
def measure(what: Part | SceneLike, other: None = None, *, unit: str | None = None) -> Measures: ...
def measure(
    what: Part | Pick | SceneLike, other: Pick | None = None, *, unit: str | None = None
) -> Measures | FaceMeasures | Between:
    """Measure a scene, a part, a face, or the distance between two points.

    Meshes and the faces of NURBS are measured exactly: by sums over triangles and integrals over trimmed faces. The
    area and volume of formulas and tubes are estimated from three meshes, with the error `Measures.error`.

    Parameters
    ----------
    what : Scene, Shape, Part, path or Pick
        A `Pick` comes from `pick` or `View.pick`.
    other : Pick, optional
        A second pick of the same scene.
    unit : str, optional
        A unit such as "mm" or "in" to convert lengths to; by default the scene's own.

    Returns
    -------
    Measures of a scene or part, FaceMeasures of a pick, Between of two

    Raises
    ------
    InputError
        If the unit is unknown, or `unit` is given for a scene without a unit.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> corners = [(0, 0, 0), (3, 0, 0), (0, 4, 0), (0, 0, 5)]
    >>> wedge = bob.Mesh(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
    >>> print(bob.measure(bob.Scene(wedge, unit="mm")))
    3 x 4 x 5 mm, area 37.36542 mm², volume 10 mm³
    """
    check_unit("unit", unit)
    if other is not None and not (isinstance(what, Pick) and isinstance(other, Pick)):
        raise InputTypeError(f"other: expected two picks, got {type(what).__name__} and {type(other).__name__}")
    if isinstance(what, Pick):
        scale = 1.0 if unit is None else factor(what.unit, unit)
        unit = unit or what.unit
        if other is None:
            return _of_face(what, scale, unit)
        if other.scene is not what.scene:
            raise InputError("other: expected a pick of the same scene, got one of another")
        return _between(what, other, scale, unit)
    if isinstance(what, Part):
        scene, root = what.scene, what
        assert isinstance(scene, Scene)
    else:
        scene = as_scene(what)
        root = scene.parts
    if unit is not None and unit != scene.unit:
        path, scene = root.path, scene.converted(unit)
        root = scene.part(path) if path else scene.parts
    return _of_part(scene, root)


# ---- Scenes and parts ------------------------------------------------------------------------------------


def _of_part(scene: Scene, root: Part) -> Measures:
    parts = []
    cache: dict[int, Amount] = {}
    for part in (root, *root.walk()):
        if part.own:
            amount = amount_of(scene, part.own, cache)
            parts.append(_measures(scene, str(part), part.own, amount))
    if len(parts) == 1:
        return replace(parts[0], name=str(root), parts=tuple(parts) if not root.path else ())
    volumes = [part.volume for part in parts]
    volume = None if None in volumes else float(sum(filter(None, volumes)))
    error = max(part.error for part in parts)
    if volume is None and all(isinstance(scene.instances[own.instance].shape, Mesh) for own in root.selected):
        volume = _absolute(amount_of_meshes(scene, root.selected).volume)  # parts may close each other
    total = Amount(sum(part.area for part in parts), volume, error)
    return replace(_measures(scene, str(root), root.selected, total), parts=tuple(parts))


def _measures(scene: Scene, name: str, selected: Iterable[Selected], amount: Amount) -> Measures:
    low, high = extent_of(scene, selected)
    return Measures(name, low, high, amount.area, _absolute(amount.volume), amount.error, scene.unit)


def _absolute(volume: float | None) -> float | None:
    return None if volume is None else abs(volume)


def amount_of(scene: Scene, own: tuple[Selected, ...], cache: dict[int, Amount]) -> Amount:
    """Return the area and volume, not signed, of a part's own primitives. `cache` has the results of whole shapes."""
    meshes = tuple(each for each in own if isinstance(scene.instances[each.instance].shape, Mesh))
    found = [amount_of_meshes(scene, meshes)] if meshes else []
    for number, start, stop in own:
        instance = scene.instances[number]
        shape, matrix = instance.shape, instance.transform
        if isinstance(shape, Brep):
            if stop - start < primitive_count(shape):
                shape = shape_of_primitives(shape, np.arange(start, stop))
                assert isinstance(shape, Brep)
            placed, scale = placed_brep(shape, matrix)
            amount = cache.get(id(placed)) if placed is instance.shape else None
            amount = amount or of_brep(placed)
            if placed is instance.shape:
                cache[id(placed)] = amount
            volume = None if amount.volume is None else scale**3 * amount.volume
            found.append(Amount(scale**2 * amount.area, volume, amount.error))
        elif not isinstance(shape, Mesh):
            found.append(of_shape(shape, matrix))
    volumes = [_absolute(each.volume) for each in found]
    total = None if None in volumes else float(sum(filter(None, volumes)))
    return Amount(sum(each.area for each in found), total, max(each.error for each in found))


def amount_of_meshes(scene: Scene, own: tuple[Selected, ...]) -> Amount:
    """Return the area and signed volume of triangles, which may close each other."""
    return of_triangles(*triangles_of(scene, own))


def triangles_of(scene: Scene, own: Iterable[Selected]) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return vertices and triangles of meshes' primitives in the scene, with their normals outwards."""
    vertices, triangles, count = [], [], 0
    for number, start, stop in own:
        instance = scene.instances[number]
        mesh, matrix = instance.shape, instance.transform
        assert isinstance(mesh, Mesh)
        used, corners = np.unique(mesh.triangles[start:stop], return_inverse=True)
        vertices.append(mapped(matrix, mesh.vertices[used]))
        corners = corners.reshape(-1, 3) + count
        triangles.append(corners[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else corners)
        count += len(used)
    return np.concatenate(vertices), np.concatenate(triangles).astype(np.int32)


# ---- Picks -----------------------------------------------------------------------------------------------


def _of_face(pick: Pick, scale: float, unit: str | None) -> FaceMeasures:
    instance = pick.scene.instances[pick.instance]
    shape = instance.shape
    surface, area = Surface("triangle" if isinstance(shape, Mesh) else shape.kind), None
    if pick.section is not None:
        surface = _surface_of(pick)
    elif isinstance(shape, Brep):
        assert pick.face is not None
        surface = recognised(shape.faces[pick.face], instance.transform)
        area = _area(pick, shape, surface)
    elif isinstance(shape, Mesh):
        corners = mapped(instance.transform, shape.vertices[shape.triangles[pick.face]])
        area = float(np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])) / 2)
    radius = surface.radius
    if surface.kind == "cone":
        assert surface.center is not None
        assert surface.axis is not None
        radius = float(np.linalg.norm(np.cross(pick.point - surface.center, surface.axis)))

    def scaled(length: float | None, power: int = 1) -> float | None:
        return None if length is None else scale**power * length

    return FaceMeasures(
        surface.kind,
        scale * pick.point,
        pick.normal,
        scaled(radius),
        scaled(surface.major_radius),
        surface.half_angle,
        None if surface.center is None or surface.kind == "plane" else scale * surface.center,
        surface.axis,
        scaled(area, 2),
        scaled(_thickness(pick, -pick.normal)),
        scaled(_thickness(pick, pick.direction)),
        unit,
    )


def _thickness(pick: Pick, direction: Point) -> float | None:
    """Return the length from a pick through the shape to the next surface of its scene; None from a snapped point."""
    if pick.snapped is not None:
        return None
    step = APART * pick.scene.radius
    found = first_surface(pick.scene, pick.point + step * direction, direction)
    return None if found is None else float(np.linalg.norm(found.point - pick.point))


def _area(pick: Pick, shape: Brep, surface: Surface) -> float:
    """Return the area of a face and of the faces that continue its surface: readers cut closed surfaces in two."""
    assert pick.face is not None
    matrix = pick.scene.instances[pick.instance].transform
    placed, scale = placed_brep(shape, matrix)
    chosen = {pick.face}
    if surface.kind not in ("plane", "freeform"):
        size = pick.scene.radius
        alike = [i for i, face in enumerate(shape.faces) if recognised(face, matrix).same_as(surface, size)]
        borders = {i: _border(shape.faces[i]) for i in alike}
        waiting = [pick.face]
        while waiting:
            own = borders[waiting.pop()]
            touching = [i for i in alike if i not in chosen and _touch(own, borders[i])]
            chosen.update(touching)
            waiting += touching
    return scale**2 * float(placed.moments[sorted(chosen), 0].sum())


def _border(face: Face) -> NDArray[np.float64]:
    """Return points of a face's border, (n, 3): many more along trims of many spans."""
    (u0, u1), (v0, v1) = face.domain
    t = np.linspace(0, 1, BORDER_POINTS)
    if not face.trims:
        zero = np.zeros_like(t)
        u, v = np.concatenate([t, t, zero, zero + 1]), np.concatenate([zero, zero + 1, t, t])
        return face.points(u0 + u * (u1 - u0), v0 + v * (v1 - v0))
    ends = np.concatenate([curve.control_points for loop in face.trims for curve in loop])
    return face.points(np.clip(ends[:, 0], u0, u1), np.clip(ends[:, 1], v0, v1))


def _touch(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    """Whether at least two points of two borders are common."""
    near = 1e-5 * float(np.ptp(np.concatenate([a, b]), axis=0).max())
    distances = np.linalg.norm(a[:, None] - b[None], axis=2)
    return int((distances.min(axis=1) <= near).sum()) >= 2


def _between(a: Pick, b: Pick, scale: float, unit: str | None) -> Between:
    offset = b.point - a.point
    angle = float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a.normal, b.normal)), a.normal @ b.normal)))
    gap = _gap(*(_surface_of(pick) for pick in (a, b)))
    return Between(
        scale * float(np.linalg.norm(offset)),
        scale * offset,
        angle,
        None if gap is None else scale * gap,
        unit,
        (_said(a, scale, unit), _said(b, scale, unit)),
    )


def _said(pick: Pick, scale: float, unit: str | None) -> str:
    """Name the feature that a pick snapped to."""
    if pick.radius is not None:
        what = "centre" if pick.snapped == "center" else "edge"
        return f"{what} of a circle, radius {scale * pick.radius:.6g}{f' {unit}' if unit else ''}"
    words = {None: "point", "middle": "middle of an edge", "center": "centre of a circle"}
    return words.get(pick.snapped, str(pick.snapped))


def _surface_of(pick: Pick) -> Surface:
    instance = pick.scene.instances[pick.instance]
    if pick.section is not None or isinstance(instance.shape, Mesh):
        return Surface("plane", pick.point, pick.normal)
    if not isinstance(instance.shape, Brep):
        return Surface("freeform")
    assert pick.face is not None
    return recognised(instance.shape.faces[pick.face], instance.transform)


def _gap(a: Surface, b: Surface) -> float | None:
    """Return the distance of parallel planes or axes, or of an axis to a parallel plane."""
    if a.axis is None or b.axis is None or a.center is None or b.center is None:
        return None
    across = float(np.linalg.norm(np.cross(a.axis, b.axis)))
    offset = b.center - a.center
    planes = [axis for axis, kind in ((a.axis, a.kind), (b.axis, b.kind)) if kind == "plane"]
    if len(planes) == 1:  # an axis along the plane
        return abs(float(offset @ planes[0])) if abs(float(a.axis @ b.axis)) < 1e-6 else None
    if across > 1e-6:
        return None
    along = float(offset @ a.axis)
    return abs(along) if planes else float(np.linalg.norm(offset - along * a.axis))
