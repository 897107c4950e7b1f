"""Shuffled mini-batches of a data set on disk, with random access by number.

An epoch visits the shapes in blocks: a block's patches are read, and their samples shuffled. So each view is read once
in an epoch, not once for each patch at 4 milliseconds each; at most two blocks are in memory; and a mini-batch is a
function of (seed, epoch, step) alone.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from functools import lru_cache
from threading import Lock
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from bobrossnet.learn.dataset.plan import PATCH, PATCHES, SIZES, STAGES, Plan, random_generator
from bobrossnet.learn.dataset.store import CHANNELS, Dataset, joined, part_of
from bobrossnet.picture.order import FIXED_ORDERS
from bobrossnet.picture.sequence import places_in_sequence
from bobrossnet.support.errors import InputError, check_integer

BLOCK = 64  # shapes in a block: 176 MB, and 88 MB for the adaptive orders
AHEAD = 4  # mini-batches prepared ahead by each worker


class Fractions(NamedTuple):
    """Distribution of the share of traced pixels: log-uniform, with 1 for some of the samples."""

    least: float
    most: float
    whole: float = 0  # share of the samples with every pixel traced
    later: tuple[int, float] | None = None  # an epoch, counted from 0, and the maximum from then on


DRAWS = ("each", "by-detail")
"""Draws of an epoch's samples: each of the split once, or the same number with detailed patches more often."""

FLAT = 0.05  # weight of a patch without detail in draws by detail, relative to the mean patch

FRACTIONS = {"stages": None, "log-uniform": Fractions(0.01, 1, 0.1), "sparse": Fractions(0.005, 0.9, later=(6, 0.3))}
"""Distributions by name; "stages" has the shares of the samples' plan.

Whatever many pixels can teach is learned early, and is kept.
"""


class Batch(NamedTuple):
    """A mini-batch of inputs and targets of the network.

    Attributes
    ----------
    partial : (n, 5, 128, 128) float32
        mask, gray, depth, normal x, normal y; 0 where not traced.
    reference : (n, 1, 128, 128) float32
        The whole gray picture.
    numbers : (n,) int64, of the samples in the plan
    fractions : (n,) float64, shares of the pixels traced
    """

    partial: Tensor
    reference: Tensor
    numbers: NDArray[np.int64]
    fractions: NDArray[np.float64]


