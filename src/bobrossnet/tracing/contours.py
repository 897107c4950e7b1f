"""Contours of sections: exact curves, their areas and lengths, as drawings."""

from __future__ import annotations

import html
import os
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet.color import hex_color
from bobrossnet.shapes.chains import Curve
from bobrossnet.shapes.cuts import Plane, cut
from bobrossnet.support.atomic import check_writable, write_whole
from bobrossnet.support.errors import InputError, InputTypeError, check_flag
from bobrossnet.support.messages import counted
from bobrossnet.support.units import check_unit, factor
from bobrossnet.tracing.scene import SceneLike, as_scene
from bobrossnet.tracing.section import Section, check_sections

UNITS = {
    "in": 1, "ft": 2, "mi": 3, "mm": 4, "cm": 5, "m": 6, "km": 7, "mil": 9, "yd": 10, "nm": 12, "um": 13, "dm": 14
}  # fmt: skip
"""Units of drawings, and their numbers in DXF."""

FORMATS = (".svg", ".dxf")


class ContourPart(NamedTuple):
    """The contours of an instance."""

    instance: int
    """Its index in `Scene.instances`."""
    name: str
    """Name of the instance; for unnamed ones, "part" and the number from 1 on."""
    color: tuple[float, float, float]
    """Colour of its material, linear RGB."""
    curves: tuple[Curve, ...]
    """Closed ones first: borders anticlockwise, holes clockwise."""

    @property
    def area(self) -> float:
        """Area of the cap, without its holes."""
        return sum(curve.area() for curve in self.curves)

    @property
    def length(self) -> float:
        """Length of all curves."""
        return sum(curve.length() for curve in self.curves)

    @property
    def loops(self) -> list[NDArray[np.float64]]:
        """The closed polylines, each (n, 2), without a repeated point."""
        return [curve.points for curve in self.curves if curve.is_closed]

    @property
    def lines(self) -> list[NDArray[np.float64]]:
        """The open polylines, each (n, 2): of shapes that enclose no solid."""
        return [curve.points for curve in self.curves if not curve.is_closed]

    @property
    def is_closed(self) -> bool:
        """Whether all curves close."""
        return all(curve.is_closed for curve in self.curves)


@dataclass(frozen=True, repr=False, eq=False)
class Contours:
    """The contours of a section, as `section` finds them.

    Coordinates are in the section's plane, to the right and up for a viewer on the removed side: x and y of "z=3",
    y and z of "x=3", -x and z of "y=3". They and all lengths are in the scene's unit.

    Attributes
    ----------
    section : Section
    parts : tuple of ContourPart
        One for each instance that the plane cuts.
    unit : str or None
        The scene's.
    """

    section: Section
    parts: tuple[ContourPart, ...]
    unit: str | None

    def __repr__(self) -> str:
        return f"Contours({counted(len(self.parts), 'part')}, area {self.area:.6g}, length {self.length:.6g})"

    @property
    def area(self) -> float:
        """The sum of the parts' areas; where parts overlap, each counts."""
        return sum(part.area for part in self.parts)

    @property
    def length(self) -> float:
        """The sum of the parts' lengths."""
        return sum(part.length for part in self.parts)

    @property
    def polylines(self) -> list[NDArray[np.float64]]:
        """All closed polylines, each (n, 2), without a repeated point."""
        return [loop for part in self.parts for loop in part.loops]

    def points(self, polyline: NDArray[np.float64]) -> NDArray[np.float64]:
        """Map coordinates in the plane, (n, 2), to the scene's, (n, 3)."""
        points: NDArray[np.float64] = polyline @ self.section.axes() + self.section.offset * np.array(
            self.section.normal
        )
        return points

    def save(self, path: str | os.PathLike[str], *, unit: str | None = None, hatch: bool = True) -> None:
        """Write a drawing to scale.

        Parameters
        ----------
        path : str or path
            Ends in .svg or .dxf (of release 12, with a layer for each part).
        unit : str, optional
            The unit of the coordinates, such as "mm" or "in"; by default the scene's, or mm if it has none. Lengths are
            converted if the scene's unit is known.
        hatch : bool
            Fill the parts in SVG with their colour and hatching.

        Raises
        ------
        InputError
            If the path has another ending or can't be written, or there is nothing to draw.
        """
        file = check_writable(path, "a drawing", FORMATS)
        unit = check_unit("unit", unit) or self.unit or "mm"
        hatch = check_flag("hatch", hatch)
        if not self.parts:
            raise InputError("section: expected a plane that meets a shape, got one that misses all; nothing to draw")
        parts = self.parts if self.unit in (None, unit) else _scaled(self.parts, factor(self.unit, unit))
        text = _svg(parts, unit, hatch) if file.suffix.lower() == ".svg" else _dxf(parts, unit)
        write_whole(file, text.encode())


