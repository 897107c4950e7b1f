"""NURBS surfaces as XML, as G+Smo writes them: gismo/gismo, `src/gsIO/gsXmlUtils.hpp`."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.grids import numbers
from bobrossnet.adapters.xml import read_xml
from bobrossnet.shapes.nurbs import Brep, Face
from bobrossnet.shapes.splines import MAX_DEGREE
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import errors_at, warn_of
from bobrossnet.tracing.instance import Instance

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

SURFACES = ("TensorBSpline2", "TensorNurbs2")


def read_gismo(file: Path) -> list[Instance]:
    """The surfaces of a file, faces of one Brep.

    u is the parameter of basis 0, whose index runs fastest among the control points, which are Euclidean. Those in two
    dimensions lie at z = 0. How patches meet is passed over.

    Raises
    ------
    InputError
        If the XML is more than `read_xml` takes, if it has no surface, or an invalid one.

    Warns
    -----
    InputWarning
        How many curves, volumes and the like were left out.
    """
    from xml.etree.ElementTree import TreeBuilder

    text = file.read_bytes().decode("utf-8-sig").strip()  # some begin with blank lines, against XML
    tree = TreeBuilder()
    read_xml(BytesIO(text.encode()), tree.start, tree.end, tree.data)
    geometries = tree.close().findall("Geometry")
    faces = []
    for number, geometry in enumerate(geometries, 1):
        if geometry.get("type") in SURFACES:
            with errors_at(f"Geometry {number}"):
                faces.append(_face(geometry))
    others = sorted({str(geometry.get("type")) for geometry in geometries} - set(SURFACES))
    if not faces:
        raise InputError(f"expected a Geometry of type {' or '.join(SURFACES)}, got {', '.join(others) or 'none'}")
    if others:
        left_out = len(geometries) - len(faces)
        warn_of(file, f"left out {left_out:,} of {len(geometries):,} geometries that are not surfaces but {others[0]}")
    return [Instance(Brep(faces), name=file.name)]


def _face(geometry: Element) -> Face:
    (knots_u, n), (knots_v, m) = (_knots(geometry, index) for index in ("0", "1"))
    coefs = geometry.find("coefs")
    if coefs is None:
        raise InputError("coefs: expected coefficients, got none")
    dimension = _integer("geoDim", coefs.get("geoDim", "3"), 2, 3)
    points = _table("coefs", coefs, (m, n, dimension)).transpose(1, 0, 2)
    weights = next(geometry.iter("weights"), None)
    return Face(
        np.pad(points, ((0, 0), (0, 0), (0, 3 - dimension))),
        knots_u,
        knots_v,
        None if weights is None else _table("weights", weights, (m, n)).T,
    )


def _knots(geometry: Element, index: str) -> tuple[NDArray[np.float64], int]:
    """The knots of a direction, and how many control points they are for."""
    element = next((basis.find("KnotVector") for basis in geometry.iter("Basis") if basis.get("index") == index), None)
    if element is None:
        raise InputError(f"Basis {index}: expected a KnotVector, got none")
    with errors_at(f"KnotVector {index}"):
        degree = _integer("degree", element.get("degree", "none"), 1, MAX_DEGREE)
        knots = numbers((element.text or "").split())
        count = len(knots) - degree - 1
        if count <= degree:
            raise InputError(f"expected at least {2 * degree + 2} knots for degree {degree}, got {len(knots)}")
    return knots, count


def _table(name: str, element: Element, shape: tuple[int, ...]) -> NDArray[np.float64]:
    with errors_at(name):
        values = numbers((element.text or "").split())
        if len(values) != np.prod(shape):
            raise InputError(f"expected {' x '.join(map(str, shape))} numbers, got {len(values):,}")
    return values.reshape(shape)


def _integer(name: str, text: str, low: int, high: int) -> int:
    if text.strip() not in map(str, range(low, high + 1)):
        raise InputError(f"{name}: expected an integer in {low}..{high}, got {text[:40]}")
    return int(text)
