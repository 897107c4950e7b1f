"""Direct tracing of implicit surfaces, compared with sphere tracing in numpy and with a mesh.

The rivals use the same formula, a plain numpy function, and the same camera. Sphere tracing advances by f / L, with the
maximum slope L of f. The mesh is made by marching cubes, fine enough for its picture to equal the direct one. Quality
is reported next to speed: wrong pixels of sphere tracing, and the distance of the mesh.

Also sparse pictures: the cost per ray when few pixels are traced, and when all are.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rays import camera_rays, seen_alike
from report import MODELS, heading, in_turn, median_ratio, spread, table
from skimage.measure import marching_cubes
from sparse_rays import on_one_thread, sparse_table

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.sdf import X, Y, Z, box, cylinder, ease, rounded_box, rounded_cylinder, sphere

sys.path.insert(0, str(Path(__file__).parent.parent / "docs"))

from gallery import FORMULAS, made

Formula = Callable[[Any, Any, Any], Any]
"""f(x, y, z) of broadcastable numpy arrays, of their dtype."""

Floats = NDArray[np.floating[Any]]

SIZE = (480, 640)
CAMERA = bob.Camera()
PIXELS = SIZE[0] * SIZE[1]
RUNS = 5
RIVAL_RUNS = 3
GRIDS = (32, 48, 64, 96, 128, 192, 256)
CUBE = np.array(((-1, -1, -1), (1, 1, 1)))
EQUAL = 0.5 / 255
"""Tolerance of gray, as a mean over the object's pixels: half a step of an 8-bit file, its maximum rounding error.

A mesh within it is as good as the direct picture.
"""

# ---- Shapes ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Example:
    name: str
    shape: bob.Implicit
    formula: Formula  # of the same values as the shape's
    far: float = np.inf
    """Sphere tracing ignores larger values, so that only slopes where f is below it bound its steps."""


def csg(x: Any, y: Any, z: Any) -> Any:
    """The example of fogleman/sdf: sphere(1) & box(1.5) minus three cylinders of radius 0.5."""
    xx, yy, zz = x * x, y * y, z * z
    ball = np.sqrt(xx + yy + zz) - 1
    beyond = [np.abs(axis) - 0.75 for axis in (x, y, z)]
    outside = sum(np.square(np.maximum(each, 0)) for each in beyond)
    cube = np.sqrt(outside) + np.minimum(np.maximum(np.maximum(beyond[0], beyond[1]), beyond[2]), 0)
    holes = np.sqrt(np.minimum(np.minimum(xx + yy, yy + zz), xx + zz)) - 0.5
    return np.maximum(np.maximum(ball, cube), -holes)


def gyroid(x: Any, y: Any, z: Any) -> Any:
    """Walls about a fiftieth of the radius thick, in a ball."""
    u, v, w = 10 * x, 10 * y, 10 * z
    wall = np.abs(np.sin(u) * np.cos(v) + np.sin(v) * np.cos(w) + np.sin(w) * np.cos(u)) - 0.15
    return np.maximum(wall, 10 * (np.sqrt(x * x + y * y + z * z) - 1))


def mandelbulb(x: Any, y: Any, z: Any) -> Any:
    """Points p with p^8 + p within 2 of the origin; the power is White and Nylander's, in closed form."""

    def eightfold(c: Any, s: Any) -> tuple[Any, Any]:
        """Return cosine and sine of eight times an angle, from those of the angle."""
        c2 = 2 * c * c - 1
        c4 = 2 * c2 * c2 - 1
        return 2 * c4 * c4 - 1, 8 * s * c * c2 * c4

    rho = np.sqrt(x * x + y * y)
    rr = x * x + y * y + z * z
    r = np.sqrt(rr)
    cos_polar, sin_polar = eightfold(np.clip(z / r, -1, 1), np.clip(rho / r, 0, 1))
    cos_azimuth, sin_azimuth = eightfold(np.clip(x / rho, -1, 1), np.clip(y / rho, -1, 1))
    power = np.square(np.square(rr))
    a, b, c = power * sin_polar * cos_azimuth + x, power * sin_polar * sin_azimuth + y, power * cos_polar + z
    return np.sqrt(a * a + b * b + c * c) - 2


