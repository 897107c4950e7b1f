"""Views with colour and depth by another renderer, in a Python that has it: `python rival_views.py NAME VIEWS.npz OUT`.

Prints one JSON object: seconds of all views after a first one, by the clock and of the processor. This file imports
nothing of the project, which that Python may lack.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

Views = Mapping[str, Any]
"""Vertices, triangles, camera_to_world (n, 4, 4) in OpenGL's convention, fov in radians, height and width."""


def pyrender(views: Views, out: Path) -> Callable[[int], None]:
    """Render by OpenGL in memory: colour with 4 samples, and depth."""
    os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
    import pyrender
    import trimesh

    height, width = int(views["height"]), int(views["width"])
    scene = pyrender.Scene(ambient_light=(0.1, 0.1, 0.1), bg_color=(0, 0, 0, 0))
    mesh = trimesh.Trimesh(views["vertices"], views["triangles"], process=False)
    scene.add(pyrender.Mesh.from_trimesh(mesh, smooth=True))
    camera = scene.add(pyrender.PerspectiveCamera(float(views["fov"]), znear=0.05, zfar=100))
    light = scene.add(pyrender.DirectionalLight(intensity=3))
    renderer = pyrender.OffscreenRenderer(width, height)

    def render(number: int) -> None:
        pose = views["camera_to_world"][number]
        scene.set_pose(camera, pose)
        scene.set_pose(light, pose)
        color, depth = renderer.render(scene)
        if number == 0:
            np.savez(out / "first.npz", color=color, depth=depth)

    return render


def bpy(views: Views, out: Path) -> Callable[[int], None]:
    """Render by Cycles on the processor, 4 samples a pixel, no bounces: one EXR file with colour and depth a view."""
    import bpy
    from mathutils import Matrix

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata(views["vertices"].tolist(), [], views["triangles"].tolist())
    mesh.shade_smooth()
    scene.collection.objects.link(bpy.data.objects.new("mesh", mesh))
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.sensor_fit = "VERTICAL"
    camera.data.angle = float(views["fov"])
    camera.data.clip_start, camera.data.clip_end = 0.05, 100
    light = bpy.data.objects.new("light", bpy.data.lights.new("light", "SUN"))
    for each in (camera, light):
        scene.collection.objects.link(each)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", 4, False, False
    cycles.max_bounces = 0
    scene.render.use_persistent_data = True  # keeps the BVH from view to view
    scene.render.resolution_x, scene.render.resolution_y = int(views["width"]), int(views["height"])
    scene.render.film_transparent = True
    scene.view_layers[0].use_pass_z = True
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.exr_codec = "NONE"

    def render(number: int) -> None:
        pose = Matrix(views["camera_to_world"][number].tolist())
        camera.matrix_world = light.matrix_world = pose
        scene.render.filepath = str(out / f"{number:05}.exr")
        bpy.ops.render.render(write_still=True)

    return render


def main() -> None:
    """Render the first view twice, and measure all of them."""
    name, file, out = sys.argv[1], sys.argv[2], Path(sys.argv[3])
    with np.load(file) as held:
        views = dict(held)
    told = os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # the libraries' own output
    render = {"pyrender": pyrender, "bpy": bpy}[name](views, out)
    render(0)
    wall, processor = time.perf_counter(), time.process_time()
    for number in range(len(views["camera_to_world"])):
        render(number)
    seconds = {"seconds": time.perf_counter() - wall, "processor": time.process_time() - processor}
    os.write(told, json.dumps(seconds).encode())
    os._exit(0)  # some libraries crash when they are unloaded


if __name__ == "__main__":
    main()
