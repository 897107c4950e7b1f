"""Meshes of boundary representations.

Each face is sampled along its borders and on a grid inside, and triangulated in its parameter plane. The samples of
a border depend on its curve in space alone, so that faces sharing it have the same points there, which are welded.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.shapes.mesh import MAX_TRIANGLES, Mesh
from bobrossnet.shapes.nurbs import Brep, Face, TrimCurve
from bobrossnet.shapes.splines import Values, curve_derivatives
from bobrossnet.support.errors import InputError, InputWarning

I32 = NDArray[np.int32]

SAG = 1 / 30
"""Maximum distance of a chord from its arc, in steps; it equals a turn of 15° in a step."""

KINK = np.radians(1)
"""Minimum turn of a kink, in radians. Borders are split at kinks, so corners stay corners."""

PLANE = 2**25
"""Range of the integer coordinates of triangulations."""

WELD = 0.02
"""Welding distance of border points, in steps.

Two faces sample the same edge within a thousandth of a step, plus the distance of their curves.
"""


class FaceMesh(NamedTuple):
    """The mesh of one face."""

    points: Values  # (n, 3)
    triangles: I32  # (t, 3)
    borders: int  # the first `borders` points lie on the face's border
    color: NDArray[np.float32] | None  # (3,), linear
    uv: Values  # (n, 2), the points' parameters


def tessellated(brep: Brep, step: float) -> Mesh:
    """Return the mesh of a brep; see `Brep.mesh`."""
    parts: list[FaceMesh] = []
    colors = brep.face_colors
    count = 0
    for i, face in enumerate(brep.faces):
        try:
            part = tessellated_face(face, step, MAX_TRIANGLES - count, None if colors is None else colors[i])
        except ValueError as error:
            if isinstance(error, InputError):
                raise
            warnings.warn(f"face {i}: {error} in its trims: left out of the mesh", InputWarning, stacklevel=3)
            continue
        if len(part.triangles):
            parts.append(part)
            count += len(part.triangles)
    if not parts:
        raise InputError("shape: expected a face that can be triangulated, got none")
    weld = min(max(2 * brep.tolerance, WELD * step), 0.25 * step)
    return _joined(parts, weld)


# ---- One face ------------------------------------------------------------------------------------------------------


def tessellated_face(face: Face, step: float, max_triangles: int, color: NDArray[np.float32] | None = None) -> FaceMesh:
    """Return the mesh of a face, of at most `max_triangles` triangles; ValueError if its trims cross."""
    grid = _Grid(face, step, max_triangles)
    loops = border(face, step)
    uv = np.concatenate(loops)
    # The edges of closed polygons, concatenated.
    ends = np.cumsum([len(loop) for loop in loops])
    following = np.arange(1, len(uv) + 1)
    following[ends - 1] = [0, *ends[:-1]]
    plane = grid.to_plane(uv)
    inner = grid.nodes_within(plane, following)
    whole: I32 = np.rint(np.concatenate([plane, grid.to_plane(inner)]) * grid.scale).astype(np.int32)
    _, first, number = np.unique(packed(whole), return_index=True, return_inverse=True)
    edges = np.stack([np.arange(len(uv)), following], axis=1)
    edges = first[number[edges]]  # by the first of equal points
    order = np.sort(first)  # border points first
    place = np.full(len(whole), -1, np.int32)
    place[order] = np.arange(len(order), dtype=np.int32)
    sides: I32 = np.ascontiguousarray(place[edges[edges[:, 0] != edges[:, 1]]])
    triangles = _core.triangulate(np.ascontiguousarray(whole[order], np.int32), sides)
    at = np.concatenate([uv, inner])[order]
    return FaceMesh(points_at(face, at), triangles, int(np.count_nonzero(order < len(uv))), color, at)


def border(face: Face, step: float) -> list[Values]:
    """Return the parameters (n, 2) along each loop of a face's border; each loop closes itself."""
    return [_sampled(face, _smooth(face, loop), step) for loop in _loops(face)]


