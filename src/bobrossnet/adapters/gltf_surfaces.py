"""The materials of a glTF, and their textures."""

from __future__ import annotations

import binascii
import math
from base64 import b64decode
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.surface import Pictures, Surface, Texture, unit
from bobrossnet.shapes.picture import Picture
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import one_line, warn_of
from bobrossnet.tracing.material import Material

WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}
"""By the numbers of WebGL."""

DATA = "data:"

MAX_NUMBER = 1e9
"""Of what moves textures."""


class GltfSurfaces(dict[int, Surface]):
    """Surfaces by the number of their material. What of one can't be read is left out, with a warning.

    Parameters
    ----------
    model : path of the glTF, for warnings
    tree : the glTF
    buffers : what its files hold, by their URIs
    """

    def __init__(self, model: Path, tree: dict[str, Any], buffers: Mapping[str, bytes]) -> None:
        super().__init__()
        self.model, self.tree, self.buffers = model, tree, buffers
        self.pictures = Pictures()
        self.sources: dict[tuple[Any, ...], Picture | None] = {}
        """By where their images are: a URI, or a view's buffer, start and length."""
        self.left_out: set[int] = set()
        """Numbers of images."""

    def __missing__(self, number: int) -> Surface:
        if number < 0:
            return Surface()
        texture = self._texture(self._base_color(number))
        surface = self._surface(number, texture)
        try:
            self.pictures.show(surface)
        except InputError as error:
            self._warn(self._image(self._base_color(number)), error)
            surface = self._surface(number, None)
        self[number] = surface
        return surface

    def _surface(self, number: int, texture: Texture | None) -> Surface:
        material = self.material(number)
        name = material.get("name")
        label = one_line(name) if isinstance(name, str) and name else None
        return Surface(self._reflecting(material), texture, label, self._cutoff(material, texture))

    def _warn(self, image: int, error: InputError) -> None:
        """Say once that an image was left out."""
        if image not in self.left_out:
            warn_of(self.model, f"texture {image} was left out: {error}")
        self.left_out.add(image)

    def index(self, number: Any) -> int:
        """The number of a primitive's material; -1, which is plain, if it is none."""
        materials = self.tree.get("materials")
        count = len(materials) if isinstance(materials, list) else 0
        return number if isinstance(number, int) and 0 <= number < count else -1

    def material(self, number: Any) -> dict[str, Any]:
        """What the file says of a material."""
        return _item(self.tree, "materials", self.index(number))

    def uv_set(self, number: Any) -> int:
        """Which places on its texture a material takes."""
        info = self._base_color(number)
        chosen = _moved(info).get("texCoord", info.get("texCoord", 0))
        return chosen if isinstance(chosen, int) else 0

    def on_texture(self, number: Any, uv: NDArray[np.float64]) -> NDArray[np.float64]:
        """Places as the material's KHR_texture_transform moves them, (V, 2): scaled, turned, then shifted.

        It turns as Khronos' sample viewer and three.js do, clockwise in the extension's own matrices.
        """
        moved = _moved(self._base_color(number))
        if not moved:
            return uv
        (u, v), (wide, high) = _pair(moved.get("offset"), 0), _pair(moved.get("scale"), 1)
        angle = _finite(moved.get("rotation"), 0)
        cos, sin = math.cos(angle), math.sin(angle)
        x, y = uv[:, 0] * wide, uv[:, 1] * high
        return np.stack([cos * x + sin * y + u, cos * y - sin * x + v], axis=1)

    def alphas(self, number: Any, colors: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """Those of vertices, (V, 1), as far as the material looks at them."""
        return colors[:, 3:] if self.material(number).get("alphaMode") == "MASK" and colors.shape[1] == 4 else None

    def _base_color(self, number: Any) -> dict[str, Any]:
        return _object(_object(self.material(number), "pbrMetallicRoughness"), "baseColorTexture")

    def _reflecting(self, material: dict[str, Any]) -> Material:
        pbr = _object(material, "pbrMetallicRoughness")
        return Material(
            _rgb(pbr.get("baseColorFactor"), 1),
            metallic=unit(pbr.get("metallicFactor"), 1),
            roughness=unit(pbr.get("roughnessFactor"), 1),
            emissive=_rgb(material.get("emissiveFactor"), 0),
        )

    def _cutoff(self, material: dict[str, Any], texture: Texture | None) -> float | None:
        """Of the texture's alpha times the vertices'. The material's own divides what their product is compared with;
        above 1, nothing is seen."""
        mode, cutoff = material.get("alphaMode"), _finite(material.get("alphaCutoff"), 0.5)
        if mode != "MASK":
            return texture.half if texture and mode == "BLEND" else None
        factor = _object(material, "pbrMetallicRoughness").get("baseColorFactor")
        alpha = unit(factor[3], 1) if isinstance(factor, list) and len(factor) == 4 else 1.0
        return max(cutoff, 0.0) / alpha if alpha else math.inf if cutoff > 0 else None

    def _texture(self, info: dict[str, Any]) -> Texture | None:
        if "index" not in info:
            return None
        texture = _item(self.tree, "textures", info.get("index"))
        picture = self._picture(self._image(info))
        sampler = _item(self.tree, "samplers", texture.get("sampler"))
        across, down = (WRAPS.get(_number(sampler.get(axis)), "repeat") for axis in ("wrapS", "wrapT"))
        return Texture(picture, (across, down)) if picture else None

    def _image(self, info: dict[str, Any]) -> int:
        """The number of a texture's image, -1 of none."""
        texture = _item(self.tree, "textures", info.get("index"))
        extensions = _object(texture, "extensions")
        number = texture.get("source", _object(extensions, "EXT_texture_webp").get("source"))
        return number if isinstance(number, int) else -1

    def _picture(self, number: int) -> Picture | None:
        source = self._source(_item(self.tree, "images", number))
        if source not in self.sources:
            self.sources[source] = None
            try:
                self.sources[source] = self.pictures.decoded(self._content(*source))
            except InputError as error:
                self._warn(number, error)
        return self.sources[source]

    def _source(self, image: dict[str, Any]) -> tuple[Any, ...]:
        """Where the file of an image is."""
        if isinstance(image.get("uri"), str):
            return (image["uri"],)
        view = _item(self.tree, "bufferViews", image.get("bufferView"))
        buffer = _item(self.tree, "buffers", view.get("buffer"))
        start, length = (_number(view.get(name, 0)) for name in ("byteOffset", "byteLength"))
        return (buffer["uri"], start, start + length) if buffer else ()

    def _content(self, uri: str | None = None, start: int | None = None, end: int | None = None) -> bytes:
        if uri is None:
            raise InputError("expected an image with a uri or a bufferView, got none")
        return self._file(uri)[start:end]

    def _file(self, uri: str) -> bytes:
        if not uri.startswith(DATA):
            return self.buffers[uri]
        try:
            return b64decode(uri.partition(",")[2])
        except (binascii.Error, ValueError) as error:
            raise InputError(f"expected a picture in base64, got something else ({error})") from error


def _item(tree: dict[str, Any], name: str, number: Any) -> dict[str, Any]:
    """An item of a list; without anything in it if there is none."""
    items = tree.get(name)
    found = items[number] if isinstance(items, list) and isinstance(number, int) and 0 <= number < len(items) else None
    return found if isinstance(found, dict) else {}


def _object(of: dict[str, Any], name: str) -> dict[str, Any]:
    value = of.get(name)
    return value if isinstance(value, dict) else {}


def _moved(info: dict[str, Any]) -> dict[str, Any]:
    return _object(_object(info, "extensions"), "KHR_texture_transform")


def _finite(value: Any, otherwise: float) -> float:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if is_number and abs(value) <= MAX_NUMBER else otherwise


def _pair(values: Any, otherwise: float) -> tuple[float, float]:
    first, second = values if isinstance(values, list) and len(values) == 2 else (None, None)
    return _finite(first, otherwise), _finite(second, otherwise)


def _number(value: Any) -> int:
    return value if isinstance(value, int) else 0


def _rgb(values: Any, otherwise: float) -> tuple[float, float, float]:
    """Linear RGB of a factor, which may have an alpha."""
    given = [*values] if isinstance(values, list) else []
    red, green, blue = (unit(value, otherwise) for value in [*given, *[None] * 3][:3])
    return red, green, blue
