"""Scenes: instances of shapes and their bounding sphere."""

from __future__ import annotations

import os
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from itertools import islice
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import Color
from bobrossnet.shapes.affine import TURNS, Point, mapped
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.shapes.nurbs import Brep
from bobrossnet.shapes.shape import Shape
from bobrossnet.support.errors import (
    InputError,
    InputTypeError,
    InputWarning,
    check_array,
    check_choice,
    check_finite,
    check_flag,
    check_number,
    each_of,
)
from bobrossnet.support.messages import counted
from bobrossnet.support.threads import lazy
from bobrossnet.support.units import check_unit
from bobrossnet.support.units import factor as unit_factor
from bobrossnet.tracing.instance import Instance, Piece, primitive_count
from bobrossnet.tracing.light import LightLike, check_light
from bobrossnet.tracing.parts import (
    HIGHLIGHT,
    Extent,
    Part,
    PartLike,
    Selected,
    colored,
    exploded,
    extent_of,
    find_part,
    only,
    tree_of,
    without,
)
from bobrossnet.tracing.section import Section, SectionLike, check_sections

MAX_INSTANCES = _core.MAX_INSTANCES
"""Maximum number of instances: files and pages can hold them, and placing them takes seconds."""


class Hits(NamedTuple):
    """Intersections of n rays with a scene."""

    distance: NDArray[np.float64]
    """(n,) distance from the origin, in the scene's units; inf for a miss."""
    instance: NDArray[np.int32]
    """(n,) index into `Scene.instances`; -1 for a miss."""
    primitive: NDArray[np.int32]
    """(n,) primitive of the shape, such as a mesh's triangle or a brep's face; -1 for a miss, -2 - i on the cap of
    section i."""
    u: NDArray[np.float64]
    """(n,) parametric position on the primitive, together with v; 0 for a miss or on a cap.

    Parameters of a face; the parameter of a tube, and 0; barycentric weights of a triangle's first and second corner.
    """
    v: NDArray[np.float64]


