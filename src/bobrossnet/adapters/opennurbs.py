"""Trims of breps, out of an openNURBS archive.

rhino3dm 8.35 has the loops and trims of a face, but not the curves in the surface's parameters that they run along.
The archive that it makes of a brep holds them: a tree of chunks, each a type code, a length and as many bytes, laid out
as the openNURBS toolkit writes it (opennurbs_brep_io.cpp). It is split here, and each curve handed back to rhino3dm.
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
"""Types of loops that bound a face. Slits enclose nothing; curves and points on a surface only lie there."""


class Trim(NamedTuple):
    """A stretch of a curve in (u, v), perhaps run backwards."""

    curve: int
    start: float
    end: float
    backwards: bool


def brep_loops(brep: Any) -> list[list[list[Any]]]:
    """The curves that bound each face of a rhino3dm brep.

    Returns
    -------
    For each face its loops, for each loop the rhino3dm curves in the surface's (u, v), end to end.

    Raises
    ------
    InputError
        If the archive is not laid out as known, or a part of it misses another.
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
            raise InputError("expected a curve of which a part can be cut out, got another")
        return curve

    bounds = []
    for face in faces:
        found = [loops[_index(loop)] for loop in face]
        if not any(kind == OUTER for kind, _ in found):
            raise InputError("expected an outer loop around each face, found none")
        bounds.append([[decoded(trims[_index(i)]) for i in loop] for kind, loop in found if kind in (OUTER, INNER)])
    return bounds


class _Chunk:
    """The bytes of a chunk, read from its start on; whatever reaches past its end raises struct.error."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.at = 0

    def take(self, layout: str) -> tuple[Any, ...]:
        values = struct.unpack_from("<" + layout, self.data, self.at)
        self.at += struct.calcsize("<" + layout)
        return values

    def chunk(self, expected: int) -> _Chunk:
        """The chunk that begins here, which ends before the one that is read next."""
        code, length = self.take("Iq")
        if code != expected:
            raise InputError(f"expected chunk {expected:#x}, got {code:#x}")
        (content,) = self.take(f"{length}s")
        return _Chunk(content[:-4] if code & ENDS_WITH_CRC else content)

    def bytes_of_chunk(self, expected: int) -> bytes:
        """The chunk that begins here, with its code and length."""
        start = self.at
        self.chunk(expected)
        return self.data[start : self.at]

    def indices(self) -> tuple[int, ...]:
        """A list of integers, after their number."""
        return self.take(f"{self.take('i')[0]}i")

    def table(self) -> range:
        """The numbers of the rows of a table, of which this is the chunk."""
        _check_version(self, 1)
        return range(self.take("i")[0])


def _check_version(chunk: _Chunk, major: int) -> None:
    """Refuse other major versions; minor ones append to what is there."""
    (version,) = chunk.take("B")
    if version >> 4 != major:
        raise InputError(f"expected version {major}, got {version >> 4}")


def _index(value: int) -> int:
    """An index, of which -1 means that there is none."""
    if value < 0:
        raise InputError(f"expected an index, got {value}")
    return value


def _curves(chunk: _Chunk) -> list[bytes]:
    return [chunk.bytes_of_chunk(OBJECT) if chunk.take("i")[0] else b"" for _ in chunk.table()]


def _trims(chunk: _Chunk) -> list[Trim]:
    trims = []
    for _ in chunk.table():
        # Passed over: its own index; edge, vertices, direction, types, loop, tolerances and domain; what is old.
        _, curve, start, end = chunk.take("2i2d")
        chunk.take("7i4d")
        (backwards,) = chunk.take("?31x")
        chunk.take("2d")
        trims.append(Trim(curve, start, end, backwards))
    return trims


def _loops(chunk: _Chunk) -> list[tuple[int, tuple[int, ...]]]:
    """Type and trims of each loop."""
    loops = []
    for _ in chunk.table():
        chunk.take("i")
        trims = chunk.indices()
        kind, _ = chunk.take("2i")
        loops.append((kind, trims))
    return loops


def _faces(chunk: _Chunk) -> list[tuple[int, ...]]:
    """Loops of each face."""
    faces = []
    for _ in chunk.table():
        chunk.take("i")
        faces.append(chunk.indices())
        chunk.take("3i")
    return faces
