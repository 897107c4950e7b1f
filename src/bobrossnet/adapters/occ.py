"""Contents of STEP and IGES files, as plain data. Importing this module imports OpenCascade."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
from OCP.BRepTools import BRepTools, BRepTools_WireExplorer
from OCP.Geom2d import Geom2d_TrimmedCurve
from OCP.Geom2dConvert import Geom2dConvert, Geom2dConvert_ApproxCurve
from OCP.GeomAbs import GeomAbs_Shape
from OCP.GeomConvert import GeomConvert, GeomConvert_ApproxSurface
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESCAFControl import IGESCAFControl_Reader
from OCP.Quantity import Quantity_Color
from OCP.ShapeAnalysis import ShapeAnalysis_ShapeTolerance
from OCP.ShapeFix import ShapeFix_ShapeTolerance
from OCP.ShapeUpgrade import ShapeUpgrade_ShapeDivideClosed
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.STEPConstruct import STEPConstruct_ExternRefs
from OCP.STEPControl import STEPControl_Reader
from OCP.TCollection import TCollection_AsciiString, TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_ChildIterator, TDF_Label, TDF_Tool
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS
from OCP.XCAFDoc import XCAFDoc_ColorTool, XCAFDoc_ColorType, XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

from bobrossnet import _core
from bobrossnet.adapters.apart import divided, limit
from bobrossnet.adapters.beside import find_beside
from bobrossnet.adapters.opencascade import Assembly, Body, Color, CurveData, FaceData, Placed, Triangles
from bobrossnet.adapters.part import Names, Part, placed
from bobrossnet.shapes.splines import MAX_DEGREE
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import one_line

# Of approximations of surfaces and curves of too high a degree.
MAX_SPANS = 1000

# Of approximations, relative to the part's size: a thousandth of a pixel in a large picture of it.
RELATIVE_TOLERANCE = 1e-6

# Maximum gap between edges of neighbouring faces, in sizes of their part.
MAX_GAP = 1e-3

# Relative to the domain: points closer to the surface's border lie on it.
ON_BORDER = 1e-6


@np.errstate(all="ignore")  # numbers of damaged files that are not finite are refused later
def read_assembly(kind: str, file: str) -> Assembly:
    """Return the contents of a STEP or IGES file. Prints to stdout, and may crash."""
    limit(_size(file))
    reader = STEPCAFControl_Reader() if kind == "STEP" else IGESCAFControl_Reader()
    reader.SetNameMode(True)
    reader.SetColorMode(True)
    if reader.ReadFile(file) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise InputError(f"expected {'a STEP' if kind == 'STEP' else 'an IGES'} file, got one that can't be parsed")
    if kind == "STEP":
        parts: set[Path] = set()
        _check_parts_beside(Path(file), reader.ChangeReader(), parts)
        if len(parts) > 1:
            limit(sum(map(_size, parts)))
    XCAFDoc_ShapeTool.SetAutoNaming_s(False)  # only names from the file
    document = TDocStd_Document(TCollection_ExtendedString("BinXCAF"))
    reader.Transfer(document)  # returns only whether there was anything
    walk = _Walk()
    for label in _children(XCAFDoc_DocumentTool.ShapesLabel_s(document.Main())):
        if walk.tool.IsShape_s(label) and walk.tool.IsFree_s(label):
            walk.visit(label, np.eye(4), None, ())
    walk.convert()
    if walk.total == 0:
        held = ", ".join(f"{name} ({count:,})" for name, count in walk.others.items() if count)
        raise InputError(f"expected faces, got {held or 'nothing that OpenCascade knows'}")
    return Assembly(walk.parts, walk.placed, walk.dropped, walk.total)


def _size(file: str | Path) -> int:
    return os.stat(file).st_size


def _check_parts_beside(file: Path, reader: STEPControl_Reader, visited: set[Path]) -> None:
    """Refuse an assembly that refers to parts outside its folder: OpenCascade would read them and their references."""
    visited.add(file)
    references = STEPConstruct_ExternRefs(reader.WS())
    references.LoadExternRefs()
    for number in range(1, references.NbExternRefs() + 1):
        name = references.FileName(number)
        find_beside(file, name)
        part = file.parent / name
        if part not in visited:
            reader_of_part = STEPControl_Reader()
            if reader_of_part.ReadFile(str(part)) == IFSelect_ReturnStatus.IFSelect_RetDone:
                _check_parts_beside(part, reader_of_part, visited)


class _Waiting(NamedTuple):
    """A face to convert, and its place."""

    face: Any
    tolerance: float
    body: Body
    color: Color | None
    number: int


class _Walk:
    """Parts and their places, collected from a document's tree of labels."""

    def __init__(self) -> None:
        self.tool = XCAFDoc_ShapeTool
        self.names = Names()
        self.parts: list[list[Body]] = []
        self.placed: list[Placed] = []
        self.indices: dict[str, int] = {}  # of parts, by the entries of their labels
        self.visited = self.total = 0
        self.waiting: list[_Waiting] = []
        self.dropped: list[str] = []
        self.others = {"hidden parts": 0, "curves": 0, "points": 0}

    def visit(self, label: Any, matrix: NDArray[np.float64], inherited: Color | None, parent: tuple[str, ...]) -> None:
        """Collect the parts of a label; those without a colour get `inherited`."""
        self.visited += 1
        if self.visited > _core.MAX_INSTANCES:  # assemblies of assemblies can repeat one part without end
            raise InputError(f"expected at most {_core.MAX_INSTANCES:,} instances of parts, got more")
        if not XCAFDoc_ColorTool.IsVisible_s(label):
            self.others["hidden parts"] += 1
            return
        color, name = _color(label), _name(label)
        if self.tool.IsReference_s(label):
            matrix = matrix @ _matrix(self.tool.GetLocation_s(label).Transformation())
            referred = TDF_Label()
            self.tool.GetReferredShape_s(label, referred)
            label = referred
            color = color or _color(label)
        color = color or inherited
        path = self.names.path(parent, one_line(_name(label) or name) or "part")
        if self.tool.IsAssembly_s(label):
            for component in _children(label):
                if self.tool.IsComponent_s(component):
                    self.visit(component, matrix, color, path)
        else:
            self.placed.append(Placed(self.part(label), matrix, _name(label), path, color))

    def convert(self) -> None:
        """Convert the faces of all parts, which takes most of the time."""
        calls = [partial(_faces_or_error, each.face, each.tolerance) for each in self.waiting]
        for found, each in zip(divided(calls), self.waiting, strict=True):
            if isinstance(found, str):
                self.dropped.append(found)
                continue
            each.body.faces.extend(found)
            each.body.colors.extend([each.color] * len(found))
            each.body.numbers.extend([each.number] * len(found))

    def part(self, label: Any) -> int:
        """Return the index of a label's part; collect its bodies once."""
        entry = TCollection_AsciiString()
        TDF_Tool.Entry_s(label, entry)
        key = entry.ToCString()
        if key not in self.indices:
            self.indices[key] = len(self.parts)
            self.parts.append(self.bodies(label))
        return self.indices[key]

    def bodies(self, label: Any) -> list[Body]:
        """Collect the solids, shells and single faces of a part."""
        shape = self.tool.GetShape_s(label)
        if shape.IsNull():
            return []
        BRepTools.Clean_s(shape)  # removes triangles that files store next to surfaces; other triangles stay
        colors = {
            _key(self.tool.GetShape_s(child)): _color(child)
            for child in _children(label)
            if self.tool.IsSubShape_s(child)
        }
        box = Bnd_Box()
        BRepBndLib.Add_s(shape, box)
        size = 0.0 if box.IsVoid() else box.SquareExtent() ** 0.5
        groups = [
            *([solid] for solid in _explore(shape, TopAbs_ShapeEnum.TopAbs_SOLID)),
            *([shell] for shell in _explore(shape, TopAbs_ShapeEnum.TopAbs_SHELL, TopAbs_ShapeEnum.TopAbs_SOLID)),
            list(_explore(shape, TopAbs_ShapeEnum.TopAbs_FACE, TopAbs_ShapeEnum.TopAbs_SHELL)),
        ]
        self.others["curves"] += sum(
            1 for _ in _explore(shape, TopAbs_ShapeEnum.TopAbs_EDGE, TopAbs_ShapeEnum.TopAbs_FACE)
        )
        self.others["points"] += sum(
            1 for _ in _explore(shape, TopAbs_ShapeEnum.TopAbs_VERTEX, TopAbs_ShapeEnum.TopAbs_EDGE)
        )
        return [self.body(group, colors, size) for group in groups]

    def body(self, shapes: list[Any], colors: dict[int, Color | None], size: float) -> Body:
        """Collect the faces of a solid, of a shell, or single ones. Those with a surface wait for `convert`."""
        tolerance = RELATIVE_TOLERANCE * size
        gap = 5 * tolerance  # approximations may lie slightly farther apart
        for shape in shapes:
            stored = ShapeAnalysis_ShapeTolerance().Tolerance(shape, 1, TopAbs_ShapeEnum.TopAbs_EDGE)
            gap = max(gap, min(stored, MAX_GAP * size))
        body = Body([], [], [], [], gap)
        for shape in shapes:
            whole = colors.get(_key(shape))
            of_shell = {
                _key(face): colors.get(_key(shell))
                for shell in _explore(shape, TopAbs_ShapeEnum.TopAbs_SHELL)
                for face in _explore(shell, TopAbs_ShapeEnum.TopAbs_FACE)
            }
            for face in _explore(shape, TopAbs_ShapeEnum.TopAbs_FACE):
                key = _key(face)
                color = colors.get(key) or of_shell.get(key) or whole
                self.total += 1
                if BRep_Tool.Surface_s(TopoDS.Face(face)) is None:  # OpenCascade would crash
                    body.triangles.extend(_triangles(TopoDS.Face(face), color))
                else:
                    self.waiting.append(_Waiting(face, tolerance, body, color, self.total))
        return body


