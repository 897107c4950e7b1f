"""Rays per second against Embree: the same rays, in the same run, one thread each.

Rays are orthographic, of random directions, spread evenly over the disc that the bounding sphere fills: the worst case
for caches, and no ray is like its neighbour. Also the time that each takes to build its BVH, with all threads; then
what sparse pictures cost, ray by ray and as a whole.
"""

from __future__ import annotations

import statistics
from functools import partial

import numpy as np
from rays import build_embree, random_rays
from report import heading, in_turn, median_ratio, shape_files, spread, table
from sparse import SHARES, sparse_table

import bobrossnet as bob
from bobrossnet import _core

FILES = (
    "scans/stanford_bunny.ply",
    "scans/armadillo.ply",
    "mechanical/satellite_fm1.ply",
    "architecture/conference_room.ply",
)
RAYS = 200_000
RUNS = 7
INSTANCES = 4096


def prepared(mesh: bob.Mesh) -> _core.Mesh:
    """Ready for its first ray, with normals that are computed."""
    shape = _core.Mesh(mesh.vertices, mesh.triangles, None)
    shape.prepare()
    return shape


def crowd(mesh: bob.Mesh) -> bob.Scene:
    """So many instances of a shape, in a cube, each turned otherwise."""
    side = round(INSTANCES ** (1 / 3))
    places = np.indices((side, side, side)).reshape(3, -1).T
    turned = (bob.Instance(mesh).rotate(2.4 * i, (1, 2, 3)) for i in range(len(places)))
    return bob.Scene([each.translate(1.5 * place) for each, place in zip(turned, places, strict=True)])


def whole_pictures() -> None:
    """Print what `bob.trace` takes, in all, for shares of the built-in scene's pixels."""
    scene, camera = bob.Scene(bob.happy_tree()), bob.Camera()
    orders = ("lattice", "adaptive")
    runs = {
        f"{order} {share:.0%}": partial(bob.trace, scene, camera, fraction=share, order=order)
        for order in orders
        for share in SHARES
    }
    seconds = in_turn(runs, 3 * RUNS)
    heading(f"Sparse pictures of the built-in scene, 640x480, by bob.trace: milliseconds, {bob.thread_count()} threads")
    rows = []
    for order in orders:
        each = [seconds[f"{order} {share:.0%}"] for share in SHARES]
        rows.append([order, *(spread(s, 1e3) for s in each), *(f"{median_ratio(s, each[-1]):.1%}" for s in each[:-1])])
    shares = [f"{share:.0%}" for share in SHARES]
    table(["order", *shares, *(f"{share} / 100%" for share in shares[:-1])], rows)


def main() -> None:
    origin, direction = random_rays(RAYS)
    t = np.empty(RAYS, np.float32)
    instance, triangle = np.empty(RAYS, np.int32), np.empty(RAYS, np.int32)
    u, v = np.empty(RAYS), np.empty(RAYS)
    threads = bob.thread_count()
    rays, builds, scenes = [], [], {}
    for path in shape_files(*FILES):
        mesh = bob.load_mesh(path)
        scene = scenes[path.stem] = bob.Scene(mesh)
        vertices = ((mesh.vertices - scene.center) / scene.radius).astype(np.float32)

        shape = prepared(mesh)
        build = in_turn(
            {
                "ours": partial(prepared, mesh),
                "embree": partial(build_embree, vertices, mesh.triangles),
            },
            RUNS,
        )
        embree = build_embree(vertices, mesh.triangles)
        ours = partial(scene.core.closest_hits, origin, direction, t, instance, triangle, u, v)

        bob.set_thread_count(1)
        seconds = in_turn({"ours": ours, "embree": partial(embree.run, origin, direction)}, RUNS)
        bob.set_thread_count(threads)
        many = in_turn({"ours": ours}, RUNS)["ours"]

        hits = np.asarray(embree.run(origin, direction)) >= 0
        ratio = median_ratio(seconds["embree"], seconds["ours"])
        rays.append(
            [
                path.stem,
                f"{len(mesh.triangles):,}",
                spread([RAYS / s for s in seconds["ours"]], 1e-6, 2),
                spread([RAYS / s for s in seconds["embree"]], 1e-6, 2),
                f"{ratio:.2f}",
                f"{statistics.median(seconds['ours']) / statistics.median(many):.2f}",
                f"{np.count_nonzero(hits != (triangle >= 0))} of {RAYS:,}",
            ]
        )
        builds.append(
            [
                path.stem,
                spread(build["ours"], 1e3),
                spread(build["embree"], 1e3),
                f"{median_ratio(build['ours'], build['embree']):.2f}",
                f"{shape.bvh_bytes / len(mesh.triangles):.0f}",
                f"{shape.bytes / len(mesh.triangles):.0f}",
            ]
        )
    heading("Tracing: millions of rays per second")
    columns = ["shape", "triangles", "ours", "Embree", "ours / Embree", f"{threads} threads / 1", "hits that differ"]
    table(columns, rays)
    heading("Building: milliseconds, all threads, shading normals included in ours")
    table(["shape", "ours", "Embree", "ours / Embree", "BVH bytes a triangle", "with normals"], builds)
    scenes |= {"built-in": bob.Scene(bob.happy_tree()), f"{INSTANCES:,} small ones": crowd(bob.happy_tree())}
    sparse_table("Meshes and scenes", scenes, bob.Camera())
    whole_pictures()


if __name__ == "__main__":
    main()
