"""Values that people try first: paths, other libraries' meshes, colour names, arrays, samples by name."""

import shutil
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import trimesh
from PIL import Image

import bobrossnet as bob
from bobrossnet.command_line import cli
from bobrossnet.sdf import sphere

SIZE = (36, 48)


@pytest.fixture
def file(tmp_path):
    bob.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]).save(
        tmp_path / "part.stl"
    )
    return tmp_path / "part.stl"


@pytest.mark.parametrize("kind", [str, lambda path: path, bytes], ids=["str", "Path", "bytes"])
def test_paths_are_scenes(file, kind):
    path = str(file).encode() if kind is bytes else kind(file)
    expected = bob.trace(bob.load(file), size=SIZE)
    assert np.array_equal(bob.trace(path, size=SIZE).gray, expected.gray)
    assert np.array_equal(next(bob.progressive(path, size=SIZE, fraction=1)).gbuffer.gray, expected.gray)
    assert bob.render(path, size=SIZE).rgba.any()
    assert bob.View(path, size=SIZE).frame(bob.Camera(), fraction=1).gbuffer.mask.all()
    assert bob.fitted(path).zoom > 0
    assert len(bob.Scene([path, sphere(1), path]).instances) == 3


def test_a_picture_of_a_file_is_upright_and_fills_the_frame(tmp_path):
    """Without a camera, as on the command line; with one, as stored."""
    path, out = str(tmp_path / "table.ply"), str(tmp_path / "table.png")
    top, legs = (1.6, 0.1, 1), [(x, z) for x in (-0.7, 0.7) for z in (-0.4, 0.4)]  # y is up
    parts = [trimesh.creation.box(top).apply_translation((0, 1.05, 0))]
    parts += [trimesh.creation.box((0.1, 1, 0.1)).apply_translation((x, 0.5, z)) for x, z in legs]
    trimesh.util.concatenate(parts).export(path)
    with pytest.warns(bob.InputWarning, match="its y is taken as up"):
        picture = bob.render(path, size=SIZE)
    assert cli.main(["render", path, "--size", "48x36", "-o", out, "--quiet"]) == 0
    with Image.open(out) as image:
        assert np.array_equal(np.asarray(image), picture.rgba)
    rows = np.flatnonzero(picture.alpha.any(1))
    assert len(rows) > 0.85 * SIZE[0]
    stored = bob.render(bob.load(path), size=SIZE)
    assert np.array_equal(bob.render(path, bob.Camera(), size=SIZE).rgba, stored.rgba)
    assert not np.array_equal(stored.rgba, picture.rgba)


def test_a_missing_file_is_named(file):
    with pytest.raises(bob.InputError, match=r"^other.stl: expected a file, found nothing at "):
        bob.render(file.with_name("other.stl"))


def test_the_home_folder(file, monkeypatch):
    monkeypatch.setenv("HOME", str(file.parent))
    monkeypatch.setenv("USERPROFILE", str(file.parent))
    assert len(bob.load("~/part.stl").instances) == 1
    bob.render("~/part.stl", size=SIZE).save("~/part.png")
    assert file.with_suffix(".png").exists()


def test_a_file_whose_name_begins_with_a_tilde(file, monkeypatch):
    monkeypatch.chdir(file.parent)
    shutil.copy(file, "~part.stl")
    assert len(bob.load("~part.stl").instances) == 1


def test_meshes_of_trimesh():
    box = trimesh.creation.box()
    expected = bob.trace(bob.Mesh(box.vertices, box.faces), size=SIZE).gray
    assert np.array_equal(bob.trace(box, size=SIZE).gray, expected)
    assert np.array_equal(bob.trace(bob.load(box), size=SIZE).gray, expected)


def test_colors_of_trimesh():
    box = trimesh.creation.box()
    box.visual.vertex_colors = (255, 0, 0, 255)
    (instance,) = bob.load(box).instances
    assert np.allclose(instance.shape.colors, (1, 0, 0))
    box = trimesh.creation.box()
    box.visual.face_colors = (0, 188, 0, 255)
    (instance,) = bob.load(box).instances
    assert np.allclose(instance.shape.face_colors, (0, 0.5028, 0), atol=1e-4)


