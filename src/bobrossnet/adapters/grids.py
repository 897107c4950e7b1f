"""Surfaces as bare text: Bezier patches, .bpt, and grids of control points, .cpt."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bobrossnet.shapes.nurbs import Brep, Face
from bobrossnet.shapes.splines import MAX_DEGREE
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import counted, errors_at
from bobrossnet.tracing.instance import Instance


def read_bpt(file: Path) -> list[Instance]:
    """The patches of a file, faces of one Brep, each over (0..1, 0..1).

    The file has the number of patches, then for each its two degrees p and q and (p + 1)(q + 1) points x y z, those
    along the second degree one after another.

    Raises
    ------
    InputError
        If a word is not a number, or there are fewer or more than the file says.
    """
    words = file.read_bytes().decode().split()
    count, at = _integer("number of patches", words, 0), 1
    faces = []
    for number in range(1, count + 1):
        with errors_at(f"patch {number} of {count}"):
            p, q = (_integer("degree", words, at + i) for i in (0, 1))
            if not (1 <= p <= MAX_DEGREE and 1 <= q <= MAX_DEGREE):
                raise InputError(f"degree: expected 1..{MAX_DEGREE} twice, got {p} and {q}")
            end = at + 2 + 3 * (p + 1) * (q + 1)
            if end > len(words):
                raise InputError(f"expected {(p + 1) * (q + 1)} points, got the end of the file")
            points = numbers(words[at + 2 : end]).reshape(p + 1, q + 1, 3)
            faces.append(Face(points, clamped(p + 1, p), clamped(q + 1, q)))
        at = end
    if not faces or at < len(words):
        raise InputError(f"expected {count or 'some'} patches, got {'more' if faces else 'none'}")
    return [Instance(Brep(faces), name=file.name)]


def read_cpt(file: Path) -> list[Instance]:
    """The surface of a grid of control points, as geomdl's `export_txt` writes it.

    A line is a row of points along v, x,y,z;x,y,z;...; the lines follow one another along u. The file says nothing of
    degrees and knots. As in geomdl's examples the surface is cubic, or of a lower degree where there are fewer than
    four points, and its knots are uniform and clamped, over (0..1, 0..1).

    Raises
    ------
    InputError
        If rows differ in length, a point has not three numbers, or there are fewer than two rows or columns.
    """
    rows = [line.strip().split(";") for line in file.read_bytes().decode().splitlines() if line.strip()]
    grid = []
    for number, row in enumerate(rows, 1):
        with errors_at(f"row {number}"):
            if len(row) != len(rows[0]):
                raise InputError(f"expected {counted(len(rows[0]), 'point')} as in the first row, got {len(row)}")
            points = [numbers(point.split(",")) for point in row]
            if any(len(point) != 3 for point in points):
                raise InputError("expected points of three numbers x,y,z, got others")
            grid.append(points)
    if len(rows) < 2 or len(rows[0]) < 2:
        raise InputError(f"expected at least 2 x 2 points, got {len(rows)} x {len(rows[0]) if rows else 0}")
    knots_u, knots_v = (clamped(count, min(3, count - 1)) for count in (len(rows), len(rows[0])))
    return [Instance(Brep([Face(np.array(grid), knots_u, knots_v)]), name=file.name)]


def numbers(words: Iterable[str]) -> NDArray[np.float64]:
    """Words as numbers (n,)."""
    values = []
    for word in words:
        try:
            values.append(float(word))
        except ValueError as error:
            raise InputError(f"expected a number, got {word[:40]!r}") from error
    return np.array(values, dtype=np.float64)


def clamped(count: int, degree: int) -> NDArray[np.float64]:
    """The knots of `count` control points, uniform and clamped, over 0..1; a Bezier patch's if there are degree + 1."""
    return np.concatenate([np.zeros(degree), np.linspace(0, 1, count - degree + 1), np.ones(degree)])


def _integer(name: str, words: list[str], at: int) -> int:
    word = words[at] if at < len(words) else "the end of the file"
    if not (word.isascii() and word.isdecimal() and len(word) < 10):
        raise InputError(f"{name}: expected a whole number of at most 9 digits, got {word[:40]}")
    return int(word)
