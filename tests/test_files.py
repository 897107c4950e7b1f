"""Mesh files: the files that load, the resulting shapes, and the one line that explains a refusal."""

from __future__ import annotations

import base64
import json
import math
import os
import re
import struct
import subprocess
import sys
import time
import warnings
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from clocks import SLOWER, least
from models import MODELS, needs_models

from bobrossnet.adapters import beside
from bobrossnet.adapters.files import MESH_ENDINGS, load, load_mesh
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.support.errors import InputError, InputTypeError, InputWarning

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def error_of(path: str | os.PathLike[str]) -> str:
    """Return the error's message, after the checks that every message must pass."""
    with pytest.raises(InputError) as caught:
        load_mesh(path)
    message = str(caught.value)
    assert message.isprintable()
    assert len(message) < 600
    assert message.startswith(Path(path).name + ": ")
    assert ": expected " in message
    return message


def written(path: Path, content: str | bytes) -> Path:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def normal_of(mesh: Mesh, triangle: int = 0) -> list[float]:
    a, b, c = mesh.vertices[mesh.triangles[triangle]]
    cross = np.cross(b - a, c - a)
    unit: list[float] = np.round(cross / np.linalg.norm(cross), 6).tolist()
    return unit


# ---- The shared models -----------------------------------------------------------------------------------

# A number of triangles that load, or a part of the error line.
BROKEN_ODD: dict[str, int | str] = {
    "BoxWithInfinites.glb": "expected triangles, got 12 that all touch a missing or non-finite vertex",
    "Generic_Twin_7081.1.t0_right.obj": 11656,
    "OutOfMemory.off": "expected counts of vertices and faces that the file can hold",
    "RecursiveNodes.gltf": "expected nodes that form a tree",
    "bad-stl-pcbvicebar.stl": 260,
    "bad-stl-tardis.stl": 3636,
    "bunny_poly.ply": 2478,
    "busted.STL": 3878,
    "crash-30d6d0f7.ply": "expected a PLY header that ends in end_header",
    "cube_with_fold.ply": 48,
    "deg_faces.obj": 4,
    "degenerate_mesh.obj": "expected triangles with an area, got 1 of zero area",
    "degenerated.obj": 24,
    "drill_range_scan.ply": "expected triangles, got a point cloud of 4,223 points",
    "empty.obj": "expected triangles, got none",
    "empty.stl": "expected triangles, got none",
    "eof_test.obj": 1,
    "float_inf_point_cloud.ply": "expected triangles, got a point cloud of 16 points",
    "hourglass_ico.obj": 40,
    "igea_tristrips.ply": 268_686,
    "inf_nan.obj": "expected triangles, got 1 that all touch a missing or non-finite vertex",
    "invalid-face-definition.obj": "expected triangles, got a point cloud of 8 points",
    "invalid_assimp.off": "expected 4 faces, but the file ends before them",
    "invalidvertex.stl": "expected facets of three vertices",
    "issue-140-zero-face-idx.obj": 1,  # the other one has the vertex 0, and OBJ counts from 1
    "issue1580-zero-area-triangle.stl": 14,
    "joined_tetrahedra.obj": 8,
    "malformed.obj": 9,  # 3 of 12 have a vertex 12 of 8, or 0
    "malformed_property_index_oob.3mf": 1,
    "nancolor.obj": 12,
    "non_manifold_wrap.obj": 12,
    "nonmanifold.stl": 11,
    "notenoughindices.obj": 1,
    "openscad-nonmanifold-crash.obj": 1442,
    "ply_empty_bin.ply": "expected triangles, got none",
    "points_ascii_with_lists.ply": "expected triangles, got a point cloud of 5 points",
    "points_emptyface.ply": "expected triangles, got a point cloud of 1,024 points",
    "polygonfaces.obj": 3,
    "self_intersectA.obj": 17160,
    "sliver_tet.ply": 4,
    "toomanyvertices.stl": "expected facets of three vertices",
    "triangle_with_empty_solid.stl": 1,
    "triple_vierbein.obj": 108,
    "unparseable.stl": "expected facets of three vertices",
}
LEAVES_OUT = {"issue-140-zero-face-idx.obj": "1 of 2", "malformed.obj": "3 of 12"}

