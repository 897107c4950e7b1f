"""Mesh files, read by the core (core/files): fetches the files that they name, and decodes their images."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from bobrossnet import _core
from bobrossnet.adapters.beside import Beside
from bobrossnet.adapters.part import MAX_DEPTH, Found, Part, converted
from bobrossnet.adapters.surface import Surface, Texture, Textures, path_of
from bobrossnet.shapes.implicit import Implicit
from bobrossnet.shapes.shape import Shape
from bobrossnet.shapes.tube import segments
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import name_of, one_line, warn_of
from bobrossnet.tracing.glass import Glass
from bobrossnet.tracing.instance import Instance, Piece
from bobrossnet.tracing.material import Material

VERTICES, NORMALS, COLORS, FACE_COLORS, ALPHAS, UV = range(6)
"""Indices of a part's arrays; further sets of uv follow."""

MATERIAL = ("ambient", "diffuse", "specular", "shininess", "metallic", "roughness")
UNNAMED = "unnamed"
"""Name of unnamed parts next to named ones."""

OF_SURFACE, OF_SHAPE, OF_PLACEMENT = 22, 3, 12
"""Numbers of each surface, shape and placement."""


def read_in_core(file: Path) -> Found[Part]:
    """Return the parts of a mesh file, and the other shapes in it.

    Raises
    ------
    InputError
        If the file can't be read.
    """
    beside = Beside(file)
    with _input_errors():
        reading = _core.Reading(file.suffix[1:].lower(), file.read_bytes())
        while wanted := reading.go_on():
            try:
                reading.give(beside.read(wanted))
            except InputError as error:
                reading.refuse(str(error))
        contents = json.loads(reading.description())
        rows = iter(reading.numbers().reshape(-1))

    def numbers(described: list[Any], width: int) -> list[list[float]]:
        """Take the numbers of each of these."""
        return [[float(number) for number in islice(rows, width)] for _ in described]

    for described, own in zip(contents["surfaces"], numbers(contents["surfaces"], OF_SURFACE), strict=True):
        described |= {"color": own[:3], "emissive": own[9:12], "attenuation": own[16:19], "alpha_cutoff": own[21]}
        described |= zip(MATERIAL, own[3:9], strict=True)
        described |= {"clearcoat": own[12], "clearcoat_roughness": own[13], "transmission": own[14], "ior": own[15]}
        described |= {"distance": own[19], "thin": bool(own[20])}
    for warning in contents["warnings"]:
        warn_of(file, warning)
    images = _Images(Textures(file, beside), contents["images"], reading)
    surfaces = [images.surface(described) for described in contents["surfaces"]]
    contents["paths"] = _paths(contents["labels"])
    parts = [_part(reading, number, part, surfaces, contents) for number, part in enumerate(contents["parts"])]
    colors = numbers(contents["shapes"], OF_SHAPE)
    places = numbers(contents["placements"], OF_PLACEMENT)
    with _input_errors():
        shapes = [_shape(reading, number, shape["kind"]) for number, shape in enumerate(contents["shapes"])]
    instances = []
    for (number, label), place in zip(contents["placements"], places, strict=True):
        instances.append(
            Instance(
                shapes[number],
                np.array([*place, 0, 0, 0, 1]).reshape(4, 4),
                Material(color=tuple(colors[number])),
                one_line(contents["shapes"][number]["name"]) or name_of(file),
                [(contents["paths"][label], None)],
            )
        )
    return Found(parts, contents["unit"] or None, instances)


def _shape(reading: _core.Reading, number: int, kind: str) -> Shape:
    if kind == "tube":
        ends, radii = reading.shape(number)
        return segments(ends.reshape(-1, 2, 3), radii)
    formula, bounds, color = reading.shape(number)
    return Implicit(formula, bounds, color)


@contextmanager
def _input_errors() -> Iterator[None]:
    """Raise the core's errors as `InputError`."""
    try:
        yield
    except ValueError as error:
        raise InputError(str(error)) from error


def _part(
    reading: _core.Reading, number: int, part: dict[str, Any], surfaces: list[Surface], contents: dict[str, Any]
) -> Part:
    vertices = reading.field(number, VERTICES)
    assert vertices is not None
    triangles = converted(reading.triangles(number), np.int64)
    surface, described = Surface(), dict[str, Any]()
    if part["surface"] >= 0:
        surface, described = surfaces[part["surface"]], contents["surfaces"][part["surface"]]
    fields: dict[str, Any] = {"normals": reading.field(number, NORMALS), "alphas": reading.field(number, ALPHAS)}
    layer = described.get("layers", {}).get("color") or described.get("layers", {}).get("mask")
    if surface.texture is not None and layer["uv"] < part["uv"]:
        fields["uv"] = reading.field(number, UV + layer["uv"])
    if surface.texture is None or not described["replaces_color"]:
        fields |= {"colors": reading.field(number, COLORS), "face_colors": reading.field(number, FACE_COLORS)}
    runs = zip(part["runs"][::2], part["runs"][1::2], strict=True)
    pieces = tuple(Piece(contents["paths"][label], count) for label, count in runs)
    return Part(vertices, triangles, surface=surface, runs=pieces, **fields)