def vm_formula(path: Path) -> Formula:
    """Return a .vm file's formula, evaluated step by step in numpy."""
    functions: Mapping[str, Callable[..., Any]] = {
        "add": np.add,
        "sub": np.subtract,
        "mul": np.multiply,
        "min": np.minimum,
        "max": np.maximum,
        "neg": np.negative,
        "square": np.square,
        "sqrt": np.sqrt,
    }
    lines = [line.split() for line in path.read_text("utf-8").splitlines() if line and not line.startswith("#")]
    last_use = {operand: i for i, (_, _, *operands) in enumerate(lines) for operand in operands}

    def formula(x: Any, y: Any, z: Any) -> Any:
        values: dict[str, Any] = {}
        variables = {"var-x": x, "var-y": y, "var-z": z}
        for i, (name, op, *operands) in enumerate(lines):
            if op in variables:
                values[name] = variables[op]
            elif op == "const":
                values[name] = float(operands[0])  # takes the arrays' dtype, unlike a numpy scalar
            else:
                values[name] = functions[op](*(values[operand] for operand in operands))
            for operand in operands:
                if last_use[operand] == i:
                    values.pop(operand, None)  # temporaries stay in the cache
        return values[lines[-1][0]]

    return formula


def cut(formula: Formula, bounds: NDArray[np.float64] | None) -> Formula:
    """Return the formula within a box, if there is one."""
    if bounds is None:
        return formula
    sides = [(float(low + high) / 2, float(high - low) / 2) for low, high in bounds.T]

    def within(*p: Any) -> Any:
        result = formula(*p)
        for axis, (middle, half) in zip(p, sides, strict=True):
            result = np.maximum(result, np.abs(axis - middle) - half)
        return result

    return within


def vm_shape(name: str) -> bob.Implicit | None:
    """Return a .vm file of the folder of shapes, or None if it is missing, with a printed reason."""
    path = vm_path(name)
    if not path.is_file():
        print(f"skipped {name}: no {path}; name the folder of shapes in BOBROSSNET_MODELS")
        return None
    shape = bob.load(path).instances[0].shape
    assert isinstance(shape, bob.Implicit)
    return shape


def vm_path(name: str) -> Path:
    return MODELS / "implicit" / f"{name}.vm"


def solid() -> bob.Implicit:
    """Return `csg` in the modelling language."""
    holes = cylinder(0.5)
    result: bob.Implicit = (sphere(1) & box(1.5)) - (holes | holes.orient(X) | holes.orient(Y))
    return result


def knob() -> bob.Implicit:
    """Return a knurled knob: a cylinder minus two rings of boxes, twisted in opposite directions."""
    teeth = box((1, 1, 4)).rotate(np.pi / 4).circular_array(24, 1.6)
    result = rounded_cylinder(1, 0.1, 5) - (teeth.twist(0.75) | teeth.twist(-0.75)).k(0.1)
    return result - cylinder(0.5).k(0.1)


def weave() -> bob.Implicit:
    """Return bent strips, three at each point of two lattices, each including the eight neighbouring points' strips."""
    strip = rounded_box([3.2, 1, 0.25], 0.1).translate((1.5, 0, 0.0625))
    bent = strip.bend_linear(X * 0.75, X * 2.25, Z * -0.1875, ease.in_out_quad)
    some = bent.circular_array(3, 0).repeat((2.7, 5.4, 0), padding=1)
    result: bob.Implicit = (some | some.translate((2.7 / 2, 2.7, 0))) & cylinder(10)
    return result


def prepared() -> dict[str, bob.Implicit]:
    """Return further shapes, with discontinuous formulas or many parts."""
    folder = Path(__file__).parent.parent / "examples"
    scripts = {name: bob.load(folder / name).instances[0].shape for name in ("gear.sdf", "vase.sdf", "tower.sdf")}
    return {**scripts, "knob": knob(), "weave": weave()}  # type: ignore[dict-item]


