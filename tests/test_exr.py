"""OpenEXR files: read by the usual names of their layers, completed, and written as they came."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

import bobrossnet as bob
from bobrossnet.command_line.cli import main
from bobrossnet.completion.exr import completed_channels
from bobrossnet.picture.exr import read_exr, write_exr

SIZE = (40, 60)
CASES = Path(__file__).parent / "cases"


@pytest.fixture(scope="module")
def picture(tree):
    """Return two colours on the tree, as bright as daylight: traced pixels, colour, distances, normals, albedo."""
    full = bob.trace(tree, size=SIZE)
    hit = full.alpha > 0
    row, column = np.indices(SIZE)
    albedo = np.where(((row // 4 + column // 4) % 2)[..., None] > 0, np.float32([0.9, 0.5, 0.1]), np.float32(0.3))
    color = np.where(hit[..., None], 500 * (full.gray[..., None] + 0.1) * albedo, 20).astype(np.float32)
    x, y = np.moveaxis(full.normal, -1, 0)
    normal = np.where(hit[..., None], np.stack([x, y, np.sqrt(np.maximum(0, 1 - x * x - y * y))], -1), 0)
    return (
        full.sample(0.2).mask,
        color,
        np.where(hit, 9 - full.depth, 1e10),
        normal,
        np.where(hit[..., None], albedo, 0),
    )


def layers(picture, names, dense=True):
    """Return the picture's channels under a program's names: (colours, depth, normal, albedo, mask)."""
    mask, color, depth, normal, albedo = picture
    colors, deep, normals, albedos, known = names
    planes = {name: np.where(mask > 0, color[..., i], 0) for i, name in enumerate(colors)}
    kept = 1 if dense else mask
    planes |= dict.fromkeys(deep, kept * depth)
    planes |= {name: kept * normal[..., i] for i, name in enumerate(normals)}
    planes |= {name: kept * albedo[..., i] for i, name in enumerate(albedos)}
    planes |= dict.fromkeys(known, mask)
    return {name: values.astype(np.float32) for name, values in planes.items()}


def lettered(layer, letters):
    return [f"{layer}.{letter}" for letter in letters]


PROGRAMS = {
    "plain": ("RGB", ["Z"], lettered("N", "XYZ"), lettered("albedo", "RGB"), ["mask"]),
    "Blender": (
        lettered("ViewLayer.Combined", "RGB"),
        ["ViewLayer.Depth.Z"],
        lettered("ViewLayer.Normal", "XYZ"),
        lettered("ViewLayer.DiffCol", "RGB"),
        ["ViewLayer.Combined.A"],
    ),
    "Blender's for denoising": (  # as 4.2 writes them
        lettered("ViewLayer.Combined", "RGB"),
        ["ViewLayer.Denoising Depth.Z"],
        lettered("ViewLayer.Denoising Normal", "XYZ"),
        lettered("ViewLayer.Denoising Albedo", "RGB"),
        ["ViewLayer.Combined.A"],
    ),
    "Blender's older": (
        lettered("Scene.View Layer.Combined", "RGB"),
        ["Scene.View Layer.Denoising Depth.V"],
        lettered("Scene.View Layer.Denoising Normal", "XYZ"),
        lettered("Scene.View Layer.Denoising Albedo", "RGB"),
        ["Scene.View Layer.Combined.A"],
    ),
    "Mitsuba": ("RGB", ["dd.T"], lettered("nn", "XYZ"), lettered("albedo", "RGB"), ["A"]),
}


@pytest.mark.parametrize("program", PROGRAMS)
def test_layers_are_known_by_their_names(program, picture, tmp_path):
    names = PROGRAMS[program]
    write_exr(tmp_path / "sparse.exr", layers(picture, names))
    file = read_exr(tmp_path / "sparse.exr")
    roles = ("color", "depth", "normal", "albedo", "mask")
    assert file.roles == {role: list(each) for role, each in zip(roles, names, strict=True)}
    assert np.array_equal(file.traced(), picture[0] > 0)
    assert all(file.is_dense(name) for role in roles[2:4] for name in file.roles[role][:1])
    gbuffer = file.gbuffer()
    assert np.array_equal(gbuffer.guides.hit > 0, picture[2] < 1e9)


def test_light_follows_what_is_known_of_all_pixels(picture, tmp_path, capsys):
    mask, color, *_ = picture
    errors = {}
    for dense in (True, False):
        write_exr(tmp_path / "sparse.exr", layers(picture, PROGRAMS["Blender"], dense))
        assert main(["complete", str(tmp_path / "sparse.exr"), "-o", str(tmp_path / "full.exr")]) == 0
        whole = read_exr(tmp_path / "full.exr")
        found = whole.role("color")
        assert np.array_equal(found[mask > 0], color[mask > 0])
        assert (whole.role("mask") == 1).all()
        assert whole.planes.keys() == layers(picture, PROGRAMS["Blender"]).keys()
        errors[dense] = np.abs(found - color).mean()
    assert errors[True] < 0.5 * errors[False] < 0.1 * color.mean()
    out = capsys.readouterr().out
    assert "ViewLayer.Normal.X, ViewLayer.Normal.Y, ViewLayer.Normal.Z, of all pixels" in out
    assert "known      20 % of 60x40" in out


def test_every_channel_is_completed(picture, tmp_path):
    planes = layers(picture, PROGRAMS["plain"], dense=False)
    planes["heat.Y"] = np.where(picture[0] > 0, np.float16(-7), np.float16(0)).astype(np.float16)
    planes["id.I"] = np.arange(SIZE[0] * SIZE[1], dtype=np.uint32).reshape(SIZE)
    write_exr(tmp_path / "sparse.exr", planes)
    whole = completed_channels(read_exr(tmp_path / "sparse.exr"))
    assert whole["heat.Y"].dtype == np.float16
    assert np.allclose(whole["heat.Y"].astype(float), -7, atol=0.1)
    assert np.array_equal(whole["id.I"], planes["id.I"])
    assert np.array_equal(whole["mask"], planes["mask"])
    for name, values in planes.items():
        assert np.array_equal(whole[name][picture[0] > 0], values[picture[0] > 0])


def test_names_can_be_given(picture, tmp_path):
    colors, deep, normals = lettered("beauty.final", "RGB"), ["far.Q"], lettered("up", "XYZ")
    planes = layers(picture, (colors, deep, normals, lettered("tint", "RGB"), ["seen.Q"]))
    write_exr(tmp_path / "odd.exr", planes)
    names = {"color": "beauty.final", "depth": "far", "albedo": "tint", "mask": "seen.Q"}
    roles = read_exr(tmp_path / "odd.exr", names).roles
    assert roles["color"] == colors
    assert roles["depth"] == deep
    assert roles["normal"] == normals  # by their values
    assert roles["albedo"] == lettered("tint", "RGB")
    assert roles["mask"] == ["seen.Q"]


def test_tiles_and_parts_are_read(picture, tmp_path):
    planes = layers(picture, PROGRAMS["plain"])
    tiled = {"type": OpenEXR.tiledimage, "tiles": OpenEXR.TileDescription()}
    OpenEXR.File(tiled, dict(planes)).write(str(tmp_path / "tiled.exr"))
    colors = {name: values for name, values in planes.items() if name in "RGB" or name == "mask"}
    others = {name: values for name, values in planes.items() if name not in colors}
    parts = [OpenEXR.Part({}, colors, "rgba"), OpenEXR.Part({}, others, "data")]
    OpenEXR.File(parts).write(str(tmp_path / "parts.exr"))
    for name in ("tiled.exr", "parts.exr"):
        file = read_exr(tmp_path / name)
        assert set(file.roles) == {"color", "depth", "normal", "albedo", "mask"}
        for channel, values in planes.items():
            assert np.array_equal(file.planes[channel], values)


def written_header(path):
    with OpenEXR.File(str(path)) as file:
        return {name: np.array(value).tolist() for name, value in file.header().items() if name != "channels"}


def test_windows_stay_as_they_are(tmp_path):
    """A crop of a larger picture stays where it is in it."""
    out = tmp_path / "out.exr"
    assert main(["complete", str(CASES / "exr-windows/crop.exr"), "-o", str(out)]) == 0
    header = written_header(out)
    assert header["dataWindow"] == [[20, 12], [67, 43]]
    assert header["displayWindow"] == [[0, 0], [99, 79]]


def test_attributes_of_the_picture_stay(picture, tmp_path):
    header = {
        "dataWindow": ((-5, 7), (54, 46)),
        "displayWindow": ((-9, -9), (99, 99)),
        "pixelAspectRatio": 2.0,
        "screenWindowCenter": (0.5, -0.25),
        "screenWindowWidth": 3.0,
        "chromaticities": (0.7, 0.3, 0.2, 0.8, 0.1, 0.05, 0.3, 0.3),
    }
    settings = {**header, "type": OpenEXR.tiledimage, "tiles": OpenEXR.TileDescription()}
    OpenEXR.File(settings, layers(picture, PROGRAMS["plain"])).write(str(tmp_path / "a.exr"))
    assert main(["complete", str(tmp_path / "a.exr"), "-o", str(tmp_path / "b.exr")]) == 0
    before, after = written_header(tmp_path / "a.exr"), written_header(tmp_path / "b.exr")
    assert {name: after[name] for name in header} == {name: before[name] for name in header}
    parts = [
        OpenEXR.Part({"dataWindow": ((x, 0), (x + SIZE[1] - 1, SIZE[0] - 1))}, {name: np.ones(SIZE, np.float32)}, name)
        for x, name in enumerate("RGB")
    ]
    OpenEXR.File(parts).write(str(tmp_path / "c.exr"))
    with pytest.raises(bob.InputError, match=r"c\.exr: expected parts with one data window, got 3 different ones"):
        read_exr(tmp_path / "c.exr")


def test_deep_pictures_are_one_line(capsys):
    assert main(["complete", str(CASES / "exr-deep/deep.exr")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith("deep.exr: expected a flat picture, got a deep one, in A; flatten it first")


def test_bright_and_dark_survive(tmp_path):
    planes = {name: np.full(SIZE, 1e4, np.float32) for name in "RGB"}
    planes["R"][:, 30:] = 1e-4
    planes["mask"] = (
        bob.GBuffer(mask=np.ones(SIZE, np.float32), gray=np.ones(SIZE, np.float32), depth=np.ones(SIZE, np.float32))
        .sample(0.3, order="uniform")
        .mask
    )
    write_exr(tmp_path / "hdr.exr", planes)
    whole = completed_channels(read_exr(tmp_path / "hdr.exr"))
    traced = planes["mask"] > 0
    for name in "RGB":
        assert np.array_equal(whole[name][traced], planes[name][traced])
    assert np.abs(whole["G"] - 1e4).mean() < 50


@pytest.mark.parametrize("fraction", ["5%", "100%"])
def test_pictures_of_shapes_are_written(fraction, tree, tmp_path):
    out = tmp_path / "tree.exr"
    assert main(["render", "--size", "64x48", "--fraction", fraction, "-o", str(out)]) == 0
    part = bob.trace(tree, size=(48, 64), fraction=float(fraction[:-1]) / 100)
    file = read_exr(out)
    assert np.array_equal(file.role("mask"), part.mask)
    assert np.array_equal(file.planes["depth"], part.depth)
    assert np.array_equal(file.planes["N.Y"], part.normal[..., 1])
    assert np.allclose(file.role("color")[..., 1], bob.complete(part), atol=1e-4)


def test_a_missing_library_is_named_before_files_are_read(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    assert main(["render", str(tmp_path / "nothing.ply"), "-o", str(tmp_path / "out.exr")]) == 2
    assert "OpenEXR files need OpenEXR: pip install 'bobrossnet[exr]'" in capsys.readouterr().err


def test_what_is_no_such_file_is_named(picture, tmp_path, capsys):
    text = tmp_path / "text.exr"
    text.write_text("not a picture")
    with pytest.raises(bob.InputError, match=r"text.exr: expected an OpenEXR file, got another$"):
        read_exr(text)
    empty = tmp_path / "empty.exr"
    empty.touch()
    with pytest.raises(bob.InputError, match=r"empty.exr: expected an OpenEXR file, got an empty file$"):
        read_exr(empty)
    with pytest.raises(bob.InputError, match=rf"{re.escape(tmp_path.name)}: expected a file, got a folder$"):
        read_exr(tmp_path)
    whole = tmp_path / "whole.exr"
    write_exr(whole, layers(picture, PROGRAMS["plain"]))
    cut = tmp_path / "cut.exr"
    cut.write_bytes(whole.read_bytes()[:2000])
    with pytest.raises(bob.InputError, match=r"cut.exr: .* got none; it may be cut short$"):
        read_exr(cut)
    gray = tmp_path / "depth.exr"
    write_exr(gray, {"Z": np.ones(SIZE, np.float32)})
    with pytest.raises(
        bob.InputError, match=r"depth.exr: expected colours, R, G and B or Y, got Z; --color names a layer"
    ):
        read_exr(gray)
    with pytest.raises(bob.InputError, match=r"whole.exr: albedo: expected a layer or channel of .*, got 'paint'"):
        read_exr(whole, {"albedo": "paint"})
    assert main(["complete", str(text)]) == 2
    assert main(["complete", str(whole), "-o", str(tmp_path / "out.png")]) == 2
    assert main(["render", "--panels", "-o", str(tmp_path / "out.exr")]) == 2
    assert all(line.startswith("bobrossnet: error: ") for line in capsys.readouterr().err.splitlines())


def test_a_missing_file_is_one_line(tmp_path, capfd):
    with pytest.raises(bob.InputError, match=r"none.exr: expected an OpenEXR file, can't read it: No such file"):
        read_exr(tmp_path / "none.exr")
    assert capfd.readouterr() == ("", "")


def test_blender_writes_layers_that_are_known(tmp_path):
    """A part of a picture with its denoising passes, by Blender if installed."""
    pytest.importorskip("bpy", reason="bpy, which is Blender, is not installed")
    path = tmp_path / "part.exr"
    subprocess.run([sys.executable, "-c", BLENDER, str(path)], check=True, timeout=300, stdout=subprocess.DEVNULL)
    file = read_exr(path)
    last = {role: [name.partition(".")[2] for name in names] for role, names in file.roles.items()}
    assert last == {
        "color": lettered("Combined", "RGB"),
        "depth": ["Denoising Depth.Z"],
        "normal": lettered("Denoising Normal", "XYZ"),
        "albedo": lettered("Denoising Albedo", "RGB"),
        "mask": ["Combined.A"],
    }
    assert file.traced().mean() == pytest.approx(1 / 4, abs=0.02)
    assert main(["complete", str(path), "-o", str(tmp_path / "full.exr")]) == 0
    whole = read_exr(tmp_path / "full.exr")
    assert np.array_equal(whole.role("color")[file.traced()], file.role("color")[file.traced()])
    assert (whole.role("mask") == 1).all()


BLENDER = """
import sys, bpy
bpy.ops.wm.read_factory_settings()  # a cube, a lamp and a camera
scene = bpy.context.scene
scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", 2
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 64, 48, 100
scene.render.use_border, scene.render.use_crop_to_border = True, False
scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.75
scene.render.border_min_y, scene.render.border_max_y = 0.25, 0.75
scene.view_layers[0].cycles.denoising_store_passes = True
scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
scene.render.filepath = sys.argv[1]
bpy.ops.render.render(write_still=True)
"""
