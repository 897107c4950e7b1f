"""Draws docs/perspective.png: a scene from far, near and inside, completed from a quarter of its pixels.

python docs/perspective.py
"""

from __future__ import annotations

from pathlib import Path

import bobrossnet as bob
from bobrossnet.picture.files import side_by_side, to_8_bit, write_picture

SIZE = (400, 400)
FRACTION = 0.25
CAMERAS = {
    "orthographic": bob.Camera(azimuth=-40),
    "fov=60": bob.Camera(azimuth=-40, fov=60),
    "position=(1.2, -1, 0.3), target=(0, 0, 0.8), fov=70": bob.Camera(
        position=(1.2, -1, 0.3), target=(0, 0, 0.8), fov=70
    ),
}


def main() -> None:
    scene = bob.Scene(bob.happy_tree())
    pictures = [
        (to_8_bit(bob.complete(bob.trace(scene, camera, size=SIZE, fraction=FRACTION))), caption)
        for caption, camera in CAMERAS.items()
    ]
    write_picture(Path(__file__).parent / "perspective.png", side_by_side(pictures))


if __name__ == "__main__":
    main()
