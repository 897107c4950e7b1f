"""Formulas as 3MF, by its Volumetric and Implicit Extensions 1.0: a level set of a function, which stays a formula.

It has the parts and elements that core/files/threemf reads.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from itertools import product
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.shapes.affine import IDENTITY
from bobrossnet.shapes.implicit import Implicit
from bobrossnet.support.errors import InputError

OPS = (
    "constant", "x", "y", "z", "negate", "absolute", "square", "sqrt", "sin", "cos", "tan", "asin", "acos", "atan",
    "exp", "log", "floor", "ceil", "round", "power", "add", "subtract", "multiply", "divide", "minimum", "maximum",
    "hypot", "atan2", "modulo", "select", "mesh_distance",
)  # fmt: skip
"""Operations by their numbers in formulas."""

KINDS = {
    "absolute": "abs",
    "asin": "arcsin",
    "acos": "arccos",
    "atan": "arctan",
    "add": "addition",
    "subtract": "subtraction",
    "multiply": "multiplication",
    "divide": "division",
    "minimum": "min",
    "maximum": "max",
    "atan2": "arctan2",
    "modulo": "mod",
}
"""Names of nodes by ops; other nodes have the op's name."""

BINARY = OPS[OPS.index("add") : OPS.index("select")]

CONTENT_TYPES = (
    '<?xml version="1.0" encoding="UTF-8"?>'
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
RELATIONS = (
    '<?xml version="1.0" encoding="UTF-8"?>'
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="rel0" '
    'Target="/3D/3dmodel.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)
MODEL = (
    '<?xml version="1.0" encoding="UTF-8"?>'
    '<model unit="millimeter" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" '
    'xmlns:v="http://schemas.3mf.io/3dmanufacturing/volumetric/2022/01" '
    'xmlns:i="http://schemas.3mf.io/3dmanufacturing/implicit/2023/12" requiredextensions="v i"><resources>'
)

MARGIN = 0.01
"""Margin of the domain around a shape without bounds, as a share of its size: its planes touch no surface."""

BOX = ("013", "032", "475", "467", "051", "045", "237", "276", "026", "064", "173", "157")
"""Triangles of a box with corners in the order of `itertools.product`, anticlockwise from outside."""

DOMAIN, SHAPE, COLOR, VOLUME, OBJECT, FIRST_MESH = range(1, 7)
"""Ids of resources."""


def written_3mf(shape: Implicit) -> bytes:
    """A 3MF of a shape within its bounds, in millimetres, whose surface and colour are functions.

    Equal shapes make equal files.

    Raises
    ------
    InputError
        If the formula takes more nodes than are read.
    """
    parts = {
        "[Content_Types].xml": CONTENT_TYPES,
        "_rels/.rels": RELATIONS,
        "3D/3dmodel.model": "".join(_model(shape)),
    }
    content = io.BytesIO()
    with ZipFile(content, "w", ZIP_DEFLATED) as archive:
        for name, text in parts.items():
            archive.writestr(ZipInfo(name), text, ZIP_DEFLATED)
    return content.getvalue()


def _model(shape: Implicit) -> Iterator[str]:
    bounds = shape.bounds
    if bounds is None:
        low, high = shape.bounding_box(IDENTITY)
        bounds = np.array([low - MARGIN * (high - low), high + MARGIN * (high - low)])
    meshes = _Meshes()
    yield MODEL
    yield _mesh(DOMAIN, list(product(*np.transpose(bounds).tolist())), BOX)
    functions = [_function(SHAPE, shape.expression, meshes)]
    volume = ""
    if shape.color_formula is not None:
        functions.append(_function(COLOR, shape.color_formula, meshes))
        volume = f' volumeid="{VOLUME}"'
    yield from meshes.objects
    yield from functions
    if volume:
        yield f'<v:volumedata id="{VOLUME}"><v:color functionid="{COLOR}" channel="color"/></v:volumedata>'
    yield (
        f'<object id="{OBJECT}" type="model"><v:levelset functionid="{SHAPE}" channel="shape" meshid="{DOMAIN}" '
        f'meshbboxonly="true"{volume}/></object></resources><build><item objectid="{OBJECT}"/></build></model>'
    )


class _Meshes:
    """Meshes that functions use, as objects; equal ones are written once."""

    def __init__(self) -> None:
        self.objects: list[str] = []
        self.known: dict[tuple[bytes, bytes], int] = {}

    def ids(self, formula: _core.Expression | _core.ColorFormula) -> list[int]:
        """Nodes of a formula, in its order."""
        if not formula.mesh_arrays:
            return []
        sizes, vertices, triangles = formula.mesh_arrays
        ends = np.cumsum(sizes, axis=0, dtype=np.int64)
        return [
            self.id_of(vertices[v - m : v], triangles[t - n : t])
            for (m, n), (v, t) in zip(sizes.tolist(), ends.tolist(), strict=True)
        ]

    def id_of(self, vertices: NDArray[np.float32], triangles: NDArray[np.uint32]) -> int:
        number = FIRST_MESH + len(self.objects)
        key = vertices.tobytes(), triangles.tobytes()
        if key not in self.known:
            self.known[key] = number
            self.objects.append(_mesh(number, vertices.tolist(), triangles.tolist()))
        return self.known[key]


def _mesh(number: int, vertices: Any, triangles: Any) -> str:
    points = "".join(f'<vertex x="{x!r}" y="{y!r}" z="{z!r}"/>' for x, y, z in vertices)
    corners = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in triangles)
    mesh = f"<mesh><vertices>{points}</vertices><triangles>{corners}</triangles></mesh>"
    return f'<object id="{number}" type="model">{mesh}</object>'


# ---- Functions -------------------------------------------------------------------------------------------


def _function(number: int, formula: _core.Expression | _core.ColorFormula, meshes: _Meshes) -> str:
    """A function of the vector pos, whose output is the scalar shape or the vector color."""
    nodes = _Nodes(meshes.ids(formula))
    values: list[str] = []  # references to scalars
    for op, operands, value in zip(
        formula.ops.tolist(), formula.operands.tolist(), formula.values.tolist(), strict=True
    ):
        values.append(nodes.scalar(OPS[op], [values[i] if i < len(values) else "" for i in operands], value))
    got, most = len(nodes.written), _core.MAX_FUNCTION_NODES
    if got > most:
        raise InputError(f"shape: expected at most {most:,} nodes, which can be read again, got {got:,}")
    if isinstance(formula, _core.ColorFormula):
        red, green, blue = (values[root] for root in formula.roots.tolist())
        output = f'<i:vectorref identifier="color" ref="{nodes.vector(red, green, blue)}"/>'
    else:
        output = f'<i:scalarref identifier="shape" ref="{values[-1]}"/>'
    return (
        f'<i:implicitfunction id="{number}"><i:in><i:vector identifier="pos"/></i:in>{"".join(nodes.written)}'
        f"<i:out>{output}</i:out></i:implicitfunction>"
    )


class _Nodes:
    """The nodes of a function, in order."""

    def __init__(self, meshes: list[int]) -> None:
        self.meshes = meshes
        self.written: list[str] = []
        self.constants: dict[float, str] = {}
        self.position = self.add("decomposevector", {"A": "inputs.pos"}, "x y z", of="vector").removesuffix("x")

    def scalar(self, op: str, operands: list[str], value: float) -> str:
        """Return a reference to the result of an op."""
        if op == "constant":
            return self.constant(value)
        if op in ("x", "y", "z"):
            return self.position + op
        a, b, c = operands
        if op == "negate":
            return self.add("subtraction", {"A": self.constant(0.0), "B": a})
        if op == "square":
            return self.add("multiplication", {"A": a, "B": a})
        if op == "power":
            return self.power(a, int(value))
        if op == "hypot":
            return self.add("length", {"A": self.vector(a, b, self.constant(0.0))}, of="vector")
        if op == "select":
            return self.add("select", {"A": a, "B": self.constant(0.0), "C": b, "D": c})
        if op == "mesh_distance":
            mesh = self.add("constresourceid", {}, "value", f' value="{self.meshes[int(value)]}"', "resourceid")
            return self.add("mesh", {"pos": self.vector(a, b, c), "mesh": mesh}, "distance")
        return self.add(KINDS.get(op, op), {"A": a, "B": b} if op in BINARY else {"A": a})

    def power(self, a: str, exponent: int) -> str:
        """Products: powers of numbers below 0 are not defined everywhere."""
        result = ""
        while exponent:
            if exponent & 1:
                result = self.add("multiplication", {"A": result, "B": a}) if result else a
            exponent >>= 1
            if exponent:
                a = self.add("multiplication", {"A": a, "B": a})
        return result

    def constant(self, value: float) -> str:
        if value not in self.constants:
            text = repr(value).replace("inf", "INF")
            self.constants[value] = self.add("constant", {}, "value", f' value="{text}"')
        return self.constants[value]

    def vector(self, x: str, y: str, z: str) -> str:
        return self.add("composevector", {"x": x, "y": y, "z": z}, made="vector")

    def add(
        self,
        kind: str,
        inputs: dict[str, str],
        outputs: str = "result",
        attributes: str = "",
        made: str = "scalar",
        of: str = "scalar",
    ) -> str:
        """Add a node; returns a reference to its first output. `of` and `made` are the types of inputs and outputs."""
        name = f"n{len(self.written)}"
        types = {"pos": "vector", "mesh": "resource"} if kind == "mesh" else {}
        given = "".join(
            f'<i:{types.get(key, of)}ref identifier="{key}" ref="{reference}"/>' for key, reference in inputs.items()
        )
        found = "".join(f'<i:{made} identifier="{output}"/>' for output in outputs.split())
        head = f"<i:in>{given}</i:in>" if inputs else ""
        self.written.append(f'<i:{kind} identifier="{name}"{attributes}>{head}<i:out>{found}</i:out></i:{kind}>')
        return f"{name}.{outputs.split()[0]}"
