"""Direct tracing of implicit surfaces compared with libfive's heightmaps, on one thread.

libfive culls blocks of voxels by interval arithmetic and evaluates the formula at each remaining voxel: depths are
rounded to voxels, and thinner details may be missed. Both give depths and normals. LIBFIVE names a folder of libfive
with `include/` and its library; without it, this is skipped.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from implicit import csg, gyroid, vm_shape
from numpy.typing import NDArray
from report import heading, in_turn, median_ratio, spread, table

import bobrossnet as bob
from bobrossnet.tracing.pixels import tiled_pixels
from bobrossnet.tracing.trace import SceneTracer

SIZE = 512
RUNS = 7
CAMERAS = {"straight down": bob.Camera(azimuth=270, elevation=90), "oblique": bob.Camera()}
FLAGS = ("-std=c++17", "-O3", "-march=native", "-DNDEBUG", "-DEIGEN_NO_DEBUG", "-I/usr/include/eigen3", "-rdynamic")

# fmt: off
NAMES = (  # in .vm files, for the core's operations in their order (core/formula/expression.h)
    "const", "var-x", "var-y", "var-z",
    "neg", "abs", "square", "sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "exp", "ln",
    "floor", "ceil", "round", "power",
    "add", "sub", "mul", "div", "min", "max", "hypot", "atan2", "mod", "select",
)
# fmt: on
UNARY = NAMES[4:20]


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
    heading(f"Implicit surfaces and libfive's heightmaps, {SIZE}x{SIZE}, one thread: milliseconds")
    table(["shape", "seen", "ours", "libfive", "ours / libfive", "hits that differ", "unresolved rays"], rows)


def build(home: Path, folder: Path) -> Path:
    """Compile the program next to this script against that libfive."""
    program, source = folder / "libfive", Path(__file__).with_suffix(".cpp")
    library = next(home.rglob("libfive.so"))
    link = [str(library), f"-Wl,-rpath,{library.parent}"]
    subprocess.run(["c++", *FLAGS, f"-I{home / 'include'}", str(source), *link, "-o", str(program)], check=True)
    return program


def row(name: str, view: str, scene: bob.Scene, camera: bob.Camera, program: Path) -> list[str]:
    (instance,) = scene.instances
    assert isinstance(instance.shape, bob.Implicit)
    trace, pixels = SceneTracer(scene, camera, (SIZE, SIZE)), tiled_pixels((SIZE, SIZE))
    formula = program.with_name(f"{name}.vm")
    formula.write_text("\n".join(lines_of(instance.shape, scene, camera)) + "\n", "utf-8")
    command = [str(program), str(SIZE), str(formula)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as rival:
        assert rival.stdin
        assert rival.stdout

        def theirs() -> int:
            print(file=rival.stdin, flush=True)
            return int(rival.stdout.readline())  # type: ignore[union-attr]

        seconds = in_turn({"ours": lambda: trace(pixels), "libfive": theirs}, RUNS)
        hits, found = np.count_nonzero(trace(pixels).hit), theirs()
        before = instance.shape.unresolved_rays
        trace(pixels)
        rival.stdin.close()
    return [
        name,
        view,
        spread(seconds["ours"], 1e3),
        spread(seconds["libfive"], 1e3),
        f"{median_ratio(seconds['ours'], seconds['libfive']):.2f}",
        f"{abs(found - hits) / hits:.2%}",
        f"{instance.shape.unresolved_rays - before:,}",
    ]


def lines_of(shape: bob.Implicit, scene: bob.Scene, camera: bob.Camera) -> Iterator[str]:
    """Yield a shape as a .vm file, rotated for a camera along -z, with its bounding sphere in the cube -1..1."""
    for axis, center in zip("xyz", scene.center, strict=True):
        yield f"v{axis} var-{axis}"
        yield f"c{axis} const {center:.9g}"
    yield f"r const {scene.radius:.9g}"
    for axis, turned in zip("xyz", axes_of(camera), strict=True):  # p = center + radius * turned @ (x, y, z)
        for across, share in zip("xyz", turned, strict=True):
            yield f"m{axis}{across} const {share:.9g}"
            yield f"t{axis}{across} mul m{axis}{across} v{across}"
        yield f"s{axis} add t{axis}x t{axis}y"
        yield f"u{axis} add s{axis} t{axis}z"
        yield f"w{axis} mul u{axis} r"
        yield f"p{axis} add w{axis} c{axis}"
    nodes = shape.expression
    for i, (op, operands, value) in enumerate(zip(nodes.ops, nodes.operands, nodes.values, strict=True)):
        name = NAMES[op]
        a, b, _ = (f"n{operand}" for operand in operands)
        if name == "const":
            yield f"n{i} const {value:.9g}"
        elif name.startswith("var"):
            yield f"n{i} max p{name[-1]} p{name[-1]}"  # a second name for it
        elif name == "hypot":
            yield from (f"a{i} square {a}", f"b{i} square {b}", f"c{i} add a{i} b{i}", f"n{i} sqrt c{i}")
        else:
            yield f"n{i} {name} {a}" if name in UNARY else f"n{i} {name} {a} {b}"
    if shape.bounds is not None:
        yield from within(shape.bounds, f"n{len(nodes) - 1}")


def within(bounds: NDArray[np.float64], formula: str) -> Iterator[str]:
    """Yield the formula cut by a box."""
    for axis, (low, high) in zip("xyz", bounds.T, strict=True):
        yield f"l{axis} const {low:.9g}"
        yield f"h{axis} const {high:.9g}"
        yield f"below{axis} sub l{axis} p{axis}"
        yield f"above{axis} sub p{axis} h{axis}"
        yield f"out{axis} max below{axis} above{axis}"
        yield f"cut{axis} max {formula} out{axis}"
        formula = f"cut{axis}"


def axes_of(camera: bob.Camera) -> NDArray[np.float64]:
    """Return the camera's axes as columns: to the right and up in the picture, and towards the camera."""
    _, origin, direction = camera.core((0, 0, 0), 1).rays(3, 3, np.array(((1, 1), (1, 2), (0, 1)), np.int32))
    back = -direction[0].astype(np.float64)
    across = (origin[1:] - origin[0]).astype(np.float64)
    across -= (across @ back)[:, None] * back
    axes = np.column_stack([*(across / np.linalg.norm(across, axis=1, keepdims=True)), back])
    return np.where(np.abs(axes) < 1e-6, 0, axes)  # exact for views along an axis, which libfive simplifies


if __name__ == "__main__":
    main()
