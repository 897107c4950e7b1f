"""Pixel orders: nested, without replacement, functions of (seed, size), and as random or as even as documented."""

import numpy as np
import pytest
from scipy import ndimage, stats
from thread_counts import with_threads

import bobrossnet as bob
from bobrossnet.picture.order import DEFAULT_ORDER, FIXED_ORDERS, ORDERS, PRIORITY

EVERY_ORDER = pytest.mark.parametrize("order", FIXED_ORDERS)


@EVERY_ORDER
@pytest.mark.parametrize(
    "size", [(1, 1), (1, 200), (9, 1), (5, 7), (64, 64), (65, 127), (1, 300), (63, 129), (480, 640)]
)
@pytest.mark.parametrize("seed", [0, 1, 2**64 - 1])
def test_every_pixel_comes_once(size, seed, order):
    pixels = bob.pixel_order(size, order=order, seed=seed)
    assert pixels.dtype == np.int32
    assert pixels.shape == (size[0] * size[1], 2)
    index = pixels[:, 0].astype(np.int64) * size[1] + pixels[:, 1]
    assert np.array_equal(np.sort(index), np.arange(size[0] * size[1]))
    assert pixels.min() >= 0
    assert pixels[:, 1].max() < size[1]


@EVERY_ORDER
@pytest.mark.parametrize("size", [(5, 7), (48, 64), (200, 300)])
def test_parts_are_parts_of_the_whole(size, order):
    total = size[0] * size[1]
    whole = bob.pixel_order(size, order=order, seed=3)
    assert len(bob.pixel_order(size, order=order, seed=3, start=total)) == 0
    for start, count in [(0, total // 20), (total // 31, total // 3), (total // 2 + 1, 1), (total - 3, 3)]:
        part = bob.pixel_order(size, order=order, seed=3, start=start, count=count)
        assert np.array_equal(part, whole[start : start + count])


@pytest.mark.parametrize(
    ("order", "first", "later"),
    [
        ("uniform", [[23, 162], [422, 636], [371, 478]], [[19, 68], [87, 105]]),
        ("lattice", [[405, 405], [341, 213], [277, 21]], [[93, 33], [29, 97]]),
    ],
)
def test_known_values(order, first, later):
    # Data sets and masks depend on these: a change would invalidate existing ones.
    assert bob.pixel_order((480, 640), order=order, seed=0, count=3).tolist() == first
    assert bob.pixel_order((128, 128), order=order, seed=7, start=1000, count=2).tolist() == later


@EVERY_ORDER
def test_seeds_differ(order):
    first = bob.pixel_order((512, 640), order=order, seed=0)
    assert np.array_equal(bob.pixel_order((512, 640), order=order, seed=0), first)
    for seed in (1, 2, 2**32, 2**63):
        assert (bob.pixel_order((512, 640), order=order, seed=seed) == first).all(axis=1).mean() < 0.03


@EVERY_ORDER
def test_threads_do_not_matter(order):
    assert np.array_equal(*with_threads((1, 3), lambda: bob.pixel_order((300, 400), order=order, seed=5)))


@EVERY_ORDER
def test_pixels_of_the_tracer_and_of_a_sample_are_the_same(tree, order):
    size = (40, 70)
    part = bob.trace(tree, size=size, fraction=0.1, order=order, seed=2)
    assert part == bob.trace(tree, size=size).sample(0.1, order=order, seed=2)
    assert np.argwhere(part.mask).tolist() == sorted(bob.pixel_order(size, order=order, seed=2, count=280).tolist())


def test_sizes_are_written_width_first():
    assert np.array_equal(bob.pixel_order("90x70"), bob.pixel_order((70, 90)))
    assert bob.trace(bob.happy_tree(), size="20X10").size == (10, 20)


@pytest.mark.parametrize(
    ("size", "order"), [((70, 90), DEFAULT_ORDER), ((511, 512), DEFAULT_ORDER), ((512, 512), PRIORITY)]
)
def test_the_default_depends_on_the_size(tree, size, order):
    part = bob.trace(tree, size=size, fraction=0.03)
    assert part == bob.trace(tree, size=size, fraction=0.03, order=order)
    assert all(part != bob.trace(tree, size=size, fraction=0.03, order=other) for other in ORDERS if other != order)


@pytest.mark.parametrize("seed", [0, 9])
@pytest.mark.parametrize("halvings", [6, 5, 4, 3, 2, 1])
def test_lattices_are_nested(halvings, seed):
    """At 1/64, 1/16, ... of the pixels a square lattice, at 1/32, 1/8, ... one rotated by 45 degrees, for any seed."""
    pixels = bob.pixel_order((128, 128), order="lattice", seed=seed, count=128**2 >> halvings)
    step = 2 ** ((halvings + 1) // 2)
    lattice = {(row, column) for row in range(21 % step, 128, step) for column in range(21 % step, 128, step)}
    if halvings % 2 == 1:
        lattice |= {((row + step // 2) % 128, (column + step // 2) % 128) for row, column in lattice}
    assert {tuple(pixel) for pixel in pixels.tolist()} == lattice


@pytest.mark.parametrize("size", [(200, 300), (64, 64), (33, 150)])
def test_gaps_are_smaller_than_by_chance(size):
    def largest_gap(order, fraction):
        rows, columns = bob.pixel_order(size, order=order, seed=1, count=round(fraction * size[0] * size[1])).T
        untraced = np.ones(size, bool)
        untraced[rows, columns] = False
        return ndimage.distance_transform_edt(untraced).max()

    for fraction in (0.01, 0.05, 0.25):
        assert largest_gap("lattice", fraction) < 0.8 * largest_gap("uniform", fraction)


def test_tiles_are_visited_evenly():
    """Pixels of equal rank follow in long steps: an early part of them covers the picture."""
    pixels = bob.pixel_order((2160, 3840), order="lattice", seed=4, count=200)  # of 2040 tiles
    counts = np.histogram2d(*pixels.T, bins=(5, 5), range=((0, 2160), (0, 3840)))[0]
    assert counts.min() >= 5
    assert counts.max() <= 11


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("fraction", [0.01, 0.05, 0.3])
def test_uniform_spreads_like_chance(seed, fraction):
    """Counts in blocks, in rows and in pairs of neighbours, compared with drawing without replacement."""
    size = (256, 320)
    total = size[0] * size[1]
    count = round(fraction * total)
    mask = np.zeros(size)
    rows, columns = bob.pixel_order(size, order="uniform", seed=seed, count=count).T
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
        ({"size": 4}, 'size: expected (height, width) or "WIDTHxHEIGHT"'),
        ({"size": "640"}, "size: expected WIDTHxHEIGHT such as 640x480, got '640'"),
        ({"size": "-4x4"}, "size: expected WIDTHxHEIGHT"),
        ({"size": "0x4"}, "width: expected an integer in 1.."),
        ({"size": (4, 4, 3)}, "size: expected (height, width)"),
        ({"size": (2**20, 2**20)}, "size: expected at most"),
        (
            {"size": (4, 4), "order": "spiral"},
            "order: expected one of uniform, lattice, adaptive, squares, priority, default, got 'spiral'",
        ),
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
