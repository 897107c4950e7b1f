"""Cost and quality of colour: tracing, completion and antialiasing compared with gray.

The errors are compared with linear interpolation of each component over the Delaunay triangles of the same pixels, and
of uniform ones.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from report import heading, in_turn, median_ratio, shape_files, spread, table
from sparse_rays import SIZE, on_one_thread

import bobrossnet as bob
from bobrossnet.color import luminance, to_srgb
from bobrossnet.learn.evaluation.evaluate import evaluate_scenes
from bobrossnet.learn.evaluation.scenes import Scenes, own_scenes, scenes_of_folder, with_colors
from bobrossnet.picture.order import ADAPTIVE
from bobrossnet.sdf import X, Y, Z, box, cylinder, sphere
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.tracing.pixels import tiled_pixels
from bobrossnet.tracing.scene import as_scene
from bobrossnet.tracing.trace import SceneTracer

RUNS = 21
FRACTIONS = (0.01, 0.02, 0.05, 0.1)
MODELS = ("default", "small", "filling")
LINEAR, UNIFORM = "delaunay-linear", "uniform"
UNIONS = (3, 20, 100, 300)  # shapes in one formula
OWN = 16  # procedural shapes in colour


def colored(mesh: bob.Mesh, **colors: object) -> bob.Mesh:
    return Mesh(mesh.vertices, mesh.triangles, mesh.normals, **colors)  # type: ignore[arg-type]


def stains(mesh: bob.Mesh) -> NDArray[np.float64]:
    """Return vertex colours: large stains with mostly soft edges."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    x, y, z = ((mesh.vertices - low) / (high - low).max() * 9).T
    waves = [np.sin(x + 2 * np.sin(y)), np.sin(y + 2 * np.sin(z) + 1), np.sin(z + 2 * np.sin(x) + 2)]
    return np.stack([0.5 + 0.5 * np.tanh(3 * wave) for wave in waves], axis=-1)


def texture() -> NDArray[np.uint8]:
    """Return 512x512 texels: tiles of random colours with borders."""
    rng = np.random.default_rng(0)
    tiles = rng.integers(30, 250, (16, 16, 3), np.uint8).repeat(32, axis=0).repeat(32, axis=1)
    inside = np.logical_and(*(np.indices((512, 512)) % 32 > 2))
    return np.where(inside[..., None], tiles, np.uint8(235))


