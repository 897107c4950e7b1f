"""Error of a frame by share of traced pixels, for each mode of choice and completion.

`--write` writes the table to core/frame/errors.h, where the frame planner reads it. `--sizes` instead compares sizes of
pictures with the same number of traced pixels.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from motion import FRAMES, GEAR, SIZE, scenes
from PIL import Image
from report import heading, table

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.frames.motion import View
from bobrossnet.frames.traced_frames import TracedFrames

HEADER = Path(__file__).parents[1] / "core/frame/errors.h"
SHARES = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)
STEPS = (0.5, 2.0, 4.0, 10.0, 30.0, 90.0)
"""Degrees between successive pictures of an orbit."""
SHARES_OF_SCREEN = (0.01, 0.02, 0.04, 0.08, 0.16)
WINDOW = (800, 950)
"""Size of the page's picture in a window of 1280x800."""
SCALES = (1, 1.25, 1.5, 2, 2.5, 3, 4, 5, 6, 8)
VIEWS = 2
ANEW = (("squares", "filling"), ("adaptive", "filling"), ("adaptive", "small"), ("adaptive", "default"))
COUNTED = range(FRAMES - 4, FRAMES)
"""Compared frames of an orbit."""


def errors_anew(scene: bob.Scene, camera: bob.Camera) -> list[list[float]]:
    """Return 1 - SSIM of new pictures, by mode and share."""
    full = bob.trace(scene, camera, size=SIZE)
    return [
        [1 - bob.ssim(bob.complete(full.sample(share, order=order), model=model), full.gray) for share in SHARES]
        for order, model in ANEW
    ]


class Reprojecting(_core.FramePlanner):
    """A planner that reprojects in every frame."""

    def plan_pixels(self, pixels: int, parallax: float) -> str:
        return "reproject"


def error_reprojected(scene: bob.Scene, first: bob.Camera, step: float, share: float) -> float:
    """Return 1 - SSIM of an orbit's last pictures; each reprojects earlier samples and traces a share of its pixels."""
    view = View(scene, size=SIZE, model="filling")
    assert isinstance(view._frames, TracedFrames)
    view._frames.planner.core = Reprojecting(SIZE[0] * SIZE[1], ["default"])
    found = []
    for k in range(FRAMES):
        camera = bob.Camera(azimuth=first.azimuth + step * k, elevation=first.elevation)
        image = view.frame(camera, fraction=share).image
        if k in COUNTED:
            found.append(1 - bob.ssim(image, bob.trace(scene, camera, size=SIZE).gray))
    return float(np.mean(found))


def parallax_of(step: float) -> float:
    """Return the parallax of an orbit's step."""
    before, after = (bob.Camera(azimuth=azimuth, elevation=20).core((0, 0, 0), 1) for azimuth in (30, 30 + step))
    return _core.parallax(before, after, *SIZE)


def error_enlarged(full: bob.GBuffer, scene: bob.Scene, camera: bob.Camera, scale: float, share: float = 1) -> float:
    """Return 1 - SSIM of a smaller picture with `share` of the pixels of `full`, if it has as many, in its size."""
    height, width = full.mask.shape
    size = round(height / scale), round(width / scale)
    part = bob.trace(scene, camera, size=size, fraction=min(1, share * scale**2), order="squares")
    small = Image.fromarray(bob.complete(part, "filling"))
    return 1 - bob.ssim(np.asarray(small.resize((width, height), Image.Resampling.BILINEAR)), full.gray)


def errors_enlarged(scene: bob.Scene, camera: bob.Camera) -> list[float]:
    full = bob.trace(scene, camera, size=SIZE)
    return [error_enlarged(full, scene, camera, scale) for scale in SCALES]


def compare_sizes(shown: dict[str, bob.Scene], camera: bob.Camera) -> None:
    heading(f"1 - SSIM of squares by the size of the picture, {WINDOW[1]}x{WINDOW[0]}, means of {len(shown)} scenes")
    rows = []
    full = {name: bob.trace(scene, camera, size=WINDOW) for name, scene in shown.items()}
    for share in SHARES_OF_SCREEN:
        errors = [
            np.mean([error_enlarged(full[name], scene, camera, scale, share) for name, scene in shown.items()])
            for scale in SCALES[:6]
        ]
        rows.append([f"{share:.0%}", *(f"{error:.4f}" for error in errors)])
    table(["traced, of all", *(f"smaller by {scale:g}" for scale in SCALES[:6])], rows)


def numbers(values: list[float]) -> str:
    return "{" + ", ".join(f"{value:#.3g}f" for value in values) + "}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--write", action="store_true", help="to core/frame/errors.h")
    parser.add_argument("--sizes", action="store_true", help="compare sizes of pictures")
    options = parser.parse_args()
    shown = scenes() | {"gear": bob.load(GEAR)}
    cameras = [bob.Camera(azimuth=30 + 360 * i / VIEWS, elevation=20) for i in range(VIEWS)]
    if options.sizes:
        return compare_sizes(shown, cameras[0])
    anew = np.mean([errors_anew(scene, camera) for scene in shown.values() for camera in cameras], 0)
    enlarged = np.mean([errors_enlarged(scene, camera) for scene in shown.values() for camera in cameras], 0)
    moving = np.array(
        [
            [
                np.mean([error_reprojected(scene, cameras[0], step, share) for scene in shown.values()])
                for share in SHARES
            ]
            for step in STEPS
        ]
    )
    parallaxes = [parallax_of(step) for step in STEPS]
    heading(f"1 - SSIM by the share of the pixels, 640x480, means of {len(shown)} scenes")
    rows = [
        [f"{mode}, {completion}", *(f"{x:.4f}" for x in row)]
        for (mode, completion), row in zip(ANEW, anew, strict=True)
    ]
    rows += [
        [f"reproject, {step:g}° a frame", *(f"{x:.4f}" for x in row)] for step, row in zip(STEPS, moving, strict=True)
    ]
    table(["way", *(f"{share:.1%}" for share in SHARES)], rows)
    table(["all pixels of a picture smaller by", *map(str, SCALES)], [["1 - SSIM", *(f"{x:.4f}" for x in enlarged)]])
    if options.write:
        lines = [
            "/// 1 - SSIM by the share of the pixels that are traced, as `bench/frame_errors.py --write` measured it.",
            "#pragma once",
            "",
            "#include <iterator>",
            "",
            "namespace bob::frame_errors {",
            "",
            f"constexpr float shares[] = {numbers(list(SHARES))};",
            *(
                f"constexpr float {mode}_{completion}[] = {numbers(row)};"
                for (mode, completion), row in zip(ANEW, anew.tolist(), strict=True)
            ),
            f"constexpr float enlarged[] = {numbers(enlarged.tolist())};  // by MovingScale::scales",
            f"constexpr float parallaxes[] = {numbers(parallaxes)};",
            "constexpr float reproject[][std::size(shares)] = {",
            *(f"    {numbers(row)}," for row in moving.tolist()),
            "};",
            "",
            "}  // namespace bob::frame_errors",
        ]
        HEADER.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
