"""Shape scripts, files of the modelling language. docs/scripts.md describes them."""

from __future__ import annotations

from pathlib import Path

from bobrossnet import _core
from bobrossnet.sdf.d3 import SDF3
from bobrossnet.support.errors import InputError


def read_script(path: Path) -> SDF3:
    """Run a script's file and return its shape, as `shape_of_script`."""
    return shape_of_script(path.read_bytes())


def shape_of_script(text: bytes) -> SDF3:
    """Run a script, UTF-8, and return its shape.

    A script can make shapes and nothing else: running a stranger's script is as safe as viewing a mesh.

    Raises
    ------
    InputError
        If it makes no shape in three dimensions, or is not in the language; one line that starts with the line and
        column of the mistake.
    """
    try:
        made = _core.run_script(text)
    except ValueError as error:
        raise InputError(str(error)) from None
    return SDF3(made.expression, color=made.color)
