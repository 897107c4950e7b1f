"""A name plate: letters and a heart of pixels on a rounded plate.

python examples/name_plate.py [name] [font file]
"""

import sys
from contextlib import suppress

import numpy as np

import bobrossnet as bob
from bobrossnet.sdf import SDF3, image, measure_text, rounded_box, text

FONTS = "DejaVuSans-Bold.ttf", "arialbd.ttf", "Arial Bold.ttf", "LiberationSans-Bold.ttf", "Helvetica.ttc"
"""Fonts to try; most systems have one of them."""

HEART = """
.##...##.
#########
#########
.#######.
..#####..
...###...
....#....
"""


def found_font() -> str:
    """Return a font of this system, or matplotlib's."""
    for font in FONTS:
        with suppress(bob.InputError):
            measure_text(font, "A")
            return font
    try:
        import matplotlib
    except ModuleNotFoundError:
        sys.exit("found no font: python examples/name_plate.py NAME FONT_FILE")
    return f"{matplotlib.get_data_path()}/fonts/ttf/DejaVuSans-Bold.ttf"


def parts(name: str, font: str) -> tuple[SDF3, SDF3, SDF3]:
    """Return a plate that fits the name, the lettering, and the heart."""
    width, height = measure_text(font, name, height=1)
    plate = rounded_box((width + 1, height + 1.8, 0.4), 0.15)
    letters = text(font, name, height=1).extrude(0.2).translate((0, -0.4, 0.2))
    pixels = np.array([[pixel == "#" for pixel in row] for row in HEART.split()])
    heart = image(pixels, height=0.6).extrude(0.2).translate((0, 0.75, 0.2))
    return plate, letters, heart


def main() -> None:
    name = sys.argv[1] if len(sys.argv) > 1 else "Hello, world"
    font = sys.argv[2] if len(sys.argv) > 2 else found_font()
    plate, letters, heart = parts(name, font)
    colors = "#23406a", "#f2e3b3", "#c8323c"
    shapes = [
        bob.Instance(part, material=bob.Material(color))
        for part, color in zip((plate, letters, heart), colors, strict=True)
    ]
    camera = bob.fitted(shapes, bob.Camera(azimuth=-80, elevation=55), size=(320, 960))
    bob.render(shapes, camera, size=(320, 960), samples=4, background="#fff").save("name_plate.png")
    plate.union(letters, heart).save("name_plate.stl", step=0.02)  # for a 3D printer
    print(f"name_plate.png and name_plate.stl: {name}")


if __name__ == "__main__":
    main()
