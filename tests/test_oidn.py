"""The adapter of Open Image Denoise, if installed."""

import sys

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.adapters import oidn

SIZE = (96, 128)


@pytest.fixture(scope="module")
def noisy(tree):
    """Return a bright tree with a path tracer's noise: the reference, noisy pixels, and guides."""
    rng = np.random.default_rng(0)
    full = bob.trace(tree, size=SIZE)
    row, column = np.indices(SIZE)
    tile = ((row // 5 + column // 7) % 2)[..., None] > 0
    surface = full.alpha[..., None] > 0
    albedo = np.where(surface, np.where(tile, (0.9, 0.5, 0.1), (0.2, 0.3, 0.8)), 1)
    truth = np.where(surface, 8 * full.gray[..., None] * albedo, 0.5)
    drawn = truth * rng.gamma(2, 0.5, SIZE)[..., None]
    return truth, drawn.astype(np.float32), bob.Guides(full.depth, full.normal, albedo, full.alpha)


@pytest.fixture
def installed():
    pytest.importorskip("pyoidn", reason="pyoidn, which has Open Image Denoise, is not installed")


def error(picture, truth):
    return np.abs(picture - truth).mean()


@pytest.mark.usefixtures("installed")
def test_noise_is_gone_and_guides_help(noisy):
    truth, drawn, guides = noisy
    before = drawn.copy()
    blind, guided = oidn.denoise(drawn), oidn.denoise(drawn, guides)
    assert guided.shape == (*SIZE, 3)
    assert guided.dtype == np.float32
    assert guided.min() >= 0
    assert error(guided, truth) < 0.8 * error(blind, truth) < 0.4 * error(drawn, truth)
    assert guided.max() > 4  # values above 1 are kept
    assert np.array_equal(drawn, before)


@pytest.mark.usefixtures("installed")
def test_a_whole_picture_of_a_tracer_is_denoised(noisy):
    truth, drawn, known = noisy

    class Tracer:
        size = SIZE

        def __call__(self, pixels):
            row, column = pixels.T
            return bob.Samples(color=drawn[row, column], variance=np.full(len(pixels), 0.1))

        def guides(self):
            return known

    frame = next(bob.progressive(tracer=Tracer(), first=1))
    assert frame.fraction == 1
    assert np.array_equal(oidn.denoise(frame.gbuffer), oidn.denoise(drawn, known))
    assert error(oidn.denoise(frame.gbuffer), truth) < 0.3 * error(drawn, truth)


@pytest.mark.usefixtures("installed")
def test_without_guides_first_hits_of_the_picture_itself_are_followed(noisy):
    truth, drawn, known = noisy
    ones = np.ones(SIZE, np.float32)
    surface = known.hit[..., None] > 0
    albedo = np.where(surface, known.albedo, 0)
    whole = bob.GBuffer(mask=ones, color=drawn, depth=known.depth, normal=known.normal, albedo=albedo)
    assert error(oidn.denoise(whole), truth) < error(oidn.denoise(bob.GBuffer(mask=ones, color=drawn)), truth)
    gray = bob.GBuffer(mask=ones, gray=np.ascontiguousarray(drawn[..., 0]))
    assert oidn.denoise(gray).shape == (*SIZE, 3)


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros((4, 5)),), "picture: expected shape (n, n, 3), got (4, 5)"),
        ((np.full((4, 5, 3), np.nan),), "picture: expected finite numbers"),
        ((np.full((4, 5, 3), -1),), "picture: expected values of at least 0, got -1"),
        ((np.zeros((4, 5, 3)), bob.Guides(np.ones((5, 4)))), "guides: expected the picture's size (4, 5), got (5, 4)"),
        ((np.zeros((4, 5, 3)), 7), "guides: expected bobrossnet.Guides or a dict of arrays, got int"),
        (
            (bob.GBuffer(mask=np.eye(4, dtype=np.float32), gray=np.eye(4, dtype=np.float32)),),
            "picture: expected a G-buffer with every pixel traced, got 12 of 16 missing; bobrossnet.complete",
        ),
    ],
)
def test_wrong_pictures_are_named(arguments, message):
    with pytest.raises(bob.InputError) as error:
        oidn.denoise(*arguments)
    assert str(error.value).startswith(message)


def test_one_line_says_what_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyoidn", None)
    with pytest.raises(bob.InputError, match=r"^oidn: this needs pyoidn: pip install 'bobrossnet\[oidn\]'$"):
        oidn.denoise(np.zeros((4, 5, 3)))
