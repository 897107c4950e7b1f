"""Objects shared by threads: each thread gets its usual result, or a one-line error."""

from __future__ import annotations

import copy
import struct
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.picture.channels import TRACED
from bobrossnet.support.threads import Turns, lazy, together

SIZE = (48, 64)


def at_once(*works: Callable[[], Any]) -> list[BaseException]:
    """Return the exceptions of threads that start together."""
    start, raised = threading.Barrier(len(works)), []

    def run(work: Callable[[], Any]) -> None:
        start.wait()
        try:
            work()
        except BaseException as error:
            raised.append(error)

    threads = [threading.Thread(target=run, args=[work]) for work in works]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return raised


@contextmanager
def suppress_refusal() -> Iterator[None]:
    try:
        yield
    except ValueError as error:
        if "expected one thread at a time, got another" not in str(error):
            raise


def test_two_threads_share_a_view(tree: bob.Scene) -> None:
    view = bob.View(tree, size=SIZE)
    frames: list[bob.Frame] = []

    def turn(first: int) -> Callable[[], None]:
        def run() -> None:
            for step in range(8):
                camera = bob.Camera(azimuth=first + 2 * step)
                frames.append(view.frame(camera, fraction=0.02))

        return run

    assert at_once(turn(0), turn(90), view.forget) == []
    assert len(frames) == 16
    assert all(np.isfinite(frame.image).all() for frame in frames)
    while frames[-1].fraction < 1:
        frames.append(view.frame(bob.Camera(), fraction=0.5))
    assert (frames[-1].image == bob.trace(tree, bob.Camera(), size=SIZE).gray).all()


def test_a_view_calls_its_tracer_for_one_thread_at_a_time(tree: bob.Scene) -> None:
    inside, most = 0, 0

    def tracer(camera: bob.Camera, pixels: np.ndarray) -> bob.Samples:
        nonlocal inside, most
        inside += 1
        most = max(most, inside)
        time.sleep(0.02)
        inside -= 1
        return bob.SceneTracer(tree, camera, SIZE)(pixels)

    view = bob.View(tracer=tracer, size=SIZE)
    works = [lambda azimuth=a: view.frame(bob.Camera(azimuth=azimuth), fraction=0.02) for a in (0, 40, 80)]
    assert at_once(*works, view.close) == []
    assert most == 1


def test_a_view_is_not_used_from_within_its_tracer(tree: bob.Scene) -> None:
    views: list[bob.View] = []

    def tracer(camera: bob.Camera, pixels: np.ndarray) -> bob.Samples:
        if views:
            views[0].frame(camera)
        return bob.SceneTracer(tree, camera, SIZE)(pixels)

    views.append(bob.View(tracer=tracer, size=SIZE))
    with pytest.raises(bob.InputError, match=r"^View: expected one call at a time, got another from within"):
        views[0].frame(fraction=0.1)


def test_objects_of_the_core_that_change_refuse_a_second_thread() -> None:
    """Every object that releases the GIL: no crash, and errors of one line."""
    size = (256, 256)
    layout, planes = TRACED.core, np.zeros((TRACED.width, *size), np.float32)
    off_center = np.zeros(size, np.float32)
    camera = bob.Camera().core((0, 0, 0), 1)
    history, refresh = _core.History(layout, *size), _core.RefreshOrder(*size)
    adaptive, squares = _core.AdaptiveOrder(0, *size), _core.SquaresOrder(*size)
    works: list[Callable[[], Any]] = [
        lambda: history.add(camera, planes),
        lambda: history.expect(camera, planes.copy(), off_center.copy()),
        history.clear,
        lambda: history.bytes,
        lambda: refresh.begin(1),
        lambda: refresh.next(layout, planes, planes, off_center, 100),
        lambda: adaptive.next(layout, planes),
        lambda: adaptive.bytes,
        lambda: squares.next(layout, planes),
    ]

    def often(work: Callable[[], Any]) -> Callable[[], None]:
        def run() -> None:
            for _ in range(5):
                with suppress_refusal():
                    work()

        return run

    assert at_once(*map(often, works), *map(often, works)) == []


def test_an_order_that_is_at_work_refuses_another_thread() -> None:
    size = (1024, 1024)
    order, planes = _core.AdaptiveOrder(0, *size), np.zeros((TRACED.width, *size), np.float32)
    refused: list[str] = []

    def run() -> None:
        end = time.monotonic() + 20
        while not refused and time.monotonic() < end:
            try:
                order.next(TRACED.core, planes)
            except ValueError as error:
                refused.append(str(error))

    assert at_once(run, run) == []
    assert refused[0].startswith("expected one thread at a time, got another that uses the same object;")


