"""Tracing of degenerate NURBS faces, compared with points in double precision by code independent of the core.

Each ray is aimed at a known point of its face, so it must hit there or earlier. Each hit is projected onto the face by
Newton's method, so its distance from the face is known for any ray.
`python tests/nurbs_oracle.py` prints a table.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.support import tables

F64 = NDArray[np.float64]

TOLERANCE = 1e-5
"""Tolerance of a hit's distance from its face, in radii of the bounding sphere (docs/reference/tolerances.md)."""
AIM = 5e-6
"""Radius of a disc of rays, in radii. A miss counts only if all rays of the disc around it hit the face.

Then neither the edge nor the silhouette of the face explains it.
"""

# ---- Points in double precision --------------------------------------------------------------------------


def bezier_basis(knots: F64, degree: int, span: NDArray[np.intp], s: F64) -> tuple[F64, F64]:
    """Return the degree + 1 basis functions of each parameter's span, (N, degree + 1), and their derivatives.

    Equations 2.5 and 2.7 of *The NURBS Book*. The parameter s is 0 to 1 in its span, so narrow spans lose no precision.
    """
    low = knots[span][:, None]
    size = knots[span + 1][:, None] - low
    near = (knots[span[:, None] + np.arange(-degree, degree + 2)] - low) / size  # 0 and 1 are at degree and degree + 1
    values = np.ones((len(s), 1))
    share = values
    for p in range(1, degree + 1):
        start = near[:, degree - p + 1 : degree + 1]
        end = near[:, degree + 1 : degree + p + 1]
        share = values / (end - start)
        values = np.zeros((len(s), p + 1))
        values[:, :-1] += (end - s[:, None]) * share
        values[:, 1:] += (s[:, None] - start) * share
    slopes = np.zeros_like(values)
    slopes[:, :-1] -= degree * share
    slopes[:, 1:] += degree * share
    return values, slopes


