"""Direct tracing of NURBS, compared with tessellation and Embree on the triangles.

The mesh has an equal silhouette: it stays within half a pixel of the surface in a picture of 2048 x 2048, and is as
coarse as this allows. Quality is reported next to speed: the distance of the mesh, and the number of wrong pixels.
"""

from __future__ import annotations

import multiprocessing
import os
import statistics
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from embreex.rtcore import EmbreeDevice
from numpy.typing import NDArray
from rays import F32, F64, build_embree, camera_rays, random_rays, seen_alike
from report import MODELS, heading, in_turn, median_ratio, spread, table
from scipy.spatial import Delaunay
from sparse_rays import sparse_table

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.shapes.affine import mapped
from bobrossnet.shapes.nurbs import TrimCurve
from bobrossnet.shapes.splines import with_weights

FILES = ("newell_teapot.bpt", "human_head.3dm", "gear.3dm")
SIZE = (480, 640)
LARGE = (2048, 2048)
TOLERANCE = 0.5 * 2 / LARGE[0]
"""Half a pixel of the large picture, in radii of the bounding sphere."""
CAMERA = bob.Camera()
RAYS = 100_000
RUNS = 5
COPIES = 16

Triangles = NDArray[np.int32]

# ---- Meshes of equal silhouette --------------------------------------------------------------------------


@dataclass(frozen=True)
class Tessellation:
    name: str
    evaluate: Callable[[], F64]
    """The vertices, (V, 3); only their evaluation is timed."""
    triangles: Triangles
    seconds: float  # to choose parameters and triangles
    in_core: Callable[[], object] | None = None
    """The core's evaluation of faces."""


def fine_grid(n: int) -> NDArray[np.int64]:
    """Return indices (n, 5) of the samples of each of n cells: four steps a cell, both ends included."""
    return 4 * np.arange(n)[:, None] + np.arange(5)


def from_chords(points: F64) -> F64:
    """Return distances of samples (..., 5, 3) from the line through the first and last."""
    chord = points[..., -1:, :] - points[..., :1, :]
    length = np.linalg.norm(chord, axis=-1, keepdims=True)
    along = chord / np.where(length > 0, length, 1)
    offset = points - points[..., :1, :]
    distance: F64 = np.linalg.norm(offset - (offset * along).sum(-1, keepdims=True) * along, axis=-1)
    return distance


def from_planes(points: F64) -> F64:
    """Return the maximum distance of the samples (n, m, 5, 5, 3) of cells from the planes of the cell's two triangles.

    The triangles share the diagonal from the cell's first corner to its last. Returns (n, m).
    """
    first, last = points[:, :, 0, 0], points[:, :, -1, -1]
    normals = [np.cross(points[:, :, -1, 0] - first, last - first), np.cross(last - first, points[:, :, 0, -1] - first)]
    lengths = [np.linalg.norm(normal, axis=-1, keepdims=True) for normal in normals]
    flat = 1e-6 * (lengths[0] + lengths[1])  # as at poles, where the other triangle covers the whole cell
    usable = [length > flat for length in lengths]
    unit = [
        np.where(ok, n, 0) / np.where(ok, length, 1) for n, length, ok in zip(normals, lengths, usable, strict=True)
    ]
    below = np.tril(np.ones((5, 5), np.bool_))
    worst = np.zeros(points.shape[:2])
    for half, this, other, ok in ((below, *unit, usable[0]), (below.T, *unit[::-1], usable[1])):
        normal = np.where(ok, this, other)[:, :, None]
        distance = np.abs(((points[:, :, half] - first[:, :, None]) * normal).sum(-1))
        worst = np.maximum(worst, distance.max(axis=-1))
    return worst


