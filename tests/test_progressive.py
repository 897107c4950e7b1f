"""Progressive pictures: complete from the first frame, exact in the last, within their budget."""

import re
from importlib import import_module
from itertools import islice

import numpy as np
import pytest
from PIL import Image

import bobrossnet as bob
from bobrossnet import _core

SIZE = (48, 64)


def test_by_share(tree):
    full = bob.trace(tree, size=SIZE)
    frames = list(bob.progressive(tree, size=SIZE, fraction=0.3))
    assert [frame.fraction for frame in frames] == pytest.approx([0.3, 0.6, 0.9, 1], abs=1e-3)
    for frame in frames:
        assert frame.gbuffer == full.sample(frame.fraction, order="adaptive")
        assert np.array_equal(frame.image, bob.complete(frame.gbuffer))
        assert frame.seconds > 0
    assert np.array_equal(frames[-1].image, full.gray)


def test_by_time(tree):
    full = bob.trace(tree, size=SIZE)
    frames = list(bob.progressive(tree, size=SIZE, frame_ms=2, order="adaptive", seed=4))
    fractions = [frame.fraction for frame in frames]
    assert fractions == sorted(set(fractions))
    assert fractions[-1] == 1
    assert frames[0].gbuffer == full.sample(fractions[0], order="adaptive", seed=4)
    assert np.array_equal(frames[-1].image, full.gray)


@pytest.mark.parametrize(("per_pixel", "is_fast"), [(5e-6, True), (2e-3, False)])
def test_where_rays_are_fast_squares_are_divided_after_the_first_round(per_pixel, is_fast, clock, tree):
    """With 20 ms a frame: the squares' first 1/64 of the pixels takes 0.24 ms or 96."""
    full, size = bob.trace(tree, size=SIZE), SIZE[0] * SIZE[1]
    asked = {}
    for order in ("default", "adaptive"):
        trace, calls = clock.tracer(0, per_pixel), []

        def tracer(pixels, trace=trace, calls=calls):
            calls.append(pixels)
            trace(pixels)
            return bob.SceneTracer(tree, bob.Camera(), SIZE)(pixels)

        *_, last = bob.progressive(tracer=tracer, size=SIZE, frame_ms=20, order=order)
        assert np.array_equal(last.image, full.gray)
        asked[order] = np.concatenate(calls)
        assert len(asked[order]) == size
    first_round = size * 35 // 10_000
    assert np.array_equal(asked["default"][:first_round], asked["adaptive"][:first_round])
    if not is_fast:
        assert np.array_equal(asked["default"], asked["adaptive"])
        return
    known = np.zeros(SIZE, np.float32)
    known[tuple(asked["default"][:first_round].T)] = 1
    squares = _core.SquaresOrder(*SIZE, known)
    left = asked["default"][first_round:]
    while len(left):
        expected = squares.next(_core.gbuffer_layout(), full.planes)
        assert np.array_equal(left[: len(expected)], expected)
        left = left[len(expected) :]


def test_batches_smaller_than_the_first_round_trace_all_pixels(clock, tree):
    full, trace = bob.trace(tree, size=SIZE), clock.tracer(0, 5e-6)

    class Batched:
        batch = 4

        def __call__(self, pixels):
            trace(pixels)
            return bob.SceneTracer(tree, bob.Camera(), SIZE)(pixels)

    *_, last = bob.progressive(tracer=Batched(), size=SIZE, frame_ms=20)
    assert last.gbuffer == full


def test_frames_keep_what_they_were(tree):
    frames = bob.progressive(tree, size=SIZE, fraction=0.25)
    first = next(frames)
    before = first.gbuffer.stack().copy(), first.image.copy()
    next(frames)
    assert np.array_equal(first.gbuffer.stack(), before[0])
    assert np.array_equal(first.image, before[1])


def test_frames_are_found_in_collections(tree):
    frames = list(bob.progressive(tree, size=SIZE, fraction=0.5))
    assert frames.index(frames[1]) == 1
    assert {*frames} == {frames[1], frames[0]}


def flat_tracer(pixels):
    n = len(pixels)
    return bob.Samples(pixels[:, 1] / SIZE[1], np.full(n, 0.5), np.zeros((n, 2)), np.ones(n, bool))


def test_the_cores_tracer_is_as_good_as_its_scene(tree):
    tracer = bob.SceneTracer(tree, bob.Camera(), SIZE)
    plugged, scene = (
        next(bob.progressive(tracer=tracer, first=0.05)),
        next(bob.progressive(tree, size=SIZE, first=0.05)),
    )
    assert np.array_equal(plugged.image, scene.image)  # without guides, which would take as long as all pixels
    assert next(bob.progressive(tracer=tracer, first=0.05, model="guided")).is_guided


def test_any_tracer_can_be_plugged_in():
    asked = []

    def tracer(pixels):
        assert pixels.dtype == np.int32
        assert pixels.shape[1] == 2
        asked.append(pixels)
        return flat_tracer(pixels)

    *_, last = bob.progressive(tracer=tracer, size=SIZE, fraction=0.4, order="lattice")
    assert np.allclose(last.image, np.arange(SIZE[1]) / SIZE[1])
    assert np.array_equal(np.concatenate(asked), bob.pixel_order(SIZE, order="lattice"))


class Clock:
    """A clock that only tracing and completion advance, by nominal costs; other load on the machine costs nothing."""

    def __init__(self):
        self.now = 0.0

    def perf_counter(self):
        return self.now

    def tracer(self, per_call, per_pixel):
        def trace(pixels):
            self.now += per_call + per_pixel * len(pixels)
            return flat_tracer(pixels)

        return trace

    def complete(self, gbuffer, model):
        self.now += 2e-3
        return bob.complete(gbuffer, model=model)


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    for module in ("progressive", "partial_picture", "calls"):
        monkeypatch.setattr(import_module(f"bobrossnet.frames.{module}"), "time", clock)
    monkeypatch.setattr(import_module("bobrossnet.frames.partial_picture"), "complete", clock.complete)
    return clock