def test_two_threads_build_one_shape(tree: bob.Scene) -> None:
    torus = bob.implicit(lambda x, y, z: ((x * x + y * y) ** 0.5 - 1) ** 2 + z * z - 0.1)
    cores: list[object] = []
    assert at_once(*3 * [lambda: cores.append(torus.core)]) == []
    assert len(cores) == 3
    assert len(set(map(id, cores))) == 1


class Two:
    """An object whose property waits for another object's."""

    def __init__(self, both: threading.Barrier) -> None:
        self.both, self.computed = both, 0

    @lazy
    def value(self) -> int:
        self.both.wait(20)
        self.computed += 1
        return self.computed


def test_values_of_two_objects_are_computed_at_once() -> None:
    both = threading.Barrier(2)
    first, second = Two(both), Two(both)
    assert at_once(lambda: first.value, lambda: second.value) == []
    assert (first.value, second.value) == (1, 1)


def test_no_property_has_a_lock_for_its_class() -> None:
    """As functools.cached_property has, up to Python 3.11."""
    sources = [file for file in Path(bob.__file__).parent.rglob("*.py") if file.name != "threads.py"]
    assert sources
    assert [file.name for file in sources if "cached_property" in file.read_text()] == []


class Failing:
    """A property that succeeds at the second attempt."""

    tries = 0

    @lazy
    def value(self) -> int:
        self.tries += 1
        if self.tries == 1:
            raise ValueError("first")
        return self.tries


def test_a_value_that_failed_is_computed_again() -> None:
    failing = Failing()
    with pytest.raises(ValueError, match="first"):
        failing.value  # noqa: B018
    assert (failing.value, failing.value, failing.tries) == (2, 2, 2)
    assert copy.copy(failing).value == 2


def test_turns_are_taken() -> None:
    turns, inside, most = Turns("Object"), 0, 0

    def run() -> None:
        nonlocal inside, most
        for _ in range(100):
            with turns:
                inside += 1
                most = max(most, inside)
                inside -= 1

    assert at_once(run, run) == []
    assert most == 1


def test_a_thread_that_never_traces_pays_a_kilobyte_at_most():
    module = Path(_core.__file__).read_bytes()
    if module[:5] != b"\x7fELF\x02":
        pytest.skip("needs a module of 64-bit ELF")
    (at,) = struct.unpack_from("<Q", module, 32)
    size, count = struct.unpack_from("<HH", module, 54)
    pt_tls = 7
    segments = [struct.unpack_from("<IIQQQQQQ", module, at + i * size) for i in range(count)]
    (thread_local,) = (segment[6] for segment in segments if segment[0] == pt_tls)
    assert thread_local <= 1024, "thread-local memory: use thread_memory<T>(), which allocates on first use"


@pytest.fixture
def two_threads() -> Iterator[None]:
    count = bob.thread_count()
    bob.set_thread_count(2)
    yield
    bob.set_thread_count(count)


@pytest.mark.usefixtures("two_threads")
def test_two_threads_make_calls() -> None:
    """Each call of the first thread waits for one of the second."""
    meeting = threading.Barrier(2, timeout=30)

    def call(i: int) -> tuple[int, int]:
        meeting.wait()
        return i, threading.get_ident()

    found = together([partial(call, i) for i in range(6)])
    assert [i for i, _ in found] == [*range(6)]
    assert len({thread for _, thread in found}) == 2
    bob.set_thread_count(1)
    assert {thread for _, thread in together([lambda: (0, threading.get_ident())] * 3)} == {threading.get_ident()}
    assert together([]) == []


@pytest.mark.usefixtures("two_threads")
def test_exceptions_of_either_thread_end_both() -> None:
    made = []

    def slow(i: int) -> None:
        time.sleep(0.2)
        made.append(i)

    def refuse() -> None:
        raise bob.InputError("refused")

    for calls in ([refuse, *(partial(slow, i) for i in range(20))], [*(partial(slow, i) for i in range(20)), refuse]):
        made.clear()
        with pytest.raises(bob.InputError, match="refused"):
            together(calls)
        time.sleep(0.5)  # the other thread ends its call
        assert len(made) <= 1