# Triangles, and whether the file stores normals.
ORIGINALS: dict[str, tuple[int, bool]] = {
    "3mf/box.3mf": (12, False),
    "3mf/counterXP.3MF": (83_750, False),
    "3mf/cube_and_sphere_same_name.3mf": (5132, False),
    "glb_cornell/CornellBox.glb": (36, True),
    "glb_interleaved/BoxInterleaved.glb": (12, True),
    "glb_material/BoxTextured.glb": (12, True),
    "glb_material/CesiumMilkTruck.glb": (3624, True),
    "glb_material/Duck.glb": (4212, True),
    "glb_material/cubevc.glb": (48, True),
    "glb_nested/nested.glb": (36, True),
    "gltf_draco/firetruck.gltf": (2428, True),
    "gltf_external/coffin_decorated.gltf": (2064, True),
    "obj_mtl_cornell/CornellBox-Original.obj": (36, False),
    "obj_mtl_fuze/fuze.obj": (1000, True),
    "obj_mtl_spider/spider.obj": (1368, True),
    "obj_negative_indices/negative_indices.obj": (12, True),
    "obj_polygons/dodecahedron_poly.obj": (36, False),
    "obj_quads/horse_quad.obj": (4796, False),
    "obj_suzanne_original/suzanne.obj": (968, True),
    "obj_vertex_colour/cube_with_vertexcolors.obj": (12, True),
    "off_comments/comments.off": (12, False),
    "off_quads/fandisk_quads.off": (1528, False),
    "off_whitespace/whitespace.off": (12, False),
    "ply_ascii/fuze_ascii.ply": (1000, False),
    "ply_uv/cube_blender_uv.ply": (12, True),
    "ply_vertex_attributes/bunny_attribute_color.ply": (12_000, True),
    "stl_ascii/Spider_ascii.stl": (1368, False),
    "stl_binary/angle_block.STL": (704, False),
}
NOT_READ = {
    "dae/duck.dae": "expected one of .ply .obj .stl .off .glb .gltf .3mf, got .dae",
    "3dxml/cube1.3dxml": "got .3dxml",
}


@needs_models
def test_the_table_lists_the_broken_and_odd_files() -> None:
    assert sorted(BROKEN_ODD) == sorted(file.name for file in (MODELS / "broken_odd").iterdir())


