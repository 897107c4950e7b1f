"""Many <bob-view> on one page: they share workers, and nothing is done for invisible ones."""

from contextlib import ExitStack

import numpy as np
import pytest
from browser import picture_at, serving

import bobrossnet as bob
from bobrossnet.page.export import export
from bobrossnet.picture.camera import FRONT
from bobrossnet.support.paths import VIEWER

WIDTH, HEIGHT = 64, 48

PAGE = """<!doctype html>
<script type="module" src="bob/component/bob-view.js"></script>
<style>body { margin: 0 } bob-view { float: left; width: 64px; height: 48px }</style>
"""

WATCH = """
window.alive = new Set(), window.most = 0, window.messages = 0, window.loads = [], window.turns = 0;
window.Worker = class extends Worker {
  constructor(...settings) { super(...settings); alive.add(this); most = Math.max(most, alive.size); }
  postMessage(...message) { super.postMessage(...message); ++messages; }
  terminate() { super.terminate(); alive.delete(this); }
};
document.addEventListener("load", ({ target }) => target.localName === "bob-view" && loads.push(target.id), true);
document.addEventListener("camera-change", () => ++turns, true);
"""

CONVERGED = "() => Promise.all([...document.querySelectorAll('bob-view')].map((view) => view.converged()))"


def wedge(depth=1.0):
    """Return a mesh that looks different from each side."""
    return bob.Mesh([(0, 0, 0), (3, 0, 0), (0, 2, 0), (0, 0, depth)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])


@pytest.fixture(scope="module")
def folder(viewer, tmp_path_factory):
    """Return a folder with the page's files and scenes."""
    folder = tmp_path_factory.mktemp("elements")
    export({path: content for path, content in viewer.files.items() if "." in path}, folder / "bob")
    for i in range(5):
        wedge(1 + i).save(folder / f"{i}.glb")
    (folder / "csg.sdf").write_bytes((VIEWER / "gallery/csg.sdf").read_bytes())
    bob.implicit(lambda x, y, z: x**2 + y**2 + z**2 - 1).mesh(0.006).save(folder / "large.ply")
    return folder


SHARING = {"Cross_Origin_Opener_Policy": "same-origin", "Cross_Origin_Embedder_Policy": "require-corp"}


@pytest.fixture(params=[{}, SHARING], ids=["alone", "shared"])
def headers(request):
    """Return a server's headers, which forbid or allow workers to share memory."""
    return request.param


@pytest.fixture
def shown(new_page, folder):
    """Open a page with these elements."""
    servers = ExitStack()

    def shown(text, headers=None, script=""):
        (folder / "index.html").write_text(PAGE + text)
        settings = {"viewport": {"width": 640, "height": 480}, "reduced_motion": "no-preference"}  # elements turn
        page = new_page(WATCH, script, **settings)
        page.goto(servers.enter_context(serving(folder, **(headers or {}))))
        return page

    with servers:
        yield shown


def elements(count, attributes=""):
    return "".join(f'<bob-view id="v{i}" src="{i % 5}.glb" {attributes}></bob-view>' for i in range(count))


def pixels(page, name):
    address = page.evaluate("(name) => document.getElementById(name).toDataURL()", name)
    return np.asarray(picture_at(address).convert("RGB")).astype(int)


def assert_shows(page, name, scene, camera=None):
    camera = camera or bob.Camera(FRONT)
    wanted = bob.render(scene, camera, size=(HEIGHT, WIDTH), background="#000").rgba[..., :3].astype(int)
    assert wanted.any()
    assert (np.abs(pixels(page, name) - wanted) > 1).mean() < 0.004


def at_rest(page):
    """Wait until no message has been sent to a worker for a while."""
    for _ in range(100):
        before = page.evaluate("() => messages")
        page.wait_for_timeout(300)
        if page.evaluate("() => messages") == before:
            return
    raise AssertionError("the page never rests")


# ---- Shared workers --------------------------------------------------------------------------------------


