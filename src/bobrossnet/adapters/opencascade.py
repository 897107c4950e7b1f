"""STEP and IGES, read by OpenCascade: solids and shells as trimmed NURBS, with their names, colours and places.

OpenCascade takes seconds to import, prints to stdout, and crashes on many damaged files. So it only runs in a separate
process (`apart.py`), where `occ.py` turns its shapes into plain data. This module turns the data into instances.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.apart import call_apart, check_library
from bobrossnet.adapters.joined import joined
from bobrossnet.adapters.part import Found, Part
from bobrossnet.adapters.reader import OPENCASCADE
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.shapes.nurbs import Brep, Face, TrimCurve
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import counted, name_of, one_line, warn_of
from bobrossnet.tracing.instance import Instance, Piece
from bobrossnet.tracing.material import Material

# Bytes at a file's beginning and end that identify it.
LOOKED_AT = 4096

# To which OpenCascade converts the lengths of all files.
UNIT = "mm"

Color = tuple[float, float, float]  # linear RGB


class CurveData(NamedTuple):
    control_points: NDArray[np.float64]  # (n, 2)
    knots: NDArray[np.float64]  # (n + p + 1,)
    weights: NDArray[np.float64] | None  # (n,)


class FaceData(NamedTuple):
    control_points: NDArray[np.float64]  # (n, m, 3)
    knots_u: NDArray[np.float64]
    knots_v: NDArray[np.float64]
    weights: NDArray[np.float64] | None  # (n, m)
    trims: list[list[CurveData]]


class Triangles(NamedTuple):
    """A face stored as triangles, without a surface."""

    vertices: NDArray[np.float64]  # (V, 3)
    triangles: NDArray[np.int64]  # (T, 3)
    normals: NDArray[np.float64] | None  # (V, 3)
    color: Color | None  # None: the colour of the instance


class Body(NamedTuple):
    """The faces of a solid or a shell, or all faces outside both."""

    faces: list[FaceData]
    colors: list[Color | None]  # of the faces; None: the colour of the instance
    numbers: list[int]  # of the faces; equal for pieces of one
    triangles: list[Triangles]
    tolerance: float  # maximum gap between edges of neighbouring faces


class Placed(NamedTuple):
    """A part in its place."""

    part: int  # index of its bodies
    matrix: NDArray[np.float64]  # (4, 4), multiplied from the left
    name: str  # empty if unnamed
    path: tuple[str, ...]  # in the tree of parts
    color: Color | None


class Assembly(NamedTuple):
    """The contents of a file, in plain data."""

    parts: list[list[Body]]
    placed: list[Placed]
    dropped: list[str]  # the reason for each unconverted face
    total: int


def read_step(file: Path) -> Found[Instance]:
    """Return the solids and shells of a STEP file, in millimetres: OpenCascade converts other units.

    Parameters
    ----------
    file : Path
        Of application protocol AP203, AP214 or AP242.

    Returns
    -------
    list of Instance, with their unit
        One for each solid, each shell outside solids, and the faces outside shells, in each place of an assembly. Its
        material has its colour, or is white if its faces have several. Faces that AP242 stores as triangles without a
        surface are separate meshes. Names come from the file's products, else from the file. Points, curves and
        hidden parts are left out.

    Raises
    ------
    InputError
        If OpenCascade is not installed or can't read the file, or if it has no visible faces.

    Warns
    -----
    InputWarning
        If faces were left out.
    """
    return _read(file, "STEP")


def read_iges(file: Path) -> Found[Instance]:
    """Return the surfaces, shells and solids of an IGES file, in millimetres; otherwise like `read_step`."""
    return _read(file, "IGES")


def _read(file: Path, kind: str) -> Found[Instance]:
    check_library("OCP", "OpenCascade", file)
    (_check_step if kind == "STEP" else _check_iges)(file)
    assembly: Assembly = call_apart(OPENCASCADE, "read_assembly", kind, str(file))
    dropped = assembly.dropped
    parts = [[_Solid(body, dropped) for body in bodies] for bodies in assembly.parts]
    instances = [
        instance
        for place in assembly.placed
        for solid in parts[place.part]
        for instance in solid.placed(place, one_line(place.name) or name_of(file))
    ]
    if not instances:
        raise InputError(f"expected faces, got {assembly.total:,} that can't be converted ({dropped[0]})")
    if dropped:
        warn_of(file, f"left out {len(dropped):,} of {counted(assembly.total, 'face')} ({dropped[0]})")
    return Found(instances, UNIT)


def _check_step(file: Path) -> None:
    """Raise InputError for a file that can't be STEP."""
    with file.open("rb") as stream:
        if b"ISO-10303-21" not in stream.read(LOOKED_AT):
            raise InputError("expected a STEP file, which begins with ISO-10303-21, got another")