def section(scene: SceneLike, section: Section | str) -> Contours:
    """Cut a scene by a plane and return the exact contours.

    Triangles are cut exactly. Curves of formulas and NURBS are polylines within 2e-6 of the scene's radius; areas and
    lengths are extrapolated, for smooth curves to about 1e-9 of the exact values. Details of formulas below 1/384 of
    their box may be missing, and tubes are cut as meshes of 1/512 of their length.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these
        The scene's own sections are ignored.
    section : Section, or text such as "z=3"

    Returns
    -------
    Contours
        Without parts if the plane misses all shapes.

    Raises
    ------
    InputError
        If an argument is out of range.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> from bobrossnet.sdf import sphere
    >>> cut = bob.section(sphere(1) - sphere(0.5), "z=0")
    >>> round(cut.area, 6), round(cut.length, 6), len(cut.polylines)
    (2.356194, 9.424778, 2)
    """
    whole, chosen = as_scene(scene), check_sections(section)
    if len(chosen) != 1:
        raise InputTypeError(f"section: expected one section, got {len(chosen)}")
    (one,) = chosen
    plane = Plane(np.array(one.normal), one.offset, one.axes(), whole.radius)
    corners = np.stack([whole.boxes[:, corner, range(3)] for corner in np.ndindex(2, 2, 2)], axis=1)
    along = corners @ plane.normal - plane.offset
    slack = 1e-6 * whole.radius
    parts = []
    for i in np.flatnonzero((along.min(axis=1) <= slack) & (along.max(axis=1) >= -slack)).tolist():
        instance = whole.instances[i]
        curves = cut(instance.shape, instance.transform, plane)
        if curves:
            name = instance.name or f"part {i + 1}"
            parts.append(ContourPart(i, name, instance.material.color, tuple(_ordered(curves))))
    return Contours(one, tuple(parts), whole.unit)


def _ordered(curves: list[Curve]) -> list[Curve]:
    """Return closed curves first, turned so that material, which an odd number of curves encloses, is to their left."""
    closed = [curve for curve in curves if curve.is_closed and len(curve.points) > 2]
    turned = []
    for curve in closed:
        around = sum(_encloses(other, curve.points[0]) for other in closed if other is not curve)
        turned.append(curve if (curve.area() > 0) == (around % 2 == 0) else curve.turned())
    return turned + [curve for curve in curves if not curve.is_closed]


def _encloses(curve: Curve, point: NDArray[np.float64]) -> bool:
    start = curve.points
    if not ((start.min(axis=0) <= point) & (point <= start.max(axis=0))).all():
        return False
    end = np.roll(start, -1, axis=0)
    crosses = (start[:, 1] <= point[1]) != (end[:, 1] <= point[1])
    (x0, y0), (x1, y1) = start[crosses].T, end[crosses].T
    return bool(np.count_nonzero(x0 + (point[1] - y0) / (y1 - y0) * (x1 - x0) > point[0]) % 2)


# ---- Drawings ------------------------------------------------------------------------------------------------------


def _scaled(parts: tuple[ContourPart, ...], factor: float) -> tuple[ContourPart, ...]:
    return tuple(part._replace(curves=tuple(curve.scaled(factor) for curve in part.curves)) for part in parts)


