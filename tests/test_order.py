"""Pixel orders: nested, without replacement, a function of (seed, size), and as random as they claim."""

import numpy as np
import pytest
from scipy import stats

import bobrossnet as bob


@pytest.mark.parametrize("size", [(1, 1), (1, 7), (9, 1), (13, 17), (480, 640)])
@pytest.mark.parametrize("seed", [0, 1, 2**64 - 1])
def test_every_pixel_comes_once(size, seed):
    pixels = bob.pixel_order(size, seed=seed)
    assert pixels.dtype == np.int32
    assert pixels.shape == (size[0] * size[1], 2)
    index = pixels[:, 0].astype(np.int64) * size[1] + pixels[:, 1]
    assert np.array_equal(np.sort(index), np.arange(size[0] * size[1]))
    assert pixels.min() >= 0
    assert pixels[:, 1].max() < size[1]


def test_parts_are_parts_of_the_whole():
    whole = bob.pixel_order((48, 64), seed=3)
    assert np.array_equal(bob.pixel_order((48, 64), seed=3, count=150), whole[:150])
    assert np.array_equal(bob.pixel_order((48, 64), seed=3, start=100, count=50), whole[100:150])
    assert len(bob.pixel_order((48, 64), seed=3, start=3072)) == 0


def test_known_values():
    # Data sets and masks are functions of these: a change would be a break with all that was made before.
    assert bob.pixel_order((480, 640), seed=0, count=3).tolist() == [[23, 162], [422, 636], [371, 478]]
    assert bob.pixel_order((128, 128), seed=7, start=1000, count=2).tolist() == [[19, 68], [87, 105]]


def test_seeds_differ():
    first = bob.pixel_order((64, 64), seed=0)
    for seed in (1, 2, 2**32, 2**63):
        assert (bob.pixel_order((64, 64), seed=seed) == first).all(axis=1).mean() < 0.01


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("fraction", [0.01, 0.05, 0.3])
def test_uniform_spreads_like_chance(seed, fraction):
    """Counts in blocks, in rows and in pairs of neighbours against what drawing without replacement gives."""
    size = (256, 320)
    total = size[0] * size[1]
    count = round(fraction * total)
    mask = np.zeros(size)
    rows, columns = bob.pixel_order(size, seed=seed, count=count).T
    mask[rows, columns] = 1
    for counts in (mask.reshape(32, 8, 40, 8).sum(axis=(1, 3)), mask.sum(axis=1), mask.sum(axis=0)):
        expected = count / counts.size
        chi2 = ((counts - expected) ** 2).sum() / (expected * (1 - fraction))
        assert 1e-5 < stats.chi2.sf(chi2, counts.size - 1) < 1 - 1e-5
    for neighbour in (mask[:, 1:] * mask[:, :-1], mask[1:] * mask[:-1], mask[1:, 1:] * mask[:-1, :-1]):
        expected = fraction**2 * neighbour.size
        assert abs(neighbour.sum() - expected) < 5 * np.sqrt(expected) + 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"size": (0, 4)}, "height: expected an integer in 1.."),
        ({"size": (4, -1)}, "width"),
        ({"size": (4.0, 4)}, "height: expected an integer, got float 4.0"),
        ({"size": 4}, "size: expected (height, width)"),
        ({"size": (4, 4, 3)}, "size: expected (height, width)"),
        ({"size": (2**20, 2**20)}, "size: expected at most"),
        ({"size": (4, 4), "order": "spiral"}, "order: expected one of uniform, got 'spiral'"),
        ({"size": (4, 4), "seed": -1}, "seed"),
        ({"size": (4, 4), "seed": 0.5}, "seed: expected an integer"),
        ({"size": (4, 4), "count": 17}, "count"),
        ({"size": (4, 4), "start": 17}, "start"),
    ],
)
def test_bad_arguments_are_named(arguments, message):
    with pytest.raises(bob.InputError) as error:
        bob.pixel_order(**arguments)
    assert str(error.value).startswith(message)
