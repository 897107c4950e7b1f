"""Finished pictures, colour and coverage, displayed by notebooks and written to files."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.color import from_8_bit
from bobrossnet.picture.files import png, write_picture
from bobrossnet.support.threads import lazy


class Picture:
    """A colour picture with alpha. `numpy.asarray(picture)` is `rgba`; notebooks display it.

    Parameters
    ----------
    color : (H, W, 3) float32 in 0..1
        Linear RGB over black, premultiplied: a half-covered pixel has half its surface's colour.
    alpha : (H, W) float32 in 0..1
        Coverage of each pixel.
    """

    def __init__(self, color: NDArray[np.float32], alpha: NDArray[np.float32]) -> None:
        self.color, self.alpha = color, alpha

    @classmethod
    def opaque(cls, srgb: NDArray[np.uint8]) -> Picture:
        """Return the picture of sRGB values, (H, W, 3); `rgba` has exactly these."""
        return _Opaque(srgb)

    def __reduce__(self) -> tuple[Any, ...]:
        return Picture, (self.color, self.alpha)

    @property
    def size(self) -> tuple[int, int]:
        """(height, width)"""
        return self.alpha.shape[0], self.alpha.shape[1]

    @lazy
    def rgba(self) -> NDArray[np.uint8]:
        """(H, W, 4) uint8: sRGB with straight alpha, as in PNG; 0 on the background."""
        rgba = _core.rgba(self.color, self.alpha)
        rgba.flags.writeable = False
        return rgba

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the picture in the format of the path's ending: .png, .webp, .avif, .jpg, .bmp or .tif.

        Formats without transparency get a black background.

        Raises
        ------
        InputError
            If the ending is unknown, or the file can't be written.
        """
        write_picture(path, self.rgba)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.rgba, dtype, copy=copy)

    def _repr_png_(self) -> bytes:
        return png(self.rgba)

    def __repr__(self) -> str:
        return f"Picture({self.size[0]} x {self.size[1]}, {100 * float(self.alpha.mean()):.3g} % covered)"


class _Opaque(Picture):
    """A picture of sRGB values, decoded only if its light is asked for: files have the values themselves."""

    def __init__(self, srgb: NDArray[np.uint8]) -> None:
        rgba = np.full((*srgb.shape[:2], 4), 255, np.uint8)
        rgba[..., :3] = srgb
        rgba.flags.writeable = False
        self.rgba = rgba

    def __reduce__(self) -> tuple[Any, ...]:
        return _Opaque, (self.rgba[..., :3],)

    @lazy
    def color(self) -> NDArray[np.float32]:  # type: ignore[override]
        return from_8_bit(self.rgba[..., :3])

    @lazy
    def alpha(self) -> NDArray[np.float32]:  # type: ignore[override]
        return np.ones(self.rgba.shape[:2], np.float32)
