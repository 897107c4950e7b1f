"""Surfaces: what the meshes of a file look like, and the pictures that are laid on them."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet.adapters.beside import Beside
from bobrossnet.shapes.picture import Picture
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import one_line, warn_of
from bobrossnet.tracing.instance import WHITE
from bobrossnet.tracing.material import Material

if TYPE_CHECKING:
    from PIL.Image import Image

MAX_TEXELS = 1 << 26
"""Of one texture: 8,192 x 8,192, 0.2 GB."""

MAX_FILE_TEXELS = 1 << 27
"""Of all pictures of a file, each counted once: 8 x 4,096 x 4,096, about 1 GB."""

TOO_LARGE = "expected a picture of at most {:,} texels, got more"

FORMATS = ("PNG", "JPEG", "WEBP", "BMP", "GIF")
"""Of textures: what browsers read as well."""


class Texture(NamedTuple):
    picture: Picture
    wrap: tuple[str, str] = ("repeat", "repeat")

    @property
    def half(self) -> float | None:
        """The cutoff for what is transparent by degrees: half, so that a ray meets what is seen most. None where
        nothing is more opaque, as of glass, which is shown as if it were."""
        return 0.5 if self.picture.alpha is not None and self.picture.max_alpha >= 128 else None


class Surface(NamedTuple):
    """A material as files have them: what it reflects, and the picture that is laid on it."""

    material: Material = WHITE
    texture: Texture | None = None
    name: str | None = None
    alpha_cutoff: float | None = None
    """Where alpha is below it, there is no surface; None where alpha does not matter."""

    @property
    def look(self) -> tuple[Any, ...]:
        """Equal where surfaces look alike."""
        picture, wrap = self.texture or (None, None)
        return self.material, picture and id(picture), wrap, self.alpha_cutoff

    @property
    def picture(self) -> Picture | None:
        """The one that is seen, without an alpha that does not matter."""
        picture = self.texture and self.texture.picture
        return picture.opaque if picture and self.alpha_cutoff is None else picture


class Pictures(dict[bytes, Picture | InputError]):
    """The pictures of a file by the SHA-256 of their contents: each is decoded once, whatever it is called."""

    def __init__(self) -> None:
        super().__init__()
        self.texels = 0
        self.means: dict[bytes, tuple[float, float, float]] = {}
        self.shown: dict[int, list[Picture]] = {}
        """With their alpha, without it, or both, by the `id` of their texels."""

    def decoded(self, data: bytes) -> Picture:
        """The texels of a picture's file.

        Raises
        ------
        InputError
            If it is none that can be read, larger than `MAX_TEXELS`, or if with the others `MAX_FILE_TEXELS` are
            exceeded.
        """
        key = hashlib.sha256(data).digest()
        if key not in self:
            try:
                self[key] = _decoded(data, self)
            except InputError as error:
                self[key] = error
        found = self[key]
        if isinstance(found, InputError):
            raise InputError(str(found))
        return found

    def mean(self, data: bytes) -> tuple[float, float, float]:
        """The mean of a picture's red, green and blue, 0..1; it is not kept.

        Raises
        ------
        InputError
            As from `decoded`, but it is not counted with the others.
        """
        key = hashlib.sha256(data).digest()
        if key not in self.means:
            with _opened(data) as image:
                image.draft("RGB", (max(image.width // 8, 1), max(image.height // 8, 1)))  # which a JPEG does quickly
                texels = _texels(image)
            red, green, blue = texels.reshape(-1, 3).mean(axis=0) / 255
            self.means[key] = float(red), float(green), float(blue)
        return self.means[key]

    def count(self, height: int, width: int) -> None:
        """Take the texels of a picture from what is left for the file, before there is any memory for them."""
        if self.texels + height * width > MAX_FILE_TEXELS:
            raise InputError(f"expected textures of at most {MAX_FILE_TEXELS:,} texels in all, got more")
        self.texels += height * width

    def show(self, surface: Surface) -> None:
        """Count the picture of a surface again where others need its alpha and this one not, or the other way round.

        Raises
        ------
        InputError
            If `MAX_FILE_TEXELS` are exceeded.
        """
        if picture := surface.picture:
            shown = self.shown.setdefault(id(picture.texels), [])
            if picture not in shown:
                if shown:
                    self.count(*picture.texels.shape[:2])
                shown.append(picture)


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
        self.model, self.beside, self.pictures = model, beside, Pictures()
        self.with_masks: dict[tuple[int | None, int], Picture] = {}

    def __missing__(self, path: PurePosixPath) -> Texture | None:
        texture = None
        try:
            texture = Texture(self.pictures.decoded(self.read(path)))
        except InputError as error:
            warn_of(self.model, f"texture {one_line(path)} was left out: {error}")
        self[path] = texture
        return texture

    def masked(self, texture: Texture | None, mask: Texture) -> Texture:
        """The texture, or a white one, with the alpha of a mask, or with what is bright of one without alpha. A mask of
        another size lends each texel what is at its centre.

        Raises
        ------
        InputError
            If the file's textures exceed `MAX_FILE_TEXELS` with it.
        """
        key = None if texture is None else id(texture.picture), id(mask.picture)
        if key not in self.with_masks:
            texels, alpha = mask.picture.texels, mask.picture.alpha
            if alpha is None:
                alpha = texels[..., 0]
            texels = np.full_like(texels, 255) if texture is None else texture.picture.texels
            self.pictures.count(*texels.shape[:2])
            rows, columns = (
                (2 * np.arange(size) + 1) * own // (2 * size)
                for size, own in zip(texels.shape[:2], alpha.shape, strict=True)
            )
            self.with_masks[key] = Picture(texels, np.ascontiguousarray(alpha[np.ix_(rows, columns)]))
        return Texture(self.with_masks[key], (texture or mask).wrap)

    def read(self, path: PurePosixPath) -> bytes:
        """The file of a texture.

        Raises
        ------
        InputError
            If there is none.
        """
        try:
            return self.beside.read(str(path))
        except InputError:
            if path.name == str(path):
                raise
            return self.beside.read(path.name)  # of paths that were another machine's, the name is right


def path_of(name: bytes) -> PurePosixPath:
    """A path as files have it, perhaps written under Windows."""
    return PurePosixPath(name.strip().decode("utf-8", "replace").replace("\\", "/"))


def _decoded(data: bytes, pictures: Pictures) -> Picture:
    with _opened(data) as image:
        width, height = image.size
        pictures.count(height, width)
        if not image.has_transparency_data:
            return Picture(_texels(image))
        if _is_deep(image):
            values = np.asarray(image)
            alpha = np.where(values == image.info["transparency"], 0, 255).astype(np.uint8)
            return Picture(_texels(image), alpha)
        texels = np.array(image.convert("RGBA"))
        alpha = np.ascontiguousarray(texels[..., 3])
        return Picture(np.ascontiguousarray(texels[..., :3]), None if (alpha == 255).all() else alpha)


@contextmanager
def _opened(data: bytes) -> Iterator[Image]:
    """A picture's file, whose errors become InputErrors."""
    from PIL import Image

    try:
        with Image.open(io.BytesIO(data), formats=FORMATS) as image:
            if image.width * image.height > MAX_TEXELS:
                raise InputError(TOO_LARGE.format(MAX_TEXELS))
            yield image
    except InputError:
        raise
    except Image.DecompressionBombError as error:  # which Pillow does not open at all
        raise InputError(TOO_LARGE.format(MAX_TEXELS)) from error
    except (OSError, ValueError, SyntaxError) as error:  # Pillow's, of broken files
        raise InputError("expected a picture in PNG, JPEG or WebP, got none that can be read") from error


def _is_deep(image: Image) -> bool:
    """Whether a picture is gray in 16 bits, which Pillow would cut off at 255."""
    return image.mode == "I" or image.mode.startswith("I;16")


def _texels(image: Image) -> NDArray[np.uint8]:
    """(H, W, 3), of 16 bits the upper eight."""
    if not _is_deep(image):
        return np.array(image.convert("RGB"))
    gray = (np.asarray(image).astype(np.int32) >> 8).astype(np.uint8)
    return np.repeat(gray[..., None], 3, axis=2)
