"""Colours and textures of a 3MF: groups of them, which triangles and their corners choose from."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.opc import Package
from bobrossnet.adapters.part import Part
from bobrossnet.adapters.surface import Pictures, Surface, Texture
from bobrossnet.color import linear
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import one_line, warn_of

Swatch: TypeAlias = tuple[str, str]
"""Id of a group of colours, and the number of a colour in it."""

RGB: TypeAlias = tuple[float, float, float]


def numbers(words: Iterable[str | list[str]]) -> NDArray[np.float64]:
    try:
        return np.array(words, dtype=np.float64)
    except ValueError as error:
        raise InputError(f"expected numbers, got others ({error})") from error


class Textures(dict[str, Texture | None]):
    """Pictures in a 3MF by path; None, with a warning, for an unreadable one."""

    def __init__(self, package: Package) -> None:
        super().__init__()
        self.package, self.pictures = package, Pictures()

    def __missing__(self, path: str) -> Texture | None:
        texture = None
        try:
            info = self.package.part(path)
            if info is None:
                raise InputError("expected a picture in the file, found none of that name")
            self.package.count("pictures", info)
            texture = Texture(self.pictures.decoded(self.package.archive.read(info)))
        except InputError as error:
            warn_of(self.package.file, f"texture {one_line(path) or 'without a path'} was left out: {error}")
        self[path] = texture
        return texture


class Palette:
    """The colours of a model, and places on its textures, by the ids of their groups and their numbers there."""

    def __init__(self, textures: Textures) -> None:
        self.textures = textures
        self.pictures: dict[str, tuple[str, str, str]] = {}
        """Path and wrap modes, by the ids of textures."""
        self.picture_of: dict[str, str] = {}
        """Ids of textures, by groups of places on them."""
        self.flat: set[str] = set()
        """Groups of base materials. These do not blend: the first corner's applies to the triangle."""
        self.colors: dict[Swatch, RGB] = {}
        self.places: dict[Swatch, list[str]] = {}
        self.mixed: list[RGB] = []
        """Components of the mixtures of the current group."""
        self.group, self.count = "", 0

    def start(self, group: str, picture: str | None = None, *, flat: bool = False) -> None:
        """Begin a group, of colours or of places on a texture."""
        self.group, self.count = group, 0
        if picture is not None:
            self.picture_of[group] = picture
        if flat:
            self.flat.add(group)

    def add(self, color: str) -> None:
        """Add a colour to the group: sRGB as #rrggbb or #rrggbbaa; white if it is another."""
        with suppress(InputError):
            self.colors[self.group, str(self.count)] = linear("color", color[:7])
        self.count += 1

    def start_mixtures(self, group: str, of: str, numbers_of: str) -> None:
        """Begin a group of mixtures of another group's colours."""
        self.start(group)
        self.mixed = [self.colors.get((of, number), (1.0, 1.0, 1.0)) for number in numbers_of.split()]

    def add_mixture(self, shares: str) -> None:
        """Add a mixture to the group, by its shares; white if the shares are invalid."""
        weights = numbers(shares.split())
        if len(weights) == len(self.mixed) and weights.min(initial=0) >= 0 and 0 < weights.sum() < np.inf:
            red, green, blue = (weights / weights.sum() @ np.array(self.mixed)).tolist()
            self.colors[self.group, str(self.count)] = red, green, blue
        self.count += 1

    def add_place(self, place: list[str]) -> None:
        """Add a place on its texture to the group."""
        self.places[self.group, str(self.count)] = place
        self.count += 1

    def of(self, swatches: Sequence[Swatch]) -> list[RGB]:
        """Return the linear RGB of each swatch of an element; white for a missing one."""
        if swatches and swatches[0][0] in self.flat:
            swatches = [swatches[0]] * len(swatches)
        return [self.colors.get(swatch, (1.0, 1.0, 1.0)) for swatch in swatches or [("", "")]]

    def parts(
        self, vertices: NDArray[np.float64], triangles: NDArray[np.int64], chosen: Sequence[tuple[Swatch, ...]]
    ) -> list[Part]:
        """An object in a part for each of its textures, and one for the rest."""
        rows_of: dict[str | None, list[int]] = {None: []}
        if self.picture_of:
            for row, swatches in enumerate(chosen):
                rows_of.setdefault(self.picture_of.get(swatches[0][0]) if swatches else None, []).append(row)
        if len(rows_of) == 1:
            return [self._colored(vertices, triangles, chosen)]
        parts = []
        for picture, rows in rows_of.items():
            own, looks = triangles[rows], [chosen[row] for row in rows]
            if picture is None:
                parts.append(self._colored(vertices, own, looks))
            else:
                parts.append(self._laid(vertices, own, looks, picture))
        return parts

    def _colored(
        self, vertices: NDArray[np.float64], triangles: NDArray[np.int64], chosen: Sequence[tuple[Swatch, ...]]
    ) -> Part:
        """Return a part with one colour per triangle, or per corner if corners differ; corners then become vertices."""
        if not self.colors:
            return Part(vertices, triangles)
        looks = {swatches: (self.of(swatches) * 3)[:3] for swatches in set(chosen)}
        if all(a == b == c for a, b, c in looks.values()):
            face_colors = np.array([looks[swatches][0] for swatches in chosen]).reshape(-1, 3)
            return Part(vertices, triangles, face_colors=face_colors)
        colors = np.array([looks[swatches] for swatches in chosen]).reshape(-1, 3)
        return _corners(vertices, triangles)._replace(colors=colors)

    def _laid(
        self,
        vertices: NDArray[np.float64],
        triangles: NDArray[np.int64],
        chosen: Sequence[tuple[Swatch, ...]],
        picture: str,
    ) -> Part:
        """Return a textured part, with one vertex per corner."""
        path, *wrap = self.pictures.get(picture, ("", "repeat", "repeat"))
        texture = self.textures[path]
        none = ["nan", "nan"]
        uv = numbers([self.places.get(swatch, none) for own in chosen for swatch in (own * 3)[:3]]).reshape(-1, 2)
        return _corners(vertices, triangles)._replace(
            uv=uv * (1, -1) + (0, 1),  # a 3MF counts from the bottom up
            surface=Surface(texture=texture and texture._replace(wrap=(wrap[0], wrap[1]))),
        )


def _corners(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> Part:
    """Return a part with one vertex per corner, NaN for a missing vertex."""
    corners = triangles.reshape(-1)
    points = np.vstack([vertices, np.full(3, np.nan)])
    inside = (corners >= 0) & (corners < len(vertices))
    return Part(points[np.where(inside, corners, -1)], np.arange(len(corners)).reshape(-1, 3))
