"""Mini-batches of a data set, shuffled, from disk, any of them by its number.

An epoch goes through the shapes in blocks: the patches of some shapes are read, and their samples are shuffled among
each other. So a view is read once an epoch, instead of a patch at a time, at 4 milliseconds each; no more than two
blocks are in memory; and a mini-batch is a function of (seed, epoch, step) alone.
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

BLOCK = 64  # shapes read at a time: 176 MB, and 88 of places in adaptive orders
AHEAD = 4  # mini-batches made ahead by each worker


class Fractions(NamedTuple):
    """How shares of traced pixels are drawn: log-uniform between two, and 1 for some of the samples."""

    least: float
    most: float
    whole: float = 0  # share of the samples that have all pixels traced
    later: tuple[int, float] | None = None  # from this epoch on, counted from 0, at most so many


DRAWS = ("each", "by-detail")
"""How an epoch's samples are drawn: each of the split once, or as many, patches with more detail more often."""

FLAT = 0.05  # how often a patch without any detail is drawn by detail, beside the mean patch

FRACTIONS = {"stages": None, "log-uniform": Fractions(0.01, 1, 0.1), "sparse": Fractions(0.005, 0.9, later=(6, 0.3))}
"""By name; "stages" has the shares of the samples' plan. What can be learned from many pixels is learned early, and
stays."""


class Batch(NamedTuple):
    """A mini-batch: what the network sees and what it should answer.

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
    """The mini-batches of one epoch; `batches[step]` is a function of the arguments alone.

    Parameters
    ----------
    dataset : Dataset
    split : "train", "validation" or "test"
    size : samples of a mini-batch; the last may have fewer
    seed : of the shuffle
    epoch : which shuffle, and which masks
    shuffle : without it, the samples come in the order of their numbers, with the masks of epoch 0
    draw : one of `DRAWS`
        By detail, most of the patches that show next to nothing are left out, and what comes up several times in an
        epoch has another mask each time.
    order : pixel order of the masks; of several, "lattice+uniform", each sample has one, in turn from epoch to epoch
    fractions : a name in `FRACTIONS`
        The shares of the samples' plan, or shares drawn anew in each epoch.
    rank, ranks : with several processes, which of how many this one is
        It gets every `ranks`-th sample of each mini-batch.

    Raises
    ------
    InputError
        If a name names nothing or a number is out of its range.
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
        # A sample and its turn say which pixels are traced.
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
        """Yield the mini-batches from step `first` on, made ahead by `workers` threads; without any, when asked for."""
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
        """The traced pixels of a sample, (128, 128). An adaptive order goes through the whole view, as it would if that
        was traced, so that a patch may have more pixels than its share, or fewer."""
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
        """The patch of a sample, (4, 128, 128)."""
        shape, patch = divmod(number // len(STAGES), PATCHES)
        return np.asarray(self._patches(shape)[patch])

    def _patches(self, shape: int) -> NDArray[np.float16]:
        with self._lock:
            return self._read(int(self._block_of_shape[shape]))[shape]

    def _read_block(self, block: int) -> dict[int, NDArray[np.float16]]:
        shapes = self._shapes[block * BLOCK : (block + 1) * BLOCK].tolist()
        return {shape: self.dataset.patches(shape) for shape in shapes}


def drawn_by(weights: NDArray[np.float64], samples: NDArray[np.int64], rng: np.random.Generator) -> NDArray[np.int64]:
    """Draw as many samples as there are, with replacement: each comes up as often as its weight says, rounded up or
    down."""
    ends = np.cumsum(weights + FLAT * weights.mean())
    places = (np.arange(len(samples)) + rng.random()) / len(samples) * ends[-1]
    drawn: NDArray[np.int64] = samples[np.minimum(np.searchsorted(ends, places), len(samples) - 1)]
    return drawn