class Surface:
    """A face without its trims, parametrised by places (N, 4).

    A place is the indices of the spans of u and v among non-empty ones, and the positions in them, 0 to 1.
    """

    def __init__(self, face: bob.Face) -> None:
        weights = np.ones(face.control_points.shape[:2]) if face.weights is None else face.weights / face.weights.max()
        self.points = np.concatenate([face.control_points * weights[..., None], weights[..., None]], axis=2)
        self.knots = face.knots_u, face.knots_v
        self.degrees = face.degree_u, face.degree_v
        self.spans = [
            p + np.flatnonzero(np.diff(knots[p : len(knots) - p]) > 0)
            for knots, p in zip(self.knots, self.degrees, strict=True)
        ]

    def places(self, u: F64, v: F64) -> F64:
        """Return the places of parameters."""
        result = []
        for x, knots, spans in zip((u, v), self.knots, self.spans, strict=True):
            i = np.clip(np.searchsorted(knots[spans], x, side="right") - 1, 0, None)
            low, high = knots[spans[i]], knots[spans[i] + 1]
            result.append((i, np.clip((x - low) / (high - low), 0, 1)))
        (i, s), (j, t) = result
        return np.stack([i, j, s, t], axis=1)

    def jets(self, places: F64) -> tuple[F64, F64, F64]:
        """Return S and its derivatives by the last two coordinates of places, each (N, 3)."""
        bases = []
        for along in (0, 1):
            span = self.spans[along][places[:, along].astype(int)]
            bases.append((span, *bezier_basis(self.knots[along], self.degrees[along], span, places[:, 2 + along])))
        (i, n, n_u), (j, m, m_v) = bases
        rows, columns = (x[:, None] - p + np.arange(p + 1) for x, p in zip((i, j), self.degrees, strict=True))
        local = self.points[rows[:, :, None], columns[:, None, :]]
        h, h_u, h_v = (np.einsum("ni,nj,nijk->nk", a, b, local) for a, b in ((n, m), (n_u, m), (n, m_v)))
        s = h[:, :3] / h[:, 3:]
        return s, (h_u[:, :3] - h_u[:, 3:] * s) / h[:, 3:], (h_v[:, :3] - h_v[:, 3:] * s) / h[:, 3:]

    def stepped(self, places: F64, steps: F64) -> F64:
        """Return places after a step, into the next span if they leave theirs, and clamped to the domain."""
        result = places.copy()
        for along in (0, 1):
            i, x = places[:, along], places[:, 2 + along] + np.nan_to_num(steps[:, along])
            last = len(self.spans[along]) - 1
            up, down = (x > 1) & (i < last), (x < 0) & (i > 0)
            at_up = (places[:, 2 + along] == 1) & up
            at_down = (places[:, 2 + along] == 0) & down
            # First to the knot, and only then into the next span, where the parametrisation may differ.
            result[:, along] = i + at_up - at_down
            result[:, 2 + along] = np.where(at_up, 0, np.where(at_down, 1, np.clip(x, 0, 1)))
        return result

    def meets(self, places: F64, origin: F64, direction: F64) -> tuple[NDArray[np.bool_], F64]:
        """Return whether Newton's method from these places finds a hit of the ray, and its distance."""
        t, found = np.zeros(len(places)), np.zeros(len(places), np.bool_)
        for _ in range(20):
            s, s_u, s_v = self.jets(places)
            matrix = np.stack([s_u, s_v, -direction], axis=2)
            with np.errstate(all="ignore"):
                size = np.prod(np.linalg.norm(matrix, axis=1), axis=1)
                regular = np.abs(np.linalg.det(matrix)) > 1e-3 * size
                step = np.zeros((len(places), 3))
                step[regular] = np.linalg.solve(matrix[regular], (origin - s)[regular][..., None])[..., 0]
            t = step[:, 2]
            found = regular & (np.linalg.norm(origin + t[:, None] * direction - s, axis=1) < 1e-9)
            places = self.stepped(places, step)
        return found, t

    def distances(self, places: F64, points: F64) -> F64:
        """Return distances of points from the face near some places, by Gauss-Newton steps that never increase it."""
        s, s_u, s_v = self.jets(places)
        best = np.linalg.norm(points - s, axis=1)
        damping = np.full(len(places), 1e-12)
        for _ in range(40):
            a, b, c = (s_u * s_u).sum(1), (s_u * s_v).sum(1), (s_v * s_v).sum(1)
            off = points - s
            f, g = (off * s_u).sum(1), (off * s_v).sum(1)
            a, c = a * (1 + damping), c * (1 + damping)
            with np.errstate(all="ignore"):
                det = a * c - b * b
                step = np.stack([(c * f - b * g) / det, (a * g - b * f) / det], axis=1)
            to = self.stepped(places, step)
            to_jets = self.jets(to)
            distance = np.linalg.norm(points - to_jets[0], axis=1)
            better = distance <= best
            best = np.where(better, distance, best)
            places = np.where(better[:, None], to, places)
            s, s_u, s_v = (np.where(better[:, None], x, y) for x, y in zip(to_jets, (s, s_u, s_v), strict=True))
            damping = np.where(better, damping / 10, np.minimum(np.maximum(damping, 1e-9) * 30, 1e12))
        return best

    def distance(self, point: F64) -> float:
        """Return the distance of a point from the face, starting at the nearest point of a grid in every pair of spans.

        Newton's method stops at kinks, which lie at knots.
        """
        spans = [range(len(spans)) for spans in self.spans]
        grid = np.stack(np.meshgrid(*spans, *2 * [np.linspace(0, 1, 33)], indexing="ij"), axis=-1).reshape(-1, 33**2, 4)
        off = [np.linalg.norm(self.jets(places)[0] - point, axis=1) for places in grid]
        starts = np.stack([places[distances.argmin()] for places, distances in zip(grid, off, strict=True)])
        return float(self.distances(starts, np.broadcast_to(point, (len(starts), 3))).min())


# ---- Faces -----------------------------------------------------------------------------------------------

Random = np.random.Generator


def knots_of(rng: Random, count: int, degree: int) -> F64:
    """Return a clamped knot vector, 0 to 1, with inner knots of any multiplicity up to the degree."""
    inner = np.sort(rng.choice(np.repeat(np.arange(1, 10) / 10, degree), count - degree - 1, replace=False))
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


def sheet(rng: Random, degrees: tuple[int, int], more: int = 4) -> F64:
    """Return control points of a wavy sheet."""
    n, m = degrees[0] + rng.integers(1, more + 1), degrees[1] + rng.integers(1, more + 1)
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, m), indexing="ij")
    return np.stack([x, y, rng.normal(scale=0.4, size=(n, m))], axis=2) + rng.normal(scale=0.1, size=(n, m, 3))


def face_of(rng: Random, points: F64, degrees: tuple[int, int], weights: F64 | None = None) -> bob.Face:
    return bob.Face(points, *(knots_of(rng, n, p) for n, p in zip(points.shape[:2], degrees, strict=True)), weights)


def some_degrees(rng: Random, highest: int = 4) -> tuple[int, int]:
    u, v = rng.integers(1, highest + 1, 2)
    return int(u), int(v)


