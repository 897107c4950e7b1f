"""User tracers: pictures of any range and depth in any unit, lit backgrounds, and throughput."""

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from clocks import least

import bobrossnet as bob

H, W = SIZE = (48, 64)
EVERYWHERE = np.argwhere(np.ones(SIZE))


def ramp(pixels):
    """Return a smooth ramp of colours across the picture, 0..1."""
    row, column = pixels[:, 0] / H, pixels[:, 1] / W
    return np.stack([column, 0.5 * row + 0.25, 1 - column], axis=-1)


@pytest.mark.parametrize("scale", [1e-4, 1, 1e4])
def test_three_lines_are_a_tracer_in_colour(scale):
    def tracer(pixels):
        return bob.Samples(color=scale * ramp(pixels))

    frames = list(bob.progressive(tracer=tracer, size=SIZE, fraction=0.1))
    truth = (scale * ramp(EVERYWHERE)).astype(np.float32).reshape(H, W, 3)
    assert np.array_equal(frames[-1].color, truth)
    assert np.array_equal(frames[-1].gbuffer.color, truth)
    for frame in frames:
        traced = frame.gbuffer.mask > 0
        assert np.array_equal(frame.color[traced], truth[traced])
        assert np.abs(frame.color - truth).mean() < 0.02 * scale