def examples() -> list[Example]:
    result = [
        Example("CSG", solid(), csg),
        Example("gyroid", bob.implicit(gyroid), gyroid),
        Example("Mandelbulb", bob.implicit(mandelbulb, 1.25 * CUBE), mandelbulb, far=1),
    ]
    colonnade = vm_shape("colonnade")
    if colonnade is not None:
        result.append(Example("colonnade", colonnade, vm_formula(vm_path("colonnade"))))
    points = np.random.default_rng(0).uniform(-1, 1, (1000, 3))
    for example in result:
        assert np.allclose(example.formula(*points.T), example.shape.expression(points), 1e-9), example.name
    return [replace(each, formula=cut(each.formula, each.shape.bounds)) for each in result]


# ---- Sphere tracing in numpy -----------------------------------------------------------------------------


def evaluate(formula: Formula, *points: Floats) -> Floats:
    """Evaluate f at points, x, y and z each (n,), in blocks that fit the cache."""
    values = np.empty_like(points[0])
    for start in range(0, len(values), 2**14):
        block = slice(start, start + 2**14)
        values[block] = formula(*(axis[block] for axis in points))
    return values


def gradient(formula: Formula, points: Floats, step: float) -> Floats:
    """Return gradients (3, n) at points (3, n), by central differences."""
    result = np.empty_like(points)
    for axis in range(3):
        beside = np.zeros((3, 1), points.dtype)
        beside[axis] = step
        result[axis] = evaluate(formula, *(points + beside)) - evaluate(formula, *(points - beside))
    return result / (2 * step)


def steepest_slope(example: Example, scene: bob.Scene, count: int = 2**18) -> float:
    """Return the largest gradient at random points of the bounding sphere, except where f is far from 0."""
    rng = np.random.default_rng(0)
    direction = rng.normal(size=(3, count))
    points = direction / np.linalg.norm(direction, axis=0) * np.cbrt(rng.random(count))
    points = scene.center[:, None] + scene.radius * points
    near = evaluate(example.formula, *points) < example.far
    slopes = gradient(example.formula, points[:, near], 1e-5 * scene.radius)
    return float(np.linalg.norm(slopes, axis=0).max())


class Rays:
    """Rays of a picture's pixels that hit the bounding sphere, starting at it.

    Attributes
    ----------
    pixels : (n,) int, in row-major order
    origin : (3, n) float32
    direction : (3, 1) float32
    length : (n,) float32, distance to the exit from the sphere
    """

    def __init__(self, scene: bob.Scene, camera: bob.Camera, size: tuple[int, int]) -> None:
        self.pixels, origin, direction = camera_rays(camera, size)
        self.origin = (scene.center + scene.radius * origin).T.astype(np.float32)
        self.direction = direction[:1].T
        self.length = (-2 * scene.radius * (origin * direction).sum(axis=1)).astype(np.float32)