def _children(label: Any) -> Iterator[Any]:
    child = TDF_ChildIterator(label)
    while child.More():
        yield child.Value()
        child.Next()


def _explore(shape: Any, kind: Any, outside: Any = None) -> Iterator[Any]:
    """Return the shapes of a kind in another, except those within a shape of the kind `outside`."""
    explorer = TopExp_Explorer(shape, kind, TopAbs_ShapeEnum.TopAbs_SHAPE if outside is None else outside)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def _key(shape: Any) -> int:
    """Return a key of a shape, equal for all its handles and orientations: handles compare by identity."""
    return hash(shape.Oriented(TopAbs_Orientation.TopAbs_FORWARD))


def _name(label: Any) -> str:
    if not label.IsAttribute(TDataStd_Name.GetID_s()):  # access to a missing attribute would crash
        return ""
    attribute = TDataStd_Name()
    label.FindAttribute(TDataStd_Name.GetID_s(), attribute)
    name: str = TCollection_AsciiString(attribute.Get()).ToCString()
    return name


def _color(label: Any) -> Color | None:
    color = Quantity_Color()
    for kind in (XCAFDoc_ColorType.XCAFDoc_ColorSurf, XCAFDoc_ColorType.XCAFDoc_ColorGen):
        if XCAFDoc_ColorTool.GetColor_s(label, kind, color):
            red, green, blue = (float(np.clip(c, 0, 1)) for c in (color.Red(), color.Green(), color.Blue()))
            return red, green, blue
    return None


