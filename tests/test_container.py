"""Scene files: saved scenes load unchanged, and damaged or odd files are refused."""

import json

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.adapters import container
from bobrossnet.adapters.container import layout, sealed

SIZE = (60, 80)
TRIANGLE = bob.Mesh([[0, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2]], [[1, 0.5, 0], [1, 0, 0], [0, 0, np.nan]])


def several():
    tree = bob.happy_tree()
    return bob.Scene(
        [
            bob.Instance(tree, name="tree “one”\n"),
            bob.Instance(tree, material=bob.Material("#3366cc", shininess=7.1)).rotate(1).translate((2, 1, 0.1)),
            bob.Instance(TRIANGLE, material=bob.Material((0.1, 0.2, 0.3), ambient=1 / 3)).scale((1, 2, 3)),
            TRIANGLE,
        ]
    )


def test_all_that_is_written_can_be_read(tmp_path, monkeypatch):
    file = tmp_path / "a.bob"
    monkeypatch.setattr("bobrossnet.tracing.scene.MAX_INSTANCES", 1000)
    monkeypatch.setattr(container, "MAX_INSTANCES", 1000)
    most = bob.Scene(bob.Instance(TRIANGLE).translate((i, 0, 0)) for i in range(1000))
    bob.save_scene(most, file)
    assert np.array_equal(bob.load(file).boxes, most.boxes)
    size = int.from_bytes(file.read_bytes()[:8], "little")
    monkeypatch.setattr(container, "MAX_INSTANCES", 999)
    with pytest.raises(bob.InputError, match=r"a.bob: instances: expected at most 999, got 1,000$"):
        bob.load(file)
    monkeypatch.setattr(container, "MAX_HEADER", size - 1)
    with pytest.raises(bob.InputError, match=rf"a.bob: expected at most {size - 1:,} bytes of places"):
        bob.load(file)
    with pytest.raises(bob.InputError, match=r"^scene: expected at most"):
        bob.save_scene(most, tmp_path / "b.bob")
    assert not (tmp_path / "b.bob").exists()


def test_scenes_of_too_many_instances_are_refused(tmp_path):
    file = tmp_path / "a.bob"
    file.write_bytes(sealed(layout({"shapes": [], "instances": [0] * 100_001}, {})))
    with pytest.raises(bob.InputError, match=r"^a.bob: instances: expected at most 100,000, got 100,001$"):
        bob.load(file)


def test_many_instances_are_written_and_read(tmp_path):
    file = tmp_path / "a.bob"
    scene = bob.Scene([bob.Instance(TRIANGLE, np.diag((1 + i / 3, 1, 1, 1))) for i in range(1000)] * 30)
    bob.save_scene(scene, file)
    again = bob.load(file)
    assert len(again.instances) == 30_000
    assert np.array_equal(again.boxes, scene.boxes)
    assert len({id(instance.material) for instance in again.instances}) == 1


def test_round_trip(tmp_path):
    scene = several()
    bob.save_scene(scene, tmp_path / "a.bob")
    again = bob.load(tmp_path / "a.bob")
    assert bob.trace(again, size=SIZE) == bob.trace(scene, size=SIZE)
    assert (again.radius, again.center.tolist()) == (scene.radius, scene.center.tolist())
    for ours, theirs in zip(scene.instances, again.instances, strict=True):
        assert (ours.name, ours.material) == (theirs.name, theirs.material)
        assert np.array_equal(ours.transform, theirs.transform)
        assert ours.shape.digest == theirs.shape.digest
    assert again.instances[0].shape is again.instances[1].shape


MATERIALS = [
    bob.Glass(),
    bob.Glass("#abc", ior=2.4, attenuation=(0.1, 0.5, 1), distance=0.25, roughness=0.1),
    bob.Glass(thin=True),
    bob.Material(clearcoat=0.5),
    bob.Material(metallic=1, clearcoat=1, clearcoat_roughness=0.1),
]


