"""glTF and GLB: meshes parsed by trimesh, after what it would read wrongly or never finish is refused."""

from __future__ import annotations

import binascii
import io
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.beside import Beside
from bobrossnet.adapters.gltf_surfaces import GltfSurfaces
from bobrossnet.adapters.json import numbers, read_json
from bobrossnet.adapters.part import Part, counted, placed, trimesh_part
from bobrossnet.adapters.surface import Surface
from bobrossnet.support.errors import InputError, check_array, check_integer
from bobrossnet.support.messages import errors_at
from bobrossnet.support.paths import MAX_BYTES
from bobrossnet.tracing.scene import MAX_INSTANCES

Z_UP = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])  # (x, y, z) → (x, -z, y)
FAN = 6
LISTS = ("buffers", "bufferViews", "accessors", "meshes", "nodes", "scenes")
TYPES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
SIZES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}  # bytes of the component types
COLORS, UV, MATERIAL = "_COLORS", "_UV", "_MATERIAL_"
PLACES = {"matrix": 16, "translation": 3, "rotation": 4, "scale": 3}
DRAWN = (4, 5)  # the primitive modes that trimesh turns into triangles: triangles and strips


def read_gltf(file: Path) -> list[Part]:
    """The primitives that a glTF's scene shows, each where its nodes place it, z up.

    Raises
    ------
    InputError
        If it is compressed, quantised or larger than `MAX_ITEMS`, if it has more than `MAX_INSTANCES` nodes or
        primitives, if its nodes do not form a tree, or if a file that belongs to it is missing or lies elsewhere.
    """
    return _parts(read_json(file.read_bytes()), _Buffers(file))


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
    version, size, length, kind = struct.unpack("<4x3I4s", data[:20])  # of the file, and of the JSON in it
    if version != 2:
        raise InputError(f"expected a GLB of version 2, got {version}")
    if size > len(data) or 20 + length > size:
        raise InputError(f"expected {max(size, 20 + length):,} bytes, as its head says, got {len(data):,}")
    if kind != b"JSON":
        raise InputError(f"expected a first chunk of JSON, got one of {kind!r}")
    tree = read_json(data[20 : 20 + length])
    _check_lists(tree)
    buffers = _Buffers(file)
    # A buffer without a name is the chunk after the JSON, if that is of this kind; chunks of other kinds do not matter.
    buffers[""] = b""
    start = 28 + length
    if start <= size:
        length, kind = struct.unpack("<I4s", data[start - 8 : start])
        if kind == b"BIN\0":
            if start + length > size:
                raise InputError(f"expected {start + length:,} bytes, as a chunk's head says, got {size:,}")
            buffers[""] = data[start : start + length]
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

    _check_lists(tree)
    _check_layout(tree)
    _check_accessors(tree)
    _check_nodes(tree)
    surfaces = GltfSurfaces(buffers.beside.model, tree, buffers)
    for primitive in (primitive for mesh in tree.get("meshes", []) for primitive in mesh["primitives"]):
        _hand_over_colors(primitive, surfaces)
    try:
        loaded = load_gltf(io.BytesIO(json.dumps(tree).encode()), buffers, skip_materials=True)
    except AssertionError as error:
        raise InputError("expected buffers that hold what the bufferViews say, got one that is shorter") from error
    except binascii.Error as error:
        raise InputError(f"expected buffers in base64, got something else ({error})") from error
    world = {loaded["base_frame"]: Z_UP}
    parts: list[Part] = []
    total = 0
    for edge in loaded["graph"]:  # parents come before their children
        matrix = world[edge["frame_from"]] @ edge["matrix"]
        world[edge["frame_to"]] = matrix
        stored = loaded["geometry"].get(edge.get("geometry"), {})
        if "faces" in stored:
            total = counted(total, len(stored["faces"]) + len(stored["vertices"]))
            part = _colored(trimesh_part(stored), stored, surfaces)
            if (part.surface.alpha_cutoff or 0) <= 1:  # else all of it is cut out
                parts.append(placed(part, matrix))
    return parts


