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

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

TOLD = """
window.told = [];
for (const name of ["load", "progress", "error", "camera-change", "section-change", "pick"]) {
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


LEAVE = """() => {
  sessionStorage.clear();
  location.replace(URL.createObjectURL(new Blob([""], { type: "text/html" })));
}"""


class Tabs:
    """Tabs of a browser that tests use one after another.

    A new context takes the time of two first pictures: its processes start, and compile the page's code again. An idle
    tab with the same scripts and settings has both. Between tests it shows an empty document of the last page's origin,
    because another origin would take another process.
    """

    IDLE = 4
    """Maximum number of idle tabs: each has a process."""

    def __init__(self, browser: Any) -> None:
        self._browser = browser
        self._idle: list[tuple[Any, Any]] = []  # keys and tabs, the last used one last
        self._opened: dict[Any, tuple[Any, dict[str, Any]]] = {}  # the key and the listeners of a tab

    def open(self, *scripts: str, on: dict[str, Any], fresh: bool = False, **settings: Any) -> Any:
        """Return a tab of a context with these settings, whose pages run the scripts first; listen to its events.

        A fresh tab has a new context, which ends with its page.
        """
        key = None if fresh else (scripts, sorted(settings.items()))
        i = next((i for i, (other, _) in enumerate(self._idle) if other == key), None)
        if i is None:
            tab = self._browser.new_context(**settings).new_page()
            for script in scripts:
                tab.add_init_script(script)
        else:
            _, tab = self._idle.pop(i)
        for event, listener in on.items():
            tab.on(event, listener)
        self._opened[tab] = key, on
        return tab

    def release(self, tab: Any) -> None:
        """End the tab's page, and keep the tab for another test if possible."""
        key, on = self._opened.pop(tab)
        if key is None:
            tab.context.close()
            return
        for event, listener in on.items():
            tab.remove_listener(event, listener)
        try:
            tab.mouse.up()
            tab.evaluate(LEAVE)
            tab.wait_for_url("blob:**")
            self._idle.append((key, tab))
        except Exception:  # it crashed, is closed, or its page has no origin
            tab.context.close()
        while len(self._idle) > self.IDLE:
            self._idle.pop(0)[1].context.close()


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


@contextmanager
def page_server(files: Any) -> Iterator[Any]:
    """Run the viewer's server at `url` with these files; tests may add more."""
    from bobrossnet.page.server import Server

    with Server(files) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


def picture_at(address: str) -> Image.Image:
    """Return the picture of a data: address."""
    return Image.open(BytesIO(base64.b64decode(address.partition(",")[2])))


def numbers(text: str, kind: Any = np.float32) -> NDArray[Any]:
    """Return the numbers of a page's array from its bytes in base64; a list takes 10 µs for each of them."""
    return np.frombuffer(base64.b64decode(text), kind)


def missing(reason: str) -> None:
    if os.environ.get("CI"):
        pytest.fail(reason)
    pytest.skip(reason)
