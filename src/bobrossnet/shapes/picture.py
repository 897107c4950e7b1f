"""Texture images, shared by meshes."""

from __future__ import annotations

from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.shapes.shape import frozen
from bobrossnet.support.errors import InputTypeError, check_array, shape_of
from bobrossnet.support.threads import lazy


class Picture:
    """The texels of a texture, decoded once and stored once for all meshes.

    Parameters
    ----------
    texels : (H, W, 3) uint8
        sRGB, row 0 at the top. Taken over, not copied.
    alpha : (H, W) uint8, optional
        Opacity of each texel; if omitted, all are opaque. Taken over.
    """

    def __init__(self, texels: NDArray[np.uint8], alpha: NDArray[np.uint8] | None = None) -> None:
        for array in (texels, alpha):
            if array is not None:
                array.flags.writeable = False
        self.texels, self.alpha = texels, alpha

    @lazy
    def core(self) -> _core.Picture:
        return _core.Picture(self.texels, self.alpha)

    @lazy
    def digest(self) -> bytes:
        """SHA-256 of the texels and the alpha."""
        tensors: dict[str, NDArray[Any]] = {"texels": self.texels.reshape(-1, 3)}
        if self.alpha is not None:
            tensors["alpha"] = self.alpha.reshape(-1)
        return _core.shape_digest("picture", tensors)

    @lazy
    def opaque(self) -> Picture:
        """Return the same texels without alpha."""
        return self if self.alpha is None else Picture(self.texels)

    @lazy
    def max_alpha(self) -> int:
        """Maximum alpha of all texels, 0..255."""
        return 255 if self.alpha is None else int(self.alpha.max())

    def is_of(self, texels: NDArray[Any]) -> bool:
        """Return whether its texels equal these, (H, W, 3) or (H, W, 4)."""
        if texels is self.texels:
            return self.alpha is None
        if texels.shape != (*self.texels.shape[:2], 3 + (self.alpha is not None)):
            return False
        return bool(
            np.array_equal(texels[..., :3], self.texels)
            and (self.alpha is None or np.array_equal(texels[..., 3], self.alpha))
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return Picture, (self.texels, self.alpha)  # the core's objects can't be copied


def channels_of(values: Any) -> int:
    """Return the channels to expect of a user's colours: 4 with an alpha, otherwise 3."""
    return 4 if shape_of(values)[-1:] == (4,) else 3


_PICTURES: WeakValueDictionary[int, Picture] = WeakValueDictionary()
"""Pictures in use, by the `id` of the source array."""


def picture_of(texture: Any) -> Picture:
    """Return the picture of a user's texture, cached by array until its values change.

    Raises
    ------
    InputError
        If it is not an array (H, W, 3) or (H, W, 4) of uint8.
    """
    if isinstance(texture, Picture):
        return texture
    channels = channels_of(texture)
    hint = "red, green and blue last, and alpha if there is one"
    texels = check_array("texture", texture, (None, None, channels), hint=hint)
    if texels.dtype != np.uint8 or texels.size == 0:
        raise InputTypeError(f"texture: expected uint8 of at least one texel, got {texels.dtype} {texels.shape}")
    known = _PICTURES.get(id(texture))
    if known is not None and known.is_of(texels):
        return known
    alpha = frozen(texels[..., 3], np.uint8) if channels == 4 else None
    picture = Picture(frozen(texels[..., :3], np.uint8), alpha)
    for array in (texture, picture.texels) if alpha is None else (texture,):
        _PICTURES[id(array)] = picture
    return picture
