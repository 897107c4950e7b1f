"""Plug a tracer of your own into BobRossNet: here a torus, found by sphere tracing in numpy.

    python examples/your_own_tracer.py

writes torus.png every tenth of a second; the first is complete after a few percent of the rays, the last exact.
"""

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob

HEIGHT, WIDTH = SIZE = (480, 640)
RING, TUBE = 0.65, 0.28  # in the unit sphere, viewed from (0, -1, 1)

RIGHT = np.array([1.0, 0, 0])
UP = np.array([0, 1, 1]) / np.sqrt(2)
TOWARD = np.array([0, -1, 1]) / np.sqrt(2)


def signed_distance(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the signed distance of points, (n, 3), from the torus; negative inside."""
    from_ring = np.hypot(points[:, 0], points[:, 1]) - RING
    return np.hypot(from_ring, points[:, 2]) - TUBE


def trace(pixels: NDArray[np.int32]) -> bob.Samples:
    """Trace one ray through each pixel's centre."""
    x = (pixels[:, 1] + 0.5 - WIDTH / 2) / (HEIGHT / 2)
    y = (HEIGHT / 2 - pixels[:, 0] - 0.5) / (HEIGHT / 2)
    points = x[:, None] * RIGHT + y[:, None] * UP + 1.5 * TOWARD
    for _ in range(60):
        points -= signed_distance(points)[:, None] * TOWARD
    hit = np.abs(signed_distance(points)) < 1e-4

    step = 1e-5
    gradient = [signed_distance(points + step * axis) - signed_distance(points - step * axis) for axis in np.eye(3)]
    normal = np.stack(gradient, axis=1) / (2 * step)
    gray = 0.15 + 0.85 * np.clip(normal @ (TOWARD + 0.5 * UP - 0.3 * RIGHT) / np.sqrt(1.34), 0, 1)
    gray[~hit] = 0  # background; any colour is allowed
    depth = np.clip(0.5 + 0.5 * points @ TOWARD, 0, 1)
    return bob.Samples(gray, depth, np.stack([normal @ RIGHT, normal @ UP], axis=1), hit)


def main() -> None:
    for frame in bob.progressive(tracer=trace, size=SIZE, frame_ms=100):
        frame.save("torus.png", background="#000000")
        print(f"torus.png: {100 * frame.fraction:.1f} % traced in {1000 * frame.seconds:.0f} ms")


if __name__ == "__main__":
    main()
