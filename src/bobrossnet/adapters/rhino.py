"""Rhino's files, .3dm, through rhino3dm: surfaces with their trims, meshes, and blocks of them.

Hidden objects, and objects on layers that are off, are left out.
"""

from __future__ import annotations

import math
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.adapters.apart import call_apart, check_library, limit
from bobrossnet.adapters.opennurbs import brep_loops
from bobrossnet.adapters.part import Found, Names
from bobrossnet.adapters.reader import RHINO
from bobrossnet.color import from_srgb
from bobrossnet.shapes.affine import IDENTITY, Matrix
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.shapes.nurbs import Brep, Face, Loop, TrimCurve
from bobrossnet.shapes.shape import Shape
from bobrossnet.shapes.splines import MAX_DEGREE
from bobrossnet.support.errors import InputError, InputWarning
from bobrossnet.support.messages import counted, name_of, one_line, warn_of
from bobrossnet.support.units import unit_of_word
from bobrossnet.tracing.instance import Instance, Piece
from bobrossnet.tracing.material import Material

# A few nested blocks can make 2ⁿ shapes; blocks and layers can contain themselves.
MAX_IN_BLOCKS = _core.MAX_INSTANCES
MAX_LAYERS_DEEP = 100

# Subdivision surfaces become meshes: each step quarters the faces. Twice looks smooth up to the crease angle.
SUBDIVISIONS = 2
MAX_SUBDIVIDED = 1_000_000

# As shares of a surface's domain: which parameters are equal, which trims lie on its border, and how closely cubics
# follow a curve. A pixel is far larger in any picture.
SAME = 1e-12
BORDER = 1e-7
FITTED = 1e-7
MAX_FITTED = 4096

# Matrices from a cubic's points at 0, 1/3, 2/3 and 1 to its control points, and on to points at 1/6, 1/2 and 5/6.
CUBIC_THROUGH = np.array([[6, 0, 0, 0], [-5, 18, -9, 2], [2, -9, 18, -5], [0, 0, 0, 6]]) / 6
BETWEEN = np.array([[125, 75, 15, 1], [27, 81, 81, 27], [1, 15, 75, 125]]) / 216

# Maximum gap between edges of neighbouring faces, in sizes of their object.
MAX_GAP = 1e-3

WHITE = "#ffffff"
UNCHOSEN = 0.02
"""A display colour of a lower luminance is ignored: layers are black by default."""

F64: TypeAlias = NDArray[np.float64]


def read_3dm(file: Path) -> Found[Instance]:
    """Return the visible shapes of a Rhino file: an instance for each surface, polysurface, extrusion and mesh.

    Instances are named after their objects, else their layers, else the file. As in Rhino's rendered view, the colour
    is the diffuse colour of the object's or layer's material. Without a material it is the display colour, or white
    if that is nearly black. Colours of a mesh's vertices replace both. Blocks are resolved. Curves, points, lights and
    annotations are skipped. Subdivision surfaces become meshes.

    Raises
    ------
    InputError
        If rhino3dm is missing, the file can't be read, or it has no visible shape.

    Warns
    -----
    InputWarning
        If faces or objects are left out, or faces are shown without their trims.
    """
    check_library("rhino3dm", "rhino3dm", file)
    instances, notes = call_apart(RHINO, "read_apart", str(file))
    for note in notes:
        warnings.warn(note, InputWarning, stacklevel=2)
    found: Found[Instance] = instances
    return found


def read_apart(file: str) -> tuple[Found[Instance], list[str]]:
    """Return the instances and warnings of `read_3dm`, in a separate process: damaged files crash rhino3dm."""
    path = Path(file)
    limit(path.stat().st_size)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        instances = read_here(path)
    return instances, [str(warning.message) for warning in caught if issubclass(warning.category, InputWarning)]


def read_here(file: Path) -> Found[Instance]:
    """Run `read_3dm` in this process."""
    import rhino3dm

    document = rhino3dm.File3dm.Read(str(file))
    if document is None:
        raise InputError("expected a Rhino file, got something else or an incomplete file")
    unit = unit_of_word(document.Settings.ModelUnitSystem.name)
    return Found(_Reader(document, file).instances(), unit)