@needs_models
@pytest.mark.parametrize("name", BROKEN_ODD)
@pytest.mark.filterwarnings("ignore::bobrossnet.support.errors.InputWarning")
def test_broken_and_odd(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    start = time.thread_time()
    expected = BROKEN_ODD[name]
    if isinstance(expected, str):
        assert expected in error_of(MODELS / "broken_odd" / name)
    else:
        assert len(load_mesh(MODELS / "broken_odd" / name).triangles) == expected
    assert time.thread_time() - start < 5  # 0.2 s for the largest; nothing may hang
    assert capfd.readouterr() == ("", "")


@needs_models
@pytest.mark.parametrize("name", LEAVES_OUT)
def test_what_is_left_out_is_counted(name: str) -> None:
    with pytest.warns(InputWarning) as told:
        load_mesh(MODELS / "broken_odd" / name)
    assert f"{name}: left out {LEAVES_OUT[name]} triangles" in str(told[-1].message)


@needs_models
@pytest.mark.parametrize("name", ORIGINALS)
@pytest.mark.filterwarnings(r"ignore:(spider.obj|fuze_ascii.ply). texture .* was left out")  # they have no such file
@pytest.mark.filterwarnings("ignore:.*not shown")
def test_originals(name: str) -> None:
    mesh = load_mesh(MODELS / "loader_originals" / name)
    assert (len(mesh.triangles), mesh.normals is not None) == ORIGINALS[name]
    if mesh.normals is not None:
        length = np.linalg.norm(mesh.normals, axis=1)
        assert (length > 0).mean() > 0.95  # the spider's file has some without length
        assert np.allclose(length[length > 0], 1, atol=1e-6)  # float32
        # Stored normals point out of the faces around them; few differ, at folds.
        a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
        cosine = np.einsum("ij,ij->i", np.cross(b - a, c - a), mesh.normals[mesh.triangles[:, 0]])
        assert np.mean(cosine >= 0) > 0.95


@needs_models
@pytest.mark.parametrize("name", NOT_READ)
def test_originals_that_are_not_read(name: str) -> None:
    assert NOT_READ[name] in error_of(MODELS / "loader_originals" / name)


@needs_models
def test_a_duck_in_glb_stands_upright() -> None:
    mesh = load_mesh(MODELS / "loader_originals" / "glb_material" / "Duck.glb")
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    assert low[2] == pytest.approx(0.0993, abs=1e-3)  # the file's y: it floats just above the ground
    assert high[2] == pytest.approx(1.64, abs=1e-2)


# ---- Files that can't be opened --------------------------------------------------------------------------


def test_what_is_no_file(tmp_path: Path) -> None:
    assert "found nothing at" in error_of(tmp_path / "missing.ply")
    (tmp_path / "folder.ply").mkdir()
    assert "got a folder" in error_of(tmp_path / "folder.ply")
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.ply")  # reading it would wait for ever
        assert "got a device" in error_of(tmp_path / "pipe.ply")
    with pytest.raises(InputTypeError, match="path: expected a file name, got int"):
        load_mesh(5)  # type: ignore[arg-type]


def test_a_name_can_be_anything(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        load_mesh(tmp_path / "two\nlines.obj")
    assert str(caught.value).startswith("two lines.obj: expected a file, found nothing")
    with pytest.raises(InputError, match=r"^nul \.ply: expected a file"):
        load_mesh("nul\0.ply")
    with pytest.raises(InputError, match="expected a file"):
        load_mesh("long" * 1000 + ".ply")


def test_endings(tmp_path: Path) -> None:
    known = " ".join(MESH_ENDINGS)
    assert error_of(written(tmp_path / "a.dwg", "x")).endswith(f"expected one of {known}, got .dwg")
    assert error_of(written(tmp_path / "bunny", "x")).endswith("got no ending")
    upper = written(tmp_path / "A.OBJ", SQUARE + "f 1 2 3 4")
    assert len(load_mesh(str(upper)).triangles) == 2


@pytest.mark.parametrize("ending", MESH_ENDINGS)
def test_nothing_and_nonsense(ending: str, tmp_path: Path) -> None:
    assert error_of(written(tmp_path / f"a{ending}", "")).endswith("expected a mesh, got an empty file")
    error_of(written(tmp_path / f"b{ending}", "\n\n"))
    for seed in range(20):
        noise = np.random.default_rng(seed).bytes(300)
        error_of(written(tmp_path / f"noise{seed}{ending}", noise))
    error_of(written(tmp_path / f"deep{ending}", "[" * 100_000))


@needs_models
@pytest.mark.filterwarnings("ignore::bobrossnet.support.errors.InputWarning")
@pytest.mark.parametrize(
    "name",
    [
        "ply_uv/cube_blender_uv.ply",
        "stl_binary/angle_block.STL",
        "3mf/box.3mf",
        "glb_interleaved/BoxInterleaved.glb",
        "off_whitespace/whitespace.off",
        "obj_negative_indices/negative_indices.obj",
    ],
)
def test_damaged_files_load_or_say_why(name: str, tmp_path: Path) -> None:
    whole = (MODELS / "loader_originals" / name).read_bytes()
    rng = np.random.default_rng(0)
    for number in range(60):
        data = bytearray(whole[: rng.integers(1, len(whole))] if number % 2 else whole)
        for at in rng.integers(0, len(data), 3):
            data[at] = rng.integers(0, 256)
        file = written(tmp_path / f"{number}{Path(name).suffix}", bytes(data))
        try:
            assert len(load_mesh(file).triangles) > 0
        except InputError as error:
            assert str(error).isprintable()  # noqa: PT017


def test_interrupts_pass(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(self: Path) -> bytes:
        raise KeyboardInterrupt

    def exhaust(self: Path) -> bytes:
        raise MemoryError

    file = written(tmp_path / "a.obj", SQUARE)
    monkeypatch.setattr(Path, "read_bytes", interrupt)
    with pytest.raises(KeyboardInterrupt):
        load_mesh(file)
    monkeypatch.setattr(Path, "read_bytes", exhaust)
    assert "expected a mesh that fits into memory" in error_of(file)


# ---- Global state ----------------------------------------------------------------------------------------


def test_threads_leave_warnings_as_they_were(tmp_path: Path) -> None:
    """Warnings that one thread suppresses while it reads, another must not restore later."""
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" * 50)
    before = list(warnings.filters)
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(8) as threads:
            list(threads.map(load, [tmp_path / "a.obj"] * 100))
    finally:
        sys.setswitchinterval(interval)
    assert list(warnings.filters) == before


def test_faces_without_all_their_vertices_are_left_out(tmp_path: Path) -> None:
    faces = "f 1 2 3\nf 1 2 5\nf 2 3 6\nf 1 2 99\nf 0 1 2"
    file = written(tmp_path / "a.obj", SQUARE + "v nan 0 0\nv 9 9 inf\n" + faces)
    with pytest.warns(InputWarning, match=r"^a\.obj: left out 4 of 5 triangles") as caught:
        mesh = load_mesh(file)
    assert mesh.triangles.tolist() == [[0, 1, 2]]
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    assert caught[0].filename == __file__


def test_vertices_that_no_face_uses_do_not_count(tmp_path: Path) -> None:
    mesh = load_mesh(written(tmp_path / "a.obj", "v 1000 0 0\n" + SQUARE + "f 2 3 4"))
    assert mesh.vertices.max() == 1


@pytest.mark.parametrize("scale", [1e-30, 1.0, 1e30])
@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_large_and_far_coordinates_survive(scale: float, offset: float, tmp_path: Path) -> None:
    points = (np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.125]]) + offset) * scale
    text = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in points.tolist())
    assert np.array_equal(load_mesh(written(tmp_path / "a.obj", text + "f 1 2 3")).vertices, points)


# ---- OBJ -------------------------------------------------------------------------------------------------


