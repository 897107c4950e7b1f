"""Model with NURBS: a vault with windows, half a cylinder of exact radius, and a handrail next to it.

    python examples/nurbs.py

writes vault.png, a picture, and vault.bob, which `bobrossnet render vault.bob` draws.
"""

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.picture.files import to_8_bit, write_picture

LENGTH, RADIUS = 4.0, 1.0

# Half a circle in two quarters of degree 2, from 0 to 2: The NURBS Book, section 7.3.
HALF_CIRCLE = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0)], np.float64)
WEIGHTS = np.array([1, np.sqrt(0.5), 1, np.sqrt(0.5), 1])
KNOTS = np.array([0, 0, 0, 1, 1, 2, 2, 2], np.float64)


def window(u: float, v: float) -> list[NDArray[np.float64] | bob.TrimCurve]:
    """Return a loop in the vault's parameters: three straight sides, then an arch back to the start."""
    sides = np.array([(u + 0.2, v + 0.2), (u, v + 0.2), (u, v - 0.2), (u + 0.2, v - 0.2)])
    arch = HALF_CIRCLE[:, ::-1] * (0.15, -0.2) + (u + 0.2, v)
    return [sides, bob.TrimCurve(arch, KNOTS, WEIGHTS)]


def vault() -> bob.Brep:
    """Return the vault; u runs across it from 0 to 2, v along it from 0 to 4."""
    control_points = [[(x, y, z) for y in (0, LENGTH)] for x, z in RADIUS * HALF_CIRCLE]
    weights = np.stack([WEIGHTS, WEIGHTS], axis=1)
    border = [(0, 0), (2, 0), (2, LENGTH), (0, LENGTH)]
    windows = [window(0.3, v) for v in np.arange(0.5, LENGTH)]
    return bob.nurbs_surface(control_points, KNOTS, [0, 0, LENGTH, LENGTH], weights, [border, *windows])


def handrail() -> bob.Tube:
    """Return a cubic curve of two pieces, thicker at its ends."""
    points = [(1.3, 0, 0), (1.3, 0, 0.8), (1.3, 2, 0.2), (1.3, LENGTH, 0.8), (1.3, LENGTH, 0)]
    return bob.nurbs_curve(points, [0, 0, 0, 0, 1, 2, 2, 2, 2], radius=[0.1, 0.04, 0.04, 0.04, 0.1])


def main() -> None:
    scene = bob.Scene([bob.Instance(vault(), material=bob.Material("#e8e8e8")), handrail()])
    camera = bob.Camera(azimuth=-30, elevation=30, zoom=1.3)
    write_picture("vault.png", to_8_bit(bob.trace(scene, camera, size=(480, 640)).gray))
    bob.save_scene(scene, "vault.bob")

    hits = scene.closest_hits([(0, LENGTH / 2, 5)], [(0, 0, -1)])
    print(f"Straight above its middle, the vault is {5 - hits.distance[0]:.6f} high, at u = {hits.u[0]:.6f}.")


if __name__ == "__main__":
    main()
