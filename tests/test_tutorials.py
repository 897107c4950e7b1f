"""Tutorials: their code runs as written, in smaller pictures and data sets."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import bobrossnet as bob
from bobrossnet.command_line.cli import main

TUTORIALS = Path(__file__).parent.parent / "docs/tutorials"


def run(name, smaller):
    """Run a tutorial's blocks in order: Python in one namespace, commands of the package without an error."""
    text = (TUTORIALS / f"{name}.md").read_text()
    names = {}
    for language, block in re.findall(r"(?s)```(python|sh)\n(.*?)```", text):
        for old, new in smaller.items():
            block = block.replace(old, new)
        if language == "python":
            exec(block, names)
            continue
        for line in block.splitlines():
            command, *arguments = shlex.split(line)
            if command == "bobrossnet":
                assert main(arguments) in (None, 0), line
    return names


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_first_picture(folder):
    names = run("first-picture", {"-o gear.png": "--size 160x120 -o gear.png", "(480, 640)": "(120, 160)"})
    assert names["part"].fraction == pytest.approx(0.05, abs=0.001)
    assert names["frame"].error <= 0.002
    assert bob.ssim(names["image"], names["exact"].gray) > 0.75
    assert {file.name for file in folder.iterdir()} == {"gear.png", "completed.png", "good-enough.png"}


def test_print_a_part(folder):
    names = run("print-a-part", {"step=0.25": "step=1", "ground=False": 'ground=False, size="80x60"'})
    width, depth, height = bob.Scene(names["knob"]).extent.size
    assert (round(width, 2), round(depth, 2), round(height, 2)) == (29.37, 29.37, 12)
    inside = names["knob"].mesh(step=1)
    closed = np.sort(inside.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert (np.unique(closed, axis=0, return_counts=True)[1] == 2).all()
    assert (folder / "knob.3mf").stat().st_size < 4000
    assert (folder / "knob.stl").stat().st_size > 10_000


def test_slow_tracer(folder):
    names = run("slow-tracer", {"240, 320": "48, 64", "/ 80": "/ 16", "(256, 3)": "(32, 3)"})
    pixels = np.argwhere(np.ones((48, 64))).astype(np.int32)
    exact = names["tracer"](pixels).gray.reshape(48, 64)
    assert bob.ssim(names["frame"].image, exact) > 0.85
    with Image.open(folder / "ring-guided.png") as picture:
        assert picture.size == (64, 48)


def test_train(folder, capsys):
    (folder / "models").mkdir()
    for number, shape in enumerate((bob.happy_tree(), bob.load("sample:gear"), bob.load("sample:vase"))):
        bob.save_scene(shape, folder / f"models/{number}.bob")
    run("train", {"--test-shapes 2": "--test-shapes 1", "epochs=2": "epochs=1 batch=128", "-o mine": "--size 64x64 -o mine"})
    printed = capsys.readouterr().out
    assert "weights.safetensors" in printed
    assert (folder / "mine.png").exists()
