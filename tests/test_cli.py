"""The installed command line: its pictures, its one-line errors, and how it stops."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh
from clocks import least
from models import MODELS, needs_models
from PIL import Image
from processes import running

import bobrossnet as bob
from bobrossnet.command_line import cli
from bobrossnet.picture.files import CAPTION_HEIGHT, GAP, color_to_8_bit

TRIANGLE = "v 0 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n"


def run(*arguments, timeout=60, cwd=None):
    """Run the installed command in a separate process."""
    command = [sys.executable, "-m", "bobrossnet", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout, cwd=cwd, check=False)


CENTRES = ["--samples", "1", "--background", "#000000"]
"""One ray per pixel, and only radiance in the file."""


def pixels(file):
    with Image.open(file) as image:
        return np.asarray(image)


@pytest.fixture(autouse=True)
def leave_signals_alone():
    handler = signal.getsignal(signal.SIGTERM)
    yield
    signal.signal(signal.SIGTERM, handler)


def test_render_the_built_in_scene(tmp_path):
    out = tmp_path / "out.png"
    done = run("render", "--size", "100x60", "--fraction", "5%", *CENTRES, "-o", out)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert "5 % of 100x60: 300 rays in" in done.stdout
    image = pixels(out)
    part = bob.trace(bob.happy_tree(), size=(60, 100), fraction=0.05)
    assert np.array_equal(image[..., 0], color_to_8_bit(bob.complete(part)))


def test_out_png_here_is_the_default(tmp_path):
    assert run("render", "--size", "16x16", cwd=tmp_path).returncode == 0
    assert [file.name for file in tmp_path.iterdir()] == ["out.png"]


def test_the_whole_picture_is_exact(tmp_path):
    out = tmp_path / "full.png"
    assert (
        cli.main(["render", "--size", "96x64", "--fraction", "100%", *CENTRES, "--azimuth", "70", "-o", str(out)]) == 0
    )
    full = bob.trace(bob.happy_tree(), bob.Camera(azimuth=70), size=(64, 96))
    assert np.array_equal(pixels(out)[..., 0], color_to_8_bit(full.gray))


def test_perspective(tmp_path):
    out = tmp_path / "near.png"
    options = ["--size", "96x64", "--fraction", "100%", *CENTRES, "-o", str(out)]
    stands = bob.Camera(position=(-1.2, -1, 0.3), target=(0, 0, 0.8), fov=70, roll=5)
    for camera, given in (
        (bob.Camera(azimuth=70, fov=35, pan=(0.1, -0.2)), ["--azimuth", "70", "--fov", "35", "--pan", "0.1,-0.2"]),
        (stands, ["--position", "-1.2,-1,0.3", "--target=0,0,.8", "--fov", "70", "--roll", "5"]),
        (bob.Camera(pan=(-0.5, 0)), ["--pan", "-.5,0"]),
    ):
        assert cli.main(["render", *options, *given]) == 0
        full = bob.trace(bob.happy_tree(), camera, size=(64, 96))
        assert np.array_equal(pixels(out)[..., 0], color_to_8_bit(full.gray))


def test_panels(tmp_path, capsys):
    out = tmp_path / "panels.png"
    assert cli.main(["render", "--size", "320x240", "--fraction", "0.05", "--panels", "-o", str(out)]) == 0
    image = pixels(out)
    assert image.shape == (240 + CAPTION_HEIGHT, 3 * 320 + 2 * GAP, 3)
    traced, completed, reference = (image[:240, i * (320 + GAP) :][:, :320] for i in range(3))
    full = bob.trace(bob.happy_tree(), size=(240, 320))
    part = full.sample(0.05)
    assert np.array_equal(reference[..., 0], color_to_8_bit(full.gray))
    assert np.array_equal(completed[..., 1], color_to_8_bit(bob.complete(part)))
    green = traced[..., 1] != traced[..., 0]
    assert np.array_equal(green, part.mask == 0)
    printed = capsys.readouterr().out
    assert f"SSIM {bob.ssim(bob.complete(part), full.gray):.4f}" in printed
    for word in ("5 % of 320x240", "3,840 rays", "completed", "reference  76,800 rays", "wrote"):
        assert word in printed


def test_the_command_line_lights_scenes(tmp_path, capsys):
    """At any share of the pixels, light is completed along first hits, with any network."""
    trimesh.creation.icosphere(2).export(tmp_path / "ball.ply")
    pictures = []
    for i, amount in enumerate(([], ["--fraction", "30%"], ["--error", "0.05"])):
        out = tmp_path / f"{i}.png"
        options = ["--size", "64x48", "--light", "studio", "--fit", "sphere", "-o", str(out)]
        assert cli.main(["render", str(tmp_path / "ball.ply"), *options, *amount]) == 0
        assert "pixels' light and all first hits" in capsys.readouterr().out
        pictures.append(pixels(out).astype(int))
    covered = pictures[0][..., 3] == 255
    for picture, most in zip(pictures[1:], (5, 255 * 0.05), strict=True):
        assert np.abs(picture - pictures[0])[..., 3].mean() < most
        assert np.abs(picture - pictures[0])[covered].mean() < most
    assert cli.main(["render", "--light", "moonshine"]) == 2
    assert "light: expected headlight, studio" in capsys.readouterr().err


@pytest.mark.parametrize("light", [[], ["--light", "studio"]])
def test_glass_that_the_headlight_hides_is_told(light, tmp_path, capsys):
    bob.save_scene(bob.Instance(bob.happy_tree(), material=bob.Glass()), tmp_path / "a.bob")
    arguments = ["--size", "20x20", *light, "-o", str(tmp_path / "out.png")]
    assert cli.main(["render", str(tmp_path / "a.bob"), *arguments]) == 0
    told = "glass      is opaque under the headlight; --light studio shows through it"
    assert (told in capsys.readouterr().out.splitlines()) == (light == [])
    assert cli.main(["info", str(tmp_path / "a.bob")]) == 0
    assert ", transmission 1, ior 1.5\n" in capsys.readouterr().out


def test_several_files_and_up(tmp_path):
    for i, name in enumerate(("a.obj", "b.obj")):
        (tmp_path / name).write_text(TRIANGLE.replace("v 0", f"v {i}"))
    out = tmp_path / "out.png"
    files = [str(tmp_path / "a.obj"), str(tmp_path / "b.obj")]
    arguments = ["render", *files, "--size", "40x40", "--fraction", "1", *CENTRES, "-o", str(out)]
    assert cli.main(arguments) == 0
    upright = bob.trace(bob.load(files), size=(40, 40))
    assert np.array_equal(pixels(out)[..., 0], color_to_8_bit(upright.gray))
    assert cli.main([*arguments, "--up", "y"]) == 0
    turned = bob.trace(bob.load(files, up="y"), size=(40, 40))
    assert np.array_equal(pixels(out)[..., 0], color_to_8_bit(turned.gray))
    assert turned != upright


@needs_models
def test_a_bunny(tmp_path):
    out = tmp_path / "bunny.png"
    done = run("render", MODELS / "scans/stanford_bunny.ply", "--fraction", "5%", "--panels", "-o", out)
    assert done.returncode == 0, done.stderr
    assert "69,451 triangles" in done.stdout
    assert pixels(out).shape == (480 + CAPTION_HEIGHT, 3 * 640 + 2 * GAP, 3)


BALL = "sphere(1) - box(1.2)\n"


@needs_models
@pytest.mark.parametrize("name", ["colonnade", "hi", "prospero", "quarter", "tanglecube"])
def test_formulas(name, tmp_path, capsys):
    file, out = MODELS / f"implicit/{name}.vm", tmp_path / "out.png"
    assert cli.main(["render", str(file), "--size", "160x120", "--fraction", "100%", *CENTRES, "-o", str(out)]) == 0
    shape = bob.load(file).instances[0].shape
    printed = capsys.readouterr().out
    assert f"scene      1 shape, {shape.cells:,} cells, loaded and built in " in printed
    assert np.array_equal(pixels(out)[..., 0], color_to_8_bit(bob.trace(shape, size=(120, 160)).gray))
    unresolved = f"unresolved {shape.unresolved_rays:,} rays" if shape.unresolved_rays else "scene"
    assert unresolved in printed
    assert ("unresolved" in printed) == (shape.unresolved_rays > 0)
    assert cli.main(["info", str(file)]) == 0
    printed = capsys.readouterr().out
    for line in (f"shape     implicit, '{name}.vm'", f"steps: {shape.expression}", f"cells     {shape.cells:,}, "):
        assert line in printed


@pytest.mark.parametrize("name", ["gear", "tower", "vase"])
def test_shape_scripts(name, tmp_path, capsys):
    file, out = Path(__file__).parents[1] / f"examples/{name}.sdf", tmp_path / "out.png"
    assert cli.main(["render", str(file), "--size", "80x60", "--fraction", "2%", "-o", str(out)]) == 0
    assert " cells, loaded and built in " in capsys.readouterr().out
    assert pixels(out).shape == (60, 80, 4)
    assert cli.main(["info", str(file)]) == 0
    assert f"implicit, '{name}.sdf'" in capsys.readouterr().out


def test_meshes_beside_formulas(tmp_path, capsys):
    (tmp_path / "a.obj").write_text(TRIANGLE)
    (tmp_path / "b.sdf").write_text(BALL)
    files = [str(tmp_path / "a.obj"), str(tmp_path / "b.sdf")]
    assert cli.main(["pack", str(tmp_path / "s.bob"), *files, "--up", "y"]) == 0
    scene = bob.load(tmp_path / "s.bob")
    assert f"2 shapes, 1 triangle, {scene.counts()['cell']:,} cells\n" in capsys.readouterr().out
    assert bob.trace(scene, size=(40, 40)) == bob.trace(bob.load(files).turned_upright(), size=(40, 40))


def test_rays_that_only_touch_are_told(tmp_path, capsys):
    """At x = 0, f is a trillionth, which bounds of max(x, -1.5 x) and of its slopes can't resolve."""
    (tmp_path / "a.vm").write_text(
        "x var-x\ny var-y\nz var-z\nxx square x\nyy square y\nzz square z\nr const -0.25\n"
        "xy add xx yy\nxyz add xy zz\nball add xyz r\n"
        "k const -1.5\nback mul k x\nv max x back\nlittle const 1e-12\nsheet add v little\nf min ball sheet\n"
    )
    arguments = ["--size", "40x40", "--fraction", "1", "--azimuth", "0", "-o", str(tmp_path / "out.png")]
    assert cli.main(["render", str(tmp_path / "a.vm"), *arguments]) == 0
    told = [line for line in capsys.readouterr().out.splitlines() if line.startswith("unresolved ")]
    assert len(told) == 1
    assert told[0].endswith(" rays passed places where a sheet thinner than 1e-6 could hide")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.sdf", "f = sphere(1)\nf.rotat(3)\n", "a.sdf: line 2"),
        ("a.sdf", "sphere(1\n", "a.sdf: line "),
        ("a.sdf", "sphere(1)\nimport os\n", "a.sdf: line 2"),
        ("a.sdf", "circle(1)\n", "a.sdf: "),
        ("a.sdf", "", "a.sdf: "),
        ("a.sdf", "plane()\n", "a.sdf: shape: expected an expression that is bounded"),
        ("a.sdf", "sphere(1) - sphere(2)\n", "a.sdf: shape: expected a formula that is negative"),
        ("a.sdf", "f = sphere(1)\nfor i in range(10 ** 9):\n    f |= sphere(i)\n", "a.sdf: line "),
        ("a.vm", "a var-x\nb frobnicate a\n", "a.vm: line 2"),
        ("a.vm", "a var-x\nb add a c\n", "a.vm: line 2"),
        ("a.vm", "a const one\n", "a.vm: line 1"),
        ("a.vm", "", "a.vm: "),
        ("a.vm", "\x00\x01\x02", "a.vm: line 1"),
    ],
)
def test_broken_formulas_get_one_line(name, content, message, tmp_path, capsys):
    (tmp_path / name).write_text(content)
    start = time.monotonic()
    for command in (["render", "--size", "16x16", "-o", str(tmp_path / "out.png")], ["info"]):
        assert cli.main([command[0], str(tmp_path / name), *command[1:]]) == 2
        printed = capsys.readouterr()
        assert printed.out == ""
        assert printed.err.startswith(f"bobrossnet: error: {message}")
        assert printed.err.count("\n") == 1
    assert time.monotonic() - start < 20
    assert [file.name for file in tmp_path.iterdir()] == [name]


