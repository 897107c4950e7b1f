"""Draws the README's first picture: the gallery's knot turning, from 5 % of its pixels and from all pixels.

python docs/turning.py
"""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from gallery import NURBS, NURBS_HELPERS, made
from PIL import Image

import bobrossnet as bob
from bobrossnet.picture.files import U8, side_by_side, to_8_bit
from bobrossnet.support.atomic import write_whole

FRACTION = 0.05
SIZE = (276, 276)  # three in a row have the width of a README: scaling would make the traced pixels shimmer
CROP = slice(20, 256)  # rows: the knot is wider than high
FRAMES = 36
TURN = 360 / 5  # degrees; the knot repeats after a fifth of a turn, so the loop has no seam
FRAME_MS = 60
UNTRACED = 44  # dark enough to set off the traced pixels, lighter than traced black background
QUALITY = 68  # traced pixels smear below 65; the file exceeds 600 kB above 70


def frame(scene: bob.Scene, azimuth: float) -> U8:
    """Return one frame of the turn: (H, W, 3) uint8."""
    full = bob.trace(scene, bob.Camera(azimuth=azimuth, elevation=50), size=SIZE)
    part = full.sample(FRACTION)
    traced = np.where(part.mask > 0, to_8_bit(part.gray), np.uint8(UNTRACED))
    panels = [
        (traced, f"{100 * FRACTION:g} % traced"),
        (to_8_bit(bob.complete(part)), "completed"),
        (to_8_bit(full.gray), "exact"),
    ]
    return side_by_side([(image[CROP], caption) for image, caption in panels])


def main() -> None:
    scene = made(NURBS["a knot"], NURBS_HELPERS)
    frames = [Image.fromarray(frame(scene, TURN * i / FRAMES)) for i in range(FRAMES)]
    content = io.BytesIO()
    frames[0].save(
        content,
        "WebP",
        save_all=True,
        append_images=frames[1:],
        duration=FRAME_MS,
        loop=0,
        quality=QUALITY,
        method=6,
    )
    write_whole(Path(__file__).parent / "turning.webp", content.getvalue())


if __name__ == "__main__":
    main()
