"""Sheets: orthographic views of a scene to one scale, with its edges and dimensions, on one page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import floor, log10
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.color import from_srgb
from bobrossnet.picture.camera import VIEWS, Camera
from bobrossnet.picture.files import color_to_8_bit
from bobrossnet.picture.order import SizeLike, check_size
from bobrossnet.pictures.drawing import Edges
from bobrossnet.pictures.fitting import fitted
from bobrossnet.pictures.rendered import Picture
from bobrossnet.pictures.rendering import render
from bobrossnet.support.errors import InputError, InputTypeError, check_choice, check_flag, each_of
from bobrossnet.tracing.light import HEADLIGHT
from bobrossnet.tracing.parts import Extent
from bobrossnet.tracing.pixels import pixel_rays, tiled_pixels
from bobrossnet.tracing.scene import Scene, SceneLike, as_scene
from bobrossnet.tracing.section import SectionLike

if TYPE_CHECKING:
    from PIL.ImageDraw import ImageDraw

SIDES = {"front": "xz", "back": "xz", "right": "yz", "left": "yz", "top": "xy", "bottom": "xy"}
"""The axes across and up of each view whose dimensions are drawn."""

LAYOUT = ("top", "isometric", "front", "right")
"""Third-angle projection: the top view lies above the front view, the right view to its right."""

PIXELS_A_PLACE = 16
"""Of which one is asked for its part."""

MAX_NAMES = 12
MAX_NAME = 24

LINES = Edges(1.25, "#141820")

INK, GRAY, PAPER = (20, 24, 32), (110, 118, 130), (255, 255, 255)


def lengths(sides: Iterable[float], unit: str) -> str:
    """Lengths as people read them, such as "4 x 2 x 1 mm"."""
    return " x ".join(f"{side:.4g}" for side in sides) + (f" {unit}" if unit else "")


@dataclass(frozen=True)
class _Cell:
    """A view in its place on the sheet."""

    name: str
    left: int
    top: int
    size: tuple[int, int]


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
    views : sequence of str
        One to six of "front", "back", "right", "left", "top", "bottom" and "isometric", in rows of two from the top
        left on. By default third-angle projection.
    size : (height, width), or "WIDTHxHEIGHT"
        At least 240 x 240.
    title : str, optional
        The first words of the bottom line; size and number of parts follow. By default the scene's description.
    unit : str, optional
        Follows the dimensions, such as "mm"; by default the scene's.
    edges : bool
        Draw edges, as in `draw`.
    names : bool
        Name up to twelve parts in the isometric view, if they have different names.
    section : Section, text such as "x=0", or up to six of them, optional
        As in `Scene`; by default the scene's.

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
    from PIL import Image, ImageDraw

    scene = as_scene(scene, section)
    height, width = check_size(size)
    if min(height, width) < 240:
        raise InputError(f"size: expected at least 240x240, got {width}x{height}")
    chosen = [
        check_choice("views", view, tuple(VIEWS))
        for view in each_of("views", [views] if isinstance(views, str) else views, "names of views")
    ]
    if not 1 <= len(chosen) <= 6:
        raise InputError(f"views: expected 1 to 6 of {', '.join(VIEWS)}, got {len(chosen)}")
    edges, names = check_flag("edges", edges), check_flag("names", names)
    unit = (scene.unit or "") if unit is None else unit
    for name, text in (("title", "" if title is None else title), ("unit", unit)):
        if not isinstance(text, str):
            raise InputTypeError(f"{name}: expected a string, got {type(text).__name__}")

    box = scene.extent
    line = max(14, min(height, width) // 45)
    cells = _cells(chosen, height - 2 * line, width)
    fits = [_fit(scene, box, cell, line) for cell in cells]
    zoom = min(camera.zoom for camera in fits)
    cameras = [replace(camera, zoom=zoom) for camera in fits]
    page = Image.new("RGB", (width, height), PAPER)
    draw = ImageDraw.Draw(page)
    pixels = min(cells[0].size) * zoom / (2 * scene.radius)
    for cell, camera in zip(cells, cameras, strict=True):
        page.paste(Image.fromarray(_drawn(scene, camera, cell.size, edges)), (cell.left, cell.top))
    for cell, camera in zip(cells, cameras, strict=True):
        _label(draw, (cell.left + line // 2, cell.top + line // 2), cell.name, line, GRAY, "lt")
        if cell.name in SIDES:
            _dimensions(draw, box, cell, pixels, line, unit)
        elif names:
            _names(draw, scene, camera, cell, line)
    _scale_bar(draw, (width, height - line), pixels, line, unit)
    parts = len(scene.instances)
    words = [scene.describe() if title is None else title, lengths(box.size, unit)]
    if parts > 1:
        words.append(f"{parts:,} parts")
    _label(draw, (line // 2, height - line), "   ".join(words), line, INK, "lm", width - line - 8 * line)
    return Picture(np.asarray(from_srgb(np.asarray(page) / 255), np.float32), np.ones((height, width), np.float32))


def _cells(views: list[str], height: int, width: int) -> list[_Cell]:
    columns = 1 if len(views) == 1 else 2 if len(views) <= 4 else 3
    rows = -(-len(views) // columns)
    size = height // rows, width // columns
    return [_Cell(view, i % columns * size[1], i // columns * size[0], size) for i, view in enumerate(views)]


def _fit(scene: Scene, box: Extent, cell: _Cell, line: int) -> Camera:
    """The largest view of the cell that leaves room for dimensions and names around it."""
    azimuth, elevation = VIEWS[cell.name]
    camera = Camera(azimuth, elevation)
    rows, columns = cell.size
    room = rows - 7 * line, columns - 8 * line
    if cell.name not in SIDES:
        fit = fitted(scene, camera, size=room, margin=0)
        return replace(fit, zoom=fit.zoom * min(room) / min(rows, columns))
    wide, high = (float(box.size["xyz".index(axis)]) / (2 * scene.radius) for axis in SIDES[cell.name])
    zoom = min(room[0] / max(high, 1e-6), room[1] / max(wide, 1e-6)) / min(rows, columns)
    middle = (((box.low + box.high) / 2 - scene.center) / scene.radius).astype(np.float32)
    row, column = camera.core(scene.center, scene.radius).seen(rows, columns, middle[None])[0, :2]
    radii = 2 / min(rows, columns)
    pan = (float(column + 0.5 - columns / 2) * radii, -float(row + 0.5 - rows / 2) * radii)
    return replace(camera, zoom=zoom, pan=pan)


def _drawn(scene: Scene, camera: Camera, size: tuple[int, int], edges: bool) -> NDArray[np.uint8]:
    """(H, W, 3) uint8."""
    shown = render(scene, camera, size=size, background="#ffffff", light=HEADLIGHT, ground=False, edges=edges and LINES)
    return color_to_8_bit(shown.color)


# ---- Lines and words -------------------------------------------------------------------------------------


def _font(size: int) -> Any:
    from PIL import ImageFont

    return ImageFont.load_default(size)


def _label(
    draw: ImageDraw,
    place: tuple[float, float],
    text: str,
    line: int,
    color: tuple[int, int, int],
    anchor: str,
    width: float | None = None,
) -> None:
    """Text of the line's height, cut off if it is wider than `width`."""
    font = _font(round(0.8 * line))
    while width is not None and draw.textlength(text, font=font) > width and len(text) > 4:
        text = f"{text[:-4]}..."
    draw.text(place, text, color, font=font, anchor=anchor)


