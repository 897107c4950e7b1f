"""Pictures with a moving camera: earlier samples are reprojected, and exactness is kept."""

import time

import numpy as np
import pytest
from thread_counts import with_threads

import bobrossnet as bob
from bobrossnet.frames.frame import enlarged

SIZE = (96, 128)


def orbit(step: float, count: int, **more: float) -> list[bob.Camera]:
    return [bob.Camera(azimuth=30 + step * k, **more) for k in range(count)]


@pytest.fixture(scope="module")
def scene(tree):
    return bob.Scene(
        [tree, bob.Instance(bob.happy_tree(), material=bob.Material(color="#553311")).translate((0.5, 0, 0))]
    )


def test_a_camera_that_stands_still_ends_exact(scene):
    view = bob.View(scene, size=SIZE)
    full = bob.trace(scene, size=SIZE)
    for k in range(4):
        frame = view.frame(fraction=0.25)
        assert frame.fraction == pytest.approx((k + 1) / 4, abs=1e-3)
        assert frame.gbuffer.stack().tobytes() == full.sample(frame.fraction, order="adaptive").stack().tobytes()
    assert np.array_equal(frame.image, full.gray)
    assert np.array_equal(view.frame(fraction=0.1).image, full.gray)


@pytest.mark.parametrize("fov", [0, 50])
def test_pixels_of_a_camera_that_moved_are_exact(scene, fov):
    view = bob.View(scene, size=SIZE)
    for camera in orbit(3, 4, fov=fov):
        frame = view.frame(camera, fraction=0.1)
        full = bob.trace(scene, camera, size=SIZE)
        traced = frame.gbuffer.mask > 0
        assert traced.mean() == pytest.approx(0.1, abs=1e-3)
        assert np.array_equal(frame.gbuffer.stack()[:, traced], full.stack()[:, traced])
        assert np.array_equal(frame.image[traced], full.gray[traced])
    while frame.fraction < 1:
        frame = view.frame(fraction=0.3)
    assert np.array_equal(frame.image, full.gray)
    assert np.array_equal(frame.gbuffer.stack(), full.stack())


@pytest.mark.parametrize("fov", [0, 50])
def test_what_was_seen_is_not_lost(scene, fov):
    size = (192, 256)
    view = bob.View(scene, size=size)
    for camera in orbit(2, 8, fov=fov):
        frame = view.frame(camera, fraction=0.04)
    full = bob.trace(scene, camera, size=size)
    anew = bob.ssim(bob.complete(full.sample(0.04)), full.gray)
    assert 1 - bob.ssim(frame.image, full.gray) < 0.75 * (1 - anew)


def test_what_is_carried_along_is_shaded_anew():
    ball = bob.implicit(lambda x, y, z: x * x + y * y + z * z - 1, bounds=((-1, -1, -1), (1, 1, 1)))
    view = bob.View(ball, size=SIZE)
    while view.frame(bob.Camera(azimuth=0), fraction=1).fraction < 1:
        pass
    frame = view.frame(bob.Camera(azimuth=40), fraction=0.001)  # with more pixels, a new picture has more detail
    full = bob.trace(ball, bob.Camera(azimuth=40), size=SIZE)
    seen_before = np.zeros(SIZE, bool)
    seen_before[20:76, 60:84] = True  # well inside both cameras' views; a ball looks the same from everywhere
    assert np.abs(frame.image - full.gray)[seen_before].max() < 0.03


def test_zoom_and_pan(scene):
    view = bob.View(scene, size=SIZE)
    camera = bob.Camera()
    frame = view.frame(camera, fraction=1)
    for camera in (bob.Camera(zoom=1.1), bob.Camera(zoom=1.1, pan=(0.1, -0.05)), bob.Camera(zoom=0.9, roll=5)):
        frame = view.frame(camera, fraction=0.03)
        full = bob.trace(scene, camera, size=SIZE)
        anew = bob.ssim(bob.complete(full.sample(0.03)), full.gray)
        assert bob.ssim(frame.image, full.gray) > anew


def test_a_jump_is_no_worse_than_a_new_picture(scene):
    view = bob.View(scene, size=SIZE)
    for camera in (bob.Camera(azimuth=170), bob.Camera(azimuth=60, zoom=30), bob.Camera(azimuth=90, elevation=-80)):
        view.frame(bob.Camera(azimuth=0), fraction=1)
        frame = view.frame(camera, fraction=0.05)
        full = bob.trace(scene, camera, size=SIZE)
        anew = bob.ssim(bob.complete(full.sample(0.05)), full.gray)
        assert bob.ssim(frame.image, full.gray) > anew - 0.03


