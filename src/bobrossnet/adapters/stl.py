"""STL and OFF, parsed by trimesh."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from bobrossnet.adapters.part import Part, converted, trimesh_part
from bobrossnet.support.errors import InputError


def read_stl(file: Path) -> list[Part]:
    """The solids of an STL, text or binary, without the normals, which it stores for faces.

    Raises
    ------
    InputError
        If it is neither as long as a binary STL says it is, nor starts like a text.
    """
    from trimesh.exchange.stl import load_stl_ascii, load_stl_binary

    data = file.read_bytes()
    declared = int.from_bytes(data[80:84], "little")
    loaded: dict[str, Any]
    if len(data) == 84 + 50 * declared:
        loaded = load_stl_binary(io.BytesIO(bytes(80) + data[80:]))  # the header may hold anything
    elif data[:84].lstrip().lower().startswith(b"solid"):
        with _errors_of("facets of three vertices, each of three numbers"):
            loaded = load_stl_ascii(_ascii(data))
    else:
        raise InputError(f"expected an STL of 84 + 50·n bytes for n triangles, got {len(data):,} bytes")
    solids = loaded["geometry"].values() if "geometry" in loaded else [loaded]
    return [_welded(trimesh_part(solid)) for solid in solids if "vertices" in solid]


def read_off(file: Path) -> list[Part]:
    """The one mesh of an OFF."""
    from trimesh.exchange.off import load_off

    data = file.read_bytes()
    with _errors_of("counts, vertices and faces, all of them numbers"):
        return [trimesh_part(load_off(_ascii(data)))]


@contextmanager
def _errors_of(expected: str) -> Iterator[None]:
    """What trimesh says of texts that it can't read, behind what it wants of them."""
    try:
        yield
    except (ValueError, IndexError, TypeError, OverflowError, NameError) as error:
        raise InputError(f"expected {expected}, got something else ({error})") from error


def _ascii(data: bytes) -> io.BytesIO:
    """A text without what its names and comments have beyond ASCII: trimesh wants a package to guess encodings."""
    return io.BytesIO(data.decode("ascii", "replace").replace("\ufffd", "?").encode())


def _welded(part: Part) -> Part:
    """The part with vertices at the same place made one: STL repeats them for every triangle."""
    rows = converted(part.vertices, np.float64)
    rows += 0.0  # -0 and 0 are the same place
    # Sorted by their bytes, two at a time: numpy takes two in one quick pass, and between passes, Ctrl-C is noticed.
    order = np.arange(len(rows))
    for digits in reversed(rows.view(">u2").T):
        if digits.size and digits.min() < digits.max():  # of numbers that were float32, a third
            order = order[np.argsort(digits.astype(np.uint16)[order], kind="stable")]
    starts = np.ones(len(rows), dtype=bool)
    starts[1:] = False
    for bits in rows.view(np.uint64).T:
        key = bits[order]
        starts[1:] |= key[1:] != key[:-1]
    place = np.empty(len(rows), dtype=np.int64)
    place[order] = np.cumsum(starts) - 1
    return Part(rows[order[starts]], place[part.triangles])
