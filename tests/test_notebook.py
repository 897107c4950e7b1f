"""`bob.view` in notebooks: the widget's two halves, and both in a real JupyterLab if installed."""

import base64
import json
import os
import re
import shutil
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager, suppress
from io import BytesIO

import numpy as np
import pytest
from browser import picture_at
from PIL import Image

import bobrossnet as bob
from bobrossnet.page.look import css
from bobrossnet.picture.files import color_to_8_bit, to_8_bit

widget = pytest.importorskip("bobrossnet.page.widget", reason="anywidget is not installed")

SIZE = HEIGHT, WIDTH = 150, 200

CELLS = [
    "import bobrossnet as bob\n"
    "ball = bob.implicit(lambda x, y, z: x**4 + y**4 + z**4 - 1)\n"
    "view = bob.view(ball, bob.Camera(azimuth=10), size=(150, 200))\n"
    "view",
    "print('camera', view.camera)",
    "view.camera = bob.Camera(azimuth=70, elevation=5, fov=40, pan=(0.1, 0))",
    "view.snapshot().save('seen.png')",
]


def ball():
    return bob.implicit(lambda x, y, z: x**4 + y**4 + z**4 - 1)


# ---- Python's half ---------------------------------------------------------------------------------------


def test_a_snapshot_is_what_is_seen():
    view = bob.view(ball(), bob.Camera(azimuth=10), size="200x150", background="#fff")
    seen = view.snapshot()
    wanted = bob.render(ball(), bob.Camera(azimuth=10), size=SIZE, background="#fff")
    np.testing.assert_array_equal(seen.rgba, wanted.rgba)
    view.camera = bob.Camera(azimuth=50, zoom=2)
    wanted = bob.render(ball(), bob.Camera(azimuth=50, zoom=2), size=(30, 40), samples=1)
    np.testing.assert_array_equal(view.snapshot(size=(30, 40), samples=1, background=None).rgba, wanted.rgba)


def test_cameras_are_those_of_the_page():
    camera = bob.Camera(azimuth=10, elevation=-5, roll=3, zoom=1.5, fov=40, pan=(0.1, -0.2))
    view = bob.view(ball(), camera)
    sent = view.get_state("camera")["camera"]
    assert sent == {"azimuth": 10, "elevation": -5, "roll": 3, "zoom": 1.5, "fov": 40, "panX": 0.1, "panY": -0.2}
    told = []
    view.observe(lambda change: told.append(change.new), "camera")
    view.set_state({"camera": {**sent, "azimuth": 11}})
    assert told == [bob.Camera(azimuth=11, elevation=-5, roll=3, zoom=1.5, fov=40, pan=(0.1, -0.2))]
    with pytest.raises(bob.InputError, match="camera: expected an orbiting camera"):
        view.camera = bob.Camera(position=(3, 0, 0), fov=40)


def test_backgrounds_are_those_of_pages():
    assert css(None) == "transparent"
    assert css("#fff") == "linear-gradient(rgb(255, 255, 255), rgb(255, 255, 255))"
    assert css(("#102030", (0, 0, 1))) == "linear-gradient(rgb(16, 32, 48), rgb(0, 0, 255))"


def test_what_shows_no_widgets_shows_a_picture():
    data, _ = bob.view(ball(), size=SIZE)._repr_mimebundle_()
    assert "application/vnd.jupyter.widget-view+json" in data
    assert Image.open(BytesIO(data["image/png"])).size == (WIDTH, HEIGHT)
    assert len(data["text/plain"]) < 300


def test_without_anywidget_it_says_what_is_missing(monkeypatch):
    monkeypatch.delitem(sys.modules, "bobrossnet.page.widget")
    monkeypatch.setitem(sys.modules, "anywidget", None)
    with pytest.raises(bob.InputError, match=r"^view: this needs anywidget: pip install 'bobrossnet\[notebook\]'$"):
        bob.view(ball())


# ---- The page's half -------------------------------------------------------------------------------------

MODEL = """async ({ script, state, scene }) => {
  const { default: { render } } = await import(URL.createObjectURL(new Blob([script], { type: "text/javascript" })));
  const listeners = new Map(), values = { ...state, scene: Uint8Array.fromBase64(scene) };
  window.sent = [];
  window.model = {
    get: (name) => values[name], on: (event, listener) => listeners.set(event, listener),
    set: (name, value) => { values[name] = value; listeners.get(`change:${name}`)?.(); },
    off: (event) => listeners.delete(event),
    save_changes: () => sent.push(structuredClone(values.camera)), listeners,
    change: (name, value) => { values[name] = value; listeners.get(`change:${name}`)(); },
  };
  window.end = render({ model, el: document.body });
}"""


def given(view):
    """Return what MODEL needs of a widget's state."""
    state = view.get_state()
    settings = {name: state[name] for name in ("size", "camera", "background")}
    return {"script": state["_esm"], "state": settings, "scene": base64.b64encode(state["scene"]).decode()}


