"""Draws docs/light.png: light from a twentieth of the pixels, and from all; and docs/glass.png: glass and chrome.

python docs/light.py
"""

from __future__ import annotations

from pathlib import Path

import bobrossnet as bob
from bobrossnet.picture.files import side_by_side, write_picture

HERE = Path(__file__).parent
SIZE, GLASS_SIZE = (400, 480), (360, 640)
FRACTIONS = (0.05, 1.0)
WALLS = "#dfe4ea"


def tile(x: int, y: int) -> bob.Instance:
    corners = [(x, y, -1), (x + 1, y, -1), (x + 1, y + 1, -1), (x, y + 1, -1)]
    color = "#e8e4dc" if (x + y) % 2 else "#9a3b2e"
    stone = bob.Material(color, ambient=0, diffuse=1, specular=0)
    return bob.Instance(bob.Mesh(corners, [(0, 1, 2), (0, 2, 3)]), material=stone)


def glass_and_chrome() -> bob.Scene:
    """Balls of glass, of chrome and of green glass on a checkered floor."""
    ball = bob.implicit(lambda x, y, z: x**2 + y**2 + z**2 - 1, bounds=((-1, -1, -1), (1, 1, 1)))
    chrome = bob.Material("#f4f4f4", metallic=1, roughness=0)
    return bob.Scene(
        [
            *(tile(x, y) for x in range(-5, 5) for y in range(-5, 5)),
            bob.Instance(ball, material=bob.Glass()).translate((1.2, -1.3, 0)),
            bob.Instance(ball, material=chrome).translate((0.4, 1.4, 0)),
            bob.Instance(ball, material=bob.Glass(attenuation="#3c8f6a", distance=1))
            .scale(0.5)
            .translate((2.6, 0.4, -0.5)),
        ],
        light="studio",
        ground=False,
    )


def main() -> None:
    pictures = [
        (bob.render(bob.happy_tree(), size=SIZE, fraction=share, light="studio", background="#ffffff"), share)
        for share in FRACTIONS
    ]
    panels = [(picture.rgba[..., :3], f"{share:.0%} of the pixels") for picture, share in pictures]
    write_picture(HERE / "light.png", side_by_side(panels))
    look = bob.Camera(azimuth=20, elevation=22, fov=35, zoom=1.75)
    bob.render(glass_and_chrome(), look, size=GLASS_SIZE, samples=16, background=WALLS).save(HERE / "glass.png")


if __name__ == "__main__":
    main()