def test_twenty_elements_share_workers(shown, headers):
    page = shown(elements(20), headers)
    page.evaluate(CONVERGED)
    cores = page.evaluate("() => navigator.hardwareConcurrency")
    assert page.evaluate("() => most") <= cores + 2
    for i in (0, 7, 19):
        assert_shows(page, f"v{i}", wedge(1 + i % 5))
    at_rest(page)
    page.evaluate("async () => { v3.camera = { azimuth: 70 }; await v3.converged(); }")
    assert_shows(page, "v3", wedge(4), bob.Camera(azimuth=70))
    assert page.evaluate("() => most") <= cores + 2


def test_formulas_and_meshes_share_workers(shown):
    page = shown(elements(3) + '<bob-view id="formula" src="csg.sdf"></bob-view>')
    page.evaluate(CONVERGED)
    assert page.evaluate("() => most") <= page.evaluate("() => navigator.hardwareConcurrency") + 2
    assert_shows(page, "v1", wedge(2))
    assert_shows(page, "formula", bob.load(VIEWER / "gallery/csg.sdf"))


def test_an_element_says_so_where_its_workers_end_while_they_open_a_scene(shown, headers):
    """They also have the scene before."""
    page = shown(elements(1), headers)
    page.evaluate(CONVERGED)
    page.evaluate("""async () => {
      window.errors = [];
      v0.addEventListener("error", ({ detail }) => errors.push(detail.message));
      v0.src = "1.glb";
      while (!v0.viewing.isOpening) await undefined;
      for (const worker of alive) {
        worker.terminate();
        worker.dispatchEvent(new ErrorEvent("error", { message: "it ended" }));
      }
    }""")
    page.wait_for_selector("#v0:not([aria-busy])")
    assert page.evaluate("() => errors") == ["it ended"]
    page.evaluate("async () => { v0.src = '2.glb'; await v0.converged(); }")
    assert_shows(page, "v0", wedge(3))


def test_the_element_that_is_moved_comes_first(shown):
    page = shown(elements(40, "camera-controls"))
    page.wait_for_function("() => loads.includes('v0')")
    page.focus("#v39")
    page.evaluate("() => v39.addEventListener('keydown', () => { window.before = loads.length; }, true)")
    page.keyboard.press("ArrowLeft")
    page.wait_for_function("() => loads.includes('v39')")
    assert page.evaluate("() => loads.indexOf('v39') - before") < 20
    page.evaluate(CONVERGED)
    assert_shows(page, "v39", wedge(5), bob.Camera(azimuth=25))


def test_elements_that_turn_share_workers(shown):
    """Picture by picture."""
    page = shown(elements(3, "auto-rotate"))
    page.evaluate("""async () => {
      const pictures = (view) => view.viewing.statistics.pictures, views = [v0, v1, v2];
      while (turns === 0) await new Promise(requestAnimationFrame);
      const before = views.map(pictures);
      while (views.some((view, i) => pictures(view) < before[i] + 5)) await new Promise(requestAnimationFrame);
    }""")


def test_memory_of_a_large_scene_is_given_back(shown):
    page = shown(elements(1) + '<bob-view id="large" src="large.ply"></bob-view>')
    page.evaluate(CONVERGED)
    page.evaluate("() => { window.before = [...alive]; large.remove(); }")
    page.wait_for_function("() => before.every((worker) => !alive.has(worker))")
    page.evaluate("async () => { v0.camera = { azimuth: 50 }; await v0.converged(); }")
    assert_shows(page, "v0", wedge(), bob.Camera(azimuth=50))


def test_converged_of_a_removed_element_is_rejected(shown):
    page = shown(elements(1))
    reason = page.evaluate("""() => {
      v0.camera = { azimuth: 77 };
      const end = v0.converged();
      v0.remove();
      return end.catch(({ message }) => message);
    }""")
    assert reason == "converged: expected an element in a document, got one that was removed"
    again = page.evaluate("""() => document.createElement("bob-view").converged().catch(({ message }) => message)""")
    assert again == reason


# ---- Out of sight ----------------------------------------------------------------------------------------