class Look(NamedTuple):
    """The colours of an object, as sRGB."""

    display: str
    """Colour of its lines."""
    material: str | None
    """Colour of its faces; None without a material."""


class Object(NamedTuple):
    """An object of the file, independent of its places."""

    name: str
    path: tuple[str, ...]
    """Its layers and its own name; within a block, only the last counts."""
    look: Look
    display_of_block: bool
    """Whether the block's display colour replaces its own."""
    material_of_block: bool
    """The same for the material."""
    shape: Shape | None = None
    matrix: Matrix = IDENTITY
    """The transform of a block's objects; identity for other objects."""
    children: tuple[str, ...] = ()


class _Reader:
    def __init__(self, document: Any, file: Path) -> None:
        self.document = document
        self.file = file
        self.layers = {layer.Index: layer for layer in document.Layers}
        self.stored = {str(item.Attributes.Id): item for item in document.Objects}
        self.objects: dict[str, Object | None] = {}
        self.not_shown: Counter[str] = Counter()
        self.faces = self.untrimmed = 0
        self.refused_faces: list[str] = []
        self.refused: list[str] = []

    def instances(self) -> list[Instance]:
        top = [key for key, item in self.stored.items() if not item.Attributes.IsInstanceDefinitionObject]
        found = list(self.placed(top))
        reasons = [*self.refused_faces, *self.refused]
        if not found:
            kinds = ", ".join(f"{kind} ({count:,})" for kind, count in self.not_shown.most_common())
            raise InputError(f"expected surfaces or meshes, got {reasons[0] if reasons else kinds or 'none'}")
        if self.refused_faces:
            warn_of(
                self.file,
                f"left out {len(self.refused_faces):,} of {counted(self.faces, 'face')} ({self.refused_faces[0]})",
            )
        if self.refused:
            warn_of(self.file, f"left out {len(self.refused):,} objects ({self.refused[0]})")
        if self.untrimmed:
            warn_of(
                self.file, f"trims of {self.untrimmed:,} of {counted(self.faces, 'face')} can't be read: shown whole"
            )
        return found

    # ---- Objects -----------------------------------------------------------------------------------------

    def placed(self, keys: Sequence[str]) -> Iterator[Instance]:
        """Yield the instances of objects, and of the objects in blocks."""
        names = Names()
        waiting: list[tuple[str, Matrix, Look | None, tuple[str, ...] | None]] = [
            (key, IDENTITY, None, None) for key in reversed(keys)
        ]
        in_blocks = 0
        while waiting:
            key, matrix, block, of_block = waiting.pop()
            if key not in self.objects:
                self.objects[key] = self.object(key)
            item = self.objects[key]
            if item is None:
                continue
            look = item.look
            if block is not None:
                look = Look(
                    block.display if item.display_of_block else look.display,
                    block.material if item.material_of_block else look.material,
                )
            inner = matrix @ item.matrix
            path = names.path(item.path[:-1] if of_block is None else of_block, item.path[-1])
            in_blocks += len(item.children)
            if in_blocks > MAX_IN_BLOCKS:
                raise InputError(
                    f"expected at most {MAX_IN_BLOCKS:,} objects in blocks, got more; does one hold itself?"
                )
            waiting += [(child, inner, look, path) for child in reversed(item.children)]
            if item.shape is not None:
                material = Material() if item.shape.is_colored else _material(look)
                try:
                    yield Instance(item.shape, inner, material, item.name, [Piece(path)])
                except InputError as error:  # a block pressed flat
                    self.refused.append(str(error))

    def object(self, key: str) -> Object | None:
        """Return an object of the file; None if it is invisible."""
        item = self.stored.get(key)
        if item is None:
            return None
        attributes, geometry = item.Attributes, item.Geometry
        layer = self.layers.get(attributes.LayerIndex)
        kind = geometry.ObjectType.name
        if not attributes.Visible or not self.shows(layer):
            self.not_shown["hidden"] += 1
            return None
        name = one_line(attributes.Name or (layer and layer.Name) or name_of(self.file))
        look = self.look(attributes, layer)
        path = (*map(one_line, layer.FullPath.split("::") if layer else ()), one_line(attributes.Name) or kind.lower())
        of_block = (
            attributes.ColorSource.name == "ColorFromParent",
            attributes.MaterialSource.name == "MaterialFromParent",
        )
        if kind == "InstanceReference":
            block = self.document.InstanceDefinitions.FindId(geometry.ParentIdefId)
            children = tuple(map(str, block.GetObjectIds())) if block else ()
            matrix = np.array(geometry.Xform.ToFloatArray(True)).reshape(4, 4)
            if not attributes.Name and block and block.Name:
                path = (*path[:-1], one_line(block.Name))
            return Object(name, path, look, *of_block, matrix=matrix, children=children)
        if kind not in ("Brep", "Extrusion", "Surface", "Mesh", "SubD"):
            self.not_shown[kind.lower()] += 1
            return None
        shape = self.shape(geometry, kind)
        return None if shape is None else Object(name, path, look, *of_block, shape)

    def shows(self, layer: Any) -> bool:
        """Return whether a layer and all its parents are on."""
        for _ in range(MAX_LAYERS_DEEP):
            if layer is None:
                return True
            if not layer.Visible:
                return False
            layer = self.document.Layers.FindId(layer.ParentLayerId)
        return True

    def look(self, attributes: Any, layer: Any) -> Look:
        of_object = attributes.MaterialSource.name == "MaterialFromObject"
        number = attributes.MaterialIndex if of_object else layer.RenderMaterialIndex if layer else -1
        material = self.document.Materials.FindIndex(number) if number >= 0 else None
        source = attributes.ColorSource.name
        display = WHITE
        if source == "ColorFromObject":
            display = _hex(attributes.ObjectColor)
        elif source != "ColorFromMaterial" and layer:
            display = _hex(layer.Color)
        return Look(display, _hex(material.DiffuseColor) if material else None)

    def shape(self, geometry: Any, kind: str) -> Shape | None:
        """Return an object's shape; without one, store the reason and return None."""
        try:
            if kind in ("Mesh", "SubD"):
                return _mesh(geometry if kind == "Mesh" else _subdivided(geometry))
            faces = self.brep_faces(geometry, kind)
            if not faces:
                return None
            box = geometry.GetBoundingBox()
            size = math.dist(*((corner.X, corner.Y, corner.Z) for corner in (box.Min, box.Max)))
            return Brep(faces, min(self.document.Settings.ModelAbsoluteTolerance, MAX_GAP * size))
        except InputError as error:
            self.refused.append(str(error))
            return None

    # ---- Faces -------------------------------------------------------------------------------------------

    def brep_faces(self, geometry: Any, kind: str) -> list[Face]:
        """Return the usable faces of a surface, an extrusion or a polysurface."""
        if kind == "Surface":
            found = [self.face(geometry, ())]
        else:
            brep = geometry.ToBrep(True) if kind == "Extrusion" else geometry
            if brep is None:
                raise InputError("expected an extrusion of a curve, got one that can't become surfaces")
            surfaces = [face.UnderlyingSurface() for face in brep.Faces]
            try:
                loops = brep_loops(brep)
            except InputError:
                loops = [[] for _ in surfaces]
                self.untrimmed += len(surfaces)
            found = [self.face(surface, bounds) for surface, bounds in zip(surfaces, loops, strict=True)]
        return [face for face in found if face is not None]

    def face(self, surface: Any, bounds: Sequence[Sequence[Any]]) -> Face | None:
        """Return a trimmed surface; if it is unusable, store the reason and return None."""
        self.faces += 1
        try:
            nurbs = surface.ToNurbsSurface()
            if nurbs is None:
                raise InputError("expected a surface with a NURBS form, got none")
            face = untrimmed(nurbs)
            if bounds:
                try:
                    loops = face_trims(bounds, surface, face)
                except InputError:
                    self.untrimmed += 1
                    return face
                if not _is_border(loops, face):
                    face = Face(face.control_points, face.knots_u, face.knots_v, face.weights, loops)
        except InputError as error:
            self.refused_faces.append(str(error))
            return None
        return face