def test_bright_and_dark_survive_in_one_picture():
    def tracer(pixels):
        return bob.Samples(color=np.where(pixels[:, 1:] < W // 2, 1e4, 1e-4) * np.ones(3))

    first = next(bob.progressive(tracer=tracer, size=SIZE, fraction=0.2))
    assert set(np.unique(first.gbuffer.color)) == {0, np.float32(1e-4), np.float32(1e4)}
    traced = first.gbuffer.mask > 0
    assert np.array_equal(first.color[traced], first.gbuffer.color[traced])
    assert np.allclose(first.color[:, 2 : W // 2 - 8], 1e4, rtol=0.1)
    assert (first.color[:, W // 2 + 8 :] < 1).all()


def test_the_transfer_is_told_and_has_an_inverse():
    def tracer(pixels):
        return bob.Samples(100 * pixels[:, 1] / W, depth=3.0 + pixels[:, 0])

    gbuffer = next(bob.progressive(tracer=tracer, size=SIZE, fraction=0.2)).gbuffer
    transfer = gbuffer.transfer
    values = np.float32([0, 1e-3, 1, 50, transfer.peak])
    assert transfer.peak == gbuffer.gray.max()
    assert transfer.middle == np.median(gbuffer.gray[gbuffer.gray > 0])
    assert transfer.encode(values)[0] == 0
    assert transfer.encode(values)[-1] == pytest.approx(1)
    expected = np.log(1 + values / transfer.middle) / np.log(1 + transfer.peak / transfer.middle)
    assert np.allclose(transfer.encode(values), expected, rtol=1e-5, atol=1e-7)
    assert np.allclose(transfer.decode(transfer.encode(values)), values, rtol=1e-5, atol=1e-6)
    depth = transfer.planes(gbuffer.planes, gbuffer.layout)[2]
    row, column = np.argwhere(gbuffer.mask).T
    assert np.allclose(depth[row, column], (transfer.far - 3 - row) / (transfer.far - transfer.near), atol=1e-6)
    assert 0 < depth[row, column].min() < depth.max() == 1
    assert (gbuffer.depth[row, column] == 3 + row).all()


def test_what_displays_show_goes_through_no_transfer(tree):
    assert bob.trace(tree, size=SIZE).transfer is None
    tracer = lambda pixels: bob.Samples(ramp(pixels)[:, 0])  # noqa: E731
    assert next(bob.progressive(tracer=tracer, size=SIZE)).gbuffer.transfer is None


def test_units_of_depth_and_light_do_not_matter(tree):
    """The same picture with light a thousand times as strong, and depth as distances."""
    full = bob.trace(tree, size=SIZE)

    def first(light, distances):
        def tracer(pixels):
            row, column = pixels.T
            depth = full.depth[row, column].astype(float)
            hit = depth > 0
            depth = 70 - 10 * depth if distances else depth
            return bob.Samples(light * full.gray[row, column].astype(float), depth, full.normal[row, column], hit)

        return next(bob.progressive(tracer=tracer, size=SIZE, fraction=0.2, order="lattice"))

    usual, strong, far = first(2, False), first(2000, False), first(2000, True)
    assert usual.gbuffer.transfer.near is None
    assert far.gbuffer.transfer.near == far.gbuffer.depth[far.gbuffer.depth != 0].min() > 60
    assert np.allclose(strong.image / 1000, usual.image, atol=1e-4)
    assert np.abs(far.image / 1000 - usual.image).mean() < 0.01


def test_backgrounds_may_shine():
    def tracer(pixels):
        hit = np.hypot(pixels[:, 0] - H / 2, pixels[:, 1] - W / 2) < 10
        color = np.where(hit[:, None], (0.8, 0.1, 0.1), (0.2, 0.4, 0.9))
        depth = np.where(hit, 0.5, np.inf)  # background depth is ignored
        return bob.Samples(color=color, depth=depth, hit=hit)

    first, *_, last = bob.progressive(tracer=tracer, size=SIZE, fraction=0.1)
    assert np.abs(first.color[:6] - (0.2, 0.4, 0.9)).mean() < 0.01
    assert np.allclose(last.color[0, 0], (0.2, 0.4, 0.9))
    assert last.gbuffer.alpha[0, 0] == 0
    assert last.gbuffer.alpha[H // 2, W // 2] == 1


@pytest.mark.parametrize(
    ("returned", "message"),
    [
        ({"color": np.zeros((4, 3))}, "tracer: expected it to return 5 samples, one per pixel, got 4"),
        ({"color": np.zeros((5, 4))}, "color: expected shape (n, 3), got (5, 4)"),
        ({"color": np.full((5, 3), np.nan)}, "color: expected finite numbers, got 15 of 15"),
        ({"color": np.full((5, 3), -1.0)}, "color: expected values of at least 0, got -1"),
        ({"color": np.full((5, 3), 1e60)}, "color: expected finite numbers, got 15 of 15"),
        ({"color": [["red"] * 3] * 5}, "color: expected an array of numbers, got dtype <U3"),
        ({"color": np.zeros((5, 3)), "hit": np.full(5, 2)}, "hit: expected booleans"),
        ({"color": np.zeros((5, 3)), "depth": np.zeros((5, 1))}, "depth: expected shape (5,), got (5, 1)"),
        ({"color": np.zeros((5, 3)), "depth": np.full(5, np.inf)}, "depth: expected finite numbers"),
        ({"color": np.zeros((5, 3)), "normal": np.full((5, 2), 3)}, "normal: expected values in -1..1"),
        ({"color": np.zeros((5, 3)), "albedo": np.full((5, 3), 3)}, "albedo: expected values in 0..1"),
        ({"color": np.zeros((5, 3)), "variance": np.full(5, -1.0)}, "variance: expected values of at least 0"),
        ({"color": np.zeros((5, 3)), "variance": np.zeros((5, 2))}, "variance: expected shape (5, 3), got (5, 2)"),
        ({"depth": np.zeros(5)}, "gray: expected gray or color, got neither"),
    ],
)
def test_each_wrong_return_is_one_line(returned, message):
    frames = bob.progressive(tracer=lambda pixels: bob.Samples(**returned), size=(1, 5), fraction=1, order="lattice")
    with pytest.raises(bob.InputError) as error:
        next(frames)
    assert str(error.value).startswith(message)
    assert "\n" not in str(error.value)


EVERYTHING = ("gray", "color", "depth", "normal", "albedo", "variance")


@pytest.mark.parametrize("name", EVERYTHING)
@pytest.mark.parametrize("is_first", [True, False])
def test_every_call_returns_the_same_channels(name, is_first):
    calls = 0

    def tracer(pixels):
        nonlocal calls
        calls += 1
        n = len(pixels)
        of = {key: np.full((n, *((3,) if key in ("color", "albedo") else ())), 0.5) for key in EVERYTHING}
        of["normal"] = np.zeros((n, 2))
        return bob.Samples(**{key: value for key, value in of.items() if key != name or (calls == 1) == is_first})

    with pytest.raises(bob.InputError) as error:
        list(bob.progressive(tracer=tracer, size=SIZE, fraction=0.3))
    every, got = ("every", "none") if is_first else ("no", "some")
    assert str(error.value) == f"{name}: expected it from {every} call of the tracer, as in the first, got {got}"
    assert calls == 2
    view = bob.View(tracer=lambda camera, pixels: tracer(pixels), size=SIZE)
    calls = 0
    with pytest.raises(bob.InputError, match=rf"^{name}: expected it from {every} call of the tracer"):
        view.frame(fraction=1e-3), view.frame(bob.Camera(azimuth=32), fraction=1e-3)


def test_hits_may_be_left_out_where_all_are():
    def tracer(pixels):
        hit = pixels[:, 0] > 2
        return bob.Samples(ramp(pixels)[:, 0], **({} if hit.all() else {"hit": hit}))

    *_, last = bob.progressive(tracer=tracer, size=SIZE, fraction=0.1)
    assert last.gbuffer.alpha[:3].max() == 0 < last.gbuffer.alpha[3:].min()


class Sized:
    """A tracer with every optional attribute."""

    size = SIZE
    batch = 100

    def __init__(self):
        self.calls = []
        self.asked_for_guides = 0

    def __call__(self, pixels):
        self.calls.append(pixels)
        return bob.Samples(color=ramp(pixels))

    def guides(self):
        self.asked_for_guides += 1
        return {"depth": np.full(SIZE, 7.0), "albedo": np.full((*SIZE, 3), 0.5)}


def test_a_tracer_says_its_size_and_how_it_likes_to_be_called():
    tracer = Sized()
    frames = list(bob.progressive(tracer=tracer, first=0.2, fraction=0.1))
    assert frames[0].image.shape == SIZE
    assert frames[0].fraction == pytest.approx(0.2, abs=0.05)
    assert {len(pixels) for pixels in tracer.calls} == {100}
    assert len(np.unique(np.concatenate(tracer.calls), axis=0)) == H * W
    assert tracer.asked_for_guides == 1
    assert frames[0].gbuffer.guides is not None
    assert frames[-1].fraction == 1
    assert np.array_equal(frames[-1].color.reshape(-1, 3), ramp(EVERYWHERE).astype(np.float32))


def test_networks_know_nothing_of_guides():
    tracer = Sized()
    frame = next(bob.progressive(tracer=tracer, first=0.2, model="small"))
    assert frame.gbuffer.guides is None
    assert tracer.asked_for_guides == 0


def test_the_first_frame_traces_its_share_whatever_time_it_takes():
    tracer = Sized()
    tracer.batch = None
    fractions = [frame.fraction for frame in bob.progressive(tracer=tracer, first=0.25, frame_ms=1e-3)]
    assert fractions[0] == pytest.approx(0.25, abs=1e-3)
    assert fractions[-1] == 1
    assert len(fractions) > 2


def test_all_pixels_at_once_take_no_more_calls_than_they_need():
    tracer = Sized()
    frame = next(bob.progressive(tracer=tracer, first=1))
    assert frame.fraction == 1
    assert len(tracer.calls) == -(-H * W // 100)
    with pytest.raises(bob.InputError, match="order"):
        bob.progressive(tracer=tracer, first=1, order="any")


def test_calls_have_few_sizes():
    sizes = []

    def tracer(pixels):
        sizes.append(len(pixels))
        return bob.Samples(pixels[:, 0] / 240)

    for _ in bob.progressive(tracer=tracer, size=(240, 320), first=0.02, frame_ms=2, order="lattice", model="small"):
        pass
    few = {1, *(2**k for k in range(20)), *(3 * 2**k for k in range(20))}
    assert sum(size not in few for size in sizes) <= 2  # the first share, and the rest


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"size": (5, 5)}, "size: expected the tracer's own, (5, 5), or none, got (48, 64)"),
        ({"batch": 0}, "tracer.batch: expected an integer in 1.."),
        ({"batch": "all"}, "tracer.batch: expected an integer"),
        ({"guides": lambda: 5}, "guides: expected bobrossnet.Guides or a dict of arrays, got int"),
        ({"guides": dict}, "guides: expected depth, normal, albedo or hit, got none of them"),
        ({"guides": lambda: {"light": 1}}, "guides: expected depth, normal, albedo and hit, got light"),
        ({"guides": lambda: {"depth": np.zeros((4, 4))}}, "guides: expected the picture's size (48, 64), got (4, 4)"),
    ],
)
def test_wrong_attributes_are_named(changed, message):
    tracer = Sized()
    for name, value in changed.items():
        setattr(tracer, name, value)
    with pytest.raises(bob.InputError) as error:
        bob.progressive(tracer=tracer, size=SIZE)
    assert str(error.value).startswith(message)


def drawn(pixels, rng, deviation=0.2):
    """Return the ramp with new noise each time, and its variance from a few paths."""
    noise = deviation * rng.standard_normal(len(pixels))
    variance = deviation**2 * rng.chisquare(15, len(pixels)) / 15
    return bob.Samples(color=np.maximum(1 + ramp(pixels) + noise[:, None], 0), variance=variance)


@pytest.mark.parametrize("pace", [{"fraction": 0.5}, {"frame_ms": 2}])
def test_noise_falls_until_the_error_is_as_asked(pace):
    rng = np.random.default_rng(0)
    until = 0.005
    frames = list(bob.progressive(tracer=lambda pixels: drawn(pixels, rng), size=SIZE, until=until, **pace))
    last = frames[-1].gbuffer
    truth = 1 + ramp(EVERYWHERE).reshape(H, W, 3)
    luminance = np.array([0.2126, 0.7152, 0.0722])
    assert all(frame.error > until for frame in frames[:-1])
    assert frames[-1].error <= until
    # Errors are measured after the transfer, as the picture exceeds 1.
    error = np.abs(last.transfer.encode(last.gray) - last.transfer.encode(truth @ luminance)).mean()
    assert error == pytest.approx(frames[-1].error, rel=0.15)
    assert [frame.fraction for frame in frames if frame.fraction < 1] == sorted({f.fraction for f in frames} - {1})
    assert sum(frame.fraction == 1 for frame in frames) > 3
    # Means of independent samples: their variance must match.
    normal = (last.gray - truth @ luminance) / np.sqrt(last.channel("variance"))
    assert normal.std() == pytest.approx(1, abs=0.1)


def test_without_noise_or_an_error_each_pixel_is_traced_once():
    rng = np.random.default_rng(0)
    asked = []

    def tracer(pixels):
        asked.extend(map(tuple, pixels))
        return drawn(pixels, rng)

    *_, last = bob.progressive(tracer=tracer, size=SIZE, fraction=0.3)
    assert last.fraction == 1
    assert len(asked) == len(set(asked)) == H * W
    exact = lambda pixels: bob.Samples(color=ramp(pixels))  # noqa: E731
    *_, last = bob.progressive(tracer=exact, size=SIZE, fraction=0.3, until=1e-9)
    assert last.fraction == 1


@pytest.mark.parametrize("batch", [None, 50], ids=["any", "batches"])
def test_a_tracer_can_not_change_the_pixels_that_it_is_given(tree, batch):
    """They address the samples: reversed in place, the picture would be wrong and reported as exact."""
    size = (24, 32)
    trace = bob.SceneTracer(tree, bob.Camera(), size)

    def tracer(pixels):
        pixels[:, 0] = size[0] - 1 - pixels[:, 0]
        return trace(pixels)

    def of_camera(camera, pixels):
        return tracer(pixels)

    if batch is not None:
        tracer.batch = of_camera.batch = batch
    with pytest.raises(ValueError, match=r"^assignment destination is read-only$"):
        next(bob.progressive(tracer=tracer, size=size, fraction=0.2))
    with pytest.raises(ValueError, match=r"^assignment destination is read-only$"):
        bob.View(tracer=of_camera, size=size).frame(fraction=0.2)


def test_completing_takes_a_small_share_where_nobody_asks_for_frames(tree):
    """Frames of 33 ms take twice the time of the tracer alone."""
    size, seconds = (240, 320), 2e-5
    full = bob.trace(tree, size=size)
    spent = 0.0

    def tracer(pixels):
        nonlocal spent
        start = time.thread_time()
        samples = bob.Samples(gray=full.gray[tuple(pixels.T)])
        while time.thread_time() - start < seconds * len(pixels):
            pass
        spent += time.thread_time() - start
        return samples

    def share():
        nonlocal spent
        spent, start = 0.0, time.process_time()
        *_, frame = bob.progressive(tracer=tracer, size=size)
        assert np.array_equal(frame.image, full.gray)
        return (time.process_time() - start) / spent

    assert least(share, 1.3) < 1.3


def disc(places):
    """A white disc on black, exactly at each place; a far plane around it."""
    hit = np.hypot(places[:, 0] - 24.3, places[:, 1] - 30.8) < 15.5
    return bob.Samples(gray=np.where(hit, 0.8, 0.1), depth=np.where(hit, 0.9, 0.2), albedo=np.ones((len(hit), 3)))


def coverage(samples):
    *_, frame = bob.progressive(tracer=disc, size=SIZE, fraction=0.3, samples=samples)
    return frame


def test_several_samples_smooth_edges():
    plain, smooth, fine = coverage(1), coverage(4), coverage(16)
    assert np.allclose(np.unique(plain.image), (0.1, 0.8))
    assert len(np.unique(np.round(smooth.image, 4))) == 5  # of 0 to 4 samples in the disc
    rows, columns = np.mgrid[0:H, 0:W]
    inside = np.zeros(SIZE)
    for row in (np.arange(32) + 0.5) / 32 - 0.5:
        for column in (np.arange(32) + 0.5) / 32 - 0.5:
            inside += np.hypot(rows + row - 24.3, columns + column - 30.8) < 15.5
    truth = 0.1 + 0.7 * inside / 32**2
    errors = [np.abs(frame.image - truth).mean() for frame in (plain, smooth, fine)]
    assert errors[2] < 0.6 * errors[1] < 0.4 * errors[0]
    # Depths belong to one surface or the other.
    assert np.allclose(np.unique(smooth.gbuffer.depth), (0.2, 0.9))


@pytest.mark.parametrize("batch", [None, 4, 100])
def test_positions_of_a_pixel_follow_each_other(batch):
    asked = []

    def tracer(places):
        asked.append(places)
        assert not places.flags.writeable
        return (places[:, 0] + 1) / H

    if batch:
        tracer.batch = batch
    *_, frame = bob.progressive(tracer=tracer, size=(6, 8), fraction=0.5, samples=4)
    assert all(places.dtype == np.float64 for places in asked)
    if batch:
        assert all(len(places) == batch for places in asked)
    for places in asked:
        pixels = places[: len(places) // 4 * 4].reshape(-1, 4, 2)
        assert np.allclose(pixels - np.rint(pixels), [(-0.25, -0.25), (-0.25, 0.25), (0.25, -0.25), (0.25, 0.25)])
    assert np.allclose(frame.image, np.repeat(np.arange(1, 7)[:, None] / H, 8, axis=1))


def test_one_sample_asks_for_pixels():
    kinds = set()

    def tracer(pixels):
        kinds.add(pixels.dtype)
        return pixels[:, 0] / H

    list(bob.progressive(tracer=tracer, size=SIZE, fraction=0.5, samples=1))
    assert kinds == {np.dtype(np.int32)}


def test_means_of_noisy_samples_have_less_variance():
    def tracer(places):
        return bob.Samples(gray=np.ones(len(places)), variance=np.full(len(places), 0.4))

    *_, frame = bob.progressive(tracer=tracer, size=(6, 8), fraction=1, samples=4)
    assert np.allclose(frame.gbuffer.planes[frame.gbuffer.layout.places["variance"]], 0.1)


def test_futures_of_several_samples():
    with ThreadPoolExecutor(2) as pool:
        *_, frame = bob.progressive(tracer=lambda places: pool.submit(disc, places), size=SIZE, fraction=0.3, samples=4)
    assert np.array_equal(frame.image, coverage(4).image)


def test_samples_that_make_no_sense():
    with pytest.raises(bob.InputError, match=r"^samples: expected 1 with a scene, got more; render antialiases scenes"):
        bob.progressive(bob.happy_tree(), samples=4)
    with pytest.raises(bob.InputError, match=r"^samples: expected an integer in 1\.\.64, got 65"):
        bob.progressive(tracer=disc, samples=65)
    with pytest.raises(bob.InputError, match=r"^samples: expected one of 1, 4, 9, .* got 5"):
        bob.progressive(tracer=disc, samples=5)

    def tracer(places):
        return disc(places)

    tracer.batch = 3
    with pytest.raises(bob.InputError, match=r"^samples: expected at most the tracer's batch, 3, got 4"):
        bob.progressive(tracer=tracer, samples=4)
    with pytest.raises(bob.InputError, match=r"^tracer: expected it to return "):
        list(bob.progressive(tracer=lambda places: bob.Samples(gray=np.ones(3)), size=SIZE, samples=4))
