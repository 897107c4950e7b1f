"""`bobrossnet complete`: completes sparse pictures of other programs."""

from __future__ import annotations

import argparse
import time
from typing import Any

from bobrossnet.command_line import arguments

WHAT = {
    "color": "with the picture",
    "depth": "with the depth of the first surfaces",
    "normal": "with the normals of the first surfaces",
    "albedo": "with the albedo of the first surfaces",
    "mask": "that is not 0 at known pixels (default: alpha; without alpha, pixels that are not black are known)",
}


def add(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    command = commands.add_parser(
        "complete",
        help="complete a sparsely rendered OpenEXR picture",
        description="Complete a sparsely rendered OpenEXR picture. If depth, normals or albedo are known at all "
        "pixels, light is completed along them. Common names of layers are recognised, including "
        "Blender's and Mitsuba's.",
    )
    command.set_defaults(run=run)
    command.add_argument(
        "file", metavar="SPARSE.exr", help="an OpenEXR file with scanlines or tiles, and one or more parts"
    )
    for role, what in WHAT.items():
        command.add_argument(f"--{role}", metavar="LAYER", help=f"the layer or channel {what}")
    arguments.add_model(command)
    command.add_argument("-o", "--out", default="out.exr", metavar="FULL.exr", help="file to write (default: out.exr)")


def run(options: argparse.Namespace) -> None:
    """Complete the file, and print the sizes and times."""
    from bobrossnet.completion.exr import completed_channels
    from bobrossnet.picture.exr import ENDING, read_exr, write_exr
    from bobrossnet.support.atomic import check_writable
    from bobrossnet.support.machine import limit_memory
    from bobrossnet.support.messages import counted

    limit_memory()
    out = check_writable(options.out, "a picture", [ENDING])
    file = read_exr(options.file, {role: getattr(options, role) for role in WHAT if getattr(options, role)})
    height, width = file.size
    for role, names in file.roles.items():
        dense = ", of all pixels" if role in ("depth", "normal", "albedo") and file.is_dense(names[0]) else ""
        print(f"{role:10} {', '.join(names)}{dense}")
    print(f"known      {100 * float(file.traced().mean()):.4g} % of {width}x{height}")
    start = time.perf_counter()
    planes = completed_channels(file, options.model)
    print(f"completed  {counted(len(planes), 'channel')} in {1000 * (time.perf_counter() - start):.0f} ms")
    write_exr(out, planes, file.header)
    print(f"wrote      {out}")
