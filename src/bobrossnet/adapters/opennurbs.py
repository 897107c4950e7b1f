"""Trims of breps, out of an openNURBS archive.

rhino3dm 8.35 returns the loops and trims of a face, but not their curves in the surface's parameters. Its archive of a
brep contains them: a tree of chunks, each a type code, a length and the bytes, in the layout of the openNURBS toolkit
(opennurbs_brep_io.cpp). This module splits the archive, and rhino3dm decodes each curve.
"""

from __future__ import annotations

import base64
import struct
from typing import Any, NamedTuple

from bobrossnet.support.errors import InputError

OBJECT = 0x00027FFA
CLASS_ID = 0x0002FFFB
CLASS_DATA = 0x0002FFFC
ANONYMOUS = 0x40008000
ENDS_WITH_CRC = 0x8000

# Archives before version 50 have lengths of 4 bytes. rhino3dm writes the newest version, whatever it has read.
FIRST_VERSION_OF_LONG_CHUNKS = 50

OUTER, INNER = 1, 2
"""Types of loops that bound a face; slits, curves and points on a surface do not."""


class Trim(NamedTuple):
    """An interval of a curve in (u, v), perhaps reversed."""

    curve: int
    start: float
    end: float
    backwards: bool


def brep_loops(brep: Any) -> list[list[list[Any]]]:
    """Return the curves that bound each face of a rhino3dm brep.

    Returns
    -------
    A list per face of lists per loop of rhino3dm curves in the surface's (u, v), end to end.

    Raises
    ------
    InputError
        If the archive has an unknown layout or a dangling index.
    """
    try:
        return _brep_loops(brep)
    except (struct.error, IndexError, KeyError, TypeError, ValueError) as error:
        raise InputError(f"expected an openNURBS brep, could not read it ({error})") from error


def _brep_loops(brep: Any) -> list[list[list[Any]]]:
    import rhino3dm

    archive = brep.Encode()
    if archive["archive3dm"] < FIRST_VERSION_OF_LONG_CHUNKS:
        raise InputError(f"expected an archive of version 50 or above, got {archive['archive3dm']}")
    stored = _Chunk(base64.b64decode(archive["data"])).chunk(OBJECT)
    stored.chunk(CLASS_ID)
    data = stored.chunk(CLASS_DATA)
    _check_version(data, 3)
    objects = _curves(data.chunk(ANONYMOUS))
    for _ in ("curves in space", "surfaces", "vertices", "edges"):
        data.chunk(ANONYMOUS)
    trims = _trims(data.chunk(ANONYMOUS))
    loops = _loops(data.chunk(ANONYMOUS))
    faces = _faces(data.chunk(ANONYMOUS))

    def decoded(trim: Trim) -> Any:
        curve = rhino3dm.CommonObject.Decode(
            {**archive, "data": base64.b64encode(objects[_index(trim.curve)]).decode()}
        )
        if not isinstance(curve, rhino3dm.Curve):
            raise InputError(f"expected a curve, got {type(curve).__name__}")
        if (trim.start, trim.end) != (curve.Domain.T0, curve.Domain.T1):
            curve = curve.Trim(trim.start, trim.end)
        if curve is None or (trim.backwards and not curve.Reverse()):
            raise InputError("expected a curve that can be trimmed, got another")
        return curve

    bounds = []
    for face in faces:
        found = [loops[_index(loop)] for loop in face]
        if not any(kind == OUTER for kind, _ in found):
            raise InputError("expected an outer loop around each face, found none")
        bounds.append([[decoded(trims[_index(i)]) for i in loop] for kind, loop in found if kind in (OUTER, INNER)])
    return bounds


class _Chunk:
    """A cursor in the bytes of a chunk; reading past its end raises struct.error."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.at = 0

    def take(self, layout: str) -> tuple[Any, ...]:
        values = struct.unpack_from("<" + layout, self.data, self.at)
        self.at += struct.calcsize("<" + layout)
        return values

    def chunk(self, expected: int) -> _Chunk:
        """Enter the chunk that begins here; its end is the start of the next one."""
        code, length = self.take("Iq")
        if code != expected:
            raise InputError(f"expected chunk {expected:#x}, got {code:#x}")
        (content,) = self.take(f"{length}s")
        return _Chunk(content[:-4] if code & ENDS_WITH_CRC else content)

    def bytes_of_chunk(self, expected: int) -> bytes:
        """Return the chunk that begins here, with its code and length."""
        start = self.at
        self.chunk(expected)
        return self.data[start : self.at]

    def indices(self) -> tuple[int, ...]:
        """Return a list of integers, stored after their count."""
        return self.take(f"{self.take('i')[0]}i")

    def table(self) -> range:
        """Return the indices of the rows of a table's chunk."""
        _check_version(self, 1)
        return range(self.take("i")[0])


def _check_version(chunk: _Chunk, major: int) -> None:
    """Refuse other major versions; minor versions only append fields."""
    (version,) = chunk.take("B")
    if version >> 4 != major:
        raise InputError(f"expected version {major}, got {version >> 4}")


def _index(value: int) -> int:
    """Return an index; -1 means a missing item."""
    if value < 0:
        raise InputError(f"expected an index, got {value}")
    return value


def _curves(chunk: _Chunk) -> list[bytes]:
    return [chunk.bytes_of_chunk(OBJECT) if chunk.take("i")[0] else b"" for _ in chunk.table()]


def _trims(chunk: _Chunk) -> list[Trim]:
    trims = []
    for _ in chunk.table():
        # Skipped: its own index; edge, vertices, direction, types, loop, tolerances, domain, obsolete fields.
        _, curve, start, end = chunk.take("2i2d")
        chunk.take("7i4d")
        (backwards,) = chunk.take("?31x")
        chunk.take("2d")
        trims.append(Trim(curve, start, end, backwards))
    return trims


def _loops(chunk: _Chunk) -> list[tuple[int, tuple[int, ...]]]:
    """Return type and trims of each loop."""
    loops = []
    for _ in chunk.table():
        chunk.take("i")
        trims = chunk.indices()
        kind, _ = chunk.take("2i")
        loops.append((kind, trims))
    return loops


def _faces(chunk: _Chunk) -> list[tuple[int, ...]]:
    """Return the loops of each face."""
    faces = []
    for _ in chunk.table():
        chunk.take("i")
        faces.append(chunk.indices())
        chunk.take("3i")
    return faces
