"""Images as shapes: worked values, and outlines compared with the drawn shapes."""

import numpy as np
import pytest
from PIL import Image

import bobrossnet as bob
from bobrossnet.sdf import image, measure_image
from bobrossnet.support.errors import InputError

ROWS, COLUMNS = np.mgrid[:60, :80] + 0.5
X, Y = COLUMNS - 40, 30 - ROWS  # at pixel centres


def ball(radius):
    """Return an antialiased disc."""
    return np.clip(radius + 0.5 - np.hypot(X, Y), 0, 1)


def test_a_disk():
    places = np.random.default_rng(0).uniform(-1, 1, (5000, 2)) * (60, 50)
    distance = image(ball(20), height=60)(places)[:, 0]
    assert np.abs(distance - (np.hypot(*places.T) - 20)).max() < 0.35  # a quarter, and a margin for antialiasing


def test_a_rectangle_and_its_hole():
    """Whole pixels: 10 <= x < 30 without 15 <= x < 20, 20 <= y < 50 without 30 <= y < 35, y down."""
    white = np.zeros((60, 80), bool)
    white[20:50, 10:30] = True
    white[30:35, 15:20] = False
    f = image(white, height=60)
    at = np.array([(12, 40), (28, 25), (17.5, 32.5), (0, 40), (25, 32.5), (12, 32.5)])
    places = np.stack([at[:, 0] - 40, 30 - at[:, 1]], axis=1)
    assert f(places)[:, 0] == pytest.approx([-2, -2, 2.5, 10, -5, -2], abs=0.01)


def test_pixels_that_meet_at_a_corner():
    apart, joined = np.zeros((6, 6)), np.zeros((6, 6))
    apart[1:3, 1:3] = apart[3:5, 3:5] = 0.9
    joined[1:3, 1:3] = joined[3:5, 3:5] = 1
    joined[2, 3] = joined[3, 2] = 0.4
    assert image(apart, height=6)([(0, 0)])[0] > 0.2
    assert image(joined, height=6)([(0, 0)])[0] < -0.2


def test_white_ends_at_the_frame():
    f = image(np.ones((40, 60), bool), width=60)
    assert f([(0, 0), (29, 0), (31, 0), (0, 25)])[:, 0] == pytest.approx([-20, -1, 1, 5])
    assert f([(30, 20)])[0] == pytest.approx([np.sqrt(0.5) / 2], abs=0.01)  # corners are cut by half a pixel


def test_sizes(tmp_path):
    Image.fromarray(np.zeros((30, 60), np.uint8)).save(tmp_path / "black.png")
    assert measure_image(tmp_path / "black.png") == pytest.approx((2, 1))
    assert measure_image(str(tmp_path / "black.png"), width=3) == pytest.approx((3, 1.5))
    assert measure_image(np.zeros((30, 60), bool), height=3) == pytest.approx((6, 3))
    assert measure_image(Image.new("L", (60, 30)), 4, 5) == pytest.approx((4, 5))


def test_pictures_of_all_kinds_are_the_same(tmp_path):
    gray = np.rint(255 * ball(20)).astype(np.uint8)
    Image.fromarray(gray).save(tmp_path / "ball.png")
    expected = image(gray).expression
    assert image(tmp_path / "ball.png").expression == expected
    assert image(Image.fromarray(gray)).expression == expected
    assert image(np.repeat(gray[..., None], 3, axis=2)).expression == expected
    places = np.random.default_rng(1).uniform(-0.6, 0.6, (500, 2))
    assert image(gray / 255)(places) == pytest.approx(image(gray)(places), abs=1e-4)


def test_large_pictures_are_made_smaller():
    small, large = image(ball(20), height=60, pixels=300), image(ball(20), height=60)
    assert len(small.expression) < len(large.expression)
    assert small([(0, 0)])[0] == pytest.approx([-20], abs=1.5)


def test_stretched_pictures_have_true_distances():
    f = image(np.ones((40, 40), bool), width=20, height=2)
    assert f([(0, 0), (11, 0), (0, 3)])[:, 0] == pytest.approx([-1, 1, 2])


def test_pictures_are_shapes_like_others():
    f = image(ball(20), height=2).extrude(0.5)
    picture = bob.trace(f, bob.Camera(elevation=90), size=(64, 64))
    area = np.pi / picture.alpha.size * (32 / np.hypot(2 / 3, 0.25) * 2 / 3) ** 2
    assert picture.alpha.mean() == pytest.approx(area, rel=0.05)
    assert f.unresolved_rays == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros((4, 4), bool),), "image: expected a picture with white in it, got none"),
        ((np.zeros((4, 4), np.int64),), "image: path_or_array: expected an array (h, w) bool, uint8 or float"),
        ((np.zeros((4, 4, 2), np.uint8),), "image: path_or_array: expected an array (h, w) bool, uint8 or float"),
        (([[1, 2], [3]],), "image: path_or_array: expected an array (h, w) bool, uint8 or float"),
        (("nowhere.png",), "image: nowhere.png: expected a picture"),
        ((np.ones((4, 4), bool), 0), "image: width: expected a number above 0, got 0"),
        ((np.ones((4, 4), bool), 1, 1, 3), "image: pixels: expected an integer in 16..67108864, got 3"),
    ],
)
def test_what_can_not_be_used_is_told(arguments, message):
    with pytest.raises(InputError) as error:
        image(*arguments)
    assert str(error.value).startswith(message)
    assert "\n" not in str(error.value)


def test_too_many_details_are_refused():
    dots = np.zeros((300, 300), bool)
    dots[::4, ::4] = True
    with pytest.raises(InputError, match=r"image: expected an outline of at most 10000 lines and arcs, got 22"):
        image(dots)


def test_noise_is_refused():
    noise = np.random.default_rng(0).random((900, 900)) < 0.5
    with pytest.raises(InputError, match=r"image: expected an outline of at most 262144 corners, got \d+; give fewer"):
        image(noise)
