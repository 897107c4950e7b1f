"""Conversion to display-referred values for the networks, and back to the G-buffer's own range."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.gbuffer import GBuffer


def displayed(gbuffer: GBuffer) -> GBuffer:
    """Return the G-buffer with display-referred gray and colour, and depth in 0..1."""
    transfer = gbuffer.transfer
    if transfer is None:
        return gbuffer
    return GBuffer.from_stack(transfer.planes(gbuffer.planes, gbuffer.layout), gbuffer.layout)


def restored(image: NDArray[np.float32], gbuffer: GBuffer) -> NDArray[np.float32]:
    """Map a completed display-referred picture, (H, W), to the G-buffer's range; traced pixels keep their values."""
    transfer = gbuffer.transfer
    if transfer is None:
        return image
    image = transfer.decode(image)
    np.copyto(image, gbuffer.gray, where=gbuffer.mask > 0)
    return image