class _Grid:
    """Grid lines of u and v, so dense that the surface between them is at most a step long and nearly flat."""

    def __init__(self, face: Face, step: float, max_triangles: int) -> None:
        self.samples = [
            _samples(knots, domain) for knots, domain in zip((face.knots_u, face.knots_v), face.domain, strict=True)
        ]
        u, v = np.meshgrid(*self.samples, indexing="ij")
        points, normals = face.points(u, v), face.normals(u, v)
        self.costs, self.counts = [], []
        for axis in (0, 1):
            length = np.linalg.norm(np.diff(points, axis=axis), axis=-1)
            a, b = (
                np.take(normals, range(1, points.shape[axis]), axis),
                np.take(normals, range(points.shape[axis] - 1), axis),
            )
            known = (np.abs(a).max(axis=-1) > 0) & (np.abs(b).max(axis=-1) > 0)  # a pole has no normal
            cost = _cost(length, np.where(known, _angle(a, b), 0), step).max(axis=1 - axis)
            self.costs.append(np.concatenate([[0], np.cumsum(cost + 1e-4)]))  # strictly increasing, hence invertible
            self.counts.append(max(1, int(np.ceil(self.costs[-1][-1] - 0.01))))
        if 2 * self.counts[0] * self.counts[1] > max_triangles:
            raise InputError(
                f"step: expected a larger one than {step:g}, which makes more than {MAX_TRIANGLES} triangles"
            )
        self.scale = PLANE / max(cost[-1] for cost in self.costs)

    def to_plane(self, uv: Values) -> Values:
        """Map parameters (n, 2) to the plane where neighbouring lines are one step apart."""
        return np.stack([np.interp(uv[:, axis], self.samples[axis], self.costs[axis]) for axis in (0, 1)], axis=1)

    def nodes_within(self, polygons: Values, following: NDArray[np.intp]) -> Values:
        """Return the parameters of line crossings inside polygons, except close to their sides."""
        a, b = polygons, polygons[following]
        lines = [np.linspace(0, cost[-1], count + 1) for cost, count in zip(self.costs, self.counts, strict=True)]
        # Crossings of sides and lines of v, by interval of u: there, inside and outside alternate.
        first, end = (np.searchsorted(lines[1], each(a[:, 1], b[:, 1])) for each in (np.minimum, np.maximum))
        side = np.repeat(np.arange(len(a)), end - first)
        j = np.arange(len(side)) - np.repeat(np.cumsum(end - first) - end, end - first)
        (x, y), way = a[side].T, (b - a)[side]
        crossed = np.searchsorted(lines[0], x + (lines[1][j] - y) / way[:, 1] * way[:, 0])
        changes = np.zeros((len(lines[0]) + 1, len(lines[1])), np.int32)
        np.add.at(changes, (crossed, j), 1)
        keep = np.cumsum(changes[:-1], axis=0) % 2 == 1
        keep[[0, -1]] = keep[:, [0, -1]] = False
        spacing = np.array([line[1] for line in lines])
        for share in (0, 0.5):
            near = (a + share * (b - a)) / spacing
            for corner in ((0, 0), (0, 1), (1, 0), (1, 1)):
                node = np.floor(near).astype(int) + corner
                close = np.linalg.norm(near - node, axis=1) < 0.5
                i, j = np.clip(node[close], 0, np.array(keep.shape) - 1).T
                keep[i, j] = False
        i, j = np.nonzero(keep)
        return np.stack(
            [
                np.interp(line[k], cost, at)
                for line, k, cost, at in zip(lines, (i, j), self.costs, self.samples, strict=True)
            ],
            axis=1,
        )


def points_at(face: Face, uv: Values) -> Values:
    """Evaluate the face at parameters (n, 2), clamped to the domain against rounding."""
    low, high = np.transpose(face.domain)
    u, v = np.clip(uv, low, high).T
    return face.points(u, v)


