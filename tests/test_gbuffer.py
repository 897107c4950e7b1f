"""G-buffers and samples: their values and their errors."""

import pickle

import numpy as np
import pytest

import bobrossnet as bob

H, W = 6, 9


def arrays(**changed):
    rng = np.random.default_rng(0)
    mask = (rng.random((H, W)) < 0.5).astype(np.float32)
    values = {
        "mask": mask,
        "gray": rng.random((H, W), dtype=np.float32),
        "depth": rng.random((H, W), dtype=np.float32),
        "normal": rng.uniform(-0.7, 0.7, (H, W, 2)).astype(np.float32),
    }
    return values | changed


def test_untraced_pixels_are_zero():
    given = arrays()
    gbuffer = bob.GBuffer(**given)
    traced = given["mask"] > 0
    for name in ("gray", "depth", "normal"):
        assert np.array_equal(getattr(gbuffer, name)[traced], given[name][traced])
        assert not getattr(gbuffer, name)[~traced].any()
    assert gbuffer.size == (H, W)
    assert gbuffer.fraction == traced.mean()


def test_stack_is_the_networks_input():
    gbuffer = bob.GBuffer(**arrays())
    stack = gbuffer.stack()
    assert stack.shape == (5, H, W)
    assert stack.dtype == np.float32
    planes = (gbuffer.mask, gbuffer.gray, gbuffer.depth, gbuffer.normal[..., 0], gbuffer.normal[..., 1])
    for plane, values in zip(stack, planes, strict=True):
        assert np.array_equal(plane, values)


def test_a_gbuffer_is_frozen():
    gbuffer = bob.GBuffer(**arrays())
    with pytest.raises(AttributeError):
        gbuffer.gray = gbuffer.depth
    for values in (gbuffer.mask, gbuffer.normal, gbuffer.stack()):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 1


def test_the_given_arrays_are_copied():
    given = arrays()
    gbuffer = bob.GBuffer(**given)
    before = gbuffer.stack().copy()
    given["gray"][:] = 0.5
    assert np.array_equal(gbuffer.stack(), before)


def test_equality_and_pickle():
    gbuffer = bob.GBuffer(**arrays())
    assert gbuffer == bob.GBuffer(**arrays())
    assert gbuffer != bob.GBuffer(**arrays(mask=np.ones((H, W), np.float32)))
    assert pickle.loads(pickle.dumps(gbuffer)) == gbuffer


def test_sample_of_a_partial_gbuffer_keeps_what_both_have():
    gbuffer = bob.GBuffer(**arrays())
    part = gbuffer.sample(0.5, order="lattice", seed=1)
    rows, columns = bob.pixel_order((H, W), seed=1, count=27).T
    picked = np.zeros((H, W), bool)
    picked[rows, columns] = True
    assert np.array_equal(part.mask > 0, picked & (gbuffer.mask > 0))
    assert gbuffer.sample(1.0) == gbuffer


def nan_at_one_place(shape):
    values = np.zeros(shape, np.float32)
    values.flat[3] = np.nan
    return values


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"mask": np.zeros((H, W))}, "mask: expected float32, got float64"),
        ({"mask": np.zeros((H, W), bool)}, "mask: expected float32, got bool"),
        ({"mask": np.full((H, W), 0.5, np.float32)}, "mask: expected only 0 and 1"),
        ({"mask": np.zeros((H,), np.float32)}, "mask: expected shape (n, n), got (6,)"),
        ({"mask": np.zeros((0, W), np.float32)}, "height"),
        ({"gray": np.zeros((W, H), np.float32)}, "gray: expected shape (6, 9), got (9, 6)"),
        ({"gray": np.full((H, W), -1, np.float32)}, "gray: expected values of at least 0, got -1"),
        ({"gray": nan_at_one_place((H, W))}, "gray: expected finite numbers, got 1 of 54 NaN or infinite"),
        ({"gray": "white"}, "gray: expected an array of numbers"),
        ({"gray": [[1, 2], [3]]}, "gray: expected an array of numbers"),
        ({"depth": "far"}, "depth: expected an array of numbers"),
        ({"depth": np.full((H, W), np.nan, np.float32)}, "depth: expected finite numbers"),
        ({"depth": np.zeros((H, W), np.uint8)}, "depth: expected float32, got uint8"),
        ({"normal": np.zeros((2, H, W), np.float32)}, "normal: expected shape (6, 9, 2), got (2, 6, 9)"),
        ({"normal": np.full((H, W, 2), 2, np.float32)}, "normal: expected values in -1..1"),
        ({"normal": nan_at_one_place((H, W, 2))}, "normal: expected finite numbers"),
    ],
)
def test_bad_arrays_are_named(changed, message):
    with pytest.raises(bob.InputError) as error:
        bob.GBuffer(**arrays(**changed))
    assert str(error.value).startswith(message)
    assert "\n" not in str(error.value)


def test_wrong_dtypes_are_type_errors():
    with pytest.raises(TypeError):
        bob.GBuffer(**arrays(gray=np.zeros((H, W))))


@pytest.mark.parametrize("fraction", [0, -0.1, 1.0001, float("nan"), float("inf"), "5%", None, True])
def test_bad_fractions_are_named(fraction):
    with pytest.raises(bob.InputError, match="fraction: expected"):
        bob.GBuffer(**arrays()).sample(fraction)


def samples(**changed):
    n = 5
    values = {
        "gray": np.full(n, 0.5),
        "depth": np.full(n, 0.5),
        "normal": np.zeros((n, 2)),
        "hit": np.ones(n, bool),
    }
    return bob.Samples(**(values | changed))


def test_samples_take_any_floats_and_what_missed_does_not_matter():
    gray = np.array([0.1, np.nan, 7, 0.4, 0.5])
    hit = np.array([True, False, False, True, True])
    taken = samples(gray=gray, hit=hit)
    assert taken.gray.dtype == np.float32
    assert len(taken) == 5
    samples(hit=np.array([0.0, 1, 1, 0, 1]))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"gray": np.zeros(4)}, "gray: expected shape (5,), got (4,)"),
        ({"gray": np.full(5, np.nan)}, "gray: expected finite numbers"),
        ({"depth": np.full(5, np.inf)}, "depth: expected finite numbers"),
        ({"gray": np.full(5, -0.5)}, "gray: expected values of at least 0, got -0.5"),
        ({"normal": np.zeros((5, 3))}, "normal: expected shape (5, 2), got (5, 3)"),
        ({"hit": np.zeros((5, 1), bool)}, "hit: expected shape (n,), got (5, 1)"),
        ({"hit": np.full(5, 0.5)}, "hit: expected booleans"),
        ({"gray": np.array(["a"] * 5)}, "gray: expected an array of numbers"),
    ],
)
def test_bad_samples_are_named(changed, message):
    with pytest.raises(bob.InputError) as error:
        samples(**changed)
    assert str(error.value).startswith(message)