def test_obj_relative_indices_count_back_from_their_line(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 5\nv 1 0 5\nv 0 1 5\nf -3 -2 -1\n"
    mesh = load_mesh(written(tmp_path / "a.obj", text))
    assert mesh.vertices[mesh.triangles][:, :, 2].tolist() == [[0, 0, 0], [5, 5, 5]]


def test_obj_mixed_corners_and_polygons(tmp_path: Path) -> None:
    faces = "f 1 2 3 5 4 # a house\nf 1/1 2/1 3/1\nf 1//1 2//1 \\\n3//1\n"
    text = SQUARE + "v 0.5 2 0\nvt 0 0\nvn 0 0 2\n" + faces
    mesh = load_mesh(written(tmp_path / "a.obj", text))
    assert len(mesh.triangles) == 5
    # Zero where the file has no normal; the tracer then computes one.
    assert mesh.normals is not None
    assert sorted(set(map(tuple, mesh.normals.tolist()))) == [(0, 0, 0), (0, 0, 1)]


def test_obj_errors(tmp_path: Path) -> None:
    assert "got a point cloud of 4 points" in error_of(written(tmp_path / "a.obj", SQUARE + "f 1 2"))
    assert "expected corners of faces such as 3" in error_of(written(tmp_path / "b.obj", SQUARE + "f one two three"))
    assert "missing or non-finite" in error_of(written(tmp_path / "c.obj", "v 0 0\nv 1 0\nv 0 1\nf 1 2 3"))


# ---- PLY -------------------------------------------------------------------------------------------------


def ply(form: str, vertices: int, faces: int, body: bytes, extra: str = "") -> bytes:
    head = f"ply\nformat {form} 1.0\nelement vertex {vertices}\n"
    head += "property float x\nproperty float y\nproperty float z\n"
    head += f"{extra}element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    return head.encode() + body


PENTAGON = [(0, 0, 0), (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0)]


@pytest.mark.parametrize("order", ["<", ">"])
def test_ply_polygons_of_mixed_sizes(order: str, tmp_path: Path) -> None:
    body = b"".join(struct.pack(order + "3f", *point) for point in PENTAGON)
    body += struct.pack(order + "B5i", 5, 0, 1, 2, 3, 4) + struct.pack(order + "B3i", 3, 0, 2, 4)
    form = "binary_little_endian" if order == "<" else "binary_big_endian"
    mesh = load_mesh(written(tmp_path / "a.ply", ply(form, 5, 2, body)))
    assert mesh.vertices.tolist() == [list(point) for point in PENTAGON]
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 2, 4]]

    text = "".join(f"{x} {y} {z}\n" for x, y, z in PENTAGON) + "5 0 1 2 3 4\n3 0 2 4 and more\n"
    other = load_mesh(written(tmp_path / "b.ply", ply("ascii", 5, 2, text.encode())))
    assert np.array_equal(other.vertices, mesh.vertices)
    assert np.array_equal(other.triangles, mesh.triangles)


def test_ply_strips_turn_alternately(tmp_path: Path) -> None:
    text = (
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n1 1 0\n9 0 1 2 3 -1 1 3 2 2\n"
    )
    mesh = load_mesh(written(tmp_path / "a.ply", text))
    assert mesh.triangles.tolist() == [[0, 1, 2], [2, 1, 3], [1, 3, 2]]
    assert [normal_of(mesh, t) for t in range(3)] == [[0, 0, 1]] * 3


def test_ply_normals_are_the_files(tmp_path: Path) -> None:
    extra = "property float nx\nproperty float ny\nproperty float nz\n"
    body = b"0 0 0 1 0 0\n1 0 0 0 1 0\n0 1 0 0 0 -3\n3 0 1 2\n"
    mesh = load_mesh(written(tmp_path / "a.ply", ply("ascii", 3, 1, body, extra)))
    assert mesh.normals is not None
    assert mesh.normals.tolist() == [[1, 0, 0], [0, 1, 0], [0, 0, -1]]
    without = ply("ascii", 3, 1, b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    assert load_mesh(written(tmp_path / "b.ply", without)).normals is None


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
def test_ply_that_promises_too_much(form: str, tmp_path: Path) -> None:
    file = written(tmp_path / "a.ply", ply(form, 4_000_000_000, 1, b"0 0 0\n" * 9))
    assert "expected 4,000,000,000 vertex, 1 face, got only 54 bytes to hold them" in error_of(file)


def test_ply_cut_short(tmp_path: Path) -> None:
    body = b"".join(struct.pack("<3f", *point) for point in PENTAGON)
    cut = ply("binary_little_endian", 5, 2, body + struct.pack("<B3i", 3, 0, 1, 2) + struct.pack("<Bi", 4, 1))
    assert "expected 2 face, but the file ends before them" in error_of(written(tmp_path / "a.ply", cut))
    text = ply("ascii", 3, 1, b"0 0 0\n1 0 0\n0 1 0\n3 0 1\n")
    assert "expected 1 face, but row 1 is missing or too short" in error_of(written(tmp_path / "b.ply", text))
    negative = ply("ascii", 3, 1, b"0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n")
    error_of(written(tmp_path / "c.ply", negative))


# ---- STL and OFF -----------------------------------------------------------------------------------------


def test_stl_vertices_are_joined(tmp_path: Path) -> None:
    corners: list[list[float]] = [[0, 0, 0, 1, 0, 0, 1, 1, 0], [-0.0, 0, 0, 1, 1, 0, 0, 1, 0]]
    data = bytes(80) + struct.pack("<I", 2)
    data += b"".join(struct.pack("<12fH", 0, 0, 1, *triangle, 0) for triangle in corners)
    mesh = load_mesh(written(tmp_path / "a.stl", data))
    assert (len(mesh.vertices), mesh.normals) == (4, None)
    assert [normal_of(mesh, t) for t in range(2)] == [[0, 0, 1]] * 2
    assert "got 183 bytes" in error_of(written(tmp_path / "b.stl", data[:-1]))
    data = data[:80] + struct.pack("<I", 4_000_000_000) + data[84:]
    assert "84 + 50 n bytes" in error_of(written(tmp_path / "c.stl", data))


def test_off(tmp_path: Path) -> None:
    text = "OFF # a square\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n\n0 1 0\n4 0 1 2 3\n"
    assert len(load_mesh(written(tmp_path / "a.off", text)).triangles) == 2
    with pytest.warns(InputWarning, match=r"^b\.off: left out 1 of 2 triangles"):
        load_mesh(written(tmp_path / "b.off", text.replace("2 3", "2 9")))


# ---- glTF ------------------------------------------------------------------------------------------------


def gltf(nodes: list[dict[str, Any]], *, normals: bool = False, **changes: Any) -> dict[str, Any]:
    """One triangle in the plane x, z, facing y, which glTF holds for up."""
    points = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0]], "<f4").tobytes()
    ups = np.array([[1, 1, 0]] * 3, "<f4").tobytes()
    data = "data:application/octet-stream;base64," + base64.b64encode(points + ups).decode()
    tree: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": data, "byteLength": 72}],
        "bufferViews": [{"buffer": 0, "byteOffset": start, "byteLength": 36} for start in (0, 36)],
        "accessors": [{"bufferView": b, "componentType": 5126, "count": 3, "type": "VEC3"} for b in (0, 1)],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, **({"NORMAL": 1} if normals else {})}}]}],
        "nodes": nodes,
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    return {**tree, **changes}


