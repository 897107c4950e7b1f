"""Scene files, .bob: all shapes, places and materials of a scene in one file that shows the same picture everywhere.

A safetensors file; docs/reference/scene-files.md has its fields. Equal scenes make equal files.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import asdict, replace
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters import lights
from bobrossnet.adapters.json import numbers, read_json
from bobrossnet.adapters.surface import Pictures
from bobrossnet.shapes.implicit import Implicit
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.shapes.nurbs import Brep
from bobrossnet.shapes.picture import Picture
from bobrossnet.shapes.shape import Shape
from bobrossnet.shapes.tube import Tube
from bobrossnet.support.atomic import check_writable, write_whole
from bobrossnet.support.errors import InputError, InputTypeError, brief, check_array, check_flag, check_integer
from bobrossnet.support.paths import MAX_BYTES, path_of
from bobrossnet.support.tensors import tensor_file
from bobrossnet.support.units import check_unit
from bobrossnet.tracing.glass import Glass
from bobrossnet.tracing.instance import Instance
from bobrossnet.tracing.material import Material
from bobrossnet.tracing.scene import MAX_INSTANCES, Scene, SceneLike, as_scene

ENDING = ".bob"
FORMAT = "bobrossnet-scene"
VERSIONS = ("1", "2", "3", "4", "5", "6", "7", "8")
"""The second has colours of meshes, and metallicity and roughness, the third meshes in formulas, the fourth alphas of
meshes, the fifth textures that meshes share, the sixth numbers of faces, the seventh glass and clear coats, the eighth
environments. Scenes are written in the lowest sufficient version."""

PARTS = "parts"
"""The entry of the metadata that has the unit and the tree of parts; readers may pass over it."""

SHARED = "texture_of"
"""The tensor of a mesh that names the shape whose texture it has."""

KINDS: dict[str, type[Shape]] = {kind.kind: kind for kind in (Brep, Implicit, Mesh, Tube)}
"""The shapes that files can hold, by the word for them there."""

PHYSICAL = {"metallic", "roughness", "emissive"}
"""Fields of materials that came with the second version."""

CLEARCOAT = {"clearcoat", "clearcoat_roughness"}
"""Fields of materials with a clear coat, from the seventh version on."""

MATERIAL = [name for name in Material.__dataclass_fields__ if name not in PHYSICAL | CLEARCOAT]

GLASS = ("color", "roughness", "emissive", "transmission", "ior", "attenuation", "distance", "thin")
"""Fields of glass, from the seventh version on."""

# The checksum comes first, so that its place is the same in every file. It is of the whole file with its own digits
# taken as zeros.
MAX_HEADER = 100_000_000
"""Bytes of JSON that readers of safetensors take."""

PIECE = 1 << 24
"""Bytes that a checksum takes at once."""

START = b'{"__metadata__":{"sha256":"'
DIGITS = slice(8 + len(START), 8 + len(START) + 64)


def save_scene(scene: SceneLike, path: str | os.PathLike[str]) -> None:
    """Write a scene to a file, whole or not at all; `bobrossnet.load` reads it.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these
        Shapes that are equal are written once, and so are textures.
    path : path ending in .bob
        Replaced if it exists.

    Raises
    ------
    InputError
        If the file can't be written, or the scene has a shape of a kind that files can't hold, or places, materials and
        names of more than `MAX_HEADER` bytes, textures of more than `MAX_FILE_TEXELS`, or more than `MAX_BYTES` in all.
    """
    file = check_scene_path(path)
    write_whole(file, packed(scene))


def packed(scene: SceneLike) -> bytes:
    """Return the bytes that `save_scene` writes; raise InputError for the same scenes."""
    numbers: dict[bytes, int] = {}
    kinds: list[str] = []
    tensors: dict[str, NDArray[Any]] = {}
    pictures: dict[bytes, int] = {}
    budget = Pictures()
    instances = []
    materials: dict[int, dict[str, Any]] = {}
    whole = as_scene(scene)
    placed = whole.instances
    for instance in placed:
        shape = instance.shape
        if not isinstance(shape, KINDS.get(shape.kind, ())):
            raise InputError(f"shape: expected one of {', '.join(KINDS)} to write, got {type(shape).__name__}")
        number = numbers.setdefault(shape.digest, len(numbers))
        if number == len(kinds):
            kinds.append(shape.kind)
            own = shape.tensors()
            if isinstance(shape, Mesh) and shape.picture:
                first = pictures.setdefault(shape.picture.digest, number)
                if first != number:
                    own = shape.tensors_apart() | {SHARED: np.array([first], np.int32)}
                else:
                    _count("scene: ", budget, shape.picture)
            tensors |= {f"{number}.{name}": tensor for name, tensor in own.items()}
        material = materials.get(id(instance.material)) or _fields_of(instance.material)
        materials[id(instance.material)] = material
        instances.append(
            {
                "shape": number,
                "transform": instance.transform.tolist(),
                "material": material,
                "name": instance.name,
            }
        )
    content = {"shapes": kinds, "instances": instances}
    is_colored = any(not PHYSICAL.isdisjoint(fields) for fields in materials.values()) or any(
        instance.shape.is_colored for instance in placed
    )
    light, environment = lights.stored(whole)
    needs = {
        "1": True,
        "2": is_colored,
        "3": _any(tensors, "mesh_sizes"),
        "4": _any(tensors, ".alpha_cutoff"),
        "5": _any(tensors, f".{SHARED}"),
        "6": _any(tensors, ".face_numbers"),
        "7": any("transmission" in fields or "clearcoat" in fields for fields in materials.values()),
        "8": environment is not None,
    }
    if environment is not None:
        tensors[lights.ENVIRONMENT] = environment
    version = max(version for version in VERSIONS if needs[version])
    data = layout(content, tensors, version, {PARTS: _parts_of(whole), lights.ENTRY: light})
    _check_header(data, "scene: ")
    if len(data) > MAX_BYTES:
        raise InputError(f"scene: expected at most {MAX_BYTES:,} bytes, which can be read again, got {len(data):,}")
    return sealed(data)


def _count(place: str, budget: Pictures, picture: Picture) -> None:
    try:
        budget.count(*picture.texels.shape[:2])
    except InputError as error:
        raise InputError(f"{place}{error}") from error


def _any(tensors: Mapping[str, NDArray[Any]], ending: str) -> bool:
    return any(name.endswith(ending) for name in tensors)


def check_scene_path(path: str | os.PathLike[str]) -> Path:
    """Return `path` if a scene can be written there, before time is spent on making it."""
    path = path_of(path)
    if path.suffix.lower() != ENDING:
        raise InputError(f"{path}: expected a scene's ending, {ENDING}, got {path.suffix or 'none'}")
    return check_writable(path)


def read_scene(file: Path) -> Scene:
    """The scene in a file.

    Raises
    ------
    InputError
        If it is not a scene, is damaged, has another version, or holds something that scenes don't have.
    """
    from safetensors import SafetensorError
    from safetensors.numpy import load

    data = file.read_bytes()
    if data[8 : DIGITS.start] != START:
        raise InputError(f"expected a {FORMAT} file, got one that starts with {data[:32]!r}")
    _check_header(data)
    if data[DIGITS] != _checksum(data):
        raise InputError("expected a whole file, got one that was damaged or cut short: its checksum differs")
    header = read_json(data[8 : 8 + int.from_bytes(data[:8], "little")])
    try:
        tensors = load(data)
    except SafetensorError as error:
        raise InputError(f"expected a safetensors file, got one that is not ({error})") from error
    metadata = header["__metadata__"]
    if metadata.get("format") != FORMAT:
        raise InputError(f"expected the format {FORMAT}, got {metadata.get('format')!r}")
    if metadata.get("version") not in VERSIONS:
        raise InputError(
            f"expected version {', '.join(VERSIONS[:-1])} or {VERSIONS[-1]}, got {metadata.get('version')!r}; "
            "was it written by a newer release?"
        )
    content = _fields("scene", read_json(metadata.get("scene", "")), "shapes", "instances")
    instances = _list("instances", content["instances"])
    if len(instances) > MAX_INSTANCES:
        raise InputError(f"instances: expected at most {MAX_INSTANCES:,}, got {len(instances):,}")
    light, ground = lights.restored(metadata.get(lights.ENTRY), tensors.pop(lights.ENVIRONMENT, None))
    shapes = _shapes(_list("shapes", content["shapes"]), tensors)
    materials: dict[str, Material] = {}
    unit, has_front, pieces = _parts(metadata.get(PARTS), len(instances))
    made = [_instance(f"instances[{i}]", item, shapes, materials) for i, item in enumerate(instances)]
    placed = (replace(one, pieces=own) if own else one for one, own in zip(made, pieces, strict=True))
    scene = Scene(placed, light=light, ground=ground, unit=unit)
    scene.has_front = has_front
    return scene


def _parts_of(scene: Scene) -> dict[str, Any] | None:
    """Return the unit, whether there is a front, and each instance's pieces as paths and counts; or None."""
    if scene.unit is None and not scene.has_front and not any(instance.pieces for instance in scene.instances):
        return None
    return {
        "unit": scene.unit,
        "has_front": scene.has_front,
        "pieces": [instance.pieces for instance in scene.instances],
    }


