import os
import threading

# Read when numpy is imported. With more, thousands of tiny systems of equations (scipy's Delaunay) are each shared out
# to threads, which wait for each other where another worker has the cores: 3 s for what takes 0.02 s.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from browser import chromium

import bobrossnet as bob


@pytest.fixture(scope="session")
def tree():
    """The built-in scene."""
    return bob.Scene(bob.happy_tree())


@pytest.fixture
def no_methods_are_left():
    """Takes away the methods that a test has given shapes by operations of its own."""
    from bobrossnet.sdf import SDF2, SDF3

    before = {shape: set(vars(shape)) for shape in (SDF2, SDF3)}
    yield
    for shape, names in before.items():
        for name in set(vars(shape)) - names:
            delattr(shape, name)


@pytest.fixture
def every_instruction_set():
    """The instruction sets of this machine; whichever a test has set, the best is in use again after it."""
    from bobrossnet import _core

    best = _core.isa()
    yield [name for name in ("baseline", "avx2", "avx512") if _core.set_isa(name)]
    _core.set_isa(best)


@pytest.fixture(scope="session")
def browser():
    """Chromium; tests that need it are skipped if there is none."""
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="session")
def viewer():
    """The server of the viewer's page, at its `url`; what a test adds to its `files` is served as well."""
    from bobrossnet.page.files import page_files
    from bobrossnet.page.server import Server

    with page_files() as files, Server(files) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield server
        server.shutdown()
        thread.join()
