"""Train the default network further from whole views, on one core, with all kinds of masks.

python runs/whole-views/further.py START OUT [--views N] [--steps N]

START and OUT are .safetensors files; OUT has the moving average of the weights.
"""

from __future__ import annotations

import argparse
import copy
import json
import math
import multiprocessing
from pathlib import Path

import numpy as np
import torch
from run import HERE, PLANES, SIZE, make_views
from torch import Tensor

from bobrossnet.learn.checkpoint import load, save
from bobrossnet.learn.losses import dissimilarity, l1
from bobrossnet.learn.muon import Muon
from bobrossnet.learn.networks import Network
from bobrossnet.learn.networks.interpolation import blend, interpolated
from bobrossnet.picture.order import pixel_order

FIRST_SHAPE = 40_000  # after those of run.py
CROP, PHASES = 192, (0, 64)  # crops begin at multiples of the coarsest lattice's step
DETAILED = 0.02  # mean step of gray between rows from which a crop is always used
AVERAGE = 0.998
ORDERS = ("adaptive", "lattice", "uniform")
OFTEN = (0.55, 0.2, 0.25)
SHARES = {  # of traced pixels: few, how often, and many
    "adaptive": ((0.006, 0.15), 0.85, (0.15, 0.6)),
    "lattice": ((0.006, 0.2), 0.6, (0.2, 0.8)),
    "uniform": ((0.006, 0.2), 0.6, (0.2, 0.8)),
}


def made_views(count: int) -> np.ndarray:
    """Make views of the package's own shapes, (count, PLANES, SIZE, SIZE) uint16 as in run.py."""
    context = multiprocessing.get_context("fork")
    views, done = np.empty((count, PLANES, SIZE, SIZE), np.uint16), np.zeros(count, np.uint8)
    none = np.zeros((0, 0, 0))
    next_shape, next_slot = context.Value("q", FIRST_SHAPE), context.Value("q", 0)
    make_views(0, (none, none), none, views, done, none, next_shape, next_slot, math.inf)
    return views


class Batches:
    """Random crops with pixels of a random order and share, and their references."""

    def __init__(self, views: np.ndarray, size: int) -> None:
        self.views, self.size, self.random = views, size, np.random.default_rng(0)
        self.lattice = np.empty((SIZE, SIZE), np.int64)
        pixels = pixel_order((SIZE, SIZE), order="lattice")
        self.lattice[pixels[:, 0], pixels[:, 1]] = np.arange(SIZE**2)

    def next(self) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Return partial pictures (N, 5, H, W), references, interpolated values and their weights, (N, 1, H, W)."""
        partial, references = [], []
        while len(partial) < self.size:
            top, left = self.random.choice(PHASES, 2)
            window = (slice(top, top + CROP), slice(left, left + CROP))
            view = self.views[self.random.integers(len(self.views))][(slice(None), *window)]
            planes = view[:4].view(np.float16).astype(np.float32)
            if self.random.random() > np.abs(np.diff(planes[0], axis=0)).mean() / DETAILED:
                continue
            order = self.random.choice(ORDERS, p=OFTEN)
            few, often, many = SHARES[order]
            low, high = few if self.random.random() < often else many
            count = max(1, round(low * (high / low) ** self.random.random() * SIZE**2))
            if order == "adaptive":
                places = view[4]
            elif order == "lattice":
                places = self.lattice[window]
            else:
                places = self.random.permutation(SIZE**2)[: CROP**2].reshape(CROP, CROP)
            mask = (places < count).astype(np.float32)[None]
            partial.append(np.concatenate([mask, planes * mask]))
            references.append(planes[:1])
        pixels = torch.from_numpy(np.stack(partial))
        return pixels, torch.from_numpy(np.stack(references)), *interpolated(pixels[:, 1:2], pixels[:, :1])


def losses(network: Network, batch: tuple[Tensor, Tensor, Tensor, Tensor]) -> Tensor:
    """Return the loss of each completed picture, (N,)."""
    pixels, reference, value, weight = batch
    image = torch.where(pixels[:, :1] > 0, pixels[:, 1:2], blend(network(pixels), value, weight))
    return dissimilarity(image, reference) + l1(image, reference)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("start", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--views", type=int, default=2300)
    parser.add_argument("--steps", type=int, default=1500)
    parser.add_argument("--batch", type=int, default=6)
    parser.add_argument("--rate", type=float, default=0.001)
    options = parser.parse_args()
    torch.set_num_threads(1)
    batches = Batches(made_views(options.views), options.batch)
    network, _ = load(options.start)
    average = copy.deepcopy(network).requires_grad_(False)
    optimizer = Muon(network.parameters(), options.rate)
    training = {"script": HERE.name, "order": "adaptive+lattice+uniform", "loss": "ssim+l1", "optimizer": "muon"}
    settings = {name: getattr(options, name) for name in ("views", "steps", "batch", "rate")}
    header = {"training": json.dumps({**training, **settings, "average": AVERAGE})}
    for step in range(options.steps):
        of_pictures = losses(network, batches.next())
        importance = (of_pictures.detach() + 0.004) ** -0.5
        warm = min(1, (step + 1) / 50)
        for group in optimizer.param_groups:
            group["lr"] = options.rate * warm * 0.5 * (1 + math.cos(math.pi * step / options.steps))
        loss = (of_pictures * importance / importance.mean()).mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        decay = min(AVERAGE, (1 + step) / (10 + step))
        with torch.no_grad():
            torch._foreach_lerp_(list(average.parameters()), list(network.parameters()), 1 - decay)
        if (step + 1) % 200 == 0:
            print(f"step {step + 1}, loss {loss:.4f}", flush=True)
            save(options.out, average, header)
    save(options.out, average, header)


if __name__ == "__main__":
    main()
