"""The npm package: packed, installed in an empty folder, and run from there."""

import gzip
import shutil
import subprocess

import numpy as np
import pytest
from browser import missing, serving

import bobrossnet as bob
from bobrossnet.page.package import write_package
from bobrossnet.picture.files import to_8_bit

MOST_BYTES = 320_000
"""Maximum compressed bytes that a browser fetches before a mesh is exact."""

HEIGHT, WIDTH = 96, 128

PAGE = """<!doctype html>
<script type="module" src="node_modules/bob-view/component/bob-view.js"></script>
<bob-view src="{file}" picture-size="128x96" camera-controls></bob-view>
"""

EXACT = """async () => {
  await customElements.whenDefined("bob-view");
  const view = document.querySelector("bob-view");
  if (!view.viewing.statistics.pictures) await new Promise((shown) => view.addEventListener("load", shown));
  view.viewing.schedule.budget = 500; // dense pictures need no network, however busy the machine
  for (let azimuth = 31; azimuth < 60; ++azimuth) {
    const next = new Promise((shown) => view.addEventListener("progress", shown, { once: true }));
    view.camera = { azimuth };
    await next;
  }
  view.camera = { azimuth: 30 };
  await view.converged();
  return Array.from((await view.viewing.buffers()).image);
}"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return an empty folder with the package installed."""
    if not shutil.which("npm"):
        missing("npm, which installs packages, is not installed")
    made, empty = tmp_path_factory.mktemp("package"), tmp_path_factory.mktemp("empty")
    write_package(made)

    def npm(*arguments, cwd):
        done = subprocess.run(["npm", *arguments], cwd=cwd, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        return done.stdout.split()

    (packed,) = npm("pack", "--silent", cwd=made)
    assert packed == f"bob-view-{bob.__version__}.tgz"
    npm("install", "--offline", "--no-audit", "--no-fund", str(made / packed), cwd=empty)
    mesh = bob.implicit(lambda x, y, z: x**2 + y**2 + z**2 - 1 + 0.2 * x * y).mesh(0.05)
    for name in ("part.glb", "part.stl", "part.ply"):
        mesh.save(empty / name)
    return empty


@pytest.mark.parametrize("name", ["part.ply", "part.stl", "part.glb"])
def test_a_mesh_is_shown_and_the_package_is_small(browser, folder, name):
    (folder / "index.html").write_text(PAGE.format(file=name))
    with serving(folder) as address:
        page = browser.new_context().new_page()
        asked = set()
        page.on("request", lambda request: asked.add(request.url))
        page.goto(address)
        image = np.reshape(np.array(page.evaluate(EXACT), np.float32), (HEIGHT, WIDTH))
        page.context.close()
    wanted = bob.trace(bob.load(folder / name), size=(HEIGHT, WIDTH)).gray
    assert (np.abs(to_8_bit(image).astype(int) - to_8_bit(wanted)) > 1).mean() < 0.002
    paths = {url.removeprefix(address) for url in asked if url.startswith(f"{address}node_modules")}
    sizes = {path: len(gzip.compress((folder / path).read_bytes())) for path in paths}
    assert sum(sizes.values()) <= MOST_BYTES, sizes
    assert not any("core.relaxed" in path or "core.wasm" in path for path in sizes)