def _samples(knots: Values, domain: tuple[float, float]) -> Values:
    """Return parameters of a surface for measuring it: several in each span."""
    spans = np.unique(knots[(domain[0] <= knots) & (knots <= domain[1])])
    each = int(np.clip(64 // (len(spans) - 1), 2, 12))
    parts = [np.linspace(low, high, each, endpoint=False) for low, high in pairwise(spans)]
    samples: Values = np.clip(np.concatenate([*parts, spans[-1:]]), *domain)
    return samples


class Course(NamedTuple):
    """A curve of a loop."""

    at: Callable[[Values], Values]  # maps parameters (k,) in 0..1 to (u, v), (k, 2)
    spans: int
    joints: Values  # parameters in 0..1 of possible kinks

    def part(self, start: float, end: float) -> Course:
        return Course(lambda t: self.at(start + t * (end - start)), self.spans, np.empty(0))


def _line(a: Values, b: Values, spans: int = 4, joints: Values | None = None) -> Course:
    return Course(lambda t: a + t[:, None] * (b - a), spans, np.empty(0) if joints is None else joints)


def _loops(face: Face) -> Iterator[list[Course]]:
    """Yield each loop's courses, end to end."""
    low, high = np.transpose(face.domain)
    if not face.trims:
        corners = [np.array(c, np.float64) for c in (low, (high[0], low[1]), high, (low[0], high[1]))]
        u, v = (
            (_joints(knots, degree, domain), len(_samples(knots, domain)) // 4)
            for knots, degree, domain in zip(
                (face.knots_u, face.knots_v), (face.degree_u, face.degree_v), face.domain, strict=True
            )
        )
        sides = (u, v, (1 - u[0][::-1], u[1]), (1 - v[0][::-1], v[1]))
        yield [_line(corners[i], corners[(i + 1) % 4], spans, joints) for i, (joints, spans) in enumerate(sides)]
    for loop in face.trims:
        yield [_trim(curve, low, high) for curve in loop]


def _trim(curve: TrimCurve, low: Values, high: Values) -> Course:
    start, end = curve.domain

    def at(t: Values) -> Values:
        uv, _ = curve_derivatives(curve.control_points, curve.weights, curve.knots, start + t * (end - start))
        return np.clip(uv, low, high)

    return Course(at, len(np.unique(curve.knots)), _joints(curve.knots, curve.degree, curve.domain))


def _joints(knots: Values, degree: int, domain: tuple[float, float]) -> Values:
    """Return the parameters in 0..1, inside the domain, where a curve may have a kink."""
    values, times = np.unique(knots, return_counts=True)
    joints = values[(times >= degree) & (domain[0] < values) & (values < domain[1])]
    share: Values = (joints - domain[0]) / (domain[1] - domain[0])
    return share


def _smooth(face: Face, courses: list[Course]) -> Iterator[Course]:
    """Yield the smooth parts of a loop's courses, and straight lines across gaps."""
    size = np.ptp(face.domain, axis=1)
    ends = [course.at(np.array([0.0, 1.0])) for course in courses]
    for i, course in enumerate(courses):
        joints = course.joints[:, None] + np.array([-1e-5, 0, 1e-5])
        uv = course.at(np.clip(joints.reshape(-1), 0, 1))
        before, after = np.moveaxis(np.diff(points_at(face, uv).reshape(-1, 3, 3), axis=1), 1, 0)
        kinks = [0.0, *course.joints[_angle(before, after) > KINK].tolist(), 1.0]
        yield from (course.part(*part) for part in pairwise(kinks))
        end, beginning = ends[i][1], ends[(i + 1) % len(courses)][0]
        if (np.abs(end - beginning) > 1e-5 * size).any():
            yield _line(end, beginning)


def _sampled(face: Face, courses: Iterable[Course], step: float) -> Values:
    """Return parameters (n, 2) along a loop, at equal arc lengths of each course in space."""
    result = []
    for course in courses:
        t = np.linspace(0, 1, int(np.clip(8 * course.spans, 33, 1025)))
        for _ in range(2):  # the second time densely enough
            uv = course.at(t)
            along = np.diff(points_at(face, uv), axis=0)
            length = np.linalg.norm(along, axis=1)
            turn = _angle(along[1:], along[:-1])
            turns = np.interp(np.arange(len(length)) + 0.5, np.arange(1, len(length)), turn)  # of each part
            cost = np.concatenate([[0], np.cumsum(_cost(length, turns, step))])
            total = cost[-1]
            count = _count(total)
            if not total > 0:
                break  # a pole
            t = np.interp(np.linspace(0, total, max(len(t), 8 * count + 1)), cost, t)
            cost = np.linspace(0, total, len(t))
        at = np.interp(np.linspace(0, cost[-1], count, endpoint=False), cost, t) if total > 0 else np.zeros(1)
        result.append(course.at(at))
    return np.concatenate(result)


def _count(cost: float) -> int:
    """Round a number of parts up to 2^i or 3 * 2^i.

    With few candidates, two faces almost never choose different numbers, although their curves differ by rounding.
    """
    cost *= 0.997  # integer numbers of steps are common
    power: int = 2 ** max(0, int(np.ceil(np.log2(max(cost, 1)))))
    return power * 3 // 4 if power >= 4 and cost <= 0.75 * power else power


def _cost(length: Values, turn: Values, step: float) -> Values:
    """Return the number of parts for arcs of given lengths and turns."""
    cost: Values = np.maximum(length / step, np.sqrt(length * turn / (8 * SAG * step)))
    return cost


def _angle(a: Values, b: Values) -> Values:
    """Return the angles between vectors (..., 3) of any length; 0 for a zero vector."""
    a, b = (x / np.maximum(np.linalg.norm(x, axis=-1, keepdims=True), 1e-300) for x in (a, b))
    angle: Values = 2 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
    return angle


# ---- All faces -----------------------------------------------------------------------------------------------------


def _joined(parts: list[FaceMesh], weld: float) -> Mesh:
    points = np.concatenate([part.points for part in parts])
    starts = np.cumsum([0, *(len(part.points) for part in parts)])
    on_border = np.concatenate([start + np.arange(part.borders) for start, part in zip(starts, parts, strict=False)])
    number = np.arange(len(points))
    number[on_border] = on_border[welded(points[on_border], weld)]
    triangles = number[np.concatenate([part.triangles + start for start, part in zip(starts, parts, strict=False)])]
    owner = np.repeat(np.arange(len(parts)), [len(part.triangles) for part in parts])
    a, b, c = triangles.T
    kept = (a != b) & (b != c) & (c != a)
    triangles, owner = triangles[kept], owner[kept]
    if not len(triangles):
        raise InputError("step: expected less than the shape's width, got a step that leaves nothing")
    triangles = _facing_alike(points, triangles, owner, len(parts))
    used, triangles = np.unique(triangles, return_inverse=True)
    colors = [part.color for part in parts if part.color is not None]
    face_colors = np.stack(colors)[owner] if colors else None
    return Mesh.owning(points[used], np.ascontiguousarray(triangles.reshape(-1, 3), np.int32), face_colors=face_colors)


def packed(numbers: NDArray[np.signedinteger]) -> NDArray[np.int64]:
    """Pack rows of non-negative integers, two below 2^31 or three below 2^21, into single integers."""
    bits = 63 // numbers.shape[1]
    keys = numbers[:, 0].astype(np.int64)
    for column in numbers.T[1:]:
        keys = keys << bits | column
    return keys


def welded(points: Values, distance: float) -> NDArray[np.intp]:
    """Return for each point the least index of its cluster: points within a distance of each other, transitively."""
    number = np.arange(len(points))
    cells = (points - points.min(axis=0)) / (2 * distance)
    while True:
        before = number.copy()
        for shift in np.ndindex(2, 2, 2):  # points closer than half a cell share a cell for one of these shifts
            cell = np.floor(cells + 0.5 * np.array(shift)).astype(np.int64)
            _, group = np.unique(packed(cell), return_inverse=True)
            least = np.full(group.max() + 1, len(points))
            np.minimum.at(least, group, number)
            number = least[group]
        if (number == before).all():
            return number


def _facing_alike(points: Values, triangles: NDArray[np.intp], owner: NDArray[np.intp], faces: int) -> NDArray[np.intp]:
    """Return the triangles with whole faces flipped, so that neighbours agree and closed shells face outwards."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    of = np.tile(owner, 3)
    forward = edges[:, 0] < edges[:, 1]
    _, edge = np.unique(packed(np.sort(edges, axis=1)), return_inverse=True)
    order = np.argsort(edge, kind="stable")
    edge, of, forward = edge[order], of[order], forward[order]
    times = np.bincount(edge)
    pair = np.flatnonzero((times[edge[:-1]] == 2) & (edge[:-1] == edge[1:]))
    votes: dict[int, dict[int, int]] = {face: {} for face in range(faces)}
    for p, q, differ in zip(
        of[pair].tolist(), of[pair + 1].tolist(), (forward[pair] != forward[pair + 1]).tolist(), strict=True
    ):
        if p != q:
            for one, other in ((p, q), (q, p)):
                votes[one][other] = votes[one].get(other, 0) + (1 if differ else -1)
    open_faces = np.zeros(faces, bool)
    open_faces[of[times[edge] != 2]] = True
    corner = points[triangles] - points.mean(axis=0)
    volume = np.bincount(owner, (corner[:, 0] * np.cross(corner[:, 1], corner[:, 2])).sum(axis=1), faces)
    turned = np.zeros(faces, bool)
    seen = np.zeros(faces, bool)
    for first in range(faces):
        if seen[first]:
            continue
        seen[first] = True
        body = [first]
        for face in body:
            for other, vote in votes[face].items():
                if not seen[other]:
                    seen[other] = True
                    turned[other] = turned[face] ^ (vote < 0)
                    body.append(other)
        if open_faces[body].any():
            wrong = 2 * np.count_nonzero(turned[body]) > len(body)
        else:
            wrong = np.where(turned[body], -volume[body], volume[body]).sum() < 0
        turned[body] ^= wrong
    flip = turned[owner]
    triangles = triangles.copy()
    triangles[flip] = triangles[flip, ::-1]
    return triangles
