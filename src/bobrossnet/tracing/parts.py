"""Parts of a scene: a tree by the names that files give, and scenes of some of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, NamedTuple, Protocol, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from bobrossnet.color import Color
from bobrossnet.shapes.affine import Point, mapped, translation
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.shapes.nurbs import Brep
from bobrossnet.shapes.shape import Shape
from bobrossnet.support.errors import (
    InputError,
    InputTypeError,
    brief,
    check_direction,
    check_integer,
    check_number,
    shape_of,
)
from bobrossnet.support.messages import one_line
from bobrossnet.tracing.instance import Instance, Piece, primitive_count
from bobrossnet.tracing.material import Material

HIGHLIGHT = "#ff8c1a"
"""Color of highlighted parts: few objects are orange."""

MAX_SHOWN = 5
"""Similar names in an error."""

PartLike: TypeAlias = "Part | str | int | tuple[str, ...]"
"""A part; its path, as a text or a tuple; its name; or its number in the tree."""

Range: TypeAlias = tuple[int, int]
"""First of some consecutive primitives, and the one behind the last."""


class Extent(NamedTuple):
    """An axis-aligned box, in a scene's units."""

    low: Point
    """(3,)"""
    high: Point
    """(3,)"""

    @property
    def size(self) -> Point:
        """(3,): the lengths of its sides."""
        return self.high - self.low

    @property
    def center(self) -> Point:
        """(3,)"""
        return (self.low + self.high) / 2


class Selected(NamedTuple):
    """Consecutive primitives of an instance."""

    instance: int
    """Index into `Scene.instances`."""
    start: int
    stop: int


class Shown(Protocol):
    """The members of `Scene` that parts need; scenes build on this module."""

    instances: tuple[Instance, ...]

    @property
    def boxes(self) -> NDArray[np.float64]: ...

    @property
    def extent(self) -> Extent: ...

    @property
    def parts(self) -> Part: ...

    def of(self: AnyScene, instances: Iterable[Instance]) -> AnyScene: ...


AnyScene = TypeVar("AnyScene", bound=Shown)


@dataclass(frozen=True, eq=False)
class Part:
    """A part of a scene, or of another part, such as an assembly, a node or a layer of a file.

    Iterate over it, or index it by number or name, for the parts below it.
    """

    name: str
    """Different from its siblings'; empty for the root."""
    path: tuple[str, ...]
    """Names from the root down to the part's own."""
    number: int
    """Place in the sequence of all parts, each before those below it; -1 for the root."""
    children: tuple[Part, ...]
    own: tuple[Selected, ...]
    """Primitives of the part itself, without parts below it."""
    scene: Shown = field(repr=False)

    def __str__(self) -> str:
        return "/".join(self.path)

    def __repr__(self) -> str:
        return f"Part({str(self)!r}, {len(self.children)} below)"

    def __iter__(self) -> Iterator[Part]:
        return iter(self.children)

    def __len__(self) -> int:
        return len(self.children)

    def __getitem__(self, which: int | str) -> Part:
        """Return a part below this one by its number among them, or by its name."""
        if isinstance(which, int):
            return self.children[which]
        for part in self.children:
            if part.name == which:
                return part
        raise KeyError(which)

    def walk(self) -> Iterator[Part]:
        """Iterate over all parts below this one, each before those below it."""
        waiting = [*reversed(self.children)]
        while waiting:
            part = waiting.pop()
            yield part
            waiting += reversed(part.children)

    @property
    def selected(self) -> tuple[Selected, ...]:
        """Primitives of the part and of all parts below it."""
        return tuple(selected for part in (self, *self.walk()) for selected in part.own)

    def primitive(self, number: int) -> tuple[int, int]:
        """Return the instance and the primitive of the part's own triangle or face of a number, counted from 0."""
        left = check_integer("face", number, 0, sum(stop - start for _, start, stop in self.own) - 1)
        for instance, start, stop in self.own:
            if left < stop - start:
                return instance, start + left
            left -= stop - start
        raise AssertionError("the number was checked")

    def number_of(self, instance: int, primitive: int) -> int:
        """Return the number that `primitive` takes, of a primitive of the part."""
        before = 0
        for number, start, stop in self.own:
            if number == instance and start <= primitive < stop:
                return before + primitive - start
            before += stop - start
        raise AssertionError("the primitive belongs to the part")

    @property
    def instances(self) -> tuple[int, ...]:
        """Indices into `Scene.instances` of all that have primitives of the part or of parts below it."""
        return tuple(sorted({selected.instance for selected in self.selected}))

    @property
    def color(self) -> tuple[float, float, float] | None:
        """Linear RGB of the material; None if there are several, or if shapes have colours."""
        instances = [self.scene.instances[i] for i in self.instances]
        colors = {None if instance.shape.is_colored else instance.material.color for instance in instances}
        return colors.pop() if len(colors) == 1 else None

    @property
    def extent(self) -> Extent:
        """The box around the part, exact as `Scene.extent`."""
        return extent_of(self.scene, self.selected)


