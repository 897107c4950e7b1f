"""Milliseconds to complete a picture in a page: the core in one worker without threads, other runtimes, and the GPU.

The same weights and input in the same page and run, one contender after the other; every result is compared with the
core's in Python. Needs the wheel playwright, Debian's chromium, and npm, which fetches the other runtimes to
build/web at the first run. Chromium may need options to use a GPU: `--option=--enable-unsafe-webgpu
--option=--enable-features=Vulkan` on Linux.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import subprocess
import tempfile
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import sync_playwright

import bobrossnet as bob
from bobrossnet.completion.network import load_network
from bobrossnet.completion.weights import WEIGHTS
from bobrossnet.learn.checkpoint import save
from bobrossnet.learn.networks import Pyramid
from bobrossnet.support.paths import VIEWER

HERE = Path(__file__).parent
PACKAGES = HERE.parents[1] / "build" / "web"


LEAN = Pyramid(features="8,8,16,24,24,24", handed_on="4,6,6,6,6")
"""A pyramid with half the default network's arithmetic. Its weights are random, which does not affect its time."""


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_: object) -> None:
        pass


def fetch_packages() -> None:
    PACKAGES.mkdir(parents=True, exist_ok=True)
    shutil.copy(HERE / "package.json", PACKAGES)
    subprocess.run(["npm", "install", "--ignore-scripts", "--no-audit", "--no-fund"], cwd=PACKAGES, check=True)


def known_kept(part: bob.GBuffer, image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Restore the traced pixels, as a page does; the GPU's pictures lack them."""
    return np.where(part.mask.ravel() > 0, part.gray.ravel(), image.clip(0, 1))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--runs", type=int, default=11)
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    parser.add_argument("--option", action="append", default=[], help="of Chromium's command line")
    arguments = parser.parse_args()
    width, height = map(int, arguments.size.split("x"))
    if not (PACKAGES / "node_modules").is_dir():
        fetch_packages()
    part = bob.trace(bob.happy_tree(), size=(height, width), fraction=0.05)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        root = Path(folder)
        for name in ("page.html", "worker.js"):
            shutil.copy(HERE / name, root)
        (root / "viewer").symlink_to(VIEWER)
        (root / "packages").symlink_to(PACKAGES / "node_modules")
        part.stack().tofile(root / "input.bin")
        server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=folder))
        threading.Thread(target=server.serve_forever, daemon=True).start()
        options = ["--no-sandbox"] if os.geteuid() == 0 else []
        browser = playwright.chromium.launch(executable_path=arguments.chromium, args=options + arguments.option)
        print(f"{arguments.size}, {arguments.runs} runs each, {browser.version}\n")
        print("| network | contender | median ms | fastest ms | largest difference |\n|---|---|---:|---:|---:|")
        lean = f"pyramid of {LEAN.multiply_adds(height, width):,.0f} multiply-adds"
        for name in ("paper", "default", lean, "small"):
            weights = root / f"{name}.safetensors"
            if name == lean:
                save(weights, LEAN)
            else:
                shutil.copy(WEIGHTS / weights.name, weights)
            bob.export(weights, root / f"{name}.onnx")
            expected = known_kept(part, load_network(weights).predict(part).ravel())
            page = browser.new_page()
            page.goto(f"http://127.0.0.1:{server.server_port}/page.html")
            settings = {"name": name, "height": height, "width": width, "runs": arguments.runs}
            for contender, found in page.evaluate("settings => measure(settings)", settings).items():
                times, image = found["milliseconds"], np.array(found["image"], np.float32)
                difference = float(np.abs(known_kept(part, image) - expected).max())
                middle = statistics.median(times)
                print(f"| {name} | {contender} | {middle:.1f} | {min(times):.1f} | {difference:.1e} |", flush=True)
            page.close()
        browser.close()
        server.shutdown()
    print()
    for file in sorted(VIEWER.glob("*.wasm")) + sorted(WEIGHTS.glob("*.safetensors")):
        print(f"{file.name}: {file.stat().st_size / 1000:.0f} KB")


if __name__ == "__main__":
    main()
