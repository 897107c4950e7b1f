"""Building blocks of procedural meshes: sweeps, lathes, extrusions, bitmaps, isosurfaces, transforms, noise.

A part is (vertices, triangles): (V, 3) float64 and (T, 3) integers, anticlockwise seen from outside if there is an
outside. Only functions with an `rng` are random.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Part = tuple[Array, NDArray[np.int64]]
Rng = np.random.Generator


# ---- surfaces over a grid ---------------------------------------------------------------------------------


def grid(points: Array, wrap_u: bool = False, wrap_v: bool = False) -> Part:
    """Return the quads between (M, N, 3) points, closed along an axis where it wraps."""
    m, n = points.shape[:2]
    index = np.arange(m * n).reshape(m, n)
    if wrap_u:
        index = np.concatenate([index, index[:1]], 0)
    if wrap_v:
        index = np.concatenate([index, index[:, :1]], 1)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.stack([a, b, c, a, c, d], -1).reshape(-1, 3)
    return points.reshape(-1, 3), triangles


def lathe(profile: Array, sides: int = 32) -> Part:
    """Return the surface of revolution about z of (n, 2) radii and heights."""
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    radius, height = profile[:, 0, None], profile[:, 1, None]
    x, y, z = np.broadcast_arrays(radius * np.cos(angle), radius * np.sin(angle), height)
    points = np.stack([x, y, z], -1)  # (n, sides, 3)
    vertices, triangles = grid(points, wrap_v=True)
    return vertices, triangles[:, ::-1]


def sphere(sides: int = 32) -> Part:
    """Return the unit sphere."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, sides // 2 + 1)
    return lathe(np.stack([np.cos(angle), np.sin(angle)], 1), sides)


def cylinder(radius: float, height: float, sides: int = 24, top: float = 1.0) -> Part:
    """Return a closed cylinder from z 0 to `height`; its upper radius is `top` times the lower."""
    profile = [[0, 0], [radius, 0], [radius * top, height], [0, height]]
    return lathe(np.array(profile, dtype=float), sides)


def torus(radius: float, tube: float, sides: int = 48, around: int = 20) -> Part:
    """Return a torus about z."""
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1) * radius
    return sweep(circle, round_outline(around) * tube, closed=True)


def sweep(path: Array, outline: Array, scale: Array | float = 1.0, closed: bool = False) -> Part:
    """Return a tube: the (m, 2) outline, scaled by `scale`, swept along the (n, 3) path."""
    n = len(path)
    tangent = np.roll(path, -1, 0) - np.roll(path, 1, 0) if closed else np.gradient(path, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
    side = np.empty_like(path)  # a frame with minimal twist
    side[0] = np.cross(tangent[0], np.eye(3)[np.argmin(np.abs(tangent[0]))])
    for i in range(n):
        side[i] = side[i - 1] if i else side[0]
        side[i] -= tangent[i] * (side[i] @ tangent[i])
        side[i] /= max(float(np.linalg.norm(side[i])), 1e-12)
    if closed:  # distributes the frame's remaining twist over the whole loop
        other = np.cross(tangent[0], side[0])
        twist = np.arctan2(side[-1] @ other, side[-1] @ side[0]) * np.arange(n)[:, None] / n
        side = side * np.cos(twist) - np.cross(tangent, side) * np.sin(twist)
    up = np.cross(tangent, side)
    size = np.broadcast_to(np.asarray(scale, dtype=float), (n,))[:, None, None]
    section = outline[:, :1] * side[:, None] + outline[:, 1:] * up[:, None]  # (n, m, 3)
    points = path[:, None] + size * section
    if not closed:
        first, last = (np.broadcast_to(path[i], points[0].shape)[None] for i in (0, -1))
        points = np.concatenate([first, points, last])
    vertices, triangles = grid(points, closed, True)
    return vertices, triangles[:, ::-1]


def rod(start: Array, end: Array, radius: float, sides: int = 8) -> Part:
    """Return a thin cylinder between two points."""
    return sweep(np.stack([start, end]), round_outline(sides) * radius)


def smooth_path(rng: Rng, knots: int, count: int) -> Array:
    """Return `count` points of a smooth curve through random knots in the cube -1..1 (Catmull-Rom)."""
    p = rng.uniform(-1, 1, (knots + 2, 3))
    t = np.linspace(0, knots - 1 - 1e-9, count)
    i = t.astype(int)
    t = (t - i)[:, None]
    a, b, c, d = p[i], p[i + 1], p[i + 2], p[np.minimum(i + 3, knots + 1)]
    return np.asarray(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3))