@pytest.mark.parametrize("material", MATERIALS)
def test_glass_and_clear_coats_round_trip(material, tmp_path):
    bob.save_scene(bob.Instance(TRIANGLE, material=material), tmp_path / "a.bob")
    (again,) = bob.load(tmp_path / "a.bob").instances
    assert again.material == material
    assert b'"version":"7"' in (tmp_path / "a.bob").read_bytes()


def test_equal_scenes_make_equal_files_that_hold_each_shape_once(tmp_path):
    copy = bob.Mesh(TRIANGLE.vertices, TRIANGLE.triangles, TRIANGLE.normals)
    for name, shape in (("a.bob", TRIANGLE), ("b.bob", copy)):
        bob.save_scene([bob.Instance(TRIANGLE), bob.Instance(shape).translate((1, 0, 0))], tmp_path / name)
    data = (tmp_path / "a.bob").read_bytes()
    assert data == (tmp_path / "b.bob").read_bytes()
    header = json.loads(data[8 : 8 + int.from_bytes(data[:8], "little")])
    assert sorted(header) == ["0.normals", "0.triangles", "0.vertices", "__metadata__"]


def test_files_are_safetensors_whose_tensors_are_aligned(tmp_path):
    from safetensors.numpy import load_file

    bob.save_scene(several(), tmp_path / "a.bob")
    tensors = load_file(tmp_path / "a.bob")
    assert np.array_equal(tensors["1.normals"], TRIANGLE.normals, equal_nan=True)
    data = (tmp_path / "a.bob").read_bytes()
    start = 8 + int.from_bytes(data[:8], "little")
    header = json.loads(data[8:start])
    del header["__metadata__"]
    for name, entry in header.items():
        assert (start + entry["data_offsets"][0]) % tensors[name].itemsize == 0


def test_scenes_load_beside_meshes(tmp_path):
    bob.save_scene(TRIANGLE, tmp_path / "a.BOB")
    (tmp_path / "b.obj").write_text("v 2 0 0\nv 2 1 0\nv 2 0 1\nf 1 2 3\n")
    scene = bob.load([tmp_path / "a.BOB", str(tmp_path / "b.obj"), TRIANGLE])
    assert [instance.name for instance in scene.instances] == [None, "b.obj", None]
    with pytest.raises(bob.InputError, match=r"^a.BOB: expected one of .ply"):
        bob.load_mesh(tmp_path / "a.BOB")


# ---- Damage ----------------------------------------------------------------------------------------------


def test_damaged_files_are_refused(tmp_path):
    """Any changed byte, any truncation, any appended data."""
    file = tmp_path / "a.bob"
    bob.save_scene([TRIANGLE, bob.Instance(TRIANGLE, name="x").translate((1, 0, 0))], file)
    whole = file.read_bytes()
    rng = np.random.default_rng(0)

    def refused(data):
        file.write_bytes(data)
        with pytest.raises(bob.InputError) as error:
            bob.load(file)
        assert str(error.value).startswith("a.bob: expected ")
        assert "\n" not in str(error.value)

    for at in range(len(whole)):
        refused(whole[:at] + bytes([whole[at] ^ 1 << rng.integers(8)]) + whole[at + 1 :])
        refused(whole[:at])
    for _ in range(500):
        data = np.frombuffer(whole, np.uint8).copy()
        places = rng.integers(len(data), size=rng.integers(1, 9))
        data[places] ^= rng.integers(1, 256, size=len(places), dtype=np.uint8)
        refused(data.tobytes() if data.tobytes() != whole else whole[1:])
    refused(whole + b"\0")
    refused(b"")
    file.write_bytes(whole)
    assert len(bob.load(file).instances) == 2


KINDS = ", ".join(container.KINDS)
MATERIAL = {"color": [1, 1, 1], "ambient": 0.1, "diffuse": 0.7, "specular": 0.2, "shininess": 32}
GLASS = {"color": [1, 1, 1], "roughness": 0, "emissive": [0, 0, 0], "transmission": 1, "ior": 1.5}
GLASS |= {"attenuation": [1, 1, 1], "distance": None, "thin": False}
INSTANCE = {"shape": 0, "transform": np.eye(4).tolist(), "material": MATERIAL, "name": None}
SCENE = {"shapes": ["mesh"], "instances": [INSTANCE]}
TENSORS = {f"0.{name}": tensor for name, tensor in TRIANGLE.tensors().items()}