def exact(page, i=0):
    """Return the picture of widget i's element, (H, W, 4)."""
    address = page.evaluate(
        """async (i) => {
      const view = document.querySelectorAll("bob-view")[i];
      if (!view.viewing.statistics.pictures) await new Promise((shown) => view.addEventListener("load", shown));
      view.setAttribute("samples", "1"); // as traced
      await view.converged();
      return view.toDataURL();
    }""",
        i,
    )
    return np.asarray(picture_at(address))


def assert_shows(found, camera):
    wanted = bob.trace(ball(), camera, size=found.shape[:2])
    covered = wanted.alpha > 0
    assert (found[..., 3] != to_8_bit(wanted.alpha)).mean() < 0.003
    assert (np.abs(found[..., 0].astype(int) - color_to_8_bit(wanted.gray))[covered] > 1).mean() < 0.003


def test_the_widget_shows_its_state_and_tells_its_camera(browser):
    view = bob.view(ball(), bob.Camera(azimuth=10), size=SIZE)
    page = browser.new_page()
    page.set_content("<!doctype html>")
    page.evaluate(MODEL, given(view))
    assert_shows(exact(page), bob.Camera(azimuth=10))
    page.focus("bob-view")
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    page.wait_for_function("() => sent.length && sent.at(-1).azimuth === 25")
    page.evaluate("(camera) => model.change('camera', camera)", {**view.get_state("camera")["camera"], "azimuth": 80})
    assert_shows(exact(page), bob.Camera(azimuth=80))
    page.evaluate("() => end()")
    assert page.locator("bob-view").count() == 0
    assert page.evaluate("() => model.listeners.size") == 0
    page.close()


def test_a_movement_goes_on_while_its_cameras_are_sent(browser):
    page = browser.new_page(reduced_motion="no-preference")
    page.set_content("<!doctype html>")
    page.evaluate(MODEL, given(bob.view(ball(), bob.Camera(azimuth=10), size=SIZE)))
    exact(page)
    page.focus("bob-view")
    page.keyboard.press("4")
    page.wait_for_function("() => sent.length && sent.at(-1).azimuth === 90", timeout=10_000)
    page.close()


def test_scenes_of_one_page_share_the_element(browser):
    """Notebooks import a module for each widget, also when a cell runs again; each brings the parts for its scene."""
    page = browser.new_page()
    page.set_content("<!doctype html>")
    wrong = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    for shape in (bob.happy_tree(), ball(), ball()):  # the first needs meshes only
        page.evaluate(MODEL, given(bob.view(shape, bob.Camera(azimuth=10), size=SIZE)))
    assert_shows(exact(page, 1), bob.Camera(azimuth=10))
    assert_shows(exact(page, 2), bob.Camera(azimuth=10))
    assert exact(page)[..., 3].any()
    assert page.evaluate("() => Array.from(document.body.children, ({ localName }) => localName)") == ["bob-view"] * 3
    page.close()
    assert wrong == []


def test_elements_of_several_versions_do_not_mix(browser):
    page = browser.new_page()
    told = []
    page.on("console", lambda entry: told.append(entry.text))
    page.set_content("<!doctype html>")
    page.evaluate("""() => {
      customElements.define("bob-view", class extends HTMLElement { static version = "0.0.1"; });
    }""")
    page.evaluate(MODEL, given(bob.view(ball(), bob.Camera(azimuth=10), size=SIZE)))
    name = page.evaluate("() => document.body.lastElementChild.localName")
    assert name == f"bob-view-{bob.__version__}-embedded"
    page.evaluate("() => document.body.lastElementChild.converged()")
    (warning,) = [text for text in told if "bob-view" in text]
    assert warning == (
        f"<bob-view> has version 0.0.1 on this page, and <{name}> has version {bob.__version__}-embedded; "
        "load one version only"
    )
    page.close()


# ---- JupyterLab ------------------------------------------------------------------------------------------


@contextmanager
def jupyter_lab(folder):
    """Serve a folder by JupyterLab; return the address."""
    program = shutil.which("jupyter-lab", path=os.path.dirname(sys.executable))
    if not program:
        pytest.skip("JupyterLab, which takes long to install, is not")
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
    environment |= {"HOME": str(folder), "JUPYTERLAB_SETTINGS_DIR": str(folder / ".settings")}
    options = ["--no-browser", "--port=0", "--allow-root", "--ServerApp.root_dir=.", "--IdentityProvider.token=none"]
    log = folder / "jupyter.log"
    with log.open("w") as told:
        process = subprocess.Popen([program, *options], cwd=folder, env=environment, stderr=told)
    try:
        yield address_of_jupyter(process, log)
    finally:
        process.terminate()
        process.wait(timeout=30)


def address_of_jupyter(process, log):
    """Wait until JupyterLab answers; it tells its address before."""
    while process.poll() is None:
        if found := re.search(r"http://127\.0\.0\.1:\d+/", log.read_text("utf-8")):
            with suppress(OSError), urllib.request.urlopen(f"{found[0]}api", timeout=30):
                return found[0]
        time.sleep(0.1)
    raise AssertionError(f"JupyterLab ended: {log.read_text('utf-8')}")


