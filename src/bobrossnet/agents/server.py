"""Tools of the Model Context Protocol: an agent looks at shapes, measures and compares them, in one loop."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import wraps
from typing import Any

import numpy as np
from mcp.server.mcpserver import Image, MCPServer
from mcp.server.mcpserver.exceptions import ToolError

from bobrossnet import __version__
from bobrossnet.agents.measures import compared, described, rounded, rounded_all, told_pick, told_volume
from bobrossnet.agents.workspace import MAX_SIDE, Look, Workspace
from bobrossnet.measuring.measure import measure as measure_picks
from bobrossnet.measuring.picking import Pick
from bobrossnet.measuring.volumes import closed_volume
from bobrossnet.picture.camera import VIEWS, Camera
from bobrossnet.picture.files import before, png, sheet
from bobrossnet.picture.order import check_size
from bobrossnet.pictures.fitting import fitted
from bobrossnet.pictures.rendering import render
from bobrossnet.pictures.sheets import LAYOUT
from bobrossnet.pictures.sheets import sheet as drawn_sheet
from bobrossnet.shapes.mesh import check_mesh_path
from bobrossnet.support.errors import InputError, check_choice
from bobrossnet.tracing.scene import Scene

INSTRUCTIONS = """Exact pictures and measures of 3D shapes: STEP, IGES, 3dm, STL, PLY, OBJ, glTF, 3MF and others, or the
text of a script in the modelling language (sphere(1) & box(1.5), as in fogleman/sdf). Give `file`, a path below the
allowed folders, or `script`. x is right, y is back and z is up from the front; lengths are in the file's unit. `look`
with a single view remembers it, so that `pick` and `measure` take its pixels."""


def server(folders: Sequence[str | os.PathLike[str]]) -> MCPServer:
    """A server for files below some folders; `run` starts it.

    Parameters
    ----------
    folders : sequence of paths
        Relative paths are relative to the first.

    Raises
    ------
    InputError
        If one of them is no folder.
    """
    space = Workspace(folders)
    made = MCPServer("bobrossnet", instructions=INSTRUCTIONS, version=__version__, log_level="ERROR")

    def tool(function: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(function)
        def told(*values: Any, **named: Any) -> Any:
            try:
                return function(*values, **named)
            except InputError as error:
                raise ToolError(str(error)) from None
            except MemoryError:
                raise ToolError("not enough memory for a picture or a shape of this size") from None

        return made.tool(structured_output=False)(told)

    @tool
    def look(
        file: str | None = None,
        script: str | None = None,
        views: list[str] = [*LAYOUT],  # noqa: B006  pydantic copies it
        size: str = "1024x768",
        up: str = "z",
        unit: str = "",
        section: list[str] = [],  # noqa: B006
        highlight: list[str] = [],  # noqa: B006
        edges: bool = True,
    ) -> Image:
        """Draw a shape. Several views make a sheet to one scale with dimensions; a single one fills the picture, and
        its pixels can be picked. Views: front, back, right, left, top, bottom, isometric. Sections such as x=0 or z>3
        cut the shape open; parts to highlight have the names that describe lists."""
        scene, _ = space.scene(file, script, up)
        if highlight:
            scene = scene.highlight(*highlight)
        scene = scene.sectioned(section or None)
        height, width = check_size(size)
        if max(height, width) > MAX_SIDE:
            raise InputError(f"size: expected at most {MAX_SIDE} pixels a side, got {width}x{height}")
        if len(views) != 1:
            return _image(drawn_sheet(scene, views, size=(height, width), unit=unit, edges=edges).rgba)
        camera = Camera.named(check_choice("views", views[0], tuple(VIEWS)))
        camera = fitted(scene.sectioned(None), camera, size=(height, width))
        picture = render(scene, camera, size=(height, width), background="#ffffff", edges=edges)
        space.last = Look(scene, camera, (height, width))
        return _image(picture.rgba)

    @tool
    def describe(file: str | None = None, script: str | None = None, up: str = "z") -> dict[str, Any]:
        """Size, bounds, parts, whether meshes are closed or inside out, volumes, and warnings of the reader."""
        return described(*space.scene(file, script, up))

    @tool
    def pick(row: int, column: int) -> dict[str, Any]:
        """The part, its face or triangle, the point and the normal at a pixel of the last picture of a single view."""
        found = _last(space).pick(row, column)
        return {"hit": None if found is None else told_pick(found)}

    @tool
    def measure(first: list[int], second: list[int]) -> dict[str, Any]:
        """Distance and offset between the points at two pixels, [row, column], of the last picture of a single view,
        and the angle between their normals in degrees."""
        a, b = _hit(space, "first", first), _hit(space, "second", second)
        between = measure_picks(a, b)
        return {
            "distance": rounded(between.distance),
            "offset": rounded_all(between.offset),
            "angle": round(between.angle, 2),
            "first": told_pick(a),
            "second": told_pick(b),
        }

    @tool
    def compare(first: str, second: str, view: str = "isometric", size: str = "1024x512") -> list[Any]:
        """Draw two files side by side with one camera, and tell how silhouettes and depths differ from all sides."""
        scenes = [space.scene(file, None)[0] for file in (first, second)]
        named = Camera.named(check_choice("view", view, tuple(VIEWS)))
        height, width = check_size(size)
        half = (height, max(width // 2, 1))
        camera = fitted(scenes[0], named, size=half)
        cameras = [_same_view(camera, scenes[0], scene) for scene in scenes]
        drawn = [
            before("white", render(scene, own, size=half).rgba) for scene, own in zip(scenes, cameras, strict=True)
        ]
        picture = sheet([(drawn[0], first), (drawn[1], second)], 2)
        return [_image(picture), compared(*scenes)]

    @tool
    def mesh(out: str, file: str | None = None, script: str | None = None, step: float | None = None) -> dict[str, Any]:
        """Write a shape as triangles, .stl, .ply, .obj or .glb, below the allowed folders; `step` is their side."""
        scene, warnings = space.scene(file, script)
        path = check_mesh_path(space.path(out))
        triangles = scene.mesh(step)
        triangles.save(path)
        return {
            "file": str(path),
            "triangles": len(triangles.triangles),
            **told_volume(closed_volume(triangles.vertices, triangles.triangles)),
            "warnings": warnings,
        }

    return made


def _last(space: Workspace) -> Look:
    if space.last is None:
        raise InputError("pick: expected a picture of a single view before; call look with one view")
    return space.last


def _hit(space: Workspace, name: str, pixel: list[int]) -> Pick:
    """The surface at a pixel, [row, column], of the last picture; `name` is the argument's."""
    look = _last(space)
    if len(pixel) != 2:
        raise InputError(f"{name}: expected [row, column], got {pixel!r}")
    hit = look.pick(*pixel)
    if hit is None:
        raise InputError(f"{name}: expected a pixel with a surface, got background")
    return hit


def _same_view(camera: Camera, reference: Scene, scene: Scene) -> Camera:
    """The camera by which a scene has the scale and place that the reference has by the given one."""
    right, up, *_ = camera.core(reference.center, reference.radius).pose(1, 1)
    across = np.array([right, up])
    offset = across @ (reference.center - scene.center) + reference.radius * np.asarray(camera.pan)
    pan = offset / scene.radius
    return replace(camera, zoom=camera.zoom * scene.radius / reference.radius, pan=(float(pan[0]), float(pan[1])))


def _image(rgba: Any) -> Image:
    return Image(data=png(rgba[..., :3]), format="png")
