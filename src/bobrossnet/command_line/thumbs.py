"""`bobrossnet thumbs`: renders a picture of every shape file of a folder."""

from __future__ import annotations

import argparse
import sys
import time
from typing import Any

from bobrossnet.command_line import arguments
from bobrossnet.command_line.report import Report, add_report
from bobrossnet.support.machine import MAX_PROCESSES


def add(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    thumbs = commands.add_parser(
        "thumbs",
        help="make a picture of every shape file of a folder",
        description="Make a picture of every shape file of a folder and below it. Pictures newer than their files "
        "are kept. The exit status is 0 if every file has one, 1 if files were left out.",
    )
    thumbs.set_defaults(run=run)
    arguments.add_pictures_of_folder(thumbs, "folder for the pictures", (256, 256))
    arguments.add_orbit(thumbs)
    thumbs.add_argument("--anew", action="store_true", help="also make pictures that exist and are up to date")
    thumbs.add_argument(
        "--workers",
        type=arguments.integer(1, MAX_PROCESSES),
        metavar="N",
        help="processes (default: one for each core)",
    )
    thumbs.add_argument("--sheet", metavar="PICTURE", help="also write one sheet with all pictures")
    add_report(thumbs)


def run(options: argparse.Namespace) -> int:
    """Render the pictures, print failed files and the counts, and return the exit status."""
    import bobrossnet as bob
    from bobrossnet.adapters.files import shape_files
    from bobrossnet.picture.files import check_picture_path, write_picture
    from bobrossnet.pictures.thumbnails import contact_sheet
    from bobrossnet.support.errors import InputError
    from bobrossnet.support.machine import limit_memory
    from bobrossnet.support.messages import counted, kept_and_failed, left_out
    from bobrossnet.support.progress import progress

    limit_memory()
    told = Report(options)
    sheet = None if options.sheet is None else check_picture_path(options.sheet)
    if not shape_files(options.folder):
        raise InputError(f"{options.folder}: expected shape files in it or below it, got none")
    start = time.perf_counter()
    with progress("drawing") as show:
        made = bob.thumbnails(
            options.folder,
            options.out,
            size=options.size,
            camera=arguments.thumbnail_camera_of(options),
            samples=options.samples,
            background=arguments.background(options.background),
            up=options.up,
            light=options.light,
            ground=options.ground,
            anew=options.anew,
            workers=options.workers,
            scheduler=options.scheduler,
            progress=show,
        )
    seconds = time.perf_counter() - start
    for each in made:
        if each.error is not None:
            print(left_out(each.file, each.error), file=sys.stderr)
    drawn = sum(each.is_new and each.error is None for each in made)
    kept = sum(not each.is_new for each in made)
    if sheet is not None:
        write_picture(sheet, contact_sheet(made))
        told.line(f"wrote {sheet}")
    failed = len(made) - drawn - kept
    told.line(
        f"wrote {counted(drawn, 'picture')} to {options.out} in {seconds:.1f} s; "
        f"{kept_and_failed(kept, 'picture', failed)}"
    )
    told.fields |= {
        "files": [
            {
                "file": str(each.file),
                "picture": None if each.picture is None else str(each.picture),
                "is_new": each.is_new,
                "error": each.error,
            }
            for each in made
        ],
        "drawn": drawn,
        "kept": kept,
        "failed": failed,
        "seconds": seconds,
    }
    told.end()
    return 1 if failed else 0
