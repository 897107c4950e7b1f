"""Completion along guides: the first surface at every pixel."""

import pickle

import numpy as np
import pytest
from thread_counts import with_threads

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.completion.guided import complete_guided

LUMINANCE = np.float32([0.2126, 0.7152, 0.0722])


@pytest.fixture(scope="module")
def tiled(tree):
    """Return the tree with tiles of two colours: its samples, its colour, and its guides."""
    full = bob.trace(tree, size=(96, 128))
    row, column = np.indices(full.size)
    tile = ((row // 5 + column // 7) % 2)[..., None] > 0
    albedo = np.where(tile, np.float32([0.9, 0.5, 0.1]), np.float32([0.2, 0.3, 0.8]))
    surface = full.alpha[..., None] > 0
    guides = bob.Guides(full.depth, full.normal, np.where(surface, albedo, 1), full.alpha)
    return full, np.where(surface, full.gray[..., None] * albedo, 0).astype(np.float32), guides


def part_of(full, color, fraction, **further):
    mask = full.sample(fraction, order="lattice").mask
    return bob.GBuffer(mask=mask, color=color, depth=full.depth, normal=full.normal, **further)


def test_guides_find_what_was_not_traced(tiled):
    full, color, guides = tiled
    guided, blind = part_of(full, color, 0.1, guides=guides), part_of(full, color, 0.1)
    errors = [np.abs(bob.complete(part, channel="color") - color).mean() for part in (guided, blind)]
    assert errors[0] < 0.4 * errors[1]
    traced = guided.mask > 0
    assert np.array_equal(bob.complete(guided, channel="color")[traced], color[traced])
    gray = bob.complete(guided)
    assert np.array_equal(gray[traced], guided.gray[traced])
    assert np.allclose(gray, bob.complete(guided, channel="color") @ LUMINANCE, atol=1e-5)
    assert np.array_equal(bob.complete(guided, "paper"), bob.complete(blind, "paper"))  # networks ignore guides


def test_rays_go_to_surfaces_that_none_has_seen():
    column = np.indices((96, 128))[1]
    is_bar = column % 32 // 2 == 1  # next to the lattice's first pixels

    class Barred:
        size = is_bar.shape

        def __call__(self, pixels):
            return bob.Samples(gray=np.full(len(pixels), 0.5))

        def guides(self):
            return bob.Guides(depth=np.where(is_bar, 4.0, 5.0))

    def on_bars(tracer):
        mask = next(bob.progressive(tracer=tracer, size=Barred.size, first=0.08)).gbuffer.mask > 0
        return (mask & is_bar).sum() / mask.sum()

    blind = on_bars(lambda pixels: Barred()(pixels))
    assert on_bars(Barred()) > 2.5 * blind


def test_guided_light_of_gray_tracers(tree):
    full = bob.trace(tree, size=(96, 128))
    guides = bob.Guides(full.depth, full.normal, hit=full.alpha)
    part = bob.GBuffer(mask=full.sample(0.1).mask, gray=full.gray, guides=guides)
    error = np.abs(bob.complete(part, "guided") - full.gray).mean()
    assert error < 0.5 * np.abs(bob.complete(full.sample(0.1)) - full.gray).mean()
    assert (bob.complete(part, "guided", channel="color") == bob.complete(part, "guided")[..., None]).all()


def test_the_core_knows_the_first_surfaces_as_well(tree):
    part = bob.trace(tree, size=(96, 128), fraction=0.05, guides=True)
    full = bob.trace(tree, size=(96, 128))
    assert np.array_equal(part.guides.hit, full.alpha)
    assert np.array_equal(part.guides.depth, full.depth)
    assert np.array_equal(part.guides.normal, full.normal)
    assert (part.guides.albedo == 1).all()
    assert bob.GBuffer.from_stack(part.planes.copy()) == bob.trace(tree, size=(96, 128), fraction=0.05)
    error = np.abs(bob.complete(part) - full.gray).mean()
    assert error < 0.5 * np.abs(bob.complete(full.sample(0.05)) - full.gray).mean()


@pytest.mark.parametrize("size", [(1, 1), (1, 9), (7, 1), (5, 6), (33, 17), (40, 50)])
@pytest.mark.parametrize("count", [0, 1, 3, 20])
@pytest.mark.parametrize("light", [1e-4, 3, 1e4])
def test_flat_light_stays_flat_at_any_size(size, count, light):
    rng = np.random.default_rng(count)
    mask = np.zeros(size, np.float32)
    mask.flat[rng.choice(mask.size, min(count, mask.size), replace=False)] = 1
    albedo = rng.uniform(0.1, 1, (*size, 3)).astype(np.float32)
    guides = bob.Guides(rng.uniform(1, 5, size), rng.uniform(-0.5, 0.5, (*size, 2)), albedo)
    part = bob.GBuffer(mask=mask, color=np.float32(light) * albedo, guides=guides)
    assert np.allclose(bob.complete(part, channel="color"), light * albedo if count else 0, rtol=1e-4)


def test_threads_and_instruction_sets_agree(tiled, every_instruction_set):
    full, color, guides = tiled
    part = part_of(full, color, 0.1, guides=guides)
    results = with_threads((1, 2, 3), lambda: complete_guided(part, "color"))
    assert np.array_equal(results[0], results[1])
    assert np.array_equal(results[0], results[2])
    for name in every_instruction_set:
        assert _core.set_isa(name)
        assert np.allclose(complete_guided(part, "color"), results[0], atol=1e-4)


def noisy(color, seed=0):
    """Return a path tracer's version: noise proportional to light, with fireflies; and its variance."""
    rng = np.random.default_rng(seed)
    deviation = 0.5 * color
    drawn = np.maximum(color + deviation * rng.standard_normal((*color.shape[:2], 1)), 0)
    fireflies = rng.random(color.shape[:2]) < 0.01
    drawn[fireflies] *= 20
    variance = np.where(fireflies, 40**2, 1) * np.square(deviation @ LUMINANCE)  # one path of many: equal to its square
    return drawn.astype(np.float32), variance.astype(np.float32)


def test_noise_is_averaged_and_more_samples_are_no_worse(tiled):
    full, color, guides = tiled
    errors, raw = np.zeros(4), 0.0
    for seed in range(3):
        drawn, variance = noisy(color, seed)
        raw += np.abs(drawn - color).mean()
        for i, fraction in enumerate((0.05, 0.1, 0.25, 1)):
            part = part_of(full, drawn, fraction, variance=variance, guides=guides)
            errors[i] += np.abs(bob.complete(part, channel="color") - color).mean()
    assert (np.diff(errors) < 0).all()
    assert errors[-1] < 0.4 * raw


def test_lamps_are_no_fireflies(tiled):
    """Bright, certain pixels are kept, though their surroundings are darker and noisy."""
    full, color, guides = tiled
    lit = color.copy()
    lit[40:44, 60:64] = 50
    variance = np.full(full.size, 0.01, np.float32)
    variance[40:44, 60:64] = 1e-4
    part = part_of(full, lit, 1, variance=variance, guides=guides)
    assert (bob.complete(part, channel="color")[41:43, 61:63] > 25).all()


def test_guides_travel_with_their_picture(tiled):
    full, color, guides = tiled
    part = part_of(full, color, 0.2, guides=guides)
    assert part.sample(0.1, order="lattice").guides is guides
    again = pickle.loads(pickle.dumps(part))
    assert again == part
    assert again.guides == guides
    assert again != part_of(full, color, 0.2)
    assert guides.size == full.size
    assert np.array_equal(guides.hit, full.alpha)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "guides: expected depth, normal, albedo or hit, got none of them"),
        ({"depth": np.zeros((2, 3)), "normal": np.zeros((3, 2, 2))}, "normal: expected shape (2, 3, 2), got (3, 2, 2)"),
        ({"normal": np.full((2, 3, 2), 2)}, "normal: expected values in -1..1"),
        ({"albedo": np.full((2, 3, 3), np.nan)}, "albedo: expected finite numbers"),
        ({"albedo": np.full((2, 3, 3), 2)}, "albedo: expected values in 0..1"),
        ({"hit": np.full((2, 3), 2)}, "hit: expected values in 0..1"),
        ({"depth": "far"}, "depth: expected an array of numbers"),
    ],
)
def test_wrong_guides_are_named(given, message):
    with pytest.raises(bob.InputError) as error:
        bob.Guides(**given)
    assert str(error.value).startswith(message)


def test_only_pictures_with_guides_can_follow_them(tree):
    with pytest.raises(bob.InputError, match="model: expected a G-buffer with guides for 'guided', got one without"):
        bob.complete(bob.trace(tree, size=(48, 64), fraction=0.1), "guided")
