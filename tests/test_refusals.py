"""Wrong arguments are refused before any file is read, and before slow libraries are imported."""

import json
import shlex
import shutil
import socket
import subprocess
import sys

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.adapters import files
from bobrossnet.command_line.cli import main
from bobrossnet.pictures import thumbnails, view_files

LOOK = [
    "--samples 3",
    "--samples x",
    "--background nonsense",
    "--light nonsense",
    "--light missing.hdr",
    "--size 0x0",
]
LINES = ["--line-width 1000", "--line-color nonsense"]
SECTIONS = ["--section q=1", 7 * "--section x=1 "]
COMMANDS = {
    "render a.ply": [
        *LOOK,
        *LINES,
        *SECTIONS,
        "missing.ply",
        "a.zzz",
        "sample:nonsense",
        "--format zzz",
        "--model nonsense",
        "--order nonsense",
        "--seed -1",
        "--fov 200",
        "-o a.zzz",
        "-o missing/a.png",
        "-o ''",
        "-o a.webp --size 16384x16",
        "--style lines -o a.svg --background #fff,#000",
    ],
    "sheet a.ply": [
        *SECTIONS,
        "--views nonsense",
        "--views front,front,front,front,front,front,front",
        "--size 100x100",
        "--unit furlong",
        "-o a.zzz",
        "-o ''",
        "-o a.jpg --size 70000x300",
        "missing.ply",
    ],
    "measure a.ply": ["missing.ply", "--unit furlong"],
    "orbit a.ply": [
        *LOOK,
        *LINES,
        *SECTIONS,
        "--frames 0",
        "--fps 0",
        "--fps 1000",
        "--elevation 91",
        "--model nonsense",
        "--scheduler nonsense",
        "-o a.zzz",
        "-o ''",
        "--size 16x16384",
        "--size 32769x16 -o a.avif",
        "--size 65536x16 -o a.gif",
        "missing.ply",
    ],
    "thumbs . -o out": [*LOOK, "--workers 0", "--elevation 91", "--sheet a.zzz", "--sheet ''"],
    "thumbs .": ["-o a.ply", "-o ''"],
    "dataset views . -o out": [*LOOK, "--views 0", "--format zzz"],
    "view a.ply --no-browser": [
        "--port 70000",
        "--port BUSY",
        "--light nonsense",
        "--background nonsense",
        "--export missing/a.html",
        "--export a.ply",
        "--export ''",
        "missing.ply",
    ],
    "mesh a.ply": ["--step 0", "-o a.zzz", "-o ''", "missing.ply"],
    "pack a.bob a.ply": ["--light nonsense", "missing.ply"],
    "pack '' a.ply": ["--up z"],
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a shape whose reading fails the test."""

    def read(*_, **__):
        pytest.fail("a file was read")

    bob.Mesh(np.eye(3), [(0, 1, 2)]).save(tmp_path / "a.ply")
    shutil.copy(tmp_path / "a.ply", tmp_path / "a.zzz")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(files, "_loaded", read)
    monkeypatch.setattr(thumbnails, "_made", read)
    monkeypatch.setattr(view_files, "_write", read)
    return tmp_path


@pytest.mark.parametrize(
    ("command", "wrong"), [(command, wrong) for command, several in COMMANDS.items() for wrong in several]
)
def test_wrong_arguments_are_refused_before_files_are_read(command, wrong, folder, capsys):
    with socket.create_server(("127.0.0.1", 0)) as busy:
        words = shlex.split(f"{command} {wrong}".replace("BUSY", str(busy.getsockname()[1])))
        assert main(words) == 2
    assert capsys.readouterr().err.startswith("bobrossnet: error: ")
    assert sorted(file.name for file in folder.iterdir()) == ["a.ply", "a.zzz"]


WITHOUT_SLOW_LIBRARIES = """
import contextlib, io, json, shlex, sys
sys.modules.update(dict.fromkeys(("torch", "zarr", "scipy", "mcp", "distributed")))
from bobrossnet.command_line.cli import main
for words in sys.argv[1:]:
    with contextlib.redirect_stderr(io.StringIO()) as told:
        status = main(shlex.split(words))
    print(json.dumps([status, told.getvalue()]))
"""
REFUSED = [
    "train missing run",
    "dataset build out --scheduler nonsense",
    "dataset build ''",
    "dataset build out --files missing",
    "dataset compare missing . --markdown ''",
    "thumbs . -o out --scheduler nonsense",
    "dataset compare missing .",
    "evaluate . --size 5x5",
    "evaluate . --models nonsense",
    "evaluate . --csv missing/scores.csv",
    "evaluate . --csv ''",
    "evaluate . --orders nonsense",
    "evaluate missing",
    "evaluate --quick --stability",
    "calibrate a.zzz",
    "calibrate a.safetensors --shapes 1",
    "calibrate a.safetensors --model nonsense",
    "figures out --data missing",
    "figures out --scores missing",
    "figures out --weights nonsense",
    "figures out --frames 0",
    "figures out --only q",
    "figures out --only ''",
    "figures ''",
    "figures a.ply",
    "mcp missing",
    "mcp ''",
]


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """Return the status and the error of each command, from one process without slow libraries."""
    folder = tmp_path_factory.mktemp("folder")
    bob.Mesh(np.eye(3), [(0, 1, 2)]).save(folder / "a.ply")
    shutil.copy(folder / "a.ply", folder / "a.zzz")
    command = [sys.executable, "-c", WITHOUT_SLOW_LIBRARIES, *REFUSED]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    assert sorted(file.name for file in folder.iterdir()) == ["a.ply", "a.zzz"]
    return dict(zip(REFUSED, map(json.loads, done.stdout.splitlines()), strict=True))


@pytest.mark.parametrize("words", REFUSED)
def test_wrong_arguments_are_refused_before_slow_imports(words, told):
    status, error = told[words]
    assert status == 2
    assert error.startswith("bobrossnet: error: ")
    assert error.count("\n") == 1
    assert "pip install" not in error
