"""NURBS for training: vessels and hulls, sheets, tubes, and solids of trimmed faces."""

from __future__ import annotations

from collections.abc import Callable

from bobrossnet.learn.shapes.splines import sheets, solids, vessels, wires
from bobrossnet.learn.shapes.splines.parts import Rng
from bobrossnet.tracing.scene import SceneLike

FAMILIES: dict[str, Callable[[Rng], SceneLike]] = {
    family.__name__: family
    for family in (
        vessels.vessel,
        vessels.still_life,
        vessels.ship,
        vessels.car,
        vessels.aircraft,
        vessels.blob,
        vessels.toy,
        sheets.terrain,
        sheets.drapery,
        sheets.pierced,
        sheets.flower,
        sheets.ribbon,
        sheets.impeller,
        wires.pipes,
        wires.spring,
        wires.basket,
        wires.scaffold,
        wires.bicycle,
        wires.cables,
        wires.branches,
        wires.knot,
        wires.chair,
        solids.bracket,
        solids.letters,
        solids.gears,
        solids.house,
        solids.engine,
    )
}
"""Families; each takes a generator and returns shapes of any size and position."""
