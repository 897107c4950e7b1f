"""NURBS surfaces, trimmed, and boundary representations of several."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import Color, linear
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.shapes.shape import Shape, check_tensors, frozen
from bobrossnet.shapes.splines import (
    MAX_DEGREE,
    Values,
    check_control_points,
    check_knots,
    check_tuple,
    check_weights,
    degree_of,
    domain_of,
    place_in_errors,
    with_weights,
)
from bobrossnet.support.errors import (
    InputError,
    InputTypeError,
    check_array,
    check_integer,
    check_number,
    shape_of,
    warn_coarse,
)
from bobrossnet.support.messages import counted
from bobrossnet.support.threads import lazy


@dataclass(frozen=True, eq=False, init=False, slots=True)
class TrimCurve:
    """A NURBS curve in a face's parameters (u, v), part of a trim loop.

    Parameters
    ----------
    control_points : (n, 2) numbers, finite
    knots : (n + p + 1,) numbers, non-decreasing
        The degree p, 1..9, follows from the lengths; the domain is knots[p] to knots[n].
    weights : (n,) numbers above 0, optional

    Raises
    ------
    InputError
        If a shape or a value is out of range; the message names it.
    """

    control_points: Values
    knots: Values
    weights: Values | None

    def __init__(self, control_points: Any, knots: Any, weights: Any = None) -> None:
        points = check_control_points("control_points", control_points, (None, 2))
        object.__setattr__(self, "control_points", points)
        object.__setattr__(self, "knots", check_knots("knots", knots, len(points)))
        object.__setattr__(self, "weights", check_weights("weights", weights, (len(points),)))

    def __reduce__(self) -> tuple[Any, ...]:
        return TrimCurve, (self.control_points, self.knots, self.weights)  # keeps the arrays read-only

    @property
    def degree(self) -> int:
        return degree_of(self.knots, len(self.control_points))

    @property
    def domain(self) -> tuple[float, float]:
        return domain_of(self.knots, self.degree)


Loop = tuple[TrimCurve, ...]


@dataclass(frozen=True, eq=False, init=False, slots=True)
class Face:
    """A NURBS surface, with or without trims.

    Parameters
    ----------
    control_points : (n, m, 3) numbers, finite
        In the shape's unit, not multiplied by weights; n along u, m along v, at least 2 each.
    knots_u, knots_v : (n + p + 1,) and (m + q + 1,) numbers, non-decreasing
        Complete knot vectors, as in *The NURBS Book*; the degrees p and q, 1..9, follow from the lengths. Unclamped
        vectors are allowed: the domain is knots_u[p] to knots_u[n], and likewise for v.
    weights : (n, m) numbers above 0, optional
        Within a factor of 1e10.
    trims : sequence of loops, optional
        A point of the surface is kept if an odd number of loops encloses it, in either direction; without loops, all
        points are. A loop is an (n, 2) array, a polygon in (u, v); a `TrimCurve`; or a sequence of arrays, as
        polylines, and curves, end to end. Straight lines close any gaps.
    color : str or 3 numbers in 0..1, optional
        sRGB as "#rrggbb", or linear RGB, multiplied by the material's colour; by default white.

    Attributes
    ----------
    trims : tuple of loops, each a tuple of TrimCurve
    color : (red, green, blue), linear RGB, or None

    Raises
    ------
    InputError
        If a shape or a value is out of range; the message names it, such as `trims[2][0].knots`.
    """

    control_points: Values
    knots_u: Values
    knots_v: Values
    weights: Values | None
    trims: tuple[Loop, ...]
    color: tuple[float, float, float] | None

    def __init__(
        self,
        control_points: Any,
        knots_u: Any,
        knots_v: Any,
        weights: Any = None,
        trims: Any = None,
        color: Color | None = None,
    ) -> None:
        points = check_control_points("control_points", control_points, (None, None, 3))
        loops = () if trims is None else check_tuple("trims", trims, "a sequence of loops")
        object.__setattr__(self, "control_points", points)
        object.__setattr__(self, "knots_u", check_knots("knots_u", knots_u, points.shape[0]))
        object.__setattr__(self, "knots_v", check_knots("knots_v", knots_v, points.shape[1]))
        object.__setattr__(self, "weights", check_weights("weights", weights, points.shape[:2]))
        object.__setattr__(self, "trims", tuple(_loop(f"trims[{i}]", loop) for i, loop in enumerate(loops)))
        object.__setattr__(self, "color", None if color is None else linear("color", color))

    def __reduce__(self) -> tuple[Any, ...]:
        return Face, (self.control_points, self.knots_u, self.knots_v, self.weights, self.trims, self.color)

    @property
    def degree_u(self) -> int:
        return degree_of(self.knots_u, self.control_points.shape[0])

    @property
    def degree_v(self) -> int:
        return degree_of(self.knots_v, self.control_points.shape[1])

    @property
    def domain(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """((u0, u1), (v0, v1)): the first and the last parameters."""
        return domain_of(self.knots_u, self.degree_u), domain_of(self.knots_v, self.degree_v)

    def points(self, u: Any, v: Any) -> Values:
        """Evaluate points S(u, v) of the surface, inside or outside the trims.

        Parameters
        ----------
        u, v : numbers, or arrays that broadcast to one shape
            Within the domain.

        Returns
        -------
        (..., 3) float64

        Raises
        ------
        InputError
            If a parameter lies outside the domain.
        """
        points: Values = self.derivatives(u, v, 0)[..., 0, 0, :]
        return points

    def derivatives(self, u: Any, v: Any, order: int) -> Values:
        """Evaluate partial derivatives up to an order in 0..9, by A4.4 of *The NURBS Book*.

        Parameters
        ----------
        u, v : as for `points`
        order : int in 0..9

        Returns
        -------
        (..., order + 1, order + 1, 3) float64
            [..., k, l, :] is d^(k+l) S / du^k dv^l; zero where k + l > order.
        """
        order = check_integer("order", order, 0, MAX_DEGREE)
        (u0, u1), (v0, v1) = self.domain
        at_u, at_v = _parameters("u", u, u0, u1), _parameters("v", v, v0, v1)
        try:
            at_u, at_v = np.broadcast_arrays(at_u, at_v)
        except ValueError:
            raise InputError(f"v: expected a shape that broadcasts with u's {at_u.shape}, got {at_v.shape}") from None
        result = _core.surface_derivatives(
            _core.homogeneous(_with_weights(self)).reshape(*self.control_points.shape[:2], 4),
            self.knots_u,
            self.knots_v,
            self.degree_u,
            self.degree_v,
            at_u.flatten(),
            at_v.flatten(),
            order,
        )
        return result.reshape(*at_u.shape, order + 1, order + 1, 3)

    def normals(self, u: Any, v: Any) -> Values:
        """Evaluate unit normals, along dS/du x dS/dv; zero where this is zero, as at the poles of a sphere.

        Parameters
        ----------
        u, v : as for `points`

        Returns
        -------
        (..., 3) float64
        """
        by = self.derivatives(u, v, 1)
        normal = np.cross(_unit(by[..., 1, 0, :]), _unit(by[..., 0, 1, :]))
        return _unit(normal)


class Brep(Shape):
    """A boundary representation: faces traced as one shape. They need not be closed or joined.

    Parameters
    ----------
    faces : sequence of Face, at least one
    tolerance : number, at least 0, optional
        Maximum gap between the edges of neighbouring faces, in the shape's units, as CAD systems define it. Trimmed
        faces extend about this far beyond their trims where no other face of the brep is, to hide gaps. A single face
        ends at its trims.
    face_numbers : (F,) integers, at least 0, optional
        Faces of equal numbers are pieces of one face, such as the halves of a cylinder: drawings have no edge between
        them. By default each face is separate.

    Raises
    ------
    InputError
        If there is no face, an item is not a Face, or the tolerance or a number is out of range. At first placement or
        trace: if all faces have zero area, or the trims remove everything.
    """

    kind = "brep"

    faces: tuple[Face, ...]
    tolerance: float
    face_numbers: NDArray[np.int32] | None

    def __init__(self, faces: Any, tolerance: float = 0.0, face_numbers: Any = None) -> None:
        self.faces = check_tuple("faces", faces, "a sequence of Face")
        if not self.faces:
            raise InputError("faces: expected at least one, got none")
        for i, face in enumerate(self.faces):
            if not isinstance(face, Face):
                raise InputTypeError(f"faces[{i}]: expected a Face, got {type(face).__name__}")
        self.tolerance = check_number("tolerance", tolerance, 0)
        self.face_numbers = None if face_numbers is None else _numbers(face_numbers, len(self.faces))

    @property
    def is_colored(self) -> bool:
        return any(face.color is not None for face in self.faces)

    @property
    def face_colors(self) -> NDArray[np.float32] | None:
        """Linear RGB of each face, (F, 3), or None if no face has a colour."""
        if not self.is_colored:
            return None
        return np.array([(1, 1, 1) if face.color is None else face.color for face in self.faces], np.float32)

    @lazy
    def core(self) -> _core.Brep:
        try:
            surfaces = _core.Brep(self._faces_in_core(), self.tolerance, self.face_colors, self.face_numbers)
        except ValueError as error:
            raise InputError(str(error)) from None
        if surfaces.is_coarse:
            warn_coarse("surface")
        return surfaces

    def _faces_in_core(self) -> list[Any]:
        return [
            (
                with_weights(face.control_points, face.weights),
                face.knots_u,
                face.knots_v,
                [[(with_weights(c.control_points, c.weights), c.knots) for c in loop] for loop in face.trims],
            )
            for face in self.faces
        ]

    def boxes(self, matrix: NDArray[np.float64]) -> Values:
        """Return the exact box around each face that is placed by a (4, 4) matrix, (n, 2, 3)."""
        linear = np.ascontiguousarray(matrix[:3, :3])
        extremes = self._extremes.get(linear.tobytes())
        if extremes is None:
            extremes = self._extremes[linear.tobytes()] = _core.face_extremes(self._faces_in_core(), linear)
        boxes: Values = extremes.transpose(0, 2, 1) + matrix[:3, 3]
        return boxes

    @lazy
    def _extremes(self) -> dict[bytes, Values]:
        """Extremes found so far, by the linear part of the matrix."""
        return {}

    @lazy
    def moments(self) -> Values:
        """(n, 15): for each face its area, the integrals of its unit normal, (3,), and of position times normal,
        (3, 3), and the parameters (u, v) of a point of it.

        By quadrature, with errors near 1e-9 of the face's squared size where its surface is smooth.
        """
        return _core.face_moments(self._faces_in_core())

    def mesh(self, step: float | None = None) -> Mesh:
        """Tessellate the faces. Vertices lie on the surfaces; border vertices lie on the trims.

        Parameters
        ----------
        step : number above 0, optional
            Mean length of the triangles' sides, in the shape's units; by default 1/128 of its longest side. Sides are
            shorter where the mesh would deviate from the surface or a trim by more than 1/30 of the step.

        Returns
        -------
        Mesh
            Shared edges have the same samples on both faces and are welded where their ends agree, within 1/50 of the
            step or twice the tolerance. So the mesh is closed if the faces are, and then anticlockwise seen from
            outside. Its triangles have their faces' colours.

        Raises
        ------
        InputError
            If the step is below 1/4000 of the longest side, or there would be more than 33 million triangles. A face
            with crossing trims is omitted with an `InputWarning`.
        """
        from bobrossnet.shapes.tessellation import tessellated  # it imports this module

        return tessellated(self, self.check_step(step))

    def describe(self) -> dict[str, str]:
        trimmed = sum(bool(face.trims) for face in self.faces)
        rational = sum(face.weights is not None for face in self.faces)
        degrees = Counter((face.degree_u, face.degree_v) for face in self.faces)
        loops = [loop for face in self.faces for loop in face.trims]
        core = self.core
        return {
            "faces": f"{len(self.faces):,}, {trimmed:,} trimmed, {rational:,} rational",
            "degrees": ", ".join(f"{degree} x {count:,}" for degree, count in degrees.most_common()),
            "control points": f"{sum(face.control_points[..., 0].size for face in self.faces):,}",
            "trims": f"{counted(len(loops), 'loop')} of {counted(sum(map(len, loops)), 'curve')}" if loops else "none",
            "patches": f"{core.patches:,} in {core.pieces:,} pieces, {core.bytes / 2**20:.1f} MiB",
            **({"colours": f"{len({face.color for face in self.faces}):,}"} if self.is_colored else {}),
        }

    def tensors(self) -> dict[str, NDArray[Any]]:
        curves = [curve for face in self.faces for loop in face.trims for curve in loop]
        tolerance = {"tolerance": np.array([self.tolerance])} if self.tolerance else {}
        colors = {} if self.face_colors is None else {"face_colors": self.face_colors}
        numbers = {} if self.face_numbers is None else {"face_numbers": self.face_numbers}
        return {
            **tolerance,
            **colors,
            **numbers,
            "faces": _table(
                [(*face.control_points.shape[:2], face.degree_u, face.degree_v, len(face.trims)) for face in self.faces]
            ),
            "control_points": _joined([_with_weights(face) for face in self.faces], 4),
            "knots": _joined([knots for face in self.faces for knots in (face.knots_u, face.knots_v)]),
            "loops": np.array([len(loop) for face in self.faces for loop in face.trims], np.int32),
            "trims": _table([(len(curve.control_points), curve.degree) for curve in curves], 2),
            "trim_control_points": _joined([_with_weights(curve) for curve in curves], 3),
            "trim_knots": _joined([curve.knots for curve in curves]),
        }

    @classmethod
    def from_tensors(cls, tensors: Mapping[str, NDArray[Any]]) -> Brep:
        int32, float64 = ("faces", "loops", "trims"), ("control_points", "knots", "trim_control_points", "trim_knots")
        required = dict.fromkeys(int32, "int32") | dict.fromkeys(float64, "float64")
        optional = {"tolerance": "float64", "face_colors": "float32", "face_numbers": "int32"}
        check_tensors(tensors, required, optional)
        table = _counts("faces", tensors, 5)
        colors: list[Any] = [None] * len(table)
        if "face_colors" in tensors:
            colors = check_array("face_colors", tensors["face_colors"], (len(table), 3)).tolist()
        take = {
            "control_points": _Pieces(tensors, "control_points", 4),
            "knots": _Pieces(tensors, "knots"),
            "loops": _Pieces(tensors, "loops"),
            "trims": _Pieces(tensors, "trims", 2),
            "trim_control_points": _Pieces(tensors, "trim_control_points", 3),
            "trim_knots": _Pieces(tensors, "trim_knots"),
        }
        _counts("loops", tensors)
        _counts("trims", tensors, 2)

        def next_curve() -> TrimCurve:
            count, degree = take["trims"].next(1)[0].tolist()
            points, weights = _without_weights(take["trim_control_points"].next(count))
            return TrimCurve(points, take["trim_knots"].next(count + degree + 1), weights)

        def next_face(color: Any, n: int, m: int, p: int, q: int, loop_count: int) -> Face:
            points, weights = _without_weights(take["control_points"].next(n * m).reshape(n, m, 4))
            knots_u, knots_v = take["knots"].next(n + p + 1), take["knots"].next(m + q + 1)
            loops = []
            for i, curve_count in enumerate(take["loops"].next(loop_count).tolist()):
                loop = []
                for j in range(curve_count):
                    with place_in_errors(f"trims[{i}][{j}]"):
                        loop.append(next_curve())
                loops.append(loop)
            return Face(points, knots_u, knots_v, weights, loops, color)

        faces = []
        for i, row in enumerate(table.tolist()):
            with place_in_errors(f"faces[{i}]"):
                faces.append(next_face(colors[i], *row))
        for pieces in take.values():
            pieces.check_end()
        tolerance = tensors.get("tolerance", np.zeros(1))
        if tolerance.shape != (1,):
            raise InputError(f"tolerance: expected one number, got shape {tolerance.shape}")
        return cls(faces, float(tolerance[0]), tensors.get("face_numbers"))

    def counts(self) -> dict[str, int]:
        return {"face": len(self.faces)}

    def __repr__(self) -> str:
        return f"Brep({counted(len(self.faces), 'face')})"


def _numbers(numbers: Any, count: int) -> NDArray[np.int32]:
    array = check_array("face_numbers", numbers, (count,), hint="one number per face")
    if array.dtype.kind not in "iu" or array.min() < 0 or array.max() > np.iinfo(np.int32).max:
        raise InputError("face_numbers: expected integers in 0..2^31 - 1")
    return frozen(array, np.int32)


def nurbs_surface(
    control_points: Any,
    knots_u: Any,
    knots_v: Any,
    weights: Any = None,
    trims: Any = None,
    color: Color | None = None,
) -> Brep:
    """Make a `Brep` of one `Face`, with the parameters of `Face`.

    >>> import bobrossnet as bob
    >>> corners = [[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 1]]]
    >>> bob.nurbs_surface(corners, [0, 0, 1, 1], [0, 0, 1, 1]).faces[0].points(0.5, 0.5).tolist()
    [0.5, 0.5, 0.25]
    """
    return Brep([Face(control_points, knots_u, knots_v, weights, trims, color)])


# ---- Trims -----------------------------------------------------------------------------------------------


def _loop(place: str, loop: Any) -> Loop:
    if isinstance(loop, TrimCurve):
        return (loop,)
    parts = () if isinstance(loop, np.ndarray) else check_tuple(place, loop, "points, a TrimCurve or several of these")
    if any(isinstance(part, TrimCurve) or np.asarray(part, object).ndim > 1 for part in parts):
        return tuple(_polyline(f"{place}[{j}]", part, 2) for j, part in enumerate(parts))
    return (_polyline(place, loop, 3),)


def _polyline(place: str, part: Any, fewest: int) -> TrimCurve:
    if isinstance(part, TrimCurve):
        return part
    points = check_array(place, part, (None, 2))
    if len(points) < fewest:
        raise InputError(f"{place}: expected at least {fewest} points, got {len(points)}")
    with place_in_errors(place):
        return TrimCurve(points, [0, *range(len(points)), len(points) - 1])


# ---- Evaluation ------------------------------------------------------------------------------------------


def _parameters(name: str, value: Any, low: float, high: float) -> Values:
    array = check_array(name, value, (None,) * len(shape_of(value))).astype(np.float64)
    outside = ~((low <= array) & (array <= high))  # NaN is outside
    if outside.any():
        raise InputError(f"{name}: expected numbers in the domain {low:.6g} to {high:.6g}, got {array[outside][0]:.6g}")
    return array


def _unit(vectors: Values) -> Values:
    """Normalise vectors to length 1; zero stays zero."""
    largest = np.abs(vectors).max(axis=-1, keepdims=True)  # squares could overflow float64
    scaled = vectors / np.where(largest > 0, largest, 1)
    length = np.linalg.norm(scaled, axis=-1, keepdims=True)
    unit: Values = scaled / np.where(length > 0, length, 1)
    return unit


# ---- Tensors ---------------------------------------------------------------------------------------------


def _with_weights(of: Face | TrimCurve) -> Values:
    points = with_weights(of.control_points, of.weights)
    return points.reshape(-1, points.shape[-1])


def _without_weights(points: Values) -> tuple[Values, Values | None]:
    weights = points[..., -1]
    return points[..., :-1], None if (weights == 1).all() else weights


def _joined(arrays: list[Values], *width: int) -> Values:
    return np.concatenate([np.empty((0, *width)), *arrays])


def _table(rows: list[tuple[int, ...]], *width: int) -> NDArray[np.int32]:
    return np.array(rows, np.int32).reshape(-1, *(width or (5,)))


def _counts(name: str, tensors: Mapping[str, NDArray[Any]], *width: int) -> NDArray[np.int32]:
    table = check_array(name, tensors[name], (None, *width))
    if table.min(initial=0) < 0:
        raise InputError(f"{name}: expected counts of at least 0, got {table.min()}")
    return table


class _Pieces:
    """A cursor that takes an array apart, from beginning to end."""

    def __init__(self, tensors: Mapping[str, NDArray[Any]], name: str, *width: int) -> None:
        self.name, self.at = name, 0
        self.array = check_array(name, tensors[name], (None, *width))

    def next(self, count: int) -> NDArray[Any]:
        start, self.at = self.at, self.at + count
        if self.at > len(self.array):
            raise InputError(f"{self.name}: expected {self.at} and more, got {len(self.array)}")
        return self.array[start : self.at]

    def check_end(self) -> None:
        if self.at < len(self.array):
            raise InputError(f"{self.name}: expected {self.at}, got {len(self.array)}")
