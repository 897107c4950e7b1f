"""The installed package on this machine: commands and calls that must work everywhere.

    python installed.py

It creates its files in a temporary folder. release/smoke.py prints digests of pictures, for comparing machines.
"""

import contextlib
import io
import os
import sys
import tempfile
import threading
import urllib.request
from importlib.resources import files
from pathlib import Path

import numpy as np
from PIL import Image

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.command_line.cli import main
from bobrossnet.page.files import page_files

BROWSER = sys.platform == "emscripten"
TRIANGLE = b"mtllib part.mtl\nv 0 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl wood\nf 1/1 2/2 3/3\n"
COMMANDS = """render --size 32x24 -o tree.png
render part.obj --size 32x24 -o part.png
pack größe–∞.bob part.obj
info größe–∞.bob
mesh part.obj -o part.stl
thumbs . -o pictures --size 16x16
view part.obj --export page.html"""


def make_files() -> None:
    """Write a mesh with a material library and a texture."""
    Image.fromarray(np.full((4, 4, 3), 200, np.uint8)).save("wood.png")
    Path("part.mtl").write_bytes(b"newmtl wood\nmap_Kd wood.png\n")
    Path("part.obj").write_bytes(TRIANGLE)


def run_commands() -> None:
    printed = io.StringIO()
    for line in COMMANDS.splitlines():
        with contextlib.redirect_stdout(printed):
            status = main(line.split())
        assert status == 0, line
    assert "größe–∞.bob" in printed.getvalue()
    assert "texture" in printed.getvalue()
    for made in ("tree.png", "pictures/part.obj.png", "pictures/part.stl.png", "page.html"):
        assert Path(made).stat().st_size > 0, made


def serve() -> None:
    """Serve the page at a free port."""
    from bobrossnet.page.server import Server

    with page_files(bob.load("part.obj")) as page, Server(page) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        for path in ("", "core.wasm", "files/scene.bob"):
            with urllib.request.urlopen(server.url + path, timeout=20) as answer:
                assert answer.status == 200, path
        server.shutdown()


def run() -> None:
    make_files()
    if not BROWSER:
        run_commands()
        serve()
    scene = bob.load(["part.obj", bob.happy_tree()])
    assert bob.render(scene, size="32x24").size
    *_, last = bob.progressive(scene, size=(24, 32), frame_ms=20)
    assert last.fraction == 1
    bob.save_scene(scene, "scene.bob")
    assert len(bob.load("scene.bob").instances) == 2
    assert (files("bobrossnet") / "weights" / "default.safetensors").is_file()
    print(f"bobrossnet {bob.__version__}, Python {sys.version.split()[0]}, {sys.platform}, {_core.isa()}")


if __name__ == "__main__":
    here = os.getcwd()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        os.chdir(folder)
        try:
            run()
        finally:
            os.chdir(here)
