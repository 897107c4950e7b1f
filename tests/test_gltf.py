"""glTF as the core reads it: files whose right values are known, and all kinds of data that it may store."""

from __future__ import annotations

import base64
import io
import itertools
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gltf_cases import CASES, QUADRANTS, Case
from loaded import area_of, told
from numpy.typing import NDArray
from PIL import Image

import bobrossnet as bob
from bobrossnet.shapes.mesh import Mesh

FOLDER = Path(__file__).parent / "cases"
UPRIGHT = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # back to the axes of a glTF
COMPONENTS = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


def mesh_of(instance: bob.Instance) -> Mesh:
    assert isinstance(instance.shape, Mesh)
    return instance.shape


@pytest.mark.parametrize(("name", "case"), CASES.items(), ids=CASES)
def test_cases(name: str, case: Case) -> None:
    if case.error:
        with pytest.raises(bob.InputError) as refused:
            bob.load(FOLDER / name)
        assert case.error in str(refused.value)
        return
    scene, warned = told(FOLDER / name)
    assert warned == ([case.warning] if case.warning else [])
    meshes = [mesh_of(instance) for instance in scene.instances]
    assert sum(map(area_of, meshes)) == pytest.approx(case.area, rel=1e-4)
    for mesh, bounds in zip(meshes, case.bounds or [], strict=True):
        places = mesh.vertices @ UPRIGHT.T
        assert np.allclose([*places.min(axis=0), *places.max(axis=0)], bounds, atol=1e-3)
    first = meshes[0]
    if case.color == QUADRANTS:
        assert first.texture is not None
        assert first.uv is not None
        assert {tuple(place) for place in np.round(first.uv, 2)} == set(itertools.product((0, 1), repeat=2))
        assert len(np.unique(first.texture.reshape(-1, 3), axis=0)) == 4
    elif case.color == "gradient":
        assert first.texture is not None
        row = first.texture[0, :, 0].astype(int)
        assert row[0] < 8
        assert row[-1] > 247
        assert (np.diff(row) >= 0).all()
    elif case.color is not None:
        color = scene.instances[0].material.color if first.colors is None else first.colors[0]
        assert np.allclose(color, case.color, atol=1e-6)


def mesh_fields(name: str) -> list[dict[str, NDArray[Any] | None]]:
    """Return the arrays of each mesh of a case; each triangle starts at its smallest corner."""
    result = []
    for mesh in map(mesh_of, bob.load(FOLDER / name).instances):
        turns = mesh.triangles.argmin(axis=1)[:, None] + np.arange(3)
        triangles = np.take_along_axis(mesh.triangles, turns % 3, axis=1)
        result.append(
            {name: getattr(mesh, name) for name in ("vertices", "normals", "colors", "uv")} | {"triangles": triangles}
        )
    return result


def test_meshopt_data_of_every_mode_and_filter() -> None:
    """Both files were made by meshoptimizer's own encoder, from the same numbers; filters keep 12 bits of them or 8."""
    found, expected = (mesh_fields(f"meshopt/every-kind{which}.glb") for which in ("", "-uncompressed"))
    assert len(found) == len(expected) == 2
    for mesh, plain in zip(found, expected, strict=True):
        assert plain["colors"] is not None
        for name, values in plain.items():
            if values is None:
                assert mesh[name] is None
            else:
                assert np.allclose(mesh[name], values, atol={"triangles": 0, "colors": 6e-3}.get(name, 2e-3)), name
    assert expected[0]["uv"] is not None


def test_draco_meshes_of_every_kind() -> None:
    """Both files were made from the same numbers, one by Google's encoder, which changes the order of points."""
    found, expected = (mesh_fields(f"draco/every-kind{which}.glb") for which in ("", "-uncompressed"))
    assert len(found) == len(expected) == 2
    for mesh, plain in zip(found, expected, strict=True):
        rows = [
            np.hstack([values[name] for name in ("vertices", "normals", "colors", "uv") if values[name] is not None])
            for values in (mesh, plain)
        ]
        distances = np.abs(rows[0][:, None] - rows[1]).max(axis=2)
        assert distances.min(axis=1).max() < 3e-3
        assert distances.min(axis=0).max() < 3e-3
        assert len(mesh["triangles"]) == len(plain["triangles"])