def glb(tree: dict[str, Any]) -> bytes:
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    return struct.pack("<4s4I", b"glTF", 2, 20 + len(text), len(text), 0x4E4F534A) + text


def loaded(tmp_path: Path, tree: dict[str, Any]) -> Mesh:
    """From .gltf and from .glb, which must agree."""
    one = load_mesh(written(tmp_path / "a.gltf", json.dumps(tree)))
    other = load_mesh(written(tmp_path / "a.glb", glb(tree)))
    assert np.array_equal(one.vertices, other.vertices)
    assert np.array_equal(one.triangles, other.triangles)
    return one


def test_gltf_is_turned_to_z_up(tmp_path: Path) -> None:
    mesh = loaded(tmp_path, gltf([{"mesh": 0, "translation": [0, 7, 0]}], normals=True))
    assert mesh.vertices.tolist() == [[0, 0, 7], [0, -1, 7], [1, 0, 7]]
    assert normal_of(mesh) == [0, 0, 1]
    assert mesh.normals is not None
    assert mesh.normals[0] == pytest.approx([math.sqrt(0.5), 0, math.sqrt(0.5)])
    assert loaded(tmp_path, gltf([{"mesh": 0}])).normals is None


def test_gltf_normals_stay_upright_on_what_is_stretched_and_mirrored(tmp_path: Path) -> None:
    nodes: list[dict[str, Any]] = [{"children": [1], "camera": 0}, {"mesh": 0, "scale": [-4, 1, 1]}]
    mesh = loaded(tmp_path, gltf(nodes, normals=True, cameras=[{"type": "perspective"}]))
    # A plane stretched four times in x leans four times less: normals are multiplied by the inverse.
    assert mesh.normals is not None
    assert mesh.normals[0] == pytest.approx(np.array([-0.25, 0, 1]) / math.hypot(0.25, 1))
    assert normal_of(mesh) == [0, 0, 1]  # the outside is still outside


def test_gltf_keeps_what_hangs_on_a_camera_in_place(tmp_path: Path) -> None:
    camera = {"type": "perspective", "perspective": {"yfov": 1.0, "aspectRatio": 1.0, "znear": 0.1}}
    nodes: list[dict[str, Any]] = [{"children": [1], "camera": 0, "translation": [5, 0, 0]}, {"mesh": 0}]
    assert loaded(tmp_path, gltf(nodes, cameras=[camera])).vertices[:, 0].min() == 5


def test_gltf_without_a_scene_shows_all_its_nodes(tmp_path: Path) -> None:
    tree = gltf([{"mesh": 0}, {"children": [2]}, {"mesh": 0, "translation": [0, 1, 0]}])
    del tree["scenes"], tree["scene"]
    assert len(loaded(tmp_path, tree).triangles) == 2


@pytest.mark.parametrize(
    "nodes",
    [
        [{"mesh": 0, "children": [0]}],
        [{"mesh": 0, "children": [1]}, {"children": [0]}],
        [{"mesh": 0, "children": [n + 1, n + 1]} for n in range(60)] + [{"mesh": 0}],
    ],
    ids=["itself", "circle", "doubling"],
)
def test_gltf_nodes_form_trees(nodes: list[dict[str, Any]], tmp_path: Path) -> None:
    assert "expected nodes that form a tree" in error_of(written(tmp_path / "a.gltf", json.dumps(gltf(nodes))))