def _paths(labels: list[dict[str, Any]]) -> list[tuple[str, ...]]:
    """Return the path of each label, and at the end the path of unlabelled triangles."""
    paths: list[tuple[str, ...]] = []
    for label in labels:
        above = paths[label["parent"]] if label["parent"] >= 0 else ()
        paths.append((*above[: MAX_DEPTH - 1], one_line(label["name"]) or UNNAMED))
    return [*paths, (UNNAMED,)]


class _Images:
    """Textures of a file's images by number; unreadable ones are left out, with a warning."""

    def __init__(self, textures: Textures, described: list[dict[str, str]], reading: _core.Reading) -> None:
        self.textures, self.described, self.reading = textures, described, reading
        self.embedded: dict[int, Texture | None] = {}
        self.left_out: set[str] = set()

    def surface(self, described: dict[str, Any]) -> Surface:
        layers, name = described["layers"], one_line(described["name"]) or None
        texture = self._texture(layers.get("color"))
        replaces = texture is not None and described["replaces_color"]
        if mask := self._texture(layers.get("mask")):
            try:
                texture = self.textures.masked(texture, mask)
            except InputError as error:
                warn_of(self.textures.model, f"the mask of {name} was left out: {error}")
        color = [1.0, 1.0, 1.0] if replaces else described["color"]
        terms = MATERIAL[:4] if described["roughness"] < 0 else MATERIAL[4:]
        reflecting = {term: described[term] for term in terms}
        if "metallic_roughness" in layers:
            _, green, blue = self._mean(layers["metallic_roughness"]["image"])
            reflecting = {"metallic": blue * reflecting["metallic"], "roughness": green * reflecting["roughness"]}
        if described["transmission"] > 0:
            glass = {name: described[name] for name in ("transmission", "ior", "distance", "thin")}
            glass |= {name: tuple(described[name]) for name in ("attenuation", "emissive")}
            material: Material = Glass(tuple(color), roughness=reflecting["roughness"], **glass)
        else:
            coat = {name: described[name] for name in ("clearcoat", "clearcoat_roughness")}
            material = Material(tuple(color), **reflecting, emissive=tuple(described["emissive"]), **coat)
        surface = Surface(material, texture, name, _cutoff(described, texture))
        try:
            self.textures.pictures.show(surface)
        except InputError as error:
            self._warn((layers.get("color") or layers["mask"])["image"], error)
            surface = Surface(material, None, name, _cutoff(described, None))
        return surface

    def _texture(self, layer: dict[str, Any] | None) -> Texture | None:
        if layer is None:
            return None
        number = layer["image"]
        name = self.described[number]["name"]
        texture = self.textures[path_of(name.encode())] if name else self._embedded(number)
        return texture and texture._replace(wrap=tuple(layer["wrap"]))

    def _embedded(self, number: int) -> Texture | None:
        if number not in self.embedded:
            self.embedded[number] = None
            try:
                self.embedded[number] = Texture(self.textures.pictures.decoded(self.reading.image(number)))
            except InputError as error:
                self._warn(number, error)
        return self.embedded[number]

    def _mean(self, number: int) -> tuple[float, float, float]:
        """Return the mean of an image of numbers, in 0..1; if unreadable, of a rough surface without metal."""
        name = self.described[number]["name"]
        try:
            data = self.textures.beside.read(str(path_of(name.encode()))) if name else self.reading.image(number)
            return self.textures.pictures.mean(data)
        except InputError as error:
            self._warn(number, error)
            return 0.0, 1.0, 0.0

    def _warn(self, number: int, error: InputError) -> None:
        """Warn once of each image that was left out."""
        label = one_line(self.described[number]["label"])
        if label not in self.left_out:
            warn_of(self.textures.model, f"texture {label} was left out: {error}")
        self.left_out.add(label)


def _cutoff(described: dict[str, Any], texture: Texture | None) -> float | None:
    if described["opacity"] == "translucent":
        return texture.half if texture else None
    if described["opacity"] == "opaque":
        return None
    return float(described["alpha_cutoff"])