def _svg(parts: tuple[ContourPart, ...], unit: str, hatch: bool) -> str:
    everything = np.concatenate([curve.points for part in parts for curve in part.curves])
    low, high = everything.min(axis=0), everything.max(axis=0)
    margin = 0.02 * max((high - low).max(), 1e-300)
    (x, y), (width, height) = (low[0] - margin, -high[1] - margin), high - low + 2 * margin
    suffix = unit if unit in ("mm", "cm", "in") else ""  # SVG has no others
    size = f'width="{width:.9g}{suffix}" height="{height:.9g}{suffix}"'
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} viewBox="{x:.9g} {y:.9g} {width:.9g} {height:.9g}">',
        f"<desc>Section; lengths in {unit}</desc>",
    ]
    period = max(width, height) / 48
    if hatch:
        for i in range(len(parts)):
            angle, space = 45 if i % 2 == 0 else -45, period / (1, 1.6, 0.7)[i // 2 % 3]
            lines.append(
                f'<pattern id="h{i}" patternUnits="userSpaceOnUse" width="{space:.6g}" height="{space:.6g}" '
                f'patternTransform="rotate({angle})"><path d="M0 0V{space:.6g}" stroke="#000" stroke-opacity=".6" '
                f'stroke-width="{space / 5:.6g}"/></pattern>'
            )
    for i, part in sorted(enumerate(parts), key=lambda numbered: -numbered[1].area):  # nested parts last
        closed = "".join(_path(loop) + "Z" for loop in part.loops)
        opened = "".join(_path(line) for line in part.lines)
        stroke = 'stroke="#000" vector-effect="non-scaling-stroke"'
        lines.append(f"<g><title>{html.escape(part.name)}</title>")
        fills = [hex_color(part.color), f"url(#h{i})"] if hatch else []
        lines += [f'<path fill="{fill}" fill-rule="evenodd" d="{closed}"/>' for fill in fills if closed]
        lines.append(f'<path fill="none" {stroke} d="{closed}{opened}"/></g>')
    return "\n".join([*lines, "</svg>", ""])


def _path(points: NDArray[np.float64]) -> str:
    return "M" + "L".join(f"{x:.9g} {-y:.9g}" for x, y in points.tolist())


def _dxf(parts: tuple[ContourPart, ...], unit: str) -> str:
    layers = [_layer(part.name, i) for i, part in enumerate(parts)]
    groups: list[tuple[int, object]] = [
        (0, "SECTION"), (2, "HEADER"),
        (9, "$ACADVER"), (1, "AC1009"), (9, "$INSUNITS"), (70, UNITS[unit]), (0, "ENDSEC"),
        (0, "SECTION"), (2, "TABLES"), (0, "TABLE"), (2, "LAYER"), (70, len(layers)),
    ]  # fmt: skip
    for i, layer in enumerate(layers):
        groups += [(0, "LAYER"), (2, layer), (70, 0), (62, i % 6 + 1), (6, "CONTINUOUS")]
    groups += [(0, "ENDTAB"), (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES")]
    for layer, part in zip(layers, parts, strict=True):
        for curve in part.curves:
            groups += [
                (0, "POLYLINE"),
                (8, layer),
                (66, 1),
                (10, 0.0),
                (20, 0.0),
                (30, 0.0),
                (70, int(curve.is_closed)),
            ]
            for x, y in curve.points.tolist():
                groups += [(0, "VERTEX"), (8, layer), (10, x), (20, y), (30, 0.0)]
            groups += [(0, "SEQEND"), (8, layer)]
    groups += [(0, "ENDSEC"), (0, "EOF")]
    return "".join(f"{code:3}\n{f'{value:.12g}' if isinstance(value, float) else value}\n" for code, value in groups)


def _layer(name: str, number: int) -> str:
    """Names of layers in release 12 have up to 31 letters, digits, dollars, hyphens and underscores; each differs."""
    letters = "".join(c if c.isascii() and (c.isalnum() or c in "$-_") else "_" for c in name.upper())
    return f"{number + 1}_{letters}"[:31]