def _parts(text: str | None, count: int) -> tuple[str | None, bool, list[Any]]:
    """Return the unit, whether there is a front, and the unchecked pieces of each instance."""
    if text is None:
        return None, False, [()] * count
    content = _fields(PARTS, read_json(text), "unit", "has_front", "pieces")
    has_front = check_flag(f"{PARTS}.has_front", content["has_front"])
    pieces = _list(f"{PARTS}.pieces", content["pieces"])
    if len(pieces) != count:
        raise InputError(f"{PARTS}.pieces: expected one entry for each of {count:,} instances, got {len(pieces):,}")
    unit = check_unit(f"{PARTS}.unit", content["unit"])
    return unit, has_front, [[_piece(piece) for piece in _list(f"{PARTS}.pieces", own)] for own in pieces]


def _piece(piece: Any) -> Any:
    """Tuples of lists; other values as they are."""
    is_pair = isinstance(piece, list) and len(piece) == 2 and isinstance(piece[0], list)
    return (tuple(piece[0]), piece[1]) if is_pair else piece


def _check_header(data: bytes, name: str = "") -> None:
    size = int.from_bytes(data[:8], "little")
    if size > MAX_HEADER:
        what = "bytes of places, materials, names and shapes' entries"
        raise InputError(f"{name}expected at most {MAX_HEADER:,} {what}, got {size:,}")


