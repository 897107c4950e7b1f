"""Edge-directed upsampling of small gray pictures by any factor, a rival of completion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]

TAPS = ((-1, 0), (-1, 1), (0, -1), (0, 0), (0, 1), (0, 2), (1, -1), (1, 0), (1, 1), (1, 2), (2, 0), (2, 1))
"""Rows and columns of taps relative to the pixel above and left of a point: 4 x 4 without the corners."""


def edge_directed(small: F32, height: int, width: int) -> F32:
    """Upsample a picture, (h, w), by a windowed kernel of 12 taps, stretched along the edge at each point.

    As in AMD's FidelityFX Super Resolution 1.0 (2021): the edge's direction is blended from the gradients at the four
    nearest pixels. Clearer edges get a longer kernel with a sharper window. The result is clamped to the range of
    the four pixels.
    """
    rows = (np.arange(height) + 0.5) * small.shape[0] / height - 0.5
    columns = (np.arange(width) + 0.5) * small.shape[1] / width - 0.5
    top, left = np.floor(rows).astype(int), np.floor(columns).astype(int)
    down, right = (rows - top)[:, None], (columns - left)[None, :]

    def tap(row: int, column: int) -> F32:
        i = np.clip(top + row, 0, small.shape[0] - 1), np.clip(left + column, 0, small.shape[1] - 1)
        return small[np.ix_(*i)]

    taps = {place: tap(*place) for place in TAPS}
    x, y, clear = (np.zeros((height, width)) for _ in range(3))
    for row, column in ((0, 0), (0, 1), (1, 0), (1, 1)):
        weight = (down if row else 1 - down) * (right if column else 1 - right)
        here = taps[row, column]
        for total, (before, after) in (
            (x, (taps[row, column - 1], taps[row, column + 1])),
            (y, (taps[row - 1, column], taps[row + 1, column])),
        ):
            slope = after - before
            steepest = np.maximum(np.abs(after - here), np.abs(here - before))
            total += weight * slope
            with np.errstate(invalid="ignore", divide="ignore"):
                clear += weight * np.where(steepest > 0, np.clip(np.abs(slope) / steepest, 0, 1), 0) ** 2

    length = np.hypot(x, y)
    flat = length < 1 / 256
    x, y = np.where(flat, 1, x / np.maximum(length, 1e-9)), np.where(flat, 0, y / np.maximum(length, 1e-9))
    clear = (0.5 * clear) ** 2
    stretch = 1 / np.maximum(np.abs(x), np.abs(y))  # a diagonal has the length of both sides together
    across, along = 1 + (stretch - 1) * clear, 1 - 0.5 * clear
    lobe = 0.5 - 0.29 * clear  # about 1/2 to 1/4 - 1/25: from a soft window to one like Lanczos
    limit = 1 / lobe
    total, weights = np.zeros((height, width)), np.zeros((height, width))
    for (row, column), values in taps.items():
        dx, dy = column - right, row - down
        squared = np.minimum(((dx * x + dy * y) * across) ** 2 + ((dy * x - dx * y) * along) ** 2, limit)
        window = (lobe * squared - 1) ** 2
        base = (25 / 16) * (0.4 * squared - 1) ** 2 - (25 / 16 - 1)
        weight = base * window
        total += weight * values
        weights += weight
    nearest = np.stack([taps[place] for place in ((0, 0), (0, 1), (1, 0), (1, 1))])
    return np.clip(total / weights, nearest.min(0), nearest.max(0)).astype(np.float32)