def test_maps_of_metal_and_roughness_are_shown_by_their_means() -> None:
    mapped, plain = (bob.load(FOLDER / f"metal-map/plastic-by-{how}.glb").instances[0] for how in ("map", "factors"))
    assert mapped.material.metallic == plain.material.metallic == 0
    assert mapped.material.roughness == pytest.approx(plain.material.roughness, abs=1 / 255)


# ---- Data ------------------------------------------------------------------------------------------------

POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float64)
CORNERS = np.array([0, 1, 2, 0, 2, 3])


class Gltf:
    """A square in the plane x, y, with whatever else is asked of it."""

    def __init__(self, points: NDArray[Any] | None = None, **attributes: NDArray[Any] | int) -> None:
        self.buffers: list[bytes] = []
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        position = self.add(POINTS.astype("<f4") if points is None else points)
        added = {name: each if isinstance(each, int) else self.add(each) for name, each in attributes.items()}
        self.primitive: dict[str, Any] = {"attributes": {"POSITION": position, **added}}
        self.primitive["indices"] = self.add(CORNERS.astype("<u2"))
        self.node: dict[str, Any] = {"mesh": 0}
        self.mesh: dict[str, Any] = {"primitives": [self.primitive]}
        self.more: dict[str, Any] = {}

    def view(self, data: bytes, **more: Any) -> int:
        self.buffers.append(data)
        self.views.append({"buffer": len(self.buffers) - 1, "byteLength": len(data), **more})
        return len(self.views) - 1

    def add(self, array: NDArray[Any], *, normalized: bool = False, stride: int | None = None, **more: Any) -> int:
        rows = array.reshape(len(array), -1)
        data = rows.tobytes()
        if stride is not None:
            size = rows.itemsize * rows.shape[1]
            data = b"".join(row.tobytes() + b"\xff" * (stride - size) for row in rows)
        view = self.view(data, **({} if stride is None else {"byteStride": stride}))
        self.accessors.append(
            {
                "bufferView": view,
                "componentType": COMPONENTS[str(array.dtype)],
                "count": len(array),
                "type": TYPES[rows.shape[1]],
                "normalized": normalized,
                **more,
            }
        )
        return len(self.accessors) - 1

    def saved(self, folder: Path) -> Path:
        tree = {
            "asset": {"version": "2.0"},
            "buffers": [
                {"uri": "data:;base64," + base64.b64encode(data).decode(), "byteLength": len(data)}
                for data in self.buffers
            ],
            "bufferViews": self.views,
            "accessors": self.accessors,
            "meshes": [self.mesh],
            "nodes": [self.node],
            "scenes": [{"nodes": [0]}],
        }
        file = folder / "a.gltf"
        file.write_text(json.dumps(tree | self.more))
        return file

    def loaded(self, folder: Path) -> Mesh:
        return mesh_of(bob.load(self.saved(folder)).instances[0])


def places(mesh: Mesh) -> list[list[float]]:
    found: list[list[float]] = np.round(mesh.vertices @ UPRIGHT.T, 6).tolist()
    return found


@pytest.mark.parametrize("stride", [None, 16])
@pytest.mark.parametrize("normalized", [False, True])
@pytest.mark.parametrize("kind", ["int8", "uint8", "int16", "uint16"])
def test_points_of_integers(kind: str, normalized: bool, stride: int | None, tmp_path: Path) -> None:
    """Those that are not normalized are numbers as they are."""
    largest = np.iinfo(kind).max
    made = Gltf()
    scaled = (POINTS * largest).astype(kind)
    if np.iinfo(kind).min < 0:
        scaled[1, 0] = np.iinfo(kind).min  # which is -1 as well
    made.primitive["attributes"]["POSITION"] = made.add(scaled, normalized=normalized, stride=stride)
    expected = np.maximum(scaled / largest, -1) if normalized else scaled.astype(float)
    assert np.allclose(places(made.loaded(tmp_path)), expected, atol=1e-6)


@pytest.mark.parametrize("kind", ["uint8", "uint16", "uint32"])
def test_corners_of_integers(kind: str, tmp_path: Path) -> None:
    made = Gltf()
    made.primitive["indices"] = made.add(CORNERS.astype(kind))
    assert area_of(made.loaded(tmp_path)) == 1