def test_info_on_a_mesh(tmp_path, capsys):
    file = tmp_path / "a.obj"
    file.write_text(TRIANGLE)
    assert cli.main(["info", str(file)]) == 0
    printed = capsys.readouterr().out
    assert "triangles  1" in printed
    assert "(0, 0, 0) .. (0, 1, 1)" in printed
    assert "computed" in printed


def test_pack_then_render_and_info(tmp_path, capsys):
    for name, x in (("a.obj", 0), ("b.obj", 1)):
        (tmp_path / name).write_text(TRIANGLE.replace("v 0", f"v {x}"))
    files, scene, out = [str(tmp_path / "a.obj"), str(tmp_path / "b.obj")], tmp_path / "s.bob", tmp_path / "out.png"
    assert cli.main(["pack", str(scene), *files, "--up", "y"]) == 0
    assert f"wrote {scene}: 2 shapes, 2 triangles" in capsys.readouterr().out
    assert cli.main(["render", str(scene), "--size", "40x40", "--fraction", "1", *CENTRES, "-o", str(out)]) == 0
    turned = bob.trace(bob.load(files).turned_upright(), size=(40, 40))
    assert np.array_equal(pixels(out)[..., 0], color_to_8_bit(turned.gray))
    bob.save_scene(bob.Instance(bob.load_mesh(files[0]), material=bob.Material("#ff0000"), name="a\nsail"), scene)
    capsys.readouterr()
    assert cli.main(["info", str(scene)]) == 0
    printed = capsys.readouterr().out
    for line in (r"shape      mesh, 'a\nsail'", "triangles  1", "bounds     (0, 0, 0) .. (0, 1, 1)"):
        assert line in printed
    assert "linear RGB (1, 0, 0), ambient 0.1, diffuse 0.7, specular 0.2, shininess 32" in printed


