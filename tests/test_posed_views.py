"""Views with camera matrices: depth, normals and poses agree; data sets of them resume to the same bytes."""

import io
import json
import tarfile

import numpy as np
import pytest
from PIL import Image

import bobrossnet as bob
from bobrossnet.command_line import cli
from bobrossnet.pictures import views
from bobrossnet.sdf import box, sphere

MIDDLE, RADIUS = np.array([30.0, -20.0, 7.0]), 5.0
CAMERAS = [
    bob.Camera(azimuth=30, fov=40),
    bob.Camera(azimuth=80, elevation=-35, fov=25, zoom=1.3, pan=(0.1, -0.2), roll=20),
    bob.Camera(azimuth=200, elevation=50),
    bob.Camera(azimuth=20, zoom=1.5, pan=(0.2, 0.1), roll=-50),
    bob.Camera(position=(38, -31, 9), target=(30, -20, 7), fov=70),
]


@pytest.fixture(scope="module")
def scene():
    ball = bob.Instance(sphere(RADIUS)).translate(MIDDLE)
    return bob.Scene([bob.Instance(box(1)).translate(MIDDLE + (0, 0, 6)), ball])


@pytest.mark.parametrize("camera", CAMERAS, ids=repr)
def test_points_and_normals_are_in_the_scene(scene, camera):
    (view,) = bob.views(scene, [camera], size=(96, 128))
    on_ball = view.instance == 1
    assert on_ball.sum() > 300
    from_middle = view.points()[on_ball] - MIDDLE
    distance = np.linalg.norm(from_middle, axis=1)
    assert np.abs(distance - RADIUS).max() < 1e-4 * scene.radius
    assert np.abs(view.normal[on_ball] - from_middle / distance[:, None]).max() < 2e-3
    assert (view.mask == (view.instance >= 0)).all()
    assert (view.depth[~view.mask] == 0).all()
    assert np.isnan(view.points()[~view.mask]).all()


@pytest.mark.parametrize("camera", CAMERAS, ids=repr)
def test_matrices_agree(scene, camera):
    (view,) = bob.views(scene, [camera], channels=["depth"], size=(96, 128))
    assert view.color is None
    assert view.normal is None
    flip = np.diag([1, -1, -1, 1])
    assert np.allclose(view.pose.camera_to_world @ flip @ view.pose.world_to_camera, np.eye(4), atol=1e-9)
    assert np.allclose(np.linalg.det(view.pose.world_to_camera[:3, :3]), 1)
    rows, columns = np.nonzero(view.mask)
    seen = view.points()[rows, columns] @ view.pose.world_to_camera[:3, :3].T + view.pose.world_to_camera[:3, 3]
    assert np.allclose(seen[:, 2], view.depth[rows, columns], atol=1e-4)
    seen[:, :2] /= 1 if view.pose.is_orthographic else seen[:, 2:]
    seen[:, 2] = 1
    pixel = seen @ view.pose.intrinsics.T
    assert np.allclose(pixel[:, 0], columns + 0.5, atol=1e-2)
    assert np.allclose(pixel[:, 1], rows + 0.5, atol=1e-2)


def test_views_around_a_scene():
    cameras = [view.camera for view in bob.views(bob.happy_tree(), 12, channels="depth", size=(8, 8))]
    azimuth, elevation = np.radians([(camera.azimuth, camera.elevation) for camera in cameras]).T
    ways = np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], 1)
    near = (ways @ ways.T - 2 * np.eye(12)).max(axis=1)
    assert np.degrees(np.arccos(near)).min() > 40
    assert np.abs(ways.mean(axis=0)).max() < 0.05


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"channels": ["colour"]}, "channels: expected .*color.*got"),
        ({"channels": []}, r"channels: expected some of .*, got \[\]"),
        ({"cameras": 0}, "cameras: expected an integer of at least 1|cameras: expected"),
        ({"cameras": bob.Camera()}, "cameras: expected a number or several cameras, got one"),
    ],
)
def test_bad_arguments_are_refused_before_the_first_view(scene, wrong, message):
    with pytest.raises((bob.InputError, bob.InputTypeError), match=message):
        bob.views(scene, **{"cameras": 1} | wrong)


@pytest.fixture
def models(tmp_path):
    folder = tmp_path / "models/below"
    folder.mkdir(parents=True)
    bob.happy_tree().save(folder / "tree.ply")
    return tmp_path / "models"


def files_of(folder):
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