def sphere_trace(example: Example, rays: Rays, steepest: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return distances of the first hits, (n,), and the normals there, (3, hits).

    NaN where a ray has no hit within a thousand steps. Finished rays are dropped from later steps.
    """
    found = np.full(len(rays.pixels), np.nan, np.float32)
    ray, points, length = np.arange(len(found)), rays.origin.copy(), rays.length
    t = np.zeros_like(length)
    for _ in range(1000):
        values = evaluate(example.formula, *points)
        hit = np.abs(values) < 1e-4
        found[ray[hit]] = t[hit]
        step = np.minimum(values, example.far) / steepest
        t += step
        points += step * rays.direction
        active = ~hit & (t < length)
        if not active.all():
            ray, points, length, t = ray[active], points[:, active], length[active], t[active]
        if not len(ray):
            break
    hits = np.flatnonzero(~np.isnan(found))
    slopes = gradient(example.formula, rays.origin[:, hits] + found[hits] * rays.direction, 1e-3)
    return found, slopes / np.linalg.norm(slopes, axis=0)


# ---- Meshes ----------------------------------------------------------------------------------------------


def mesh_of(example: Example, cells: int) -> bob.Scene:
    """Return the marching cubes mesh of a grid with `cells` points along each axis."""
    low, high = example.shape.bounding_box(np.eye(4))
    low, high = low - 0.01 * (high - low), high + 0.01 * (high - low)
    x, y, z = np.linspace(low, high, cells).T
    values = np.empty((cells, cells, cells))
    for i in range(cells):  # plane by plane, so that temporaries stay in the cache
        values[i] = example.formula(x[i], y[:, None], z)
    vertices, triangles, _, _ = marching_cubes(values, 0, spacing=(high - low) / (cells - 1))  # type: ignore[no-untyped-call]
    return bob.Scene(bob.Mesh(low + vertices, triangles))


def gray_error(mesh: bob.GBuffer, direct: bob.GBuffer) -> float:
    """Return the mean difference of gray over the object's pixels."""
    object_pixels = (mesh.depth > 0) | (direct.depth > 0)
    return float(np.abs(mesh.gray - direct.gray)[object_pixels].mean())


@dataclass(frozen=True)
class MeshPicture:
    cells: int
    triangles: int
    error: float
    seconds: float  # for sampling, marching cubes, BVH and tracing


def equal_mesh(example: Example, scene: bob.Scene, direct: bob.GBuffer) -> MeshPicture:
    """Return the coarsest mesh as good as the direct picture, or the finest one tried."""
    for cells in GRIDS:
        start = time.perf_counter()
        mesh = mesh_of(example, cells)
        picture = bob.trace(mesh, seen_alike(CAMERA, scene, mesh), size=SIZE)
        seconds = time.perf_counter() - start
        result = MeshPicture(cells, mesh.counts()["triangle"], gray_error(picture, direct), seconds)
        if result.error <= EQUAL:
            break
    return result


# ---- The tables ------------------------------------------------------------------------------------------


def build(shape: bob.Implicit) -> bob.Scene:
    """Build a scene of the shape, ready for its first ray, from the formula."""
    scene = bob.Scene(bob.Implicit(shape.expression, shape.bounds))
    assert scene.core
    return scene


def build_row(name: str, shape: bob.Implicit) -> list[str]:
    bounds = _core.find_bounds(shape.expression) if shape.bounds is None else shape.bounds
    assert bounds is not None
    seconds = in_turn({"cells": partial(_core.Implicit, shape.expression, bounds), "all": partial(build, shape)}, RUNS)
    core = shape.core
    assert isinstance(core, _core.Implicit)
    return [
        name,
        f"{len(shape.expression)}",
        spread(seconds["cells"], 1e3),
        spread(seconds["all"], 1e3),
        f"{core.cells:,}",
        f"{core.bytes / 2**20:.1f}",
    ]


def trace_row(example: Example, trace: Callable[[], object]) -> list[str]:
    before = example.shape.unresolved_rays
    trace()
    unresolved = example.shape.unresolved_rays - before
    seconds = in_turn({"all": trace, "one": on_one_thread(trace)}, RUNS)
    return [
        example.name,
        spread(seconds["all"], 1e3),
        *(spread([PIXELS / s for s in seconds[threads]], 1e-6, 2) for threads in ("all", "one")),
        f"{median_ratio(seconds['one'], seconds['all']):.2f}",
        f"{unresolved:,}",
    ]


def numpy_row(example: Example, scene: bob.Scene, trace: Callable[[], bob.GBuffer]) -> list[str]:
    steepest = steepest_slope(example, scene)
    rays = Rays(scene, CAMERA, SIZE)
    rival = partial(sphere_trace, example, rays, steepest)
    seconds = in_turn({"all": trace, "one": on_one_thread(trace), "numpy": rival}, RIVAL_RUNS)
    t, _ = rival()
    depth = trace().depth.ravel()[rays.pixels]
    theirs, ours = ~np.isnan(t), depth > 0
    off = np.abs(t - rays.length / 2 + scene.radius * (2 * depth - 1))[theirs & ours] / scene.radius
    return [
        example.name,
        f"{steepest:.3g}",
        spread([PIXELS / s for s in seconds["numpy"]], 1e-6, 3),
        f"{median_ratio(seconds['numpy'], seconds['all']):.1f}",
        f"{median_ratio(seconds['numpy'], seconds['one']):.1f}",
        f"{np.mean(ours & ~theirs):.2%}",
        f"{np.mean(theirs & ~ours):.2%}",
        f"{np.median(off):.1e}",
    ]


def mesh_row(example: Example, scene: bob.Scene, trace: Callable[[], bob.GBuffer]) -> list[str]:
    direct = trace()
    mesh = equal_mesh(example, scene, direct)
    seconds = in_turn({"ours": lambda: bob.trace(build(example.shape), CAMERA, size=SIZE)}, RIVAL_RUNS)["ours"]
    more = "" if mesh.error <= EQUAL else "> "
    return [
        example.name,
        f"{more}{mesh.cells}",
        f"{mesh.triangles:,}",
        f"{mesh.error:.4f}",
        f"{more}{1e3 * mesh.seconds:,.0f}",
        spread(seconds, 1e3, 0),
        f"{more}{mesh.seconds / statistics.median(seconds):.1f}",
    ]


def sparse_scenes() -> dict[str, bob.Scene]:
    """Return shapes with expensive rays and with cheap rays."""
    shapes = {name: vm_shape(name) for name in ("bear", "prospero", "tanglecube", "colonnade")}
    shapes |= {"gyroid": bob.implicit(gyroid), "CSG": solid()} | prepared()
    return {name: bob.Scene(shape) for name, shape in shapes.items() if shape is not None}


def main() -> None:
    shapes = examples()
    scenes = [bob.Scene(example.shape) for example in shapes]
    traces = [partial(bob.trace, scene, CAMERA, size=SIZE) for scene in scenes]
    threads = bob.thread_count()

    heading(f"Implicit surfaces, building: milliseconds, {threads} threads")
    columns = ["shape", "steps", "cells", "all before the first ray", "number of cells", "MiB"]
    built = {example.name: example.shape for example in shapes} | prepared()
    table(columns, [build_row(*each) for each in built.items()])

    heading("Implicit surfaces, every pixel of 640x480: millions of rays per second")
    columns = ["shape", "ms", f"{threads} threads", "1 thread", f"{threads} threads / 1", "unresolved rays"]
    rows = [trace_row(example, trace) for example, trace in zip(shapes, traces, strict=True)]
    table(columns, rows)
    print(f"\nCSG example, every pixel, {threads} threads: {rows[0][1]} ms; target: 60")
    wild = made(FORMULAS["Mandelbulb"]).instances[0].shape
    assert isinstance(wild, bob.Implicit)
    seconds = in_turn({"whole": lambda: bob.trace(build(wild), CAMERA, size=(242, 242))}, RIVAL_RUNS)["whole"]
    print(f"Mandelbulb of two steps (docs/gallery.md), 242x242: {spread(seconds, 1, 2)} s; target: 1")

    sparse_table("Implicit surfaces", sparse_scenes(), CAMERA)

    heading("Implicit surfaces and sphere tracing in numpy, one thread: millions of rays per second")
    ratios = [f"ours / numpy, {threads} threads", "1 thread"]
    columns = ["shape", "steepest slope", "numpy", *ratios, "misses", "adds", "depth error, radii"]
    table(columns, [numpy_row(*each) for each in zip(shapes, scenes, traces, strict=True)])

    equal = f"Implicit surfaces and a mesh of equal accuracy: gray within {EQUAL:.4f}"
    heading(f"{equal}, milliseconds, {threads} threads")
    columns = [
        "shape",
        "grid",
        "triangles",
        "gray error",
        "mesh, build and trace",
        "ours, build and trace",
        "mesh / ours",
    ]
    table(columns, [mesh_row(*each) for each in zip(shapes, scenes, traces, strict=True)])


if __name__ == "__main__":
    main()
