"""Backgrounds of pictures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet.color import Color, from_srgb, linear, to_srgb
from bobrossnet.pictures.rendered import Picture

BLACK = "#000000"
"""Default background of the page and of sparse pictures."""

Background: TypeAlias = Color | Sequence[Color] | None


def picture_of(color: NDArray[np.float32], alpha: NDArray[np.float32], background: Background = None) -> Picture:
    """Composite linear light, (H, W, 3), with coverage, (H, W), over a background.

    Every picture, traced or completed, passes through here, so that all look the same.
    """
    behind = background_rows(background, len(alpha))
    if behind is None:
        return Picture(color, alpha)
    return Picture(color + (1 - alpha[..., None]) * behind, np.ones_like(alpha))


def background_rows(background: Any, height: int) -> NDArray[np.float32] | None:
    """Return the linear RGB of each row, (H, 1, 3), or None for None.

    Two colours are blended in sRGB, which looks even to the eye.
    """
    if background is None:
        return None
    are_two = not isinstance(background, str) and isinstance(background, Sequence) and len(background) == 2
    top, bottom = background if are_two else (background, background)
    ends = to_srgb(np.array([linear("background", top), linear("background", bottom)], np.float32))
    share = np.linspace(0, 1, height, dtype=np.float32)[:, None]
    return np.asarray(from_srgb((1 - share) * ends[0] + share * ends[1]), np.float32)[:, None]