def _hand_over_colors(primitive: dict[str, Any], surfaces: GltfSurfaces) -> None:
    """Let trimesh hand over what it would turn into visuals of its own: attributes whose names start with "_"."""
    attributes = primitive["attributes"]
    for name in [name for name in attributes if name.startswith("_")]:
        del attributes[name]
    if "COLOR_0" in attributes:
        attributes[COLORS] = attributes.pop("COLOR_0")
    if "material" in primitive:
        material = primitive.pop("material")
        attributes[f"{MATERIAL}{surfaces.index(material)}"] = attributes["POSITION"]
        uv = attributes.get(f"TEXCOORD_{surfaces.uv_set(material)}")
        if uv is not None:
            attributes[UV] = uv


def _colored(part: Part, stored: dict[str, Any], surfaces: GltfSurfaces) -> Part:
    """The part with what `_hand_over_colors` made trimesh hand over."""
    found = stored.get("vertex_attributes", {})
    material = next((int(name.removeprefix(MATERIAL)) for name in found if name.startswith(MATERIAL)), None)
    colors, uv = (_normalized(found.get(name)) for name in (COLORS, UV))
    if colors is not None and colors.ndim != 2:
        colors = None
    return part._replace(
        colors=None if colors is None else colors[:, :3],
        alphas=None if colors is None or material is None else surfaces.alphas(material, colors),
        uv=uv if uv is None or material is None else surfaces.on_texture(material, uv),
        surface=Surface() if material is None else surfaces[material],
    )


def _normalized(values: NDArray[Any] | None) -> NDArray[np.float64] | None:
    """Numbers in 0..1 of integers, which stand for these."""
    if values is None:
        return None
    return np.asarray(values, np.float64) / (1 if values.dtype.kind == "f" else np.iinfo(values.dtype).max)


def _check_lists(tree: Any) -> None:
    """Refuse a tree whose top levels are not as the specification says."""
    if not isinstance(tree, dict):
        raise InputError(f"expected a glTF, which is an object, got {type(tree).__name__}")
    asset = tree.get("asset")
    version = asset.get("version") if isinstance(asset, dict) else None
    if not (isinstance(version, str) and version.startswith("2.")):
        raise InputError(f"asset: expected version 2.0, got {version}")
    for name in LISTS:
        items = tree.get(name, [])
        if not (isinstance(items, list) and all(isinstance(item, dict) for item in items)):
            raise InputError(f"{name}: expected a list of objects, got another")
    _check_count("nodes", len(tree.get("nodes", [])))


def _check_count(name: str, count: int) -> None:
    if count > MAX_INSTANCES:
        raise InputError(f"{name}: expected at most {MAX_INSTANCES:,}, got {count:,}")


def _check_layout(tree: dict[str, Any]) -> None:
    """Refuse what refers to something that isn't there."""

    def index(what: str, value: Any, of: str) -> dict[str, Any]:
        found: dict[str, Any] = tree.get(of, [])[check_integer(what, value, 0, len(tree.get(of, [])) - 1)]
        return found

    for i, buffer in enumerate(tree.get("buffers", [])):
        if not isinstance(buffer.get("uri"), str):
            raise InputError(f"buffers[{i}]: expected a uri, got {buffer.get('uri')}")
    for i, view in enumerate(tree.get("bufferViews", [])):
        with errors_at(f"bufferViews[{i}]"):
            index("buffer", view.get("buffer"), "buffers")
            check_integer("byteLength", view.get("byteLength"), 1, MAX_BYTES)
            check_integer("byteOffset", view.get("byteOffset", 0), 0, MAX_BYTES)
            check_integer("byteStride", view.get("byteStride", 4), 1, MAX_BYTES)
    for i, accessor in enumerate(tree.get("accessors", [])):
        with errors_at(f"accessors[{i}]"):
            _check_accessor(accessor, index)
    for i, mesh in enumerate(tree.get("meshes", [])):
        with errors_at(f"meshes[{i}]"):
            for primitive in _objects(mesh, "primitives"):
                attributes = primitive.get("attributes")
                if not isinstance(attributes, dict) or "POSITION" not in attributes:
                    raise InputError("attributes: expected a POSITION, got none")
                for name, value in attributes.items():
                    index(name, value, "accessors")
                for name in attributes.keys() & {"POSITION", "NORMAL"}:
                    if index(name, attributes[name], "accessors")["type"] != "VEC3":
                        raise InputError(f"{name}: expected vectors of type VEC3, got another")
                check_integer("mode", primitive.get("mode", 4), 0, FAN)
                if "indices" in primitive:
                    index("indices", primitive["indices"], "accessors")
    for i, node in enumerate(tree.get("nodes", [])):
        with errors_at(f"nodes[{i}]"):
            for child in _integers(node, "children"):
                index("children", child, "nodes")
            if "mesh" in node:
                index("mesh", node["mesh"], "meshes")
            for name in node.keys() & PLACES.keys():
                check_array(name, numbers(name, node[name]), (PLACES[name],))
    if "scenes" in tree:
        for root in _integers(index("scene", tree.get("scene", 0), "scenes"), "nodes"):
            index("nodes", root, "nodes")