@pytest.mark.parametrize("kind", ["uint8", "uint16", "uint32"])
@pytest.mark.parametrize("has_view", [True, False])
def test_sparse_points(has_view: bool, kind: str, tmp_path: Path) -> None:
    """They replace some; without a view, the others are zeros. Next to them is a square, since zeros have no area."""
    made = Gltf()
    moved = np.array([[1, 0, 5], [0, 1, 5]], "<f4")
    sparse = {
        "count": 2,
        "indices": {
            "bufferView": made.view(np.array([1, 3]).astype(kind).tobytes()),
            "componentType": COMPONENTS[kind],
        },
        "values": {"bufferView": made.view(moved.tobytes())},
    }
    accessor = made.accessors[0]
    accessor["sparse"] = sparse
    if not has_view:
        del accessor["bufferView"]
    made.add(POINTS.astype("<f4"))
    made.mesh["primitives"].append({"attributes": {"POSITION": len(made.accessors) - 1}, "indices": 1})
    expected = POINTS.copy() if has_view else np.zeros((4, 3))
    expected[[1, 3]] = moved
    mesh = made.loaded(tmp_path)
    assert np.allclose(places(mesh)[:4], expected)


def test_sparse_data_beyond_the_others_are_refused(tmp_path: Path) -> None:
    made = Gltf()
    made.accessors[0]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": made.view(b"\x04"), "componentType": 5121},
        "values": {"bufferView": made.view(bytes(12))},
    }
    with pytest.raises(bob.InputError, match=r"^a\.gltf: meshes\[0\]: sparse: expected indices below 4, got 4$"):
        made.loaded(tmp_path)
    made.accessors[0]["sparse"]["count"] = 2
    with pytest.raises(bob.InputError, match=r"accessors\[0\]: sparse: expected 2 bytes in its view, got 1$"):
        made.loaded(tmp_path)


@pytest.mark.parametrize(
    ("mode", "corners", "area"),
    [(4, [0, 1, 2, 0, 2, 3, 1], 1), (5, [0, 1, 3, 2], 1), (5, [0, 1, 3, 3, 2], 0.5), (6, [0, 1, 2, 3], 1)],
)
def test_triangles_of_all_modes(mode: int, corners: list[int], area: float, tmp_path: Path) -> None:
    """All of them face the same side."""
    made = Gltf()
    made.primitive |= {"mode": mode, "indices": made.add(np.array(corners, "<u2"))}
    mesh = made.loaded(tmp_path)
    a, b, c = (mesh.vertices[mesh.triangles[:, corner]] @ UPRIGHT.T for corner in range(3))
    normals = np.cross(b - a, c - a)
    assert (normals[:, 2] > 0).all() or len(corners) == 5
    assert np.abs(normals).sum() / 2 == area


def test_what_is_no_surface_is_named_in_one_warning(tmp_path: Path) -> None:
    made = Gltf()
    more = [made.primitive | {"mode": mode} for mode in range(4)]
    made.mesh["primitives"] += more
    made.primitive["material"] = 0
    extensions = {"KHR_materials_sheen": {}, "KHR_materials_unlit": {}}
    made.more = {
        "materials": [{"normalTexture": {"index": 0}, "occlusionTexture": {"index": 0}, "extensions": extensions}],
        "animations": [{}],
        "scenes": [{"nodes": [0]}, {"nodes": []}],
    }
    made.node["extensions"] = {"KHR_lights_punctual": {"light": 0}}
    scene, warned = told(made.saved(tmp_path))
    assert scene.counts()["triangle"] == 2
    assert warned == [
        "a.gltf: not shown: KHR_lights_punctual, KHR_materials_sheen, KHR_materials_unlit, animations, lines, "
        "normal maps, occlusion maps, other scenes, points"
    ]


@pytest.mark.parametrize(
    ("colors", "normalized"),
    [
        (np.array([[255, 0, 51, 0]] * 4, np.uint8), True),
        (np.array([[65535, 0, 13107]] * 4, "<u2"), True),
        (np.array([[1, 0, 0.2]] * 4, "<f4"), False),
    ],
)
def test_colors_of_vertices(colors: NDArray[Any], normalized: bool, tmp_path: Path) -> None:
    made = Gltf()
    made.primitive["attributes"]["COLOR_0"] = made.add(colors, normalized=normalized)
    mesh = made.loaded(tmp_path)
    assert mesh.colors is not None
    assert np.allclose(mesh.colors, (1, 0, 0.2), atol=1e-6)


