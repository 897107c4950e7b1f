"""The documentation site: it builds without warnings, and its reference has all public names."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import bobrossnet as bob

ROOT = Path(__file__).parent.parent
SITE = ROOT / "docs/site"


def test_the_reference_is_whole():
    named = re.findall(r"^\.\. auto\w+:: (\w+)$", (SITE / "api.md").read_text(), re.MULTILINE)
    assert sorted(named) == sorted(bob.__all__)


def test_the_site_builds_and_has_the_page(tmp_path):
    pytest.importorskip("sphinx")
    out = tmp_path / "site"
    command = [
        sys.executable,
        "-m",
        "sphinx",
        "-q",
        "-W",
        "--keep-going",
        "-d",
        str(tmp_path / "trees"),
        "-c",
        str(SITE),
    ]
    done = subprocess.run([*command, str(ROOT), str(out)], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")
    assert (out / "page/core.wasm").is_file()
    assert 'url=docs/site/index.html"' in (out / "index.html").read_text()
    listed = re.findall(r"\]\((.+)\)", (out / "llms.txt").read_text())
    assert "docs/how-to/thumbnails.html" in listed
    assert all((out / page).is_file() for page in listed)
    reference = (out / "docs/site/api.html").read_text()
    assert all(f'id="bobrossnet.{name}"' in reference for name in bob.__all__)
    commands = (out / "docs/site/commands.html").read_text()
    assert "bobrossnet thumbs" in commands
    assert "--background COLOR" in commands
    # Every link within the site has a target.
    for page in out.glob("docs/**/*.html"):
        for link in re.findall(r'href="([^"#:]+\.html)[#"]', page.read_text()):
            assert (page.parent / link).resolve().is_file(), f"{page.name}: {link}"