def extent_of(scene: Shown, selected: Iterable[Selected]) -> Extent:
    """Return the box around primitives of a scene."""
    boxes = []
    for number, start, stop in selected:
        instance = scene.instances[number]
        if isinstance(instance.shape, Mesh):
            if stop - start == len(instance.shape.triangles):
                boxes.append(scene.boxes[number])
                continue
            used = instance.shape.vertices[instance.shape.triangles[start:stop].reshape(-1)]
            points = mapped(instance.transform, used)
            boxes.append(np.array([points.min(axis=0), points.max(axis=0)]))
        elif isinstance(instance.shape, Brep):
            of_faces = instance.shape.boxes(instance.transform)[start:stop]
            boxes.append(np.array([of_faces[:, 0].min(axis=0), of_faces[:, 1].max(axis=0)]))
        else:
            boxes.append(np.array(scene.of([instance]).extent if len(scene.instances) > 1 else scene.extent))
    low, high = np.array(boxes).transpose(1, 0, 2)
    return Extent(low.min(axis=0), high.max(axis=0))


# ---- The tree --------------------------------------------------------------------------------------------


@dataclass
class _Node:
    """A part in the making."""

    children: dict[str, _Node] = field(default_factory=dict)
    own: list[Selected] = field(default_factory=list)


def tree_of(scene: Shown) -> Part:
    """Return the root of a scene's parts. Instances without pieces are parts below it, by their names or kinds."""
    root = _Node()
    taken = {piece.path[0] for instance in scene.instances for piece in instance.pieces}
    counts: dict[str, int] = {}
    for number, instance in enumerate(scene.instances):
        pieces: Sequence[Piece] = instance.pieces
        if not pieces:
            pieces = [Piece((_own_name(instance, taken, counts),))]
        start = 0
        for path, count in pieces:
            node = root
            for name in path:
                node = node.children.setdefault(name, _Node())
            stop = start + (primitive_count(instance.shape) if count is None else count)
            if node.own and node.own[-1][::2] == (number, start):
                start = node.own.pop().start
            node.own.append(Selected(number, start, stop))
            start = stop
    return _part(scene, root, (), [-1])


def _own_name(instance: Instance, taken: set[str], counts: dict[str, int]) -> str:
    """Return a new name for an instance without pieces."""
    first = name = one_line(instance.name or instance.shape.kind)
    while name in taken:
        counts[first] = counts.get(first, 1) + 1
        name = f"{first} {counts[first]}"
    taken.add(name)
    return name


def _part(scene: Shown, node: _Node, path: tuple[str, ...], counter: list[int]) -> Part:
    number = counter[0]
    counter[0] += 1
    children = tuple(_part(scene, child, (*path, name), counter) for name, child in node.children.items())
    return Part(path[-1] if path else "", path, number, children, tuple(node.own), scene)


def part_at(scene: Shown, instance: int, primitive: int) -> Part:
    """Return the part of a primitive of an instance."""
    for part in scene.parts.walk():
        for number, start, stop in part.own:
            if number == instance and start <= primitive < stop:
                return part
    raise AssertionError("each primitive has a part")


