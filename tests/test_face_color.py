"""Colours of faces: pictures, meshes and files of breps with coloured faces."""

import json
import pickle
from collections import Counter

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.adapters.container import layout, sealed
from bobrossnet.color import from_srgb

SIZE = 60, 80
KNOTS = [0, 0, 1, 1]
COLORS = ("#c33", None, (0, 0.5, 1), "#393", (1, 1, 0), "#f9c")


def cube(colors=COLORS):
    """Return six faces with optional colours."""
    faces = []
    for axis in range(3):
        for side in (0, 1):
            points = np.zeros((2, 2, 3))
            points[..., axis] = side
            points[..., (axis + 1) % 3], points[..., (axis + 2) % 3] = np.meshgrid((0, 1), (0, 1), indexing="ij")
            faces.append(bob.Face(points, KNOTS, KNOTS, color=colors[len(faces)]))
    return bob.Brep(faces)


@pytest.fixture(scope="module")
def brep():
    return cube()


def test_faces_take_colors_as_materials_do():
    face = cube().faces[0]
    assert face.color == bob.Material("#c33").color
    assert cube().faces[1].color is None
    assert (
        bob.nurbs_surface(face.control_points, KNOTS, KNOTS, color="#393").faces[0].color == bob.Material("#393").color
    )
    for color, message in (
        ("rot", "color: expected #rrggbb, a CSS name or 3 numbers, got 'rot'"),
        ((2, 0, 0), "color: expected a"),
    ):
        with pytest.raises(bob.InputError, match=f"^{message}"):
            bob.Face(face.control_points, KNOTS, KNOTS, color=color)


@pytest.mark.parametrize("angles", [(30, 30), (210, -40)])
def test_pictures_show_the_color_of_the_face_that_was_hit(brep, angles):
    camera = bob.Camera(azimuth=angles[0], elevation=angles[1])
    seen = bob.trace(bob.Instance(brep, material=bob.Material((1, 0.5, 0.5))), camera, size=SIZE)
    plain = bob.trace(cube([None] * 6), camera, size=SIZE)
    assert plain.channels == ("mask", "gray", "depth", "normal")
    for channel in ("mask", "depth", "normal"):
        assert np.array_equal(seen.channel(channel), plain.channel(channel))
    found = {tuple(color) for color in seen.albedo[seen.alpha > 0]}
    expected = [np.float32(brep.face_colors[i]) * np.float32((1, 0.5, 0.5)) for i in range(6)]
    assert len(found) == 3
    assert all(any(np.array_equal(color, each) for each in expected) for color in found)


