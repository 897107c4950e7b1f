"""Curves along which planes cut shapes.

Each kind of shape is cut in its own way: triangles exactly; formulas on a lattice of the plane, whose crossings are
moved to the roots; faces of breps from their tessellation, whose crossings are moved onto surface and plane.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet.shapes.affine import IDENTITY, Matrix, mapped
from bobrossnet.shapes.chains import Curve, Numbers, Values, chained, straight
from bobrossnet.shapes.implicit import Implicit
from bobrossnet.shapes.mesh import MAX_TRIANGLES, Mesh
from bobrossnet.shapes.nurbs import Brep, Face
from bobrossnet.shapes.shape import Shape
from bobrossnet.shapes.tessellation import tessellated_face

LATTICE = 384
"""Lattice lines of a formula along the longer side of its box in the plane: thinner details may be lost."""

TUBE_STEPS = 512
"""Steps along the longest side of a tube's mesh, which is cut in its place."""

SAG = 2e-6
"""Maximum distance of chords from the curve, in the scene's radii."""

HALVINGS = 40
"""Maximum number of times that a segment is halved."""

BEND, KINK = 0.02, 1e-7
"""Segments are halved where a chord is farther from the curve than this share of its length, down to this length in the
scene's radii: so kinks stay sharp."""

STRAIGHT = 1e-11
"""Points this close to the line between their neighbours, in the scene's radii, are left out."""

TOUCHING = 1e-9
"""Ends of curves of a mesh that are this close are joined, in the scene's radii."""

IN_PLANE = 1e-9
"""Cuts of breps are moved this far to the kept side, in the scene's radii, so that no face lies in the plane."""


class Plane(NamedTuple):
    """The plane normal · p = offset, with unit vectors along it, (2, 3); in the scene's units."""

    normal: Values
    offset: float
    axes: Values
    size: float  # the scene's radius

    def seen(self, points: Values) -> Values:
        """Map points (n, 3) to the plane's coordinates, (n, 2)."""
        seen: Values = points @ self.axes.T
        return seen

    def point(self, at: Values) -> Values:
        """Map the plane's coordinates (n, 2) to points (n, 3)."""
        point: Values = at @ self.axes + self.offset * self.normal
        return point


def cut(shape: Shape, transform: Matrix, plane: Plane) -> list[Curve]:
    """Return the curves of a placed shape in a plane; closed ones unless the shape is open."""
    if isinstance(shape, Implicit):
        return cut_formula(shape, transform, plane)
    if isinstance(shape, Brep):
        return cut_brep(shape, transform, plane)
    mesh = shape
    if not isinstance(mesh, Mesh):
        low, high = shape.bounding_box(IDENTITY)
        made = shape.mesh(float((high - low).max()) / TUBE_STEPS)
        assert isinstance(made, Mesh)
        mesh = made
    return cut_mesh(mesh, transform, plane)


# ---- Meshes --------------------------------------------------------------------------------------------------------


def cut_mesh(mesh: Mesh, transform: Matrix, plane: Plane) -> list[Curve]:
    """Cut triangles. A vertex in the plane belongs to the removed side, so that neighbours agree."""
    used, index = np.unique(mesh.triangles, return_inverse=True)
    vertices, number = np.unique(mesh.vertices[used], axis=0, return_inverse=True)
    triangles = number.reshape(-1)[index].reshape(-1, 3)
    points = mapped(transform, vertices)
    distance = points @ plane.normal - plane.offset
    low, high, segments = crossed(triangles, distance >= 0)
    share = (distance[low] / (distance[low] - distance[high]))[:, None]
    crossings = plane.seen(points[low] + share * (points[high] - points[low]))
    curves = [straight(crossings[chain.ends], chain.is_closed) for chain in chained(segments)]
    curves = _joined(curves, TOUCHING * plane.size)  # an edge may be opposite to several shorter ones
    return [_simplified(curve, plane.size) for curve in curves]


