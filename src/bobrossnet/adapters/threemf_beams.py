"""Beam lattices of a 3MF as tubes: a beam is straight, between two vertices; a ball is a tube of length 0."""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.threemf_colors import RGB, Palette, Swatch, numbers
from bobrossnet.shapes.affine import MAX_COORDINATE
from bobrossnet.shapes.tube import Tube, segments


class Lattice:
    """The beams and balls of one object. The lattice's attributes override the object's."""

    def __init__(self, attributes: dict[str, str], of_object: dict[str, str]) -> None:
        self.get = {name: of_object[name] for name in ("pid", "pindex") if name in of_object} | attributes
        self.radius = attributes.get("radius", "nan")
        self.ends: list[list[str]] = []
        """Two vertices and two radii of each beam."""
        self.chosen: list[tuple[Swatch, ...]] = []
        self.caps: Counter[str] = Counter()
        self.balls: dict[str, tuple[str, tuple[Swatch, ...]]] = {}
        """Radii and colours, by vertices."""

    def add_beam(self, get: dict[str, str], v1: str, v2: str) -> None:
        r1 = get.get("r1", self.radius)
        self.ends.append([v1, v2, r1, get.get("r2", r1)])
        cap = self.get.get("cap", "sphere")
        self.caps.update((get.get("cap1", cap), get.get("cap2", cap)))
        group, first = get.get("pid", self.get.get("pid", "")), get.get("p1")
        self.chosen.append(() if first is None else ((group, first), (group, get.get("p2", first))))

    def add_ball(self, get: dict[str, str], vertex: str) -> None:
        group, number = get.get("pid", self.get.get("pid", "")), get.get("p")
        radius = get.get("r", self.ball("ballradius", self.radius))
        self.balls[vertex] = radius, () if number is None else ((group, number),)

    def ball(self, name: str, default: str) -> str:
        """Return an attribute about balls, with or without their namespace."""
        return next((value for key, value in self.get.items() if key.rpartition("}")[2] == name), default)

    def tubes(self, vertices: NDArray[np.float64], palette: Palette, left: Counter[str]) -> list[tuple[Tube, RGB]]:
        """Return one tube per colour; `left` counts missing and approximated beams and balls."""
        default = (self.get.get("pid", ""), self.get.get("pindex", ""))
        ends, looks = list(self.ends), list(self.chosen)
        mode = self.ball("ballmode", "none")
        if mode == "all":
            radius = self.ball("ballradius", self.radius)
            for vertex in dict.fromkeys(vertex for beam in self.ends for vertex in beam[:2]):
                self.balls.setdefault(vertex, (radius, ()))
        if mode != "none":
            for vertex, (radius, look) in self.balls.items():
                ends.append([vertex, vertex, radius, radius])
                looks.append(look)

        values = numbers(ends).reshape(-1, 4)
        pairs, radii = values[:, :2], values[:, 2:]
        inside = ((pairs >= 0) & (pairs < len(vertices))).all(axis=1)  # not if NaN
        points = np.full((len(ends), 2, 3), np.nan)
        points[inside] = vertices[pairs[inside].astype(np.int64)]
        shown = ((np.abs(points) <= MAX_COORDINATE).all(axis=2) & (radii > 0) & (radii <= MAX_COORDINATE)).all(axis=1)
        left["beams without a vertex or a radius"] += int(np.count_nonzero(~shown))
        lengths = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
        is_beam = np.arange(len(ends)) < len(self.ends)
        shown &= ~is_beam | ((lengths >= float(numbers([self.get.get("minlength", "0")])[0])) & (lengths > 0))

        left["flat ends of beams"] += self.caps["butt"]
        if self.get.get("clippingmode", "none") != "none":
            left["clippings of beam lattices"] += 1
        rows_of: dict[RGB, list[int]] = {}
        for row in np.flatnonzero(shown):
            color = np.mean(palette.of(looks[row] or (default,)), axis=0)
            rows_of.setdefault((float(color[0]), float(color[1]), float(color[2])), []).append(int(row))
        return [(segments(points[rows], radii[rows]), color) for color, rows in rows_of.items()]