def test_gltf_deep_trees_load(tmp_path: Path) -> None:
    nodes: list[dict[str, Any]] = [{"children": [n + 1], "translation": [0, 1, 0]} for n in range(5000)]
    assert loaded(tmp_path, gltf([*nodes, {"mesh": 0}])).vertices[:, 2].max() == 5000


MANY: dict[str, list[dict[str, Any]]] = {
    "empty": [{"mesh": 0}, *[{}] * 100_000],
    "deep": [*({"children": [n + 1]} for n in range(100_000)), {"mesh": 0}],
    "repeated": [{"mesh": 0}] * 100_001,
}


@pytest.mark.parametrize("nodes", MANY.values(), ids=MANY)
def test_gltf_nodes_are_counted(nodes: list[dict[str, Any]], tmp_path: Path) -> None:
    roots = range(len(nodes)) if "children" not in nodes[0] else [0]
    tree = gltf(nodes, scenes=[{"nodes": [*roots]}])
    for file in (written(tmp_path / "a.gltf", json.dumps(tree)), written(tmp_path / "a.glb", glb(tree))):
        assert error_of(file).endswith(": nodes: expected at most 100,000, got 100,001")


def test_gltf_primitives_are_counted_as_often_as_they_are_placed(tmp_path: Path) -> None:
    tree = gltf([{"mesh": 0}] * 1001, scenes=[{"nodes": [*range(1001)]}])
    tree["meshes"][0]["primitives"] *= 100
    message = "a.gltf: primitives: expected at most 100,000, got 100,100"
    assert error_of(written(tmp_path / "a.gltf", json.dumps(tree))) == message


def test_gltf_names_take_no_time(tmp_path: Path) -> None:
    """Those that end in numbers, and come twice."""

    def cost(names: list[str]) -> float:
        tree = gltf([{"mesh": 0, "name": name} for name in names], scenes=[{"nodes": [*range(len(names))]}])
        file = written(tmp_path / "a.gltf", json.dumps(tree))
        start = time.thread_time()
        load(file)
        return time.thread_time() - start

    count = 8000
    cost(["a"])
    repeated, different = [f"a_{n % (count // 2)}" for n in range(count)], [str(n) for n in range(count)]
    assert least(lambda: cost(repeated) / cost(different), 3) < 3


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"accessors": [{"componentType": 5126, "count": 10**12, "type": "VEC3"}]}, "at most"),
        (
            {"accessors": [{"bufferView": 0, "componentType": 5126, "count": 10**12, "type": "VEC3"}]},
            "expected 12,000,000,000,000 bytes in its view, got 36",
        ),
        ({"accessors": [{"bufferView": 0, "componentType": 5126, "count": 9, "type": "VEC3"}]}, "bytes in its view"),
        ({"buffers": [{"uri": "a.bin", "byteLength": 72}]}, "found no such file"),
        ({"buffers": [{"uri": "/dev/zero", "byteLength": 72}]}, "found no such file"),
        ({"buffers": [{"uri": "https://example.org/a.bin", "byteLength": 72}]}, "found no such file"),
        ({"asset": {"version": "1.0"}}, "asset: expected version 2.0, got 1.0"),
        ({"meshes": []}, "nodes[0]: mesh: expected an integer in 0..-1, got 0"),
        ({"scenes": [{"nodes": []}]}, "expected triangles, got none"),
        ({"meshes": 3}, "meshes: expected a list of objects, got another"),
    ],
)
def test_gltf_errors(change: dict[str, Any], message: str, tmp_path: Path) -> None:
    file = written(tmp_path / "a.gltf", json.dumps(gltf([{"mesh": 0}], **change)))
    assert message in error_of(file)


def buffer_file(path: Path) -> Path:
    """Write the triangle's data next to a glTF."""
    path.parent.mkdir(exist_ok=True)
    return written(path, base64.b64decode(gltf([])["buffers"][0]["uri"].partition(",")[2]))


