"""Colours, materials and textures of mesh files, against the formats' specifications."""

from __future__ import annotations

import base64
import io
import json
import struct
import time
import zipfile
from functools import partialmethod
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from clocks import least
from loaded import told
from models import MODELS, needs_models
from numpy.typing import NDArray
from PIL import Image

import bobrossnet as bob
from bobrossnet.color import from_srgb
from bobrossnet.shapes.mesh import Mesh

TEXELS = np.array([[(255, 0, 0), (0, 255, 0)], [(0, 0, 255), (255, 255, 0)]], np.uint8)
HALF = float(from_srgb(128 / 255))


def picture(form: str = "PNG", texels: NDArray[np.uint8] = TEXELS) -> bytes:
    file = io.BytesIO()
    Image.fromarray(texels).save(file, form)
    return file.getvalue()


def written(path: Path, content: bytes | str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def mesh_of(path: Path) -> Mesh:
    (instance,) = bob.load(path).instances
    assert isinstance(instance.shape, Mesh)
    return instance.shape


def seen(scene: Any, size: tuple[int, int] = (40, 40)) -> NDArray[np.float32]:
    """The albedo of a square that fills the picture, from above."""
    return bob.trace(scene, bob.Camera(elevation=90, azimuth=0, zoom=1.4), size=size).albedo


def corners_of(albedo: NDArray[np.float32]) -> NDArray[np.int64]:
    """Return the colours near the four corners of a picture, rounded to 0 or 1."""
    return np.rint(albedo[[[8], [31]], [[8, 31]]]).astype(int)


# ---- OBJ -------------------------------------------------------------------------------------------------

# Seen from above with azimuth 0, x points down and y to the right.
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
FACE = "f 1/1 2/2 3/3 4/4\n"


def obj(folder: Path, mtl: str, body: str = f"usemtl a\n{FACE}") -> Path:
    written(folder / "a.mtl", mtl)
    return written(folder / "a.obj", f"mtllib a.mtl\n{SQUARE}{body}")


def test_obj_materials_are_instances_of_their_names(tmp_path: Path) -> None:
    mtl = "newmtl red one\nKd 0.5 0 0\nKs 0 0 0\nnewmtl metal\nKd 1 1 1\nPm 1\nPr .25 # rough\nKe 0 0 0.5\n"
    file = obj(
        tmp_path, mtl, "f 1 2 3\nusemtl red one\nf 1 3 4\nusemtl metal\nf 2 3 4\nf 1 2 4\nusemtl unknown\nf 3 4 1\n"
    )
    scene, warned = told(file)
    assert warned == ["a.obj: material 'unknown' was left out: expected a newmtl in the libraries, got none"]
    plain, red, metal = scene.instances
    assert [i.shape.counts()["triangle"] for i in scene.instances] == [2, 1, 2]
    assert [i.name for i in scene.instances] == ["a.obj", "red one", "metal"]
    assert plain.material == bob.Material()
    assert red.material == bob.Material((float(from_srgb(0.5)), 0, 0), specular=0)
    assert metal.material == bob.Material(metallic=1, roughness=0.25, emissive=(0, 0, float(from_srgb(0.5))))
    with pytest.warns(bob.InputWarning, match="'unknown'"):
        whole = bob.load_mesh(file)
    assert whole.face_colors is not None
    assert np.allclose(whole.face_colors[:, 1], [1, 0, 1, 1, 1])
    assert np.allclose(whole.face_colors[1], (from_srgb(0.5), 0, 0))


def test_colors_that_are_no_numbers_are_told(tmp_path: Path) -> None:
    scene, warned = told(obj(tmp_path, "newmtl a\nKd 0,9 0,5 0\nKe spectral lamp.rfl\nKs\n"))
    expected = "was left out: expected one or three numbers, got"
    assert warned == [
        f"a.obj: {what} of material 'a' {expected} '{got}'"
        for what, got in (("Kd", "0,9 0,5 0"), ("Ke", "spectral lamp.rfl"))
    ]
    assert scene.instances[0].material == bob.Material()


def test_obj_is_as_smooth_where_materials_meet(tmp_path: Path) -> None:
    """Without normals in the file, and where some have no length: as if it had one material."""
    angles = np.arange(12) * np.pi / 6
    rims = [(np.cos(a), np.sin(a), z) for z in (0, 3) for a in angles]
    points = "".join(f"v {x} {y} {z}\n" for x, y, z in rims)
    sides = [(i + 1, (i + 1) % 12 + 1, (i + 1) % 12 + 13, i + 13) for i in range(12)]
    some = "vn 0 0 0\n"
    for normals, corner in (("", "{}"), (some, "{}//1")):
        faces = ["f " + " ".join(corner.format(vertex) for vertex in side) + "\n" for side in sides]
        plain = bob.load(written(tmp_path / "plain.obj", points + normals + "".join(faces)))
        colored = "".join(f"usemtl {'ab'[i % 2]}\n{face}" for i, face in enumerate(faces))
        written(tmp_path / "two.mtl", "newmtl a\nKd 1 1 1\nnewmtl b\nKd 1 1 0\n")
        two = bob.load(written(tmp_path / "two.obj", f"mtllib two.mtl\n{points}{normals}{colored}"))
        assert len(two.instances) == 2
        expected, found = (bob.trace(scene, size=(60, 80)) for scene in (plain, two))
        assert np.abs(expected.normal - found.normal).max() < 1e-3
        assert (expected.normal[..., 0] > 0).any()


def test_obj_highlights(tmp_path: Path) -> None:
    """Ks scales the highlight that surfaces have here; exponents below 1 are no highlight's."""
    (instance,) = bob.load(obj(tmp_path, "newmtl a\nKs 0.5 1 0.1\nNs 90\n")).instances
    assert (instance.material.specular, instance.material.shininess) == (0.2, 90)
    (instance,) = bob.load(obj(tmp_path, "newmtl a\nNs 0\n")).instances
    assert (instance.material.specular, instance.material.shininess) == (0.2, 32)


def test_obj_materials_that_look_alike_are_one_shape(tmp_path: Path) -> None:
    (instance,) = bob.load(obj(tmp_path, "newmtl a\nnewmtl b\n", "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n")).instances
    assert (instance.name, instance.shape.counts()["triangle"]) == ("a.obj", 2)


@pytest.mark.parametrize("form", ["PNG", "JPEG", "WEBP", "BMP"])
def test_obj_texture_counts_from_the_bottom_up(form: str, tmp_path: Path) -> None:
    texels = np.repeat(np.repeat(TEXELS, 16, 0), 16, 1)
    written(tmp_path / "t.png", picture(form, texels))
    mesh = mesh_of(obj(tmp_path, "newmtl a\nKd 0.2 0.2 0.2\nmap_Kd t.png\n"))
    assert mesh.texture is not None
    assert mesh.uv is not None
    assert mesh.texture.shape == (32, 32, 3)
    assert np.abs(mesh.texture.astype(int) - texels).mean() < 8  # of formats that lose some
    at = {tuple(vertex): tuple(uv) for vertex, uv in zip(mesh.vertices[:, :2], mesh.uv, strict=True)}
    assert at == {(0, 0): (0, 1), (1, 0): (1, 1), (1, 1): (1, 0), (0, 1): (0, 0)}
    # Up is -x, right is y: the texture's left bottom, at the origin, is seen at the left top.
    found = corners_of(seen(mesh))
    assert np.array_equal(found, np.rint(from_srgb(TEXELS / 255))[::-1].transpose(1, 0, 2))


def test_obj_maps_and_their_paths(tmp_path: Path) -> None:
    for place in ("t.png", "maps/b c.png"):
        written(tmp_path / place, picture())
    for line in (
        "map_Kd .\\t.png",
        "map_Kd maps\\b c.png",
        "map_kd -s 1 1 1 -o 0 0 -bm 0.5 t.png",
        "map_Kd C:\\Users\\somebody\\textures\\t.png",
        "map_Kd /home/somebody/t.png",
        "map_Kd Textures\\T.PNG",
    ):
        assert mesh_of(obj(tmp_path, f"newmtl a\n{line}\n")).wrap == ("repeat", "repeat")
    assert mesh_of(obj(tmp_path, "newmtl a\nmap_Kd -clamp on t.png\n")).wrap == ("clamp", "clamp")
    written(tmp_path / "maps/a.mtl", "newmtl a\nmap_Kd b c.png\n")  # from the library's folder on
    for library in ("maps/a.mtl", "C:\\Users\\somebody\\b.mtl"):  # of another machine: next to the model
        written(tmp_path / "b.mtl", "newmtl a\nmap_Kd t.png\n")
        file = written(tmp_path / "b.obj", f"mtllib {library}\n{SQUARE}usemtl a\n{FACE}")
        assert mesh_of(file).texture is not None


@pytest.mark.parametrize(
    ("map_kd", "message"),
    [
        ("missing.png", "found no such file: missing.png"),
        ("../t.png", "found no such file"),
        ("a.mtl", "expected a picture in PNG, JPEG, WebP or AVIF, got none that can be read"),
    ],
)
def test_a_texture_that_cannot_be_read_is_one_warning(map_kd: str, message: str, tmp_path: Path) -> None:
    written(tmp_path / "t.png", picture())
    mtl = f"newmtl a\nKd 1 0 0\nmap_Kd {map_kd}\nnewmtl b\nKd 0 1 0\nmap_Kd {map_kd}\n"
    scene, warned = told(obj(tmp_path / "in", mtl, "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n"))
    assert [instance.material.color for instance in scene.instances] == [(1, 0, 0), (0, 1, 0)]
    assert len(warned) == 1
    assert message in warned[0]
    assert warned[0].startswith("a.obj: texture ")


def test_materials_that_are_missing_are_one_warning(tmp_path: Path) -> None:
    scene, warned = told(written(tmp_path / "a.obj", f"mtllib none.mtl\n{SQUARE}usemtl a\n{FACE}"))
    assert not scene.is_colored
    assert len(warned) == 1
    assert warned[0].startswith("a.obj: materials were left out: ")
    assert told(written(tmp_path / "b.obj", f"mtllib none.mtl\n{SQUARE}{FACE}"))[1] == []  # nothing has one


def test_textures_have_a_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bobrossnet.adapters.surface.MAX_TEXELS", 3)
    written(tmp_path / "t.png", picture())
    scene, warned = told(obj(tmp_path, "newmtl a\nmap_Kd t.png\n"))
    assert not scene.is_colored
    assert "at most 3 texels, got more" in warned[0]


MANY = [f"newmtl m{i}\nKd {i % 100 / 100} {i // 100 / 100} 1\n" for i in range(8000)]


def test_obj_loads_in_time_linear_in_its_materials(tmp_path: Path) -> None:
    def cost(count: int) -> float:
        faces = "".join(f"usemtl m{i}\nf 1 2 3\n" for i in range(count))
        file = obj(tmp_path / str(count), "".join(MANY[:count]), faces)
        start = time.thread_time()
        assert len(bob.load(file).instances) == count
        return time.thread_time() - start

    cost(10)
    # 8 if linear, above 30 if every material goes through all triangles.
    assert least(lambda: cost(8000) / cost(1000), 20) < 20


def test_pictures_of_a_file_have_a_limit_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each counts once, by its content, and is in memory once, whatever surfaces have it."""
    monkeypatch.setattr("bobrossnet.adapters.surface.MAX_FILE_TEXELS", 8)
    for i in range(3):
        written(tmp_path / f"{i}.png", picture(texels=TEXELS + np.uint8(i)))
        written(tmp_path / f"copy{i}.png", picture())
    face = "".join(f"usemtl {i}\nf 1 2 3\n" for i in range(3))
    scene, warned = told(obj(tmp_path, "".join(f"newmtl {i}\nmap_Kd {i}.png\n" for i in range(3)), face))
    assert sum(instance.shape.texture is not None for instance in scene.instances) == 2
    assert warned == ["a.obj: texture 2.png was left out: expected textures of at most 8 texels in all, got more"]

    mtl = "".join(f"newmtl {i}\nKe 0 0 0.{i}\nmap_Kd copy{i}.png\n" for i in range(3))
    scene, warned = told(obj(tmp_path, mtl, face))
    assert len({id(instance.shape.picture) for instance in scene.instances}) == 1
    assert len(scene.instances) == 3
    assert warned == []

    mtl = "newmtl 0\n" + "".join(f"newmtl {i}\nmap_Kd copy0.png\nmap_d {i}.png\n" for i in (1, 2))
    _, warned = told(obj(tmp_path, mtl, face))
    assert len(warned) == 2  # one picture and one mask fit, but not the two combined
    assert warned[0].startswith("a.obj: the mask of 1 was left out: expected textures of at most 8 texels in all")
    assert warned[1].startswith("a.obj: texture 2.png was left out: ")


def test_a_picture_is_decoded_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    decoded = []
    opened = Image.open
    monkeypatch.setattr("PIL.Image.open", lambda *args, **more: decoded.append(args) or opened(*args, **more))
    data = picture()
    uri = "data:;base64," + base64.b64encode(data).decode()
    names = [{"uri": uri}, {"uri": uri + "\n"}, {"uri": "t.png"}, {"uri": "u.png"}]
    written(tmp_path / "t.png", data)
    written(tmp_path / "u.png", data)
    sources = [{"source": i} for i in range(len(names))]
    tree = gltf([laid({"index": i}) for i in range(len(names))], textures=sources, images=names)
    assert len(bob.load(saved(tmp_path, tree)).instances) == 1  # because they look the same
    assert len(decoded) == 1
    mtl = "newmtl a\nmap_Kd t.png\nnewmtl b\nmap_Kd u.png\n"
    assert len(bob.load(obj(tmp_path, mtl, "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n")).instances) == 1
    assert len(decoded) == 2
    broken = {"3D/Textures/paint.png": b"no", "3D/Textures/other.png": b"no"}
    _, warned = told(textured_3mf(tmp_path, broken))
    assert len(decoded) == 3
    assert len(warned) == 1


def test_obj_colors_of_points(tmp_path: Path) -> None:
    mesh = mesh_of(written(tmp_path / "a.obj", "v 0 0 0 1 0.5 0\nv 1 0 0\nv 0 1 0 0 nan 1\nf 1 2 3\n"))
    assert mesh.colors is not None
    assert np.allclose(mesh.colors, [(1, from_srgb(0.5), 0), (1, 1, 1), (0, 1, 1)], atol=1e-6)
    with pytest.warns(bob.InputWarning, match="b.obj: numbers behind points were left out: expected colours in 0..1"):
        assert mesh_of(written(tmp_path / "b.obj", "v 0 0 0 1 2 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")).colors is None


LEAF = np.dstack([np.full((2, 2, 3), 255, np.uint8), np.array([(255, 0), (100, 200)], np.uint8)])
"""Of which the left top and the right bottom are more opaque than not."""


def seen_corners(scene: Any) -> list[list[bool]]:
    """Where a square is there, near the corners of its texture."""
    depth = bob.trace(scene, bob.Camera(elevation=90, azimuth=-90, zoom=1.4), size=(40, 40)).depth
    found: list[list[bool]] = (depth[[[8], [31]], [[8, 31]]] > 0).tolist()
    return found


def test_obj_is_cut_out_by_half_transparent_textures(tmp_path: Path) -> None:
    """map_d's alpha decides, or its brightness if it has no alpha; without map_d, the colour texture's alpha."""
    large = LEAF.repeat(16, 0).repeat(16, 1)
    written(tmp_path / "leaf.png", picture(texels=large))
    written(tmp_path / "other.png", picture(texels=np.ascontiguousarray(255 - large[..., 3])))
    written(tmp_path / "solid.png", picture(texels=large[..., :3].copy()))
    written(tmp_path / "glass.png", picture(texels=np.full((2, 2, 4), 99, np.uint8)))
    cut, otherwise, all_of_it = [[True, False], [False, True]], [[False, True], [True, False]], [[True, True]] * 2
    for maps, expected in (
        ("map_Kd leaf.png", cut),
        ("map_Kd leaf.png\nmap_d leaf.png", cut),
        ("map_Kd solid.png\nmap_d leaf.png", cut),
        ("map_d leaf.png", cut),
        ("map_Kd leaf.png\nmap_d other.png", otherwise),
        ("map_Kd solid.png", all_of_it),
        ("map_Kd glass.png", all_of_it),  # a cutout would leave nothing of it
        ("d 0.1\nmap_Kd solid.png", all_of_it),
    ):
        mesh = mesh_of(obj(tmp_path, f"newmtl a\n{maps}\n"))
        assert seen_corners(mesh) == expected, maps
    (instance,) = bob.load(obj(tmp_path, "newmtl a\nKd 1 0 0\nmap_d leaf.png\n")).instances
    assert instance.material.color == (1, 0, 0)


def test_obj_masks_of_other_sizes_lend_what_is_at_centres(tmp_path: Path) -> None:
    written(tmp_path / "t.png", picture())
    mask = np.array([(0, 10, 20, 30, 40), (50, 60, 70, 80, 90), (200, 210, 220, 230, 240)], np.uint8)
    written(tmp_path / "mask.png", picture(texels=mask))
    mesh = mesh_of(obj(tmp_path, "newmtl a\nmap_Kd -clamp on t.png\nmap_d mask.png\n"))
    assert mesh.texture_alpha is not None
    assert mesh.texture_alpha.tolist() == [[10, 30], [210, 230]]
    assert mesh.wrap == ("clamp", "clamp")


# ---- PLY -------------------------------------------------------------------------------------------------


def ply(folder: Path, vertex: str, face: str = "", *, rows: str, faces: str = "4 0 1 2 3\n", comment: str = "") -> Path:
    head = f"ply\nformat ascii 1.0\n{comment}element vertex 4\n" + rgb("float", ("x", "y", "z")) + vertex
    head += f"element face {faces.count(chr(10))}\nproperty list uchar int vertex_indices\n{face}end_header\n"
    points = ("0 0 0", "1 0 0", "1 1 0", "0 1 0")
    return written(
        folder / "a.ply", head + "".join(f"{a} {b}\n" for a, b in zip(points, rows.splitlines(), strict=True)) + faces
    )


def rgb(kind: str, names: tuple[str, str, str] = ("red", "green", "blue")) -> str:
    return "".join(f"property {kind} {name}\n" for name in names)


@pytest.mark.parametrize(
    ("kind", "row"),
    [("uchar", "255 128 0"), ("ushort", "65535 32896 0"), ("float", "1 0.50196078 0"), ("double", "1 0.50196078 -9")],
)
def test_ply_colors_of_vertices(kind: str, row: str, tmp_path: Path) -> None:
    mesh = mesh_of(ply(tmp_path, rgb(kind), rows=f"{row}\n" * 4))
    assert mesh.colors is not None
    assert np.allclose(mesh.colors, (1, HALF, 0), atol=1e-5)


def test_ply_colors_in_binary(tmp_path: Path) -> None:
    head = "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    head += rgb("uint8", ("diffuse_red", "diffuse_green", "diffuse_blue"))
    head += "element face 1\nproperty list uchar int vertex_index\nend_header\n"
    body = b"".join(struct.pack(">3f3B", *point, 255, 128, 0) for point in ((0, 0, 0), (1, 0, 0), (0, 1, 0)))
    mesh = mesh_of(written(tmp_path / "a.ply", head.encode() + body + struct.pack(">B3i", 3, 0, 1, 2)))
    assert mesh.colors is not None
    assert np.allclose(mesh.colors, (1, HALF, 0), atol=1e-6)


def test_ply_colors_of_mitsuba_are_linear(tmp_path: Path) -> None:
    mesh = mesh_of(ply(tmp_path, rgb("float", ("color_0", "color_1", "color_2")), rows="1 0.5 0\n" * 4))
    assert mesh.colors is not None
    assert np.allclose(mesh.colors, (1, 0.5, 0))


@pytest.mark.filterwarnings("ignore:.*left out 1 face of fewer than three corners")
def test_ply_colors_of_faces(tmp_path: Path) -> None:
    faces = "4 0 1 2 3 255 0 0\n3 0 1 2 0 255 0\n2 0 1 9 9 9\n3 1 2 3 0 0 255\n"
    mesh = mesh_of(ply(tmp_path, "", rgb("uchar"), rows="\n" * 4, faces=faces))
    assert mesh.face_colors is not None
    assert mesh.face_colors.tolist() == [[1, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    mesh = mesh_of(ply(tmp_path, rgb("uchar"), rgb("uchar"), rows="9 9 9\n" * 4, faces=faces))
    assert mesh.face_colors is None
    assert mesh.colors is not None


def test_ply_that_is_white_has_no_colors(tmp_path: Path) -> None:
    assert not mesh_of(ply(tmp_path, rgb("uchar"), rows="255 255 255\n" * 4)).is_colored


def test_ply_texture(tmp_path: Path) -> None:
    """Coordinates of vertices and of corners, and the colours used if the picture is missing."""
    comment = "comment TextureFile the texture.png\n"
    places, rows = "property float s\nproperty float t\n", "0 0 9 9 9\n1 0 9 9 9\n1 1 9 9 9\n0 1 9 9 9\n"
    scene, warned = told(ply(tmp_path, places + rgb("uchar"), rows=rows, comment=comment))
    assert len(warned) == 1
    assert warned[0].startswith("a.ply: texture the texture.png was left out: ")
    shape = scene.instances[0].shape
    assert isinstance(shape, Mesh)
    assert shape.colors is not None

    written(tmp_path / "the texture.png", picture(texels=np.repeat(np.repeat(TEXELS, 16, 0), 16, 1)))
    of_vertices = mesh_of(ply(tmp_path, places + rgb("uchar"), rows=rows, comment=comment))
    assert of_vertices.texture is not None
    assert of_vertices.colors is None
    corners = "4 0 1 2 3 8 0 0 1 0 1 1 0 1\n"
    face = "property list uchar float texcoord\n"
    of_corners = mesh_of(ply(tmp_path, "", face, rows="\n" * 4, faces=corners, comment=comment))
    expected = np.rint(from_srgb(TEXELS / 255))[::-1].transpose(1, 0, 2)
    for mesh in (of_vertices, of_corners):
        assert np.array_equal(corners_of(seen(mesh)), expected)


# ---- glTF ------------------------------------------------------------------------------------------------


def gltf(materials: list[dict[str, Any]], colors: NDArray[Any] | None = None, **more: Any) -> dict[str, Any]:
    """A square in the plane x, z that faces y, once with each material and once without one."""
    points = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]], "<f4")
    places = np.array([[0, 0], [0, 1], [1, 1], [1, 0]], "<f4")
    other = np.rint(places[::-1] * 65535).astype("<u2")
    arrays: list[NDArray[Any]] = [points, np.array([0, 1, 2, 0, 2, 3], "<u2"), places, other]
    arrays += [] if colors is None else [colors]
    kinds = {"float32": 5126, "uint16": 5123, "uint8": 5121}
    attributes = {"POSITION": 0, "TEXCOORD_0": 2, "TEXCOORD_1": 3} | ({} if colors is None else {"COLOR_0": 4})
    primitives = [{"attributes": attributes, "indices": 1, "material": i} for i in range(len(materials))]
    return {
        "asset": {"version": "2.0"},
        "buffers": [
            {"uri": "data:;base64," + base64.b64encode(a.tobytes()).decode(), "byteLength": a.nbytes} for a in arrays
        ],
        "bufferViews": [{"buffer": i, "byteLength": array.nbytes} for i, array in enumerate(arrays)],
        "accessors": [
            {
                "bufferView": i,
                "componentType": kinds[str(array.dtype)],
                "count": len(array),
                "type": "SCALAR" if array.ndim == 1 else f"VEC{array.shape[1]}",
                **({"normalized": True} if array.ndim == 2 and array.dtype.kind == "u" else {}),
            }
            for i, array in enumerate(arrays)
        ],
        "meshes": [{"primitives": primitives or [{"attributes": attributes, "indices": 1}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "materials": materials,
        **more,
    }


def laid(texture: dict[str, Any]) -> dict[str, Any]:
    return {"pbrMetallicRoughness": {"baseColorTexture": texture}}


def saved(folder: Path, tree: dict[str, Any]) -> Path:
    return written(folder / "a.gltf", json.dumps(tree))


def test_gltf_materials(tmp_path: Path) -> None:
    factors = {"baseColorFactor": [0.5, 0.25, 1, 0.3], "metallicFactor": 0.25, "roughnessFactor": 0.75}
    materials = [{"name": "one", "pbrMetallicRoughness": factors, "emissiveFactor": [0, 0, 0.5]}, {}]
    one, other = bob.load(saved(tmp_path, gltf(materials))).instances
    assert one.material == bob.Material((0.5, 0.25, 1), metallic=0.25, roughness=0.75, emissive=(0, 0, 0.5))
    assert other.material == bob.Material(metallic=1, roughness=1)  # the specification's default
    assert (one.name, other.name) == ("one", "a.gltf")
    (plain,) = bob.load(saved(tmp_path, gltf([]))).instances
    assert plain.material == bob.Material()


GLASS = {
    "sheet": ({}, {"KHR_materials_transmission": {"transmissionFactor": 0.75}}, {"transmission": 0.75, "thin": True}),
    "solid": (
        {"roughnessFactor": 0.25, "baseColorFactor": [1, 0.5, 1, 1]},
        {
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_ior": {"ior": 1.33},
            "KHR_materials_volume": {
                "thicknessFactor": 0.1,
                "attenuationDistance": 2,
                "attenuationColor": [0.5, 0.25, 1],
            },
        },
        {"color": (1, 0.5, 1), "ior": 1.33, "roughness": 0.25, "attenuation": (0.5, 0.25, 1), "distance": 2.0},
    ),
    "clear": (
        {},
        {
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 0},
        },
        {},
    ),
    "half metal": (
        {"metallicFactor": 0.5},
        {"KHR_materials_transmission": {"transmissionFactor": 1}},
        {"transmission": 0.5, "thin": True},
    ),
}


@pytest.mark.parametrize("name", GLASS)
def test_gltf_glass(tmp_path: Path, name: str, recwarn: pytest.WarningsRecorder) -> None:
    factors, extensions, expected = GLASS[name]
    material = {"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0} | factors, "extensions": extensions}
    (one,) = bob.load(saved(tmp_path, gltf([material]))).instances
    assert one.material == bob.Glass(**expected)
    assert not recwarn


def test_gltf_clear_coats(tmp_path: Path, recwarn: pytest.WarningsRecorder) -> None:
    coat = {"KHR_materials_clearcoat": {"clearcoatFactor": 0.75, "clearcoatRoughnessFactor": 0.25}}
    (one,) = bob.load(saved(tmp_path, gltf([{"extensions": coat}]))).instances
    assert one.material == bob.Material(metallic=1, roughness=1, clearcoat=0.75, clearcoat_roughness=0.25)
    assert not recwarn


@pytest.mark.parametrize(
    ("extensions", "left_out"),
    [
        (
            {"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatTexture": {"index": 0}}},
            "clearcoat maps",
        ),
        ({"KHR_materials_transmission": {"transmissionFactor": 0}, "KHR_materials_ior": {}}, "KHR_materials_ior"),
        (
            {"KHR_materials_transmission": {"transmissionFactor": 1, "transmissionTexture": {"index": 0}}},
            "transmission maps",
        ),
        ({"KHR_materials_volume": {"thicknessFactor": 1}}, "KHR_materials_volume"),
    ],
)
def test_gltf_glass_that_is_not_shown(tmp_path: Path, extensions: dict[str, Any], left_out: str) -> None:
    material = {"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": extensions}
    with pytest.warns(UserWarning, match=f"not shown: {left_out}$"):
        (one,) = bob.load(saved(tmp_path, gltf([material]))).instances
    assert type(one.material) is bob.Material
    assert one.material.clearcoat == 0


@pytest.mark.parametrize(
    "colors",
    [
        np.array([(255, 128, 0, 7)] * 4, np.uint8),
        np.array([(65535, 32896, 0, 7)] * 4, "<u2"),
        np.array([(1, 128 / 255, 0)] * 4, "<f4"),
    ],
)
def test_gltf_colors_of_vertices_are_linear(colors: NDArray[Any], tmp_path: Path) -> None:
    mesh = mesh_of(saved(tmp_path, gltf([], colors)))
    assert mesh.colors is not None
    assert np.allclose(mesh.colors, (1, 128 / 255, 0), atol=1e-6)


def test_gltf_textures(tmp_path: Path) -> None:
    """In files, in addresses and in buffers; z points towards the eye above, and becomes -y."""
    texels = picture(texels=np.repeat(np.repeat(TEXELS, 16, 0), 16, 1))
    written(tmp_path / "a b.png", texels)
    data = "data:image/png;base64," + base64.b64encode(texels).decode()
    buffered = gltf([])
    buffered["buffers"].append(
        {"uri": data.replace("image/png", "application/octet-stream"), "byteLength": len(texels)}
    )
    view = {"buffer": 4, "byteLength": len(texels)}
    expected = None
    for image in ({"uri": "a%20b.png"}, {"uri": data}, {"bufferView": 4, "mimeType": "image/png"}):
        tree = gltf([laid({"index": 0})], textures=[{"source": 0}], images=[image])
        tree |= {"buffers": buffered["buffers"], "bufferViews": [*tree["bufferViews"], view]}
        mesh = mesh_of(saved(tmp_path, tree))
        assert mesh.texture is not None
        assert mesh.wrap == ("repeat", "repeat")
        found = corners_of(seen(mesh))
        # The texture's top left is at x = 0, y = 0 seen from above, and its bottom left at y = -1.
        expected = np.rint(from_srgb(TEXELS / 255))[::-1].transpose(1, 0, 2)
        assert np.array_equal(found, expected)
    tree["materials"][0] = laid({"index": 0, "texCoord": 1})
    assert np.array_equal(corners_of(seen(mesh_of(saved(tmp_path, tree)))), expected[::-1])


def test_gltf_texture_transforms(tmp_path: Path) -> None:
    """Against the places that three.js makes of them: scaled, turned, then shifted; and with another set of places."""
    written(tmp_path / "t.png", picture())
    plain = gltf([laid({"index": 0})], textures=[{"source": 0}], images=[{"uri": "t.png"}])
    places = mesh_of(saved(tmp_path, plain)).uv
    assert places is not None
    invalid = {"offset": "here", "scale": [1], "rotation": None, "texCoord": []}
    for moved, expected in (
        ({"offset": [0.25, 0.5]}, places + (0.25, 0.5)),
        ({"scale": [2, -3]}, places * (2, -3)),
        ({"rotation": np.pi / 2}, np.stack([places[:, 1], -places[:, 0]], axis=1)),
        (
            {"offset": [0.1, 0.2], "rotation": np.pi / 2, "scale": [2, 3]},
            np.stack([3 * places[:, 1] + 0.1, -2 * places[:, 0] + 0.2], axis=1),
        ),
        ({"texCoord": 1}, places[::-1]),
        (invalid, places),
    ):
        info = {"index": 0, "extensions": {"KHR_texture_transform": moved}}
        scene, warned = told(saved(tmp_path, {**plain, "materials": [laid(info)]}))
        uv = scene.instances[0].shape.uv  # type: ignore[attr-defined]
        assert uv is not None
        assert np.allclose(uv, expected, atol=1e-6)
        names = ", ".join(f"invalid {name}" for name in sorted(invalid))
        assert warned == ([f"a.gltf: not shown: {names}"] if moved is invalid else [])


def test_gltf_samplers(tmp_path: Path) -> None:
    written(tmp_path / "t.png", picture())
    tree = gltf(
        [laid({"index": i}) for i in range(3)],
        textures=[{"source": 0}, {"source": 0, "sampler": 0}, {"source": 0, "sampler": 1}],
        images=[{"uri": "t.png"}],
        samplers=[{"wrapS": 33071, "wrapT": 33648}, {}],
    )
    wraps = [instance.shape.wrap for instance in bob.load(saved(tmp_path, tree)).instances]  # type: ignore[attr-defined]
    assert wraps == [("repeat", "repeat"), ("clamp", "mirror")]  # the third is like the first
    tree["materials"] *= 2
    tree["meshes"] = gltf(tree["materials"])["meshes"]
    assert len(bob.load(saved(tmp_path, tree)).instances) == 2  # equal surfaces stay equal under any wrapping


@pytest.mark.parametrize(
    "more",
    [
        {"textures": [{"source": 0}], "images": [{"uri": "missing.png"}]},
        {"textures": [{"source": 0}], "images": [{"uri": "data:image/png;base64,????"}]},
        {"textures": [{"source": 0}], "images": [{"bufferView": 0}]},
        {"textures": [{"source": 0}], "images": [{"bufferView": 99}]},
        {"textures": [{"source": 0}], "images": [{}]},
        {"textures": [{"source": 7}], "images": {}},
        {"textures": [{}]},
        {"textures": 3},
        {},
    ],
)
def test_gltf_textures_that_cannot_be_read_are_one_warning(more: dict[str, Any], tmp_path: Path) -> None:
    scene, warned = told(saved(tmp_path, gltf([laid({"index": 0}), laid({"index": 0})], **more)))
    assert [instance.shape.is_colored for instance in scene.instances] == [False]
    assert len(warned) == 1
    assert warned[0].startswith("a.gltf: texture ")


@pytest.mark.parametrize("value", [None, 3, "a", [], {}, [[]], ["a", None, {}], 1e999, [1e999, -5, 7]])
def test_gltf_materials_of_nonsense_load(value: Any, tmp_path: Path) -> None:
    for tree in (
        gltf([{}]) | {"materials": value},
        gltf([{"pbrMetallicRoughness": value, "emissiveFactor": value, "name": value}]),
        gltf(
            [{"pbrMetallicRoughness": {"baseColorFactor": value, "metallicFactor": value, "baseColorTexture": value}}]
        ),
        gltf([laid({"index": value, "texCoord": value})], textures=[{"source": value}], images=value),
    ):
        text = json.dumps(tree).replace("Infinity", "1e999")
        assert told(written(tmp_path / "a.gltf", text))[0].counts()["triangle"] == 2


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ({"alphaMode": "MASK"}, [[True, False], [False, True]]),
        ({"alphaMode": "MASK", "alphaCutoff": 0.3}, [[True, False], [True, True]]),
        ({"alphaMode": "MASK", "alphaCutoff": 0.9}, [[True, False], [False, False]]),
        ({"alphaMode": "MASK", "alphaCutoff": 0}, [[True, True], [True, True]]),
        ({"alphaMode": "MASK", "factor": 0.6}, [[True, False], [False, False]]),
        ({"alphaMode": "MASK", "factor": 0.3, "alphaCutoff": 0.2}, [[True, False], [False, True]]),
        ({"alphaMode": "BLEND"}, [[True, False], [False, True]]),
        ({"alphaMode": "BLEND", "factor": 0.1}, [[True, False], [False, True]]),
        ({"alphaMode": "OPAQUE"}, [[True, True], [True, True]]),
        ({"alphaCutoff": 0.9}, [[True, True], [True, True]]),
    ],
)
def test_gltf_alpha_modes(more: dict[str, Any], expected: list[list[bool]], tmp_path: Path) -> None:
    """The texture's alpha times the factor's against the cutoff. Blended surfaces are drawn from half opacity on."""
    image = {"uri": "data:;base64," + base64.b64encode(picture(texels=LEAF.repeat(16, 0).repeat(16, 1))).decode()}
    factor = [1, 1, 1, more.get("factor", 1)]
    material = {**more, "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "baseColorFactor": factor}}
    file = saved(tmp_path, gltf([material], textures=[{"source": 0}], images=[image]))
    assert seen_corners(bob.load(file)) == expected


def test_gltf_alphas_of_vertices_count_where_there_is_a_mask(tmp_path: Path) -> None:
    colors = np.array([(255, 255, 255, 255), (255, 255, 255, 0), (255, 255, 255, 0), (255, 255, 255, 255)], np.uint8)
    for mode, share in (("MASK", 0.5), ("BLEND", 1), ("OPAQUE", 1)):
        mesh = mesh_of(saved(tmp_path, gltf([{"alphaMode": mode}], colors)))
        size, zoom = (60, 60), np.sqrt(2)
        depth = bob.trace(mesh, bob.Camera(elevation=90, azimuth=0, zoom=zoom), size=size).depth
        assert (depth > 0).mean() == pytest.approx(share, abs=0.03)


def test_gltf_that_is_cut_out_whole_is_not_there(tmp_path: Path) -> None:
    gone = {"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.4]}}
    scene = bob.load(saved(tmp_path, gltf([gone, {"name": "left"}])))
    assert [instance.name for instance in scene.instances] == ["a.gltf"]
    with pytest.raises(bob.InputError, match=r"^a\.gltf: expected triangles, got none$"):
        bob.load(saved(tmp_path, gltf([gone])))
    assert bob.load(saved(tmp_path, gltf([gone | {"alphaMode": "BLEND"}]))).counts()["triangle"] == 2


def test_pictures_of_any_kind_have_their_alpha(tmp_path: Path) -> None:
    """Palettes with a transparent colour, and gray."""
    exact: dict[str, Any] = {"webp": {"lossless": True}, "avif": {"quality": 100}}
    for mode, name in (("P", "a.png"), ("LA", "b.png"), ("RGBA", "c.webp"), ("P", "d.gif"), ("RGBA", "e.avif")):
        image = Image.fromarray(LEAF.repeat(8, 0).repeat(8, 1)).convert("RGBA")
        alpha = image.getchannel("A").point(lambda value: 255 * (value >= 128))
        image.putalpha(alpha)
        if mode == "P":
            # White, and black as the transparent colour.
            indices = Image.fromarray((np.asarray(alpha) < 128).astype(np.uint8), "P")
            indices.putpalette([255, 255, 255, 0, 0, 0])
            indices.save(tmp_path / name, transparency=1)
        else:
            image.convert(mode).save(tmp_path / name, **exact.get(name[-4:], {}))
        mesh = mesh_of(obj(tmp_path, f"newmtl a\nmap_Kd {name}\n"))
        assert mesh.texture_alpha is not None, name
        assert np.array_equal(mesh.texture_alpha, np.asarray(alpha))


# ---- 3MF -------------------------------------------------------------------------------------------------


def test_3mf_colors(tmp_path: Path) -> None:
    """Of the object, of triangles, of corners, and of triangles from another group."""
    vertices = "".join(f"<vertex x='{x}' y='{y}' z='{z}'/>" for x, y, z in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)))
    triangles = (
        "<triangle v1='0' v2='1' v3='2'/><triangle v1='0' v2='1' v3='3' p1='0'/>"
        "<triangle v1='0' v2='2' v3='3' pid='6' p1='0' p2='1' p3='1'/><triangle v1='1' v2='2' v3='3' pid='7' p1='3'/>"
    )
    text = (
        "<model xmlns='http://schemas.microsoft.com/3dmanufacturing/core/2015/02' "
        "xmlns:m='http://schemas.microsoft.com/3dmanufacturing/material/2015/02'><resources>"
        "<basematerials id='5'><base name='a' displaycolor='#FF0000FF'/><base name='b' displaycolor='#008000'/>"
        "</basematerials><m:colorgroup id='6'><m:color color='#0000FF'/><m:color color='none'/></m:colorgroup>"
        f"<object id='1' pid='5' pindex='1'><mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles>"
        "</mesh></object></resources><build><item objectid='1'/></build></model>"
    )
    with zipfile.ZipFile(tmp_path / "a.3mf", "w") as archive:
        archive.writestr("3D/3dmodel.model", text)
    mesh = mesh_of(tmp_path / "a.3mf")
    assert mesh.colors is not None
    green, red, blue, white = (0, HALF, 0), (1, 0, 0), (0, 0, 1), (1, 1, 1)
    expected = [[green] * 3, [red] * 3, [blue, white, white], [white] * 3]
    assert np.allclose(mesh.colors[mesh.triangles], expected, atol=1e-6)


def textured_3mf(folder: Path, pictures: dict[str, bytes], texture: str = "", triangles: str = "") -> Path:
    """A square in the plane z = 0, whose left bottom is the texture's, and a triangle of a colour below it."""
    points = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, -1))
    vertices = "".join(f"<vertex x='{x}' y='{y}' z='{z}'/>" for x, y, z in points)
    laid = triangles or (
        "<triangle v1='0' v2='1' v3='2' pid='4' p1='0' p2='1' p3='2'/>"
        "<triangle v1='0' v2='2' v3='3' pid='4' p1='0' p2='2' p3='3'/><triangle v1='0' v2='3' v3='4'/>"
    )
    places = "".join(f"<m:tex2coord u='{u}' v='{v}'/>" for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)))
    texture = texture or "path='/3D/Textures/paint.png' contenttype='image/png'"
    text = (
        "<model xmlns='http://schemas.microsoft.com/3dmanufacturing/core/2015/02' "
        "xmlns:m='http://schemas.microsoft.com/3dmanufacturing/material/2015/02'><resources>"
        f"<m:texture2d id='3' {texture}/><m:texture2dgroup id='4' texid='3'>{places}</m:texture2dgroup>"
        "<basematerials id='5'><base name='a' displaycolor='#FF0000'/></basematerials>"
        f"<object id='1' pid='5' pindex='0'><mesh><vertices>{vertices}</vertices><triangles>{laid}</triangles>"
        "</mesh></object></resources><build><item objectid='1'/></build></model>"
    )
    with zipfile.ZipFile(folder / "a.3mf", "w") as archive:
        archive.writestr("3D/3dmodel.model", text)
        for path, content in pictures.items():
            archive.writestr(path, content)
    return folder / "a.3mf"


