"""glTF and GLB: parsed by trimesh, after what it would read wrongly or never finish is refused."""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from bobrossnet.adapters.beside import Beside
from bobrossnet.adapters.part import Part, counted, placed, trimesh_part
from bobrossnet.errors import InputError

Z_UP = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])  # (x, y, z) → (x, -z, y)
FAN = 6
DRAWN = (4, 5)  # the primitive modes that trimesh turns into triangles: triangles and strips


def read_gltf(file: Path) -> list[Part]:
    """The primitives that a glTF's scene shows, each where its nodes place it, z up.

    Raises
    ------
    InputError
        If it is compressed, quantised or larger than `MAX_ITEMS`, if its nodes do not form a tree, or if a file that
        belongs to it is missing or lies elsewhere.
    """
    return _parts(json.loads(file.read_bytes()), _Buffers(file))


def read_glb(file: Path) -> list[Part]:
    """The same, from a glTF packed into one file.

    Raises
    ------
    InputError
        Also if it is shorter than its head says.
    """
    data = file.read_bytes()
    if data[:4] != b"glTF" or len(data) < 20:
        raise InputError(f"expected a GLB, which starts with 'glTF', got {data[:4]!r}")
    size, length = struct.unpack("<8x2I", data[:16])  # of the file, and of the JSON in it
    if size > len(data) or 20 + length > size:
        raise InputError(f"expected {max(size, 20 + length):,} bytes, as its head says, got {len(data):,}")
    tree = json.loads(data[20 : 20 + length])
    buffers = _Buffers(file)
    # A buffer without a name is the chunk after the JSON, whose own head has eight bytes.
    buffers[""] = data[28 + length : size]
    for buffer in tree.get("buffers", []):
        buffer.setdefault("uri", "")
    return _parts(tree, buffers)


class _Buffers(dict[str, bytes]):
    """What a glTF's buffers hold, by their URIs, in which a space, for example, is written as %20."""

    def __init__(self, gltf: Path) -> None:
        super().__init__()
        self.beside = Beside(gltf)

    def __missing__(self, uri: str) -> bytes:
        content = self[uri] = self.beside.read(unquote(uri))
        return content


def _parts(tree: dict[str, Any], buffers: _Buffers) -> list[Part]:
    from trimesh.exchange.gltf import load_gltf

    _check_accessors(tree)
    _check_nodes(tree)
    loaded = load_gltf(io.BytesIO(json.dumps(tree).encode()), buffers, skip_materials=True)
    world = {loaded["base_frame"]: Z_UP}
    parts: list[Part] = []
    total = 0
    for edge in loaded["graph"]:  # parents come before their children
        matrix = world[edge["frame_from"]] @ edge["matrix"]
        world[edge["frame_to"]] = matrix
        stored = loaded["geometry"].get(edge.get("geometry"), {})
        if "faces" in stored:
            total = counted(total, len(stored["faces"]) + len(stored["vertices"]))
            parts.append(placed(trimesh_part(stored), matrix))
    return parts


def _check_accessors(tree: dict[str, Any]) -> None:
    """Refuse vertices and indices that aren't plainly there, or too many."""
    accessors = tree.get("accessors", [])
    total = 0
    for primitive in (p for mesh in tree.get("meshes", []) for p in mesh["primitives"]):
        mode = primitive.get("mode", 4)
        if mode == FAN:
            raise InputError("expected triangles or strips, got a triangle fan")
        used = [primitive["attributes"]["POSITION"], primitive.get("indices")] if mode in DRAWN else []
        for accessor in (accessors[index] for index in used if index is not None):
            if "bufferView" not in accessor or "sparse" in accessor:
                how = ", ".join(primitive.get("extensions", {})) or "sparse data"
                raise InputError(f"expected plain vertices and indices, got {how}; export without compression")
            if accessor.get("normalized"):
                raise InputError("expected positions in floating point, got quantised ones")
            # Counted before they are read: many small primitives can share one large accessor.
            total = counted(total, int(accessor["count"]))
    for accessor in accessors:
        if "bufferView" not in accessor:
            accessor["count"] = 0  # trimesh would allocate as many zeros as the file asks for


def _check_nodes(tree: dict[str, Any]) -> None:
    """Refuse nodes that do not form a tree, as the specification requires: they could be reached in 2ⁿ ways."""
    nodes = tree.get("nodes", [])
    children = [child for node in nodes for child in node.get("children", [])]
    scenes = tree.setdefault("scenes", [{"nodes": sorted(set(range(len(nodes))) - set(children))}])
    roots = scenes[tree.get("scene", 0)].get("nodes", [])
    if len(set(children)) < len(children) or not set(children).isdisjoint(roots):
        raise InputError("expected nodes that form a tree, got one with two parents or inside itself")
    for node in nodes:
        node.pop("camera", None)  # trimesh drops a camera's node, and with it the place of its children
