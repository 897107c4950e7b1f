"""Chromium, for tests of the viewer's page."""

from __future__ import annotations

import base64
import os
import shutil
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

TOLD = """
window.told = [];
for (const name of ["load", "progress", "error", "camera-change", "pick"]) {
  document.addEventListener(name, ({ type, detail, target }) => {
    if (target.localName === "bob-view") told.push({ type, detail });
  }, true);
}
"""
"""Records the events of elements in `told`."""

NAMES = ("chromium", "chromium-browser", "google-chrome")


@contextmanager
def chromium() -> Iterator[Any]:
    """Start Chromium; without one, the requesting test is skipped, or fails if CI is set."""
    try:
        from playwright.sync_api import Error, sync_playwright
    except ModuleNotFoundError:
        missing("playwright, which drives browsers, is not installed")
    reason, browser = None, None
    with sync_playwright() as playwright:
        try:
            browser = launch(playwright.chromium)
        except Error as error:
            reason = str(error).splitlines()[0]
        if browser is None:
            missing(f"no Chromium: {reason}")
        yield browser
        browser.close()


def launch(kind: Any, *options: str) -> Any:
    """Launch a browser of one of playwright's kinds, with further command line options."""
    program = next(filter(None, map(shutil.which, NAMES)), None)  # otherwise playwright's
    return kind.launch(executable_path=program, args=[*options, *(["--no-sandbox"] if os.geteuid() == 0 else [])])


@contextmanager
def serving(folder: Path, **headers: str) -> Iterator[str]:
    """Serve only a folder's files; return the address. Responses have these headers, with _ for -."""

    class Quiet(SimpleHTTPRequestHandler):
        def end_headers(self) -> None:
            for name, value in headers.items():
                self.send_header(name.replace("_", "-"), value)
            super().end_headers()

        def log_message(self, *_: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=folder)) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}/"
        finally:
            server.shutdown()
            thread.join()


def picture_at(address: str) -> Image.Image:
    """Return the picture of a data: address."""
    return Image.open(BytesIO(base64.b64decode(address.partition(",")[2])))


def missing(reason: str) -> None:
    if os.environ.get("CI"):
        pytest.fail(reason)
    pytest.skip(reason)
