"""Writes docs/page.png: the viewer's page while a scene is turned, with the traced pixels and the completed picture.

python docs/page_picture.py

Needs the wheel playwright and a Chromium.
"""

from __future__ import annotations

import os
import shutil
import threading
from pathlib import Path

from playwright.sync_api import sync_playwright

from bobrossnet.page.files import page_files
from bobrossnet.page.server import Server

WIDTH, HEIGHT = 1280, 720
SCENE = "happy_tree.bob"
TURNS = 8  # pictures until the throughput of rays has been measured


def main() -> None:
    program = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    options = ["--no-sandbox"] if os.geteuid() == 0 else []
    with page_files() as files, Server(files) as server, sync_playwright() as playwright:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        browser = playwright.chromium.launch(executable_path=program, args=options)
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, color_scheme="light")
        page.goto(f"{server.url}?size=950x720#scene={SCENE}")
        page.evaluate("() => bobrossnet.started")
        page.uncheck("#refines")
        page.check("[value=split]", force=True)
        for turn in range(TURNS):
            page.evaluate("(azimuth) => bobrossnet.look({ azimuth, elevation: 20 })", 30 + turn)
            page.wait_for_timeout(300)
        page.screenshot(path=Path(__file__).parent / "page.png")
        browser.close()
        server.shutdown()


if __name__ == "__main__":
    main()