def find_part(scene: Shown, which: Any) -> Part:
    """Return a part by what `PartLike` says, or of a pick."""
    which = getattr(which, "part", which)
    if isinstance(which, Part):
        which = which.path
        if which == ():
            return scene.parts
    parts = list(scene.parts.walk())
    if isinstance(which, int | np.integer) and not isinstance(which, bool):
        if not 0 <= which < len(parts):
            raise InputError(f"part: expected a number in 0..{len(parts) - 1}, got {brief(which, of_type=False)}")
        return parts[int(which)]
    if isinstance(which, tuple):
        found = [part for part in parts if part.path == which]
        which = "/".join(map(str, which))
    elif isinstance(which, str):
        found = [part for part in parts if str(part) == which] or [part for part in parts if part.name == which]
    else:
        raise InputTypeError(f"part: expected a part, its path, name or number, got {brief(which)}")
    if len(found) == 1:
        return found[0]
    name = one_line(which)
    if found:
        paths = ", ".join(one_line(part) for part in found[:MAX_SHOWN])
        raise InputError(f"part: expected a path, as {len(found):,} parts are called {name!r}: {paths}")
    from difflib import get_close_matches  # imported by errors alone

    texts = {text.lower(): str(part) for part in parts for text in (part.name, str(part))}
    near = dict.fromkeys(texts[text] for text in get_close_matches(name.lower(), texts, MAX_SHOWN))
    shown = [one_line(text) for text in [*near] or [str(part) for part in parts[:MAX_SHOWN]]]
    which_are = "the only part," if len(parts) == 1 else f"one of the {len(parts):,} parts, such as"
    raise InputError(f"part: expected {which_are} {', '.join(shown)}, got {name!r}")


# ---- Scenes of some parts --------------------------------------------------------------------------------


def without(scene: AnyScene, parts: Iterable[Any]) -> AnyScene:
    """Return the scene without some parts."""
    chosen = _ranges(scene, parts)
    kept = [_cut(instance, _others(instance, chosen.get(i, []))) for i, instance in enumerate(scene.instances)]
    instances = [instance for instance in kept if instance is not None]
    if not instances:
        raise InputError("parts: expected to keep at least one, got all of the scene")
    return scene.of(instances)


def only(scene: AnyScene, parts: Iterable[Any]) -> AnyScene:
    """Return the scene of some parts alone."""
    chosen = _ranges(scene, parts)
    kept = [_cut(scene.instances[i], ranges) for i, ranges in sorted(chosen.items())]
    instances = [instance for instance in kept if instance is not None]
    if not instances:
        raise InputError("parts: expected at least one, got none")
    return scene.of(instances)


def colored(scene: AnyScene, parts: Iterable[Any], color: Color) -> AnyScene:
    """Return the scene with some parts in one colour instead of their own."""
    chosen, material = _ranges(scene, parts), Material(color)
    instances: list[Instance | None] = []
    shapes: dict[int, Shape] = {}
    for i, instance in enumerate(scene.instances):
        if i not in chosen:
            instances.append(instance)
            continue
        part = _cut(instance, chosen[i])
        assert part is not None
        shape = shapes.setdefault(id(part.shape), _without_colors(part.shape))
        looks = material
        if type(instance.material) is Material:
            looks = Material(**asdict(instance.material) | {"color": material.color})
        instances.append(Instance(shape, part.transform, looks, part.name, part.pieces))
        instances.append(_cut(instance, _others(instance, chosen[i])))
    return scene.of(instance for instance in instances if instance is not None)


def faces_colored(scene: AnyScene, faces: Iterable[tuple[int, int]], color: Color) -> AnyScene:
    """Return the scene with some triangles or faces, pairs of an instance and a primitive, in one colour.

    Unlike `colored`, this keeps shapes whole: a section still closes them.
    """
    chosen: dict[int, list[int]] = {}
    for number, primitive in faces:
        chosen.setdefault(number, []).append(primitive)
    instances = [*scene.instances]
    for number, primitives in chosen.items():
        instance, shape = instances[number], instances[number].shape
        if not isinstance(shape, Mesh | Brep):
            raise InputError(f"face: expected one of a mesh or of NURBS, got a shape of kind {shape.kind}")
        own = np.ones((primitive_count(shape), 3)) if shape.face_colors is None else shape.face_colors
        colors = (own * instance.material.color).astype(np.float32)
        colors[primitives] = Material(color).color
        looks = asdict(instance.material) if type(instance.material) is Material else {}
        if isinstance(shape, Brep):
            painted: Shape = Brep.from_tensors(shape.tensors() | {"face_colors": colors})
        else:
            painted = Mesh.from_tensors(shape.tensors_apart() | {"face_colors": colors}, shape.picture)
        instances[number] = replace(instance, shape=painted, material=Material(**looks | {"color": (1, 1, 1)}))
    return scene.of(instances)


def exploded(scene: AnyScene, factor: float, axis: Any) -> AnyScene:
    """Return the scene with its parts moved apart, as `Scene.explode` says."""
    factor, along = check_number("factor", factor), np.eye(3)
    if axis is not None:
        direction = _axis(axis)
        along = np.outer(direction, direction)
    middle = Extent(scene.boxes[:, 0].min(axis=0), scene.boxes[:, 1].max(axis=0)).center
    instances = []
    for part in scene.parts.walk():
        if part.own:
            offset = factor * along @ (extent_of(scene, part.own).center - middle)
            ranges: dict[int, list[Range]] = {}
            for number, start, stop in part.own:
                ranges.setdefault(number, []).append((start, stop))
            for number, own in ranges.items():
                moved = _cut(scene.instances[number], own)
                assert moved is not None
                instances.append(moved.transformed(translation(offset)))
    return scene.of(instances)


