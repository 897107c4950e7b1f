import gc
import os

# Read when numpy is imported. With more, thousands of tiny linear systems (scipy's Delaunay) are each split over
# threads, which wait for each other when another worker has the cores: 3 s instead of 0.02 s.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from browser import Tabs, chromium, page_server

import bobrossnet as bob

LONGEST = (
    "test_viewer",
    "test_controls",
    "test_component",
    "test_cutaways",
    "test_viewer_files",
    "test_npm",
    "test_tutorials",
    "test_documents",
    "test_elements",
    "test_train",
    "test_dataset",
    "test_failures",
    "test_figures_learned",
    "test_cli",
    "test_complete",
    "test_light_in_page",
    "test_everyday",
    "test_mesh_word",
    "test_light",
    "test_default_network",
    "test_implicit",
    "test_wasm",
    "test_opencascade",
)
"""The files that take the longest, run first, so that no worker starts a long file at the end."""


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: LONGEST.index(item.path.stem) if item.path.stem in LONGEST else len(LONGEST))
    for item in items:
        if "browser" in item.fixturenames:
            item.add_marker(pytest.mark.flaky(reruns=1))  # a busy machine delays its processes; the report counts these


def pytest_configure():
    gc.disable()  # Collecting the tests imports a million objects, of which none is garbage.


def pytest_collection_finish():
    gc.freeze()
    gc.enable()


@pytest.fixture(scope="session")
def tree():
    """The built-in scene."""
    return bob.Scene(bob.happy_tree())


@pytest.fixture
def no_methods_are_left():
    """Remove the methods that a test's custom operations have added to shapes."""
    from bobrossnet.sdf import SDF2, SDF3

    before = {shape: set(vars(shape)) for shape in (SDF2, SDF3)}
    yield
    for shape, names in before.items():
        for name in set(vars(shape)) - names:
            delattr(shape, name)


@pytest.fixture
def every_instruction_set():
    """Return the instruction sets of this machine; afterwards the best one is in use again."""
    from bobrossnet import _core

    best = _core.isa()
    yield [name for name in ("baseline", "avx2", "avx512") if _core.set_isa(name)]
    _core.set_isa(best)


@pytest.fixture(scope="session")
def browser():
    """Start Chromium; tests that need it are skipped if it is missing."""
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="session")
def tabs(browser):
    """Return tabs that tests use one after another."""
    return Tabs(browser)


@pytest.fixture
def new_page(tabs):
    """Return a function that opens a page which runs these scripts first, with settings of its context.

    No page may throw an error. Cameras arrive at once.
    """
    pages, wrong = [], []
    listeners = {"pageerror": lambda error: wrong.append(str(error))}

    def new_page(*scripts, fresh=False, **settings):
        settings = {"reduced_motion": "reduce", **settings}
        pages.append(tabs.open(*scripts, on=listeners, fresh=fresh, **settings))
        return pages[-1]

    yield new_page
    for page in pages:
        tabs.release(page)
    assert wrong == []


@pytest.fixture(autouse=True)
def files_of_the_viewer(request):
    """Remove the files that a test adds to the viewer: its folder ends with it."""
    if "viewer" not in request.fixturenames:
        yield
        return
    files = request.getfixturevalue("viewer").files
    before = dict(files)
    yield
    files.clear()
    files.update(before)


@pytest.fixture(scope="session")
def viewer():
    """Start the viewer's server at `url`; tests may add `files` to serve."""
    from bobrossnet.page.files import page_files

    with page_files() as files, page_server(files) as server:
        yield server
