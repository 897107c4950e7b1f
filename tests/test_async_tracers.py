"""Tracers that return futures: calls run concurrently, and finish in any order."""

import asyncio
import os
import signal
import threading
import time
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet import _core

H, W = SIZE = (48, 64)
LATER = 0.002


def found(pixels):
    """A disc in front of a ramp."""
    row, column = pixels.T
    hit = np.hypot(row - H / 2, column - W / 2) < 15
    gray = np.where(hit, row / H, column / W)
    return bob.Samples(color=gray[:, None] * (1, 0.5, 0.25), depth=np.where(hit, 0.6, 0), hit=hit)


def noisy(pixels, deviation=0.1):
    rng = np.random.default_rng(abs(hash(pixels.tobytes())))
    gray = 1 + pixels[:, 1] / W + deviation * rng.standard_normal(len(pixels))
    return bob.Samples(gray, variance=np.full(len(pixels), deviation**2))


class Pool:
    """A tracer with calls in threads; some overtake earlier ones."""

    size = SIZE
    in_flight = 4

    def __init__(self, trace=found, workers=4):
        self.trace = trace
        self.executor = ThreadPoolExecutor(workers)
        self.calls, self.running, self.most, self.lock = [], 0, 0, threading.Lock()

    def __call__(self, pixels):
        self.calls.append(pixels)
        return self.executor.submit(self.run, pixels, LATER * (1 + len(self.calls) % 3))

    def run(self, pixels, seconds):
        with self.lock:
            self.running += 1
            self.most = max(self.most, self.running)
        try:
            time.sleep(seconds)
            return self.trace(pixels)
        finally:
            with self.lock:
                self.running -= 1

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.executor.shutdown()


class ByHand:
    """A tracer whose calls end when a test ends them."""

    size = SIZE

    def __init__(self, in_flight=4):
        self.in_flight = in_flight
        self.calls = []
        self.ending = threading.Lock()  # timers and the test may end calls at once

    def __call__(self, pixels):
        future = Future()
        self.calls.append((pixels, future))
        return future

    def made(self, index):
        """Return a call and its future, once it exists."""
        while len(self.calls) <= index:
            time.sleep(1e-3)
        return self.calls[index]

    def end(self, index):
        with self.ending:
            pixels, future = self.made(index)
            del self.calls[index]
        future.set_result(found(pixels))
        return len(pixels)


def last_of(**arguments):
    *_, last = bob.progressive(**arguments)
    return last


PACES = [{"fraction": 0.1}, {"first": 0.2, "frame_ms": 5}, {"frame_ms": 20}]


@pytest.mark.parametrize("pace", PACES)
@pytest.mark.parametrize("order", ["adaptive", "uniform"])
@pytest.mark.parametrize("batch", [None, 50])
def test_the_picture_is_that_of_a_plain_tracer_to_the_bit(pace, order, batch):
    with Pool() as tracer:
        tracer.batch = batch
        frames = list(bob.progressive(tracer=tracer, order=order, **pace))
    plain = last_of(tracer=found, size=SIZE)
    assert frames[-1].gbuffer == plain.gbuffer
    assert np.array_equal(frames[-1].image, plain.image)
    assert np.array_equal(frames[-1].color, plain.color)
    fractions = [frame.fraction for frame in frames]
    assert fractions == sorted(set(fractions))
    assert fractions[0] >= pace.get("first", pace.get("fraction", 0)) - 1e-3
    asked = np.concatenate(tracer.calls)
    assert len(np.unique(asked, axis=0)) == H * W
    assert tracer.most == tracer.in_flight
    if batch is None:
        assert len(asked) == H * W
    else:
        assert {len(pixels) for pixels in tracer.calls} == {batch}
    for frame in frames:
        row, column = np.argwhere(frame.gbuffer.mask).T
        assert np.array_equal(frame.color[row, column], plain.color[row, column])


