"""Forks, exits, and sub-interpreters, while threads are working."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import import_module

import pytest

FORKED = """
import os, sys, threading, time
import numpy as np
import bobrossnet as bob
from bobrossnet import _core

bob.set_thread_count(2)

BOX = ((-1, -1, -1), (1, 1, 1))

def wild(k):
    waves = lambda x, y, z: np.sin(k * x) + np.sin(k * y) + np.sin(k * z) + 0.1 * np.sin(3 * k * x * y)
    return bob.implicit(waves, BOX)

def in_child(work):
    child = os.fork()
    if not child:
        status = 1
        try:
            status = 0 if work() else 2
        finally:
            os._exit(status)
    for _ in range(600):
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.05)
    os.kill(child, 9)
    return "hangs"

def while_at_work(thread_does, work):
    thread = threading.Thread(target=thread_does, daemon=True)
    thread.start()
    time.sleep(0.3)
    assert thread.is_alive(), "ended too soon"
    return in_child(work)
"""

BUILDING = """
shape, other = wild(40), wild(2)
def builds():
    for k in range(40, 90):
        wild(k).core
threading.Thread(target=lambda: shape.core, daemon=True).start()
def work():
    other.core
    assert len(os.listdir("/proc/self/task")) == 2  # the pool's other thread
    bob.trace(bob.happy_tree(), size=(30, 40))
    return True
print(while_at_work(builds, work))
"""

VIEWING = """
event, scene = threading.Event(), bob.Scene(bob.happy_tree())
def tracer(camera, pixels):
    if made:
        time.sleep(60)
    return bob.SceneTracer(scene, camera, (30, 40))(pixels)
made = []
made.append(bob.View(tracer=tracer, size=(30, 40)))
def work():
    try:
        made[0].frame()
    except bob.InputError as error:
        return str(error).startswith("View: expected one that was idle when this process was forked")
print(while_at_work(made[0].frame, work))
"""

READING = """
from bobrossnet.adapters import files
def reads():
    with files._quiet():
        time.sleep(60)
def work():
    with files._quiet():
        return True
print(while_at_work(reads, work))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize("script", [BUILDING, VIEWING, READING], ids=["building", "viewing", "reading"])
def test_a_forked_process_goes_on(script: str) -> None:
    """It has a separate pool, and waits for no thread that it lacks."""
    ended = run(FORKED + script)
    assert (ended.stdout.strip(), ended.returncode) == ("0", 0), ended.stderr


ENDING = """
import atexit, sys, threading, time
import numpy as np
import bobrossnet as bob

def at_exit():
    bob.trace(bob.happy_tree(), size=(30, 40))
    print("traced at exit", flush=True)

atexit.register(at_exit)
BOX = ((-2, -2, -2), (2, 2, 2))
view = bob.View(bob.happy_tree(), size=(120, 160))

def traces(begun):
    begun.set()
    while True:
        try:
            {work}
        except Exception:
            pass

for _ in range(3):
    begun = threading.Event()
    threading.Thread(target=traces, args=[begun], daemon=True).start()
    begun.wait()
time.sleep(0.3)
"""
WORKS = {
    "tracing": "bob.trace(bob.happy_tree(), size=(480, 640))",
    "building": "bob.implicit(lambda x, y, z: np.sin(50 * x) + np.sin(50 * y) + np.sin(50 * z), BOX).core",
    "viewing": "view.frame(bob.Camera(azimuth=time.perf_counter() % 99), fraction=0.02)",
}


@pytest.mark.parametrize("work", WORKS)
def test_a_program_ends_while_daemon_threads_work(work: str) -> None:
    ended = run(ENDING.format(work=WORKS[work]))
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "traced at exit\n", "")


def test_a_sub_interpreter_is_refused() -> None:
    name = "_interpreters" if sys.version_info >= (3, 13) else "_xxsubinterpreters"
    try:
        import_module(name)
    except ImportError:
        pytest.skip("needs sub-interpreters")
    script = f"import {name} as interpreters; interpreters.run_string(interpreters.create(), {REFUSED!r})"
    ended = run(script)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert (
        ended.stdout == "bobrossnet: expected the main interpreter, got a sub-interpreter; use threads or processes\n"
    )


REFUSED = f"""
import sys
sys.path[:] = {sys.path!r}
try:
    import bobrossnet
except ImportError as error:
    print(error, flush=True)
"""


def run(script: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
