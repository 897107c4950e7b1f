"""Surfaces: what the meshes of a file look like, and the pictures that are laid on them."""

from __future__ import annotations

import io
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.beside import Beside
from bobrossnet.adapters.messages import one_line, warn_of
from bobrossnet.errors import InputError
from bobrossnet.tracing.instance import WHITE
from bobrossnet.tracing.material import Material

MAX_TEXELS = 1 << 26
"""Of one texture: 8,192 x 8,192, 0.2 GB."""

FORMATS = ("PNG", "JPEG", "WEBP", "BMP", "GIF")
"""Of textures: what browsers read as well."""


class Texture(NamedTuple):
    texels: NDArray[np.uint8]
    """(H, W, 3) sRGB, row 0 at the top."""
    wrap: tuple[str, str] = ("repeat", "repeat")


class Surface(NamedTuple):
    """A material as files have them: what it reflects, and the picture that is laid on it."""

    material: Material = WHITE
    texture: Texture | None = None
    name: str | None = None

    @property
    def look(self) -> tuple[Material, int | None, tuple[str, str] | None]:
        """Equal where surfaces look alike."""
        texels, wrap = self.texture or (None, None)
        return self.material, None if texels is None else id(texels), wrap


class Textures(dict[PurePosixPath, Texture | None]):
    """Textures in files beside a model, by their paths from its folder; None, with a warning, where one can't be
    read.

    Parameters
    ----------
    model : path of the model
    beside : reads its files
    """

    def __init__(self, model: Path, beside: Beside) -> None:
        super().__init__()
        self.model, self.beside = model, beside

    def __missing__(self, path: PurePosixPath) -> Texture | None:
        texture = None
        try:
            texture = Texture(decoded(self._read(path)))
        except InputError as error:
            warn_of(self.model, f"texture {one_line(path)} was left out: {error}")
        self[path] = texture
        return texture

    def _read(self, path: PurePosixPath) -> bytes:
        try:
            return self.beside.read(str(path))
        except InputError:
            if path.name == str(path):
                raise
            return self.beside.read(path.name)  # of paths that were another machine's, the name is right


def path_of(name: bytes) -> PurePosixPath:
    """A path as files have it, perhaps written under Windows."""
    return PurePosixPath(name.strip().decode("utf-8", "replace").replace("\\", "/"))


def texture_beside(model: Path, name: bytes) -> Texture | None:
    """The texture that a model names; None, with a warning, if it can't be read."""
    return Textures(model, Beside(model))[path_of(name)]


def decoded(data: bytes) -> NDArray[np.uint8]:
    """The texels of a picture's file, (H, W, 3) sRGB; how transparent they are does not matter.

    Raises
    ------
    InputError
        If it is none that can be read, or larger than `MAX_TEXELS`.
    """
    from PIL import Image

    try:
        with Image.open(io.BytesIO(data), formats=FORMATS) as image:
            width, height = image.size
            if width * height > MAX_TEXELS:
                raise InputError(f"expected a picture of at most {MAX_TEXELS:,} texels, got {width} x {height}")
            return np.array(image.convert("RGB"))
    except InputError:
        raise
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:  # Pillow's, of broken files
        raise InputError("expected a picture in PNG, JPEG or WebP, got none that can be read") from error


def unit(value: Any, otherwise: float) -> float:
    """A number as near to it as 0..1 allows; `otherwise` where it is none."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        return otherwise
    return min(max(float(value), 0.0), 1.0)
