"""Views by name, fronts, and shapes that lie on their back."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest
from models import MODELS, needs_models

import bobrossnet as bob

SIZE = (60, 80)
BUNNY = MODELS / "scans/stanford_bunny.ply"
DUCK = MODELS / "loader_originals/glb_material/Duck.glb"
AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


def marker():
    """A flat box with a tower at its front right, seen from -y."""
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    triangles = [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]
    box = bob.Mesh(corners, triangles)
    return bob.Scene([bob.Instance(box).scale((4, 2, 1)), bob.Instance(box).scale((1, 1, 3)).translate((3, 0, 0))])


@pytest.mark.parametrize(
    ("view", "toward"),
    [
        ("front", (0, -1, 0)),
        ("back", (0, 1, 0)),
        ("right", (1, 0, 0)),
        ("left", (-1, 0, 0)),
        ("top", (0, 0, 1)),
        ("bottom", (0, 0, -1)),
        ("isometric", (1, -1, 1)),
    ],
)
def test_views_look_at_their_side(view, toward):
    camera = bob.Camera.named(view)
    rays = camera.core((0, 0, 0), 1).rays(1, 1, np.zeros((1, 2), np.int32))[2]
    assert np.allclose(rays[0] / np.linalg.norm(rays[0]), -np.array(toward) / np.linalg.norm(toward), atol=1e-6)


def test_names_of_views_are_cameras_everywhere():
    scene, camera = marker(), bob.Camera.named("front")
    expected = bob.trace(scene, camera, size=SIZE).gray
    assert np.array_equal(bob.trace(scene, "front", size=SIZE).gray, expected)
    assert np.array_equal(
        bob.render(scene, "top", size=SIZE).rgba, bob.render(scene, bob.Camera.named("top"), size=SIZE).rgba
    )
    assert bob.fitted(scene, "front", size=SIZE) == bob.fitted(scene, camera, size=SIZE)
    assert bob.orbit(scene, "front", frames=2, size=SIZE).cameras[0] == camera
    (frame,) = bob.progressive(scene, "front", size=SIZE, fraction=1)
    assert np.array_equal(frame.gbuffer.gray, expected)
    assert np.array_equal(bob.View(scene, size=SIZE).frame("front", fraction=1).gbuffer.gray, expected)
    with pytest.raises(
        bob.InputError, match="camera: expected one of front, back, right, left, top, bottom, isometric"
    ):
        bob.trace(scene, "frnot", size=SIZE)
    with pytest.raises(TypeError, match="camera: expected a Camera, got int; names of views"):
        bob.trace(scene, 3, size=SIZE)


def test_the_tower_is_at_the_front_right():
    gray = bob.trace(marker(), "front", size=(90, 120)).mask * bob.trace(marker(), "front", size=(90, 120)).alpha
    columns = np.flatnonzero(gray[: gray.shape[0] // 2].any(axis=0))
    assert columns.min() > gray.shape[1] / 2


@needs_models
def test_default_cameras_stand_at_the_front(tmp_path):
    scene = bob.load(DUCK)
    assert scene.has_front
    front = bob.trace(scene, bob.Camera(azimuth=-60), size=SIZE).gray
    assert np.array_equal(bob.trace(scene, size=SIZE).gray, front)
    assert np.array_equal(bob.View(scene, size=SIZE).frame(fraction=1).gbuffer.gray, front)
    (frame,) = bob.progressive(scene, size=SIZE, fraction=1)
    assert np.array_equal(frame.gbuffer.gray, front)
    plain = marker()
    assert not plain.has_front
    assert np.array_equal(bob.trace(plain, size=SIZE).gray, bob.trace(plain, bob.Camera(), size=SIZE).gray)
    bob.save_scene(scene, tmp_path / "a.bob")
    assert bob.load(tmp_path / "a.bob").has_front
    for same in (bob.Scene([scene, plain]), scene.explode(1), scene.converted("mm")):
        assert same.has_front


@pytest.mark.parametrize("up", ["x", "y", "z", "-x", "-y", "-z"])
def test_an_axis_becomes_up(up):
    tip = np.array(AXES[up[-1]]) * (-1 if up[0] == "-" else 1)
    corners = np.array([tip * 5.0, *(np.roll(np.eye(3)[:2] * 1.0, "xyz".index(up[-1]) + 1, axis=1)), -tip])
    scene = bob.load(bob.Mesh(corners, [(0, 1, 2), (1, 2, 3)]), up=up)
    turned = scene.instances[0].transform[:3, :3] @ corners[0]
    assert np.allclose(turned, (0, 0, 5))
    assert np.linalg.det(scene.instances[0].transform[:3, :3]) == pytest.approx(1)
    assert scene.has_front == (up == "y")


@needs_models
def test_what_lies_is_stood_up():
    with pytest.warns(
        bob.InputWarning, match=r"^stanford_bunny\.ply: seems to lie on its back, so its y is taken as up"
    ):
        scene = bob.load(BUNNY, up="auto")
    assert np.allclose(scene.extent.size, bob.load(BUNNY, up="y").extent.size)
    assert scene.has_front
    lying = bob.load(BUNNY)
    assert not lying.has_front
    # A shape in memory, and formats that say which axis is up, stay as they are.
    assert np.allclose(bob.load(lying, up="auto").extent.size, lying.extent.size)
    assert np.allclose(bob.load(DUCK, up="auto").extent.size, bob.load(DUCK).extent.size)


@needs_models
def test_files_together_are_turned_together(tmp_path):
    bob.load_mesh(BUNNY).save(tmp_path / "bunny.stl")
    with pytest.warns(bob.InputWarning, match=r"bunny\.stl and others: seems to lie"):
        scene = bob.load([tmp_path / "bunny.stl", BUNNY], up="auto")
    assert np.allclose(scene.instances[0].transform, scene.instances[1].transform)


def command(*arguments):
    done = subprocess.run(
        [sys.executable, "-m", "bobrossnet", *map(str, arguments)], capture_output=True, text=True, timeout=120
    )
    return done.returncode, done.stdout, done.stderr


@needs_models
def test_the_command_line_stands_shapes_up_and_says_so(tmp_path):
    out = tmp_path / "a.png"
    status, told, warned = command("render", BUNNY, "--size", "80x60", "--json", "-o", out)
    assert status == 0
    report = json.loads(told)
    assert [line for line in warned.splitlines() if line] == [f"bobrossnet: warning: {report['warnings'][0]}"]
    assert report["warnings"][0].startswith("stanford_bunny.ply: seems to lie on its back")
    assert report["camera"]["azimuth"] == -60
    upright = out.read_bytes()
    status, told, warned = command("render", BUNNY, "--size", "80x60", "--up", "y", "-o", out)
    assert (status, warned) == (0, "")
    assert out.read_bytes() == upright
    status, told, _ = command("render", BUNNY, "--size", "80x60", "--up", "-z", "--view", "top", "--json", "-o", out)
    assert (status, json.loads(told)["camera"]["elevation"]) == (0, 90)
    status, _, warned = command("render", BUNNY, "--view", "top", "--azimuth", "3", "-o", out)
    assert status == 2
    assert warned == "bobrossnet: error: --view: expected no --azimuth with it\n"


@needs_models
def test_conversions_keep_the_axes(tmp_path):
    assert command("mesh", BUNNY, "-o", tmp_path / "a.stl")[0] == 0
    assert np.allclose(bob.load(tmp_path / "a.stl").extent.size, bob.load(BUNNY).extent.size)


@needs_models
def test_thumbnails_stand_up(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in/bunny.ply").write_bytes(BUNNY.read_bytes())
    assert command("thumbs", tmp_path / "in", "-o", tmp_path / "auto", "--size", "48x48", "--workers", "1")[0] == 0
    upright = bob.load(BUNNY, up="y")
    camera = bob.fitted(upright, size=(48, 48))
    expected = bob.render(upright, camera, size=(48, 48), background=None).rgba
    from PIL import Image

    found = np.asarray(Image.open(next((tmp_path / "auto").rglob("*.png"))).convert("RGBA"))
    assert np.abs(found.astype(int) - expected).max() <= 1