def _matrix(transformation: Any) -> NDArray[np.float64]:
    """A gp_Trsf as (4, 4)."""
    matrix = np.eye(4)
    matrix[:3] = [[transformation.Value(row, column) for column in range(1, 5)] for row in range(1, 4)]
    return matrix


def _triangles(face: Any, color: Color | None) -> list[Triangles]:
    """Return the triangles of a face, placed; None without any."""
    location = TopLoc_Location()
    stored = BRep_Tool.Triangulation_s(face, location)
    if stored is None:
        return []
    matrix = _matrix(location.Transformation())
    indices = range(1, stored.NbNodes() + 1)
    points = np.array([_coordinates(stored.Node(i)) for i in indices]).reshape(-1, 3)
    triangles = np.array([stored.Triangle(i).Get() for i in range(1, stored.NbTriangles() + 1)], np.int64) - 1
    normals = np.array([_coordinates(stored.Normal(i)) for i in indices]) if stored.HasNormals() else None
    part = placed(Part(points, triangles.reshape(-1, 3), normals), matrix)
    if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        turned = None if part.normals is None else -part.normals
        part = part._replace(triangles=part.triangles[:, ::-1], normals=turned)
    return [Triangles(part.vertices, part.triangles, part.normals, color)]


# ---- From OpenCascade's faces to NURBS -------------------------------------------------------------------