def crossed(triangles: Numbers, is_beyond: NDArray[np.bool_]) -> tuple[Numbers, Numbers, Numbers]:
    """Return the edges with ends on two sides, by their lower and higher vertex, and segments (n, 2) between these."""
    mixed = triangles[is_beyond[triangles].any(axis=1) & ~is_beyond[triangles].all(axis=1)].astype(np.intp)
    following = np.roll(mixed, -1, axis=1)
    crosses = is_beyond[mixed] != is_beyond[following]
    low, high = np.minimum(mixed, following)[crosses], np.maximum(mixed, following)[crosses]  # two of each triangle
    keys, number = np.unique(low.astype(np.int64) << 32 | high, return_inverse=True)
    return keys >> 32, keys & 0xFFFFFFFF, number.reshape(-1, 2)


# ---- Formulas ------------------------------------------------------------------------------------------------------


def cut_formula(shape: Implicit, transform: Matrix, plane: Plane) -> list[Curve]:
    """Cut a formula."""
    back = np.linalg.inv(transform)
    low, high = shape.domain

    def field(at: Values) -> Values:
        points = plane.point(at) @ back[:3, :3].T + back[:3, 3]
        outside = np.maximum(low - points, points - high).max(axis=1)
        values = np.maximum(shape.expression(np.ascontiguousarray(points)), outside)
        return np.where(np.isnan(values), np.inf, values)

    corners = np.array([[(low, high)[k][axis] for axis, k in enumerate(corner)] for corner in np.ndindex(2, 2, 2)])
    corners = mapped(transform, corners)
    along = corners @ plane.normal - plane.offset
    if along.min() > 0 or along.max() < 0:
        return []
    seen = plane.seen(corners)
    start, size = seen.min(axis=0), np.ptp(seen, axis=0)
    spacing = size.max() / LATTICE
    counts = np.ceil(size / spacing).astype(int) + 3
    # Shifted so that no line of the lattice runs through round coordinates.
    x, y = (start[k] + spacing * (np.arange(counts[k]) - 0.997 - 0.005 * k) for k in (0, 1))
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    inside = (field(grid.reshape(-1, 2)) < 0).reshape(counts)
    segments, ends = _lattice_segments(inside, field, grid)
    used, segments = np.unique(segments, return_inverse=True)
    a, b = (grid.reshape(-1, 2)[ends[used, k]] for k in (0, 1))
    crossings = _root(field, a, b)

    def middle(p: Values, q: Values) -> Values:
        """The curve's crossing of the perpendicular bisector of each chord; the chord's middle without a crossing."""
        half, across = (p + q) / 2, np.stack([p[:, 1] - q[:, 1], q[:, 0] - p[:, 0]], axis=1)
        found, result = np.zeros(len(p), bool), half.copy()
        for reach in (1e-3, 1e-2, 0.1, 0.5, 1, 2):
            left = np.flatnonzero(~found)
            if not len(left):
                break
            c, d = half[left] - reach * across[left], half[left] + reach * across[left]
            changes = (field(c) < 0) != (field(d) < 0)
            found[left[changes]] = True
            result[left[changes]] = _root(field, c[changes], d[changes])
        return result

    chains = chained(segments.reshape(-1, 2))
    curves = [_refined(crossings[c.ends], c.is_closed, middle, lambda at: at, plane.size) for c in chains]
    return [_simplified(curve, plane.size) for curve in curves]


def _lattice_segments(
    inside: NDArray[np.bool_], field: Callable[[Values], Values], grid: Values
) -> tuple[Numbers, Numbers]:
    """Return segments (n, 2) between sides of cells, and the nodes (m, 2) at the ends of all sides."""
    columns, rows = inside.shape
    node = np.arange(columns * rows).reshape(columns, rows)
    right = np.stack([node[:-1], node[1:]], axis=-1).reshape(-1, 2)
    up = np.stack([node[:, :-1], node[:, 1:]], axis=-1).reshape(-1, 2)
    ends = np.concatenate([right, up])
    right_side = np.arange(len(right)).reshape(columns - 1, rows)
    up_side = len(right) + np.arange(len(up)).reshape(columns, rows - 1)
    sides = np.stack([right_side[:, :-1], up_side[1:], right_side[:, 1:], up_side[:-1]], axis=-1).reshape(-1, 4)
    corners = np.stack([inside[:-1, :-1], inside[1:, :-1], inside[1:, 1:], inside[:-1, 1:]], axis=-1).reshape(-1, 4)
    crosses = corners != np.roll(corners, -1, axis=1)
    two, four = (np.flatnonzero(crosses.sum(axis=1) == count) for count in (2, 4))
    segments = [sides[two][crosses[two]].reshape(-1, 2)]
    if len(four):
        middles = (grid[:-1, :-1] + grid[1:, 1:]).reshape(-1, 2)[four] / 2
        joined = (field(middles) < 0) == corners[four, 0]  # the first corner with the third
        for cells, pairs in ((four[joined], ((0, 1), (2, 3))), (four[~joined], ((3, 0), (1, 2)))):
            segments += [sides[cells][:, pair] for pair in pairs]
    return np.concatenate(segments).astype(np.intp), ends