def _check_iges(file: Path) -> None:
    """Raise InputError for a file that can't be a whole IGES file: OpenCascade accepts truncated ones.

    Column 73 of 80 has the letter of the section, from S for start to T for terminate.
    """
    with file.open("rb") as stream:
        first = stream.read(LOOKED_AT)
        stream.seek(-min(LOOKED_AT, file.stat().st_size), os.SEEK_END)
        last = stream.read()
    if not any(line[72:73] == b"S" for line in first.splitlines()):
        raise InputError("expected an IGES file of ASCII lines, the first of them marked S, got another")
    if not any(line[72:73] == b"T" for line in last.splitlines()):
        raise InputError("expected an IGES file that ends with a line marked T, got one that ends before")


class _Solid:
    """A body with checked faces, and its shapes by colour."""

    def __init__(self, body: Body, dropped: list[str]) -> None:
        self.tolerance = body.tolerance
        self.faces: list[Face] = []
        self.colors: list[Color | None] = []
        numbers: list[int] = []
        self.plain: Brep | None = None
        self.painted: dict[Color | None, Brep] = {}  # by the colour of faces without one
        self.meshes: list[tuple[Mesh, Color | None]] = []
        for data, color, number in zip(body.faces, body.colors, body.numbers, strict=True):
            try:
                self.faces.append(_face(data))
            except InputError as error:
                dropped.append(str(error))
            else:
                self.colors.append(color)
                numbers.append(number)
        self.numbers = np.unique(numbers, return_inverse=True)[1] if len({*numbers}) < len(numbers) else None
        parts: dict[Color | None, list[Part]] = {}
        for vertices, triangles, normals, color in body.triangles:
            parts.setdefault(color, []).append(Part(vertices, triangles, normals))
        for color, alike in parts.items():
            try:
                self.meshes.append((joined(alike).drawn().mesh(), color))
            except InputError as error:
                dropped.append(str(error))

    def placed(self, place: Placed, name: str) -> list[Instance]:
        """Return instances of the faces with a surface, and of triangles by their colours."""
        of_place = name, [Piece(place.path)]
        meshes = [
            Instance(mesh, place.matrix, _material(color or place.color), *of_place) for mesh, color in self.meshes
        ]
        return [self._surfaces(place, name), *meshes] if self.faces else meshes

    def _surfaces(self, place: Placed, name: str) -> Instance:
        """Return an instance. A single colour becomes its material: places in other colours share the shape."""
        colors = {color or place.color for color in self.colors}
        if len(colors) == 1:
            (color,) = colors
            self.plain = self.plain or Brep(self.faces, self.tolerance, self.numbers)
            return Instance(self.plain, place.matrix, _material(color), name, [Piece(place.path)])
        if place.color not in self.painted:
            faces = zip(self.faces, self.colors, strict=True)
            painted = [_painted(face, color or place.color) for face, color in faces]
            self.painted[place.color] = Brep(painted, self.tolerance, self.numbers)
        return Instance(self.painted[place.color], place.matrix, None, name, [Piece(place.path)])


def _material(color: Color | None) -> Material | None:
    return None if color is None else Material(color)


def _face(data: FaceData) -> Face:
    trims = [[TrimCurve(*curve) for curve in loop] for loop in data.trims]
    return Face(data.control_points, data.knots_u, data.knots_v, data.weights, trims or None)


def _painted(face: Face, color: Color | None) -> Face:
    return Face(face.control_points, face.knots_u, face.knots_v, face.weights, face.trims or None, color)
