"""The release besides the code: metadata, workflows, licences, list of parts, and conda-forge's recipe."""

import re
import subprocess
import sys
from importlib.metadata import distribution
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

import bobrossnet as bob

ROOT = Path(__file__).parent.parent
METADATA = distribution("bobrossnet").metadata


@pytest.mark.skipif(find_spec("check_jsonschema") is None, reason="no check-jsonschema, which the extra `test` brings")
@pytest.mark.parametrize(
    ("schema", "pattern"),
    [
        ("vendor.github-workflows", ".github/workflows/*.yml"),
        ("custom.github-workflows-require-timeout", ".github/workflows/*.yml"),
        ("vendor.citation-file-format", "CITATION.cff"),
    ],
)
def test_files_follow_their_schemas(schema, pattern):
    files = list(ROOT.glob(pattern))
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", schema, *files]
    assert files
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    assert done.returncode == 0, done.stdout


def test_the_version_is_everywhere_the_same():
    """pyproject.toml defines it; others are generated from it, or checked here."""
    (version,) = re.findall(r'^version = "([^"]+)"$', (ROOT / "pyproject.toml").read_text("utf-8"), re.MULTILINE)
    (of_conda,) = re.findall(r'^  version: "(.+)"$', (ROOT / "conda/recipe.yaml").read_text("utf-8"), re.MULTILINE)
    assert {version, of_conda} == {bob.__version__}


def test_authors_are_everywhere_the_same():
    (cited,) = re.findall(r"^  - name: (.+)$", (ROOT / "CITATION.cff").read_text("utf-8"), re.MULTILINE)
    assert cited == METADATA["Author"]


def test_conda_installs_what_pip_installs():
    run = (ROOT / "conda/recipe.yaml").read_text("utf-8").partition("  run:\n")[2].partition("\n\n")[0]
    of_conda = {line.strip(" -").replace(" ", "") for line in run.splitlines()} - {"python"}
    of_pip = {line for line in METADATA.get_all("Requires-Dist") if ";" not in line}
    assert of_conda == of_pip


def test_other_peoples_code_is_listed_as_it_is_installed():
    spec = spec_from_file_location("third_party", ROOT / "vendor/third_party.py")
    third_party = module_from_spec(spec)
    pytest.importorskip("nanobind", reason="no nanobind here, whose licence is compared")
    pytest.importorskip("ziglang", reason="no ziglang here, whose licences are compared")
    spec.loader.exec_module(third_party)
    for path, text in third_party.files().items():
        assert path.read_text("utf-8") == text, f"{path}: run python vendor/third_party.py"


def test_licences_and_parts_are_installed():
    installed = {str(file).partition(".dist-info/")[2] for file in distribution("bobrossnet").files}
    assert {"licenses/LICENSE", "licenses/vendor/NOTICES.txt", "sboms/sbom.cdx.json"} <= installed
    used = set(re.findall(r"[\w.+-]+", METADATA["License-Expression"])) - {"AND", "WITH"}
    notices = (ROOT / "vendor/NOTICES.txt").read_text("utf-8")
    assert {name for line in re.findall(r"^\S.*?: (.+?), in ", notices, re.MULTILINE) for name in line.split()} - {
        "AND",
        "WITH",
    } <= used