def _faces_or_error(face: Any, tolerance: float) -> list[FaceData] | str:
    """Return `_faces`, or the reason for none."""
    try:
        return _faces(face, tolerance)
    except Exception as error:  # of any type: OpenCascade has no common one
        return f"{type(error).__name__}: {error}"


def _faces(face: Any, tolerance: float) -> list[FaceData]:
    """Return a face as trimmed NURBS; a closed surface is cut open into several."""
    # Curves in the (u, v) of NURBS are approximated within their edges' tolerance. OpenCascade's usual 1e-7 mm make it
    # ten times slower, and hundreds of control points a curve.
    ShapeFix_ShapeTolerance().LimitTolerance(face, tolerance, 0.0, TopAbs_ShapeEnum.TopAbs_EDGE)
    converted = BRepBuilderAPI_NurbsConvert(face, True).Shape()
    # Without seams, trims can't leave the domain by a period, and no curve is two borders. Cutting before conversion
    # would be faster for tori, but fails on spheres drilled across their seam.
    divide = ShapeUpgrade_ShapeDivideClosed(converted)
    divide.Perform()
    return [_face_data(piece, tolerance) for piece in _explore(divide.Result(), TopAbs_ShapeEnum.TopAbs_FACE)]


def _face_data(shape: Any, tolerance: float) -> FaceData:
    face = TopoDS.Face(shape.Oriented(TopAbs_Orientation.TopAbs_FORWARD))
    loops = [_loop(TopoDS.Wire(wire), face) for wire in _explore(face, TopAbs_ShapeEnum.TopAbs_WIRE)]
    loops = [loop for loop in loops if loop]
    surface = GeomConvert.SurfaceToBSplineSurface_s(BRep_Tool.Surface_s(face))  # a placed copy
    if surface.IsUPeriodic() or surface.IsVPeriodic():
        _open(surface, loops)
    bounds = np.array(surface.Bounds()).reshape(2, 2).T
    if max(surface.UDegree(), surface.VDegree()) > MAX_DEGREE:
        smooth = GeomAbs_Shape.GeomAbs_C1
        lower = GeomConvert_ApproxSurface(surface, tolerance, smooth, smooth, MAX_DEGREE, MAX_DEGREE, MAX_SPANS, 0)
        surface = lower.Surface()

    rows, columns = range(1, surface.NbUPoles() + 1), range(1, surface.NbVPoles() + 1)
    data = FaceData(
        np.array([[_coordinates(surface.Pole(i, j)) for j in columns] for i in rows]),
        _numbers(surface.UKnotSequence()),
        _numbers(surface.VKnotSequence()),
        np.array([[surface.Weight(i, j) for j in columns] for i in rows])
        if surface.IsURational() or surface.IsVRational()
        else None,
        loops,
    )
    if len(loops) == 1 and _is_border(loops[0], bounds):
        return data._replace(trims=[])
    flat = data.weights is None and data.control_points.shape == (2, 2, 3)
    return _widened(data) if loops and flat else data


