"""Pictures of traced and completed pixels, as images and files."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.order import Size
from bobrossnet.support.atomic import check_writable, write_whole
from bobrossnet.support.errors import InputError, check_array, check_finite, shape_of
from bobrossnet.support.paths import path_of

F32 = NDArray[np.float32]
U8 = NDArray[np.uint8]

UNTRACED = (0, 150, 70)
"""Green: distinct from every shade of gray."""

FORMATS = {
    ".png": "PNG",
    ".jpg": "JPEG",
    ".jpeg": "JPEG",
    ".webp": "WebP",
    ".avif": "AVIF",
    ".bmp": "BMP",
    ".tif": "TIFF",
    ".tiff": "TIFF",
}

MAX_SIDES = {"WebP": 16383, "JPEG": 65500, "GIF": 65535, "AVIF": 32768, "MP4": 16384}
"""Maximum width and height in pixels that a format holds, or that its usual encoders and decoders accept."""

OPAQUE = {"JPEG", "BMP"}
"""Formats without transparency."""

PNG_LEVEL = 3
"""zlib compression level: files are about the size of level 6, the default, in half the time."""

CAPTION_HEIGHT = 26
GAP = 4


def to_8_bit(values: F32) -> U8:
    """Convert values in 0..1 to uint8 without a transfer function: error maps, coverage, and sRGB values."""
    return np.rint(np.clip(values, 0, 1) * 255).astype(np.uint8)


def color_to_8_bit(color: F32) -> U8:
    """Convert linear gray, (H, W), or RGB, (H, W, 3), to sRGB uint8 of the same shape.

    The one tone curve of all pictures, exact or completed, white or coloured; values above 1 are clamped to white.
    """
    values = np.ascontiguousarray(color, np.float32)
    return _core.displayed(values.reshape(-1)).reshape(values.shape)


def traced_on_green(gbuffer: GBuffer) -> U8:
    """Return the traced pixels over green, (H, W, 3) uint8."""
    shown = color_to_8_bit(gbuffer.color if "color" in gbuffer.channels else gbuffer.gray[..., None])
    return np.where(gbuffer.mask[..., None] > 0, shown, np.array(UNTRACED, np.uint8))


def side_by_side(panels: list[tuple[U8, str]]) -> U8:
    """Return images of equal size in a row, each above its caption: (H', W', 3) uint8."""
    return sheet(panels, len(panels))


def sheet(panels: list[tuple[U8, str]], columns: int) -> U8:
    """Return images of equal size in rows of `columns`; the last row may be shorter."""
    from PIL import Image, ImageDraw, ImageFont

    height, width = panels[0][0].shape[:2]
    across, rows = min(columns, len(panels)), -(-len(panels) // columns)
    drawn = Image.new("RGB", (across * (width + GAP) - GAP, rows * (height + CAPTION_HEIGHT)), "white")
    draw = ImageDraw.Draw(drawn)
    for i, (image, caption) in enumerate(panels):
        left, top = i % columns * (width + GAP), i // columns * (height + CAPTION_HEIGHT)
        drawn.paste(Image.fromarray(image), (left, top))
        # The largest font size that fits: in small pictures, captions must not overlap.
        for size in range(15, 5, -1):
            font = ImageFont.load_default(size)
            if draw.textlength(caption, font=font) <= width - 8:
                break
        else:
            shown = len(caption)
            while shown and draw.textlength(caption, font=font) > width:
                shown -= 1
                caption = f"{caption[:shown]}..."
        place = left + width / 2, top + height + CAPTION_HEIGHT / 2
        draw.text(place, caption, "black", font=font, anchor="mm")
    return np.asarray(drawn)


def before(color: str, rgba: U8) -> U8:
    """Composite a picture, (H, W, 4) uint8, over a colour known to Pillow: (H, W, 3) uint8."""
    from PIL import Image

    picture = Image.fromarray(rgba)
    return np.asarray(Image.alpha_composite(Image.new("RGBA", picture.size, color), picture).convert("RGB"))


def png(image: U8) -> bytes:
    """A picture's file, as notebooks show it."""
    return encoded(image, "PNG", "picture")


def check_picture_path(path: str | os.PathLike[str], size: Size | None = None) -> Path:
    """Return `path` if a picture can be written there; checked before any time is spent on the picture."""
    path = check_writable(path, "a picture", FORMATS)
    if size is not None:
        check_sides(path, FORMATS[path.suffix.lower()], size)
    return path


def check_sides(path: Path, kind: str, size: Size) -> None:
    """Raise InputError if a format has no pictures of a size."""
    height, width = size
    if max(size) > (most := MAX_SIDES.get(kind, max(size))):
        raise InputError(f"{path}: expected at most {most:,} pixels a side in {kind}, got {width}x{height}")


def is_opaque(path: str | os.PathLike[str]) -> bool:
    """Return whether the path's ending names a format without transparency."""
    return FORMATS.get(path_of(path).suffix.lower()) in OPAQUE


def save(image: Any, path: str | os.PathLike[str]) -> None:
    """Write an array of light as a picture.

    Parameters
    ----------
    image : (H, W) or (H, W, 3) floats, or (H, W), (H, W, 3) or (H, W, 4) uint8
        Linear gray or linear RGB, such as what `complete` returns; values beyond 1 are white. uint8 is sRGB and written
        as it is.
    path : str or path
        Its ending names the format: .png, .jpg, .webp, .avif, .bmp or .tif.

    Raises
    ------
    InputError
        If the array has another shape or NaN in it, or the path can't be written.
    """
    array = check_array("image", image, (None, None) if len(shape_of(image)) == 2 else (None, None, None))
    channels = (3, 4) if array.dtype == np.uint8 else (3,)
    if 0 in array.shape or (array.ndim == 3 and array.shape[2] not in channels):
        raise InputError(f"image: expected shape (height, width) or (height, width, 3), got {array.shape}")
    write_picture(path, array if array.dtype == np.uint8 else color_to_8_bit(check_finite("image", array)))


def write_picture(path: str | os.PathLike[str], image: U8) -> None:
    """Write (H, W), (H, W, 3) or (H, W, 4) uint8 in the format that the ending says, whole or not at all; before black
    where that has no transparency."""
    path = check_picture_path(path, (image.shape[0], image.shape[1]))
    write_whole(path, encoded(image, FORMATS[path.suffix.lower()], str(path)))


def encoded(image: U8, kind: str, name: str) -> bytes:
    """The bytes of a picture's file; `kind` is one of `FORMATS`, `name` is for errors."""
    from PIL import Image

    content = io.BytesIO()
    has_alpha = image.ndim == 3 and image.shape[2] == 4
    picture = Image.fromarray(before("black", image) if has_alpha and kind in OPAQUE else image)
    try:
        picture.save(content, kind, **({"compress_level": PNG_LEVEL} if kind == "PNG" else {}))
    except (OSError, ValueError, KeyError) as error:  # such as a Pillow without AVIF
        raise InputError(f"{name}: can't write {image.shape[1]} x {image.shape[0]} pixels: {error}") from error
    return content.getvalue()