def test_results_may_come_in_any_order():
    tracer = ByHand()
    frames = bob.progressive(tracer=tracer, fraction=1)
    random = np.random.default_rng(0)

    def end_some():
        while waiting.is_alive():
            if len(tracer.calls) >= 4 or frames.gi_frame is None or (len(tracer.calls) and random.random() < 0.1):
                tracer.end(random.integers(len(tracer.calls)))
            time.sleep(1e-4)

    out = []
    waiting = threading.Thread(target=lambda: out.extend(frames))
    waiting.start()
    end_some()
    assert out[-1].gbuffer == last_of(tracer=found, size=SIZE).gbuffer


def test_frames_come_while_calls_are_under_way():
    tracer = ByHand(in_flight=3)
    frames = bob.progressive(tracer=tracer, frame_ms=20)
    ended = []
    timer = threading.Timer(0.05, lambda: ended.append(tracer.end(1)))
    timer.start()
    first = next(frames)
    timer.join()
    assert len(tracer.calls) == 3  # another one began
    assert first.fraction == ended[0] / (H * W)
    tracer.end(2)
    second = next(frames)
    assert second.fraction > first.fraction
    assert second.seconds < 1
    for _, future in tracer.calls:
        future.set_result(None)
    frames.close()


def test_what_is_under_way_is_not_taken_for_empty(tree):
    """Rounds decided before the last call returns choose the same pixels as synchronous ones."""
    full = bob.trace(tree, size=(240, 320))

    def traced(pixels):
        row, column = pixels.T
        return bob.Samples(full.gray[row, column], full.depth[row, column], full.normal[row, column])

    class Late(ByHand):
        size = (240, 320)
        batch = 24  # otherwise sizes would depend on measured times

        def __call__(self, pixels):
            if len(self.calls) == self.in_flight - 1:  # the oldest finishes
                pixels_before, future = self.calls.pop(0)
                future.set_result(traced(pixels_before))
            return super().__call__(pixels)

    frame = next(bob.progressive(tracer=Late(8), first=0.05, fraction=0.05))
    assert frame.fraction == pytest.approx(0.05, abs=0.01)
    late, plain = (bob.ssim(bob.complete(part), full.gray) for part in (frame.gbuffer, full.sample(frame.fraction)))
    assert late > plain - 0.02


@pytest.mark.parametrize("until", [0.002, 0.02])
def test_noise_falls_until_the_error_is_as_asked(until):
    with Pool(noisy) as tracer:
        *frames, last = bob.progressive(tracer=tracer, fraction=0.3, until=until)
    assert last.error <= until
    assert all(frame.error > until for frame in frames)
    asked = np.concatenate(tracer.calls)
    assert len(asked) > H * W or until == 0.02
    assert tracer.running == 0


def test_guides_are_followed():
    class Guided(Pool):
        def guides(self):
            return {"depth": np.full(SIZE, 5.0)}

    with Guided() as tracer:
        *_, last = bob.progressive(tracer=tracer, fraction=0.3)
    assert last.gbuffer.guides is not None
    assert np.array_equal(last.color, last_of(tracer=found, size=SIZE).color)


def test_nothing_is_left_when_it_is_closed_early():
    threads = threading.active_count()
    with Pool(workers=2) as tracer:
        frames = bob.progressive(tracer=tracer, fraction=0.1)
        next(frames)
        frames.close()
        assert tracer.running == 0
        count = len(tracer.calls)
        time.sleep(5 * LATER)
        assert (tracer.running, len(tracer.calls)) == (0, count)
    assert threading.active_count() == threads


def test_calls_that_have_not_begun_are_cancelled():
    tracer = ByHand()
    frames = bob.progressive(tracer=tracer, frame_ms=1)
    threading.Timer(0.02, lambda: tracer.end(0)).start()
    next(frames)
    futures = [future for _, future in tracer.calls]
    assert len(futures) == 4
    frames.close()
    assert all(future.cancelled() for future in futures)


def test_the_end_by_its_error_leaves_nothing():
    with Pool() as tracer:
        last = last_of(tracer=tracer, fraction=0.02, until=0.2)
        assert last.fraction < 1
        assert tracer.running == 0


