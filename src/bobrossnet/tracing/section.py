"""Sections: planes that cut scenes open."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.shapes.affine import Matrix, Point
from bobrossnet.support.errors import (
    InputError,
    InputTypeError,
    brief,
    check_direction,
    check_number,
    each_of,
)

MAX_SECTIONS: int = _core.MAX_SECTIONS
"""Maximum number of sections of a scene: the six sides of a box."""

PATTERN = re.compile(
    r"\s*([xyz])\s*(<=|>=|=|<|>)\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[-+]?[0-9]+)?)\s*", re.IGNORECASE
)
"""A section as text; viewer/tracing/section.js has the same."""


@dataclass(frozen=True, init=False)
class Section:
    """A plane that cuts a scene open: it keeps the points p of normal · p <= offset.

    So the normal points out of the cut, towards its viewer. As text, a section is an axis, a relation and a number in
    the scene's unit: `"x<=2"` and `"x<2"` keep the side of smaller x, `"x>2"` the other side. `"x=2"` means `"x<=2"`:
    the default camera, and every other one from the front, right and above, then looks at the cut.

    Where the plane cuts a solid, a cap closes it: with the colour of the part, and hatched. Surfaces in the plane
    itself, within 4e-6 of the scene's radius, belong to the side that is removed.

    Parameters
    ----------
    normal : (x, y, z), or text
        A nonzero vector in the scene's coordinates; or the whole section as text.
    offset : number
        Distance of the plane from the scene's origin along the normal, in lengths of the normal.

    Raises
    ------
    InputError
        If a value is out of range or not a number, or the text is not a section.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> bob.Section((0, 0, 2), 3)
    Section(normal=(0.0, 0.0, 1.0), offset=1.5)
    >>> bob.Section("z>1")
    Section(normal=(-0.0, -0.0, -1.0), offset=-1.0)
    >>> picture = bob.render(bob.happy_tree(), size="160x120", section="x=0")
    """

    normal: tuple[float, float, float]
    """Unit vector, out of the kept side."""
    offset: float

    def __init__(self, normal: Any, offset: float | None = None) -> None:
        if isinstance(normal, str):
            if offset is not None:
                raise InputError("offset: expected none with a section as text")
            normal, offset = _parsed(normal)
        vector, length = check_direction("normal", normal)
        distance = 0.0 if offset is None else check_number("offset", offset)
        x, y, z = vector.tolist()
        object.__setattr__(self, "normal", (x, y, z))
        object.__setattr__(self, "offset", check_number("offset", distance / length))

    def transformed(self, matrix: Matrix) -> Section:
        """Return the section of a scene moved by a rotation and a translation, a (4, 4) matrix."""
        normal = matrix[:3, :3] @ self.normal
        return Section(normal, self.offset + float(normal @ matrix[:3, 3]))

    def scaled(self, factor: float) -> Section:
        """Return the section of a scene scaled about its origin."""
        return Section(self.normal, factor * self.offset)

    def __str__(self) -> str:
        """Its text with four digits, such as "x=0"; the normal and the offset if it is oblique."""
        axis, offset = self.axis()
        if axis is None:
            return f"({', '.join(f'{x:.3g}' for x in self.normal)}) {self.offset:.4g}"
        return f"{'xyz'[axis]}{'=' if self.normal[axis] > 0 else '>'}{offset:.4g}"

    def axis(self) -> tuple[int | None, float]:
        """Return the axis along the normal, None if it is oblique, and the coordinate of the plane."""
        axis = int(np.argmax(np.abs(self.normal)))
        if not np.allclose(np.delete(self.normal, axis), 0, atol=1e-9):
            return None, self.offset
        return axis, self.offset * float(np.sign(self.normal[axis])) + 0.0

    def plane(self, center: Point, radius: float) -> list[float]:
        """The plane in the unit sphere of a scene, as the core has it: the normal and the offset."""
        return [*self.normal, (self.offset - float(np.dot(self.normal, center))) / radius]

    def axes(self) -> NDArray[np.float64]:
        """(2, 3): unit vectors to the right and up in the plane, seen against the normal."""
        normal = np.array(self.normal)
        right = np.cross((0.0, 0.0, 1.0) if abs(normal[2]) < 0.9 else (0.0, 1.0, 0.0), normal)
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(normal, right)])


SectionLike: TypeAlias = Section | str | Iterable[Section | str] | None
"""A section, its text, several of them, or None."""


def check_sections(section: SectionLike) -> tuple[Section, ...]:
    """Return the sections of an argument; what all of them keep is seen."""
    if section is None:
        return ()
    if isinstance(section, Section | str):
        return (_section(section),)
    if not isinstance(section, Iterable):
        raise InputTypeError(f"section: expected a Section, a text such as 'x=0' or several, got {brief(section)}")
    several = tuple(_section(one) for one in each_of("section", section, "a Section, a text such as 'x=0' or several"))
    if len(several) > MAX_SECTIONS:
        raise InputError(f"section: expected at most {MAX_SECTIONS}, got {len(several)}")
    return several


def _section(section: Any) -> Section:
    if isinstance(section, Section):
        return section
    if isinstance(section, str):
        return Section(section)
    raise InputTypeError(f"section: expected a Section or a text such as 'x=0', got {brief(section)}")


def _parsed(text: str) -> tuple[NDArray[np.float64], float]:
    match = PATTERN.fullmatch(text)
    expected = "expected an axis, a relation and a number, such as 'x=0', 'z>3' or 'y<=-1.5'"
    if match is None:
        raise InputError(f"section: {expected}, got {brief(text, of_type=False)}")
    try:
        offset = check_number("section", float(match[3]))
    except ValueError:  # InputError, too
        raise InputError(f"section: {expected}, got {brief(text, of_type=False)}") from None
    normal: NDArray[np.float64] = np.eye(3)["xyz".index(match[1].lower())]
    return (-normal, -offset) if match[2].startswith(">") else (normal, offset)