def instance(**fields):
    return {**SCENE, "instances": [INSTANCE, {**INSTANCE, **fields}]}


def material(**fields):
    return instance(material={**MATERIAL, **fields})


def tensors(**fields):
    return {name: tensor for name, tensor in {**TENSORS, **fields}.items() if tensor is not None}


def test_the_file_that_the_next_test_spoils_is_whole(tmp_path):
    (tmp_path / "a.bob").write_bytes(sealed(layout(SCENE, TENSORS)))
    assert bob.trace(bob.load(tmp_path / "a.bob"), size=SIZE) == bob.trace(TRIANGLE, size=SIZE)


@pytest.mark.parametrize(
    ("scene", "arrays", "message"),
    [
        ([], TENSORS, "scene: expected an object of shapes, instances, got list"),
        ({"shapes": []}, TENSORS, "scene: expected an object of shapes, instances, got shapes"),
        ({**SCENE, "shapes": "mesh"}, TENSORS, "shapes: expected a list, got str"),
        ({**SCENE, "instances": {}}, TENSORS, "instances: expected a list, got dict"),
        ({**SCENE, "instances": []}, TENSORS, "shapes: expected at least one shape, got none"),
        ({**SCENE, "shapes": ["cloud"]}, TENSORS, f"shapes[0]: expected a kind among {KINDS}, got"),
        ({**SCENE, "shapes": [["mesh"]]}, TENSORS, f"shapes[0]: expected a kind among {KINDS}, got"),
        ({**SCENE, "shapes": []}, TENSORS, "0.normals: expected tensors of 0 shapes"),
        ({**SCENE, "instances": [3]}, TENSORS, "instances[0]: expected an object of shape, transform"),
        (instance(shape=1), TENSORS, "instances[1].shape: expected an integer in 0..0, got 1"),
        (instance(shape=-1), TENSORS, "instances[1].shape: expected an integer in 0..0, got -1"),
        (instance(shape="0"), TENSORS, "instances[1].shape: expected an integer, got str '0'"),
        (instance(extra=1), TENSORS, "instances[1]: expected an object of shape, transform, material, name, got"),
        (instance(name=3), TENSORS, "instances[1]: name: expected a string, got int"),
        (instance(transform=None), TENSORS, "instances[1].transform: expected a list, got NoneType"),
        (instance(transform=[1, 2]), TENSORS, "instances[1]: transform: expected shape (4, 4), got (2,)"),
        (instance(transform=[[1], [2, 3]]), TENSORS, "instances[1]: transform: expected an array of numbers"),
        (instance(transform=[["a"] * 4] * 4), TENSORS, "instances[1]: transform: expected an array of numbers"),
        (instance(transform=[[10**400] * 4] * 4), TENSORS, "instances[1]: transform: expected an array of numbers"),
        (instance(transform=np.zeros((4, 4)).tolist()), TENSORS, "instances[1]: transform: expected an affine map"),
        (instance(transform=np.diag([1, 1, 0, 1]).tolist()), TENSORS, "instances[1]: transform: expected a map that"),
        (instance(material=None), TENSORS, "instances[1].material: expected an object of color, ambient"),
        (material(color=[1, 1, 7]), TENSORS, "instances[1]: color: expected a number in [0, 1], got 7"),
        (material(color=3), TENSORS, "instances[1]: color: expected #rrggbb, a CSS name or 3 numbers, got 3"),
        (material(ambient=-1), TENSORS, "instances[1]: ambient: expected a number in [0, 1], got -1"),
        (material(shininess=10**400), TENSORS, "instances[1]: shininess: expected a number in [0, 10000], got inf"),
        (instance(material=GLASS | {"ior": 0.5}), TENSORS, "instances[1]: ior: expected a number in [1, 100], got 0.5"),
        (instance(material=GLASS | {"distance": 0}), TENSORS, "instances[1]: distance: expected a number"),
        (instance(material=GLASS | {"thin": 2}), TENSORS, "instances[1]: thin: expected true or false, got int 2"),
        (
            instance(material=GLASS | {"ambient": 0}),
            TENSORS,
            "instances[1].material: expected an object of color, rough",
        ),
        (material(gloss=1), TENSORS, "instances[1].material: expected an object of color"),
        (SCENE, tensors(**{"0.vertices": None}), "shapes[0]: vertices: expected an array of float64, got none"),
        (SCENE, tensors(**{"0.color": np.zeros(3)}), "shapes[0]: color: expected only vertices, triangles, normals"),
        (SCENE, tensors(**{"1.vertices": np.zeros(3)}), "1.vertices: expected tensors of 1 shapes"),
        (SCENE, tensors(vertices=np.zeros(3)), "vertices: expected tensors of 1 shapes"),
        (SCENE, tensors(**{"0.vertices": np.eye(3, dtype=np.float32)}), "shapes[0]: vertices: expected float64"),
        (SCENE, tensors(**{"0.vertices": np.full((3, 3), np.nan)}), "shapes[0]: vertices: expected finite numbers"),
        (SCENE, tensors(**{"0.vertices": np.zeros((3, 3))}), "shapes: expected an extent above zero"),
        (SCENE, tensors(**{"0.triangles": np.int32([[0, 1, 3]])}), "shapes[0]: triangles: expected indices in 0..2"),
        (SCENE, tensors(**{"0.triangles": np.zeros((0, 3), np.int32)}), "shapes[0]: triangles: expected at least one"),
        (SCENE, tensors(**{"0.normals": np.zeros((2, 3), np.float32)}), "shapes[0]: normals: expected shape (3, 3)"),
    ],
)
def test_what_no_scene_has_is_refused(scene, arrays, message, tmp_path):
    """Files with a valid checksum."""
    (tmp_path / "a.bob").write_bytes(sealed(layout(scene, arrays)))
    with pytest.raises(bob.InputError) as error:
        bob.load(tmp_path / "a.bob")
    assert str(error.value).startswith("a.bob: " + message)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        (
            b'"version":"1"',
            b'"version":"9"',
            "expected version 1, 2, 3, 4, 5, 6, 7 or 8, got '9'; was it written by a newer release?",
        ),
        (b'"bobrossnet-scene"', b'"bobrossnet-sauce"', "expected the format bobrossnet-scene, got 'bobrossnet-sauce'"),
        (b'"format":', b'"fermat":', "expected the format bobrossnet-scene, got None"),
        (b'"scene":', b'"score":', "expected JSON, got something else at line 1, column 1"),
        (b'"shapes', b'"shap[s', "scene: expected an object of shapes, instances, got shap[s, instances"),
        (b'"data_offsets":[0,72]', b'"data_offsets":[0,71]', "expected a safetensors file, got one that"),
        (b'"data_offsets":[0,72]', b'"data_offsets":[8,80]', "expected a safetensors file, got one that"),
        (b'"dtype":"F64"', b'"dtype":"U64"', "shapes[0]: vertices: expected float64, got uint64"),
        (b'"dtype":"F64"', b'"dtype":"X64"', "expected a safetensors file, got one that"),
    ],
)
def test_other_headers_are_refused(before, after, message, tmp_path):
    data = layout(SCENE, TENSORS)
    before = before if before in data else before.replace(b'"', b'\\"')
    after = after if before[0] == after[0] else after.replace(b'"', b'\\"')
    assert before in data
    (tmp_path / "a.bob").write_bytes(sealed(data.replace(before, after, 1)))
    with pytest.raises(bob.InputError) as error:
        bob.load(tmp_path / "a.bob")
    assert str(error.value).startswith("a.bob: " + message)