def _axis(axis: Any) -> Point:
    """Return a unit vector along an axis."""
    if isinstance(axis, str):
        if axis not in ("x", "y", "z"):
            raise InputError(f"axis: expected x, y, z or 3 numbers, got {brief(axis, of_type=False)}")
        along: Point = np.eye(3)["xyz".index(axis)]
        return along
    if not shape_of(axis):
        raise InputTypeError(f"axis: expected x, y, z or 3 numbers, got {brief(axis)}")
    return check_direction("axis", axis)[0]


def _ranges(scene: Shown, parts: Iterable[Any]) -> dict[int, list[Range]]:
    """Return the primitives of parts by the numbers of their instances, ascending and apart."""
    found: dict[int, list[Range]] = {}
    for which in parts:
        for number, start, stop in find_part(scene, which).selected:
            found.setdefault(number, []).append((start, stop))
    return {number: _merged(ranges) for number, ranges in found.items()}


def _merged(ranges: list[Range]) -> list[Range]:
    merged: list[Range] = []
    for start, stop in sorted(ranges):
        if merged and start <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(stop, merged[-1][1]))
        else:
            merged.append((start, stop))
    return merged


def _others(instance: Instance, ranges: list[Range]) -> list[Range]:
    """Return the primitives of an instance outside some of them."""
    ends = [0, *(end for both in ranges for end in both), primitive_count(instance.shape)]
    return [(start, stop) for start, stop in zip(ends[::2], ends[1::2], strict=True) if start < stop]


def _cut(instance: Instance, ranges: list[Range]) -> Instance | None:
    """Return the instance with some of its primitives; None without any, the instance itself with all."""
    ranges = _merged(ranges)
    if not ranges:
        return None
    if ranges == [(0, primitive_count(instance.shape))]:
        return instance
    pieces, start = [], 0
    for path, count in instance.pieces:
        assert count is not None
        kept = sum(max(0, min(b, start + count) - max(a, start)) for a, b in ranges)
        start += count
        if kept:
            pieces.append((path, kept))
    chosen = np.concatenate([np.arange(a, b) for a, b in ranges])
    return Instance(
        shape_of_primitives(instance.shape, chosen), instance.transform, instance.material, instance.name, pieces
    )


def shape_of_primitives(shape: Shape, chosen: NDArray[np.int64]) -> Shape:
    """Return a shape of some triangles or faces, shaded as in the whole."""
    if isinstance(shape, Brep):
        return Brep([shape.faces[i] for i in chosen], shape.tolerance)
    assert isinstance(shape, Mesh)
    held = shape.tensors_apart()
    corners = held["triangles"][chosen].reshape(-1)
    if shape.normals is None or not (np.isfinite(shape.normals).all() and shape.normals.any(axis=1).all()):
        # Shading smooths over neighbours that are cut off: each corner becomes a vertex with its normal.
        used, places = corners, np.arange(len(corners))
        held["normals"] = shape.core.corner_normals().reshape(-1, 3, 3)[chosen].reshape(-1, 3)
    else:
        used, places = np.unique(corners, return_inverse=True)
        held["normals"] = shape.normals[used]
    held["triangles"] = places.reshape(-1, 3).astype(np.int32)
    for name in ("vertices", "colors", "alphas", "uv"):
        if name in held:
            held[name] = held[name][used]
    if "face_colors" in held:
        held["face_colors"] = held["face_colors"][chosen]
    return Mesh.from_tensors(held, shape.picture)


def _without_colors(shape: Shape) -> Shape:
    """Return a shape without its colours, except a texture that has holes."""
    if not shape.is_colored or (isinstance(shape, Mesh) and shape.texture_alpha is not None):
        return shape
    held = shape.tensors_apart() if isinstance(shape, Mesh) else shape.tensors()
    of_colors = {"colors", "face_colors", "uv", "texture_layout"}
    plain = {name: held[name] for name in held if name not in of_colors and not name.startswith("color_")}
    if "alphas" in plain:
        plain["colors"] = np.ones_like(held["colors"])
    return type(shape).from_tensors(plain)