def test_a_hit_has_the_color_of_its_face(brep):
    center = np.full(3, 0.5)
    for i in range(6):
        out = np.eye(3)[i // 2] * (1 if i % 2 else -1)
        hits = bob.Scene(brep).closest_hits([center + 3 * out], [-out])
        assert hits.primitive[0] == i
    camera = bob.Camera(azimuth=0, elevation=0)  # from +x: the face at x = 1
    albedo = bob.trace(brep, camera, size=SIZE).albedo[30, 40]
    assert np.array_equal(albedo, brep.face_colors[1])
    assert np.array_equal(
        bob.trace(brep, bob.Camera(azimuth=180, elevation=0), size=SIZE).albedo[30, 40], brep.face_colors[0]
    )


def test_meshes_have_the_colors_of_faces(brep, tmp_path):
    mesh = brep.mesh(0.2)
    assert len(mesh.face_colors) == len(mesh.triangles)
    middle = mesh.vertices[mesh.triangles].mean(axis=1)
    for i in range(6):
        on = np.abs(middle[:, i // 2] - i % 2) < 1e-6
        assert on.any()
        assert (mesh.face_colors[on] == brep.face_colors[i]).all()
    assert cube([None] * 6).mesh(0.2).face_colors is None
    for ending, atol in (("ply", 0.005), ("glb", 0.003), ("obj", 0.005)):
        mesh.save(tmp_path / f"a.{ending}")
        again = bob.load_mesh(tmp_path / f"a.{ending}")
        assert len(again.triangles) == len(mesh.triangles)
        corner = again.colors[again.triangles]
        assert np.abs(corner - corner[:, :1]).max() < 1e-6  # no interpolation
        ours, theirs = (m[np.lexsort(np.round(m.T, 1))] for m in (mesh.face_colors, corner[:, 0]))
        np.testing.assert_allclose(ours, theirs, atol=atol)
    vertices = cube().mesh(0.2)
    both = bob.Mesh(vertices.vertices, vertices.triangles, colors=np.full_like(vertices.vertices, 0.5),
                    face_colors=vertices.face_colors)  # fmt: skip
    both.save(tmp_path / "b.glb")
    assert abs(bob.load_mesh(tmp_path / "b.glb").colors.max() - 0.5) < 0.003
    both.save(tmp_path / "b.stl")
    assert bob.load_mesh(tmp_path / "b.stl").colors is None


def test_scenes_join_the_colors_of_faces(brep):
    joined = bob.Scene([brep, bob.Instance(cube([None] * 6), material=bob.Material("#0f0")).translate((2, 0, 0))]).mesh(
        0.3
    )
    count = len(brep.mesh(0.3).triangles)
    assert np.array_equal(joined.face_colors[:count], brep.mesh(0.3).face_colors)
    assert (joined.face_colors[count:] == 1).all()
    assert (joined.colors[-1] == (0, 1, 0)).all()


def test_files_hold_the_colors(brep, tmp_path):
    bob.save_scene(brep, tmp_path / "a.bob")
    data = (tmp_path / "a.bob").read_bytes()
    header = json.loads(data[8 : 8 + int.from_bytes(data[:8], "little")])
    assert header["__metadata__"]["version"] == "2"
    again = bob.load(tmp_path / "a.bob").instances[0].shape
    assert again.digest == brep.digest
    assert np.array_equal(again.face_colors, brep.face_colors)
    bob.save_scene(again, tmp_path / "b.bob")
    assert (tmp_path / "b.bob").read_bytes() == data
    bob.save_scene(cube([None] * 6), tmp_path / "c.bob")
    assert b'"version":"1"' in (tmp_path / "c.bob").read_bytes()
    assert b"face_colors" not in (tmp_path / "c.bob").read_bytes()
    assert pickle.loads(pickle.dumps(brep)).digest == brep.digest
    assert cube().digest != cube(["#c34", *COLORS[1:]]).digest


@pytest.mark.parametrize(
    ("colors", "message"),
    [
        (np.ones((5, 3), np.float32), r"face_colors: expected shape \(6, 3\)"),
        (np.full((6, 3), 1.5, np.float32), r"faces\[0\].color: expected a number in \[0, 1\], got 1.5"),
        (np.full((6, 3), np.nan, np.float32), r"faces\[0\].color: expected"),
        (np.ones((6, 3)), "face_colors: expected float32, got float64"),
    ],
)
def test_wrong_colors_in_files_are_refused(brep, colors, message, tmp_path):
    tensors = {f"0.{name}": tensor for name, tensor in brep.tensors().items()} | {"0.face_colors": colors}
    material = {"color": [1, 1, 1], "ambient": 0.1, "diffuse": 0.7, "specular": 0.2, "shininess": 32}
    instance = {"shape": 0, "transform": np.eye(4).tolist(), "material": material, "name": None}
    (tmp_path / "a.bob").write_bytes(sealed(layout({"shapes": ["brep"], "instances": [instance]}, tensors, "2")))
    with pytest.raises(bob.InputError, match=rf"^a.bob: shapes\[0\]: {message}"):
        bob.load(tmp_path / "a.bob")


def test_breps_say_how_many_colors_they_have(brep):
    assert brep.describe()["colours"] == "6"
    assert "colours" not in cube([None] * 6).describe()
    assert Counter(map(tuple, brep.face_colors))[(1.0, 1.0, 1.0)] == 1
    np.testing.assert_allclose(brep.face_colors[0], from_srgb(np.array((0xCC, 0x33, 0x33)) / 255), rtol=1e-6)
