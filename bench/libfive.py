"""Implicit surfaces, traced directly, beside libfive's heightmaps: intervals rule out blocks of voxels, and what is left is
evaluated at each, so that depths are those of voxels and thin sheets may be stepped over.

LIBFIVE names the folder of a libfive that is there, with `include/` and its library; without it, this is skipped. Both
run on one thread and give depths and normals; in turns.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from implicit import csg, gyroid, vm_shape
from numpy.typing import NDArray
from report import heading, in_turn, median_ratio, spread, table

import bobrossnet as bob
from bobrossnet.tracing.trace import SceneTracer, tiled_pixels

SIZE = 512
RUNS = 7
CAMERAS = {"straight": bob.Camera(azimuth=270, elevation=90), "oblique": bob.Camera()}
FLAGS = ("-std=c++17", "-O3", "-march=native", "-DNDEBUG", "-DEIGEN_NO_DEBUG", "-I/usr/include/eigen3")

# Of the core's operations, in its order (core/formula/expression.h).
NAMES = (
    "const var-x var-y var-z neg abs square sqrt sin cos tan asin acos atan exp ln floor ceil round power "
    "add sub mul div min max hypot atan2 mod select"
).split()


def main() -> None:
    home = os.environ.get("LIBFIVE")
    if not home:
        print("skipped libfive.py: LIBFIVE does not name the folder of a libfive")
        return
    shapes = {name: vm_shape(name) for name in ("bear", "prospero", "tanglecube", "colonnade")}
    shapes |= {"gyroid": bob.implicit(gyroid), "CSG": bob.implicit(csg)}
    bob.set_thread_count(1)
    with tempfile.TemporaryDirectory() as folder:
        program = build(Path(home), Path(folder))
        rows = [
            row(name, view, bob.Scene(shape), camera, program)
            for name, shape in shapes.items()
            if shape is not None
            for view, camera in CAMERAS.items()
        ]
    heading(f"Implicit surfaces beside libfive's heightmaps, {SIZE}x{SIZE}, one thread: milliseconds")
    table(["shape", "seen", "ours", "libfive", "ours / libfive", "pixels that differ", "unresolved rays"], rows)


def build(home: Path, folder: Path) -> Path:
    """Compile the program beside this script against that libfive."""
    program = folder / "libfive"
    library = next(home.rglob("libfive.so"))
    source = Path(__file__).with_suffix(".cpp")
    link = [str(library), f"-Wl,-rpath,{library.parent}", "-rdynamic"]
    subprocess.run(["c++", *FLAGS, f"-I{home / 'include'}", str(source), *link, "-o", str(program)], check=True)
    return program


def row(name: str, view: str, scene: bob.Scene, camera: bob.Camera, program: Path) -> list[str]:
    (instance,) = scene.instances
    assert isinstance(instance.shape, bob.Implicit)
    trace, pixels = SceneTracer(scene, camera, (SIZE, SIZE)), tiled_pixels((SIZE, SIZE))
    formula = program.with_name(f"{name}.vm")
    formula.write_text("\n".join(lines_of(instance.shape, scene, camera)) + "\n")
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen([program, str(SIZE), formula], **pipes) as rival:  # type: ignore[call-overload]
        last = ""

        def theirs() -> None:
            nonlocal last
            print(file=rival.stdin, flush=True)
            last = rival.stdout.readline()

        seconds = in_turn({"ours": lambda: trace(pixels), "libfive": theirs}, RUNS, clock=time.perf_counter)
        rival.stdin.close()
    full = bob.trace(scene, camera, size=(SIZE, SIZE))
    hits = (full.depth > 0).sum()
    return [
        name,
        view,
        spread(seconds["ours"], 1e3),
        spread(seconds["libfive"], 1e3),
        f"{median_ratio(seconds['ours'], seconds['libfive']):.2f}",
        f"{abs(int(last) - int(hits)) / hits:.2%}",
        str(instance.shape.unresolved_rays),
    ]


def lines_of(shape: bob.Implicit, scene: bob.Scene, camera: bob.Camera) -> Iterator[str]:
    """A shape as a .vm file: turned so that the camera looks along -z, its bounding sphere within the cube -1..1."""
    numbers = (f"const {value:.9g}" for value in (*scene.center, scene.radius))
    yield from (f"{name} {number}" for name, number in zip(("cx", "cy", "cz", "r"), numbers, strict=True))
    for axis in "xyz":
        yield f"v{axis} var-{axis}"
    for i, axis in enumerate("xyz"):  # p = center + radius * (the camera's axes as columns) @ (x, y, z)
        for j, across in enumerate("xyz"):
            yield f"m{axis}{across} const {axes_of(camera)[i, j]:.9g}"
            yield f"t{axis}{across} mul m{axis}{across} v{across}"
        yield f"s{axis} add t{axis}x t{axis}y"
        yield f"u{axis} add s{axis} t{axis}z"
        yield f"w{axis} mul u{axis} r"
        yield f"p{axis} add w{axis} c{axis}"
    expression = shape.expression
    for i, (op, operands, value) in enumerate(
        zip(expression.ops, expression.operands, expression.values, strict=True)
    ):
        name = NAMES[op]
        a, b, _ = (f"n{operand}" for operand in operands)
        if name == "const":
            yield f"n{i} const {value:.9g}"
        elif name.startswith("var"):
            yield f"n{i} max p{name[-1]} p{name[-1]}"  # another name for it
        elif name == "hypot":
            yield from (f"a{i} square {a}", f"b{i} square {b}", f"c{i} add a{i} b{i}", f"n{i} sqrt c{i}")
        else:
            yield f"n{i} {name} {a} {b}" if name in NAMES[20:] else f"n{i} {name} {a}"
    if shape.bounds is not None:
        yield from within(shape.bounds, f"n{len(expression) - 1}")


def within(bounds: NDArray[np.float64], formula: str) -> Iterator[str]:
    """The formula cut by a box."""
    for axis, (low, high) in zip("xyz", bounds.T, strict=True):
        yield f"l{axis} const {low:.9g}"
        yield f"h{axis} const {high:.9g}"
        yield f"below{axis} sub l{axis} p{axis}"
        yield f"above{axis} sub p{axis} h{axis}"
        yield f"out{axis} max below{axis} above{axis}"
        yield f"cut{axis} max {formula} out{axis}"
        formula = f"cut{axis}"


def axes_of(camera: bob.Camera) -> NDArray[np.float64]:
    """The camera's axes as columns: to the right and up in the picture, and towards the camera."""
    pixels = np.array(((1, 1), (1, 2), (0, 1)), np.int32)
    _, origin, direction = camera.core().rays(3, 3, pixels)
    back = -direction[0].astype(np.float64)
    across = (origin[1:] - origin[0]).astype(np.float64)
    across -= (across @ back)[:, None] * back
    return np.column_stack([*(across / np.linalg.norm(across, axis=1, keepdims=True)), back])


if __name__ == "__main__":
    main()
