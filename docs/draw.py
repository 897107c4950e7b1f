"""Draws the README's picture: the built-in scene from 5 % of its pixels.

python docs/draw.py
"""

from pathlib import Path

import bobrossnet as bob
from bobrossnet.picture.files import side_by_side, to_8_bit, traced_on_green, write_picture

SIZE = (480, 500)
FRACTION = 0.05


def main() -> None:
    full = bob.trace(bob.happy_tree(), size=SIZE)
    part = full.sample(FRACTION)
    image = bob.complete(part)
    sheet = side_by_side(
        [
            (traced_on_green(part), f"{100 * FRACTION:g} % of the pixels traced"),
            (to_8_bit(image), f"completed: SSIM {bob.ssim(image, full.gray):.2f}"),
            (to_8_bit(full.gray), "all pixels traced"),
        ]
    )
    write_picture(Path(__file__).parent / "demo.png", sheet)


if __name__ == "__main__":
    main()