def test_a_texture_of_trimesh():
    """Its v is measured from the bottom: the picture's upper half is red."""
    picture = Image.new("RGB", (8, 8), "blue")
    picture.paste("red", (0, 0, 8, 4))
    square = trimesh.Trimesh([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2), (0, 2, 3)], process=False)
    square.visual = trimesh.visual.TextureVisuals([(0, 0), (1, 0), (1, 1), (0, 1)], image=picture)
    red, _, blue = bob.trace(square, bob.Camera(elevation=90), size=SIZE).albedo.reshape(-1, 3).T
    assert red.sum() == pytest.approx(blue.sum(), rel=0.1)
    (instance,) = bob.load(square).instances
    assert np.allclose(instance.shape.uv[[0, 2]], [(0, 1), (1, 0)])


def test_scenes_of_trimesh_keep_places_and_share_meshes():
    scene, ball = trimesh.Scene(), trimesh.creation.icosphere()
    scene.add_geometry(ball, node_name="a", geom_name="ball")
    scene.graph.update("b", geometry="ball", matrix=trimesh.transformations.translation_matrix((5, 0, 0)))
    loaded = bob.load(scene)
    assert [instance.name for instance in loaded.instances] == ["a", "b"]
    assert loaded.instances[0].shape is loaded.instances[1].shape
    assert np.allclose(loaded.center, (2.5, 0, 0))


@pytest.mark.parametrize("name", ["tomato", "TOMATO", "#ff6347"])
def test_color_names(name):
    assert np.allclose(bob.Material(name).color, (1, 0.1247, 0.0630), atol=1e-4)
    assert sphere(1).color(name).color_formula == sphere(1).color("#ff6347").color_formula


@pytest.mark.parametrize("name", ["", "#", "tomat", "tomatoe", "zzz", "aaa", "#ff634", "tomato "])
def test_other_words_are_no_colors(name):
    with pytest.raises(bob.InputError, match=r"^color: expected #rrggbb, a CSS name or 3 numbers, got "):
        bob.Material(name)


def test_arrays_of_tracers():
    def gray(pixels):
        return pixels[:, 0] / SIZE[0]

    def color(pixels):
        return np.repeat(gray(pixels)[:, None], 3, axis=1)

    expected = np.repeat(np.arange(SIZE[0])[:, None] / SIZE[0], SIZE[1], axis=1)
    *_, frame = bob.progressive(tracer=gray, size=SIZE)
    assert np.allclose(frame.image, expected)
    with ThreadPoolExecutor() as pool:
        *_, frame = bob.progressive(tracer=lambda pixels: pool.submit(color, pixels), size=SIZE)
    assert np.allclose(frame.color, expected[..., None])


@pytest.mark.parametrize("shape", [(2,), (2, 2), (2, 3, 1), ()])
def test_arrays_of_other_shapes_are_refused(shape):
    with pytest.raises(bob.InputError):
        next(bob.progressive(tracer=lambda pixels: np.zeros(shape), size=SIZE))


def test_arrays_are_saved(tmp_path):
    image = np.linspace(0, 1, 48 * 36, dtype=np.float32).reshape(SIZE)
    bob.save(image, tmp_path / "gray.png")
    with Image.open(tmp_path / "gray.png") as picture:
        assert np.asarray(picture)[-1, -1] == 255
        assert np.asarray(picture)[18, 0] == 188  # sRGB of .5
    bob.save(np.dstack([image] * 3), tmp_path / "color.png")
    bob.save(np.full((*SIZE, 4), 7, np.uint8), tmp_path / "alpha.png")
    with Image.open(tmp_path / "alpha.png") as picture:
        assert (np.asarray(picture) == 7).all()
    for wrong in (np.zeros((2, 2, 2)), np.zeros(3), np.full(SIZE, np.nan), np.zeros((0, 3)), "x", np.zeros((2, 2, 4))):
        with pytest.raises(bob.InputError, match=r"^image: "):
            bob.save(wrong, tmp_path / "wrong.png")
    assert not (tmp_path / "wrong.png").exists()


def test_samples_by_name():
    assert bob.load("sample:happy_tree").instances[0].shape.digest == bob.happy_tree().digest
    gyroid = bob.load("sample:gyroid")
    assert gyroid.instances[0].shape.kind == "implicit"
    with pytest.raises(bob.InputError, match=r"^sample: expected one of happy_tree, .*gyroid.*, got 'geer'"):
        bob.load("sample:geer")