def test_lights_are_packed(tmp_path, capsys):
    file = tmp_path / "lit.bob"
    assert cli.main(["pack", str(file), "sample:heart", "--light", "studio", "--no-ground"]) == 0
    assert cli.main(["info", str(file)]) == 0
    assert "\nlight   studio\n" in capsys.readouterr().out
    by_default, asked = tmp_path / "default.png", tmp_path / "asked.png"
    render = ["render", str(file), "--size", "40x30", "--out"]
    assert cli.main([*render, str(by_default)]) == 0
    assert cli.main([*render, str(asked), "--light", "studio", "--no-ground"]) == 0
    assert by_default.read_bytes() == asked.read_bytes()
    sun = [bob.Light((0, 0, 1)), bob.Light((1, 0, 0)), bob.Sky(image=np.ones((4, 8, 3)))]
    bob.save_scene(bob.Scene(bob.load(file), light=sun, ground=True), file)
    assert cli.main(["info", str(file)]) == 0
    assert "\nlight   2 discs and an environment, on a ground\n" in capsys.readouterr().out
    assert cli.main(["pack", str(file), "sample:heart", "--ground"]) == 2
    assert "ground: expected none under the headlight" in capsys.readouterr().err
    assert cli.main(["view", "--export", str(tmp_path / "gallery"), "--no-ground"]) == 2
    assert "light: expected headlight or studio, and no ground, without a file" in capsys.readouterr().err


