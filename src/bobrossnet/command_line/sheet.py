"""`bobrossnet sheet`: views of shapes to one scale, with dimensions."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

from bobrossnet.command_line import arguments
from bobrossnet.command_line.report import Report, add_report, plural
from bobrossnet.picture.camera import VIEWS
from bobrossnet.pictures.sheets import LAYOUT, check_sheet_size, check_views, laid_out
from bobrossnet.support.units import METRES

SIZE = (900, 1200)


def add(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    sheet = commands.add_parser(
        "sheet",
        help="draw views of shapes to one scale, with dimensions",
        description="Draw orthographic views of shapes to one scale, with edges, dimensions and names of parts.",
    )
    sheet.set_defaults(run=run)
    arguments.add_files(sheet)
    arguments.add_size(sheet, SIZE, check_sheet_size)
    sheet.add_argument(
        "--views",
        type=arguments.checked("views", lambda text: check_views(text.split(","))),
        default=LAYOUT,
        metavar="VIEW,...",
        help=f"one to six of {', '.join(VIEWS)} (default: {','.join(LAYOUT)})",
    )
    sheet.add_argument("--title", help="first words of the bottom line (default: the file's name)")
    sheet.add_argument("--unit", choices=tuple(METRES), help="convert lengths to this unit (default: the file's)")
    sheet.add_argument("--no-edges", dest="edges", action="store_false", help="leave silhouettes and creases out")
    arguments.add_up(sheet)
    arguments.add_section(sheet, "add a view of the shapes cut open")
    arguments.add_parts(sheet)
    told = "default: sheet.png; - writes a PNG to standard output"
    sheet.add_argument("-o", "--out", default="sheet.png", metavar="PICTURE", help=told)
    add_report(sheet)


def run(options: argparse.Namespace) -> None:
    """Draw the sheet, and print the dimensions."""
    from PIL import Image, ImageDraw, ImageFont  # noqa: F401  here, while another process reads a CAD file

    from bobrossnet.picture.files import check_picture_path
    from bobrossnet.pictures.annotations import lengths
    from bobrossnet.support.machine import limit_memory

    Image.preinit()  # imports the formats
    limit_memory()
    report = Report(options)
    if not report.to_stdout:
        check_picture_path(options.out, options.size)
    scene = arguments.scene_of(options).sectioned(None)
    title = Path(options.files[0]).name if len(options.files) == 1 and options.title is None else options.title
    start = time.perf_counter()
    sheet = laid_out(scene, options.views, options.size, options.unit, options.section)
    picture = sheet.drawn(title, options.edges)
    seconds = time.perf_counter() - start
    scene, unit = sheet.scene, sheet.unit
    name, box = report.write(picture.rgba), scene.extent
    report.line(f"wrote {name}: {scene.describe()}, {lengths(box.size, unit)}, {seconds:.1f} s")
    report.fields |= {
        "picture": options.out,
        "views": list(options.views),
        "scene": plural(scene.counts()),
        "bounds": [box.low.tolist(), box.high.tolist()],
        "unit": unit,
        "seconds": seconds,
    }
    report.end()