class Scene:
    """Shapes in one space, with their placements and materials, and the bounding sphere that cameras orbit.

    The sphere is centred on the axis-aligned bounding box and reaches to the farthest point of a shape. Pictures do
    not depend on the order of the shapes, even where surfaces coincide.

    Parameters
    ----------
    shapes : Shape, Instance, Scene, path, mesh of trimesh, or an iterable of these
        A bare shape is placed by its own coordinates, in white. Paths are read by `load`.
    light : str, path, Light, Sky or several, optional
        As in `render`: the default light of its pictures.
    ground : bool, optional
        As in `render`: the default ground of its pictures.
    section : Section, text such as "x=0", or up to six of them, optional
        Planes that cut the scene open; the part that all of them keep is visible. Where a plane cuts a solid, a hatched
        cap of the solid's colour closes it. Open shapes show their inside instead, with a warning. The bounding sphere
        does not change. Scene files do not store sections.
    unit : str, optional
        The unit of lengths, such as "mm", "m" or "in", to which scenes of other units are converted. By default that of
        the first scene or file that has one.

    Attributes
    ----------
    instances : tuple of Instance
    unit : str or None
    has_front : bool
        Whether the file's format, or that its y is up, says that its front faces -y. Default cameras then stand there.
    light, ground
        As given; environments are loaded.
    section : tuple of Section
    center : (3,) float64
    radius : float, above 0

    Raises
    ------
    InputError
        If there are no shapes, more than `MAX_INSTANCES`, or a scene of no extent.
    """

    def __init__(
        self,
        shapes: SceneLike,
        *,
        light: LightLike = None,
        ground: bool | None = None,
        section: SectionLike = None,
        unit: str | None = None,
    ) -> None:
        self.section = check_sections(section)
        self._whole = self  # without sections, whose core others share
        self.light = check_light(light)
        self.ground = ground if ground is None else check_flag("ground", ground)
        several = _Several(check_unit("unit", unit))
        self.instances = tuple(islice(several.instances(shapes), MAX_INSTANCES + 1))
        self.unit = several.unit
        self.has_front = several.has_front
        if not self.instances:
            raise InputError("shapes: expected at least one shape, got none")
        if len(self.instances) > MAX_INSTANCES:
            raise InputError(f"shapes: expected at most {MAX_INSTANCES:,} in a scene, got more")
        materials = {id(instance.material): instance.material for instance in self.instances}
        in_core = {number: material.core() for number, material in materials.items()}
        try:
            self._arrangement = _core.Arrangement(
                [instance.shape.core for instance in self.instances],
                np.array([instance.transform for instance in self.instances]),
                [in_core[id(instance.material)] for instance in self.instances],
            )
        except ValueError as error:
            raise InputError(str(error)) from None
        self.center: Point = self._arrangement.center
        self.radius = self._arrangement.radius

    def __reduce__(self) -> tuple[Any, ...]:
        # The core's objects can't be copied.
        return _made_again, (self.instances, self.light, self.ground, self.section, self.unit, self.has_front)

    def __repr__(self) -> str:
        return f"Scene({self.describe()}, radius {self.radius:.6g})"

    def describe(self) -> str:
        """Return a short description of the contents."""
        return ", ".join(counted(count, noun) for noun, count in self.counts().items())

    def counts(self) -> dict[str, int]:
        """Return the number of shapes and of their primitives, such as triangles; each instance adds its own."""
        counts = Counter({"shape": len(self.instances)})
        for instance in self.instances:
            counts.update(instance.shape.counts())
        return dict(counts)

    @property
    def is_colored(self) -> bool:
        """Whether any surface is not white, or a section has hatching; pictures then have colours."""
        return bool(self.section) or any(not i.material.is_white or i.shape.is_colored for i in self.instances)

    @property
    def boxes(self) -> NDArray[np.float64]:
        """(n, 2, 3): the minimum and maximum coordinates of each instance."""
        return self._arrangement.boxes

    @lazy
    def extent(self) -> Extent:
        """The smallest box around all surfaces.

        Exact for scenes of meshes and NURBS; other surfaces are met by rays from six sides, which may miss parts
        thinner than 1/256 of it. Sections do not change it.
        """
        return _measured(self) if self._whole is self else self._whole.extent

    @property
    def unresolved_rays(self) -> int:
        """Number of rays so far that passed places indistinguishable from a surface.

        The sum of `unresolved_rays` over all shapes, in any traced scene that has them.
        """
        shapes = {id(i.shape): i.shape for i in self.instances}
        return sum(shape.unresolved_rays for shape in shapes.values())

    def turned_upright(self) -> Scene:
        """Return the scene rotated from y up, common in games and films, to z up. Its front moves from +z to -y."""
        return self.turned("y")

    def turned(self, up: str) -> Scene:
        """Return the scene rotated so that an axis, such as "y" or "-x", becomes z."""
        check_choice("up", up, tuple(TURNS))
        if up == "z":
            return self
        turned = self.of(instance.transformed(TURNS[up]) for instance in self.instances)
        turned.has_front = up == "y"
        turned.section = tuple(section.transformed(TURNS[up]) for section in self.section)
        return turned

    def of(self, instances: Iterable[Instance], unit: str | None = None) -> Scene:
        """Return a scene of other instances, with everything else as in this one."""
        scene = Scene(instances, light=self.light, ground=self.ground, section=self.section, unit=unit or self.unit)
        scene.has_front = self.has_front
        return scene

    def converted(self, unit: str) -> Scene:
        """Return the scene with its lengths in another unit; raise InputError if its own is unknown."""
        factor = unit_factor(self.unit, check_unit("unit", unit))
        if factor == 1:
            return self
        scene = self.of((instance.scale(factor) for instance in self.instances), unit)
        scene.section = tuple(each.scaled(factor) for each in self.section)
        return scene

    @lazy
    def parts(self) -> Part:
        """The tree of the parts, by the names that files give them: the root, which is all of the scene."""
        return tree_of(self)

    def part(self, which: PartLike) -> Part:
        """Return a part by its path, "housing/bolt 3", by its name if no other has it, or by its number in the tree.

        Raises
        ------
        InputError
            If there is no such part; the message has names that are similar.
        """
        return find_part(self, which)

    def hide(self, *parts: PartLike) -> Scene:
        """Return the scene without some parts."""
        return without(self, parts)

    def isolate(self, *parts: PartLike) -> Scene:
        """Return the scene of some parts alone."""
        return only(self, parts)

    def color(self, part: PartLike, color: Color) -> Scene:
        """Return the scene with a part in one colour instead of its own, linear RGB or sRGB as "#rrggbb"."""
        return colored(self, (part,), color)

    def highlight(self, *parts: PartLike, color: Color = HIGHLIGHT) -> Scene:
        """Return the scene with some parts in a colour that stands out."""
        return colored(self, parts, color)

    def explode(self, factor: float = 1.0, axis: Any = None) -> Scene:
        """Return the scene with its parts moved apart.

        Parameters
        ----------
        factor : number
            Each part moves by this times the offset of its box's centre from the scene's.
        axis : "x", "y", "z" or (3,) numbers, optional
            Parts move along this axis alone.
        """
        return exploded(self, factor, axis)

    def sectioned(self, section: SectionLike) -> Scene:
        """Return the same scene with other sections, or without; it shares all memory, and takes no time to build.

        Parameters
        ----------
        section : Section, text such as "x=0", up to six of them, or None
            As in `Scene`; they replace this scene's sections.
        """
        scene = object.__new__(Scene)
        kept = ("light", "ground", "instances", "unit", "has_front", "_arrangement", "center", "radius")
        scene.__dict__.update({name: self.__dict__[name] for name in kept})
        scene.section, scene._whole = check_sections(section), self._whole
        return scene

    def mesh(self, step: float | None = None) -> Mesh:
        """Return all shapes as one mesh, in their places, without normals. Overlaps are kept.

        If any surface is not white, vertices and triangles have the colours of shapes and materials, without textures.

        Parameters
        ----------
        step : number above 0, optional
            As in `Shape.mesh`, in the scene's units; by default each shape's default.
        """
        vertices, triangles, colors, face_colors, count = [], [], [], [], 0
        meshes: dict[tuple[int, float | None], Shape] = {}
        for instance in self.instances:
            matrix = instance.transform
            own_step = step
            if step is not None:
                own_step = check_number("step", step, 0, above=True) / _core.singular_values(matrix)[0]
            key = id(instance.shape), own_step
            if key not in meshes:
                meshes[key] = instance.shape.mesh(own_step)
            mesh = meshes[key]
            assert isinstance(mesh, Mesh)
            vertices.append(mapped(matrix, mesh.vertices))
            mirrored = np.linalg.det(matrix[:3, :3]) < 0
            triangles.append((mesh.triangles[:, ::-1] if mirrored else mesh.triangles) + np.int32(count))
            count += len(mesh.vertices)
            if self.is_colored:
                own = np.ones((len(mesh.vertices), 3)) if mesh.colors is None else mesh.colors
                colors.append(own * instance.material.color)
                own = np.ones((len(mesh.triangles), 3)) if mesh.face_colors is None else mesh.face_colors
                face_colors.append(own)
        made: dict[str, Any] = {}
        for name, values in (("colors", colors), ("face_colors", face_colors)):
            if any((of_shape != 1).any() for of_shape in values):
                made[name] = np.concatenate(values)
        return Mesh(np.concatenate(vertices), np.concatenate(triangles), **made)

    @lazy
    def core(self) -> _core.Scene:
        """The core's scene, in the unit sphere, built at first use.

        Of coincident surfaces the first in canonical order, by the instances' digests, is visible.
        """
        if not self.section:
            return self._whole._core
        planes = np.array([section.plane(self.center, self.radius) for section in self.section])
        core = self._whole._core.sectioned(planes)
        self._warn_of_open(core.open_instances)
        return core

    @lazy
    def _core(self) -> _core.Scene:
        several = len(self.instances) > 1
        return self._arrangement.scene([instance.shape.digest for instance in self.instances] if several else [])

    def _warn_of_open(self, numbers: list[int]) -> None:
        """Warn of the instances that enclose no solid, if a section cuts them."""
        boxes = self.boxes[numbers]
        corners = np.stack([boxes[:, corner, range(3)] for corner in np.ndindex(2, 2, 2)], axis=1)
        distances = corners @ np.transpose([section.normal for section in self.section])
        offsets = np.array([section.offset for section in self.section])
        cut = ((distances.min(axis=1) < offsets) & (offsets < distances.max(axis=1))).any(axis=1)
        names = [self.instances[number].name for number in np.array(numbers, np.int64)[cut]]
        if names:
            first = f" ({names[0]})" if names[0] else ""
            are = (
                f"{len(names):,} shapes{first} are open, and show"
                if len(names) > 1
                else f"a shape{first} is open, and shows"
            )
            text = f"section: expected closed shapes, got an open one; {are} the inside instead of a cap"
            warnings.warn(text, InputWarning, stacklevel=2)

    def closest_hits(self, origins: Any, directions: Any) -> Hits:
        """Intersect rays of any origin and direction with the scene.

        Parameters
        ----------
        origins, directions : (n, 3) numbers, finite
            In the scene's units; directions of any nonzero length.

        Returns
        -------
        Hits
            The first surface in front of each origin.
        """
        origins = check_finite("origins", check_array("origins", origins, (None, 3)))
        directions = check_finite("directions", check_array("directions", directions, (len(origins), 3)))
        largest = np.abs(directions).max(axis=1, keepdims=True)
        if not largest.all():
            raise InputError("directions: expected lengths above 0, got a direction of length 0")
        # Squares of huge or tiny numbers would overflow or underflow; scaling by a power of two is exact.
        direction = np.ldexp(directions, -np.frexp(largest)[1])
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        origin = (origins - self.center) / self.radius
        # The core needs origins near the unit sphere: rays from afar start at a slightly larger sphere.
        along = (origin * direction).sum(axis=1)
        start = -along - np.sqrt(np.maximum(along**2 - (origin**2).sum(axis=1) + 1.01, 0))
        start = np.maximum(start, 0)
        origin = origin + start[:, None] * direction
        t = np.empty(len(origins), np.float32)
        found, primitive = np.empty(len(origins), np.int32), np.empty(len(origins), np.int32)
        u, v = np.empty(len(origins)), np.empty(len(origins))
        self.core.closest_hits(origin.astype(np.float32), direction.astype(np.float32), t, found, primitive, u, v)
        return Hits(np.where(found >= 0, (start + t) * self.radius, np.inf), found, primitive, u, v)