def test_pack_the_built_in_scene(tmp_path):
    assert cli.main(["pack", str(tmp_path / "tree.bob")]) == 0
    assert bob.trace(bob.load(tmp_path / "tree.bob"), size=(32, 32)) == bob.trace(bob.happy_tree(), size=(32, 32))


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("paper", ["10,346", "(80, 5, 3, 3)", "adadelta"]),
        ("default", ["59,600", "(32, 8, 3, 3)", "adaptive+lattice+uniform", "ssim+l1"]),
        ("small", ["16,060", "features    4,8,8,16,16,16", "(4, 14, 3, 3)"]),
        ("filling", ["network     filling", "mask,gray"]),
    ],
)
def test_info_on_weights(name, told, capsys):
    assert cli.main(["info", name]) == 0
    printed = capsys.readouterr().out
    for part in told:
        assert part in printed


def test_evaluate(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("bobrossnet.learn.evaluation.costs.SIZE", (48, 64))
    (tmp_path / "a.obj").write_text(TRIANGLE)
    assert cli.main(["evaluate", str(tmp_path), "--size", "32x32"]) == 0
    printed = capsys.readouterr().out
    assert "1 picture of 1 shape." in printed
    assert "delaunay-linear" in printed


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("speed=9", "speed=9: expected NAME=VALUE with a name of"),
        ("epochs=many", "epochs=many: expected a value of type int"),
        ("--devices=none", "devices=none: expected a value of type int"),
    ],
)
def test_wrong_settings_of_a_training_are_one_line(setting, message, tmp_path, capsys):
    (tmp_path / "zarr.json").touch()
    assert cli.main(["train", str(tmp_path), "run", setting]) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith(f"bobrossnet: error: {message}")
    assert printed.err.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["train", "missing", "run"], "missing: expected a data set, got none"),
        (["evaluate", "missing"], "missing"),
        (["render", "missing.ply"], "missing.ply: "),
        (["render", "notes.txt"], "notes.txt: "),
        (["render", "."], "expected"),
        (["render", "--size", "640"], "--size: expected WIDTHxHEIGHT such as 640x480, got '640'"),
        (["render", "--size", "0x5"], "--size: width: expected an integer in 1.."),
        (["render", "--size", "99999x99999"], "--size: expected at most"),
        (["render", "--size", "-4x5"], "size"),
        (["render", "--fraction", "0"], "--fraction: expected a share of the pixels"),
        (["render", "--fraction", "150%"], "--fraction"),
        (["render", "--fraction", "5%%"], "--fraction"),
        (["render", "--fraction", "nan"], "--fraction"),
        (
            ["render", "--order", "spiral"],
            "order: expected one of uniform, lattice, adaptive, squares, priority, default, got 'spiral'",
        ),
        (["render", "--seed", "-1"], "seed: expected an integer in 0.."),
        (["render", "--azimuth", "east"], "--azimuth"),
        (["render", "--azimuth", "inf"], "azimuth: expected a finite number"),
        (["render", "--elevation", "100"], "elevation: expected a number in [-90, 90]"),
        (["render", "--zoom", "0"], "zoom"),
        (["render", "--fov", "200"], "fov: expected degrees in [0.1, 175], or 0, which is orthographic, got 200"),
        (["render", "--pan", "left"], "--pan: expected numbers with commas between them, got 'left'"),
        (["render", "--position", "3,0,1"], "position: expected a fov above 0 with it, such as fov=35"),
        (["render", "--position", "3,0", "--fov", "35"], "position: expected shape (3,), got (2,)"),
        (["render", "--target", "-3,0,1"], "target: expected none without a position"),
        (
            ["render", "--position", "-3,0,1", "--fov", "35", "--azimuth", "5"],
            "azimuth: expected none with a position",
        ),
        (["render", "--up", "w"], "--up"),
        (["render", "--model", "oil"], "model: expected one of"),
        (["thumbs", ".", "-o", "out"], ".: expected shape files in it or below it, got none"),
        (["render", "-o", "no/such/folder.png"], "there is no folder"),
        (["render", "-o", "picture.gif"], "picture.gif: expected a picture's ending"),
        (["render", "-o", "picture"], "picture: expected a picture's ending"),
        (["render", "notes.bob"], "notes.bob: expected a file"),
        (["pack"], "SCENE.bob"),
        (["pack", "scene.ply"], "scene.ply: expected a scene's ending, .bob, got .ply"),
        (["pack", "no/such/scene.bob"], "there is no folder"),
        (["pack", "scene.bob", "missing.ply"], "missing.ply: "),
        (["pack", "scene.bob", "notes.txt"], "notes.txt: "),
        (["info", "missing.bob"], "missing.bob: "),
        (["info", "missing.safetensors"], "missing.safetensors: "),
        (["info"], "FILE"),
        (["paint"], "paint"),
        (["pack", "scene.bob", "-o", "scene.bob"], "arguments: -o scene.bob (see bobrossnet pack --help)"),
        (["dataset", "build", "data", "--paint"], "arguments: --paint (see bobrossnet dataset build --help)"),
        ([], "COMMAND"),
    ],
)
def test_mistakes_get_one_line_and_status_2(arguments, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("notes.txt").write_text("hello")
    assert cli.main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("bobrossnet: error: ")
    assert printed.err.count("\n") == 1
    assert message in printed.err
    assert [file.name for file in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize(
    ("arguments", "stream"), [(["render", "-o", "-"], "stdout"), (["measure", "-", "--format", "ply"], "stdin")]
)
def test_closed_streams_are_named(arguments, stream, capsys, monkeypatch):
    monkeypatch.setattr(sys, stream, None)
    assert cli.main(arguments) == 2
    assert re.search(r"^bobrossnet: error: .* standard (out|in)put, which is closed\n$", capsys.readouterr().err)


def broken_files():
    return sorted((MODELS / "broken_odd").glob("*")) if MODELS.is_dir() else []


@needs_models
@pytest.mark.parametrize("file", broken_files(), ids=lambda file: file.name)
def test_broken_files_render_or_get_one_line(file, tmp_path, capsys):
    """The table in test_files.py has the expected results; here nothing else may happen."""
    start = time.monotonic()
    status = cli.main(["render", str(file), "--size", "64x48", "-o", str(tmp_path / "out.png")])
    assert time.monotonic() - start < 10
    errors = capsys.readouterr().err
    assert status in (0, 2)
    if status == 0:
        assert pixels(tmp_path / "out.png").shape[:2] == (48, 64)
        assert all(line.startswith("bobrossnet: warning: ") for line in errors.splitlines())
    else:
        assert errors.startswith(f"bobrossnet: error: {file.name}: ")
        assert errors.count("\n") == 1
        assert not list(tmp_path.iterdir())


def test_warnings_are_one_line(tmp_path, capsys):
    file = tmp_path / "nan.obj"
    file.write_text(TRIANGLE + "v nan 0 0\nf 1 2 4\n")
    assert cli.main(["render", str(file), "--size", "16x16", "-o", str(tmp_path / "out.png")]) == 0
    errors = capsys.readouterr().err
    assert errors.startswith("bobrossnet: warning: nan.obj: ")
    assert errors.count("\n") == 1


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_stopping_a_long_render(stop, tmp_path):
    """72 million rays take at least fifteen seconds; on a busy machine, freeing their memory takes two."""
    out = tmp_path / "huge.png"
    out.write_bytes(b"what was here before")
    command = [
        sys.executable,
        "-m",
        "bobrossnet.command_line.cli",
        "render",
        "--size",
        "12000x12000",
        "--fraction",
        "50%",
    ]

    def stopping():
        with running([*command, "-o", str(out)], stderr=subprocess.PIPE) as process:
            time.sleep(3)
            assert process.poll() is None
            process.send_signal(stop)
            start = time.monotonic()
            _, errors = process.communicate(timeout=20)
            took = time.monotonic() - start
        assert process.returncode == 130
        assert errors.splitlines()[-1] == "bobrossnet: interrupted"
        assert "Traceback" not in errors
        return took

    assert least(stopping, 5) < 5
    assert [file.name for file in tmp_path.iterdir()] == ["huge.png"]
    assert out.read_bytes() == b"what was here before"


def test_a_reader_that_leaves_is_no_error(tmp_path):
    command = f"{sys.executable} -m bobrossnet info paper | true"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert done.stderr == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
@pytest.mark.parametrize(
    ("arguments", "unbuffered"), [("info paper", ""), ("info paper", "1"), ("--help", ""), ("--version", "")]
)
def test_output_that_is_full_gets_one_line(arguments, unbuffered):
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-m", "bobrossnet", *arguments.split()]
        environment = {**os.environ, "PYTHONUNBUFFERED": unbuffered}
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, env=environment, check=False)
    assert done.returncode == 2
    assert done.stderr == "bobrossnet: error: can't write the output: No space left on device\n"


@pytest.mark.parametrize("module", ["numpy", "bobrossnet.adapters.files", "bobrossnet.command_line.arguments"])
def test_ctrl_c_while_it_starts_leaves_no_traceback(module, tmp_path):
    """The import of this module sends it, into a process that would otherwise print its version."""
    (tmp_path / "sitecustomize.py").write_text(
        "import os, signal, sys\n"
        "class Finder:\n"
        "    def find_spec(self, name, *_):\n"
        f"        if name == {module!r}:\n"
        "            os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.meta_path.insert(0, Finder())\n"
    )
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-m", "bobrossnet", "--version"]
    with running(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**os.environ, "PYTHONPATH": path}) as p:
        assert p.communicate(timeout=20) == ("", "")
    assert p.returncode == 130


