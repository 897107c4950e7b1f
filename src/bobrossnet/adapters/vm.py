""".vm files: formulas as text, as fidget and its kin write them. core/formula/vm.h lists the operations."""

from __future__ import annotations

from pathlib import Path

from bobrossnet import _core
from bobrossnet.errors import InputError
from bobrossnet.shapes.implicit import Implicit

# What fidget's viewer shows.
CUBE = ((-1, -1, -1), (1, 1, 1))

HEIGHT = 0.1
# Higher than what formulas in two dimensions are extruded to, so that their ends are the shape's and not the box's.
SQUARE = ((-1, -1, -HEIGHT), (1, 1, HEIGHT))


def read_vm(path: Path) -> Implicit:
    """Read a formula, and make of it the shape that is inside where it is negative.

    The files say nothing about where to look. A bounded shape is taken whole, however large it is; one without bounds
    is cut by the cube from -1 to 1. A formula without z is a flat shape: it becomes an extrusion of height 0.1 about
    z = 0, cut by the square from -1 to 1.

    Raises
    ------
    InputError
        If a line is not such a file's; one line that starts with its number.
    """
    try:
        expression = _core.parse_vm(path.read_bytes())
        flat = None if expression.uses("z") else _extruded(expression)
    except ValueError as error:
        raise InputError(str(error)) from None
    if flat is not None:
        return Implicit(flat, SQUARE)
    try:
        _core.find_bounds(expression)
    except ValueError:
        return Implicit(expression, CUBE)
    return Implicit(expression)


def _extruded(expression: _core.Expression) -> _core.Expression:
    """max(f(x, y), |z| - height / 2)."""
    graph = _core.Graph()
    z = graph.z()
    sides = graph.substitute(expression, graph.x(), graph.y(), z)
    ends = graph.binary("subtract", graph.unary("absolute", z), graph.constant(HEIGHT / 2))
    return graph.expression(graph.binary("maximum", sides, ends))