def _measured(scene: Scene) -> Extent:
    """Measure a scene's box: from vertices and faces, else by rays from six sides."""
    box = np.array([scene.boxes[:, 0].min(axis=0), scene.boxes[:, 1].max(axis=0)])
    if all(isinstance(instance.shape, Mesh | Brep) for instance in scene.instances):
        numbers = enumerate(map(primitive_count, (instance.shape for instance in scene.instances)))
        return extent_of(scene, (Selected(number, 0, count) for number, count in numbers))
    around = ((box - scene.center) / scene.radius).astype(np.float32)
    return Extent(*(scene.center + scene.radius * scene._core.box_by_rays(around).astype(np.float64)))


def _made_again(
    instances: tuple[Instance, ...],
    light: LightLike,
    ground: bool | None,
    section: tuple[Section, ...],
    unit: str | None,
    has_front: bool,
) -> Scene:
    scene = Scene(instances, light=light, ground=ground, section=section, unit=unit)
    scene.has_front = has_front
    return scene


SceneLike: TypeAlias = Scene | Instance | Shape | str | os.PathLike[Any] | Iterable[Any]
"""A scene, an instance, a shape, or an iterable of these."""


def as_scene(scene: SceneLike, section: SectionLike = None) -> Scene:
    """Return a Scene of a scene, a shape or several shapes; with other sections, if there are any."""
    scene = scene if isinstance(scene, Scene) else Scene(scene)
    return scene if section is None else scene.sectioned(section)