def _hex(color: tuple[int, ...]) -> str:
    red, green, blue = color[:3]
    return f"#{red:02x}{green:02x}{blue:02x}"


def _material(look: Look) -> Material:
    if look.material is not None:
        return Material(look.material)
    red, green, blue = Material(look.display).color
    unchosen = 0.2126 * red + 0.7152 * green + 0.0722 * blue < UNCHOSEN
    return Material() if unchosen else Material(look.display)


# ---- Meshes ----------------------------------------------------------------------------------------------


def _subdivided(geometry: Any) -> Any:
    """Return a subdivided control net, a rhino3dm mesh."""
    import rhino3dm

    subd = geometry.Duplicate()
    for _ in range(SUBDIVISIONS):
        if 4 * subd.FaceCount <= MAX_SUBDIVIDED:
            subd.Subdivide(1)
    mesh = rhino3dm.Mesh.CreateFromSubDControlNet(subd, False)
    if mesh is None:
        raise InputError("expected a subdivision surface with faces, got none")
    return mesh


def _mesh(mesh: Any) -> Mesh:
    """Return a rhino3dm mesh, with normals and colours if there is one for each vertex."""
    vertices = np.array([(p.X, p.Y, p.Z) for p in mesh.Vertices.ToPoint3dArray()], np.float64).reshape(-1, 3)
    corners = np.array([mesh.Faces[i] for i in range(len(mesh.Faces))], np.int64).reshape(-1, 4)
    # A triangle is stored as a quad that repeats its last corner.
    quads = corners[corners[:, 2] != corners[:, 3]]
    normals = np.array([(n.X, n.Y, n.Z) for n in (mesh.Normals[i] for i in range(len(mesh.Normals)))], np.float64)
    colors = np.array([mesh.VertexColors[i][:3] for i in range(len(mesh.VertexColors))], np.float64)
    return Mesh(
        vertices,
        np.concatenate([corners[:, :3], quads[:, [0, 2, 3]]]),
        normals if normals.shape == vertices.shape else None,
        colors=from_srgb(colors / 255) if colors.shape == vertices.shape else None,
    )


