"""Tools of the Model Context Protocol: an agent looks at shapes, measures and compares them, in one loop."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import wraps
from typing import Any

import numpy as np
from mcp.server.mcpserver import Image, MCPServer
from mcp.server.mcpserver.exceptions import ToolError

from bobrossnet import __version__
from bobrossnet.agents.measures import (
    compared,
    described,
    differences,
    rounded,
    rounded_all,
    told_face,
    told_pick,
    told_volume,
)
from bobrossnet.agents.workspace import MAX_SIDE, Look, LookedAt, Workspace, highlighted
from bobrossnet.measuring.measure import measure as measure_picks
from bobrossnet.measuring.picking import Pick
from bobrossnet.measuring.volumes import closed_volume
from bobrossnet.picture.camera import VIEWS, Camera
from bobrossnet.picture.files import before, png, sheet
from bobrossnet.picture.order import Size, check_size
from bobrossnet.pictures.fitting import fitted
from bobrossnet.pictures.rendering import render
from bobrossnet.pictures.sheets import LAYOUT, check_views, laid_out
from bobrossnet.shapes.mesh import check_mesh_path
from bobrossnet.support.errors import InputError, check_choice
from bobrossnet.support.units import check_unit
from bobrossnet.tracing.scene import Scene
from bobrossnet.tracing.section import check_sections

INSTRUCTIONS = """Exact pictures and measures of 3D shapes: STEP, IGES, 3dm, STL, PLY, OBJ, glTF, 3MF and others, or the
text of a script in the modelling language (sphere(1) & box(1.5), as in fogleman/sdf). Give `file`, a path below the
allowed folders, or `script`. x is right, y is back and z is up from the front; lengths are in the file's unit. `pick`
and `measure` take pixels of the last picture of `look`."""


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
                answer = function(*values, **named)
            except InputError as error:
                raise ToolError(str(error)) from None
            except MemoryError:
                raise ToolError("not enough memory for a picture or a shape of this size") from None
            if isinstance(answer, list):
                return [_short(each) for each in answer]
            return _short(answer)

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
        """Draw a shape. Several views make a sheet to one scale with dimensions; a single one fills the picture. Views:
        front, back, right, left, top, bottom, isometric. Sections such as x=0 or z>3 cut a single view open; on a sheet
        each of them adds a view of the cut. Lengths of a sheet are converted to the unit. Highlight parts by the names
        that describe lists, and faces by the names that pick returns. Pixels of the picture can be picked and
        measured."""
        height, width = _check_size(size)  # all are checked before the file is read
        check_views(views)
        check_unit("unit", unit or None)
        check_sections(section)
        plain, _ = space.scene(file, script, up)
        scene = highlighted(plain, highlight)
        if len(views) != 1:
            drawn = laid_out(scene, views, (height, width), unit or None, section)
            of_pick = laid_out(plain, views, (height, width), unit or None, section) if highlight else drawn
            seen = [LookedAt(view.scene, view.camera, view.left, view.top, view.size) for view in of_pick.views]
            picture = drawn.drawn(file or "script", edges)
        else:
            camera = Camera.named(views[0])
            camera = fitted(plain, camera, size=(height, width))
            scene, plain = (each.sectioned(section or None) for each in (scene, plain))
            picture = render(scene, camera, size=(height, width), background="#ffffff", edges=edges)
            seen = [LookedAt(plain, camera, 0, 0, (height, width))]
        space.last = Look((height, width), tuple(seen))
        return _image(picture.rgba)

    @tool
    def describe(file: str | None = None, script: str | None = None, up: str = "z") -> dict[str, Any]:
        """Kinds, unit, size, counts, and for each part bounds, area, volume, whether it is closed or inside out; pairs
        of parts that overlap; warnings of the reader. All is of the uncut shape: sections of look change none of it.
        Faces are counted as pick numbers them: a face around a whole cylinder is read as two."""
        return described(*space.scene(file, script, up))

    @tool
    def pick(row: int, column: int, snap: float = 0) -> dict[str, Any]:
        """The part, its face or triangle, the point and the normal at a pixel of the last picture of look. With snap,
        the point of the nearest visible corner, middle of an edge, centre of a circle or edge within so many pixels."""
        found = _last(space).pick(row, column, snap)
        return {"hit": None if found is None else told_pick(found)}

    @tool
    def measure(first: list[int], second: list[int] | None = None, snap: float = 0) -> dict[str, Any]:
        """Distance and offset between the points at two pixels, [row, column], of the last picture of look, the angle
        between their normals in degrees, and the gap of parallel faces or axes. With snap, points are those of pick:
        the centres of two holes, for instance. Without a second pixel: the kind of the face at the first, its radius,
        area, and the thickness of the wall."""
        a = _hit(space, "first", first, snap)
        if second is None:
            return told_face(measure_picks(a)) | {"first": told_pick(a)}
        b = _hit(space, "second", second, snap)
        if b.scene is not a.scene:  # of another view of the sheet, with or without a section
            b = replace(b, scene=a.scene)
        between = measure_picks(a, b)
        return {
            "distance": rounded(between.distance),
            "offset": rounded_all(between.offset),
            "angle": round(between.angle, 2),
            "gap": None if between.gap is None else rounded(between.gap),
            "unit": between.unit,
            "first": told_pick(a),
            "second": told_pick(b),
        }

    @tool
    def compare(
        first: str,
        second: str | None = None,
        script: str | None = None,
        view: str = "isometric",
        size: str = "1200x450",
    ) -> list[Any]:
        """Draw a file and another, or a script, side by side with one camera, and next to them their differences: red
        where only the first has a surface, blue where only the second, orange where depths differ. Also tells how
        silhouettes and depths differ from all sides."""
        named = Camera.named(check_choice("view", view, tuple(VIEWS)))
        height, width = _check_size(size)
        one, other = space.scene(first, None)[0], space.scene(second, script)[0]
        if one.unit and other.unit:
            other = other.converted(one.unit)
        third, both = (height, max(width // 3, 1)), Scene([one, other])
        camera = fitted(both, named, size=third)
        drawn = [
            before("white", render(scene, _same_view(camera, both, scene), size=third).rgba) for scene in (one, other)
        ]
        drawn.append(differences(one, other, camera, both, third))
        picture = sheet([*zip(drawn, (first, second or "script", "differences"), strict=True)], 3)
        return [_image(picture), compared(one, other)]

    @tool
    def mesh(out: str, file: str | None = None, script: str | None = None, step: float | None = None) -> dict[str, Any]:
        """Write a shape as triangles, .stl, .ply, .obj or .glb, below the allowed folders; `step` is their side."""
        path = check_mesh_path(space.path(out))
        scene, warnings = space.scene(file, script)
        triangles = scene.mesh(step)
        triangles.save(path)
        return {
            "file": str(path),
            "triangles": len(triangles.triangles),
            **told_volume(closed_volume(triangles.vertices, triangles.triangles)),
            "warnings": warnings,
        }

    return made


def _check_size(size: str) -> Size:
    height, width = check_size(size)
    if max(height, width) > MAX_SIDE:
        raise InputError(f"size: expected at most {MAX_SIDE} pixels a side, got {width}x{height}")
    return height, width


def _last(space: Workspace) -> Look:
    if space.last is None:
        raise InputError("pick: expected an earlier picture; call look first")
    return space.last


def _hit(space: Workspace, name: str, pixel: list[int], snap: float) -> Pick:
    """The surface at a pixel, [row, column], of the last picture, as `Look.pick`; `name` is the argument's."""
    look = _last(space)
    if len(pixel) != 2:
        raise InputError(f"{name}: expected [row, column], got {pixel!r}")
    row, column = pixel
    hit = look.pick(row, column, snap)
    if hit is None:
        raise InputError(f"{name}: expected a pixel with a surface, got background")
    return hit


def _same_view(camera: Camera, reference: Scene, scene: Scene) -> Camera:
    """Return the camera that shows a scene at the scale and place of the reference under the given camera."""
    right, up, *_ = camera.core(reference.center, reference.radius).pose(1, 1)
    across = np.array([right, up])
    offset = across @ (reference.center - scene.center) + reference.radius * np.asarray(camera.pan)
    pan = offset / scene.radius
    return replace(camera, zoom=camera.zoom * scene.radius / reference.radius, pan=(float(pan[0]), float(pan[1])))


def _short(answer: Any) -> Any:
    """Numbers in one line: indented, each of them would cost an agent a line."""
    return json.dumps(answer) if isinstance(answer, dict) else answer


def _image(rgba: Any) -> Image:
    return Image(data=png(rgba[..., :3]), format="png")