@pytest.mark.parametrize("format", ["npz", "exr", "webdataset"])
def test_data_sets(models, tmp_path, format, capsys):
    command = ["dataset", "views", str(models), "--views", "3", "--size", "32x24", "--format", format]
    assert cli.main([*command, "-o", str(tmp_path / "one")]) == 0
    assert "wrote 3 views of 1 shape " in capsys.readouterr().out
    made = files_of(tmp_path / "one")
    place = tmp_path / "one/below/tree.ply"
    if format == "webdataset":
        with tarfile.open(tmp_path / "one/below/tree.ply.tar") as tar:
            assert tar.getnames() == [f"{i:05}.{ending}" for i in range(3) for ending in ("png", "npz", "json")]
            about = json.load(tar.extractfile("00001.json"))
            arrays = np.load(io.BytesIO(tar.extractfile("00001.npz").read()))
        assert np.allclose(arrays["world_to_camera"], about["world_to_camera_opencv"])
        (tmp_path / "one/below/tree.ply.tar").unlink()
    else:
        transforms = json.loads((place / "transforms.json").read_text())
        assert (transforms["w"], transforms["h"], len(transforms["frames"])) == (32, 24, 3)
        with Image.open(place / transforms["frames"][2]["file_path"]) as picture:
            assert (picture.size, picture.mode) == ((32, 24), "RGBA")
        (place / "transforms.json").unlink()  # as if it had been interrupted
        (place / f"00001.{format}").unlink()
    assert cli.main([*command, "-o", str(tmp_path / "one")]) == 0
    assert files_of(tmp_path / "one") == made
    assert cli.main([*command, "-o", str(tmp_path / "one")]) == 0
    assert "1 shape was there" in capsys.readouterr().out


def test_unreadable_files_are_named(models, tmp_path, capsys):
    (models / "broken.ply").write_text("ply\n")
    command = ["dataset", "views", str(models), "-o", str(tmp_path / "out"), "--views", "1", "--size", "16x16"]
    assert cli.main(command) == 1
    assert "/broken.ply: expected " in capsys.readouterr().err


def test_bad_options_of_data_sets_are_refused_at_once(models, tmp_path, capsys):
    command = ["dataset", "views", str(models), "-o", str(tmp_path / "out"), "--samples", "65"]
    assert cli.main(command) == 2
    assert "samples: expected" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_points_of_two_views_coincide():
    """Depth and pose agree: a point of one view, seen from another, has the depth there; 1e-4 of the radius."""
    scene = bob.Scene(bob.happy_tree())
    first, second = bob.views(scene, [bob.Camera(30, 25, fov=40), bob.Camera(55, 30)], "depth", size=(240, 320))
    points = first.points()[first.mask].astype(float)
    seen = points @ second.pose.world_to_camera[:3, :3].T + second.pose.world_to_camera[:3, 3]
    place = np.column_stack([seen[:, :2], np.ones(len(seen))]) @ second.pose.intrinsics.T  # orthographic
    column, row = np.floor(place[:, :2]).astype(int).T
    inside = (row >= 0) & (row < 240) & (column >= 0) & (column < 320)
    inside[inside] = second.mask[row[inside], column[inside]]
    # Back in space: the second view's point at that pixel, along its surface to the first's.
    there = second.points()[row[inside], column[inside]].astype(float)
    apart = np.linalg.norm(there - points[inside], axis=1)
    pixel = 1 / second.pose.intrinsics[0, 0]
    same = apart < 3 * pixel
    assert same.mean() > 0.4  # the others are hidden from the second
    # A ray through the first's point itself meets it.
    rays = points[inside][same] - second.pose.camera_to_world[:3, 2] * -2 * scene.radius
    hits = scene.closest_hits(rays, np.broadcast_to(-second.pose.camera_to_world[:3, 2], rays.shape))
    found = rays - hits.distance[:, None] * second.pose.camera_to_world[:3, 2]
    coincide = np.linalg.norm(found - points[inside][same], axis=1) < 1e-4 * scene.radius
    assert coincide.mean() > 0.97


@pytest.mark.parametrize("light", [None, "studio"])
def test_colors_are_those_of_render(light):
    scene = bob.Scene(bob.happy_tree())
    (view,) = bob.views(scene, ["front"], size=(60, 80), light=light, background="#fff")
    assert np.array_equal(view.color, bob.render(scene, "front", size=(60, 80), light=light, background="#fff").rgba)


def test_one_shape_is_traced_once(scene, monkeypatch):
    """Depth, normals and the mask come from the samples of the colour; only several instances need other rays."""
    calls = []
    traced = views.trace
    monkeypatch.setattr(views, "trace", lambda *a, **k: (calls.append("trace"), traced(*a, **k))[1])
    monkeypatch.setattr(views, "_instances", lambda *a: calls.append("instances") or np.zeros((24, 32), np.int32))
    list(bob.views(sphere(1), 2, size=(24, 32)))
    assert calls == ["trace", "trace"]
    list(bob.views(scene, 1, size=(24, 32)))
    assert calls[2:] == ["trace", "instances"]
