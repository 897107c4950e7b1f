"""Error of a frame by share of traced pixels, for each mode of choice and completion.

`--write` writes the table to core/frame/errors.h, where the frame planner reads it.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from motion import FRAMES, GEAR, SIZE, scenes
from report import heading, table

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.frames.motion import View
from bobrossnet.frames.traced_frames import TracedFrames

HEADER = Path(__file__).parents[1] / "core/frame/errors.h"
SHARES = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)
STEPS = (0.5, 2.0, 4.0, 10.0, 30.0, 90.0)
"""Degrees between successive pictures of an orbit."""
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


def numbers(values: list[float]) -> str:
    return "{" + ", ".join(f"{value:#.3g}f" for value in values) + "}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--write", action="store_true", help="to core/frame/errors.h")
    write = parser.parse_args().write
    shown = scenes() | {"gear": bob.load(GEAR)}
    cameras = [bob.Camera(azimuth=30 + 360 * i / VIEWS, elevation=20) for i in range(VIEWS)]
    anew = np.mean([errors_anew(scene, camera) for scene in shown.values() for camera in cameras], 0)
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
    if write:
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