def _loop(wire: Any, face: Any) -> list[CurveData]:
    """Return a wire's curves in (u, v), end to end."""
    border = (TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED)
    stored = [edge for edge in _explore(wire, TopAbs_ShapeEnum.TopAbs_EDGE) if edge.Orientation() in border]
    edges = []
    explorer = BRepTools_WireExplorer(wire, face)
    while explorer.More():
        edges.append(explorer.Current())
        explorer.Next()
    # The explorer stops at edges without a common vertex; files store most wires in order.
    return [_curve(edge, face) for edge in (edges if len(edges) == len(stored) else stored)]


def _curve(edge: Any, face: Any) -> CurveData:
    edge = TopoDS.Edge(edge)
    first, last = BRep_Tool.Range_s(edge, face)
    stored = BRep_Tool.CurveOnSurface_s(edge, face, first, last)
    curve = Geom2dConvert.CurveToBSplineCurve_s(Geom2d_TrimmedCurve(stored, first, last))
    if curve.Degree() > MAX_DEGREE:
        u0, u1, v0, v1 = BRep_Tool.Surface_s(face).Bounds()
        near = RELATIVE_TOLERANCE * max(u1 - u0, v1 - v0)
        curve = Geom2dConvert_ApproxCurve(curve, near, GeomAbs_Shape.GeomAbs_C0, MAX_SPANS, MAX_DEGREE).Curve()
    if edge.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        curve.Reverse()
    indices = range(1, curve.NbPoles() + 1)
    return CurveData(
        np.array([_coordinates(curve.Pole(i)) for i in indices]),
        _numbers(curve.KnotSequence()),
        np.array([curve.Weight(i) for i in indices]) if curve.IsRational() else None,
    )


def _coordinates(point: Any) -> list[float]:
    return [point.Coord(i) for i in range(1, 3 + hasattr(point, "Z"))]


def _numbers(array: Any) -> NDArray[np.float64]:
    """Return one of OpenCascade's arrays. Its own iterator takes a hundred times as long for each array."""
    return np.array([array.Value(i) for i in range(array.Lower(), array.Upper() + 1)])


def _open(surface: Any, loops: list[list[CurveData]]) -> None:
    """Cut a periodic surface open to the range of its loops."""
    bounds = np.array(surface.Bounds()).reshape(2, 2).T
    if loops:
        points = np.concatenate([curve.control_points for loop in loops for curve in loop])
        needed = np.stack([points.min(axis=0), points.max(axis=0)])
        fits = needed[1] - needed[0] <= bounds[1] - bounds[0]
        periodic = np.array([surface.IsUPeriodic(), surface.IsVPeriodic()])
        bounds = np.where(fits & periodic, needed, bounds)
    (u0, v0), (u1, v1) = bounds
    surface.Segment(u0, u1, v0, v1)


def _is_border(loop: list[CurveData], bounds: NDArray[np.float64]) -> bool:
    """Return whether a loop follows the border of the domain from `bounds[0]` to `bounds[1]`."""
    size = bounds[1] - bounds[0]
    corners = []
    for curve in loop:
        points = (curve.control_points - bounds[0]) / size
        if not (np.abs(points[None] - np.array([[[0.0]], [[1.0]]])) < ON_BORDER).all(axis=1).any():
            return False
        corners.append(points[0])
    u, v = np.array(corners).T
    area = 0.5 * abs(np.dot(u, np.roll(v, -1)) - np.dot(v, np.roll(u, -1)))
    return bool(abs(area - 1) < 4 * ON_BORDER)


def _widened(face: FaceData) -> FaceData:
    """Return a bilinear surface without weights, extended by 1 % on each side: trims on its border end inside."""
    e = 0.01
    stretch = np.array([[1 + e, -e], [-e, 1 + e]])
    return face._replace(
        control_points=np.einsum("ia,jb,abk->ijk", stretch, stretch, face.control_points),
        knots_u=np.repeat(stretch @ face.knots_u[1:3], 2),
        knots_v=np.repeat(stretch @ face.knots_v[1:3], 2),
    )
