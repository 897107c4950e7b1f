"""Training of the error predictor, the weights of core/completion/error_predictor.h.

The pictures are completed by one network. The predictions also hold for networks of equal or lower quality, since the
features include a network's errors at the traced pixels.

The output is the logarithm of the expected error. It is fitted by the likelihood of a Poisson variable of that mean,
which depends on the mean alone. A squared loss would be dominated by the few worst pixels, a loss on the logarithm by
the many nearly correct ones.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.completion.network import load_network
from bobrossnet.completion.weights import FORMAT
from bobrossnet.learn.checkpoint import write_tensors
from bobrossnet.learn.checks import MAX_SHAPES, check_weights_path
from bobrossnet.learn.evaluation.scenes import Scenes, each_scene, own_scenes
from bobrossnet.picture.order import ADAPTIVE
from bobrossnet.support.errors import check_integer
from bobrossnet.support.progress import progress

F32 = NDArray[np.float32]

FEATURES = 14
HIDDEN = 32
ORDERS = ("uniform", "lattice", ADAPTIVE)
FRACTIONS = (0.0005, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5)
SIZE = (256, 256)
EVERY = 16  # learn from one pixel in this number
STEPS, BATCH, RATE = 6000, 8192, 5e-3
LOWEST, HIGHEST = -14.0, 0.0  # as in the core
NEGLIGIBLE = 5e-5  # pictures with smaller mean errors weigh no more
CHECKED = 5  # hold out one shape in this number, to set the safety margin
SURE = 0.95  # share of held-out pictures with at most the predicted error; early stops by luck are the rest


class Layers(nn.Module):
    """The predictor; the layers have the names of its tensors."""

    def __init__(self) -> None:
        super().__init__()
        self.hidden = nn.Linear(FEATURES, HIDDEN)
        self.output = nn.Linear(HIDDEN, 1)
        nn.init.constant_(self.output.bias, -4.0)  # an initial error of 0.02

    def forward(self, features: Tensor) -> Tensor:
        """Map features, (P, FEATURES), to the logarithms of the errors, (P,)."""
        logarithms: Tensor = self.output(self.hidden(features).relu())[:, 0]
        return logarithms.clamp(LOWEST, HIGHEST)


class Picture(NamedTuple):
    """The training data of a completed picture: P of its pixels, and its mean error."""

    features: F32  # (P, FEATURES)
    errors: F32  # (P,), absolute
    mean: float  # mean error of all pixels
    untraced: float  # share of untraced pixels


def calibrate(
    out: str | os.PathLike[str], *, model: str = "default", shapes: int = 250, steps: int = STEPS, seed: int = 0
) -> list[float]:
    """Train the error predictor on procedural shapes, and write its weights.

    Parameters
    ----------
    out : path ending in .safetensors
    model : name of shipped weights, or a .safetensors file
        The network that completes the pictures.
    shapes : int, at least 2
        A fifth of them is held out. Predictions are scaled so that a share of `SURE` of the held-out pictures has at
        most the predicted error.
    steps : of training
    seed : of the choice of pixels, and of the initial weights

    Returns
    -------
    list of float
        The true mean error as a share of the predicted one, for each held-out picture.

    Raises
    ------
    InputError
        If an argument is invalid, or the file can't be written.
    """
    check_weights_path(out)
    check_integer("shapes", shapes, 2, MAX_SHAPES)
    torch.manual_seed(seed)
    learned: list[Picture] = []
    checked: list[Picture] = []
    with progress("completing") as report:
        for number, picture in _pictures(own_scenes(shapes, first=0), model, np.random.default_rng(seed)):
            (checked if number % CHECKED == CHECKED - 1 or number == shapes - 1 else learned).append(picture)
            report((number + 1) / shapes)
    layers = _fit(learned, steps)
    ratios = np.array([picture.mean / _mean(layers, picture) for picture in checked if picture.mean > 0])
    margin = float(np.quantile(ratios, SURE))
    with torch.no_grad():
        layers.output.bias.add_(float(np.log(margin)))
    header = {"format": FORMAT, "network": "uncertainty", "model": Path(model).stem, "shapes": str(shapes)}
    write_tensors(Path(out), layers.state_dict(), header)
    return [float(ratio) for ratio in ratios / margin]


def _pictures(scenes: Scenes, model: str, rng: np.random.Generator) -> Iterator[tuple[int, Picture]]:
    """Yield completed pictures with the indices of their scenes."""
    network = load_network(model)
    for number, _, scene in each_scene(scenes, stacklevel=3):
        full = bob.trace(scene, bob.Camera(azimuth=37 * number % 360, elevation=(20, 45)[number % 2]), size=SIZE)
        for order in ORDERS:
            for fraction in FRACTIONS:
                part = full.sample(fraction, order=order, seed=number)
                untraced = np.flatnonzero(part.mask == 0)
                chosen = rng.choice(untraced, max(1, len(untraced) // EVERY), replace=False)
                predicted = network.predict(part)
                features = np.empty((FEATURES, *SIZE), np.float32)
                _core.error_features(part.layout.core, part.planes, predicted[None], features)
                errors = np.abs(bob.complete(part, model=network) - full.gray)
                yield (
                    number,
                    Picture(
                        np.ascontiguousarray(features.reshape(FEATURES, -1)[:, chosen].T),
                        errors.ravel()[chosen],
                        float(errors.mean()),
                        len(untraced) / part.mask.size,
                    ),
                )


def _fit(pictures: Sequence[Picture], steps: int) -> Layers:
    """Train the two layers; each picture has the same weight, whatever its error."""
    features = torch.from_numpy(np.concatenate([picture.features for picture in pictures]))
    errors = torch.from_numpy(np.concatenate([picture.errors for picture in pictures]))
    weights = torch.cat([torch.full((len(p.errors),), 1 / max(p.mean, NEGLIGIBLE)) for p in pictures])
    weights /= weights.mean()
    middle, spread = features.mean(0), features.std(0) + 1e-6
    layers = Layers()
    optimizer = torch.optim.Adam(layers.parameters(), RATE)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)
    with progress("learning") as report:
        for step in range(steps):
            chosen = torch.randint(len(errors), (BATCH,))
            logarithms = layers((features[chosen] - middle) / spread)
            loss = (weights[chosen] * (logarithms.exp() - errors[chosen] * logarithms)).mean()
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            report((step + 1) / steps)
    with torch.no_grad():  # folds the normalisation of the features into the weights
        layers.hidden.weight.div_(spread)
        layers.hidden.bias.sub_(layers.hidden.weight @ middle)
    return layers


def _mean(layers: Layers, picture: Picture) -> float:
    """Return the predicted mean error of a whole picture."""
    with torch.no_grad():
        return float(layers(torch.from_numpy(picture.features)).exp().mean()) * picture.untraced