@pytest.mark.parametrize(("per_call", "per_pixel"), [(0, 20e-6), (0, 200e-6), (1e-3, 20e-6), (4e-3, 2e-6)])
def test_budget_is_kept_and_used(per_call, per_pixel, clock):
    """bench/progressive.py measures it by a real clock."""
    budget = 20
    *frames, last = bob.progressive(tracer=clock.tracer(per_call, per_pixel), size=SIZE, frame_ms=budget)
    for frame in frames:
        assert 0.7 * budget < 1000 * frame.seconds < 1.02 * budget
    assert last.fraction == 1


def test_a_budget_below_the_time_of_completing_comes_to_an_end(clock):
    frames = list(islice(bob.progressive(tracer=clock.tracer(0, 1e-6), size=SIZE, frame_ms=1e-3), 1000))
    assert frames[-1].fraction == 1


@pytest.mark.parametrize("pace", [{"fraction": 0.02}, {"frame_ms": 5}])
def test_it_ends_where_little_error_is_expected(pace, tree):
    full = bob.trace(tree, size=(120, 160))
    *frames, last = bob.progressive(tree, size=(120, 160), until=0.004, **pace)
    assert last.error <= 0.004
    assert all(frame.error > 0.004 for frame in frames)
    assert last.fraction > 0.05
    assert last.fraction < 0.6 or "frame_ms" in pace  # a frame may have time for all of them
    assert np.abs(last.image - full.gray).mean() < 1.3 * 0.004  # an estimate, up to 1.2 times as large


def test_predicting_errors_is_part_of_a_frame(clock, monkeypatch):
    def mean_error(gbuffer, model):
        clock.now += 5e-3
        return 1.0

    monkeypatch.setattr(import_module("bobrossnet.frames.partial_picture"), "mean_error", mean_error)
    *frames, last = bob.progressive(tracer=clock.tracer(0, 20e-6), size=SIZE, frame_ms=20, until=0.01)
    assert all(0.7 * 20 < 1000 * frame.seconds < 1.02 * 20 for frame in frames)
    assert last.fraction == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "progressive: expected either a scene or a tracer, got neither"),
        ({"scene": 1, "tracer": flat_tracer}, "progressive: expected either a scene or a tracer, got both"),
        ({"scene": "nothing.ply"}, "nothing.ply: expected a file, found nothing at nothing.ply"),
        ({"tracer": 5}, "tracer: expected a callable, got int"),
        ({"tracer": flat_tracer, "camera": bob.Camera()}, "camera: expected none with a tracer"),
        (
            {"tracer": flat_tracer, "frame_ms": 33, "fraction": 0.1},
            "progressive: expected frame_ms or fraction",
        ),
        ({"tracer": flat_tracer, "frame_ms": 0}, "frame_ms: expected a number above 0, got 0"),
        ({"tracer": flat_tracer, "fraction": 2}, "fraction"),
        ({"tracer": flat_tracer, "until": -1}, "until: expected a number"),
        ({"tracer": flat_tracer, "size": (0, 0)}, "height"),
        ({"tracer": flat_tracer, "order": "spiral"}, "order"),
        ({"tracer": flat_tracer, "model": "oil"}, "model"),
    ],
)
def test_bad_arguments_are_named_at_once(arguments, message):
    with pytest.raises(bob.InputError) as error:
        bob.progressive(**({"size": SIZE} | arguments))
    assert str(error.value).startswith(message)


@pytest.mark.parametrize(
    ("tracer", "message"),
    [
        (
            lambda pixels: [0.0] * len(pixels),
            "tracer: expected it to return bobrossnet.Samples, got list",
        ),
        (
            lambda pixels: flat_tracer(pixels[1:]),
            "tracer: expected it to return 1229 samples, one per pixel, got 1228",
        ),
    ],
)
def test_bad_tracers_are_named(tracer, message):
    with pytest.raises(bob.InputError) as error:
        next(bob.progressive(tracer=tracer, size=SIZE, fraction=0.4, order="lattice"))
    assert str(error.value) == message


def test_what_a_tracer_raises_comes_through():
    def tracer(pixels):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        next(bob.progressive(tracer=tracer, size=SIZE))


def test_frames_show_and_save_themselves_as_the_final_picture_looks(tmp_path):
    """Traced pixels have the tone curve of `render`; a notebook shows a picture, not arrays."""
    tree = bob.happy_tree()
    exact = bob.render(tree, size=SIZE, samples=1)
    *_, last = bob.progressive(tree, size=SIZE, fraction=0.5)
    assert np.array_equal(last.picture().rgba, exact.rgba)
    last.save(tmp_path / "last.png", "#fff")
    with Image.open(tmp_path / "last.png") as image:
        white = np.asarray(bob.render(tree, size=SIZE, samples=1, background="#fff"))
        assert np.array_equal(np.asarray(image.convert("RGBA")), white)
    assert last._repr_png_().startswith(b"\x89PNG")
    assert re.fullmatch(r"Frame\(\d+ x \d+, 100 % traced, [\d.e+]+ ms\)", repr(last))


def test_frames_of_lit_backgrounds_are_opaque():
    def sunset(pixels):
        return bob.Samples(gray=np.full(len(pixels), 0.5), hit=np.zeros(len(pixels), bool))

    *_, last = bob.progressive(tracer=sunset, size=SIZE, fraction=1)
    assert (last.picture().rgba == (188, 188, 188, 255)).all()