def _root(field: Callable[[Values], Values], a: Values, b: Values) -> Values:
    """Return a sign change of a field between points a and b of other signs, (n, 2), by the Illinois method."""
    start, way = a, b - a
    low, high = np.zeros(len(a)), np.ones(len(a))
    at_low, at_high = field(a), field(b)
    is_low = at_low < 0
    share, before, last = np.full(len(a), 0.5), np.full(len(a), np.inf), np.zeros(len(a), np.int8)
    for i in range(60):
        with np.errstate(all="ignore"):
            secant = low + (high - low) * at_low / (at_low - at_high)
        half = (low + high) / 2
        share = np.where(np.isfinite(secant) & (i % 4 < 3), np.clip(secant, low, high), half)
        value = field(start + share[:, None] * way)
        same = (value < 0) == is_low
        # A side that stays twice counts half.
        at_high = np.where(same & (last == 1), at_high / 2, at_high)
        at_low = np.where(~same & (last == -1), at_low / 2, at_low)
        low, at_low = np.where(same, share, low), np.where(same, value, at_low)
        high, at_high = np.where(same, high, share), np.where(same, at_high, value)
        last = np.where(same, 1, -1).astype(np.int8)
        if (np.minimum(np.abs(share - before), high - low) < 1e-13).all():
            break
        before = share
    return start + share[:, None] * way


def _refined(
    at: Values,
    is_closed: bool,
    middle: Callable[[Values, Values], Values],
    seen: Callable[[Values], Values],
    size: float,
) -> Curve:
    """Halve segments until chords are close to the curve.

    Of parameters p and q, (n, 2), middle(p, q) is between them on the curve; seen(p) is where they are in the plane.
    """
    following = np.roll(at, -1, axis=0) if is_closed else at[1:]
    halves = middle(at[: len(following)], following)
    points, middles = seen(at), seen(halves)
    for _ in range(HALVINGS):
        end = np.roll(points, -1, axis=0) if is_closed else points[1:]
        places = np.flatnonzero(_is_bent(points[: len(end)], middles, end, size))
        if not len(places):
            break
        following = np.roll(at, -1, axis=0) if is_closed else at[1:]
        start, half, end = at[places], halves[places], following[places]
        first, second = middle(start, half), middle(half, end)
        at, points = np.insert(at, places + 1, half, axis=0), np.insert(points, places + 1, middles[places], axis=0)
        halves[places], middles[places] = first, seen(first)
        halves = np.insert(halves, places + 1, second, axis=0)
        middles = np.insert(middles, places + 1, seen(second), axis=0)
    return Curve(points, middles, is_closed)


def _is_bent(start: Values, middles: Values, end: Values, size: float) -> NDArray[np.bool_]:
    """Return the segments whose chords are too far from the curve."""
    sag = np.linalg.norm(middles - (start + end) / 2, axis=1)
    length = np.linalg.norm(end - start, axis=1)
    bent: NDArray[np.bool_] = (sag > SAG * size) | ((sag > BEND * length) & (length > KINK * size))
    return bent


def _from_line(points: Values, start: Values, end: Values) -> Values:
    """Return the distances of points from lines; infinite if a line has no direction."""
    way, offset = end - start, points - start
    length = np.linalg.norm(way, axis=1)
    with np.errstate(all="ignore"):
        far: Values = np.abs(offset[:, 0] * way[:, 1] - offset[:, 1] * way[:, 0]) / length
    return np.where(length > 0, far, np.inf)