@pytest.mark.parametrize("scene", ["[" * 100_000, '"', "1" * 5000, "NaN", ""])
def test_odd_json_is_refused(scene, tmp_path, monkeypatch):
    monkeypatch.setattr(container.json, "dumps", lambda value, **_: scene if "shapes" in value else whole(value))
    whole = json.JSONEncoder(separators=(",", ":")).encode
    (tmp_path / "a.bob").write_bytes(sealed(layout(SCENE, TENSORS)))
    with pytest.raises(bob.InputError, match=r"^a.bob: (scene: )?expected"):
        bob.load(tmp_path / "a.bob")


# ---- Lights ----------------------------------------------------------------------------------------------

RED = np.linspace(0, 4, 8 * 16 * 3).reshape(8, 16, 3)
SUN = {"direction": [0, 0, 1], "angle": 2, "color": [1, 1, 1], "intensity": 1}
SKY = {"top": [1, 1, 1], "bottom": [1, 1, 1], "turn": 0, "intensity": 1}


@pytest.mark.parametrize(
    ("light", "ground", "version"),
    [
        (None, None, b"1"),
        ("headlight", None, b"1"),
        ("studio", False, b"1"),
        ([bob.Light((0.3, -1, 2), angle=0.5, color="#fff4e0"), bob.Sky("#89b", "#443", intensity=0.7)], True, b"1"),
        (bob.Sky(image=RED, turn=30, intensity=2), None, b"8"),
    ],
)
def test_lights_are_kept(light, ground, version, tmp_path):
    scene = bob.Scene(TRIANGLE, light=light, ground=ground)
    bob.save_scene(scene, tmp_path / "a.bob")
    again = bob.load(tmp_path / "a.bob")
    assert (again.light, again.ground) == (scene.light, scene.ground)
    bob.save_scene(again, tmp_path / "b.bob")
    data = (tmp_path / "a.bob").read_bytes()
    assert (tmp_path / "b.bob").read_bytes() == data
    assert b'"version":"' + version + b'"' in data
    assert (b'"light":' in data) == (light is not None)


