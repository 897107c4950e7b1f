"""Sheets: orthographic views of a scene to one scale, with its edges and dimensions, on one page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import asin, atan2, ceil, degrees, isqrt

import numpy as np
from numpy.typing import NDArray

from bobrossnet.measuring.measure import measure
from bobrossnet.picture.camera import VIEWS, Camera
from bobrossnet.picture.files import color_to_8_bit
from bobrossnet.picture.order import Size, SizeLike, check_size
from bobrossnet.pictures.annotations import GRAY, PAPER, Annotations, Place, font, lengths
from bobrossnet.pictures.drawing import Edges
from bobrossnet.pictures.fitting import fitted
from bobrossnet.pictures.rendered import Picture
from bobrossnet.pictures.rendering import render
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.shapes.nurbs import Brep
from bobrossnet.support.errors import InputError, InputTypeError, check_choice, check_flag, each_of
from bobrossnet.support.messages import counted
from bobrossnet.support.threads import together
from bobrossnet.support.units import check_unit, factor
from bobrossnet.tracing.light import HEADLIGHT
from bobrossnet.tracing.parts import Extent
from bobrossnet.tracing.pixels import pixel_rays, tiled_pixels
from bobrossnet.tracing.scene import Scene, SceneLike, as_scene
from bobrossnet.tracing.section import Section, SectionLike, check_sections

SIDES = {"front": "xz", "back": "xz", "right": "yz", "left": "yz", "top": "xy", "bottom": "xy"}
"""The axes across and up of each view whose dimensions are drawn."""

TOWARD = {"right": (1, 0, 0), "left": (-1, 0, 0), "back": (0, 1, 0), "front": (0, -1, 0), "top": (0, 0, 1)} | {
    "bottom": (0, 0, -1)
}
"""Directions from the scene to the viewer."""

LAYOUT = ("top", "isometric", "front", "right")
"""Third-angle projection: the top view lies above the front view, the right view to its right."""

PIXELS_A_PLACE = 16
"""One pixel in this number is traced, to find the visible parts."""

MAX_NAMES = 12

LINES = Edges(1.25, "#141820")

LINE_SHARE, LEAST_LINE = 40, 14
"""Lines of text that fill the shorter side, and their minimum height in pixels: letters stay legible on 768 pixels."""


@dataclass(frozen=True, eq=False)
class SheetView:
    """A view in its place on a sheet."""

    label: str
    scene: Scene
    """Cut open, if the view is a section's."""
    camera: Camera
    left: int
    top: int
    size: Size
    axes: str | None
    """Axes to the right and up, whose dimensions are drawn; None for oblique views."""

    @property
    def middle(self) -> Place:
        """x and y on the page."""
        return self.left + self.size[1] / 2, self.top + self.size[0] / 2

    def places(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return x and y on the page, (n, 2), of points of the scene, (n, 3)."""
        unit = np.asarray((points - self.scene.center) / self.scene.radius, np.float32)
        seen = self.camera.core(self.scene.center, self.scene.radius).seen(*self.size, unit)[:, :2]
        return seen[:, ::-1].astype(np.float64) + (self.left + 0.5, self.top + 0.5)


@dataclass(frozen=True, eq=False)
class Sheet:
    """The views of a sheet and their scale; `drawn` draws them."""

    scene: Scene
    size: Size
    views: tuple[SheetView, ...]
    sections: tuple[Section, ...]
    pixels: float
    """Pixels of a unit of length."""
    line: int
    """Pixels of a line of text."""
    unit: str
    """Follows lengths."""

    def drawn(self, title: str | None = None, edges: bool = True, names: bool = True) -> Picture:
        """Draw the sheet; arguments as in `sheet`."""
        from PIL import Image, ImageDraw

        (height, width), line, unit = self.size, self.line, self.unit
        page = Image.new("RGB", (width, height), PAPER)
        *shown, known = together(
            [*(partial(_drawn, view, edges) for view in self.views), partial(_facts, self.scene, unit)]
        )
        for view, drawn in zip(self.views, shown, strict=True):
            page.paste(Image.fromarray(drawn), (view.left, view.top))
        notes, box = Annotations(ImageDraw.Draw(page), line, unit), self.scene.extent
        named = next((view for view in self.views if view.label == "isometric"), self.views[0])
        for view in self.views:
            notes.label((view.left + line // 2, view.top + line // 2), view.label, GRAY, "lt")
            if view.axes is not None:
                wide, high = (float(box.size["xyz".index(axis)]) for axis in view.axes)
                notes.dimensions(view.middle, wide, high, self.pixels)
                for section in self.sections if view.label in SIDES else ():
                    self._cutting_line(notes, view, section)
            if names and view is named and (places := _named_places(view)):
                notes.names(places, view.left + view.size[1] - line / 2, view.top + line, view.size[0] - 2 * line)
        notes.scale_bar(width - line / 2, height - 0.7 * line, self.pixels)
        facts = [lengths(box.size, unit), *known]
        notes.title(
            (line / 2, height - line), self.scene.describe() if title is None else title, facts, width - 9 * line
        )
        return Picture.opaque(np.asarray(page))

    def _cutting_line(self, notes: Annotations, view: SheetView, section: Section) -> None:
        """Draw where a section along an axis of the view cuts."""
        axis, offset = section.axis()
        if axis is None or view.axes is None or "xyz"[axis] not in view.axes:
            return
        (other,) = ("xyz".index(name) for name in view.axes if name != "xyz"[axis])
        low, high = self.scene.extent
        if not low[axis] < offset < high[axis]:
            return
        ends = np.array([self.scene.extent.center] * 2)
        ends[:, axis], ends[:, other] = offset, (low[other], high[other])
        places = view.places(ends).tolist()
        # The upper or right end comes last: there is free space for the name.
        start, end = sorted(places, key=lambda place: (place[0] - place[1], place))
        notes.cutting_line((start[0], start[1]), (end[0], end[1]), str(section))


def sheet(
    scene: SceneLike,
    views: Sequence[str] = LAYOUT,
    *,
    size: SizeLike = "1200x900",
    title: str | None = None,
    unit: str | None = None,
    edges: bool = True,
    names: bool = True,
    section: SectionLike = None,
) -> Picture:
    """Draw views of a scene to one scale, with its edges, dimensions and a scale bar.

    Parameters
    ----------
    scene : Scene, Shape, Instance, path or iterable of these
        Its own sections cut all views.
    views : sequence of str
        One to six of "front", "back", "right", "left", "top", "bottom" and "isometric", in rows of two from the top
        left on. By default third-angle projection.
    size : (height, width), or "WIDTHxHEIGHT"
        At least 240 x 240.
    title : str, optional
        The first words of the bottom line. Size, number of parts and, of meshes and NURBS, the volume follow. By
        default the scene's description.
    unit : str, optional
        Follows the dimensions, such as "mm"; by default the scene's. Lengths are converted if that is known.
    edges : bool
        Draw edges, as in `draw`.
    names : bool
        Name up to twelve parts, in the isometric view or else in the first.
    section : Section, text such as "x=0", or up to six of them, optional
        Each adds a view that looks at the cut, and a line that marks it in the other views.

    Returns
    -------
    Picture
        Opaque, on white.

    Raises
    ------
    InputError
        If an argument is out of range, or a view has another name.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> bob.sheet(bob.happy_tree(), size="480x360").size
    (360, 480)
    """
    edges, names = check_flag("edges", edges), check_flag("names", names)
    if title is not None and not isinstance(title, str):
        raise InputTypeError(f"title: expected a string, got {type(title).__name__}")
    return laid_out(scene, views, size, unit, section).drawn(title, edges, names)


def laid_out(
    scene: SceneLike, views: Sequence[str], size: SizeLike, unit: str | None = None, section: SectionLike = None
) -> Sheet:
    """Return the sheet of some views and sections, not yet drawn; arguments as in `sheet`."""
    check_unit("unit", unit)
    height, width = check_sheet_size(size)
    chosen = check_views(views)
    sections = check_sections(section)
    scene = as_scene(scene)
    if unit and scene.unit:
        own, scene = scene.unit, scene.converted(unit)
        sections = tuple(each.scaled(factor(own, unit)) for each in sections)
    unit = scene.unit or "" if unit is None else unit
    line = max(LEAST_LINE, min(height, width) // LINE_SHARE)
    shown = [(name, scene, Camera.named(name), SIDES.get(name)) for name in chosen]
    shown += [_section_view(scene, each) for each in sections]
    cells = _cells(len(chosen), len(sections), height - 2 * line, width)
    widest = max(font(line).getlength(lengths([side], unit)) for side in scene.extent.size)
    margins = 7 * line, 2 * (ceil(widest) + 2 * line)
    placed = [
        SheetView(label, seen, _fit(seen, camera, axes, cell, margins), left, top, cell, axes)
        for (label, seen, camera, axes), (left, top, cell) in zip(shown, cells, strict=True)
    ]
    zoom = min(view.camera.zoom for view in placed)
    placed = [replace(view, camera=replace(view.camera, zoom=zoom)) for view in placed]
    pixels = min(placed[0].size) * zoom / (2 * scene.radius)
    return Sheet(scene, (height, width), tuple(placed), sections, pixels, line, unit)


def check_sheet_size(size: SizeLike) -> Size:
    """Return the size of a sheet; raise InputError if it is too small."""
    height, width = check_size(size)
    if min(height, width) < 240:
        raise InputError(f"size: expected at least 240x240, got {width}x{height}")
    return height, width


def check_views(views: Sequence[str]) -> list[str]:
    """Return the names of a sheet's views; raise InputError for unknown names, none or too many."""
    chosen = [
        check_choice("views", view, tuple(VIEWS))
        for view in each_of("views", [views] if isinstance(views, str) else views, "names of views")
    ]
    if not 1 <= len(chosen) <= 6:
        raise InputError(f"views: expected 1 to 6 of {', '.join(VIEWS)}, got {len(chosen)}")
    return chosen


def _section_view(scene: Scene, section: Section) -> tuple[str, Scene, Camera, str | None]:
    """Return the label, scene, camera and axes of the view that looks at a cut."""
    cut, label = scene.sectioned((*scene.section, section)), f"section {section}"
    for name, toward in TOWARD.items():
        if np.allclose(section.normal, toward, atol=1e-9):
            return label, cut, Camera.named(name), SIDES[name]
    x, y, z = section.normal
    return label, cut, Camera(degrees(atan2(y, x)), degrees(asin(max(-1.0, min(1.0, z))))), None


def _cells(views: int, sections: int, height: int, width: int) -> list[tuple[int, int, Size]]:
    """Return left, top and size of each view's place. Sections fill columns right of the views, from the top."""
    if views < 3:
        count = views + sections
        columns = isqrt(count - 1) + 1
        rows = -(-count // columns)
        places = [divmod(i, columns) for i in range(count)]
    else:
        columns = 2 if views <= 4 else 3
        rows = -(-views // columns)
        places = [divmod(i, columns) for i in range(views)]
        places += [(i % rows, columns + i // rows) for i in range(sections)]
        columns += -(-sections // rows)
    size = height // rows, width // columns
    return [(column * size[1], row * size[0], size) for row, column in places]


def _fit(scene: Scene, camera: Camera, axes: str | None, cell: Size, margins: Size) -> Camera:
    """Return the camera whose view is the largest that leaves room for dimensions and names around it."""
    rows, columns = cell
    room = max(rows - margins[0], 1), max(columns - margins[1], 1)
    if axes is None:
        fit = fitted(scene.sectioned(None), camera, size=room, margin=0)
        return replace(fit, zoom=fit.zoom * min(room) / min(rows, columns))
    box: Extent = scene.extent
    wide, high = (float(box.size["xyz".index(axis)]) / (2 * scene.radius) for axis in axes)
    zoom = min(room[0] / max(high, 1e-6), room[1] / max(wide, 1e-6)) / min(rows, columns)
    middle = (((box.low + box.high) / 2 - scene.center) / scene.radius).astype(np.float32)
    row, column = camera.core(scene.center, scene.radius).seen(rows, columns, middle[None])[0, :2]
    radii = 2 / min(rows, columns)
    pan = (float(column + 0.5 - columns / 2) * radii, -float(row + 0.5 - rows / 2) * radii)
    return replace(camera, zoom=zoom, pan=pan)


def _drawn(view: SheetView, edges: bool) -> NDArray[np.uint8]:
    """(H, W, 3) uint8."""
    lines = edges and LINES
    shown = render(
        view.scene, view.camera, size=view.size, background="#ffffff", light=HEADLIGHT, ground=False, edges=lines
    )
    return color_to_8_bit(shown.color)


def _facts(scene: Scene, unit: str) -> list[str]:
    """Return the number of parts and, where it is exact, the volume."""
    parts = sum(bool(part.own) for part in scene.parts.walk())
    facts = [counted(parts, "part")]
    if all(isinstance(instance.shape, Mesh | Brep) for instance in scene.instances):
        volume = measure(scene).volume
        facts.append("open" if volume is None else f"volume {lengths([volume], f'{unit}^3' if unit else '')}")
    return facts


def _named_places(view: SheetView) -> dict[str, Place]:
    """Return x and y on the page of each part's visible pixel nearest to the middle of its visible pixels."""
    scene = view.scene
    parts = [part for part in scene.parts.walk() if part.own]
    if not 2 <= len(parts) <= MAX_NAMES:
        return {}
    pixels = np.ascontiguousarray(tiled_pixels(view.size)[::PIXELS_A_PLACE])
    rays, origins, directions = pixel_rays(view.camera, scene.center, scene.radius, view.size, pixels)
    hits, pixels = scene.closest_hits(origins, directions), pixels[rays]
    found = np.full(len(hits.instance), -1)
    for i, part in enumerate(parts):
        for number, start, stop in part.own:
            has_faces = isinstance(scene.instances[number].shape, Mesh | Brep)
            primitive = np.maximum(hits.primitive, 0) if has_faces else start
            found[(hits.instance == number) & (start <= primitive) & (primitive < stop)] = i
    places = {}
    for i in np.unique(found[found >= 0]).tolist():
        own = pixels[found == i]
        row, column = own[((own - own.mean(axis=0)) ** 2).sum(axis=1).argmin()].tolist()
        name = parts[i].name if sum(part.name == parts[i].name for part in parts) == 1 else str(parts[i])
        places[name] = (view.left + column + 0.5, view.top + row + 0.5)
    return places