def have_state_saved(folder):
    """Like the setting "Save Widget State Automatically"."""
    settings = folder / ".settings/@jupyter-widgets/jupyterlab-manager"
    settings.mkdir(parents=True)
    (settings / "plugin.jupyterlab-settings").write_text('{"saveState": true}')


def write_notebook(path, sources):
    cells = [
        {"cell_type": "code", "execution_count": None, "id": str(i), "metadata": {}, "outputs": [], "source": source}
        for i, source in enumerate(sources)
    ]
    metadata = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    path.write_text(json.dumps({"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}))


def test_in_jupyter_lab_it_turns_with_a_kernel_and_without_and_from_the_notebook_alone(browser, tmp_path):
    write_notebook(tmp_path / "scene.ipynb", CELLS)
    have_state_saved(tmp_path)
    with jupyter_lab(tmp_path) as address:
        page = browser.new_page(viewport={"width": 1100, "height": 800})
        page.goto(f"{address}lab/tree/scene.ipynb?token=none")
        page.locator(".jp-Cell").first.click(timeout=60_000)
        page.wait_for_selector("[data-status=idle]", timeout=60_000)

        def run(count):
            for _ in range(count):
                page.keyboard.press("Shift+Enter")

        run(1)
        page.wait_for_selector("bob-view", timeout=60_000)
        assert_shows(exact(page), bob.Camera(azimuth=10))
        page.focus("bob-view")
        page.keyboard.press("ArrowRight")
        page.keyboard.press("ArrowRight")
        page.wait_for_timeout(1000)
        page.locator(".jp-Cell").nth(1).click()
        run(1)
        page.wait_for_selector("text=camera Camera(azimuth=20.0, elevation=20.0)")
        run(2)
        page.wait_for_function("() => document.querySelector('bob-view').camera.azimuth === 70", timeout=30_000)
        moved = bob.Camera(azimuth=70, elevation=5, fov=40, pan=(0.1, 0))
        assert_shows(exact(page), moved)
        page.wait_for_timeout(1000)
        picture = np.asarray(Image.open(tmp_path / "seen.png"))
        np.testing.assert_array_equal(picture, bob.render(ball(), moved, size=SIZE).rgba)
        with urllib.request.urlopen(f"{address}api/sessions?token=none") as answer:
            (session,) = json.load(answer)
        ended = urllib.request.Request(f"{address}api/sessions/{session['id']}?token=none", method="DELETE")
        with urllib.request.urlopen(ended) as answer:
            assert answer.status == 204
        page.wait_for_timeout(1000)
        with urllib.request.urlopen(f"{address}api/kernels?token=none") as answer:
            assert json.load(answer) == []
        page.focus("bob-view")
        for _ in range(4):
            page.keyboard.press("ArrowRight")
        page.keyboard.press("Home")
        page.keyboard.press("p")
        assert_shows(exact(page), bob.Camera())
        if picture := os.environ.get("NOTEBOOK_PICTURE"):
            page.screenshot(path=picture)
        page.keyboard.press("ArrowRight")
        page.wait_for_timeout(1000)
        page.locator(".jp-Cell .jp-InputPrompt").nth(1).click()
        page.keyboard.press("Control+s")
        page.wait_for_timeout(2000)
        page.reload()
        page.wait_for_selector("bob-view", timeout=60_000)
        assert_shows(exact(page), bob.Camera(azimuth=35))
        page.close()


AGAIN = [
    "import bobrossnet as bob\nbob.view(bob.happy_tree(), bob.Camera(azimuth=10), size=(150, 200))",
    "ball = bob.implicit(lambda x, y, z: x**4 + y**4 + z**4 - 1)\n"
    "bob.view(ball, bob.Camera(azimuth=10), size=(150, 200))",
]


def test_in_jupyter_lab_several_scenes_are_shown_and_cells_run_again(browser, tmp_path):
    write_notebook(tmp_path / "scenes.ipynb", AGAIN)
    with jupyter_lab(tmp_path) as address:
        page = browser.new_page(viewport={"width": 1100, "height": 800})
        page.goto(f"{address}lab/tree/scenes.ipynb?token=none")
        cell = page.locator(".jp-Cell")
        cell.first.click(timeout=60_000)
        page.wait_for_selector("[data-status=idle]", timeout=60_000)
        for i in (0, 1, 1, 0):
            cell.nth(i).locator(".jp-InputPrompt").click()
            page.evaluate("() => document.querySelectorAll('bob-view').forEach(({ dataset }) => (dataset.isOld = ''))")
            page.keyboard.press("Control+Enter")
            page.wait_for_function(
                "(i) => document.querySelectorAll('.jp-Cell')[i].querySelector('bob-view:not([data-is-old])')",
                arg=i,
                timeout=60_000,
            )
        assert exact(page, 0)[..., 3].any()
        assert_shows(exact(page, 1), bob.Camera(azimuth=10))
        if picture := os.environ.get("NOTEBOOK_PICTURE"):
            page.screenshot(path=picture)
        page.close()
