"""STL and OFF, parsed by trimesh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bobrossnet.adapters.part import Part, trimesh_part
from bobrossnet.errors import InputError


def read_stl(file: Path) -> list[Part]:
    """The solids of an STL, text or binary, without the normals, which it stores for faces.

    Raises
    ------
    InputError
        If it is neither as long as a binary STL says it is, nor starts like a text.
    """
    from trimesh.exchange.stl import load_stl

    size = file.stat().st_size
    with file.open("rb") as stream:
        head = stream.read(84)
        declared = int.from_bytes(head[80:84], "little")
        if size != 84 + 50 * declared and not head.lstrip().lower().startswith(b"solid"):
            raise InputError(f"expected an STL of 84 + 50·n bytes for n triangles, got {size:,} bytes")
        stream.seek(0)
        loaded: dict[str, Any] = load_stl(stream)
    solids = loaded["geometry"].values() if "geometry" in loaded else [loaded]
    return [_welded(trimesh_part(solid)) for solid in solids if "vertices" in solid]


def read_off(file: Path) -> list[Part]:
    """The one mesh of an OFF."""
    from trimesh.exchange.off import load_off

    with file.open("rb") as stream:
        return [trimesh_part(load_off(stream))]


def _welded(part: Part) -> Part:
    """The part with vertices at the same place made one: STL repeats them for every triangle."""
    rows = np.ascontiguousarray(part.vertices + 0.0)  # -0 and 0 are the same place
    places = rows.view(np.dtype((np.void, 24))).ravel()  # one item per row: ten times faster than axis=0
    _, first, inverse = np.unique(places, return_index=True, return_inverse=True)
    return Part(rows[first], inverse.reshape(-1)[part.triangles])
