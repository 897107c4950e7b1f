"""Textures shared by several meshes: one picture in memory, in the budget of a file, in scene files and in copies."""

import base64
import copy
import io
import json
import pickle

import numpy as np
import pytest
from PIL import Image
from textures import OTHERS, PLACES, mesh, shared_scene, texels

import bobrossnet as bob

SIZE = (24, 24)


def pictures(scene):
    """Return the distinct pictures of its instances."""
    return {id(instance.shape.picture) for instance in scene.instances}


@pytest.mark.parametrize("channels", [3, 4])
def test_meshes_of_one_array_share_its_picture(channels):
    """In Python and in the core, where each further mesh takes less than the picture."""
    array = texels(channels=channels)
    meshes = [mesh(array, i, wrap=wrap) for i, wrap in enumerate(("repeat", "clamp", "mirror"))]
    meshes += [mesh(array, 3).turned_upright(), mesh(meshes[0].picture, 4)]
    assert len({id(each.picture) for each in meshes}) == 1
    assert np.array_equal(meshes[0].texture, array[..., :3])
    scenes = [bob.Scene(meshes), bob.Scene(meshes[:1])]
    for scene in scenes:
        bob.trace(scene, size=SIZE)
    more = scenes[0].core.bytes - scenes[1].core.bytes
    assert more < meshes[0].picture.core.bytes / 2
    assert scenes[1].core.bytes > meshes[0].picture.core.bytes > array.size


def test_an_array_that_changed_is_another_picture():
    array = texels()
    before = mesh(array)
    array[0, 0] += 1
    after = mesh(array)
    assert before.picture is not after.picture
    assert before.digest != after.digest
    assert np.array_equal(after.texture, array)
    assert mesh(array).picture is after.picture
    assert mesh(after.texture).picture is after.picture


def test_an_alpha_is_no_part_of_the_texels():
    with_alpha = mesh(texels(channels=4))
    plain = mesh(with_alpha.texture)
    assert plain.texture_alpha is None
    assert with_alpha.texture_alpha is not None
    assert with_alpha.digest != plain.digest


def test_pictures_go_when_no_mesh_has_them():
    """A new array at the same address is not mistaken for the old one."""
    for value in range(20):
        made = mesh(np.full((8, 8, 3), value, np.uint8))
        assert (made.texture == value).all()


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda scene: pickle.loads(pickle.dumps(scene))])
def test_copies_share_as_well(copied):
    array = texels(channels=4)
    scene = bob.Scene([mesh(array, i) for i in range(3)])
    again = copied(scene)
    assert len(pictures(again)) == 1
    assert bob.trace(again, size=SIZE) == bob.trace(scene, size=SIZE)
    assert not again.instances[0].shape.texture.flags.writeable


# ---- Scene files -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("channels", [3, 4])
def test_scene_files_hold_each_texture_once(channels, tmp_path):
    array, other = texels(channels=channels), texels(8, 8)
    scene = bob.Scene([*(mesh(array, i, wrap="clamp") for i in range(4)), mesh(other, 5), mesh(other.copy(), 6)])
    bob.save_scene(scene, tmp_path / "a.bob")
    assert (tmp_path / "a.bob").stat().st_size < 1.5 * array.size
    assert b'"version":"5"' in (tmp_path / "a.bob").read_bytes()
    again = bob.load(tmp_path / "a.bob")
    assert len(pictures(again)) == 2
    assert [i.shape.digest for i in again.instances] == [i.shape.digest for i in scene.instances]
    assert bob.trace(again, size=SIZE) == bob.trace(scene, size=SIZE)
    bob.save_scene(again, tmp_path / "b.bob")
    assert (tmp_path / "b.bob").read_bytes() == (tmp_path / "a.bob").read_bytes()
    bob.save_scene(mesh(array), tmp_path / "one.bob")
    assert f'"version":"{channels // 4 * 2 + 2}"'.encode() in (tmp_path / "one.bob").read_bytes()  # for older releases


def test_scene_files_have_a_budget_of_texels(tmp_path, monkeypatch):
    scene = [mesh(texels(4, 4), 0), mesh(texels(2, 2), 1)]
    bob.save_scene(scene, tmp_path / "a.bob")
    monkeypatch.setattr("bobrossnet.adapters.surface.MAX_FILE_TEXELS", 19)
    message = "expected textures of at most 19 texels in all, got more"
    with pytest.raises(bob.InputError, match=rf"^a\.bob: shapes\[1\]: {message}$"):
        bob.load(tmp_path / "a.bob")
    with pytest.raises(bob.InputError, match=rf"^scene: {message}$"):
        bob.save_scene(scene, tmp_path / "b.bob")
    shared = texels(4, 4)
    bob.save_scene([mesh(shared, i) for i in range(5)], tmp_path / "c.bob")
    assert len(bob.load(tmp_path / "c.bob").instances) == 5