class Batches:
    """The mini-batches of an epoch; `batches[step]` is a function of the arguments alone.

    Parameters
    ----------
    dataset : Dataset
    split : "train", "validation" or "test"
    size : samples of a mini-batch; the last may have fewer
    seed : of the shuffle
    epoch : number of the epoch, which determines the shuffle and the masks
    shuffle : if false, samples are in the order of their numbers, with the masks of epoch 0
    draw : one of `DRAWS`
        By detail, most nearly uniform patches are omitted, and a sample repeated in an epoch has a different mask each
        time.
    order : pixel order of the masks; with several, "lattice+uniform", each sample alternates from epoch to epoch
    fractions : a name in `FRACTIONS`
        The shares of the samples' plan, or new random shares in each epoch.
    rank, ranks : index of this process, and number of processes
        It gets every `ranks`-th sample of each mini-batch.

    Raises
    ------
    InputError
        If a name is unknown or a number is out of range.
    """

    def __init__(
        self,
        dataset: Dataset,
        split: str,
        *,
        size: int = 32,
        seed: int = 0,
        epoch: int = 0,
        shuffle: bool = True,
        draw: str = "each",
        order: str = "uniform",
        fractions: str = "stages",
        rank: int = 0,
        ranks: int = 1,
    ) -> None:
        if fractions not in FRACTIONS:
            raise InputError(f"fractions: expected one of {', '.join(FRACTIONS)}, got {fractions!r}")
        if draw not in DRAWS:
            raise InputError(f"draw: expected one of {', '.join(DRAWS)}, got {draw!r}")
        self.dataset = dataset
        self.size = check_integer("size", size, 1, 2**31 - 1)
        self.epoch = epoch if shuffle else 0
        self.orders = order.split("+")
        self.fractions = fractions
        self.rank, self.ranks = rank, ranks
        rng = random_generator(seed, 5, epoch)
        shapes = rng.permutation(dataset.plan.shapes) if shuffle else np.arange(dataset.plan.shapes)
        samples = dataset.plan.split(split)
        if draw == "by-detail":
            samples = drawn_by(dataset.detail.ravel()[samples // len(STAGES)], samples, rng)
        self._shapes = shapes
        self._block_of_shape = np.argsort(shapes) // BLOCK
        of_block = self._block_of_shape[samples // (PATCHES * len(STAGES))]  # the block of each sample
        blocks = [samples[of_block == block] for block in range(-(-len(shapes) // BLOCK))]
        self.samples = np.concatenate([rng.permutation(block) if shuffle else block for block in blocks])
        # The number and the turn of a sample determine its traced pixels.
        count = len(samples)
        self._turns = np.full(count, self.epoch) if draw == "each" else self.epoch * count + np.arange(count)
        self._lock = Lock()
        self._read = lru_cache(maxsize=2)(self._read_block)
        self._places = lru_cache(maxsize=2 * BLOCK * len(SIZES))(self._places_in_view)

    def __len__(self) -> int:
        return -(-len(self.samples) // self.size)

    def __getitem__(self, step: int) -> Batch:
        if not 0 <= step < len(self):
            raise IndexError(f"step: expected 0..{len(self) - 1}, got {step}")
        mine = slice(step * self.size + self.rank, (step + 1) * self.size, self.ranks)
        numbers, turns = self.samples[mine], self._turns[mine].tolist()
        fractions = np.array([self._fraction(*drawn) for drawn in zip(numbers.tolist(), turns, strict=True)])
        partial = torch.empty(len(numbers), 1 + len(CHANNELS), PATCH, PATCH)
        reference = torch.empty(len(numbers), 1, PATCH, PATCH)
        drawn = zip(numbers.tolist(), turns, fractions.tolist(), strict=True)
        for i, (number, turn, fraction) in enumerate(drawn):
            patch = torch.from_numpy(self._patch(number))
            partial[i, 0] = torch.from_numpy(self._mask(number, fraction, turn))
            partial[i, 1:] = patch
            reference[i, 0] = partial[i, 1]
            partial[i, 1:] *= partial[i, 0]
        return Batch(partial, reference, numbers, fractions)

    def stream(self, first: int = 0, workers: int = 1) -> Iterator[Batch]:
        """Yield the mini-batches from step `first` on, prepared by `workers` threads, or on demand for 0."""
        if workers == 0:
            yield from (self[step] for step in range(first, len(self)))
            return
        with ThreadPoolExecutor(workers) as pool:
            waiting: deque[Future[Batch]] = deque()
            try:
                for step in range(first, len(self)):
                    waiting.append(pool.submit(self.__getitem__, step))
                    if len(waiting) > AHEAD * workers:
                        yield waiting.popleft().result()
                while waiting:
                    yield waiting.popleft().result()
            finally:
                for future in waiting:
                    future.cancel()

    def _fraction(self, number: int, turn: int) -> float:
        drawn = FRACTIONS[self.fractions]
        if drawn is None:
            return self.dataset.plan.sample(number).fraction
        most = drawn.later[1] if drawn.later and self.epoch >= drawn.later[0] else drawn.most
        whole, place = random_generator(self.dataset.plan.seed, 3, number, turn).random(2)
        return 1.0 if whole < drawn.whole else float(drawn.least * (most / drawn.least) ** place)

    def _mask(self, number: int, fraction: float, turn: int) -> NDArray[np.float32]:
        """Return the traced pixels of a sample, (128, 128).

        An adaptive order visits the whole view, as in actual tracing, so a patch may have more or fewer pixels than its
        share.
        """
        plan, order = self.dataset.plan, self.orders[(number + turn) % len(self.orders)]
        if order in FIXED_ORDERS:
            return plan.mask(number, fraction, turn=turn, order=order)
        sample = plan.sample(number)
        places = self._places(sample.shape, sample.size, order)
        row, column = sample.row * PATCH, sample.column * PATCH
        count = max(round(fraction * sample.size**2), 1)
        return (places[row : row + PATCH, column : column + PATCH] < count).astype(np.float32)

    def _places_in_view(self, shape: int, size: int, order: str) -> NDArray[np.int32]:
        view = joined(self._patches(shape)[Plan.patches_of_view(size)]).astype(np.float32)
        whole = part_of(view, np.ones((size, size), np.float32))
        return places_in_sequence(whole.planes, whole.layout, order, self.dataset.plan.seed)

    def _patch(self, number: int) -> NDArray[np.float16]:
        """Return the patch of a sample, (4, 128, 128)."""
        shape, patch = divmod(number // len(STAGES), PATCHES)
        return np.asarray(self._patches(shape)[patch])

    def _patches(self, shape: int) -> NDArray[np.float16]:
        with self._lock:
            return self._read(int(self._block_of_shape[shape]))[shape]

    def _read_block(self, block: int) -> dict[int, NDArray[np.float16]]:
        shapes = self._shapes[block * BLOCK : (block + 1) * BLOCK].tolist()
        return {shape: self.dataset.patches(shape) for shape in shapes}


def drawn_by(weights: NDArray[np.float64], samples: NDArray[np.int64], rng: np.random.Generator) -> NDArray[np.int64]:
    """Draw len(samples) samples with replacement; each occurs in proportion to its weight, rounded up or down."""
    ends = np.cumsum(weights + FLAT * weights.mean())
    places = (np.arange(len(samples)) + rng.random()) / len(samples) * ends[-1]
    drawn: NDArray[np.int64] = samples[np.minimum(np.searchsorted(ends, places), len(samples) - 1)]
    return drawn
