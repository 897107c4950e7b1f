"""Tutorials and how-to pages: their code runs as written, in smaller pictures and data sets."""

import re
import shlex
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest
from PIL import Image

import bobrossnet as bob
from bobrossnet.command_line.cli import main

DOCS = Path(__file__).parent.parent / "docs"
HOW_TO = [page.stem for page in sorted((DOCS / "how-to").glob("*.md"))]


def run(name, smaller):
    """Run a page's blocks in order: Python in one namespace, commands of the package without an error."""
    text = (DOCS / f"{name}.md").read_text()
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
    names = run("tutorials/first-picture", {"-o gear.png": "--size 160x120 -o gear.png", "(480, 640)": "(120, 160)"})
    assert names["part"].fraction == pytest.approx(0.05, abs=0.001)
    assert names["frame"].error <= 0.002
    assert bob.ssim(names["image"], names["exact"].gray) > 0.75
    assert {file.name for file in folder.iterdir()} == {"gear.png", "completed.png", "good-enough.png"}


def test_print_a_part(folder):
    names = run("tutorials/print-a-part", {"step=0.25": "step=1", "ground=False": 'ground=False, size="80x60"'})
    width, depth, height = bob.Scene(names["knob"]).extent.size
    assert (round(width, 2), round(depth, 2), round(height, 2)) == (29.37, 29.37, 12)
    inside = names["knob"].mesh(step=1)
    closed = np.sort(inside.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert (np.unique(closed, axis=0, return_counts=True)[1] == 2).all()
    assert (folder / "knob.3mf").stat().st_size < 4000
    assert (folder / "knob.stl").stat().st_size > 10_000


def test_slow_tracer(folder):
    names = run("tutorials/slow-tracer", {"240, 320": "48, 64", "/ 80": "/ 16", "(256, 3)": "(32, 3)"})
    pixels = np.argwhere(np.ones((48, 64))).astype(np.int32)
    exact = names["tracer"](pixels).gray.reshape(48, 64)
    assert bob.ssim(names["frame"].image, exact) > 0.85
    with Image.open(folder / "ring-guided.png") as picture:
        assert picture.size == (64, 48)


def test_train(folder, capsys):
    (folder / "models").mkdir()
    for number, shape in enumerate((bob.happy_tree(), bob.load("sample:gear"), bob.load("sample:vase"))):
        bob.save_scene(shape, folder / f"models/{number}.bob")
    run(
        "tutorials/train",
        {
            "--test-shapes 2": "--test-shapes 1",
            "epochs=10": "epochs=1 batch=128",
            "5%,10%,25%": "10%",
            "--panels -o mine": "--size 64x64 -o mine",
        },
    )
    printed = capsys.readouterr().out
    assert "weights.safetensors" in printed
    assert (folder / "mine.png").exists()


SMALLER = {
    "part.step": "part.ply",
    "part.stl": "part.ply",
    "1280x960": "64x48",
    "640x480": "64x48",
    "256x256": "32x32",
    "llvm_ad_rgb": "scalar_rgb",
    "range(90)": "range(3)",
    "--views 24": "--views 2",
    "cameras=24": "cameras=2",
    "bob.orbit(part, camera": 'bob.orbit(part, camera, frames=3, size="64x48"',
    "--elevation 30": "--elevation 30 --frames 3 --size 64x48",
    "fraction=0.1)": 'fraction=0.1, size="64x48")',
    'size="64x48", fraction=0.1, size="64x48"': 'size="64x48", fraction=0.1',
    "--light studio": "--light studio --size 64x48",
    'light="studio"': 'light="studio", samples=1',
}


def small(box):
    """Return the scene with a picture of 16 x 16 pixels."""

    def scene():
        made = box()
        made["sensor"]["film"] |= {"width": 16, "height": 16}
        return made

    return scene


@pytest.mark.parametrize("page", HOW_TO)
def test_how_to(page, folder, monkeypatch):
    """With a mesh for the CAD part."""
    bob.happy_tree().save("part.ply")
    (folder / "models").mkdir()
    bob.happy_tree().save("models/tree.ply")
    monkeypatch.setattr(mi, "cornell_box", small(mi.cornell_box))
    run(f"how-to/{page}", SMALLER)
    commands = "".join(re.findall(r"(?s)```sh.*?```", (DOCS / f"how-to/{page}.md").read_text()))
    for name in re.findall(r"(?:-o|--export|--sheet) (\S+\.\w+)", commands):
        assert (folder / name).stat().st_size > 500, name


def test_how_to_pages_fit_on_a_screen():
    for page in HOW_TO:
        assert len((DOCS / f"how-to/{page}.md").read_text().splitlines()) <= 45, page