def test_what_a_call_raises_comes_through():
    def failing(pixels):
        raise ZeroDivisionError("mine")

    with Pool(failing) as tracer:
        frames = bob.progressive(tracer=tracer)
        with pytest.raises(ZeroDivisionError, match="mine"):
            next(frames)
        assert tracer.running == 0
        assert list(frames) == []


def test_a_tracer_that_fails_itself_leaves_no_call():
    class Failing(Pool):
        def __call__(self, pixels):
            if len(self.calls) == 3:
                raise OSError("no connection")
            return super().__call__(pixels)

    with Failing() as tracer:
        with pytest.raises(OSError, match="no connection"):
            next(bob.progressive(tracer=tracer))
        assert tracer.running == 0


async def coroutine(pixels):
    return found(pixels)


@pytest.mark.parametrize(
    ("tracer", "message"),
    [
        (lambda future: future.set_result([0.5]), "expected it to return bobrossnet.Samples, got list"),
        (lambda future: future.set_result(np.zeros(3)), "expected it to return 10 samples, one per pixel, got 3"),
        (
            lambda future: future.set_result(bob.Samples([0.5])),
            "expected it to return 10 samples, one per pixel, got 1",
        ),
        (lambda future: future.cancel(), "expected samples, got a future that was cancelled"),
    ],
)
def test_each_wrong_future_is_one_line(tracer, message):
    def filled(pixels):
        future = Future()
        tracer(future)
        return future

    with pytest.raises(bob.InputError) as error:
        next(bob.progressive(tracer=filled, size=SIZE))  # 10 pixels are the first round
    assert str(error.value) == f"tracer: {message}"


def asyncio_future(pixels):
    loop = asyncio.new_event_loop()
    future = loop.create_future()
    loop.close()
    return future


@pytest.mark.parametrize(("tracer", "got"), [(coroutine, "coroutine"), (asyncio_future, "Future")])
def test_what_a_loop_in_this_thread_would_fill_is_refused(tracer, got):
    with pytest.raises(bob.InputTypeError) as error:
        next(bob.progressive(tracer=tracer, size=SIZE))
    assert str(error.value) == (
        f"tracer: expected it to return bobrossnet.Samples or a concurrent future, got {got}; "
        "asyncio.run_coroutine_threadsafe returns such a future"
    )


def test_coroutines_in_a_loop_elsewhere():
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    tracer = lambda pixels: asyncio.run_coroutine_threadsafe(coroutine(pixels), loop)  # noqa: E731
    assert last_of(tracer=tracer, size=SIZE).gbuffer == last_of(tracer=found, size=SIZE).gbuffer
    loop.call_soon_threadsafe(loop.stop)
    thread.join()
    loop.close()


@pytest.mark.parametrize("pace", PACES)
@pytest.mark.parametrize("in_flight", [None, 1, 3])
def test_samples_and_futures_may_alternate(pace, in_flight):
    class Mixed(Pool):
        def __call__(self, pixels):
            future = super().__call__(pixels)
            return future.result() if len(self.calls) % 3 else future

    with Mixed() as tracer:
        tracer.in_flight = in_flight
        assert last_of(tracer=tracer, **pace).gbuffer == last_of(tracer=found, size=SIZE).gbuffer


def test_samples_at_once_keep_the_pace_whatever_is_said_to_be_in_flight():
    def tracer(pixels):
        time.sleep(LATER)
        return found(pixels)

    tracer.in_flight = 5
    frames = bob.progressive(tracer=tracer, size=SIZE, frame_ms=20)
    assert np.median([frame.seconds for frame in frames]) < 0.1


@pytest.mark.parametrize("in_flight", [0, 2.5, "many", 2**20])
def test_wrong_numbers_of_calls_are_named(in_flight):
    tracer = ByHand(in_flight)
    with pytest.raises(bob.InputError, match=r"^tracer.in_flight: expected an integer"):
        bob.progressive(tracer=tracer)


def seen(tree, camera, pixels):
    return bob.SceneTracer(tree, camera, SIZE)(pixels)