def test_ctrl_c_is_left_alone_where_the_package_is_only_imported():
    code = "import signal, bobrossnet; assert signal.getsignal(signal.SIGINT) is signal.default_int_handler"
    with running([sys.executable, "-c", code]) as process:
        assert process.wait(timeout=20) == 0


def test_a_link_is_written_through(tmp_path):
    (tmp_path / "far").mkdir()
    target = tmp_path / "far" / "picture.png"
    target.write_bytes(b"old")
    for name, aim in (("link.png", "far/picture.png"), ("new.png", "far/other.png")):
        (tmp_path / name).symlink_to(aim)
        assert cli.main(["render", "--size", "16x16", "-o", str(tmp_path / name)]) == 0
        assert os.readlink(tmp_path / name) == aim
        assert pixels(tmp_path / aim).shape == (16, 16, 4)
    assert sorted(file.name for file in target.parent.iterdir()) == ["other.png", "picture.png"]


def test_links_that_lead_to_no_file_are_refused(tmp_path, capsys):
    for aim, message in (
        ("/dev/null", "expected a file to write, got a device"),
        (".", "expected a file to write, got a folder"),
        ("link.png", "expected a file to write, got a link to itself"),
        ("missing/out.png", f"there is no folder {tmp_path / 'missing'}"),
    ):
        link = tmp_path / "link.png"
        link.symlink_to(aim)
        assert cli.main(["render", "--size", "16x16", "-o", str(link)]) == 2
        assert message in capsys.readouterr().err
        assert os.readlink(link) == aim
        link.unlink()
    assert not list(tmp_path.iterdir())