def smooth(rng: Random) -> bob.Face:
    degrees = some_degrees(rng, 9)
    return face_of(rng, sheet(rng, degrees), degrees)


def rational(rng: Random, spread: float) -> bob.Face:
    """Weights within a factor of `spread`."""
    degrees = some_degrees(rng)
    points = sheet(rng, degrees)
    return face_of(rng, points, degrees, spread ** rng.uniform(0, 1, points.shape[:2]))


def repeated(rng: Random) -> bob.Face:
    """Repeated rows or columns of control points: patches of zero area, cusps and poles."""
    degrees = some_degrees(rng)
    points = sheet(rng, degrees, 6)
    for _ in range(rng.integers(1, 4)):
        along = int(rng.integers(2))
        lines = np.moveaxis(points, along, 0)
        first = int(rng.integers(len(lines)))
        last = min(len(lines), first + int(rng.integers(2, degrees[along] + 3)))
        lines[first:last] = lines[first] if rng.random() < 0.7 else lines[first, :1]
    weights = rng.uniform(0.5, 2, points.shape[:2]) if rng.random() < 0.3 else None
    return face_of(rng, points, degrees, weights)


def close_knots(rng: Random, gap: float) -> bob.Face:
    """Spans of about `gap` of the domain, strips of any width for repeated knots."""
    degrees = some_degrees(rng)
    points = sheet(rng, degrees, 2 * max(degrees) + 2)
    knots = []
    for n, p in zip(points.shape[:2], degrees, strict=True):
        inner = np.sort(rng.uniform(0.1, 0.9, n - p - 1))
        if len(inner):
            at, count = rng.uniform(0.3, 0.6), min(len(inner), int(rng.integers(1, 2 * p + 1)))
            inner[:count] = at + gap * (np.arange(count) // p)
            if count <= p:
                inner[count // 2 : count] += gap
            inner[count:] = rng.uniform(0.65, 0.95, len(inner) - count)
        knots.append(np.concatenate([np.zeros(p + 1), np.sort(inner), np.ones(p + 1)]))
    return bob.Face(points, *knots)


def flat(rng: Random) -> bob.Face:
    """A part of a plane with scattered control points."""
    degrees = some_degrees(rng)
    points = sheet(rng, degrees)
    frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    points = points[..., :1] * frame[0] + points[..., 1:2] * frame[1] + rng.uniform(-0.5, 0.5) * frame[2]
    weights = rng.uniform(0.5, 2, points.shape[:2]) if rng.random() < 0.3 else None
    return face_of(rng, points, degrees, weights)


def ruled(rng: Random) -> bob.Face:
    """Lines along v between two curves; parallel ones are a cylinder."""
    degrees = int(rng.integers(1, 4)), 1
    points = sheet(rng, degrees, 5)[:, :2]
    if rng.random() < 0.6:
        points[:, 1] = points[:, 0] + rng.normal(size=3)
    return bob.Face(points, knots_of(rng, len(points), degrees[0]), [0, 0, 1, 1])


# ---- Rays ------------------------------------------------------------------------------------------------


def unit(vectors: F64) -> F64:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)


def aim(rng: Random, surface: Surface, count: int, within: bool) -> tuple[F64, F64, F64]:
    """Return places, points and directions of rays: equally many in all spans, a third of them close to knots.

    If `within`, rays run along the face.
    """
    places = np.empty((count, 4))
    for along in (0, 1):
        places[:, along] = rng.integers(len(surface.spans[along]), size=count)
        x = rng.random(count)
        close = rng.random(count) < 1 / 3
        places[:, 2 + along] = np.where(close, np.abs(np.round(x) - 10.0 ** rng.uniform(-7, -1, count)), x)
    target, s_u, s_v = surface.jets(places)
    direction = rng.normal(size=(count, 3))
    if within:
        mix = rng.normal(size=(2, count, 1))
        mix[0, rng.random(count) < 0.5] = 0
        direction = mix[0] * s_u + mix[1] * s_v
    some = np.linalg.norm(direction, axis=1) > 0
    return places[some], target[some], unit(direction[some])


@dataclass
class Report:
    faces: int = 0
    refused: int = 0
    """Faces of zero area."""
    rays: int = 0
    hits: int = 0
    missed: int = 0
    """Rays that miss the face, or hit it only behind the target point."""
    off: int = 0
    """Hits farther from the face than TOLERANCE."""
    false: int = 0
    """Hits farther from it than 1e-3 radii."""
    farthest: float = 0.0
    """In radii."""


def add_rays(report: Report, face: bob.Face, rng: Random, count: int, within: bool) -> None:
    scene = bob.Scene(bob.Brep([face]))
    surface, radius = Surface(face), scene.radius
    places, target, direction = aim(rng, surface, count, within)
    back = radius * rng.uniform(2.1, 3, len(places))
    aside = rng.random(len(places)) < 0.3  # beside their points: any hit must still be on the face
    shift = 0.3 * radius * rng.normal(size=(len(places), 3)) * aside[:, None]
    origin = target - back[:, None] * direction + shift
    hits = scene.closest_hits(origin, direction)

    hit = hits.instance >= 0
    points = origin[hit] + hits.distance[hit, None] * direction[hit]
    starts = surface.places(hits.u[hit], hits.v[hit]), places[hit]
    off = np.minimum(*(surface.distances(start, points) for start in starts)) / radius
    for i in np.flatnonzero(off > TOLERANCE):
        off[i] = surface.distance(points[i]) / radius

    # Edge-on, a face has no width.
    passed = np.flatnonzero(~aside & ~within & ~(hits.distance < back + 10 * AIM * radius))
    for angle in np.arange(8) * np.pi / 4:
        a = unit(np.cross(direction[passed], direction[passed][:, [1, 2, 0]] + 0.1))
        b = np.cross(direction[passed], a)
        around = origin[passed] + AIM * radius * (np.cos(angle) * a + np.sin(angle) * b)
        meets, t = surface.meets(places[passed], around, direction[passed])
        passed = passed[meets & (t < hits.distance[passed] - 2 * AIM * radius)]

    report.rays += len(hit)
    report.hits += int(hit.sum())
    report.missed += len(passed)
    report.off += int((off > TOLERANCE).sum())
    report.false += int((off > 1e-3).sum())
    report.farthest = max(report.farthest, float(off.max(initial=0)))


KINDS: dict[str, tuple[Callable[[Random], bob.Face], bool]] = {
    "smooth": (smooth, False),
    "smooth, tangent rays": (smooth, True),
    "weights within 1e1": (lambda rng: rational(rng, 1e1), False),
    "weights within 1e3": (lambda rng: rational(rng, 1e3), False),
    "weights within 1e5": (lambda rng: rational(rng, 1e5), False),
    "weights within 1e8": (lambda rng: rational(rng, 1e8), False),
    "repeated control points": (repeated, False),
    "repeated control points, tangent rays": (repeated, True),
    "flat": (flat, False),
    "flat, rays within": (flat, True),
    "ruled, rays along": (ruled, True),
    "knots 1e-3 apart": (lambda rng: close_knots(rng, 1e-3), False),
    "knots 1e-6 apart": (lambda rng: close_knots(rng, 1e-6), False),
    "knots 1e-9 apart": (lambda rng: close_knots(rng, 1e-9), False),
    "knots 1e-12 apart": (lambda rng: close_knots(rng, 1e-12), False),
}
"""How to make a face of each kind, and whether rays run along it."""


def examine(kind: str, seeds: Iterable[int], rays: int) -> Report:
    """Trace `rays` rays at a random face of a kind for each seed."""
    make, within = KINDS[kind]
    report = Report()
    for seed in seeds:
        rng = np.random.default_rng(seed)
        face = make(rng)
        report.faces += 1
        try:
            add_rays(report, face, rng, rays, within)
        except bob.InputError:
            report.refused += 1
    return report


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--faces", type=int, default=100, help="of each kind (default: 100)")
    parser.add_argument("--rays", type=int, default=500, help="of each face (default: 500)")
    parser.add_argument("--seed", type=int, default=0, help="of the first face (default: 0)")
    parser.add_argument("--kind", choices=KINDS, action="append", help="only this kind (default: all)")
    arguments = parser.parse_args()
    seeds = range(arguments.seed, arguments.seed + arguments.faces)
    reports = {kind: examine(kind, seeds, arguments.rays) for kind in arguments.kind or KINDS}
    columns = ["kind", "faces", "without area", "rays", "hits", "missed", "> 1e-5 R off", "> 1e-3 R off", "farthest, R"]
    rows = [
        [kind, *(str(x) for x in (r.faces, r.refused, r.rays, r.hits, r.missed, r.off, r.false)), f"{r.farthest:.1e}"]
        for kind, r in reports.items()
    ]
    print(tables.table(columns, rows, left=True))
    return any(r.off or r.missed for r in reports.values())


if __name__ == "__main__":
    sys.exit(main())
