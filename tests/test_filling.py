"""The fillings, baselines of the networks."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from bobrossnet.completion.filling import FILLINGS, delaunay_linear, nearest, pull_push, telea
from bobrossnet.metrics import ssim
from bobrossnet.support.errors import InputError

every_filling = pytest.mark.parametrize("fill", FILLINGS.values(), ids=FILLINGS.keys())
Filling = Callable[[Any, Any], np.ndarray]


def partial(size: tuple[int, int], fraction: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return a disc on black and the mask of its known pixels."""
    y, x = np.mgrid[: size[0], : size[1]] / np.array(size)[:, None, None] - 0.5
    gray = np.where(x * x + y * y < 0.16, 0.6 + x - y, 0).astype(np.float32)
    mask = np.random.default_rng(seed).random(size) < fraction
    mask.flat[seed % mask.size] = True
    return gray, mask


@every_filling
@pytest.mark.parametrize("size", [(64, 64), (37, 53), (1, 9), (5, 1), (1, 1), (128, 3)])
def test_known_pixels_are_kept(fill: Filling, size: tuple[int, int]) -> None:
    gray, mask = partial(size, 0.2)
    filled = fill(np.where(mask, gray, 7), mask)  # values under unknown pixels aren't read
    assert filled.dtype == np.float32
    assert filled.shape == size
    np.testing.assert_array_equal(filled[mask], gray[mask])
    beyond = 0.1 if fill is telea else 1e-6  # it follows gradients, an 8-bit step for each pixel
    assert filled.min() >= gray[mask].min() - beyond
    assert filled.max() <= gray[mask].max() + beyond


@every_filling
def test_all_known_and_one_known(fill: Filling) -> None:
    gray, mask = partial((19, 30), 0.0)
    np.testing.assert_array_equal(fill(gray, np.ones_like(gray)), gray)
    tolerance = 0.1 if fill is telea else 1e-6
    np.testing.assert_allclose(fill(gray + 0.25, mask), gray[mask][0] + 0.25, atol=tolerance)


@every_filling
def test_better_with_more_pixels(fill: Filling) -> None:
    scores = []
    for fraction in (0.02, 0.1, 0.5, 1.0):
        gray, mask = partial((128, 128), fraction)
        scores.append(ssim(fill(gray, mask), gray))
    assert scores == sorted(scores)
    assert scores[1] > 0.8
    assert scores[-1] == 1


def test_nearest_is_the_nearest() -> None:
    gray, mask = partial((24, 31), 0.05)
    known = np.argwhere(mask)
    filled = nearest(gray, mask)
    for row, column in np.ndindex(*gray.shape):
        distance = ((known - (row, column)) ** 2).sum(1)
        candidates = gray[tuple(known[distance == distance.min()].T)]
        assert filled[row, column] in candidates


def test_delaunay_is_exact_on_a_plane() -> None:
    y, x = np.mgrid[:40, :50]
    plane = (0.01 * x + 0.005 * y).astype(np.float32)
    mask = np.random.default_rng(3).random(plane.shape) < 0.1
    mask[[0, 0, -1, -1], [0, -1, 0, -1]] = True  # the hull is the picture
    np.testing.assert_allclose(delaunay_linear(plane, mask), plane, atol=1e-5)
    components = np.stack([plane, 1 - plane, plane**2], -1)
    expected = np.stack([delaunay_linear(each, mask) for each in np.moveaxis(components, -1, 0)], -1)
    np.testing.assert_allclose(delaunay_linear(components, mask), expected, atol=1e-6)


def test_pull_push_by_hand() -> None:
    """Two known pixels of a 2x2 block: the others get their mean, interpolated from one 1x1 level."""
    mask = np.array([[1, 0], [0, 1]])
    np.testing.assert_allclose(pull_push(np.array([[0.2, 0], [0, 0.6]]), mask), [[0.2, 0.4], [0.4, 0.6]], rtol=1e-6)


def test_telea_marches_in_both_directions() -> None:
    """Three unknown pixels between stripes: their neighbours' values, plus the steps that Telea adds."""
    gray = np.repeat(np.float32([[0.2, 0.2, 0.2, 0, 0, 0, 0.8, 0.8, 0.8]]), 7, 0)
    mask = np.repeat([[1, 1, 1, 0, 0, 0, 1, 1, 1]], 7, 0)
    filled = telea(gray, mask)
    np.testing.assert_allclose(filled[:, [3, 5]], np.repeat([[0.2, 0.8]], 7, 0), atol=2.5 / 255)
    assert ((filled[:, 4] > 0.15) & (filled[:, 4] < 0.85)).all()
    np.testing.assert_allclose(filled * 255, np.rint(filled * 255), atol=1e-4)


@every_filling
def test_bad_input(fill: Filling) -> None:
    with pytest.raises(InputError, match="mask: expected at least one traced pixel, got none of 12"):
        fill(np.zeros((3, 4)), np.zeros((3, 4)))
    with pytest.raises(InputError, match=r"gray: expected shape \(3, 4\) to match mask, got \(4, 3\)"):
        fill(np.zeros((4, 3)), np.ones((3, 4)))
    with pytest.raises(InputError, match="gray: expected finite numbers"):
        fill(np.full((3, 4), np.nan), np.ones((3, 4)))
