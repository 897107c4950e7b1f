"""MTL: the materials of an OBJ, and their textures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path, PurePosixPath

import numpy as np

from bobrossnet.adapters.beside import Beside, find_beside
from bobrossnet.adapters.surface import Surface, Texture, Textures, path_of, unit
from bobrossnet.color import from_srgb
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import one_line, warn_of
from bobrossnet.tracing.material import Material

OPTIONS = {b"-s": 3, b"-o": 3, b"-t": 3, b"-mm": 2}
"""Of maps: how many numbers may follow; one word follows the others."""


def read_mtl(model: Path, libraries: Sequence[bytes]) -> dict[bytes, Surface]:
    """The surfaces that an OBJ's libraries describe, by their names.

    A library or a texture that can't be read is left out, with a warning.
    """
    beside = Beside(model)
    statements: dict[bytes, dict[bytes, list[bytes]]] = {}
    folders: dict[bytes, PurePosixPath] = {}
    for name in dict.fromkeys(_libraries(model, libraries)):
        path = path_of(name)
        try:
            data = beside.read(str(path))
        except InputError as error:
            warn_of(model, f"materials were left out: {error}")
            continue
        of: dict[bytes, list[bytes]] = {}
        for line in data.splitlines():
            words = line.partition(b"#")[0].split()
            if words[:1] == [b"newmtl"]:
                material = line.partition(b"newmtl")[2].strip()
                of = statements[material] = {}
                folders[material] = path.parent
            elif words:
                of[words[0].lower()] = words[1:]
    textures = Textures(model, beside)
    return {name: _surface(name, of, textures, folders[name]) for name, of in statements.items()}


def _libraries(model: Path, lines: Sequence[bytes]) -> list[bytes]:
    """What a line names is several files, if there are such, or one with spaces in its name."""

    def is_there(name: bytes) -> bool:
        try:
            return bool(find_beside(model, str(path_of(name))))
        except InputError:
            return False

    return [
        name
        for line in lines
        for name in (line.split() if not is_there(line) and any(map(is_there, line.split())) else [line])
    ]


def _surface(name: bytes, of: dict[bytes, list[bytes]], textures: Textures, folder: PurePosixPath) -> Surface:
    texture, mask = (_texture(of.get(word), textures, folder) for word in (b"map_kd", b"map_d"))
    # Exporters write any Kd beside a texture, and importers such as Blender's do not look at it.
    color = (1.0, 1.0, 1.0) if texture else _color(of.get(b"kd"), 1)
    if mask:
        try:
            texture = textures.masked(texture, mask)
        except InputError as error:
            warn_of(textures.model, f"the mask of {one_line(name.decode('utf-8', 'replace'))} was left out: {error}")
    cutoff = texture.half if texture else None
    label = one_line(name.decode("utf-8", "replace")) or None
    emissive = _color(of.get(b"ke"), 0)
    if b"pm" in of or b"pr" in of:
        metallic, roughness = (unit(_finite(of.get(word)), otherwise) for word, otherwise in ((b"pm", 0), (b"pr", 0.5)))
        material = Material(color, metallic=metallic, roughness=roughness, emissive=emissive)
        return Surface(material, texture, label, cutoff)
    # Highlights of full strength are common in files and wash colours out: Ks scales the one that surfaces have here.
    specular = 0.2 * max(_color(of.get(b"ks"), 1))
    exponent = float(_finite(of.get(b"ns")) or 0)
    shininess = min(exponent, 10_000) if exponent >= 1 else 32
    material = Material(color, specular=specular, shininess=shininess, emissive=emissive)
    return Surface(material, texture, label, cutoff)


def _texture(words: list[bytes] | None, textures: Textures, folder: PurePosixPath) -> Texture | None:
    file, clamped = _map(words or [])
    texture = textures[folder / path_of(file)] if file else None
    return texture._replace(wrap=("clamp", "clamp")) if texture and clamped else texture


def _map(words: list[bytes]) -> tuple[bytes, bool]:
    """The file of a map, and whether it is clamped."""
    clamped = False
    while len(words) > 1 and words[0].startswith(b"-"):
        option, words = words[0].lower(), words[1:]
        if option in OPTIONS:
            count = 0
            while count < OPTIONS[option] and len(words) > 1 and _finite(words) is not None:
                count, words = count + 1, words[1:]
        else:
            clamped |= option == b"-clamp" and words[0].lower() == b"on"
            words = words[1:]
    return b" ".join(words), clamped


def _color(words: list[bytes] | None, otherwise: float) -> tuple[float, float, float]:
    """Linear RGB of a statement's sRGB."""
    values = [_finite([word]) for word in (words or [])[:3]]
    if len(values) == 1:
        values *= 3
    red, green, blue = from_srgb([unit(value, otherwise) for value in [*values, *[None] * 3][:3]])
    return float(red), float(green), float(blue)


def _finite(words: list[bytes] | None) -> float | None:
    try:
        value = float((words or [b""])[0])
    except ValueError:
        return None
    return value if np.isfinite(value) else None