def test_elements_out_of_sight_wait_until_they_are_seen(shown):
    page = shown('<div style="height: 2000px"></div>' + elements(2))
    page.wait_for_timeout(500)
    assert page.evaluate("() => most") == 0
    page.evaluate("() => scrollTo(0, document.body.scrollHeight)")
    page.evaluate(CONVERGED)
    assert_shows(page, "v1", wedge(2))
    # Out of sight again, their workers end, and their pictures stay.
    page.evaluate("() => scrollTo(0, 0)")
    page.wait_for_function("() => alive.size === 0")
    assert_shows(page, "v1", wedge(2))
    page.evaluate("() => { v1.camera = { azimuth: 80 }; scrollTo(0, document.body.scrollHeight); }")
    page.evaluate(CONVERGED)
    assert_shows(page, "v1", wedge(2), bob.Camera(azimuth=80))


def test_a_click_picks_in_a_scene_that_was_freed(shown):
    page = shown(elements(2, 'camera-orbit="120deg 70deg 100%"') + '<div style="clear: left; height: 4000px"></div>')
    page.evaluate(CONVERGED)
    pick = "() => v1.pick(64 + 32, 24)"
    found = page.evaluate(pick)
    assert len(found["point"]) == 3
    page.evaluate("() => scrollTo(0, 2000)")
    page.wait_for_function("() => alive.size === 0")
    assert page.evaluate("() => v1.viewing.ask('about')") is None  # unseen
    page.evaluate("() => scrollTo(0, 0)")
    page.wait_for_function("() => v1.viewing.isSeen")
    assert page.evaluate(pick) == found
    page.evaluate(CONVERGED)
    assert_shows(page, "v1", wedge(2), bob.Camera())


def test_each_element_keeps_its_exposure(shown):
    page = shown('<bob-view id="v0" src="0.glb" exposure="0.5"></bob-view><bob-view id="v1" src="1.glb"></bob-view>')
    page.evaluate(CONVERGED)
    assert_shows(page, "v1", wedge(2))
    dark = pixels(page, "v0")
    page.evaluate("async () => { v0.exposure = 1; await v0.converged(); }")
    assert_shows(page, "v0", wedge())
    assert 0 < dark.max() < pixels(page, "v0").max()


def test_an_eager_element_does_not_wait(shown):
    page = shown('<div style="height: 2000px"></div>' + elements(1, 'loading="eager"'))
    page.evaluate(CONVERGED)
    assert_shows(page, "v0", wedge())
    page.wait_for_function("() => alive.size === 0")


HIDDEN = {
    "scrolled": "() => scrollTo(0, 2000)",
    "not displayed": "() => (v0.style.display = 'none')",
    "transparent": "() => (v0.parentElement.style.opacity = 0)",
    "invisible": "() => (v0.style.visibility = 'hidden')",
    "another tab": """() => {
      Object.defineProperty(document, "visibilityState", { value: "hidden", configurable: true });
      document.dispatchEvent(new Event("visibilitychange"));
    }""",
}


@pytest.mark.parametrize("way", HIDDEN)
def test_nothing_turns_that_nobody_sees(shown, way):
    page = shown(f'<div>{elements(1, "auto-rotate")}</div><div style="clear: left; height: 4000px"></div>')
    page.wait_for_function("() => turns > 0")
    page.evaluate(HIDDEN[way])
    page.wait_for_function("() => alive.size === 0")
    before = page.evaluate("() => [turns, messages]")
    page.wait_for_timeout(500)
    assert page.evaluate("() => [turns, messages]") == before
    page.evaluate("""() => {
      scrollTo(0, 0);
      v0.style.display = v0.style.visibility = v0.parentElement.style.opacity = "";
      delete document.visibilityState;
      document.dispatchEvent(new Event("visibilitychange"));
    }""")
    page.wait_for_function("(before) => turns > before", arg=before[0])


def test_nothing_is_done_at_rest(shown):
    page = shown(elements(5, "camera-controls"))
    page.evaluate(CONVERGED)
    at_rest(page)
    before = page.evaluate("() => messages")
    page.wait_for_timeout(1000)
    assert page.evaluate("() => messages") == before
