"""Surfaces of mesh files: materials and textures."""

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
"""Maximum size of one texture: 8,192 x 8,192 texels, 0.2 GB."""

MAX_FILE_TEXELS = 1 << 27
"""Maximum size of all pictures of a file, each counted once: 8 x 4,096 x 4,096 texels, about 1 GB."""

TOO_LARGE = "expected a picture of at most {:,} texels, got more"

FORMATS = ("PNG", "JPEG", "WEBP", "BMP", "GIF", "AVIF")
"""File formats of textures, the same as in browsers."""


class Texture(NamedTuple):
    picture: Picture
    wrap: tuple[str, str] = ("repeat", "repeat")

    @property
    def half(self) -> float | None:
        """The cutoff of a translucent picture: half, so a ray meets the more visible surface. None if all of it is less
        opaque, like glass; it is then shown as opaque."""
        return 0.5 if self.picture.alpha is not None and self.picture.max_alpha >= 128 else None


class Surface(NamedTuple):
    """A material of a file, and its texture."""

    material: Material = WHITE
    texture: Texture | None = None
    name: str | None = None
    alpha_cutoff: float | None = None
    """There is no surface where alpha is below it; None if alpha is ignored."""

    @property
    def look(self) -> tuple[Any, ...]:
        """A key, equal for surfaces of equal appearance."""
        picture, wrap = self.texture or (None, None)
        return self.material, picture and id(picture), wrap, self.alpha_cutoff

    @property
    def picture(self) -> Picture | None:
        """The visible texture, without an ignored alpha."""
        picture = self.texture and self.texture.picture
        return picture.opaque if picture and self.alpha_cutoff is None else picture


class Pictures(dict[bytes, Picture | InputError]):
    """The pictures of a file by the SHA-256 of their contents; each is decoded once, even under several names."""

    def __init__(self) -> None:
        super().__init__()
        self.texels = 0
        self.means: dict[bytes, tuple[float, float, float]] = {}
        self.shown: dict[int, list[Picture]] = {}
        """Whether pictures are used with alpha, without it, or both, by the `id` of their texels."""

    def decoded(self, data: bytes) -> Picture:
        """Decode a picture's file.

        Raises
        ------
        InputError
            If it is unreadable or larger than `MAX_TEXELS`, or if all pictures together exceed `MAX_FILE_TEXELS`.
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
        """Return the mean of a picture's red, green and blue, 0..1, without keeping the picture.

        Raises
        ------
        InputError
            As `decoded`, but it does not count towards `MAX_FILE_TEXELS`.
        """
        key = hashlib.sha256(data).digest()
        if key not in self.means:
            with _opened(data) as image:
                image.draft("RGB", (max(image.width // 8, 1), max(image.height // 8, 1)))  # fast for JPEG
                texels = _texels(image)
            red, green, blue = texels.reshape(-1, 3).mean(axis=0) / 255
            self.means[key] = float(red), float(green), float(blue)
        return self.means[key]

    def count(self, height: int, width: int) -> None:
        """Subtract a picture's texels from the file's budget, before memory is allocated."""
        if self.texels + height * width > MAX_FILE_TEXELS:
            raise InputError(f"expected textures of at most {MAX_FILE_TEXELS:,} texels in all, got more")
        self.texels += height * width

    def show(self, surface: Surface) -> None:
        """Count a picture twice if one surface uses its alpha and another ignores it.

        Raises
        ------
        InputError
            If `MAX_FILE_TEXELS` is exceeded.
        """
        if picture := surface.picture:
            shown = self.shown.setdefault(id(picture.texels), [])
            if picture not in shown:
                if shown:
                    self.count(*picture.texels.shape[:2])
                shown.append(picture)


class Textures(dict[PurePosixPath, Texture | None]):
    """Textures in files next to a model, by their paths from its folder; None, with a warning, if one is unreadable.

    Parameters
    ----------
    model : path of the model
    beside : reader of files next to it
    """

    def __init__(self, model: Path, beside: Beside) -> None:
        super().__init__()
        self.model, self.beside, self.pictures = model, beside, Pictures()
        self.with_masks: dict[tuple[int | None, int], Picture] = {}

    def __missing__(self, path: PurePosixPath) -> Texture | None:
        texture = None
        try:
            texture = Texture(self.pictures.decoded(self.beside.read(str(path))))
        except InputError as error:
            warn_of(self.model, f"texture {one_line(path)} was left out: {error}")
        self[path] = texture
        return texture

    def masked(self, texture: Texture | None, mask: Texture) -> Texture:
        """Return the texture, or a white one, with the alpha of a mask, or the mask's red if it has no alpha.

        A mask of another size is sampled at the texels' centres.

        Raises
        ------
        InputError
            If the file's textures then exceed `MAX_FILE_TEXELS`.
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


def path_of(name: bytes) -> PurePosixPath:
    """Parse a path from a file, perhaps written on Windows."""
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
    """Open a picture's file; its errors become InputErrors."""
    from PIL import Image

    try:
        with Image.open(io.BytesIO(data), formats=FORMATS) as image:
            if image.width * image.height > MAX_TEXELS:
                raise InputError(TOO_LARGE.format(MAX_TEXELS))
            yield image
    except InputError:
        raise
    except Image.DecompressionBombError as error:  # too large for Pillow
        raise InputError(TOO_LARGE.format(MAX_TEXELS)) from error
    except (OSError, ValueError, SyntaxError, KeyError) as error:  # from Pillow: damaged, or AVIF before Pillow 11.3
        raise InputError("expected a picture in PNG, JPEG, WebP or AVIF, got none that can be read") from error


def _is_deep(image: Image) -> bool:
    """Whether a picture is 16-bit gray, which Pillow would clip at 255."""
    return image.mode == "I" or image.mode.startswith("I;16")


def _texels(image: Image) -> NDArray[np.uint8]:
    """Return (H, W, 3) uint8; 16-bit values lose their lower eight bits."""
    if not _is_deep(image):
        return np.array(image.convert("RGB"))
    gray = (np.asarray(image).astype(np.int32) >> 8).astype(np.uint8)
    return np.repeat(gray[..., None], 3, axis=2)
