"""`bobrossnet measure`: sizes, areas and volumes of shapes and their parts."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from bobrossnet.command_line import arguments
from bobrossnet.command_line.report import Report, add_report
from bobrossnet.support.units import METRES

if TYPE_CHECKING:
    import bobrossnet as bob


def add(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    measure = commands.add_parser(
        "measure",
        help="print the size, area and volume of shapes and their parts",
        description="Print the size, area and volume of shapes and their parts, in the unit of the file.",
    )
    measure.set_defaults(run=run)
    arguments.add_files(measure)
    arguments.add_parts(measure)
    measure.add_argument("--unit", choices=tuple(METRES), help="convert lengths to this unit (default: the file's)")
    arguments.add_up(measure, "z")
    add_report(measure)


def run(options: argparse.Namespace) -> None:
    """Print a line of the whole and one of each part."""
    import bobrossnet as bob
    from bobrossnet.support.machine import limit_memory

    limit_memory()
    report = Report(options)
    scene = arguments.scene_of(options)
    found = bob.measure(scene, unit=options.unit)
    report.line(f"{scene.describe()}: {found}")
    report.line(f"area and volume to {found.error:.1g} of themselves; {_told(found)}")
    if len(found.parts) > 1:
        width = max(len(part.name) for part in found.parts)
        for part in found.parts:
            report.line(f"  {part.name:{width}}  {part}")
    report.fields |= _fields(found) | {"parts": [{"name": part.name} | _fields(part) for part in found.parts]}
    report.end()


def _told(found: bob.Measures) -> str:
    return "the unit is unknown" if found.unit is None else f"the unit is {found.unit}"


def _fields(found: bob.Measures) -> dict[str, Any]:
    return {
        "unit": found.unit,
        "size": found.size.tolist(),
        "bounds": [found.low.tolist(), found.high.tolist()],
        "area": found.area,
        "closed": found.is_closed,
        "volume": found.volume,
        "error": found.error,
    }
