""".vm files: formulas as text, as fidget and its kin write them. core/formula/vm.h lists the operations."""

from __future__ import annotations

from pathlib import Path

from bobrossnet import _core
from bobrossnet.shapes.implicit import Implicit
from bobrossnet.support.errors import InputError


def read_vm(path: Path) -> Implicit:
    """Read a formula as a solid: the region where it is negative.

    The files have no bounds. A bounded solid of any size is kept whole; an unbounded one
    is cut by the cube from -1 to 1. A formula without z is a flat shape: it becomes an extrusion of height 0.1 about
    z = 0, cut by the square from -1 to 1.

    Raises
    ------
    InputError
        If a line is invalid; one line that starts with its number.
    """
    try:
        formula, bounds, cut = _core.vm_solid(_core.parse_vm(path.read_bytes()))
    except ValueError as error:
        raise InputError(str(error)) from None
    if cut:
        return Implicit(formula, bounds)
    return Implicit(formula) if bounds is None else Implicit.within(formula, bounds)