def _shapes(kinds: list[Any], tensors: Mapping[str, NDArray[Any]]) -> list[Shape]:
    of: list[dict[str, NDArray[Any]]] = [{} for _ in kinds]
    for name, tensor in sorted(tensors.items()):
        number, _, own_name = name.partition(".")
        if not (number.isdecimal() and int(number) < len(kinds)):
            raise InputError(f"{name}: expected tensors of {len(kinds)} shapes, named NUMBER.NAME, got another name")
        of[int(number)][own_name] = tensor
    shapes: list[Shape] = []
    budget = Pictures()
    for i, kind in enumerate(kinds):
        if not (isinstance(kind, str) and kind in KINDS):
            raise InputError(f"shapes[{i}]: expected a kind among {', '.join(KINDS)}, got {kind!r}")
        try:
            shapes.append(_mesh(of[i], shapes, budget) if kind == Mesh.kind else KINDS[kind].from_tensors(of[i]))
        except InputError as error:
            raise InputError(f"shapes[{i}]: {error}") from error
    return shapes


def _mesh(tensors: dict[str, NDArray[Any]], before: list[Shape], budget: Pictures) -> Mesh:
    """Return a mesh; it may share the texture of an earlier shape."""
    first = tensors.pop(SHARED, None)
    if first is None:
        if "texture" in tensors:
            budget.count(len(tensors["texture"]), 1)
        return Mesh.from_tensors(tensors)
    if first.dtype != np.int32:
        raise InputTypeError(f"{SHARED}: expected int32, got {first.dtype}")
    number = int(check_array(SHARED, first, (1,))[0])
    of = before[number] if 0 <= number < len(before) else None
    if not isinstance(of, Mesh) or of.picture is None:
        raise InputError(f"{SHARED}: expected the number of an earlier shape with a texture, got {number}")
    return Mesh.from_tensors(tensors, of.picture)