def test_3mf_textures(tmp_path: Path) -> None:
    """They count from the bottom up; other triangles of the object keep their colours."""
    paint = {"3D/Textures/Paint.PNG": picture(texels=TEXELS.repeat(16, 0).repeat(16, 1))}  # in any case
    scene, warned = told(textured_3mf(tmp_path, paint))
    assert warned == []
    laid, other = sorted(scene.instances, key=lambda instance: -instance.shape.counts()["triangle"])
    assert isinstance(laid.shape, Mesh)
    assert isinstance(other.shape, Mesh)
    assert laid.shape.wrap == ("repeat", "repeat")
    assert np.array_equal(corners_of(seen(laid)), np.rint(from_srgb(TEXELS / 255))[::-1].transpose(1, 0, 2))
    assert other.shape.face_colors is not None
    assert other.shape.face_colors.tolist() == [[1, 0, 0]]
    styles = "path='/3D/Textures/paint.png' tilestyleu='mirror' tilestylev='none'"
    (laid,) = (
        i for i in bob.load(textured_3mf(tmp_path, paint, styles)).instances if i.shape.counts()["triangle"] == 2
    )
    assert isinstance(laid.shape, Mesh)
    assert laid.shape.wrap == ("mirror", "clamp")


@pytest.mark.parametrize(
    ("pictures", "texture", "message"),
    [
        (
            {},
            "",
            "texture /3D/Textures/paint.png was left out: expected a picture in the file, found none of that name",
        ),
        (
            {"3D/Textures/paint.png": b"no"},
            "",
            "expected a picture in PNG, JPEG, WebP or AVIF, got none that can be read",
        ),
        ({"3D/Textures/paint.png": b"\0" * (1 << 27)}, "", "got a zip file that unpacks to 134,217,728 bytes"),
        ({}, "x='y'", "texture without a path was left out"),
    ],
)
def test_3mf_textures_that_cannot_be_read_are_one_warning(
    pictures: dict[str, bytes], texture: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(zipfile.ZipFile, "writestr", partialmethod(zipfile.ZipFile.writestr, compress_type=8))
    scene, warned = told(textured_3mf(tmp_path, pictures, texture))
    assert scene.counts()["triangle"] == 3
    assert len(warned) == 1
    assert warned[0].startswith("a.3mf: texture ")
    assert message in warned[0]


def test_3mf_textures_have_a_limit_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bobrossnet.adapters.surface.MAX_FILE_TEXELS", 3)
    scene, warned = told(textured_3mf(tmp_path, {"3D/Textures/paint.png": picture()}))
    assert scene.counts()["triangle"] == 3
    assert len(warned) == 1
    assert "expected textures of at most 3 texels in all, got more" in warned[0]


def test_3mf_corners_without_a_place_or_a_point(tmp_path: Path) -> None:
    """The former are at the texture's corner, the latter are left out."""
    paint = {"3D/Textures/paint.png": picture()}
    triangles = (
        "<triangle v1='0' v2='1' v3='2' pid='4' p1='0' p2='9' p3='-1'/><triangle v1='0' v2='2' v3='9' pid='4' p1='0'/>"
        "<triangle v1='0' v2='2' v3='3' pid='4' p1='2'/>"
    )
    scene, warned = told(textured_3mf(tmp_path, paint, "", triangles))
    (instance,) = scene.instances
    assert isinstance(instance.shape, Mesh)
    assert instance.shape.uv is not None
    assert instance.shape.uv.tolist() == [[0, 1], [0, 0], [0, 0], [1, 0], [1, 0], [1, 0]]
    assert warned == ["a.3mf: left out 1 of 3 triangles that touch a missing or non-finite vertex"]
    wrong = paint, "", triangles.replace("v3='3' pid='4'", "v3='x' pid='4'")
    with pytest.raises(bob.InputError, match=r"^a\.3mf: expected numbers, got others"):
        bob.load(textured_3mf(tmp_path, *wrong))


# ---- Real files ------------------------------------------------------------------------------------------


@needs_models
@pytest.mark.filterwarnings("ignore:.*not shown")
def test_real_textures() -> None:
    folder = MODELS / "loader_originals"
    duck = mesh_of(folder / "glb_material/Duck.glb")
    assert duck.texture is not None
    assert duck.texture.shape == (512, 512, 3)
    albedo = bob.trace(duck, size=(64, 64)).albedo
    yellow = albedo[(albedo > 0).any(axis=-1)].mean(axis=0)
    assert yellow[0] > yellow[1] > 3 * yellow[2]
    truck = bob.load(folder / "glb_material/CesiumMilkTruck.glb")
    assert sorted(str(instance.name) for instance in truck.instances) == ["glass", "truck", "window_trim"]
    assert mesh_of(folder / "obj_mtl_fuze/fuze.obj").texture is not None
    fuze, spider = bob.load_mesh(folder / "obj_mtl_fuze/fuze.obj"), told(folder / "obj_mtl_spider/spider.obj")
    assert fuze.texture is not None
    assert len(spider[0].instances) == 4
    assert len(spider[1]) == 1


@needs_models
@pytest.mark.filterwarnings("ignore:.*not shown")
def test_scenes_of_textured_files_are_saved(tmp_path: Path) -> None:
    scene = bob.load(MODELS / "loader_originals/glb_material/CesiumMilkTruck.glb")
    bob.save_scene(scene, tmp_path / "truck.bob")
    assert bob.trace(bob.load(tmp_path / "truck.bob"), size=(48, 64)) == bob.trace(scene, size=(48, 64))