def _check_accessor(accessor: dict[str, Any], index: Callable[[str, Any, str], dict[str, Any]]) -> None:
    kind, component = accessor.get("type"), accessor.get("componentType")
    if kind not in [*TYPES] or component not in [*SIZES]:
        raise InputError(f"expected a type such as VEC3 and a componentType such as 5126, got {kind} and {component}")
    check_integer("count", accessor.get("count"), 0, 1 << 53)
    check_integer("byteOffset", accessor.get("byteOffset", 0), 0, MAX_BYTES)
    if "bufferView" in accessor:
        index("bufferView", accessor["bufferView"], "bufferViews")


def _objects(item: dict[str, Any], name: str) -> list[dict[str, Any]]:
    values = item.get(name)
    if not (isinstance(values, list) and all(isinstance(value, dict) for value in values)):
        raise InputError(f"{name}: expected a list of objects, got another")
    return values


def _integers(item: dict[str, Any], name: str) -> list[Any]:
    values = item.get(name, [])
    if not isinstance(values, list):
        raise InputError(f"{name}: expected a list, got {type(values).__name__}")
    return values


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
            total = counted(total, accessor["count"])
    for i, accessor in enumerate(accessors):
        if "bufferView" not in accessor:
            accessor["count"] = 0  # trimesh would allocate as many zeros as the file asks for
        elif accessor["count"]:
            view = tree["bufferViews"][accessor["bufferView"]]
            size = SIZES[accessor["componentType"]] * TYPES[accessor["type"]]
            end = accessor.get("byteOffset", 0) + (accessor["count"] - 1) * view.get("byteStride", size) + size
            if end > view["byteLength"]:
                raise InputError(f"accessors[{i}]: expected {end:,} bytes in its view, got {view['byteLength']:,}")


def _check_nodes(tree: dict[str, Any]) -> None:
    """Refuse nodes that do not form a tree, as the specification requires: they could be reached in 2ⁿ ways. Refuse
    more primitives than a scene has instances, in the meshes or as often as nodes place them."""
    nodes, meshes = tree.get("nodes", []), tree.get("meshes", [])
    for users in (meshes, [meshes[node["mesh"]] for node in nodes if "mesh" in node]):
        _check_count("primitives", sum(len(mesh["primitives"]) for mesh in users))
    children = [child for node in nodes for child in node.get("children", [])]
    scenes = tree.setdefault("scenes", [{"nodes": sorted(set(range(len(nodes))) - set(children))}])
    roots = scenes[tree.get("scene", 0)].get("nodes", [])
    if len(set(children)) < len(children) or not set(children).isdisjoint(roots):
        raise InputError("expected nodes that form a tree, got one with two parents or inside itself")
    for node in nodes:
        node.pop("camera", None)  # trimesh drops a camera's node, and with it the place of its children
    for item in (*nodes, *meshes):
        item.pop("name", None)  # trimesh takes quadratic time to make some names unique