def test_any_number_of_threads(scene):
    def frames():
        view = bob.View(scene, size=SIZE, seed=5)
        return [view.frame(camera, fraction=0.03).image for camera in orbit(4, 3)]

    assert np.array_equal(*with_threads((1, 3), frames))


def test_by_time(scene):
    def slow(camera, pixels):
        time.sleep(20e-6 * len(pixels))
        return bob.SceneTracer(scene, camera, SIZE)(pixels)

    view = bob.View(tracer=slow, size=SIZE)
    frames = [view.frame(camera, ms=20) for camera in orbit(2, 8)]
    pixels = [frame.fraction * SIZE[0] * SIZE[1] for frame in frames]
    assert max(pixels) < 2 * 20e-3 / 20e-6
    assert min(pixels) >= 1


def test_a_tracer_of_ones_own(scene):
    calls = []

    def tracer(camera, pixels):
        calls.append(camera)
        return bob.SceneTracer(scene, camera, SIZE)(pixels)

    view = bob.View(tracer=tracer, size=SIZE)
    for camera in orbit(2, 3):
        frame = view.frame(camera, fraction=0.05)
        assert calls[-1] == camera
    full = bob.trace(scene, camera, size=SIZE)
    traced = frame.gbuffer.mask > 0
    assert np.array_equal(frame.image[traced], full.gray[traced])
    anew = bob.ssim(bob.complete(full.sample(0.05)), full.gray)
    assert bob.ssim(frame.image, full.gray) > anew
    view.forget()
    again = view.frame(fraction=0.05)
    assert np.array_equal(again.image, bob.complete(full.sample(0.05, order="adaptive")))


def test_frames_keep_what_they_were(scene):
    view = bob.View(scene, size=SIZE)
    view.frame(bob.Camera(azimuth=0), fraction=0.1)
    frame = view.frame(bob.Camera(azimuth=2), fraction=0.1)
    before = frame.image.copy(), frame.gbuffer.stack().copy()
    view.frame(fraction=0.2)
    view.frame(bob.Camera(azimuth=4), fraction=0.2)
    assert np.array_equal(frame.image, before[0])
    assert np.array_equal(frame.gbuffer.stack(), before[1])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "either a scene or a tracer"),
        ({"tracer": 3}, "tracer: expected a callable"),
        ({"tracer": print, "size": (0, 3)}, "height: expected an integer"),
        ({"tracer": print, "seed": -1}, "seed"),
    ],
)
def test_wrong_views(arguments, message):
    with pytest.raises(bob.InputError, match=message):
        bob.View(**arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"camera": 30}, "camera: expected a Camera, got int"),
        ({"ms": 33, "fraction": 0.1}, "ms or fraction"),
        ({"fraction": 5}, "fraction"),
        ({"ms": 0}, "ms"),
    ],
)
def test_wrong_frames(scene, arguments, message):
    view = bob.View(scene, size=SIZE)
    with pytest.raises(bob.InputError, match=message):
        view.frame(**arguments)


def test_depth_of_moving_cameras_is_over_the_unit_sphere():
    def tracer(camera, pixels):
        return bob.Samples(gray=np.full(len(pixels), 0.5), depth=np.full(len(pixels), 7.0))

    view = bob.View(tracer=tracer, size=(24, 32))
    view.frame(bob.Camera(), fraction=0.1)
    with pytest.raises(
        bob.InputError, match=r"^depth: expected 0..1 over the unit sphere where a camera moves, got 0..7$"
    ):
        view.frame(bob.Camera(azimuth=40), fraction=0.1)


def test_frames_with_time_for_a_dense_picture_carry_nothing_along(scene):
    """Reprojection would only take time; with less time, frames reproject."""
    view = bob.View(scene, size=SIZE)
    for camera in orbit(2, 6):
        frame = view.frame(camera, ms=1000)
    assert frame.fraction == 1
    assert np.array_equal(frame.shown.mask, frame.gbuffer.mask)
    frame = view.frame(bob.Camera(azimuth=42), fraction=0.02)
    assert frame.shown.fraction > 0.3 > frame.gbuffer.fraction


