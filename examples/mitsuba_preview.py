"""A path tracer's picture from a few percent of its pixels: Mitsuba's Cornell box, with a ball of glass.

    pip install '.[mitsuba]'
    python examples/mitsuba_preview.py

writes cornell.png, first completed from 5 % of the pixels, then from growing shares; and mitsuba.png, which shows the
first one's traced pixels, the first and the last. MITSUBA_VARIANT=scalar_rgb needs no LLVM, but more time.
"""

from __future__ import annotations

import os

import mitsuba as mi

import bobrossnet as bob
from bobrossnet.adapters import mitsuba
from bobrossnet.picture.files import color_to_8_bit, side_by_side, traced_on_green, write_picture

WIDTH, HEIGHT = 480, 360


def cornell_box() -> mi.Scene:
    """Return Mitsuba's Cornell box, with two balls instead of its boxes."""
    box = mi.cornell_box()
    del box["small-box"], box["large-box"]
    box["sensor"]["film"] |= {"width": WIDTH, "height": HEIGHT}
    box["sensor"]["fov_axis"] = "y"
    box["glass"] = {"type": "sphere", "center": [0.35, -0.66, 0.35], "radius": 0.34, "bsdf": {"type": "dielectric"}}
    gold = {"type": "roughconductor", "material": "Au", "alpha": 0.15}
    box["gold"] = {"type": "sphere", "center": [-0.4, -0.6, -0.25], "radius": 0.4, "bsdf": gold}
    return mi.load_dict(box)


def main() -> None:
    mi.set_variant(os.environ.get("MITSUBA_VARIANT", "llvm_ad_rgb"))
    tracer = mitsuba.tracer(cornell_box(), spp=32)
    first = None
    for frame in bob.progressive(tracer=tracer, first=0.05, fraction=0.25):
        first = first or frame
        frame.save("cornell.png")
        print(f"cornell.png: {100 * frame.fraction:.1f} % traced in {1000 * frame.seconds:.0f} ms")
    assert first is not None
    panels = [
        (traced_on_green(first.gbuffer), f"traced: {100 * first.fraction:.1f} %"),
        (color_to_8_bit(first.color), "completed from these"),
        (color_to_8_bit(frame.color), "from all pixels"),
    ]
    write_picture("mitsuba.png", side_by_side(panels))


if __name__ == "__main__":
    main()