class Span:
    """A rectangle between knots of a face, to be cut into n_u x n_v cells of two triangles each."""

    def __init__(self, face: bob.Face, u: tuple[float, float], v: tuple[float, float]) -> None:
        self.face, self.u, self.v = face, u, v

    def cells(self, n_u: int, n_v: int) -> tuple[float, NDArray[np.bool_]]:
        """Return the maximum distance of the surface from the triangles, and the cells to cut along the other diagonal.

        It is measured at 5 x 5 points of each cell; along the face's borders it is the distance from the chords. The
        mask, (n_u, n_v), is true for cells that are better cut from their second corner than from their first.
        """
        surface = self.face.points(np.linspace(*self.u, 4 * n_u + 1)[:, None], np.linspace(*self.v, 4 * n_v + 1))
        points = surface[fine_grid(n_u)[:, None, :, None], fine_grid(n_v)[None, :, None, :]]
        one, other = from_planes(points), from_planes(points[:, :, ::-1])
        (u0, u1), (v0, v1) = self.face.domain
        borders = [
            surface[index] if across else surface[:, index]
            for across, index, on in (
                (True, 0, self.u[0] == u0),
                (True, -1, self.u[1] == u1),
                (False, 0, self.v[0] == v0),
                (False, -1, self.v[1] == v1),
            )
            if on
        ]
        chords = [from_chords(border[fine_grid(len(border) // 4)]).max() for border in borders]
        return max(float(np.minimum(one, other).max()), *chords, 0.0), other < one

    def fewest(self, tolerance: float) -> tuple[int, int]:
        """Return (n_u, n_v) of about the fewest cells within the tolerance.

        The proportions follow from second derivatives (Filip, Magedson and Markot, *Surface algorithms using bounds on
        derivatives*, 1986). From there the counts grow step by step, with the distance measured.
        """
        at_u, at_v = np.linspace(*self.u, 9)[:, None], np.linspace(*self.v, 9)
        by = self.face.derivatives(at_u, at_v, 2)
        normal = self.face.normals(at_u, at_v)
        bend_u = np.abs((by[..., 2, 0, :] * normal).sum(-1)).max() * (self.u[1] - self.u[0]) ** 2
        bend_v = np.abs((by[..., 0, 2, :] * normal).sum(-1)).max() * (self.v[1] - self.v[0]) ** 2

        @cache
        def good(n_u: int, n_v: int) -> bool:
            return self.cells(n_u, n_v)[0] <= tolerance

        sides = np.sqrt([bend_u, bend_v])
        shares = sides / max(*sides, 1e-300)

        def counts(n: int) -> tuple[int, int]:
            n_u, n_v = np.maximum(1, np.round(n * shares)).astype(int).tolist()
            return n_u, n_v

        low, high = 0, 1
        while not good(*counts(high)) and high < 256:
            low, high = high, 2 * high
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if good(*counts(middle)) else (middle, high)
        best = counts(high)
        steps = ((-1, 0), (0, -1), (-1, 1), (1, -1), (-2, 1), (1, -2))
        while True:
            fewer = ((best[0] + du, best[1] + dv) for du, dv in steps)
            tries = ((u, v) for u, v in fewer if min(u, v) > 0 and u * v < best[0] * best[1])
            better = next((each for each in tries if good(*each)), None)
            if better is None:
                return best
            best = better


def spans(face: bob.Face) -> list[list[Span]]:
    """Return the spans of v within each span of u."""
    (u0, u1), (v0, v1) = face.domain
    knots_u, knots_v = (np.unique(knots) for knots in (face.knots_u, face.knots_v))
    knots_u, knots_v = knots_u[(u0 <= knots_u) & (knots_u <= u1)], knots_v[(v0 <= knots_v) & (knots_v <= v1)]
    return [[Span(face, u, v) for v in pairwise(knots_v.tolist())] for u in pairwise(knots_u.tolist())]


def untrimmed(face: bob.Face, tolerance: float) -> Iterator[tuple[F64, Triangles]]:
    """Yield parameters (n, 2) and triangles of each span separately."""
    for row in spans(face):
        for span in row:
            n_u, n_v = span.fewest(tolerance)
            _, turned = span.cells(n_u, n_v)
            u, v = np.meshgrid(np.linspace(*span.u, n_u + 1), np.linspace(*span.v, n_v + 1), indexing="ij")
            number = np.arange((n_u + 1) * (n_v + 1)).reshape(n_u + 1, n_v + 1)
            a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
            straight = np.stack([a, b, c, a, c, d], axis=-1)
            other = np.stack([b, c, d, b, d, a], axis=-1)
            triangles = np.where(turned[..., None], other, straight).reshape(-1, 3)
            yield np.stack([u.ravel(), v.ravel()], axis=1), triangles.astype(np.int32)


def curve_points(curve: TrimCurve, t: F64) -> F64:
    """Return points (n, 2) at parameters (n,), by A4.1 of *The NURBS Book*."""
    at, values = _core.basis_derivatives(curve.degree, curve.knots, t, 0)
    near = _core.homogeneous(with_weights(curve.control_points, curve.weights))[
        at[:, None] + np.arange(-curve.degree, 1)
    ]
    point = (values[:, 0, :, None] * near).sum(axis=1)
    result: F64 = point[:, :-1] / point[:, -1:]
    return result


def outlines(face: bob.Face, tolerance: float) -> list[F64]:
    """Return the loops as polygons (n, 2), with enough corners on each span of a curve for its chords in space."""
    low, high = np.transpose(face.domain)

    def within(curve: TrimCurve, t: F64) -> F64:
        return np.clip(curve_points(curve, t), low, high)

    result = []
    for loop in face.trims:
        corners = []
        for curve in loop:
            start, end = curve.domain
            knots = np.unique(np.clip(curve.knots, start, end))
            for t0, t1 in pairwise(knots.tolist()):
                n = 1
                while n < 256:
                    surface = face.points(*within(curve, np.linspace(t0, t1, 4 * n + 1)).T)
                    error = from_chords(surface[fine_grid(n)]).max()
                    if error <= tolerance:
                        break
                    n = max(n + 1, int(n * np.sqrt(error / tolerance)))
                corners.append(within(curve, np.linspace(t0, t1, n + 1)))
        result.append(np.concatenate(corners))
    return result


def trimmed(face: bob.Face, tolerance: float) -> tuple[F64, Triangles]:
    """Return parameters (n, 2) and triangles of a trimmed face.

    They are the Delaunay triangles of the polygons' corners and of a grid inside, with the polygons' sides halved until
    each is a side of a triangle.
    """
    counts = [[span.fewest(tolerance) for span in row] for row in spans(face)]
    lines, units = [], []
    by_axis: tuple[Any, Any] = counts, list(zip(*counts, strict=True))
    for axis, each in enumerate(by_axis):
        knots = sorted({t for row in spans(face) for span in row for t in ((span.u, span.v)[axis])})
        steps = [max(count[axis] for count in row) for row in each]
        parts = [np.linspace(a, b, n, endpoint=False) for (a, b), n in zip(pairwise(knots), steps, strict=True)]
        lines.append(np.append(np.concatenate(parts), knots[-1]))
        units.append(np.arange(len(lines[-1]), dtype=np.float64))

    def scaled(uv: F64) -> F64:  # cells of the grid become squares
        return np.stack([np.interp(uv[:, i], lines[i], units[i]) for i in range(2)], axis=1)

    polygons = [scaled(outline) for outline in outlines(face, tolerance)]
    corners = np.concatenate(polygons)
    ends = np.concatenate([np.roll(polygon, -1, axis=0) for polygon in polygons])
    both = np.concatenate([corners, ends])
    _, kept, inverse = np.unique(np.round(both, 7), axis=0, return_index=True, return_inverse=True)
    points, sides = both[kept], inverse.reshape(2, -1).T
    sides = sides[sides[:, 0] != sides[:, 1]]
    a, b = points[sides[:, 0]], points[sides[:, 1]]

    def inside(p: F64) -> NDArray[np.bool_]:
        x, y = p[:, :1], p[:, 1:]
        crossed = (a[:, 1] > y) != (b[:, 1] > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            right = x < a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
        odd: NDArray[np.bool_] = np.count_nonzero(crossed & right, axis=1) % 2 == 1
        return odd

    grid = np.stack(np.meshgrid(*units, indexing="ij"), axis=-1).reshape(-1, 2)
    grid = grid[inside(grid)]
    along = np.clip(((grid[:, None] - a) * (b - a)).sum(-1) / ((b - a) ** 2).sum(-1), 0, 1)
    far = np.linalg.norm(grid[:, None] - a - along[..., None] * (b - a), axis=-1).min(axis=1) > 0.3
    points = np.concatenate([points, grid[far]])
    for _ in range(10):
        triangles = Delaunay(points, qhull_options="QJ Pp").simplices
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1) @ (len(points), 1)
        missing = ~np.isin(np.sort(sides, axis=1) @ (len(points), 1), edges)
        if not missing.any():
            break
        new = len(points) + np.arange(np.count_nonzero(missing))
        points = np.concatenate([points, points[sides[missing]].mean(axis=1)])
        first, last = sides[missing].T
        halves = [np.stack([first, new], axis=1), np.stack([new, last], axis=1)]
        sides = np.concatenate([sides[~missing], *halves])
    triangles = triangles[inside(points[triangles].mean(axis=1))]
    across, beside = (points[triangles[:, i]] - points[triangles[:, 0]] for i in (1, 2))
    area = across[:, 0] * beside[:, 1] - across[:, 1] * beside[:, 0]
    triangles = triangles[np.abs(area) > 1e-7]  # corners along a straight border may form degenerate triangles
    unscaled = [np.interp(points[:, i], units[i], lines[i]) for i in range(2)]
    return np.stack(unscaled, axis=1), triangles.astype(np.int32)


def tessellate(scene: bob.Scene) -> Tessellation:
    """Return a mesh of a scene's faces.

    Neighbouring spans and faces need not match: their borders differ by up to twice the tolerance, which a real
    tessellator has to stitch.
    """
    start = time.perf_counter()
    parameters: list[tuple[bob.Face, Any, F64]] = []
    triangles, count = [], 0
    for instance in scene.instances:
        stretch = float(np.linalg.norm(instance.transform[:3, :3], 2))
        assert isinstance(instance.shape, bob.Brep)
        for face in instance.shape.faces:
            tolerance = TOLERANCE * scene.radius / stretch
            parts = [trimmed(face, tolerance)] if face.trims else list(untrimmed(face, tolerance))
            for uv, corners in parts:
                triangles.append(corners + count)
                count += len(uv)
            parameters.append((face, instance.transform, np.concatenate([uv for uv, _ in parts])))

    def evaluate() -> F64:
        return np.concatenate([mapped(matrix, face.points(*uv.T)) for face, matrix, uv in parameters])

    arguments = [
        (
            _core.homogeneous(with_weights(face.control_points, face.weights).reshape(-1, 4)).reshape(
                *face.control_points.shape[:2], 4
            ),
            face.knots_u,
            face.knots_v,
            face.degree_u,
            face.degree_v,
            np.ascontiguousarray(uv[:, 0]),
            np.ascontiguousarray(uv[:, 1]),
            0,
        )
        for face, _, uv in parameters
    ]

    def in_core() -> None:
        for each in arguments:
            _core.surface_derivatives(*each)

    corners = np.concatenate(triangles)
    same = same_place(evaluate())[1][corners]
    proper = (same != np.roll(same, 1, axis=1)).all(axis=1)  # triangles at poles may be degenerate
    return Tessellation("equal", evaluate, corners[proper], time.perf_counter() - start, in_core)


def same_place(points: F64) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the points to keep among equal points, and each point's representative."""
    rounded = np.round(points / (1e-9 * np.abs(points).max()))
    _, kept, inverse = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    return kept, inverse.reshape(-1)


def tessellate_tube(scene: bob.Scene) -> Tessellation:
    """Tessellate a tube by m rings of n corners for each span of the curve, with the fewest vertices.

    The chords along and around the tube together stay within the tolerance. The curve must not turn vertical; its ends
    stay open.
    """
    start = time.perf_counter()
    tube = scene.instances[0].shape
    assert isinstance(tube, bob.Tube)
    tolerance, radius = TOLERANCE * scene.radius, float(tube.radii[0])
    low, high = tube.domain
    knots = np.unique(np.clip(tube.knots, low, high))

    def derivatives(t: F64) -> F64:
        at, values = _core.basis_derivatives(tube.degree, tube.knots, t, 1)
        near = tube.control_points[at[:, None] + np.arange(-tube.degree, 1)]
        result: F64 = (values[..., None] * near[:, None]).sum(axis=2)
        return result

    def parameters(steps: int) -> F64:
        return np.interp(np.arange(steps * (len(knots) - 1) + 1) / steps, np.arange(len(knots)), knots)

    def bulge(steps: int) -> float:
        middle = derivatives(parameters(4 * steps))[:, 0]
        return float(from_chords(middle[fine_grid(steps * (len(knots) - 1))]).max())

    bulges = [0.0] if tube.degree == 1 else [bulge(steps) for steps in range(1, 9)]
    choices = []
    for around in range(3, 200):
        left = tolerance - radius * (1 - np.cos(np.pi / around))
        steps = next((i + 1 for i, off in enumerate(bulges) if off <= left), None)
        if steps:
            choices.append((around * steps, around, steps))
    _, around, steps = min(choices)
    t = parameters(steps)
    angle = 2 * np.pi * np.arange(around) / around

    def evaluate() -> F64:
        center, tangent = derivatives(t).transpose(1, 0, 2)
        if tube.degree == 1:  # rings lie between the segments that they join
            along = np.diff(center, axis=0)
            along /= np.linalg.norm(along, axis=1, keepdims=True)
            tangent = np.concatenate([along[:1], along[:-1] + along[1:], along[-1:]])
        side = np.cross(tangent, (0, 0, 1))
        side /= np.linalg.norm(side, axis=1, keepdims=True)
        up = np.cross(side, tangent)
        up /= np.linalg.norm(up, axis=1, keepdims=True)
        ring = np.cos(angle)[:, None] * side[:, None] + np.sin(angle)[:, None] * up[:, None]
        vertices: F64 = (center[:, None] + radius * ring).reshape(-1, 3)
        return vertices

    number = np.arange(len(t) * around).reshape(len(t), around)
    a, b = number[:-1], number[1:]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    triangles = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3).astype(np.int32)
    return Tessellation("equal", evaluate, triangles, time.perf_counter() - start)


# ---- Examples --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Example:
    name: str
    scene: bob.Scene
    meshes: list[Tessellation]


def helix() -> bob.Tube:
    t = np.linspace(0, 1, 200)
    points = np.stack([np.cos(50 * t), np.sin(50 * t), 3 * t], axis=1)
    return bob.nurbs_curve(points, [0, 0, 0, *range(198), 197, 197, 197], radius=0.05)


def knot() -> bob.Tube:
    t = np.linspace(0, 2 * np.pi, 1000)
    points = np.stack(
        [np.cos(7 * t) * (2 + np.cos(11 * t)), np.sin(7 * t) * (2 + np.cos(11 * t)), np.sin(11 * t)], axis=1
    )
    return bob.polyline(points, radius=0.05)


def examples() -> list[Example]:
    result = []
    for file in FILES:
        path = MODELS / "nurbs" / file
        if not path.is_file():
            print(f"skipped {path.stem}: no {path}; name the folder of shapes in BOBROSSNET_MODELS")
            continue
        scene = bob.load(path)
        meshes = [tessellate(scene)]
        render = path.with_suffix(".rendermesh.ply")
        if render.is_file():
            mesh = bob.load_mesh(render)
            meshes.append(Tessellation("Rhino's", partial(np.array, mesh.vertices), mesh.triangles, 0))
        result.append(Example(path.stem, scene, meshes))
    for name, tube in (("helix, 200 points", helix()), ("polyline, 1,000", knot())):
        scene = bob.Scene(tube)
        result.append(Example(name, scene, [tessellate_tube(scene)]))
    return result


def in_unit_sphere(scene: bob.Scene, points: F64) -> F32:
    return ((points - scene.center) / scene.radius).astype(np.float32)


def merged(mesh: Tessellation) -> tuple[F64, Triangles]:
    """Return vertices and triangles with equal vertices merged."""
    points = mesh.evaluate()
    kept, same = same_place(points)
    used, within = np.unique(same[mesh.triangles], return_inverse=True)
    return points[kept[used]], within.reshape(-1, 3).astype(np.int32)


# ---- The tables ------------------------------------------------------------------------------------------


def distances(scene: bob.Scene, vertices: F64, triangles: Triangles, count: int = 100_000) -> F64:
    """Return distances from random points of a mesh to the surface, in pixels of the large picture.

    They are measured along the triangles' normals, in both directions; inf for no hit within four pixels.
    """
    rng = np.random.default_rng(0)
    corners = vertices[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1)
    chosen = rng.choice(len(triangles), count, p=area / area.sum())
    weights = rng.dirichlet((1, 1, 1), count)
    points = (corners[chosen] * weights[..., None]).sum(axis=1)
    pixel = scene.radius * 2 / LARGE[0]
    direction = normal[chosen] / area[chosen, None]
    found = []
    for way in (direction, -direction):
        distance = scene.closest_hits(points - 4 * pixel * way, way).distance / pixel
        found.append(np.where(distance < 8, np.abs(distance - 4), np.inf))
    return np.minimum(*found)


def quality_row(example: Example, mesh: Tessellation) -> list[str]:
    scene = example.scene
    vertices, triangles = merged(mesh)
    off = distances(scene, vertices, triangles)
    beside = np.isfinite(off)
    other = bob.Scene(bob.Mesh(vertices, triangles))
    cameras = CAMERA, seen_alike(CAMERA, scene, other)
    ours, theirs = (bob.trace(*each, size=LARGE).depth > 0 for each in zip((scene, other), cameras, strict=True))
    return [
        example.name,
        mesh.name,
        f"{len(triangles):,}",
        f"{len(vertices):,}",
        f"{np.median(off):.3f}",
        f"{off[beside].max():.2f}",
        f"{1 - beside.mean():.2%}",
        f"{np.count_nonzero(ours != theirs) / np.count_nonzero(ours):.2%}",
        f"{mesh.seconds:.1f}" if mesh.seconds else "",
    ]


def speed_rows(example: Example, mesh: Tessellation) -> Iterator[list[str]]:
    vertices, triangles = merged(mesh)
    embree = build_embree(in_unit_sphere(example.scene, vertices), triangles)
    threads = bob.thread_count()
    for name, (origin, direction) in (("random", random_rays(RAYS)), ("camera", camera_rays(CAMERA, SIZE)[1:])):
        count = len(origin)
        t, u, v = np.empty(count, np.float32), np.empty(count), np.empty(count)
        instance, primitive = np.empty(count, np.int32), np.empty(count, np.int32)
        ours = partial(example.scene.core.closest_hits, origin, direction, t, instance, primitive, u, v)
        bob.set_thread_count(1)
        seconds = in_turn({"ours": ours, "embree": partial(embree.run, origin, direction)}, RUNS)
        bob.set_thread_count(threads)
        hits = np.asarray(embree.run(origin, direction)) >= 0
        yield [
            example.name,
            mesh.name,
            name,
            spread([count / s for s in seconds["ours"]], 1e-6, 2),
            spread([count / s for s in seconds["embree"]], 1e-6, 2),
            f"{median_ratio(seconds['embree'], seconds['ours']):.2f}",
            f"{np.mean(hits != (instance >= 0)):.2%}",
        ]


def resident_bytes() -> int:
    return int(Path("/proc/self/statm").read_text("utf-8").split()[1]) * os.sysconf("SC_PAGESIZE")


def embree_growth(vertices: F32, triangles: Triangles) -> float:
    """Return the growth of the process in bytes for each of many equal scenes in Embree, after the first few."""
    device = EmbreeDevice()
    scenes = [build_embree(vertices, triangles, device) for _ in range(COPIES)]
    before = resident_bytes()
    scenes += [build_embree(vertices, triangles, device) for _ in range(COPIES)]
    return (resident_bytes() - before) / COPIES


def memory_row(example: Example, mesh: Tessellation) -> list[str]:
    vertices, triangles = merged(mesh)
    points = in_unit_sphere(example.scene, vertices)
    with multiprocessing.get_context("spawn").Pool(1) as child:  # a process with untouched memory
        embree = child.apply(embree_growth, (points, triangles))
    ours = sum(shape.core.bytes for shape in {id(i.shape): i.shape for i in example.scene.instances}.values())
    arrays = points.nbytes + triangles.nbytes
    ours_meshed = _core.Mesh(points.astype(np.float64), triangles, None)
    ours_meshed.prepare()
    return [
        example.name,
        mesh.name,
        f"{ours / 2**10:,.0f}",
        f"{embree / 2**10:,.0f}",
        f"{ours / embree:.2f}",
        f"{arrays / 2**10:,.0f}",
        f"{points.nbytes / 2**10:,.0f}",
        f"{ours_meshed.bytes / 2**10:,.0f}",
    ]


def rebuilt(scene: bob.Scene) -> bob.Scene:
    """Return the scene with shapes that have not been built."""

    def fresh(shape: Any) -> bob.Brep | bob.Tube:
        if isinstance(shape, bob.Brep):
            return bob.Brep(shape.faces)
        return bob.Tube(shape.control_points, shape.knots, shape.radii, shape.weights)

    return bob.Scene([bob.Instance(fresh(i.shape), i.transform, i.material) for i in scene.instances])


def picture_row(example: Example, mesh: Tessellation, pool: ThreadPoolExecutor) -> list[str]:
    scene = example.scene
    _, origin, direction = camera_rays(CAMERA, SIZE)
    bands = np.array_split(np.arange(len(origin)), 8 * bob.thread_count())
    slices = [slice(int(band[0]), int(band[-1]) + 1) for band in bands]

    def embree() -> tuple[float, float, float]:
        start = time.perf_counter()
        points = in_unit_sphere(scene, mesh.evaluate())
        evaluated = time.perf_counter()
        built = build_embree(points, mesh.triangles)
        traced = time.perf_counter()
        list(pool.map(lambda rows: built.run(origin[rows], direction[rows]), slices))
        return evaluated - start, traced - evaluated, time.perf_counter() - traced

    parts = []
    seconds = in_turn(
        {
            "ours": lambda: bob.trace(rebuilt(scene), CAMERA, size=SIZE),
            "trace": lambda: bob.trace(scene, CAMERA, size=SIZE),
            "embree": lambda: parts.append(embree()),
            "shaded": lambda: bob.trace(bob.Mesh(mesh.evaluate(), mesh.triangles), CAMERA, size=SIZE),
            "core": mesh.in_core or (lambda: None),
        },
        RUNS,
    )
    return [
        example.name,
        mesh.name,
        spread(seconds["ours"], 1e3),
        spread(seconds["trace"], 1e3),
        spread(seconds["embree"], 1e3),
        f"{1e3 * statistics.median(seconds['core']):.1f}" if mesh.in_core else "",
        *(f"{1e3 * statistics.median(part):.1f}" for part in zip(*parts[1:], strict=True)),
        f"{median_ratio(seconds['ours'], seconds['embree']):.2f}",
        spread(seconds["shaded"], 1e3),
        f"{median_ratio(seconds['ours'], seconds['shaded']):.2f}",
    ]


def main() -> None:
    shown = [(example, mesh) for example in examples() for mesh in example.meshes]
    threads = bob.thread_count()

    heading("NURBS and meshes: accuracy of the meshes, in pixels of 2048 x 2048")
    columns = ["shape", "mesh", "triangles", "vertices", "off by, median", "maximum", "off the surface"]
    table([*columns, "pixels that differ", "seconds to choose"], [quality_row(*each) for each in shown])

    heading("NURBS and meshes in Embree, one thread: millions of rays per second")
    rows = [row for each in shown for row in speed_rows(*each)]
    table(["shape", "mesh", "rays", "ours", "Embree", "ours / Embree", "hits that differ"], rows)
    print("\ntarget: ours / Embree of 0.75 for the rays of a camera, and of 0.25 for others")

    sparse_table("NURBS", {example.name: example.scene for example, mesh in shown if mesh.name == "equal"}, CAMERA)
    print("\ntarget: 1.5 times a dense ray at 5 %, and 1.3 at 25 %")

    if Path("/proc/self/statm").exists():
        heading("NURBS and meshes in Embree: KiB")
        columns = [
            "shape",
            "mesh",
            "ours",
            "Embree, all",
            "ours / Embree",
            "vertices and indices",
            "normals, if any",
        ]
        table([*columns, "bob.Mesh"], [memory_row(*each) for each in shown])
        print("\ntarget: less than Embree")

    heading(f"NURBS and meshes in Embree, the first picture, 640x480: milliseconds, {threads} threads")
    columns = [
        "shape",
        "mesh",
        "ours, build and trace",
        "trace",
        "mesh, all",
        "evaluate in the core",
        "in all",
        "build",
        "trace it",
    ]
    with ThreadPoolExecutor(threads) as pool:
        rows = [picture_row(*each, pool) for each in shown]
    table([*columns, "ours / mesh", "shaded, by bob.Mesh", "ours / shaded"], rows)
    print("\ntarget: sooner than the mesh")
    for row in rows:
        if row[0] == "newell_teapot":
            print(f"\nTeapot, every pixel, {threads} threads: {row[3]} ms; target: 80")


if __name__ == "__main__":
    main()
