"""The pixel order that goes where the picture needs it."""

from itertools import pairwise

import numpy as np
import pytest

import bobrossnet as bob


@pytest.fixture(scope="module")
def full(tree):
    return bob.trace(tree, size=(240, 320))


@pytest.mark.parametrize("fraction", [0.01, 0.05, 0.25, 0.9, 1])
def test_traced_and_sampled_pictures_are_the_same(fraction, tree, full):
    part = bob.trace(tree, size=(240, 320), fraction=fraction, order="adaptive")
    assert part == full.sample(fraction, order="adaptive")
    assert int(part.mask.sum()) == round(fraction * full.mask.size)


def test_it_is_nested(full):
    masks = [full.sample(fraction, order="adaptive").mask for fraction in (0.01, 0.05, 0.06, 0.25, 0.8)]
    for fewer, more in pairwise(masks):
        assert (fewer <= more).all()


@pytest.mark.parametrize(("fraction", "most"), [(0.05, 0.75), (0.1, 0.6), (0.25, 0.25)])
def test_errors_are_fewer_than_with_the_lattice(fraction, most, full):
    errors = []
    for order in ("adaptive", "lattice"):
        image = bob.complete(full.sample(fraction, order=order))
        errors.append(1 - bob.ssim(image, full.gray))
    assert errors[0] < most * errors[1]


def test_it_does_not_depend_on_the_pace(tree, full):
    """Frames of any size show the same pixels as one call."""
    for share in (0.013, 0.1):
        frames = list(bob.progressive(tree, size=(120, 160), fraction=share, order="adaptive"))
        assert frames[2].gbuffer == bob.trace(tree, size=(120, 160), fraction=frames[2].fraction, order="adaptive")
        assert frames[-1].fraction == 1
    last = list(bob.progressive(tree, size=(120, 160), frame_ms=5, order="adaptive"))[-1]
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
