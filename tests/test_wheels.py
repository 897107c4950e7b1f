"""Wheels: the list of platforms, their names, the tools and the document agree. `make check-wheels` runs the wheels."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from runpy import run_path

import pytest
from packaging.requirements import Requirement
from packaging.utils import parse_wheel_filename

from bobrossnet import _core

tomllib = pytest.importorskip("tomllib", reason="needs Python 3.11 or later")

ROOT = Path(__file__).parent.parent
RELEASE = ROOT / "release"
NAMES = run_path(str(RELEASE / "platforms.py"))
PLATFORMS, STABLE_ABI = NAMES["PLATFORMS"], NAMES["STABLE_ABI"]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())


@pytest.mark.parametrize("platform", PLATFORMS, ids=lambda platform: platform.tag)
def test_tags_name_the_targets_that_zig_compiles_for(platform):
    processor = re.search(r"(x86_64|aarch64|amd64|arm64)$", platform.tag)[1]
    assert platform.target.split("-")[0] == {"amd64": "x86_64", "arm64": "aarch64"}.get(processor, processor)
    oldest = re.match(r"[a-z]+_(\d+)_(\d+)_", platform.tag)
    if oldest and not platform.musl:  # zig has one version of it
        assert platform.target.endswith(f"{oldest[1]}.{oldest[2]}")


def test_wheels_have_the_stable_abi_that_the_project_asks_for():
    assert STABLE_ABI.split("-")[0] == PROJECT["tool"]["scikit-build"]["wheel"]["py-api"]


def test_the_pinned_tools_are_what_the_project_builds_with():
    lines = [line for line in (RELEASE / "requirements.txt").read_text().splitlines() if not line.startswith("#")]
    pinned = {requirement.name: requirement for requirement in map(Requirement, lines)}
    overrides = PROJECT["tool"]["scikit-build"]["overrides"]
    asked = PROJECT["build-system"]["requires"] + [r for o in overrides for r in o.get("build", {}).get("requires", [])]
    for requirement in map(Requirement, asked):
        (version,) = (specifier.version for specifier in pinned[requirement.name].specifier)
        assert requirement.specifier.contains(version), requirement


def test_the_document_has_every_platform():
    rows = re.findall(r"^\| `(\w+)` \|", (ROOT / "docs/platforms.md").read_text(), re.MULTILINE)
    assert rows == [platform.tag for platform in PLATFORMS]


def test_wheels_that_were_built_have_known_names_and_sizes():
    for wheel in (ROOT / "dist").glob("*.whl"):
        name, version, _, tags = parse_wheel_filename(wheel.name)
        assert (name, str(version)) == ("bobrossnet", PROJECT["project"]["version"])
        assert {str(tag) for tag in tags} <= {f"{STABLE_ABI}-{platform.tag}" for platform in PLATFORMS}
        assert wheel.stat().st_size <= 8_000_000


def test_the_smoke_test_answers(tmp_path):
    done = subprocess.run(
        [sys.executable, RELEASE / "smoke.py"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    answer = json.loads(done.stdout.splitlines()[-1])
    assert answer["isa"] == _core.isa()
    bits = answer["pictures"]["baseline"]
    assert len(bits) == len(set(bits.values())) == 9