ODD_LIGHTS = [
    ({"lights": []}, None, "light: expected an object of lights, ground"),
    ({"lights": [], "ground": "no"}, None, "light.ground: expected "),
    ({"lights": 5, "ground": None}, None, "light.lights: expected a list"),
    ({"lights": "sun.hdr", "ground": None}, None, "light.lights: expected a list"),
    ({"lights": None, "ground": 2}, None, "light.ground: expected "),
    ({"lights": ["sun"], "ground": None}, None, "light.lights[0]: expected an object of direction"),
    ({"lights": [{**SUN, "more": 1}], "ground": None}, None, "light.lights[0]: expected an object of direction"),
    (
        {"lights": [SUN, {**SUN, "direction": [0, 0, 2]}], "ground": None},
        None,
        "light.lights[1].direction: expected u",
    ),
    ({"lights": [{**SUN, "direction": [0, 1]}], "ground": None}, None, "light.lights[0].direction: expected "),
    ({"lights": [{**SUN, "direction": [0, 0, True]}], "ground": None}, None, "light.lights[0].direction: expected "),
    ({"lights": [{**SUN, "angle": 200}], "ground": None}, None, "light.lights[0].angle: expected "),
    ({"lights": [{**SUN, "color": [0, 2, 0]}], "ground": None}, None, "light.lights[0].color: expected "),
    ({"lights": [{**SUN, "intensity": -1}], "ground": None}, None, "light.lights[0].intensity: expected "),
    ({"lights": [{**SKY, "turn": 1e9}], "ground": None}, None, "light.lights[0].turn: expected "),
    ({"lights": [SKY, SKY], "ground": None}, None, "light: expected at most one Sky, got several"),
    ({"lights": [SUN] * 33, "ground": None}, None, "light: expected at most 32, got 33"),
    ({"lights": [SUN], "ground": None}, RED, "environment: expected a sky that has it"),
    ({"lights": "studio", "ground": None}, RED, "environment: expected float32, of a scene with a sky"),
    ({"lights": [SUN, {**SKY, "bottom": [0, 0, 0]}], "ground": None}, RED, "light.lights[1].bottom: expected top's"),
    ({"lights": [SKY], "ground": None}, -RED, "light.lights[0].image: expected "),
    ({"lights": [SKY], "ground": None}, np.full((2, 4, 3), np.nan), "light.lights[0].image: expected "),
    ({"lights": [SKY], "ground": None}, RED[0], "light.lights[0].image: expected shape (n, n, 3)"),
    ({"lights": [SKY], "ground": None}, RED[:0], "light.lights[0].image: expected an environment"),
]
"""Entries, environments, and the errors in Python."""