# ---- Surfaces and their trims ----------------------------------------------------------------------------


def untrimmed(nurbs: Any) -> Face:
    """Return the whole of a rhino3dm NURBS surface."""
    rows, columns = nurbs.Points.CountU, nurbs.Points.CountV
    points = [nurbs.Points[i, j] for i in range(rows) for j in range(columns)]
    control_points, weights = _euclidean(points, nurbs.IsRational)
    return Face(
        control_points.reshape(rows, columns, 3),
        _full_knots(nurbs.KnotsU),
        _full_knots(nurbs.KnotsV),
        None if weights is None else weights.reshape(rows, columns),
    )


def _euclidean(points: list[Any], rational: bool) -> tuple[F64, F64 | None]:
    """Divide homogeneous points by their weights; return control points (n, 3) and weights (n,)."""
    stored = np.array([(p.X, p.Y, p.Z, p.W) for p in points], np.float64).reshape(-1, 4)
    if not rational:
        return stored[:, :3], None
    with np.errstate(all="ignore"):  # a weight of zero is refused later on
        return stored[:, :3] / stored[:, 3:], stored[:, 3]


def _full_knots(knots: Any) -> F64:
    """Add the first and the last knot, which openNURBS omits: they have no influence within the domain."""
    stored = np.array(knots.ToList(), np.float64)
    return np.concatenate([stored[:1], stored, stored[-1:]])


def face_trims(bounds: Sequence[Sequence[Any]], surface: Any, face: Face) -> tuple[Loop, ...]:
    """Map loops of curves from the parameters of a rhino3dm surface to those of its NURBS form.

    Parameters
    ----------
    bounds : loops of rhino3dm curves, end to end

    Raises
    ------
    InputError
        If a curve has no NURBS form, or is too rough to be followed where its points must be moved.
    """
    same = _same_parameters(surface)
    scale = np.ptp(np.array(face.domain), axis=1)

    def moved(u: float, v: float) -> tuple[float, float]:
        if same:
            return u, v
        _, nurbs_u, nurbs_v = surface.GetNurbsFormParameterFromSurfaceParameter(u, v)
        return nurbs_u, nurbs_v

    def trim(curve: Any) -> TrimCurve:
        nurbs = curve.ToNurbsCurve()
        if nurbs is None:
            raise InputError("expected a curve with a NURBS form, got none")
        if not same or nurbs.Order - 1 > MAX_DEGREE:
            return _fitted(nurbs, moved, scale)
        points, weights = _euclidean([nurbs.Points[i] for i in range(len(nurbs.Points))], nurbs.IsRational)
        return TrimCurve(points[:, :2], _full_knots(nurbs.Knots), weights)

    return tuple(tuple(trim(curve) for curve in loop) for loop in bounds)