def _simplified(curve: Curve, size: float) -> Curve:
    """Leave points out where the curve is straight: every other one, again and again."""
    points, middles, is_closed = curve
    while len(points) > 4:
        before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
        on_left = np.roll(middles, 1, axis=0) if is_closed else np.concatenate([points[:1], middles])
        on_right = middles if is_closed else np.concatenate([middles, points[-1:]])
        apart = [_from_line(at, before, after) for at in (points, on_left, on_right)]
        is_straight = np.max(apart, axis=0) < STRAIGHT * size
        is_straight &= ((points - before) * (after - points)).sum(axis=1) > 0
        is_straight[1:] &= ~is_straight[:-1] | (np.arange(1, len(points)) % 2 == 1)  # of two neighbours, one stays
        is_straight[:-1] &= ~(is_straight[1:] & is_straight[:-1])
        is_straight[0] = is_straight[-1] = False
        gone = np.flatnonzero(is_straight)
        if not len(gone):
            break
        kept = np.ones(len(points), bool)
        kept[gone] = False
        middles = middles.copy()
        middles[gone - 1] = (before[gone] + after[gone]) / 2
        points, middles = points[kept], middles[kept[: len(middles)]]
    return Curve(points, middles, is_closed)


# ---- Breps ---------------------------------------------------------------------------------------------------------


def cut_brep(shape: Brep, transform: Matrix, plane: Plane) -> list[Curve]:
    """Cut the faces one by one, and join the curves where these meet."""
    normal = transform[:3, :3].T @ plane.normal
    offset = plane.offset - IN_PLANE * plane.size - float(plane.normal @ transform[:3, 3])
    step = shape.check_step(None)
    curves: list[Curve] = []
    for face in shape.faces:
        hull = face.control_points.reshape(-1, 3) @ normal - offset
        if hull.min() < 0 < hull.max():
            curves += _FaceCut(face, step, normal, offset, transform, plane).curves()
    stretch = float(np.linalg.norm(transform[:3, :3], 2))
    curves = _joined(curves, stretch * max(step / 4, 2 * shape.tolerance))
    return [_simplified(curve, plane.size) for curve in curves]


class _FaceCut:
    """The curve of a face in a plane, in the face's parameters."""

    def __init__(self, face: Face, step: float, normal: Values, offset: float, transform: Matrix, plane: Plane) -> None:
        self.face, self.step, self.normal, self.offset = face, step, normal, offset
        self.transform, self.plane = transform, plane

    def curves(self) -> list[Curve]:
        try:
            part = tessellated_face(self.face, self.step, MAX_TRIANGLES)
        except ValueError:  # its trims cross
            return []
        distance = part.points @ self.normal - self.offset
        low, high, segments = crossed(part.triangles.astype(np.intp), distance >= 0)
        if not len(segments):
            return []
        share = distance[low] / (distance[low] - distance[high])
        uv = self._on_line(part.uv[low], part.uv[high], share)
        size = self.plane.size
        return [_refined(uv[c.ends], c.is_closed, self._middle, self._seen, size) for c in chained(segments)]

    def _seen(self, uv: Values) -> Values:
        points = mapped(self.transform, self.face.points(*uv.T))
        return self.plane.seen(points)

    def _distance(self, uv: Values) -> tuple[Values, Values]:
        """The distance from the plane, and its slopes in u and v, (n, 2)."""
        by = self.face.derivatives(uv[:, 0], uv[:, 1], 1)
        value = by[:, 0, 0] @ self.normal - self.offset
        return value, np.stack([by[:, 1, 0] @ self.normal, by[:, 0, 1] @ self.normal], axis=1)

    def _on_line(self, a: Values, b: Values, share: Values) -> Values:
        """Return where parameter lines from a to b cross the plane, by Newton's method from a share or bisection."""
        low, high = np.zeros(len(a)), np.ones(len(a))
        is_beyond = self._distance(a)[0] >= 0
        for _ in range(40):
            uv = a + share[:, None] * (b - a)
            value, slope = self._distance(uv)
            same = (value >= 0) == is_beyond
            low, high = np.where(same, share, low), np.where(same, high, share)
            with np.errstate(all="ignore"):
                newton = share - value / (slope * (b - a)).sum(axis=1)
            following = np.where((newton >= low) & (newton <= high), newton, (low + high) / 2)
            if np.abs(following - share).max() < 1e-14:
                break
            share = following
        return a + share[:, None] * (b - a)

    def _middle(self, a: Values, b: Values) -> Values:
        """Move parameters from halfway between a and b onto the plane, at most by the distance from a to b."""
        domain = np.transpose(self.face.domain)
        uv = start = (a + b) / 2
        limit = np.abs(b - a).sum(axis=1, keepdims=True)
        for _ in range(12):
            by = self.face.derivatives(uv[:, 0], uv[:, 1], 1)
            s_u, s_v = by[:, 1, 0], by[:, 0, 1]
            value = by[:, 0, 0] @ self.normal - self.offset
            slope = np.stack([s_u @ self.normal, s_v @ self.normal], axis=1)
            # Steps of equal length in space, whatever the parameters.
            scale = np.stack([(s_u**2).sum(axis=1), (s_v**2).sum(axis=1)], axis=1)
            with np.errstate(all="ignore"):
                way = np.where(scale > 0, slope / scale, 0)
                step = -(value / (slope * way).sum(axis=1))[:, None] * way
            uv = np.clip(uv + np.where(np.isfinite(step), step, 0), domain[0], domain[1])
            if np.abs(value).max() < 1e-15 * self.plane.size:
                break
        is_near = (np.abs(uv - start) <= limit).all(axis=1, keepdims=True)
        return np.where(is_near, uv, start)