def with_light(light, image):
    arrays = TENSORS if image is None else {**TENSORS, "environment": np.asarray(image, np.float32)}
    return sealed(layout(SCENE, arrays, "1" if image is None else "8", {"light": light}))


@pytest.mark.parametrize(("light", "image", "message"), ODD_LIGHTS)
def test_odd_lights_are_refused(light, image, message, tmp_path):
    (tmp_path / "a.bob").write_bytes(with_light(light, image))
    with pytest.raises(bob.InputError) as error:
        bob.load(tmp_path / "a.bob")
    assert str(error.value).startswith("a.bob: " + message)
    assert "\n" not in str(error.value)


# ---- Writing ---------------------------------------------------------------------------------------------


class Cloud(bob.Mesh):
    kind = "cloud"


@pytest.mark.parametrize(
    ("scene", "path", "message"),
    [
        (TRIANGLE, "a.ply", "expected a scene's ending, .bob, got .ply"),
        (TRIANGLE, "a", "expected a scene's ending, .bob, got none"),
        (TRIANGLE, "no/such/folder.bob", "there is no folder"),
        ("a.ply", "a.bob", "a.ply: expected a file, found nothing at a.ply"),
        ([], "a.bob", "shapes: expected at least one shape, got none"),
        (Cloud(np.eye(3), [[0, 1, 2]]), "a.bob", f"shape: expected one of {KINDS} to write, got Cloud"),
    ],
)
def test_what_can_t_be_written(scene, path, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(bob.InputError) as error:
        bob.save_scene(scene, path)
    assert message in str(error.value)
    assert not list(tmp_path.iterdir())


# ---- Formulas --------------------------------------------------------------------------------------------

TANGLE = bob.implicit(lambda x, y, z: x**4 + y**4 + z**4 - 5 * (x * x + y * y + z * z) + 11.8)


def test_formulas_round_trip(tmp_path):
    scene = [bob.Instance(TANGLE, material=bob.Material("#8899aa")).rotate(0.5, (1, 0, 0)), bob.Instance(TRIANGLE)]
    bob.save_scene(scene, tmp_path / "a.bob")
    again = bob.load(tmp_path / "a.bob")
    assert bob.trace(again, size=SIZE) == bob.trace(scene, size=SIZE)
    assert [instance.shape.kind for instance in again.instances] == ["implicit", "mesh"]


def test_formulas_that_are_none_are_refused(tmp_path):
    """Random changes of a formula's arrays, in files with a valid checksum: a picture, or a one-line error."""
    rng = np.random.default_rng(0)
    scene = {**SCENE, "shapes": ["implicit"]}
    refused = 0
    for _ in range(60):
        arrays = {name: tensor.copy() for name, tensor in TANGLE.tensors().items()}
        name = rng.choice(list(arrays))
        if rng.random() < 0.3:
            arrays[name] = [arrays[name][:-1], arrays[name][None], arrays[name].astype(np.float32)][rng.integers(3)]
        else:
            content = arrays[name].reshape(-1).view(np.uint8)
            content[rng.integers(len(content))] ^= 1 << rng.integers(8)
        data = layout(scene, {f"0.{name}": tensor for name, tensor in arrays.items()})
        (tmp_path / "a.bob").write_bytes(sealed(data))
        try:
            bob.trace(bob.load(tmp_path / "a.bob"), size=(8, 8))
        except bob.InputError as error:
            refused += 1
            assert "\n" not in str(error)  # noqa: PT017
    assert refused > 15