def _instance(place: str, item: Any, shapes: list[Shape], materials: dict[str, Material]) -> Instance:
    """`materials` are those so far, by their texts: instances share them."""
    fields = _fields(place, item, "shape", "transform", "material", "name")
    number = check_integer(f"{place}.shape", fields["shape"], 0, len(shapes) - 1)
    transform = _list(f"{place}.transform", fields["transform"])
    material = fields["material"]
    given: set[str] = set(material) if isinstance(material, dict) else set()
    names: Iterable[str] = MATERIAL
    if "transmission" in given:
        names = GLASS
    elif given & (PHYSICAL | CLEARCOAT):
        names = [name for name in Material.__dataclass_fields__ if name not in CLEARCOAT or "clearcoat" in given]
    material = _fields(f"{place}.material", material, *names)
    if any(isinstance(x, bool) for row in transform if isinstance(row, list) for x in row):
        raise InputTypeError(f"{place}.transform: expected numbers, got true or false")
    text = repr(material)
    try:
        if text not in materials:
            for name in {"color", "emissive", "attenuation"} & material.keys():
                numbers(f"material.{name}", material[name])
            if names is GLASS:
                if not isinstance(material["thin"], bool):
                    raise InputError(f"thin: expected true or false, got {brief(material['thin'])}")
                distance = inf if material["distance"] is None else material["distance"]
                materials[text] = Glass(**material | {"distance": distance})
            else:
                materials[text] = Material(**material)
        return Instance(shapes[number], transform, materials[text], fields["name"])
    except InputError as error:
        raise InputError(f"{place}: {error}") from error


def _fields_of(material: Material) -> dict[str, Any]:
    if type(material) not in (Material, Glass):
        raise InputError(
            f"material: expected a Material to write, got {type(material).__name__}, which scene files cannot store"
        )
    fields = asdict(material)
    if isinstance(material, Glass):
        distance = None if material.distance == inf else material.distance  # JSON has no infinity
        return {name: fields[name] for name in GLASS} | {"distance": distance}
    if material.clearcoat == 0:
        fields = {name: value for name, value in fields.items() if name not in CLEARCOAT}
        if material.roughness is None and material.emissive == (0, 0, 0):
            return {name: fields[name] for name in MATERIAL}
    return fields


def _fields(place: str, value: Any, *names: str) -> dict[str, Any]:
    if not isinstance(value, dict) or value.keys() != set(names):
        got = ", ".join(map(str, value)) if isinstance(value, dict) else type(value).__name__
        raise InputTypeError(f"{place}: expected an object of {', '.join(names)}, got {got or 'nothing in it'}")
    return value


def _list(place: str, value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise InputTypeError(f"{place}: expected a list, got {type(value).__name__}")
    return value


# ---- Layout ----------------------------------------------------------------------------------------------


def layout(
    scene: Any, tensors: Mapping[str, NDArray[Any]], version: str = VERSIONS[0], further: Mapping[str, Any] = {}
) -> bytes:
    """The file with zeros for its checksum. Further entries of the metadata may be None."""
    metadata = {
        "sha256": "0" * 64,
        "format": FORMAT,
        "version": version,
        "scene": json.dumps(scene, allow_nan=False, separators=(",", ":")),
        **{name: json.dumps(value, separators=(",", ":")) for name, value in further.items() if value is not None},
    }
    return tensor_file(metadata, tensors)


def sealed(data: bytes) -> bytes:
    """The file with its checksum in place."""
    return data[: DIGITS.start] + _checksum(data) + data[DIGITS.stop :]


def _checksum(data: bytes) -> bytes:
    digest = hashlib.sha256(data[: DIGITS.start])
    digest.update(b"0" * 64)
    for start in range(DIGITS.stop, len(data), PIECE):  # between them, Ctrl-C is noticed
        digest.update(memoryview(data)[start : start + PIECE])
    return digest.hexdigest().encode()
