"""NURBS surfaces as JSON, as geomdl's `exchange.export_json` writes them: orbingol/NURBS-Python 5.4, `_exchange.py`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.json import numbers, read_json
from bobrossnet.shapes.nurbs import Brep, Face, TrimCurve
from bobrossnet.shapes.splines import MAX_DEGREE
from bobrossnet.support.errors import InputError, InputTypeError, check_array, check_integer
from bobrossnet.support.messages import errors_at, warn_of
from bobrossnet.tracing.instance import Instance

WORDS: dict[type, str] = {dict: "an object", list: "a list", str: "a string"}


def read_geomdl(file: Path) -> list[Instance]:
    """Read the surfaces of a file: faces of one Brep, or of one Brep per name.

    Control points are Euclidean; v varies fastest. Trims are in the parameters of the file's knots. As in geomdl, the
    inside of a trim is cut away, or the outside if it is `reversed`. Surfaces that are `trimmed` but have no trims in
    the file are shown whole.

    Raises
    ------
    InputError
        If the file has curves or volumes, a field is missing, or a surface is invalid.

    Warns
    -----
    InputWarning
        If surfaces lack their trims, with their number.
    """
    shape = _get(read_json(file.read_bytes()), "shape", dict)
    kind, data = _get(shape, "type", str), _get(shape, "data", list)
    if kind == "curve":
        raise InputError("expected surfaces, got curves, which have no radius; bobrossnet.nurbs_curve gives them one")
    if kind != "surface":
        raise InputError(f"type: expected surface, got {kind}")
    if not data:
        raise InputError("data: expected surfaces, got none")
    count = shape.get("count", len(data))
    if isinstance(count, bool) or count != len(data):
        raise InputError(f"count: expected {len(data)}, the surfaces in data, got {count}")

    named: dict[str, list[Face]] = {}
    untrimmed = 0
    for number, surface in enumerate(data, 1):
        with errors_at(f"surface {number}"):
            face = _face(surface)
            name = _get(surface, "name", str) if surface.get("name") else file.name
            named.setdefault(name, []).append(face)
            untrimmed += bool(surface.get("trimmed")) and not face.trims
    if untrimmed:
        text = f"{untrimmed:,} of {len(data):,} faces are trimmed, but the file has no trim curves"
        warn_of(file, f"{text}: they are shown whole")
    return [Instance(Brep(faces), name=name) for name, faces in named.items()]


def _face(surface: Any) -> Face:
    size_u, size_v = (check_integer(name, _get(surface, name), 2, 1 << 31) for name in ("size_u", "size_v"))
    knots_u, knots_v = _knots(surface, "_u", size_u), _knots(surface, "_v", size_v)
    points, weights = _control_points(surface, size_u * size_v, 3)
    return Face(
        points.reshape(size_u, size_v, 3),
        knots_u,
        knots_v,
        None if weights is None else weights.reshape(size_u, size_v),
        _loops(surface, knots_u, knots_v),
    )


def _loops(surface: Any, knots_u: NDArray[np.float64], knots_v: NDArray[np.float64]) -> list[Any]:
    """Return loops; an odd number of them encloses each kept point."""
    if not surface.get("trims"):
        return []
    loops = []
    keeps_inside = False
    for i, trim in enumerate(_get(_get(surface, "trims", dict), "data", list)):
        with errors_at(f"trims[{i}]"):
            pieces = _get(trim, "data", list) if _get(trim, "type", str) == "container" else [trim]
        loop = []
        for j, piece in enumerate(pieces):
            with errors_at(f"trims[{i}][{j}]"):
                loop.append(_curve(piece))
        loops.append(loop)
        keeps_inside |= bool(trim.get("reversed"))
    if loops and not keeps_inside:
        # Holes need an outer loop, wider than the surface, so that rounding does not matter at its border.
        (u0, u1), (v0, v1) = (_widened(knots[0], knots[-1]) for knots in (knots_u, knots_v))
        loops.append([np.array([(u0, v0), (u1, v0), (u1, v1), (u0, v1)])])
    return loops


def _widened(low: float, high: float) -> tuple[float, float]:
    with np.errstate(over="ignore", invalid="ignore"):  # refused as a trim
        return 2 * low - high, 2 * high - low


def _curve(piece: Any) -> NDArray[np.float64] | TrimCurve:
    kind = _get(piece, "type", str)
    if kind == "freeform":
        return check_array("points", numbers("points", _get(piece, "points", list)), (None, 2))
    if kind != "spline":
        raise InputError(f"type: expected spline, freeform or a container of these, got {kind}")
    count = len(_get(_get(piece, "control_points", dict), "points", list))
    knots = _knots(piece, "", count)
    points, weights = _control_points(piece, count, 2)
    return TrimCurve(points, knots, weights)


def _control_points(spline: Any, count: int, dimension: int) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Return control points (count, dimension), and weights (count,) unless all are 1."""
    fields = _get(spline, "control_points", dict)
    points = check_array("points", numbers("points", _get(fields, "points", list)), (count, dimension))
    weights = check_array("weights", numbers("weights", fields.get("weights", [1] * count)), (count,))
    return points, None if (weights == 1).all() else weights


def _knots(spline: Any, axis: str, count: int) -> NDArray[np.float64]:
    """Return the knots of `count` control points, and check the degree against their number."""
    degree = check_integer(f"degree{axis}", _get(spline, f"degree{axis}"), 1, MAX_DEGREE)
    name = f"knotvector{axis}"
    return check_array(name, numbers(name, _get(spline, name, list)), (count + degree + 1,))


def _get(value: Any, name: str, kind: type = object) -> Any:
    """Return a field of an object, of a given JSON type."""
    if not isinstance(value, dict):
        raise InputTypeError(f"expected an object with {name}, got {type(value).__name__}")
    if name not in value:
        raise InputError(f"{name}: expected one, got none")
    if not isinstance(value[name], kind):
        raise InputTypeError(f"{name}: expected {WORDS[kind]}, got {type(value[name]).__name__}")
    return value[name]
