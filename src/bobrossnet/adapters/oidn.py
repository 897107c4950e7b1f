"""Intel's Open Image Denoise, for pictures with every pixel traced and noisy. Needs the extra `oidn`.

from bobrossnet.adapters import oidn

frame = next(bob.progressive(tracer=tracer, first=1))  # all pixels, few paths each
color = oidn.denoise(frame.gbuffer)
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.guides import Guides, check_guides
from bobrossnet.picture.values import check_range
from bobrossnet.support.errors import InputError, check_array

F32 = NDArray[np.float32]


def denoise(picture: GBuffer | Any, guides: Guides | None = None) -> F32:
    """Denoise a picture.

    Parameters
    ----------
    picture : GBuffer with every pixel traced, or (H, W, 3) numbers of at least 0
        Linear RGB of any range.
    guides : Guides, optional
        Noise-free albedo and normals; by default the G-buffer's guides. Without guides, the G-buffer's own albedo and
        normals are used; with one ray per pixel, they are aliased at edges.

    Returns
    -------
    (H, W, 3) float32, linear RGB >= 0, in the range of the picture
        All pixels change, even exact ones.

    Raises
    ------
    InputError
        If pyoidn is not installed, a pixel is missing, or `guides` are of another size.

    References
    ----------
    Áfra, "Intel Open Image Denoise", https://www.openimagedenoise.org: filter RT for HDR colours.
    """
    pyoidn = _pyoidn()
    known: GBuffer | Guides | None
    if isinstance(picture, GBuffer):
        missing = picture.mask.size - int(np.count_nonzero(picture.mask))
        if missing:
            raise InputError(
                f"picture: expected a G-buffer with every pixel traced, got {missing} of {picture.mask.size} missing; "
                "bobrossnet.complete makes a picture of these"
            )
        color, known = picture.color, picture.guides or picture
    else:
        color, known = check_range("color", check_array("picture", picture, (None, None, 3)), "picture"), None
    if guides is not None:
        known = check_guides(guides, color.shape[:2])
    further = {}
    if known is not None:
        x, y = np.moveaxis(known.normal, -1, 0)
        hit = known.hit if isinstance(known, Guides) else known.alpha
        normal = np.stack([x, y, np.sqrt(np.maximum(0, 1 - x * x - y * y)) * hit], axis=-1)
        further = {"albedo": known.albedo, "normal": normal}
    color, *others = (np.ascontiguousarray(array, np.float32) for array in (color, *further.values()))
    is_clean = isinstance(known, Guides)
    result: F32 = pyoidn.denoise(color, hdr=True, clean_aux=is_clean, **dict(zip(further, others, strict=True)))
    return np.maximum(result, 0)


def _pyoidn() -> Any:
    try:
        import pyoidn
    except ModuleNotFoundError as error:
        raise InputError(f"oidn: this needs {error.name}: pip install 'bobrossnet[oidn]'") from None
    return pyoidn