WRONG = [
    (1, "texture_of: expected the number of an earlier shape with a texture, got 1"),
    (-1, "texture_of: expected the number of an earlier shape with a texture, got -1"),
    (2, "texture_of: expected the number of an earlier shape with a texture, got 2"),
]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        *(((number,), message) for number, message in WRONG),
        ((0, np.float32), "texture_of: expected int32, got float32"),
    ],
)
def test_textures_of_no_other_shape_are_refused(arguments, message, tmp_path):
    (tmp_path / "a.bob").write_bytes(shared_scene(*arguments))
    with pytest.raises(bob.InputError) as error:
        bob.load(tmp_path / "a.bob")
    assert str(error.value) == f"a.bob: shapes[1]: {message}"


@pytest.mark.parametrize("changes", OTHERS)
def test_shared_textures_are_as_the_other_shape_has_them(changes, tmp_path):
    (tmp_path / "a.bob").write_bytes(shared_scene(0, **changes))
    with pytest.raises(bob.InputError, match=r"^a\.bob: shapes\[1\]: "):
        bob.load(tmp_path / "a.bob")
    (tmp_path / "a.bob").write_bytes(shared_scene(0))
    assert len(pictures(bob.load(tmp_path / "a.bob"))) == 1


# ---- Files of meshes -------------------------------------------------------------------------------------


def png(array):
    file = io.BytesIO()
    Image.fromarray(array).save(file, "PNG")
    return file.getvalue()


def gltf(path, materials, array):
    """A triangle for each of the materials, all with one texture."""
    uri = "data:application/octet-stream;base64,"
    buffers = [np.eye(3, dtype=np.float32), PLACES.astype(np.float32)]
    laid = {"baseColorTexture": {"index": 0}}
    tree = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": uri + base64.b64encode(b).decode(), "byteLength": b.nbytes} for b in buffers],
        "bufferViews": [{"buffer": i, "byteLength": b.nbytes} for i, b in enumerate(buffers)],
        "accessors": [
            {"bufferView": i, "componentType": 5126, "count": 3, "type": f"VEC{b.shape[1]}"}
            for i, b in enumerate(buffers)
        ],
        "meshes": [
            {
                "primitives": [
                    {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": i} for i in range(len(materials))
                ]
            }
        ],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "materials": [
            {"pbrMetallicRoughness": laid | {"roughnessFactor": i / 100}} | m for i, m in enumerate(materials)
        ],
        "textures": [{"source": 0}],
        "images": [{"uri": uri + base64.b64encode(png(array)).decode()}],
    }
    path.write_text(json.dumps(tree))
    return path


def test_materials_share_a_picture(tmp_path, recwarn, monkeypatch):
    """Any number of them counts once."""
    array = texels()
    monkeypatch.setattr("bobrossnet.adapters.surface.MAX_FILE_TEXELS", array.size // 3)
    faces = "".join(f"usemtl {i}\nf 1/1 2/2 3/3\n" for i in range(20))
    points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{points}{faces}")
    (tmp_path / "a.mtl").write_text("".join(f"newmtl {i}\nmap_Kd a.png\nNs {i + 1}\n" for i in range(20)))
    (tmp_path / "a.png").write_bytes(png(array))
    for file in (tmp_path / "a.obj", gltf(tmp_path / "a.gltf", [{}] * 20, array)):
        scene = bob.load(file)
        assert len(scene.instances) == 20
        (picture,) = {instance.shape.picture for instance in scene.instances}
        assert np.array_equal(picture.texels, array)
        bob.trace(scene, size=SIZE)
        assert scene.core.bytes < 2 * picture.core.bytes
    assert not recwarn.list


def test_a_picture_with_and_without_its_alpha_counts_twice(tmp_path, monkeypatch):
    array, masked = texels(4, 4, 4), {"alphaMode": "MASK"}
    assert len(pictures(bob.load(gltf(tmp_path / "a.gltf", [masked, {}] * 3, array)))) == 2
    monkeypatch.setattr("bobrossnet.adapters.surface.MAX_FILE_TEXELS", 16)
    assert len(pictures(bob.load(gltf(tmp_path / "a.gltf", [masked] * 3, array)))) == 1
    assert len(pictures(bob.load(gltf(tmp_path / "a.gltf", [{}] * 3, array)))) == 1
    with pytest.warns(bob.InputWarning) as told:
        scene = bob.load(gltf(tmp_path / "a.gltf", [masked, {}] * 3, array))
    (warning,) = told
    assert str(warning.message) == (
        "a.gltf: texture 0 was left out: expected textures of at most 16 texels in all, got more"
    )
    assert sorted(instance.shape.picture is None for instance in scene.instances) == [False] * 3 + [True] * 3
