"""Measure a sample by few dwells: any measurement is a tracer, and a dwell is a pixel.

    python examples/measuring.py                 a made sample, measured with noise until its error is small
    python examples/measuring.py IMAGE           the error of an image file by the share of its pixels

IMAGE may be the X-ray image of docs/measuring.md. It needs the extra `train`.
"""

import sys
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.completion.filling import delaunay_linear
from bobrossnet.picture.files import side_by_side, to_8_bit, traced_on_green, write_picture

F32 = NDArray[np.float32]

SIZE = (240, 320)
COUNTS = 3000  # photons of a dwell where the sample is brightest
ENOUGH = 0.004  # mean absolute error
SHARES = (0.05, 0.1, 0.2, 0.27)


def flakes(seed: int = 1) -> F32:
    """Return a sample of bright flakes on a dark film, (H, W) in 0..1."""
    rng = np.random.default_rng(seed)
    y, x = np.indices(SIZE)
    image = np.full(SIZE, 0.02)
    for _ in range(40):
        across, down, angle, size = (
            rng.uniform(0, SIZE[1]),
            rng.uniform(0, SIZE[0]),
            rng.uniform(0, 3),
            rng.uniform(4, 22),
        )
        u = (x - across) * np.cos(angle) + (y - down) * np.sin(angle)
        v = (y - down) * np.cos(angle) - (x - across) * np.sin(angle)
        flake = np.maximum(np.abs(u), 1.7 * np.abs(v)) < size
        image[flake] = rng.uniform(0.2, 1) + 0.1 * (u[flake] / size)
    clipped: F32 = np.clip(image, 0, 1).astype(np.float32)
    return clipped


class Microscope:
    """A scanning microscope: it counts photons at one place after the other."""

    def __init__(self, sample: F32, counts: float) -> None:
        self.sample, self.counts = sample, counts
        self.dwells = 0
        self._rng = np.random.default_rng(0)

    def __call__(self, pixels: NDArray[np.int32]) -> bob.Samples:
        """Measure the places, (n, 2) rows and columns."""
        self.dwells += len(pixels)
        counted = self._rng.poisson(self.counts * self.sample[tuple(pixels.T)])
        return bob.Samples(gray=counted / self.counts, variance=np.maximum(counted, 1) / self.counts**2)


def measure() -> None:
    """Measure the flakes until the predicted error is small enough, and write the picture."""
    sample = flakes()
    microscope = Microscope(sample, COUNTS)
    for frame in bob.progressive(tracer=microscope, size=SIZE, fraction=0.02, until=ENOUGH):
        true = np.abs(frame.image - sample).mean()
        share = f"{microscope.dwells} dwells, {100 * frame.fraction:.0f} %"
        print(f"{share}: error {frame.error:.4f} predicted, {true:.4f} true")
    panels = [
        (traced_on_green(frame.gbuffer), f"{100 * frame.fraction:.0f} % of the places measured"),
        (to_8_bit(frame.image), "completed"),
        (to_8_bit(sample), "the sample"),
    ]
    write_picture("measuring.png", side_by_side(panels))


# ---- An image file in the place of the sample ----------------------------------------------------------------------


def normalized_error(image: F32, truth: F32) -> float:
    """Return the norm of the error divided by the norm of the truth, as scikit-image does by default."""
    return float(np.linalg.norm(image - truth) / np.linalg.norm(truth))


def compare(path: str) -> None:
    """Print errors by the share of the pixels of an image file, noise-free."""
    import cv2

    read = cv2.imread(path, cv2.IMREAD_UNCHANGED)
    if read is None:
        sys.exit(f"{path}: expected an image file, got none that OpenCV reads")
    values = read.astype(np.float64)
    values = values if values.ndim == 2 else values[..., :3].mean(2)
    truth = ((values - values.min()) / (values.max() - values.min())).astype(np.float32)
    full = bob.GBuffer(mask=np.ones_like(truth), gray=truth)
    methods: dict[str, tuple[str, Callable[[bob.GBuffer], F32]]] = {
        "uniform, delaunay-linear": ("uniform", lambda part: delaunay_linear(part.gray, part.mask)),
        "adaptive, default": ("adaptive", bob.complete),
    }
    for name, (order, complete) in methods.items():
        for share in SHARES:
            image = complete(full.sample(share, order=order))
            scores = f"NRMSE {normalized_error(image, truth):.3f}, SSIM {bob.ssim(image, truth):.3f}"
            print(f"{name}, {100 * share:g} %: {scores}")


if __name__ == "__main__":
    compare(sys.argv[1]) if len(sys.argv) > 1 else measure()