def _same_parameters(surface: Any) -> bool:
    """Return whether a surface has the parameters of its NURBS form.

    Surfaces of revolution do not: the parameter of a rational arc is not its angle.
    """
    low, size = np.array([(d.T0, d.T1 - d.T0) for d in (surface.Domain(0), surface.Domain(1))]).T
    # Arcs of a quarter or a third of the domain agree at other points by accident.
    for u, v in low + size * np.array([(0.07, 0.17), (0.31, 0.41), (0.57, 0.61), (0.83, 0.93)]):
        _, *moved = surface.GetNurbsFormParameterFromSurfaceParameter(u, v)
        if not (np.abs(np.array(moved) - (u, v)) <= SAME * np.maximum(size, np.abs((u, v)))).all():
            return False
    return True


def _fitted(curve: Any, moved: Callable[[float, float], tuple[float, float]], scale: F64) -> TrimCurve:
    """Approximate a curve of moved points by cubics, halved until they are within `FITTED` of it."""

    def points(t: F64) -> F64:
        found = [curve.PointAt(each) for each in t.ravel().tolist()]
        return np.array([moved(point.X, point.Y) for point in found]).reshape(*t.shape, 2)

    knots = np.unique(curve.Knots.ToList())
    pieces: list[tuple[float, float, F64]] = []  # start, end, control points
    start, end = knots[:-1], knots[1:]
    through = points(np.linspace(start, end, 4, axis=1))
    while len(start):
        # Cubics through the points at 0, 1/3, 2/3 and 1, measured between them.
        cubics = CUBIC_THROUGH @ through
        middle = (start + end) / 2
        between = points(start[:, None] + (end - start)[:, None] * np.array([1, 3, 5]) / 6)
        close = (np.abs(BETWEEN @ cubics - between) <= FITTED * scale).all(axis=(1, 2))
        done = close | ~((start < middle) & (middle < end))
        pieces += zip(start[done].tolist(), end[done].tolist(), cubics[done], strict=True)
        # The halves interpolate these points and those between them.
        left, middle, right = start[~done], middle[~done], end[~done]
        start, end = np.concatenate([left, middle]), np.concatenate([middle, right])
        a, b, c, d = np.moveaxis(through[~done], 1, 0)
        ab, bc, cd = np.moveaxis(between[~done], 1, 0)
        through = np.concatenate([np.stack([a, ab, b, bc], 1), np.stack([bc, c, cd, d], 1)])
        if len(pieces) + len(start) > MAX_FITTED:
            raise InputError("expected a smooth trim, got one that cubics don't follow")
    pieces.sort(key=lambda piece: piece[0])
    control_points = [cubic[1:] if i else cubic for i, (_, _, cubic) in enumerate(pieces)]
    ends = [pieces[0][0], *(end for _, end, _ in pieces)]
    return TrimCurve(np.concatenate(control_points), np.repeat(ends, [4, *[3] * (len(ends) - 2), 4]))


def _is_border(loops: tuple[Loop, ...], face: Face) -> bool:
    """Return whether a single loop follows the border of the domain, and so trims nothing."""
    if len(loops) != 1:
        return False
    low, high = np.array(face.domain).T
    corners = []
    for curve in loops[0]:
        points = (curve.control_points - low) / (high - low)
        corners.append(points)
        on_side = np.concatenate([np.abs(points) <= BORDER, np.abs(points - 1) <= BORDER], axis=1)  # (n, 4)
        # If all control points of a span lie on one side of the domain, so does the span.
        degree = curve.degree
        spans = np.lib.stride_tricks.sliding_window_view(on_side, degree + 1, axis=0)
        lasting = np.diff(curve.knots)[degree : len(points)] > 0
        if not spans[lasting].all(axis=-1).any(axis=-1).all():
            return False
    u, v = np.concatenate(corners).T
    area = abs(float(u @ np.roll(v, -1) - v @ np.roll(u, -1))) / 2
    return area >= 1 - 8 * BORDER