def _dimensions(draw: ImageDraw, box: Extent, cell: _Cell, pixels: float, line: int, unit: str) -> None:
    """A dimension line below the view and one to its left."""
    wide, high = (float(box.size["xyz".index(axis)]) for axis in SIDES[cell.name])
    middle = cell.left + cell.size[1] / 2, cell.top + cell.size[0] / 2
    left, right = middle[0] - wide * pixels / 2, middle[0] + wide * pixels / 2
    top, bottom = middle[1] - high * pixels / 2, middle[1] + high * pixels / 2
    y, x, tick = bottom + 1.2 * line, left - 1.2 * line, 0.3 * line
    draw.line([(left, y), (right, y)], GRAY)
    for end in (left, right):
        draw.line([(end, bottom + 0.4 * line), (end, y + tick)], GRAY)
    draw.line([(x, top), (x, bottom)], GRAY)
    for end in (top, bottom):
        draw.line([(left - 0.4 * line, end), (x - tick, end)], GRAY)
    _label(draw, (middle[0], y + 0.3 * line), lengths([wide], unit), line, INK, "mt")
    _label(draw, (x - 0.4 * line, middle[1]), lengths([high], unit), line, INK, "rm")


def _scale_bar(draw: ImageDraw, corner: tuple[int, int], pixels: float, line: int, unit: str) -> None:
    """The longest of 1, 2 or 5 times a power of ten units that is at most six lines wide."""
    longest = 6 * line / pixels
    power = 10.0 ** floor(log10(longest))
    length = max(times * power for times in (1, 2, 5) if times * power <= longest)
    right = corner[0] - line / 2
    left, y = right - length * pixels, corner[1] + 0.3 * line
    draw.line([(left, y), (right, y)], INK, width=max(2, line // 8))
    for end in (left, right):
        draw.line([(end, y - 0.25 * line), (end, y + 0.25 * line)], INK, width=max(2, line // 8))
    _label(draw, ((left + right) / 2, y - 0.3 * line), lengths([length], unit), line, INK, "mb")


def _names(draw: ImageDraw, scene: Scene, camera: Camera, cell: _Cell, line: int) -> None:
    """The parts' names at the right border, each with a leader to a visible place of its part."""
    names = [instance.name for instance in scene.instances]
    if not 2 <= len(names) <= MAX_NAMES or None in names or len({*names}) < len(names):
        return
    places = _visible_places(scene, camera, cell.size)
    rows, columns = cell.size
    for i, (name, (row, column)) in enumerate(sorted(places.items(), key=lambda item: item[1])):
        y = cell.top + line + (i + 0.5) * min((rows - 2 * line) / len(places), 2 * line)
        right, text = cell.left + columns - line / 2, names[name] or ""
        text = text if len(text) <= MAX_NAME else f"{text[: MAX_NAME - 3]}..."
        start = right - draw.textlength(text, font=_font(round(0.8 * line))) - 0.3 * line
        at = cell.left + column + 0.5, cell.top + row + 0.5
        draw.line([(start, y), at], GRAY)
        draw.ellipse([(at[0] - 2, at[1] - 2), (at[0] + 2, at[1] + 2)], INK)
        _label(draw, (right, y), text, line, INK, "rm")


def _visible_places(scene: Scene, camera: Camera, size: tuple[int, int]) -> dict[int, tuple[float, float]]:
    """By instance, the row and column of the visible pixel nearest to the middle of its visible pixels."""
    pixels = np.ascontiguousarray(tiled_pixels(size)[::PIXELS_A_PLACE])
    rays, origins, directions = pixel_rays(camera, scene.center, scene.radius, size, pixels)
    hits, pixels = scene.closest_hits(origins, directions), pixels[rays]
    places = {}
    for instance in np.unique(hits.instance[hits.instance >= 0]).tolist():
        own = pixels[hits.instance == instance]
        row, column = own[((own - own.mean(axis=0)) ** 2).sum(axis=1).argmin()].tolist()
        places[instance] = (row, column)
    return places
