"""Draws docs/color.png: materials, a texture and vertex colours, completed from a tenth of the pixels, and exact.

python docs/color.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.picture.files import side_by_side, traced_on_green, write_picture
from bobrossnet.sdf import X, Y, Z, box, cylinder, sphere, torus

SIZE = (360, 440)
CAMERA = bob.Camera(azimuth=35, elevation=30, zoom=1.15, pan=(0.1, 0))


def ball(**colors: NDArray[np.float64] | NDArray[np.uint8]) -> bob.Mesh:
    """Return a unit ball's mesh with uv."""
    u, v = np.meshgrid(np.linspace(0, 1, 97), np.linspace(0, 1, 49), indexing="ij")
    around, down = 2 * np.pi * u, np.pi * v
    points = np.stack([np.cos(around) * np.sin(down), np.sin(around) * np.sin(down), np.cos(down)], -1).reshape(-1, 3)
    index = np.arange(len(points)).reshape(u.shape)
    a, b, c, d = (corner.ravel() for corner in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, d, b], -1), np.stack([b, d, c], -1)])
    if "texture" in colors:
        return bob.Mesh(points, triangles, points, uv=np.stack([6 * u, 3 * v], -1).reshape(-1, 2), **colors)
    return bob.Mesh(points, triangles, points, colors=(points + 1) / 2)


def scene() -> bob.Scene:
    drill = cylinder(0.5)
    carved = (sphere(1) & box(1.5)) - (drill.orient(X) | drill.orient(Y) | drill.orient(Z))
    checks = np.full((32, 32, 3), (238, 228, 208), np.uint8)
    checks[:16, :16], checks[16:, 16:] = (178, 58, 48), (46, 84, 140)
    return bob.Scene(
        [
            bob.Instance(ball(texture=checks)).translate((0, -2.3, 0)),
            bob.Instance(ball()).translate((0, 2.3, 0)),
            bob.Instance(carved, material=bob.Material("#c8952c", metallic=1, roughness=0.35)),
            bob.Instance(torus(0.8, 0.3), material=bob.Material("#2f7f5f")).translate((2.3, 0, -0.7)),
            bob.Instance(sphere(0.6), material=bob.Material("#8e3b7a", roughness=0.25)).translate((1.7, 2.1, -0.4)),
        ]
    )


def main() -> None:
    shown = scene()
    part = bob.trace(shown, CAMERA, size=SIZE, fraction=0.1)
    background = ("#ffffff", "#c9d3de")
    completed = bob.render(shown, CAMERA, size=SIZE, fraction=0.1, background=background)
    exact = bob.render(shown, CAMERA, size=SIZE, samples=16, background=background)
    pictures = [
        (traced_on_green(part), "10 % of the pixels"),
        (completed.rgba[..., :3], "completed"),
        (exact.rgba[..., :3], "exact, 16 rays at edges"),
    ]
    write_picture(Path(__file__).parent / "color.png", side_by_side(pictures))


if __name__ == "__main__":
    main()