# ---- flat outlines and their extrusions -------------------------------------------------------------------


def round_outline(sides: int) -> Array:
    """Return the corners of a regular polygon in the unit circle, (sides, 2)."""
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    return np.stack([np.cos(angle), np.sin(angle)], 1)


def extrude(outer: Array, inner: Array, height: float) -> Part:
    """Return the prism between two outlines with equally many corners, from z 0 to `height`."""
    ring = np.stack([inner, outer, outer, inner])  # (4, n, 2), once around the section
    z = np.array([0, 0, height, height])[:, None, None]
    points = np.concatenate([ring, np.broadcast_to(z, (*ring.shape[:2], 1))], -1)
    vertices, triangles = grid(points, True, True)
    return vertices, triangles[:, ::-1]


def plate(holes: tuple[int, int], radius: float, height: float, sides: int = 24) -> Part:
    """Return a plate of unit square tiles, each with a round hole of `radius` below 0.5."""
    circle = round_outline(sides)
    square = circle / (2 * np.abs(circle).max(1, keepdims=True))
    tile = extrude(square, circle * radius, height)
    return join([moved(tile, offset=(x, y, 0)) for x in range(holes[0]) for y in range(holes[1])])


def box(x: float, y: float, z: float, bevel: float = 0.0) -> Part:
    """Return a box centred on the origin, with all edges chamfered by `bevel`."""
    if bevel <= 0:
        signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
        corners = signs * (x / 2, y / 2, z / 2)
        quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        return corners, np.array([[q[i] for i in tri] for q in quads for tri in ((0, 1, 2), (0, 2, 3))])
    bevel = min(bevel, 0.45 * min(x, y, z))
    sx, sy, b = x / 2, y / 2, bevel
    quarter = np.array([[sx, b - sy], [sx, sy - b], [sx - b, sy], [b - sx, sy]])
    outline = np.concatenate([quarter, -quarter])
    shrunk = outline * ((sx - b) / sx, (sy - b) / sy)
    heights = np.array([-z / 2, -z / 2, b - z / 2, z / 2 - b, z / 2, z / 2])
    layers = [0 * outline, shrunk, outline, outline, shrunk, 0 * outline]
    rings = [np.c_[layer, np.full(len(layer), height)] for layer, height in zip(layers, heights, strict=True)]
    vertices, triangles = grid(np.array(rings), wrap_v=True)
    return vertices, triangles[:, ::-1]