def test_morph_targets(tmp_path: Path) -> None:
    """By the weights of the node, or else of the mesh."""
    made = Gltf()
    up, far = (made.add(np.tile(np.array(to, "<f4"), (4, 1))) for to in ([0, 0, 1], [8, 0, 0]))
    made.primitive["targets"] = [{"POSITION": up}, {"POSITION": far}]
    assert places(made.loaded(tmp_path)) == POINTS.tolist()
    made.mesh["weights"] = [0.5, 0]
    assert places(made.loaded(tmp_path)) == (POINTS + (0, 0, 0.5)).tolist()
    made.node["weights"] = [2, 1]
    assert places(made.loaded(tmp_path)) == (POINTS + (8, 0, 2)).tolist()


def test_morphed_colors_are_clamped(tmp_path: Path) -> None:
    made = Gltf(COLOR_0=np.array([[0.5, 0, 0.2]] * 4, "<f4"))
    changes = made.add(np.array([[-0.25, 2, 0.1]] * 4, "<f4"))
    made.primitive["targets"] = [{"COLOR_0": changes}]
    made.mesh["weights"] = [1]
    mesh = made.loaded(tmp_path)
    assert mesh.colors is not None
    assert np.allclose(mesh.colors, (0.25, 1, 0.3), atol=1e-6)
    made.primitive["targets"] = [{"COLOR_0": made.add(np.zeros((4, 4), "<f4"))}]
    with pytest.raises(bob.InputError, match="targets: expected a vector of type VEC3 for each vertex, got others"):
        made.loaded(tmp_path)


def test_morphed_texture_coordinates_are_transformed(tmp_path: Path) -> None:
    file = io.BytesIO()
    Image.new("RGB", (2, 2)).save(file, "png")
    made = Gltf(TEXCOORD_0=np.zeros((4, 2), "<f4"))
    made.primitive |= {"material": 0, "targets": [{"TEXCOORD_0": made.add(np.array([[0.5, 0.25]] * 4, "<f4"))}]}
    made.mesh["weights"] = [1]
    texture: dict[str, Any] = {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 1]}}}
    made.more = {
        "images": [{"uri": "data:image/png;base64," + base64.b64encode(file.getvalue()).decode()}],
        "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": texture}}],
    }
    uv = made.loaded(tmp_path).uv
    assert uv is not None
    assert np.allclose(uv, (1, 0.25))

    texture["texCoord"] = 3
    with pytest.warns(bob.InputWarning, match=r"not shown: textures without TEXCOORD_3$"):
        assert made.loaded(tmp_path).uv is None


def test_skins(tmp_path: Path) -> None:
    """Joints move vertices by their weights. The place of the node itself does not matter."""
    joints = np.array([[0, 1, 0, 0]] * 4, np.uint8)
    weights = np.array([[1, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0.5, 0.5, 0, 0]], "<f4")
    made = Gltf(JOINTS_0=joints, WEIGHTS_0=weights)
    made.node |= {"skin": 0, "translation": [100, 0, 0]}
    inverse = np.array([np.eye(4), np.eye(4)])
    inverse[1, 3, :3] = [0, -1, 0]  # columns come first
    made.more = {
        "nodes": [
            made.node,
            {"children": [2], "translation": [0, 0, 1]},
            {"children": [3]},
            {"translation": [0, 3, 0]},
        ],
        "scenes": [{"nodes": [0, 1]}],
        "skins": [{"joints": [2, 3], "inverseBindMatrices": made.add(inverse.astype("<f4"))}],
    }
    assert places(made.loaded(tmp_path)) == [[0, 0, 1], [1, 0, 1], [1, 3, 1], [0, 2, 1]]


def test_joints_that_are_missing_leave_out_what_they_hold(tmp_path: Path) -> None:
    weights = np.array([[1, 0, 0, 0]] * 4, "<f4")
    made = Gltf(JOINTS_0=np.array([[0] * 4, [7, 0, 0, 0], [0] * 4, [0] * 4], "<u2"), WEIGHTS_0=weights)
    made.node["skin"] = 0
    made.more = {"skins": [{"joints": [0]}]}
    scene, warned = told(made.saved(tmp_path))
    assert scene.counts()["triangle"] == 1
    assert warned == ["a.gltf: left out 1 of 2 triangles that touch a missing or non-finite vertex"]