def test_frames_with_little_time_are_smaller_and_enlarged(scene):
    """As in pages. A frame at rest, one with a share of the pixels, and those of a tracer have the view's size."""
    view, cameras = bob.View(scene, size=SIZE), orbit(2, 6)
    assert not view.frame(cameras[0], ms=1e-3).is_enlarged
    for camera in cameras[1:]:
        frame = view.frame(camera, ms=1e-3)
        assert frame.is_enlarged
    own, small = frame.gbuffer, tuple(round(length / 8) for length in SIZE)
    assert own.size == frame.shown.size == small
    traced, full = own.mask > 0, bob.trace(scene, camera, size=small)
    assert np.array_equal(own.gray[traced], full.gray[traced])
    assert frame.fraction == pytest.approx(traced.sum() / (SIZE[0] * SIZE[1]))
    assert frame.image.shape == frame.alpha.shape == frame.color.shape[:2] == frame.picture().size == SIZE
    for channel, shown in {"gray": frame.image, "alpha": frame.alpha, "color": frame.color}.items():
        assert np.array_equal(shown, enlarged(bob.complete(frame.shown, frame.network, channel=channel), SIZE))
    assert frame.error > 0
    assert not view.frame(ms=1e-3).is_enlarged
    while view.frame(ms=1000).fraction < 1:
        pass
    assert np.array_equal(view.frame().image, bob.trace(scene, camera, size=SIZE).gray)
    view.frame(cameras[0], ms=1e-3)
    assert not view.frame(cameras[1], fraction=0.01).is_enlarged
    others = bob.View(tracer=lambda camera, pixels: bob.SceneTracer(scene, camera, SIZE)(pixels), size=SIZE)
    assert not any(others.frame(camera, ms=1e-3).is_enlarged for camera in cameras)


def test_the_cheapest_network_that_is_as_good_completes(scene):
    """The filling from a tenth of the pixels on, traced or reprojected, in an adaptive order; otherwise the default."""
    names = {bob.completion.network.load_network(name): name for name in ("default", "filling", "small")}
    frames = list(bob.progressive(scene, size=SIZE, fraction=0.06, model="auto"))
    assert [names[frame.network] for frame in frames[:3]] == ["default", "filling", "filling"]
    assert np.array_equal(frames[0].image, bob.complete(frames[0].gbuffer))
    assert np.array_equal(frames[1].image, bob.complete(frames[1].gbuffer, model="filling"))
    on_lattice = bob.progressive(scene, size=SIZE, fraction=0.3, model="auto", order="lattice")
    assert {names[frame.network] for frame in on_lattice} == {"default"}
    view = bob.View(scene, size=SIZE)
    shares = [names[view.frame(camera, fraction=0.02).network] for camera in orbit(2, 3)]
    assert shares == ["default", "filling", "filling"]
    view = bob.View(scene, size=SIZE, model="small")
    assert names[view.frame(fraction=0.3).network] == "small"


def test_a_picture_is_whole_where_there_is_time_for_it() -> None:
    view = bob.View(bob.happy_tree(), size=(60, 80))
    for azimuth in range(30, 40):
        frame = view.frame(bob.Camera(azimuth=azimuth), ms=500)
        if frame.fraction == 1 and azimuth > 33:
            break
    assert frame.fraction == 1
    np.testing.assert_array_equal(frame.image, bob.trace(bob.happy_tree(), bob.Camera(azimuth), size=(60, 80)).gray)
    assert frame.seconds < 0.5


@pytest.mark.parametrize("fov", [0, 50])
def test_after_large_steps_pictures_are_no_worse_than_new_ones(scene: bob.Scene, fov: float) -> None:
    view = bob.View(scene, size=SIZE)
    for camera in orbit(12, 3, fov=fov):
        frame = view.frame(camera, fraction=0.03)
        new = next(bob.progressive(scene, camera, size=SIZE, fraction=0.03, order="adaptive"))
        np.testing.assert_array_equal(frame.gbuffer.mask, new.gbuffer.mask)
        np.testing.assert_array_equal(frame.shown.mask, new.gbuffer.mask)
    # Fewer pixels have less information than the reprojected samples; more have them in addition.
    for fraction in (0.005, 0.1):
        view.forget()
        view.frame(bob.Camera(azimuth=0, fov=fov), fraction=1)
        assert view.frame(bob.Camera(azimuth=12, fov=fov), fraction=fraction).shown.fraction > 0.5
