"""What to learn from: views of procedural meshes cut into patches, and mini-batches of them, partly traced.

Everything is a function of seeds and counters: which view a shape gets, which patches stay, which pixels of a
sample are traced. So samples can be made in any order, and again. A patch is stored once, fully traced, without
a mask; `training_batch` draws one for each sample. Letters: N patches, S = 128 their size.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from bobrossnet import Camera, Scene, pixel_order, trace
from bobrossnet.learn.shapes.meshes import procedural_mesh

PATCH = 128
SIZES = (128, 256, 512)  # pictures per view, cut into 1 + 4 + 16 patches
FRACTION_LEAST = 0.01
FULL_SHARE = 0.1  # of the samples: all pixels traced; the others' fractions are log-uniform
EMPTY_BELOW = 0.02  # share of pixels with a surface below which a patch counts as background
EMPTY_KEPT = 0.1  # share of those that stay, so that black stays black


def random_generator(*counters: int) -> np.random.Generator:
    """Return the generator of some counters: a seed, what it is for, and which one of these.

    What it is for: 1 cameras, 2 background patches, 3 fractions, 4 masks, 5 epochs.
    """
    return np.random.Generator(np.random.Philox(np.random.SeedSequence(counters)))


def camera(seed: int, shape: int, view: int) -> Camera:
    """Return a view's camera: uniform on the sphere down to 30° below the shape, rolled by 10° or so."""
    rng = random_generator(seed, 1, shape, view)
    elevation = np.degrees(np.arcsin(rng.uniform(-0.5, 1)))
    return Camera(azimuth=rng.uniform(0, 360), elevation=elevation, roll=rng.normal(0, 10))


def patches_of_shape(seed: int, shape: int, views: int) -> Iterator[NDArray[np.float16]]:
    """Yield a shape's patches, each (4, S, S) float16: gray, depth, normal x, normal y; 0 off the surface."""
    # A million shapes to a seed, so that two seeds share none.
    scene = Scene([procedural_mesh(seed * 1_000_000 + shape)])
    for view in range(views):
        for size in SIZES:
            full = trace(scene, camera(seed, shape, view), size=(size, size))
            picture = full.stack()[1:]  # (4, size, size)
            keep = random_generator(seed, 2, shape, view, size).random((size // PATCH, size // PATCH))
            for (i, j), chance in np.ndenumerate(keep):
                patch = picture[:, i * PATCH : (i + 1) * PATCH, j * PATCH : (j + 1) * PATCH]
                if np.count_nonzero(patch[1]) >= EMPTY_BELOW * PATCH**2 or chance < EMPTY_KEPT:
                    yield patch.astype(np.float16)


def render_patches(
    seed: int, shapes: Iterable[int], views: int, report: Callable[[int], object] = lambda shape: None
) -> NDArray[np.float16]:
    """Return the patches of some shapes, in order.

    Parameters
    ----------
    seed : int of at least 0
    shapes : numbers of the shapes, below 1,000,000
    views : views of each, up to 21 patches a view
    report : function of a shape's number
        Called when the shape is done.

    Returns
    -------
    (N, 4, S, S) float16
        Gray, depth, normal x, normal y. float16 keeps gray to 0.00025, a sixteenth of a step of 8 bits.
    """
    shapes = list(shapes)
    most = len(shapes) * views * sum((size // PATCH) ** 2 for size in SIZES)
    # As many as there may be: the system gives no memory for what isn't written.
    patches = np.empty((most, 4, PATCH, PATCH), np.float16)
    count = 0
    for shape in shapes:
        for patch in patches_of_shape(seed, shape, views):
            patches[count] = patch
            count += 1
        report(shape)
    return patches[:count]


def sample_fraction(seed: int, sample: int) -> float:
    """Return a sample's share of traced pixels: 1 for a tenth of the samples, for the others log-uniform in 0.01..1."""
    rng = random_generator(seed, 3, sample)
    full, place = rng.random(2)
    return 1.0 if full < FULL_SHARE else float(FRACTION_LEAST ** (1 - place))


def mask(seed: int, sample: int, fraction: float, order: str = "uniform") -> NDArray[np.float32]:
    """Return (S, S) float32, 1 at the first `fraction` of the pixels in a sample's own order, at least at one."""
    count = max(round(fraction * PATCH**2), 1)
    order_seed = int(random_generator(seed, 4, sample).integers(2**31))
    pixels = pixel_order((PATCH, PATCH), order=order, seed=order_seed, count=count)
    traced = np.zeros((PATCH, PATCH), np.float32)
    traced[pixels[:, 0], pixels[:, 1]] = 1
    return traced


def batch(patches: NDArray[Any], masks: NDArray[np.float32]) -> tuple[Tensor, Tensor]:
    """Return what the network sees and what it should answer.

    Parameters
    ----------
    patches : (N, 4, S, S) float16, from `render_patches`
    masks : (N, S, S) float32, 1 where traced

    Returns
    -------
    partial : (N, 5, S, S) float32
        mask, gray, depth, normal x, normal y; 0 where not traced.
    reference : (N, 1, S, S) float32
        The whole gray picture.
    """
    whole = torch.from_numpy(np.ascontiguousarray(patches)).float()  # (N, 4, S, S)
    traced = torch.from_numpy(masks)[:, None]  # (N, 1, S, S)
    return torch.cat([traced, whole * traced], 1), whole[:, :1]


def epoch_order(seed: int, epoch: int, count: int) -> NDArray[np.int64]:
    """Return the order in which an epoch visits `count` patches."""
    return random_generator(seed, 5, epoch).permutation(count)


def training_batch(
    patches: NDArray[Any], seed: int, step: int, size: int, order: str = "uniform"
) -> tuple[Tensor, Tensor]:
    """Return the mini-batch of a step as `batch` does: `size` patches, the next ones of a shuffle anew each epoch.

    A function of its arguments alone; no step depends on those before.
    """
    samples = range(step * size, (step + 1) * size)  # counted over the whole training
    n = len(patches)
    orders = {epoch: epoch_order(seed, epoch, n) for epoch in {sample // n for sample in samples}}
    index = [orders[sample // n][sample % n] for sample in samples]
    masks = np.stack([mask(seed, sample, sample_fraction(seed, sample), order) for sample in samples])
    return batch(patches[index], masks)
