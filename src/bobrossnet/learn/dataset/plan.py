"""The plan of a data set: its samples and their splits. Nothing is rendered here.

Each shape has three views of 128², 256² and 512² pixels, each from a different direction. A view is cut into patches of
128², 1 + 4 + 16 for each shape, and a patch gives a sample at each of five stages of convergence. Everything is a
function of a seed and of counters, so that samples are reproducible in any order, anywhere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet.learn.checks import MAX_SEED, MAX_SHAPES
from bobrossnet.picture.camera import Camera
from bobrossnet.picture.order import pixel_order
from bobrossnet.support.errors import InputError, check_integer

SHAPES = 479
TEST_SHAPES = 10
PATCH = 128  # pixels
SIZES = (128, 256, 512)  # sizes of the views
STAGES = (0.01, 0.25, 0.5, 0.75, 1.0)  # shares of traced pixels
VALIDATION_SHARE = 0.1  # of the patches outside the test split
SPLITS = ("train", "validation", "test")

FOVS = (20.0, 70.0)  # degrees, range in a coloured data set, where half of the views are in perspective

PATCHES = sum((size // PATCH) ** 2 for size in SIZES)  # patches of a shape
_FIRST_PATCH = dict(zip(SIZES, np.cumsum([0, *((size // PATCH) ** 2 for size in SIZES)]).tolist(), strict=False))


class Sample(NamedTuple):
    """The origin of a sample: a patch of a view, and its share of traced pixels."""

    shape: int
    size: int  # side of the view, one of `SIZES`
    row: int  # of the patch in the view, in patches
    column: int
    fraction: float


@dataclass(frozen=True)
class Plan:
    """The samples of a data set: `shapes` x 21 patches x 5 stages, numbered in this order.

    A `colored` one has shapes with colours and textures, and half of its views in perspective; otherwise all are white
    and orthographic.

    Raises
    ------
    InputError
        If a number is out of range.
    """

    seed: int = 0
    shapes: int = SHAPES
    test_shapes: int = TEST_SHAPES
    colored: bool = False

    def __post_init__(self) -> None:
        check_integer("seed", self.seed, 0, MAX_SEED)
        check_integer("shapes", self.shapes, 2, MAX_SHAPES)
        check_integer("test_shapes", self.test_shapes, 1, MAX_SHAPES)
        if self.test_shapes >= self.shapes:
            raise InputError(f"test_shapes: expected fewer than all {self.shapes} shapes, got {self.test_shapes}")

    @property
    def samples(self) -> int:
        """Number of samples."""
        return self.shapes * PATCHES * len(STAGES)

    def sample(self, number: int) -> Sample:
        """Return the origin of sample `number`, 0 to `samples` - 1."""
        shape, patch, stage = np.unravel_index(number, (self.shapes, PATCHES, len(STAGES)))
        size = max(size for size in SIZES if _FIRST_PATCH[size] <= patch)
        row, column = divmod(int(patch) - _FIRST_PATCH[size], size // PATCH)
        return Sample(int(shape), size, row, column, STAGES[stage])

    def split(self, name: str) -> NDArray[np.int64]:
        """Return the numbers of the samples for "train", "validation" or "test", ascending.

        Test shapes are drawn from all shapes. Of the other shapes' patches a tenth is drawn for validation, with all of
        its stages, so that no picture serves both training and validation.
        """
        if name not in SPLITS:
            raise InputError(f"split: expected one of {', '.join(SPLITS)}, got {name!r}")
        for_testing = random_generator(self.seed, 6).permutation(self.shapes) < self.test_shapes  # by shape
        patches = np.arange(self.shapes * PATCHES)
        test = for_testing[patches // PATCHES]
        if name == "test":
            chosen = patches[test]
        else:
            others = patches[~test]
            shuffled = random_generator(self.seed, 7).permutation(others)
            count = round(VALIDATION_SHARE * len(others))
            chosen = np.sort(shuffled[:count] if name == "validation" else shuffled[count:])
        return (chosen[:, None] * len(STAGES) + np.arange(len(STAGES))).ravel()

    @staticmethod
    def patches_of_view(size: int) -> slice:
        """Return the slice of a shape's patches that belong to its view of this size."""
        return slice(_FIRST_PATCH[size], _FIRST_PATCH[size] + (size // PATCH) ** 2)

    def camera(self, shape: int, size: int) -> Camera:
        """Return a view's camera: uniform on the sphere down to 30° below the shape, rolled by about 10°."""
        rng = random_generator(self.seed, 1, shape, size)
        elevation = float(np.degrees(np.arcsin(rng.uniform(-0.5, 1))))
        camera = Camera(azimuth=rng.uniform(0, 360), elevation=elevation, roll=rng.normal(0, 10))
        in_perspective = self.colored and rng.random() < 0.5
        return replace(camera, fov=rng.uniform(*FOVS)) if in_perspective else camera

    def mask(self, number: int, fraction: float, *, turn: int = 0, order: str = "uniform") -> NDArray[np.float32]:
        """Return the mask of a sample's traced pixels.

        Parameters
        ----------
        number : number of the sample
        fraction : share of the pixels, above 0; at least one pixel is traced
        turn : draws different pixels for each value, such as an epoch's number
        order : one of `FIXED_ORDERS`

        Returns
        -------
        (128, 128) float32, 1 where traced, otherwise 0
        """
        count = max(round(fraction * PATCH**2), 1)
        traced = np.ones((PATCH, PATCH), np.float32)
        if count < PATCH**2:
            order_seed = int(random_generator(self.seed, 4, number, turn).integers(2**31))
            pixels = pixel_order((PATCH, PATCH), order=order, seed=order_seed, count=count)
            traced[:] = 0
            traced[pixels[:, 0], pixels[:, 1]] = 1
        return traced


def random_generator(*counters: int) -> np.random.Generator:
    """Return a random generator for some counters: a seed, a purpose, and an index within the purpose.

    Purposes: 1 cameras, 2 shapes, 3 fractions, 4 masks, 5 epochs, 6 test shapes, 7 validation.
    """
    return np.random.Generator(np.random.Philox(np.random.SeedSequence(counters)))
