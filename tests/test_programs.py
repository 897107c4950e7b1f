"""The command line for programs: JSON, standard input and output, silence."""

import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import bobrossnet as bob
from bobrossnet.adapters import apart


@pytest.fixture
def part(tmp_path):
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    bob.Mesh(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]).save(tmp_path / "part.stl")
    return tmp_path / "part.stl"


def run(*arguments, content=None, cwd=None):
    command = [sys.executable, "-m", "bobrossnet", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, input=content, timeout=60, cwd=cwd, check=False)


def test_render_tells_one_object(part, tmp_path):
    done = run("render", part, "--size", "48x36", "--json", "-o", tmp_path / "part.png", "--fraction", "25%")
    told = json.loads(done.stdout)
    assert told["size"] == [48, 36]
    assert told["scene"] == {"shapes": 1, "triangles": 4}
    assert told["rays"] == told["fraction"] * 48 * 36 == 432
    assert set(told["milliseconds"]) == {"load", "trace", "complete"}
    assert all(value > 0 for value in told["milliseconds"].values())
    assert told["warnings"] == []
    assert done.stderr == b""


def test_warnings_are_in_the_object_and_on_stderr(tmp_path):
    (tmp_path / "a.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\nnan 0 0\n3 0 1 2\n3 0 1 3\n"
    )
    done = run("info", tmp_path / "a.ply", "--json")
    told = json.loads(done.stdout)
    assert len(told["warnings"]) == 1
    assert "left out 1 of 2 triangles" in told["warnings"][0]
    assert b"left out 1 of 2 triangles" in done.stderr
    assert told["instances"][0]["triangles"] == 1


def test_info_tells_bounds_and_materials(part):
    told = json.loads(run("info", part, "--json").stdout)
    (instance,) = told["instances"]
    assert (told["kind"], instance["kind"]) == ("scene", "mesh")
    assert np.allclose(instance["bounds"], [(0, 0, 0), (1, 1, 1)])
    assert instance["material"]["color"] == [1, 1, 1]
    assert told["center"] == [0.5, 0.5, 0.5]
    weights = json.loads(run("info", "default", "--json").stdout)
    assert weights["kind"] == "weights"
    assert weights["parameters"] == sum(np.prod(shape, dtype=int) for shape in weights["tensors"].values())


def test_thumbs_tell_each_file(part):
    part.with_name("broken.stl").write_text("solid")
    done = run("thumbs", part.parent, "-o", part.parent / "out", "--size", "16x16", "--json")
    told = json.loads(done.stdout)
    assert done.returncode == 1
    assert (told["drawn"], told["kept"], told["failed"]) == (1, 0, 1)
    broken, drawn = told["files"]
    assert broken["error"].startswith("broken.stl: ")
    assert broken["picture"] is None
    assert drawn["error"] is None
    assert drawn["picture"].endswith("part.stl.png")


def test_standard_input_and_output(part, tmp_path):
    run("render", part, "--size", "48x36", "-o", tmp_path / "part.png")
    done = run("render", "-", "--format", "STL", "--size", "48x36", "-o", "-", content=part.read_bytes())
    with Image.open(io.BytesIO(done.stdout)) as streamed, Image.open(tmp_path / "part.png") as written:
        assert np.array_equal(np.asarray(streamed), np.asarray(written))
    assert b"wrote      standard output" in done.stderr


def test_json_goes_to_stderr_where_the_picture_is_the_output(part):
    done = run("render", part, "--size", "16x16", "--json", "-o", "-")
    assert done.stdout.startswith(b"\x89PNG")
    assert json.loads(done.stderr)["picture"] == "-"


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ([], "--format: expected the format of standard input, one of .ply "),
        (["--format", "doc"], "argument --format: expected one of .ply, "),
        (["--format", ""], "argument --format: expected one of .ply, "),
    ],
)
def test_standard_input_needs_its_format(given, message):
    done = run("render", "-", *given, content=b"solid")
    assert done.returncode == 2
    assert done.stderr.startswith(f"bobrossnet: error: {message}".encode())
    assert done.stderr.count(b"\n") == 1


def test_silence(part, tmp_path):
    done = run("render", part, "--size", "16x16", "--quiet", "-o", tmp_path / "part.png")
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
    assert (tmp_path / "part.png").exists()


def test_json_or_silence(part):
    assert run("info", part, "--json", "--quiet").returncode == 2


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("bobrossnet thu", {"thumbs"}),
        ("bobrossnet render --gro", {"--ground"}),
        ("bobrossnet dataset views --format ", {"npz", "exr", "webdataset"}),
    ],
)
def test_shells_complete_words(line, words, tmp_path):
    pytest.importorskip("argcomplete")
    answer = tmp_path / "answer"
    asked = {"_ARGCOMPLETE": "1", "COMP_LINE": line, "COMP_POINT": str(len(line))}
    asked |= {"_ARGCOMPLETE_STDOUT_FILENAME": str(answer), "_ARGCOMPLETE_IFS": "\n"}
    done = subprocess.run([sys.executable, "-m", "bobrossnet"], env={**os.environ, **asked}, timeout=60, check=False)
    assert done.returncode == 0
    assert {word.strip() for word in answer.read_text().split("\n")} == words


ROOT = Path(__file__).parent.parent


def test_the_image_is_of_the_package_and_without_root():
    lines = (ROOT / "Dockerfile").read_text().splitlines()
    (extras,) = re.findall(r"/source\[([\w,]+)\]", "\n".join(lines))
    known = re.findall(r"^(\w+) = \[", (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    assert {"cad", "mcp"} == {*extras.split(",")} <= {*known}
    assert "USER bobrossnet" in lines
    assert lines.index("USER bobrossnet") > max(i for i, line in enumerate(lines) if line.startswith("RUN"))


def test_a_missing_library_of_the_system_is_named(monkeypatch):
    def missing(name):
        raise ImportError("libGL.so.1: cannot open shared object file")

    monkeypatch.setattr(apart.importlib, "import_module", missing)
    with pytest.raises(bob.InputError, match=r"got libGL\.so\.1: cannot .*; Debian has it in the package libgl1"):
        apart._imported("bobrossnet.adapters.occ")