def _joined(curves: list[Curve], distance: float) -> list[Curve]:
    """Join curves whose ends are at most a distance apart, where their tangents meet."""
    closed, opened = [c for c in curves if c.is_closed], [c for c in curves if not c.is_closed]
    if not opened:
        return closed
    ends = np.array([(curve.points[0], curve.points[-1]) for curve in opened]).reshape(-1, 2)
    gaps = np.linalg.norm(ends[:, None] - ends, axis=2) if len(ends) <= 4096 else _near(ends, distance)
    first, second = np.nonzero(np.triu(gaps <= distance, 1))
    other = np.full(len(ends), -1)
    for i in np.argsort(gaps[first, second], kind="stable"):
        a, b = first[i], second[i]
        if other[a] < 0 and other[b] < 0:
            other[a], other[b] = b, a
    for a, b in enumerate(other.tolist()):
        if a < b:
            meeting = _meeting(_tangent(opened, a), _tangent(opened, b), distance)
            for end in (a, b):
                opened[end // 2].points[0 if end % 2 == 0 else -1] = meeting
    done = np.zeros(len(opened), bool)
    starts = [end for end in range(len(ends)) if other[end] < 0] + list(range(0, len(ends), 2))
    for start in starts:
        if done[start // 2]:
            continue
        points, middles, end = [], [], start
        while not done[end // 2]:
            curve = opened[end // 2]
            done[end // 2] = True
            curve = curve if end % 2 == 0 else curve.turned()
            points.append(curve.points[:-1])
            middles.append(curve.middles)
            last = curve.points[-1:]
            end = int(other[end ^ 1])
            if end < 0:
                break
        is_closed = end >= 0
        closed.append(
            Curve(np.concatenate(points if is_closed else [*points, last]), np.concatenate(middles), is_closed)
        )
    return closed


def _near(ends: Values, distance: float) -> Values:
    """Return the distances of near ends, and infinity elsewhere, by blocks of rows."""
    gaps = np.full((len(ends), len(ends)), np.inf, np.float32)
    for row, end in enumerate(ends):
        apart = np.linalg.norm(ends - end, axis=1)
        gaps[row, apart <= distance] = apart[apart <= distance]
    return gaps.astype(np.float64)


def _tangent(curves: list[Curve], end: int) -> tuple[Values, Values]:
    """The end of a curve, and its direction there by the parabola through three points."""
    curve = curves[end // 2]
    p, m, q = curve.points[0], curve.middles[0], curve.points[1]
    if end % 2:
        p, m, q = curve.points[-1], curve.middles[-1], curve.points[-2]
    way = 4 * m - 3 * p - q
    size = np.linalg.norm(way)
    return p, way / size if size > 0 else way


def _meeting(a: tuple[Values, Values], b: tuple[Values, Values], distance: float) -> Values:
    """Return the point where two lines meet, if that is near; otherwise halfway between their points."""
    (p, d), (q, e) = a, b
    half: Values = (p + q) / 2
    sine = d[0] * e[1] - d[1] * e[0]
    if abs(sine) < 1e-3:
        return half
    gap = q - p
    meeting: Values = p + (gap[0] * e[1] - gap[1] * e[0]) / sine * d
    return meeting if np.linalg.norm(meeting - half) <= distance else half
