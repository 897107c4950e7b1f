"""Environment maps: radiance from all directions, from .hdr, .exr or display-referred pictures."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.color import from_8_bit
from bobrossnet.picture.values import check_range
from bobrossnet.support.errors import InputError, check_array
from bobrossnet.support.paths import path_of

MAX_TEXELS = 8192 * 4096
"""Maximum number of pixels, 400 MB. Larger maps make no smoother light."""


def read_environment(image: str | os.PathLike[str] | Any) -> NDArray[np.float32]:
    """Return the linear radiance of a file or an array, (H, W, 3) float32.

    Raises
    ------
    InputError
        If the file can't be read, values are negative or not finite, or the map has too many pixels.
    """
    if not isinstance(image, str | os.PathLike):
        array = check_array("image", image, (None, None, 3))
        _check_size("image", array.shape[0], array.shape[1])
        return _frozen(check_range("color", array.astype(np.float32), "image"))
    path = path_of(image)
    try:
        if path.suffix.lower() == ".hdr":
            texels = read_hdr(path.read_bytes(), str(path))
        elif path.suffix.lower() == ".exr":
            texels = _of_exr(path)
        else:
            texels = _of_picture(path)
    except OSError as error:
        raise InputError(f"{path}: can't read it: {error.strerror or error}") from None
    if not np.isfinite(texels).all() or texels.min() < 0:
        raise InputError(f"{path}: expected radiance that is finite and at least 0")
    return _frozen(texels)


def _frozen(texels: NDArray[Any]) -> NDArray[np.float32]:
    held = np.array(texels, np.float32, order="C")
    held.flags.writeable = False
    return held


def _check_size(name: str, height: int, width: int) -> None:
    if height < 1 or width < 1 or height * width > MAX_TEXELS:
        raise InputError(
            f"{name}: expected an environment of at most 8192 x 4096 pixels, got {width} x {height}; make it smaller"
        )


def _of_exr(path: Path) -> NDArray[np.float32]:
    from bobrossnet.picture.exr import read_exr

    file = read_exr(path)
    _check_size(str(path), *file.size)
    color = file.role("color")
    if color is None:
        raise InputError(f"{path}: expected the channels R, G and B, or Y, got others")
    return np.broadcast_to(color.reshape(*file.size, -1), (*file.size, 3)).astype(np.float32)


def _of_picture(path: Path) -> NDArray[np.float32]:
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as image:
            _check_size(str(path), image.height, image.width)
            texels = np.asarray(image.convert("RGB"))
    except (UnidentifiedImageError, Image.DecompressionBombError, ValueError, SyntaxError) as error:
        raise InputError(f"{path}: expected a picture, .hdr or .exr: {error}") from None
    radiance: NDArray[np.float32] = from_8_bit(texels)
    return radiance


def read_hdr(data: bytes, name: str = "image") -> NDArray[np.float32]:
    """Decode a Radiance picture, run-length encoded or flat, to (H, W, 3) float32.

    Ward, "Real Pixels", Graphics Gems II (1991): a pixel is three mantissas and one shared exponent.
    """
    head = re.match(rb"#\?[^\n]*\n(?:[^\n]+\n)*\n-Y (\d{1,6}) \+X (\d{1,6})\n", data[:65536])
    if head is None:
        raise InputError(f"{name}: expected a Radiance picture, whose rows go down and right, got another file")
    height, width = int(head[1]), int(head[2])
    _check_size(name, height, width)
    bytes_left = np.frombuffer(data, np.uint8)[head.end() :]
    rgbe = np.empty((height, width, 4), np.uint8)
    has_runs = 8 <= width < 32768 and bytes_left[:2].tolist() == [2, 2]
    if has_runs:
        _read_runs(bytes_left.tobytes(), rgbe, name)
    else:
        if len(bytes_left) < rgbe.size:
            raise InputError(f"{name}: ends within its pixels")
        rgbe[:] = bytes_left[: rgbe.size].reshape(rgbe.shape)
    exponent = rgbe[..., 3:].astype(np.int32)
    scale = np.where(exponent > 0, np.ldexp(np.float32(1), exponent - 136), np.float32(0))
    return rgbe[..., :3].astype(np.float32) * scale.astype(np.float32)


def _read_runs(data: bytes, rgbe: NDArray[np.uint8], name: str) -> None:
    height, width = rgbe.shape[:2]
    at = 0
    row = bytearray(4 * width)
    for y in range(height):
        if data[at : at + 4] != bytes((2, 2, width >> 8, width & 255)):
            raise InputError(f"{name}: row {y} has no runs, or ends within its pixels")
        at += 4
        filled = 0
        while filled < 4 * width:
            if at + 1 >= len(data):
                raise InputError(f"{name}: ends within its pixels")
            count = data[at]
            is_run = count > 128
            length = count - 128 if is_run else count
            # A run ends within its component, as every writer ensures.
            if length == 0 or filled % width + length > width:
                raise InputError(f"{name}: row {y} has a run beyond its end")
            if is_run:
                row[filled : filled + length] = data[at + 1 : at + 2] * length
                at += 2
            else:
                piece = data[at + 1 : at + 1 + length]
                if len(piece) < length:
                    raise InputError(f"{name}: ends within its pixels")
                row[filled : filled + length] = piece
                at += 1 + length
            filled += length
        rgbe[y] = np.frombuffer(bytes(row), np.uint8).reshape(4, width).T