class Seeing(Pool):
    """The same tracer for a `View`."""

    def __init__(self, tree, **arguments):
        super().__init__(lambda asked: seen(tree, *asked), **arguments)

    def __call__(self, camera, pixels):
        return super().__call__((camera, pixels))


class SeeingByHand(ByHand):
    def __init__(self, tree, in_flight):
        super().__init__(in_flight)
        self.tree = tree

    def __call__(self, camera, pixels):
        return super().__call__((camera, pixels))

    def end(self, index):
        with self.ending:
            asked, future = self.made(index)
            del self.calls[index]
        future.set_result(seen(self.tree, *asked))


def is_exact(frame, tree, camera):
    """Return whether all traced pixels equal this camera's picture, and are shown unchanged."""
    full, traced = bob.trace(tree, camera, size=SIZE), frame.gbuffer.mask > 0
    same = np.array_equal(frame.gbuffer.stack()[:, traced], full.stack()[:, traced])
    return same and np.array_equal(frame.image[traced], full.gray[traced])


def test_a_view_of_futures_ends_exact(tree):
    with Seeing(tree) as tracer:
        view = bob.View(tracer=tracer, size=SIZE)
        frame = view.frame(fraction=0.1)
        assert round(0.1 * H * W) / (H * W) <= frame.fraction < 1
        while frame.fraction < 1:
            before, frame = frame.fraction, view.frame(ms=5)
            assert before < frame.fraction
        assert is_exact(frame, tree, bob.Camera())
        assert len(np.unique(np.concatenate([pixels for _, pixels in tracer.calls]), axis=0)) == H * W
        count = len(tracer.calls)
        view.frame(fraction=0.1)
        assert (len(tracer.calls), tracer.running) == (count, 0)
        assert tracer.most == tracer.in_flight


@pytest.mark.parametrize("pace", [{"fraction": 0.05}, pytest.param({"ms": 10}, marks=pytest.mark.measures)])
def test_views_of_futures_carry_along_and_show_nothing_of_other_cameras(tree, pace):
    with Seeing(tree) as tracer:
        view = bob.View(tracer=tracer, size=SIZE)
        view.frame(fraction=0.3)
        for azimuth in range(32, 44, 2):
            camera = bob.Camera(azimuth=azimuth)
            frame = view.frame(camera, **pace)
            assert frame.gbuffer.fraction < frame.shown.fraction
            assert is_exact(frame, tree, camera)
            assert {asked for asked, _ in tracer.calls[-tracer.in_flight :]} == {camera}
        while frame.fraction < 1:
            frame = view.frame(fraction=0.2)
            assert is_exact(frame, tree, camera)
        assert np.array_equal(frame.image, bob.trace(tree, camera, size=SIZE).gray)


def test_calls_of_a_camera_before_are_cancelled_or_dropped(tree):
    tracer = SeeingByHand(tree, in_flight=4)
    view = bob.View(tracer=tracer, size=SIZE)
    threading.Timer(0.02, lambda: tracer.end(0)).start()
    view.frame(ms=5)
    _, (_, running), (_, waits), (_, waits_too) = tracer.calls
    assert running.set_running_or_notify_cancel()
    tracer.end(0)  # in time to be reprojected
    tracer.calls.clear()
    camera = bob.Camera(azimuth=32)
    timer = threading.Timer(0.05, lambda: tracer.end(0))
    timer.start()
    frame = view.frame(camera, ms=5)
    begun = len(tracer.calls)
    timer.join()  # a frame of reprojected samples may come before
    assert waits.cancelled()
    assert waits_too.cancelled()
    assert is_exact(frame, tree, camera)
    assert 2 <= begun <= 3  # running calls keep their slots
    running.set_result("nobody looks at this")
    timer = threading.Timer(0.02, lambda: tracer.end(0))
    timer.start()
    frame = view.frame(ms=5)
    begun = len(tracer.calls)
    timer.join()
    assert 3 <= begun <= 4
    while frame.fraction < 1:
        assert is_exact(frame, tree, camera)
        for _ in tracer.calls[:]:
            tracer.end(0)
        frame = view.frame(ms=1)
    assert np.array_equal(frame.image, bob.trace(tree, camera, size=SIZE).gray)