def bitmap(picture: NDArray[np.bool_], cell: float, height: float) -> Part:
    """Return the set pixels of a bitmap as square columns, without the walls between them."""
    set_ = np.pad(picture, 1)
    row, column = np.nonzero(set_)
    corner = np.stack([row, column, 0 * row], 1)[:, None]  # (n, 1, 3)
    bottom = np.array([[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0]])
    up = np.array([0, 0, 1])
    quads = [corner + bottom, corner + bottom[::-1] + up]
    for (dr, dc), a, b in (((-1, 0), 0, 1), ((0, 1), 1, 2), ((1, 0), 2, 3), ((0, -1), 3, 0)):
        wall = ~set_[row + dr, column + dc]
        quads.append(corner[wall] + np.array([bottom[b], bottom[a], bottom[a] + up, bottom[b] + up]))
    points = np.concatenate(quads).reshape(-1, 3) * (cell, cell, height)
    triangles = np.array([[0, 1, 2], [0, 2, 3]]) + 4 * np.arange(len(points) // 4)[:, None, None]
    return points.astype(float), triangles.reshape(-1, 3)


# ---- implicit surfaces ------------------------------------------------------------------------------------


def lattice(count: int) -> tuple[Array, Array, Array]:
    """Return open grids of x, y, z over the cube -1..1, for `isosurface`."""
    axis = np.linspace(-1, 1, count)
    return axis[:, None, None], axis[None, :, None], axis[None, None, :]


def isosurface(field: Array) -> Part:
    """Return the surface where a field changes sign, by surface nets.

    `field` is (n, n, n) over the cube -1..1, negative inside. If it is negative nowhere, the result is a sphere.
    """
    n = len(field)
    field = np.pad(field, 1, constant_values=1.0)  # closes the surface at the cube's faces
    inside = field < 0
    total = np.zeros((n + 1, n + 1, n + 1, 3))
    crossings = np.zeros((n + 1, n + 1, n + 1))
    quads = []
    for axis in range(3):
        low = [slice(None)] * 3
        high = [slice(None)] * 3
        low[axis], high[axis] = slice(0, -1), slice(1, None)
        i = np.argwhere(inside[tuple(low)] != inside[tuple(high)])  # edges along this axis with a sign change
        step = np.eye(3, dtype=np.int64)[axis]
        a, b = field[tuple(i.T)], field[tuple((i + step).T)]
        position = i + step * (a / (a - b))[:, None]
        u, v = np.eye(3, dtype=np.int64)[(axis + 1) % 3], np.eye(3, dtype=np.int64)[(axis + 2) % 3]
        cells = np.stack([i - u - v, i - v, i, i - u], 1)  # the four cells around the edge, (m, 4, 3)
        cells[a > b] = cells[a > b][:, ::-1]
        for corner in range(4):
            flat = np.ravel_multi_index(tuple(cells[:, corner].T), crossings.shape)
            crossings += np.bincount(flat, minlength=crossings.size).reshape(crossings.shape)
            for k in range(3):
                total[..., k] += np.bincount(flat, position[:, k], crossings.size).reshape(crossings.shape)
        quads.append(np.ravel_multi_index(tuple(np.moveaxis(cells, -1, 0)), crossings.shape))
    corners = np.concatenate(quads)
    if len(corners) == 0:
        return sphere()
    used = crossings.ravel() > 0
    # One vertex in each cell, at the mean of its crossings.
    vertices = total.reshape(-1, 3)[used] / crossings.ravel()[used, None]
    corners = (np.cumsum(used) - 1)[corners]
    triangles = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    return (vertices - 1) / (n - 1) * 2 - 1, triangles


# ---- placing, joining, deforming --------------------------------------------------------------------------


def join(parts: Sequence[Part]) -> Part:
    """Return several parts as one."""
    start = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    triangles = [triangles + offset for (_, triangles), offset in zip(parts, start, strict=False)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(triangles)


def moved(part: Part, matrix: Array | float = 1.0, offset: Sequence[float] | Array = (0, 0, 0)) -> Part:
    """Return the part after a (3, 3) matrix that does not mirror, or a factor, and an offset."""
    vertices, triangles = part
    turned = vertices * matrix if np.ndim(matrix) < 2 else vertices @ np.asarray(matrix).T
    return turned + np.asarray(offset), triangles


def ring(part: Part, radius: float, count: int) -> list[Part]:
    """Return copies of a part in a ring about z."""
    return [moved(moved(part, offset=(radius, 0, 0)), rotation(2, 2 * np.pi * i / count)) for i in range(count)]


def rotation(axis: int, angle: float) -> Array:
    """Return the (3, 3) rotation about x, y or z, in radians."""
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def random_rotation(rng: Rng) -> Array:
    """Return a uniformly random (3, 3) rotation."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return np.asarray(q if np.linalg.det(q) > 0 else -q)


def fitted(part: Part) -> Part:
    """Return the part moved and scaled so that its bounding box is centred and its longest side is 2."""
    vertices, triangles = part
    low, high = vertices.min(0), vertices.max(0)
    return (vertices - (low + high) / 2) * (2 / max(float((high - low).max()), 1e-9)), triangles


def noise(rng: Rng, points: Array, frequency: float) -> Array:
    """Return smooth noise of about unit variance at (n, 3) points: a sum of random plane waves."""
    waves = 12
    direction = rng.normal(size=(3, waves)) * frequency
    phase = rng.uniform(0, 2 * np.pi, waves)
    return np.asarray(np.sin(points @ direction + phase).sum(1) * np.sqrt(2 / waves))


def displaced(part: Part, amount: Array) -> Part:
    """Return the part with each vertex moved outwards along its normal by `amount`, (V,)."""
    vertices, triangles = part
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    face = np.cross(b - a, c - a)
    normal = np.zeros_like(vertices)
    for corner in range(3):
        for k in range(3):
            normal[:, k] += np.bincount(triangles[:, corner], face[:, k], len(vertices))
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    return vertices + normal * amount[:, None], triangles