def kinds(mesh: bob.Mesh) -> dict[str, bob.Scene]:
    """Return scenes of a shape in white, and with each of three kinds of colours."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    uv = ((mesh.vertices - low) / (high - low).max())[:, [0, 2]] * 2
    return {
        "white": bob.Scene(mesh),
        "material": bob.Scene(bob.Instance(mesh, material=bob.Material("#c33"))),
        "metal": bob.Scene(bob.Instance(mesh, material=bob.Material("#b87333", metallic=1, roughness=0.3))),
        "vertices": bob.Scene(colored(mesh, colors=stains(mesh))),
        "texture": bob.Scene(colored(mesh, uv=uv, texture=texture())),
    }


def parts() -> bob.Scene:
    """Return twenty-seven carved balls of different colours."""
    drill = cylinder(0.5)
    carved = (sphere(1) & box(1.5)) - (drill.orient(X) | drill.orient(Y) | drill.orient(Z))
    rng = np.random.default_rng(1)
    places = [(x, y, z) for x in (-2, 0, 2) for y in (-2, 0, 2) for z in (-2, 0, 2)]
    materials = [bob.Material(tuple(rng.uniform(0.05, 0.9, 3))) for _ in places]
    return bob.Scene([bob.Instance(carved, material=m).translate(p) for m, p in zip(materials, places, strict=True)])


def union(count: int, *, colored: bool) -> bob.Scene:
    """Return balls and boxes of different colours, or all white, as one formula."""
    rng = np.random.default_rng(1)
    shapes = []
    for number in range(count):
        place, size, color = rng.uniform(-3, 3, 3), rng.uniform(0.2, 0.6), tuple(rng.uniform(0.1, 0.9, 3))
        shape = (sphere(size) if number % 2 else box(1.5 * size)).translate(place)
        shapes.append(shape.color(color) if colored else shape)
    return bob.Scene(shapes[0].union(*shapes[1:]))


def tracing(scenes: dict[str, bob.Scene]) -> None:
    """Print the time of a traced pixel."""
    heading("Tracing in colour, every pixel of 512x512, one thread: microseconds of processor time a pixel")
    table(["the bunny", "microseconds", "/ white"], traced(scenes, dict.fromkeys(scenes, "white")))
    heading("The same of formulas of many shapes side by side")
    kinds = {f"{count} shapes{', colored' * colored}": union(count, colored=colored)
             for count in UNIONS for colored in (False, True)}  # fmt: skip
    white = {name: name.removesuffix(", colored") for name in kinds}
    table(["one formula of", "microseconds", "/ white"], traced(kinds, white))


def traced(scenes: dict[str, bob.Scene], white: dict[str, str]) -> list[list[str]]:
    """Return the time of a pixel in each scene, also relative to its white version."""
    pixels = tiled_pixels(SIZE)
    tracers = {name: SceneTracer(scene, bob.Camera(), SIZE) for name, scene in scenes.items()}
    runs = {name: on_one_thread(partial(tracer, pixels)) for name, tracer in tracers.items()}
    seconds = in_turn(runs, RUNS, clock=time.thread_time)
    return [
        [name, f"{1e6 * statistics.median(s) / len(pixels):.3f}", f"{median_ratio(s, seconds[white[name]]):.2f}"]
        for name, s in seconds.items()
    ]


def completing(scene: bob.Scene) -> None:
    """Print the time of completion."""
    heading("Completing 640x480 in colour, from 5 % of the pixels, all of bob.complete: milliseconds")
    rows, threads = [], bob.thread_count()
    for name, zoom in (("all of it", 1), ("close", 3)):
        part = bob.trace(scene, bob.Camera(zoom=zoom), size=(480, 640), fraction=0.05)
        shown = f"{name}, {np.mean(bob.complete(part) > 0):.0%} of the picture"
        for count in (1, threads):
            bob.set_thread_count(count)
            for model in ("default", "filling"):
                runs: dict[str, Callable[[], object]] = {
                    channel: partial(bob.complete, part, model, channel=channel) for channel in ("gray", "color")
                }
                seconds = in_turn(runs, 41, clock=time.thread_time if count == 1 else time.perf_counter)
                ratio = f"{median_ratio(seconds['color'], seconds['gray']):.2f}"
                rows.append([shown, model, str(count), *(spread(s, 1e3, 2) for s in seconds.values()), ratio])
    table(["seen", "model", "threads", "gray", "color", "color / gray"], rows)


def edges(scene: bob.Scene) -> None:
    """Print the time of antialiasing."""
    heading("Smooth edges, 640x480: milliseconds of bob.render, and SSIM against 16 rays in every pixel")
    many = bob.trace(scene, size=(4 * 480, 4 * 640)).color.reshape(480, 4, 640, 4, 3).mean(axis=(1, 3))
    runs: dict[str, Callable[[], object]] = {
        str(samples): partial(bob.render, scene, samples=samples) for samples in (1, 4, 16)
    }
    seconds = in_turn(runs, 7)
    rows = []
    for samples, each in seconds.items():
        shown = bob.render(scene, samples=int(samples)).color
        ssim = bob.ssim(luminance(to_srgb(shown)), luminance(to_srgb(many)))
        rows.append([samples, spread(each, 1e3), f"{median_ratio(each, seconds['1']):.2f}", f"{ssim:.4f}"])
    table(["maximum rays", "ms", "/ 1 ray", "SSIM"], rows)


def sets_of_scenes(scenes: dict[str, bob.Scene]) -> dict[str, Scenes]:
    """Return the scenes for errors of completed colours: single scenes, procedural shapes, and files with colours."""
    shown = {name: scenes[name] for name in ("material", "vertices", "texture")} | {"27 parts": parts()}
    sets: dict[str, Scenes] = {name: {name: partial(as_scene, scene)} for name, scene in shown.items()}
    sets[f"{OWN} own shapes"] = own_scenes(OWN, colored=True)
    real = {
        f"{folder.name}/{name}": scene
        for folder in shape_files("loader_originals", "textured")
        for name, scene in with_colors(scenes_of_folder(folder)).items()
    }
    return sets | {f"{len(real)} files": real}


def errors(sets: dict[str, Scenes]) -> None:
    """Print the errors of completed colours."""
    heading("Completed colours at 256x256: mean FLIP of sRGB, less is better, and SSIM of the luminance")
    rows = []
    for name, scenes in sets.items():
        views = 3 if len(scenes) == 1 else 1
        measure = partial(evaluate_scenes, scenes, fractions=FRACTIONS, views=views, channel="color", repainting=False)
        adaptive = measure(MODELS, orders=[ADAPTIVE], fillings=[LINEAR])
        result = adaptive.beside(measure([], orders=[UNIFORM], fillings=[LINEAR]))
        for run in result.scores:
            scores = zip(result.mean(run, "flip"), result.mean(run, "ssim"), strict=True)
            cells = ["{:.4f}, {:.4f}".format(*each) for each in scores]
            rows.append([name, f"{run[0].removesuffix(' kept')}, {run[1]}", *cells])
    table(["scene", "method, order", *(f"{fraction:.0%}" for fraction in FRACTIONS)], rows)


def main() -> None:
    (bunny,) = shape_files("scans/stanford_bunny.ply")
    mesh = bob.load_mesh(bunny)
    scenes = kinds(mesh)
    tracing(scenes)
    completing(scenes["texture"])
    edges(scenes["texture"])
    errors(sets_of_scenes(scenes))


if __name__ == "__main__":
    main()
