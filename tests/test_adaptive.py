"""The adaptive pixel orders."""

from itertools import pairwise

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.picture.order import ORDERS_BY_SIGHT

EACH_ORDER = pytest.mark.parametrize("order", ORDERS_BY_SIGHT)


@pytest.fixture(scope="module")
def full(tree):
    return bob.trace(tree, size=(240, 320))


@EACH_ORDER
@pytest.mark.parametrize("fraction", [0.01, 0.05, 0.25, 0.9, 1])
def test_traced_and_sampled_pictures_are_the_same(fraction, order, tree, full):
    part = bob.trace(tree, size=(240, 320), fraction=fraction, order=order)
    assert part == full.sample(fraction, order=order)
    assert int(part.mask.sum()) == round(fraction * full.mask.size)


@EACH_ORDER
def test_they_are_nested(order, full):
    masks = [full.sample(fraction, order=order).mask for fraction in (0.01, 0.05, 0.06, 0.25, 0.8)]
    for fewer, more in pairwise(masks):
        assert (fewer <= more).all()


@pytest.mark.parametrize(
    ("order", "fraction", "most"),
    [("adaptive", 0.05, 0.75), ("adaptive", 0.1, 0.6), ("adaptive", 0.25, 0.25)]
    + [("squares", 0.05, 0.95), ("squares", 0.1, 0.8), ("squares", 0.25, 0.2)],
)
def test_errors_are_fewer_than_with_the_lattice(order, fraction, most, full):
    errors = []
    for each in (order, "lattice"):
        image = bob.complete(full.sample(fraction, order=each))
        errors.append(1 - bob.ssim(image, full.gray))
    assert errors[0] < most * errors[1]


@EACH_ORDER
def test_they_do_not_depend_on_the_pace(order, tree):
    """Frames of any size give the same pixels as one call."""
    for share in (0.013, 0.1):
        frames = list(bob.progressive(tree, size=(120, 160), fraction=share, order=order))
        assert frames[2].gbuffer == bob.trace(tree, size=(120, 160), fraction=frames[2].fraction, order=order)
        assert frames[-1].fraction == 1
    last = list(bob.progressive(tree, size=(120, 160), frame_ms=5, order=order))[-1]
    assert np.array_equal(last.image, bob.trace(tree, size=(120, 160)).gray)


def test_plugged_tracers_are_called_a_few_times(full):
    calls = []

    def tracer(pixels):
        calls.append(len(pixels))
        rows, columns = pixels.T
        hit = full.depth[rows, columns] > 0
        return bob.Samples(full.gray[rows, columns], full.depth[rows, columns], full.normal[rows, columns], hit)

    frames = bob.progressive(tracer=tracer, size=(240, 320), fraction=0.05, order="adaptive")
    frame = next(frames)
    assert len(calls) <= 8
    assert frame.gbuffer == full.sample(0.05, order="adaptive")
    while frame.fraction < 0.25:
        frame = next(frames)
    assert len(calls) <= 20  # 16, and one more for each further frame


def test_a_tracer_that_fails_leaves_the_last_picture():
    calls = []

    def tracer(pixels):
        if len(calls) == 5:
            raise RuntimeError("out of licences")
        calls.append(len(pixels))
        n = len(pixels)
        return bob.Samples(np.full(n, 0.5), np.zeros(n), np.zeros((n, 2)), np.ones(n, bool))

    frames = bob.progressive(tracer=tracer, size=(64, 64), fraction=0.01, order="adaptive")
    last = []

    def watch():
        for frame in frames:
            last[:] = [frame]

    with pytest.raises(RuntimeError, match="out of licences"):
        watch()
    assert 0 < int(last[0].gbuffer.mask.sum()) <= sum(calls)
    assert np.isfinite(last[0].image).all()


def test_what_it_shows_has_to_be_traced_first():
    for order in ("adaptive", "default"):
        with pytest.raises(bob.InputError, match="known before anything is traced"):
            bob.pixel_order((8, 8), order=order)
    with pytest.raises(bob.InputError, match="order: expected one of"):
        bob.trace(bob.happy_tree(), order="adapt")


def test_it_has_few_bytes_a_pixel(full):
    from bobrossnet import _core
    from bobrossnet.picture.channels import TRACED

    order, count = _core.AdaptiveOrder(0, 240, 320), 0
    while len(pixels := order.next(TRACED.core, full.planes)):
        count += len(pixels)
        assert order.bytes <= 18 * full.mask.size  # and the round itself
    assert count == full.mask.size
