"""A name plate: letters and a heart of pixels, engraved in a rounded box.

python examples/name_plate.py [name] [font file]
"""

import sys

import matplotlib
import numpy as np

import bobrossnet as bob
from bobrossnet.sdf import SDF3, image, measure_text, rounded_box, text

HEART = """
.##...##.
#########
#########
.#######.
..#####..
...###...
....#....
"""


def name_plate(name: str, font: str) -> SDF3:
    """A plate that is as wide as the name needs."""
    width, height = measure_text(font, name, height=1)
    plate = rounded_box((width + 1, height + 2, 0.4), 0.15)
    letters = text(font, name, height=1).extrude(0.2).translate((0, -0.4, 0.2))
    pixels = np.array([[pixel == "#" for pixel in row] for row in HEART.split()])
    heart = image(pixels, height=0.7).extrude(0.2).translate((0, height / 2 + 0.3, 0.2))
    return plate.difference(letters, heart)


def main() -> None:
    name = sys.argv[1] if len(sys.argv) > 1 else "Hello, world"
    font = sys.argv[2] if len(sys.argv) > 2 else f"{matplotlib.get_data_path()}/fonts/ttf/DejaVuSans-Bold.ttf"
    plate = name_plate(name, font)
    camera = bob.fitted(plate, bob.Camera(azimuth=-85, elevation=60))
    bob.render(plate, camera, size=(480, 960), samples=2, background="#fff").save("name_plate.png")
    plate.save("name_plate.stl", step=0.02)  # for a printer
    print(f"name_plate.png and name_plate.stl: {name}")


if __name__ == "__main__":
    main()
