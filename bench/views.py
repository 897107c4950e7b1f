"""Views with colour, depth and poses: pictures a second, compared with Blender's Cycles and with pyrender.

Rivals run in this Python, or in the Pythons that BOBROSSNET_BENCH_BPY and BOBROSSNET_BENCH_PYRENDER name: Blender's
wheel needs a certain version.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from report import heading, shape_files, spread, table

import bobrossnet as bob
from bobrossnet.pictures.views import CHANNELS as ALL

ROUNDS = 3
VIEWS = 12
SIZE = (480, 640)
CHANNELS = ("color", "depth")

RIVALS = {
    "bpy": "Blender, Cycles, 4 samples, to files",
    "pyrender": "pyrender, OpenGL by EGL, in memory",
}


def rivals() -> dict[str, str]:
    """Return the Python of each rival that is installed; name the others."""
    found = {}
    for name in RIVALS:
        python = os.environ.get(f"BOBROSSNET_BENCH_{name.upper()}", sys.executable)
        if subprocess.run([python, "-c", f"import {name}"], capture_output=True, check=False).returncode:
            print(f"without a rival: {name} is not installed", file=sys.stderr)
        else:
            found[name] = python
    return found


def depth_of(name: str, folder: Path) -> np.ndarray:
    """Return a rival's depth of the first view; background is 0 or 1e10."""
    if name == "pyrender":
        with np.load(folder / "first.npz") as held:
            return np.asarray(held["depth"])
    import OpenEXR

    with OpenEXR.File(str(folder / "00000.exr"), separate_channels=True) as file:
        (depth,) = (c for part in file.parts for name, c in part.channels.items() if name.endswith(".Depth.Z"))
        return np.asarray(depth.pixels)


def run(name: str, python: str, file: Path, folder: Path) -> dict[str, float]:
    """Return a rival's seconds for all views."""
    command = [python, str(Path(__file__).with_name("rival_views.py")), name, str(file), str(folder)]
    done = subprocess.run(command, capture_output=True, check=True, text=True)
    told: dict[str, float] = json.loads(done.stdout)
    return told


def ours(scene: bob.Scene, channels: tuple[str, ...]) -> dict[str, float]:
    """Return our seconds for all views."""
    wall, processor = time.perf_counter(), time.process_time()
    for _ in bob.views(scene, VIEWS, channels, size=SIZE):
        pass
    return {"seconds": time.perf_counter() - wall, "processor": time.process_time() - processor}


def main() -> None:
    """Print pictures a second of each, in turns, and how far the depths of the first view differ."""
    (file,) = shape_files("scans/stanford_bunny.ply")
    mesh = bob.load_mesh(file)
    scene = bob.Scene(mesh)
    vertices = (mesh.vertices - scene.center) / scene.radius  # the rivals' near planes suit this size
    scene = bob.Scene(bob.Mesh(vertices, mesh.triangles))
    views = list(bob.views(scene, VIEWS, CHANNELS, size=SIZE))
    with tempfile.TemporaryDirectory() as made:
        data = Path(made) / "views.npz"
        np.savez(
            data,
            vertices=vertices,
            triangles=mesh.triangles,
            camera_to_world=np.array([view.pose.camera_to_world for view in views]),
            fov=2 * np.arctan(SIZE[0] / 2 / views[0].pose.intrinsics[1, 1]),
            height=SIZE[0],
            width=SIZE[1],
        )
        found = rivals()
        times: dict[str, list[dict[str, float]]] = {}
        for _ in range(ROUNDS):
            times.setdefault("ours, colour and depth", []).append(ours(scene, CHANNELS))
            times.setdefault("ours, with normals and instances", []).append(ours(scene, ALL))
            for name, python in found.items():
                times.setdefault(name, []).append(run(name, python, data, Path(made)))
        heading(f"Views: {VIEWS} of {SIZE[1]}x{SIZE[0]} of {len(mesh.triangles):,} triangles, colour and depth")
        rows = []
        for name, taken in times.items():
            difference = "–"
            if name in found:
                theirs, view = depth_of(name, Path(made)), views[0]
                assert view.depth is not None
                both = view.mask & (theirs > 0) & (theirs < 1e9)
                share = both.sum() / view.mask.sum()
                difference = f"{np.median(np.abs(theirs - view.depth)[both]):.1e}, {100 * share:.1f} % of the pixels"
            rows.append(
                [
                    RIVALS.get(name, name),
                    spread([VIEWS / each["seconds"] for each in taken]),
                    spread([1000 * each["processor"] / VIEWS for each in taken], digits=0),
                    difference,
                ]
            )
        table(["", "pictures a second", "processor ms a picture", "depth differs, in radii"], rows)


if __name__ == "__main__":
    main()
