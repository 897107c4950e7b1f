"""Chromium, for tests of the viewer's page."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser; without one, the test that wants it is skipped, or fails where CI is set."""
    reason, browser = None, None
    try:
        from playwright.sync_api import Error, sync_playwright
    except ModuleNotFoundError:
        missing("playwright, which drives browsers, is not installed")
    program = next(filter(None, map(shutil.which, NAMES)), None)  # else playwright's own
    options = ["--no-sandbox"] if os.geteuid() == 0 else []
    with sync_playwright() as playwright:
        try:
            browser = playwright.chromium.launch(executable_path=program, args=options)
        except Error as error:
            reason = str(error).splitlines()[0]
        if browser is None:
            missing(f"no Chromium: {reason}")
        yield browser
        browser.close()


def missing(reason: str) -> None:
    if os.environ.get("CI"):
        pytest.fail(reason)
    pytest.skip(reason)
