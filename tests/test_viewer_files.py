"""Scenes and files in the viewer's page: the same pictures as Python's, and errors in one line."""

import base64
import json
from pathlib import Path

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.view import VIEWER

SIZE = (72, 96)

READ = """
async ({ file, name, height, width, camera }) => {
  const [{ loadCore }, { readFile }, { buildScene }] = await Promise.all(
    ["/core.js", "/files.js", "/scene.js"].map((module) => import(module)));
  globalThis.core ??= await loadCore("core", false);
  try {
    const bytes = file === null ? new ArrayBuffer(0) : await (await fetch(file)).arrayBuffer();
    const scene = buildScene(core, await readFile(core, name, bytes));
    const gbuffer = core.gbuffer(height, width);
    scene.trace(gbuffer, core.pixelOrder("uniform", { height, width }), camera);
    const planes = Array.from(gbuffer.planes);
    gbuffer.free(), scene.free();
    return { planes };
  } catch (error) {
    return { error: error.message, kind: error.constructor.name, line: error.line };
  }
}
"""


@pytest.fixture(scope="module")
def page(browser, viewer):
    page = browser.new_page()
    page.goto(viewer.url + "gallery/index.json")
    yield page
    page.close()


@pytest.fixture
def read(page, viewer, tmp_path):
    """What the page makes of a file, of its path or its content: (5, H, W), or what is wrong, {error, kind, line}."""

    def read(name, content=b"", camera=bob.Camera()):
        viewer.files["tested"] = Path(name) if content == b"" else content
        place = {"file": "/tested", "name": Path(name).name, "height": SIZE[0], "width": SIZE[1]}
        angles = {angle: getattr(camera, angle) for angle in ("azimuth", "elevation", "roll", "zoom")}
        found = page.evaluate(READ, {**place, "camera": angles})
        return np.array(found["planes"], np.float32).reshape(5, *SIZE) if "planes" in found else found

    return read


def assert_equal_pictures(planes, scene, camera=bob.Camera(), pixels=0):
    """All but a few pixels are within a rounding of Python's, in another instruction set and order of sums."""
    assert isinstance(planes, np.ndarray), planes
    expected = bob.trace(scene, camera, size=SIZE).stack()
    different = (np.abs(planes - expected) > 1e-4).any(axis=0)
    assert np.count_nonzero(different) <= pixels
    assert planes[1].max() > 0.1  # something is seen


# ---- Scenes ----------------------------------------------------------------------------------------------


GALLERY = json.loads((VIEWER / "gallery/index.json").read_bytes())


@pytest.mark.parametrize("entry", GALLERY, ids=lambda entry: entry["title"])
def test_gallery(entry, read, viewer):
    file = viewer.files[f"gallery/{entry['file']}"]
    assert_equal_pictures(read(file), bob.load(file), pixels=3)


def test_gallery_is_what_its_script_writes(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[1] / "docs")
    from page_gallery import FOLDER, write

    write(tmp_path)
    for file in tmp_path.iterdir():
        assert file.read_bytes() == (FOLDER / file.name).read_bytes()