def test_instances_may_be_turned_by_normalized_integers(tmp_path: Path) -> None:
    made = Gltf()
    half = np.rint(np.sqrt(0.5) * 32767)
    turns = np.array([[0, 0, 0, 32767], [0, 0, half, half]]).astype("<i2")  # by a quarter about z
    shifts = np.array([[0, 0, 0], [5, 0, 0]], "<f4")
    attributes = {"TRANSLATION": made.add(shifts), "ROTATION": made.add(turns, normalized=True)}
    made.node["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    found = np.array(places(made.loaded(tmp_path)))
    assert np.allclose(found[4:], POINTS[:, [1, 0, 2]] * (-1, 1, 1) + (5, 0, 0), atol=1e-4)


def test_colors_of_instances_are_named(tmp_path: Path) -> None:
    made = Gltf()
    colors = {"_COLOR_0": made.add(np.eye(3, dtype="<f4")), "TRANSLATION": made.add(np.eye(3, dtype="<f4"))}
    made.node["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": colors}}
    scene, warned = told(made.saved(tmp_path))
    assert scene.counts()["triangle"] == 6
    assert warned == ["a.gltf: not shown: colours of instances"]


def test_a_file_of_lines_is_refused_by_their_name(tmp_path: Path) -> None:
    made = Gltf()
    made.primitive["mode"] = 3
    with pytest.raises(bob.InputError, match=r"a.gltf: expected triangles, got none; not shown: lines$"):
        bob.load(made.saved(tmp_path))


def test_hidden_nodes_hide_what_hangs_on_them(tmp_path: Path) -> None:
    made = Gltf()
    hidden = {"children": [2], "extensions": {"KHR_node_visibility": {"visible": False}}}
    made.more = {
        "nodes": [made.node, hidden, {"mesh": 0}],
        "scenes": [{"nodes": [0, 1]}],
        "extensionsRequired": ["KHR_node_visibility"],
    }
    assert len(made.loaded(tmp_path).triangles) == 2


@pytest.mark.parametrize("extension", ["EXT_texture_webp", "EXT_texture_avif", "KHR_texture_basisu"])
def test_textures_of_extensions(extension: str, tmp_path: Path) -> None:
    """WebP and AVIF are decoded; a container of other formats is named in one warning."""
    kind, file = extension.split("_")[-1], io.BytesIO()
    if kind != "basisu":
        Image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(file, kind, quality=100)
    made = Gltf(TEXCOORD_0=POINTS[:, :2].astype("<f4"))
    made.primitive["material"] = 0
    made.more = {
        "images": [{"uri": "data:;base64," + base64.b64encode(file.getvalue()).decode()}],
        "textures": [{"extensions": {extension: {"source": 0}}}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "extensionsRequired": [extension],
    }
    scene, warned = told(made.saved(tmp_path))
    texture = mesh_of(scene.instances[0]).texture
    if kind == "basisu":
        assert warned == [
            "a.gltf: texture 0 was left out: expected a picture in PNG, JPEG, WebP or AVIF, got KHR_texture_basisu"
        ]
        assert texture is None
    else:
        assert warned == []
        assert texture is not None
        assert np.abs(texture.astype(int) - 200).max() <= 2


@pytest.mark.measures
@pytest.mark.parametrize("size", [50_000, 100_000])
def test_many_nodes_take_little_time(size: int, tmp_path: Path) -> None:
    made = Gltf()
    made.more = {
        "nodes": [{"mesh": 0, "translation": [i, 0, 0]} for i in range(size)],
        "scenes": [{"nodes": [*range(size)]}],
    }
    file = made.saved(tmp_path)
    start = time.thread_time()
    assert bob.load(file).counts()["triangle"] == 2 * size
    assert time.thread_time() - start < 5  # 0.3 s


@pytest.mark.parametrize(
    "text", ['{"a": 1', '{"a": NaN}', '{"a": 01}', "[", '{"a": "\\ud800"}', "", "[" * 100_000, "3"]
)
def test_other_texts_are_refused_in_a_line(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.gltf").write_text(text)
    with pytest.raises(bob.InputError, match=r"^a\.gltf: expected [^\n]+$"):
        bob.load(tmp_path / "a.gltf")
