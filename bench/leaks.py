"""Leaks of closed shapes: rays from inside, aimed at edges and corners, that miss every surface.

Points inside are known independently of the tracer: for meshes by the winding number in float64, for formulas and NURBS
by their dimensions. A ray from inside must hit a surface in any direction, so no tolerance is needed.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from report import heading, shape_files, table

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.sdf import X, Y, Z, box, cylinder, sphere

FILES = (
    "anatomy_bio/dog_femur.ply",
    "animals/spot_cow.ply",
    "animals/fox.ply",
    "characters/teddy_bear.ply",
    "furniture_household/chess_queen.ply",
    "broken_odd/sliver_tet.ply",
)
BATCH = 500_000
F64 = NDArray[np.float64]
Aim = Callable[[np.random.Generator, int], F64]


@dataclass
class Target:
    """A closed shape, points (n, 3) inside it, and target points for rays, in the shape's units."""

    kind: str
    name: str
    scene: bob.Scene
    inside: F64
    aim: Aim


def winding(vertices: F64, triangles: NDArray[np.int32], point: F64) -> float:
    """Return the winding number of a closed mesh about a point: the sum of its triangles' solid angles over 4 π."""
    a, b, c = (vertices[triangles[:, corner]] - point for corner in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    dots = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return float(np.arctan2((a * np.cross(b, c)).sum(1), dots).sum() / (2 * np.pi))


def is_closed(triangles: NDArray[np.int32]) -> bool:
    """Return whether each edge occurs equally often in both directions."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    n = int(triangles.max()) + 1
    forth, back = edges[:, 0] * n + edges[:, 1], edges[:, 1] * n + edges[:, 0]
    return bool(np.array_equal(np.sort(forth), np.sort(back)))


def mesh_target(kind: str, name: str, mesh: bob.Mesh) -> Target | None:
    """Return None if the mesh is not closed after merging equal vertices, or if no point inside was found."""
    vertices, same = np.unique(mesh.vertices, axis=0, return_inverse=True)
    triangles = same.reshape(-1)[mesh.triangles].astype(np.int32)
    if not is_closed(triangles):
        return None
    rng = np.random.default_rng(0)
    low, high = vertices.min(0), vertices.max(0)
    candidates = [rng.uniform(low, high) for _ in range(400)]
    inside = [p for p in candidates if abs(winding(vertices, triangles, p)) > 0.5][:20]
    if not inside:
        return None

    def aim(rng: np.random.Generator, count: int) -> F64:
        face, corner = rng.integers(len(triangles), size=count), rng.integers(3, size=count)
        along = rng.random((count, 1)) * (rng.random((count, 1)) < 0.75)  # a quarter at corners
        start, end = vertices[triangles[face, corner]], vertices[triangles[face, (corner + 1) % 3]]
        return (1 - along) * start + along * end

    return Target(kind, name, bob.Scene(mesh), np.array(inside), aim)


def sliver_fan(thickness: float, seed: int) -> bob.Mesh:
    """Return two cones over one rim, with close pairs of points, rotated at random."""
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, 100))
    angle = np.sort(np.concatenate([angle, angle + thickness * rng.uniform(0.01, 1, 100)]))
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(200)], axis=1)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    vertices = np.concatenate([rim, [(0.1, 0.05, 0.7), (-0.05, 0, -0.8)]]) @ turn.T
    i = np.arange(200)
    after = (i + 1) % 200
    top, bottom = np.full(200, 200), np.full(200, 201)
    triangles = np.concatenate([np.stack([i, after, top], axis=1), np.stack([after, i, bottom], axis=1)])
    return bob.Mesh(vertices.astype(np.float32), triangles.astype(np.int32))


def meshes() -> list[Target]:
    """Return fans of slivers, and the closed meshes among the files."""
    fans = {f"slivers of {thin:.0e}": sliver_fan(thin, seed) for seed, thin in enumerate((1e-6, 1e-7, 1e-8, 1e-9))}
    found = [mesh_target("mesh", name, fan) for name, fan in fans.items()]
    for path in shape_files(*FILES):
        target = mesh_target("mesh", path.stem, bob.load_mesh(path))
        if target is None:
            print(f"skipped {path.name}: not closed, or no point inside was found")
        found.append(target)
    return [target for target in found if target is not None]


def formulas() -> list[Target]:
    """Return solids with edges, and rays in any direction from points inside."""
    drill = cylinder(0.25)
    solids = {
        "box": box(1),
        "ball and box": sphere(0.6) & box(0.9),
        "drilled": (sphere(1) & box(1.5)) - (drill.orient(X) | drill.orient(Y) | drill.orient(Z)),
    }
    # Balls inside each solid, by its dimensions: centre and radius.
    balls = {"box": ((0, 0, 0), 0.49), "ball and box": ((0, 0, 0), 0.44), "drilled": ((0.5, 0.5, 0.5), 0.1)}
    return [Target("formula", name, bob.Scene(solid), *in_ball(*balls[name])) for name, solid in solids.items()]


def in_ball(center: tuple[float, float, float], radius: float) -> tuple[F64, Aim]:
    """Return points in a ball, and targets all around it, a third of them in the plane y = 0."""
    rng = np.random.default_rng(0)
    way = rng.normal(size=(100, 3))
    inside = center + radius * rng.random((100, 1)) * way / np.linalg.norm(way, axis=1, keepdims=True)

    def aim(rng: np.random.Generator, count: int) -> F64:
        direction = rng.normal(size=(count, 3))
        direction[: count // 3, 1] = 0
        direction *= 3 / np.linalg.norm(direction, axis=1, keepdims=True)
        aimed: F64 = np.asarray(center) + direction
        return aimed

    return inside, aim


def splines() -> list[Target]:
    """Return a ball of one rational surface, with a seam and two poles."""
    r = np.sqrt(0.5)
    circle = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)], float)
    half = np.array([(0, -1), (1, -1), (1, 0), (1, 1), (0, 1)], float)
    points = np.concatenate([half[:, None, :1] * circle, np.broadcast_to(half[:, None, 1:], (5, 9, 1))], axis=2)
    weights = np.outer([1, r, 1, r, 1], [1, r, 1, r, 1, r, 1, r, 1])
    knots = [0, 0, 0, 1, 1, 2, 2, 2], [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]
    ball = bob.Brep([bob.Face(points, *knots, weights)])
    return [Target("NURBS", "ball", bob.Scene(ball), *in_ball((0, 0, 0), 0.9))]


def leaks(target: Target, count: int, seed: int) -> int:
    """Return the number of leaks of `count` rays from inside."""
    lost = 0
    rng = np.random.default_rng(seed)
    t = np.empty(BATCH, np.float32)
    instance, part = np.empty(BATCH, np.int32), np.empty(BATCH, np.int32)
    u, v = np.empty(BATCH), np.empty(BATCH)
    for begin in range(0, count, BATCH):
        n = min(BATCH, count - begin)
        origin = target.inside[rng.integers(len(target.inside), size=n)]
        way = target.aim(rng, n) - origin
        start = (origin - target.scene.center) / target.scene.radius
        rays = start.astype(np.float32), way.astype(np.float32)
        target.scene.core.closest_hits(*rays, t[:n], instance[:n], part[:n], u[:n], v[:n])
        lost += int(np.count_nonzero(part[:n] < 0))
    return lost


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rays", nargs="?", type=float, default=1e9, help="in all, over shapes and instruction sets")
    count = int(parser.parse_args().rays)
    best = _core.isa()
    sets = [isa for isa in ("baseline", "avx2", "avx512") if _core.set_isa(isa)]
    _core.set_isa(best)
    targets = meshes() + formulas() + splines()
    each = -(-count // (len(targets) * len(sets)))
    rows: list[list[str]] = []
    for target in targets:
        lost = []
        for isa in sets:
            _core.set_isa(isa)
            lost.append(leaks(target, each, seed=len(rows)))
        rows.append([target.kind, target.name, f"{each * len(sets):,}", *(f"{n:,}" for n in lost)])
    _core.set_isa(best)
    heading(f"Rays that leak out of closed shapes, of {each * len(sets) * len(targets):,}")
    table(["kind", "shape", "rays", *sets], rows)


if __name__ == "__main__":
    main()
