"""Rays per second of a thread's CPU time against Embree: the same rays, in the same run.

Rays are orthographic and incoherent, with random directions over the disc of the bounding sphere: the worst case for
caches. Also the time to build each BVH, with all threads; the cost of sparse pictures, per ray and in total; and the
cost of perspective pictures compared with orthographic ones.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np
from rays import build_embree, random_rays
from report import heading, in_turn, median_ratio, shape_files, spread, table
from sparse_rays import SHARES, SIZE, on_one_thread, sparse_table

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.sdf import X, Y, Z, box, cylinder, sphere
from bobrossnet.tracing.pixels import tiled_pixels
from bobrossnet.tracing.trace import SceneTracer

FILES = (
    "scans/stanford_bunny.ply",
    "scans/armadillo.ply",
    "mechanical/satellite_fm1.ply",
    "architecture/conference_room.ply",
)
RAYS = 200_000
RUNS = 7
FOVS = (0, 35, 60, 90)
INSTANCES = 4096


def prepared(mesh: bob.Mesh) -> _core.Mesh:
    """Build the core's mesh, ready for its first ray, with computed normals."""
    shape = _core.Mesh(mesh.vertices, mesh.triangles, None)
    shape.prepare()
    return shape


def crowd(mesh: bob.Mesh) -> bob.Scene:
    """Return `INSTANCES` instances of a shape in a cube, each with another rotation."""
    side = round(INSTANCES ** (1 / 3))
    places = np.indices((side, side, side)).reshape(3, -1).T
    turned = (bob.Instance(mesh).rotate(2.4 * i, (1, 2, 3)) for i in range(len(places)))
    return bob.Scene([each.translate(1.5 * place) for each, place in zip(turned, places, strict=True)])


def whole_pictures() -> None:
    """Print the total time of `bob.trace` for shares of the built-in scene's pixels."""
    scene, camera = bob.Scene(bob.happy_tree()), bob.Camera()
    orders = ("lattice", "adaptive", "squares")
    runs = {
        f"{order} {share:.0%}": partial(bob.trace, scene, camera, fraction=share, order=order)
        for order in orders
        for share in SHARES
    }
    seconds = in_turn(runs, 3 * RUNS, clock=time.process_time)
    threads = bob.thread_count()
    heading(f"Sparse pictures of the built-in scene, 640x480, by bob.trace: ms of processor time, {threads} threads")
    rows = []
    for order in orders:
        each = [seconds[f"{order} {share:.0%}"] for share in SHARES]
        rows.append([order, *(spread(s, 1e3) for s in each), *(f"{median_ratio(s, each[-1]):.1%}" for s in each[:-1])])
    shares = [f"{share:.0%}" for share in SHARES]
    table(["order", *shares, *(f"{share} / 100%" for share in shares[:-1])], rows)


def perspective_table(scenes: Mapping[str, bob.Scene]) -> None:
    """Print the time of a pixel in perspective, relative to an orthographic picture's."""
    columns = [f"{fov}°" if fov else "orthographic" for fov in FOVS]
    pixels = tiled_pixels(SIZE)
    rows = []
    for name, scene in scenes.items():
        tracers = [SceneTracer(scene, bob.Camera(fov=fov), SIZE) for fov in FOVS]
        runs = {column: on_one_thread(partial(trace, pixels)) for column, trace in zip(columns, tracers, strict=True)}
        each = list(in_turn(runs, RUNS, clock=time.thread_time).values())
        hits = [trace(pixels).hit.mean() for trace in tracers]
        took = [f"{1e6 * statistics.median(s) / len(pixels):.3f}" for s in each]
        rows.append(
            [
                name,
                *(f"{taken} ({100 * hit:.0f} %)" for taken, hit in zip(took, hits, strict=True)),
                *(f"{median_ratio(s, each[0]):.2f}" for s in each[1:]),
            ]
        )
    heading("Perspective, every pixel of 512x512, one thread: µs of processor time a pixel (and pixels that hit)")
    table(["shape", *columns, *(f"{column} / orthographic" for column in columns[1:])], rows)


def carved() -> bob.Scene:
    """Return the README's formula."""
    drill = cylinder(0.5)
    return bob.Scene((sphere(1) & box(1.5)) - (drill.orient(X) | drill.orient(Y) | drill.orient(Z)))


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

        one = on_one_thread(ours)
        seconds = in_turn({"ours": one, "embree": partial(embree.run, origin, direction)}, RUNS, clock=time.thread_time)
        both = in_turn({"one": one, "many": ours}, RUNS)

        hits = np.asarray(embree.run(origin, direction)) >= 0
        ratio = median_ratio(seconds["embree"], seconds["ours"])
        rays.append(
            [
                path.stem,
                f"{len(mesh.triangles):,}",
                spread([RAYS / s for s in seconds["ours"]], 1e-6, 2),
                spread([RAYS / s for s in seconds["embree"]], 1e-6, 2),
                f"{ratio:.2f}",
                f"{median_ratio(both['one'], both['many']):.2f}",
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
    kinds = {name: scenes[name] for name in (*(Path(file).stem for file in (FILES[0], FILES[-1])), "built-in")}
    (teapot,) = shape_files("nurbs/newell_teapot.bpt")
    perspective_table(kinds | {"CSG, a formula": carved(), "newell_teapot, NURBS": bob.load(teapot)})


if __name__ == "__main__":
    main()