@pytest.mark.parametrize("ending", ["stl", "obj", "sdf", "bob", "xml"])
def test_files_too_large_to_be_read_are_refused_at_once(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"x.{ending}"
    with path.open("wb") as file:
        file.truncate(beside.MAX_BYTES + 1)  # which takes no room on the disk
    with pytest.raises(
        InputError, match=r"^x\.\w+: expected a file of at most 4,294,967,296 bytes, got 4,294,967,297$"
    ):
        load(path)


def test_gltf_reads_files_in_its_folder_and_below(tmp_path: Path) -> None:
    buffer_file(tmp_path / "parts" / "a b%20.bin")
    (tmp_path / "link.bin").symlink_to("parts/a b%20.bin")
    for uri in ("parts/a%20b%2520.bin", "./parts/a b%2520.bin", "link.bin"):
        assert len(loaded(tmp_path, gltf([{"mesh": 0}], buffers=[{"uri": uri, "byteLength": 72}])).triangles) == 1
    (tmp_path / "folder").symlink_to(tmp_path, target_is_directory=True)
    assert len(loaded(tmp_path / "folder", gltf([{"mesh": 0}])).triangles) == 1


def test_gltf_reads_a_file_next_to_it_for_one_elsewhere(tmp_path: Path) -> None:
    buffer_file(tmp_path / "a.bin")
    for uri in ("textures/a.bin", "../a.bin", "parts/../a.bin", f"{tmp_path}/a.bin", "C:%5Cparts%5Ca.bin"):
        assert len(loaded(tmp_path, gltf([{"mesh": 0}], buffers=[{"uri": uri, "byteLength": 72}])).triangles) == 1


@pytest.mark.parametrize(
    "uri",
    [
        "../../../etc/passwd",
        "../secret.bin",
        "%2e%2e/secret.bin",
        "..%2Fsecret.bin",
        "parts/../../secret.bin",
        "{tmp}/secret.bin",
        "%2Fetc/passwd",
        "/proc/self/environ",
        "/dev/zero",
        "file:///etc/passwd",
        "link.bin",
        "linked/secret.bin",
        "process/self/environ",
        "loop.bin",
        "pipe.bin",
        "parts",
        "a.bin%00",
        "a" * 5000,
    ],
)
def test_gltf_reads_nothing_elsewhere(uri: str, tmp_path: Path) -> None:
    folder = tmp_path / "model"
    for file in ("model/a.bin", "secret.bin", "model/parts/a.bin"):
        buffer_file(tmp_path / file)
    (folder / "link.bin").symlink_to("../secret.bin")
    (folder / "linked").symlink_to(tmp_path, target_is_directory=True)
    (folder / "process").symlink_to("/proc", target_is_directory=True)
    (folder / "loop.bin").symlink_to("loop.bin")
    os.mkfifo(folder / "pipe.bin")
    tree = gltf([{"mesh": 0}], buffers=[{"uri": uri.replace("{tmp}", str(tmp_path)), "byteLength": 72}])
    for file in (written(folder / "a.gltf", json.dumps(tree)), written(folder / "a.glb", glb(tree))):
        assert "in or below its folder, found no such file: " in error_of(file)


def test_gltf_files_have_a_limit_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(beside, "MAX_BYTES", 143)
    for name in ("a.bin", "b.bin"):
        buffer_file(tmp_path / name)
    one, other = ({"uri": name, "byteLength": 72} for name in ("a.bin", "b.bin"))
    assert len(loaded(tmp_path, gltf([{"mesh": 0}], buffers=[one, one])).triangles) == 1  # read once
    file = written(tmp_path / "a.gltf", json.dumps(gltf([{"mesh": 0}], buffers=[one, other])))
    assert "expected files of at most 143 bytes next to it, got more in b.bin" in error_of(file)


def test_gltf_unused_accessors_take_no_memory(tmp_path: Path) -> None:
    tree = gltf([{"mesh": 0}])
    tree["accessors"].append({"componentType": 5126, "count": 10**12, "type": "MAT4"})
    assert len(loaded(tmp_path, tree).triangles) == 1


def test_gltf_cannot_multiply_without_end(tmp_path: Path) -> None:
    tree = gltf([{"mesh": 0}])
    tree["buffers"] = [{"uri": "a.bin", "byteLength": 12_000_000}]
    (tmp_path / "a.bin").write_bytes(bytes(12_000_000))
    tree["bufferViews"] = [{"buffer": 0, "byteLength": 12_000_000}] * 2
    tree["accessors"] = [{"bufferView": 0, "componentType": 5126, "count": 999_999, "type": "VEC3"}]
    tree["meshes"][0]["primitives"] *= 2000
    file = written(tmp_path / "a.gltf", json.dumps(tree))
    assert "expected at most 100,000,000 triangles and vertices" in error_of(file)


def test_glb_cut_short(tmp_path: Path) -> None:
    whole = glb(gltf([{"mesh": 0}]))
    assert re.search(r"expected [\d,]+ bytes", error_of(written(tmp_path / "a.glb", whole[:-10])))
    assert "starts with 'glTF'" in error_of(written(tmp_path / "b.glb", b"RIFF" + whole[4:]))


# ---- 3MF -------------------------------------------------------------------------------------------------

TRIANGLE = (
    "<mesh><vertices><vertex x='0' y='0' z='0'/><vertex x='1' y='0' z='0'/>"
    "<vertex x='0' y='1' z='0'/></vertices><triangles><triangle v1='0' v2='1' v3='2'/></triangles></mesh>"
)


def threemf(path: Path, resources: str, build: str) -> Path:
    text = f"<model xmlns='http://schemas.microsoft.com/3dmanufacturing/core/2015/02'><resources>{resources}"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", f"{text}</resources><build>{build}</build></model>")
    return path


def test_3mf_places_components(tmp_path: Path) -> None:
    # 3MF multiplies from the right: a quarter turn about z takes x to y; then the item moves it.
    turn = "0 1 0 -1 0 0 0 0 1 0 0 0"
    resources = f"<object id='1'>{TRIANGLE}</object><object id='2'><components>"
    resources += f"<component objectid='1' transform='{turn}'/><component objectid='1'/></components></object>"
    build = "<item objectid='2' transform='1 0 0 0 1 0 0 0 1 5 6 7'/>"
    mesh = load_mesh(threemf(tmp_path / "a.3mf", resources, build))
    corners = sorted(mesh.vertices[mesh.triangles].tolist())
    assert corners == [[[5, 6, 7], [5, 7, 7], [4, 6, 7]], [[5, 6, 7], [6, 6, 7], [5, 7, 7]]]


def test_3mf_components_that_never_end(tmp_path: Path) -> None:
    itself = "<object id='2'><components><component objectid='2'/></components></object>"
    assert "finitely many" in error_of(threemf(tmp_path / "a.3mf", itself, "<item objectid='2'/>"))
    doubling = f"<object id='0'>{TRIANGLE}</object>" + "".join(
        f"<object id='{n + 1}'><components>" + f"<component objectid='{n}'/>" * 2 + "</components></object>"
        for n in range(60)
    )
    assert "finitely many" in error_of(threemf(tmp_path / "b.3mf", doubling, "<item objectid='60'/>"))
    assert "object with id 9" in error_of(threemf(tmp_path / "c.3mf", doubling, "<item objectid='9999'/>"))


def test_3mf_bombs(tmp_path: Path) -> None:
    bomb = threemf(tmp_path / "a.3mf", " " * (1 << 27), "")
    assert "unpacks to 134,217," in error_of(bomb)
    entity = "<!DOCTYPE m [<!ENTITY a 'aaaaaaaaaa'>" + "".join(
        f"<!ENTITY {chr(98 + n)} '{f'&{chr(97 + n)};' * 10}'>" for n in range(12)
    )
    with zipfile.ZipFile(tmp_path / "b.3mf", "w") as archive:
        archive.writestr("3D/3dmodel.model", entity + "]><model>&m;</model>")
    error_of(tmp_path / "b.3mf")
    with zipfile.ZipFile(tmp_path / "c.3mf", "w") as archive:
        archive.writestr("readme.txt", "nothing here")
    assert "expected a 3MF with a 3D/3dmodel.model" in error_of(tmp_path / "c.3mf")


@pytest.mark.parametrize("ending", [".3mf", ".xml"])
@pytest.mark.parametrize(
    ("start", "repeated", "message"),
    [
        ("<m>", "<a/>", "at most 250,000 elements of a few bytes"),
        ("<m>", "<a>", "at most 100,000 levels"),
        ("<m a='", "aaaa", "tags of at most 1,048,576 bytes"),
        ("<m><!--", "aaaa", "tags of at most 1,048,576 bytes"),
        ("<!DOCTYPE m [", "<!ENTITY a 'b'>", "without a document type"),
    ],
    ids=["elements", "levels", "attribute", "comment", "entities"],
)
def test_xml_bombs_are_refused_at_once(ending: str, start: str, repeated: str, message: str, tmp_path: Path) -> None:
    """A 3MF of any size may unpack to 64 MB."""
    content = start + repeated * ((1 << 26) // len(repeated) - 100)
    file = tmp_path / f"a{ending}"
    if ending == ".3mf":
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            archive.writestr("3D/3dmodel.model", content.replace("<m", "<model", 1))
    else:
        file.write_text(content)
    begin = time.thread_time()
    with pytest.raises(InputError, match=message):
        load(file)
    assert time.thread_time() - begin < 3 * SLOWER


# ---- Text beyond ASCII -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.off", "OFF # Würfel\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
        ("a.obj", "# Würfel\ng Würfel\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("a.stl", "solid Würfel\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                  "endloop\nendfacet\nendsolid\n"),
        ("a.ply", "ply\nformat ascii 1.0\ncomment Würfel\nelement vertex 3\nproperty float x\nproperty float y\n"
                  "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
                  "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_names_and_comments_in_any_encoding(name: str, text: str, encoding: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(text.encode(encoding))
    assert len(load_mesh(tmp_path / name).triangles) == 1


def test_binary_stl_with_any_head(tmp_path: Path) -> None:
    corners = struct.pack("<12f", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0) + bytes(2)
    for head in (b"COLOR=\xff\xfe\x80\xff", b"solid \xe4", b""):
        (tmp_path / "a.stl").write_bytes(head.ljust(80, b" ") + struct.pack("<I", 1) + corners)
        assert len(load_mesh(tmp_path / "a.stl").triangles) == 1


@pytest.mark.measures
def test_what_trimesh_logs_is_not_shown(tmp_path: Path) -> None:
    facet = "facet normal x 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    (tmp_path / "a.stl").write_text(f"solid a\n{facet}endsolid\n")
    command = [sys.executable, "-m", "bobrossnet", "info", str(tmp_path / "a.stl")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "triangles  1" in done.stdout
    assert done.stderr == ""