def test_names_may_be_as_long_as_the_system_has_them(tmp_path, capsys):
    for length in (246, 255):
        name = "a" * (length - 4) + ".png"
        assert cli.main(["render", "--size", "16x16", "-o", str(tmp_path / name)]) == 0
        assert [file.name for file in tmp_path.iterdir()] == [name]
        (tmp_path / name).unlink()
    capsys.readouterr()
    assert cli.main(["render", "--size", "16x16", "-o", str(tmp_path / ("a" * 252 + ".png"))]) == 2
    printed = capsys.readouterr()
    assert "can't write it: File name too long" in printed.err
    assert printed.out == ""


def seconds(*arguments):
    """Return the CPU time of a process, which does not count waiting for others."""
    before = os.times()
    subprocess.run([sys.executable, *arguments], capture_output=True, check=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


@pytest.mark.parametrize("command", [("-m", "bobrossnet", "--help"), ("-c", "import bobrossnet")])
def test_help_and_import_are_quick(command):
    """On slow machines at most three times numpy's import; each pair is equally slow."""
    assert least(lambda: seconds(*command) / max(0.3, 3 * seconds("-c", "import numpy")), 1) < 1


def test_numbers_are_checked_without_the_import_of_masked_arrays():
    code = (
        "import sys; from numpy.typing import NDArray; before = {*sys.modules}; import bobrossnet as bob;"
        "bob.Camera(pan=(0, 0.5)); print({*sys.modules} - before & {'numpy.ma'})"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout.split() == [b"set()"]


def test_run_time_needs_no_torch():
    code = (
        "import sys; sys.modules['torch'] = None; import bobrossnet as bob;"
        "bob.complete(bob.trace(bob.happy_tree(), size=(32, 32), fraction=0.1))"
    )
    subprocess.run([sys.executable, "-c", code], check=True, env={**os.environ, "PYTHONWARNINGS": "error"})
