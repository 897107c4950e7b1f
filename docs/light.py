"""Draws docs/light.png: light from a twentieth of the pixels, and from all.

python docs/light.py
"""

from __future__ import annotations

from pathlib import Path

import bobrossnet as bob
from bobrossnet.picture.files import side_by_side, write_picture

SIZE = (400, 480)
FRACTIONS = (0.05, 1.0)


def main() -> None:
    pictures = [
        (bob.render(bob.happy_tree(), size=SIZE, fraction=share, light="studio", background="#ffffff"), share)
        for share in FRACTIONS
    ]
    panels = [(picture.rgba[..., :3], f"{share:.0%} of the pixels") for picture, share in pictures]
    write_picture(Path(__file__).parent / "light.png", side_by_side(panels))


if __name__ == "__main__":
    main()