class _Several:
    """The content of a scene: instances, in one unit and under different names."""

    def __init__(self, unit: str | None) -> None:
        self.unit = unit
        self.has_front = False
        self._names: set[str] = set()
        """Names below the root of the scenes so far."""

    def instances(self, shapes: SceneLike, among: str = "") -> Iterator[Instance]:
        if isinstance(shapes, Instance):
            yield shapes
        elif isinstance(shapes, Shape):
            yield Instance(shapes)
        elif isinstance(shapes, Scene):
            yield from self._renamed(self._in_unit(shapes))
        elif (read := next((found for read in READERS if (found := read(shapes)) is not None), None)) is not None:
            yield from self.instances(read)
        elif isinstance(shapes, Iterable):
            for shape in each_of("shapes", shapes, "a shape or several"):
                yield from self.instances(shape, " among them")
        else:
            raise InputTypeError(f"shapes: expected a shape or several, got {type(shapes).__name__}{among}")

    def _in_unit(self, scene: Scene) -> Iterable[Instance]:
        self.has_front = self.has_front or scene.has_front
        if scene.unit is None or self.unit in (None, scene.unit):
            self.unit = self.unit or scene.unit
            return scene.instances
        return scene.converted(self.unit).instances

    def _renamed(self, instances: Iterable[Instance]) -> Iterator[Instance]:
        """Instances, renamed below the root if an earlier scene has the same name."""
        is_first, renamed = not self._names, dict[str, str]()
        for instance in instances:
            pieces = []
            for (first, *rest), count in instance.pieces:
                if first not in renamed:
                    names = (first, *(f"{first} {number}" for number in range(2, len(self._names) + 3)))
                    renamed[first] = next(name for name in names if name not in self._names)
                    self._names.add(renamed[first])
                pieces.append(Piece((renamed[first], *rest), count))
            yield instance if is_first else replace(instance, pieces=tuple(pieces))


READERS: list[Callable[[Any], SceneLike | None]] = []
"""Each returns the shapes of a foreign value, or None. `adapters` adds its own: nothing here depends on files."""