@pytest.fixture
def interruptible():
    """A job in the background ignores Ctrl-C, and so do the tests that it starts."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_one_call_at_a_time_waits_for_one_that_was_dropped(tree):
    tracer = SeeingByHand(tree, in_flight=1)
    view = bob.View(tracer=tracer, size=SIZE)

    def interrupt():
        _, future = tracer.made(0)
        future.set_running_or_notify_cancel()
        time.sleep(0.05)  # until the view waits for it
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    with pytest.raises(KeyboardInterrupt):
        view.frame(fraction=0.001)
    begun = []

    def end():
        begun.append(len(tracer.calls))
        tracer.end(0)
        tracer.end(0)

    threading.Timer(0.05, end).start()
    assert view.frame(fraction=0.001).fraction == pytest.approx(0.001, abs=3e-4)
    assert begun == [1]


def test_a_view_whose_tracer_failed_begins_anew(tree):
    class Failing(Seeing):
        fails = False

        def run(self, asked, seconds):
            if self.fails:
                raise OSError("a worker is gone")
            return super().run(asked, seconds)

    with Failing(tree) as tracer:
        view = bob.View(tracer=tracer, size=SIZE)
        view.frame(fraction=0.5)
        tracer.fails = True
        with pytest.raises(OSError, match="a worker is gone"):
            view.frame(fraction=0.5)
        tracer.fails = False
        frame = view.frame(fraction=0.1)
        assert frame.fraction < 0.4
        while frame.fraction < 1:
            frame = view.frame(fraction=0.3)
        assert is_exact(frame, tree, bob.Camera())


def test_closed_views_leave_nothing(tree):
    with Seeing(tree, workers=2) as tracer:
        view = bob.View(tracer=tracer, size=SIZE)
        view.frame(fraction=0.1)
        view.frame(bob.Camera(azimuth=32), fraction=0.1)
        view.close()
        assert tracer.running == 0
        count = len(tracer.calls)
        time.sleep(5 * LATER)
        assert (tracer.running, len(tracer.calls)) == (0, count)
        assert is_exact(view.frame(fraction=0.1), tree, bob.Camera(azimuth=32))


def test_dask():
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=2, processes=False, dashboard_address=":0") as cluster,
        distributed.Client(cluster) as client,
    ):
        tracer = partial(client.submit, found)
        assert last_of(tracer=tracer, size=SIZE).gbuffer == last_of(tracer=found, size=SIZE).gbuffer
        frames = bob.progressive(tracer=tracer, size=SIZE, fraction=0.1)
        next(frames)
        frames.close()
        with pytest.raises(ZeroDivisionError):
            next(bob.progressive(tracer=lambda pixels: client.submit(lambda: 1 / 0), size=SIZE))


def test_the_rate_is_that_of_all_calls():
    """Any waiting is included: here twice as many calls are in flight as run."""
    turnover, workers, in_flight, per_call, per_pixel = _core.Turnover(), 4, 8, 0.002, 0.001
    free, now, calls = [0.0] * workers, 0.0, []
    for _ in range(200):
        while len(calls) < in_flight:
            n = turnover.pixels_in(0.1, in_flight)
            worker = free.index(min(free))
            free[worker] = max(free[worker], now) + per_call + n * per_pixel
            calls.append((free[worker], now, n))
        calls.sort()
        ended, began, n = calls.pop(0)
        turnover.returned(n, ended - began, ended, in_flight)
        now = ended
    assert turnover.pixels_in(0.1, in_flight) == pytest.approx((0.1 / 2 - per_call) / per_pixel, rel=0.15)
    turnover.resumed(now + 100)  # idle until then
    turnover.returned(48, 0.05, now + 100.0125, in_flight)
    assert turnover.pixels_in(0.1, in_flight) == pytest.approx((0.1 / 2 - per_call) / per_pixel, rel=0.2)
