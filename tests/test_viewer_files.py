"""Scenes and files in the viewer's page: the same pictures as Python's, and one-line errors."""

import base64
import hashlib
import io
import json
import struct
import warnings
import zipfile
import zlib
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from browser import numbers
from gltf_cases import CASES as GLTF_CASES
from models import MODELS, needs_models
from PIL import Image
from test_container import ODD_LIGHTS, with_light
from textures import OTHERS, shared_scene

import bobrossnet as bob
from bobrossnet.adapters import surface as surfaces_of_files
from bobrossnet.adapters.container import layout, sealed
from bobrossnet.page.files import READ_IN_PAGE
from bobrossnet.picture.channels import COLORED
from bobrossnet.support.paths import VIEWER

SIZE = (48, 64)
CAMERA = bob.Camera()

# A separate worker without a document, as in the page.
WORKER = b"""
import { loadCore } from "/core/load.js";
import { Beside } from "/files/beside.js";
import { readFile } from "/files/read.js";
import { GBuffer } from "/picture/gbuffer.js";
import { buildScene } from "/tracing/scene.js";

const cores = { core: loadCore("core", false), mesh: loadCore("core.mesh", false) };
onmessage = async ({ data: { file, name, beside, height, width, camera } }) => {
  try {
    const instance = await (/\\.(ply|obj|stl|off|glb|gltf)$/i.test(name) ? cores.mesh : cores.core);
    const bytes = await (await fetch(file)).arrayBuffer();
    const others = beside.map(([name, url]) => ({ name, arrayBuffer: async () => (await fetch(url)).arrayBuffer() }));
    const description = await readFile(instance, name, bytes, new Beside(others));
    const scene = buildScene(instance, description), gbuffer = new GBuffer(instance, height, width, scene.layout);
    const place = (i) => (7919 * (i >> 1)) % (height * width); // far apart
    const at = (_, i) => i % 2 ? place(i) % width : Math.floor(place(i) / width);
    const pixels = Int32Array.from({ length: 2 * height * width }, at);
    gbuffer.add(pixels, scene.trace(pixels, { height, width }, camera));
    const text = (array) => array && new Uint8Array(array.slice().buffer).toBase64();
    const planes = text(gbuffer.planes), color = text(gbuffer.color);
    gbuffer.free(), scene.free();
    const { warnings = [], instances } = description;
    postMessage({ planes, color, warnings, names: instances.map(({ name }) => name) });
  } catch (error) {
    postMessage({ error: error.message, kind: error.constructor.name, line: error.line });
  }
};
"""

START = "() => { window.worker = new Worker('/tested/worker.js', { type: 'module' }); }"
ASK = """
(request) => new Promise((resolve, reject) => {
  worker.onmessage = ({ data }) => resolve(data);
  worker.onerror = ({ message }) => reject(new Error(message));
  worker.postMessage(request);
})
"""


@contextmanager
def opened(browser, viewer):
    viewer.files["tested/worker.js"] = WORKER
    page = browser.new_page()
    page.goto(viewer.url + "gallery/index.json")
    page.evaluate(START)
    yield page
    page.close()


@pytest.fixture(scope="module")
def page(browser, viewer):
    with opened(browser, viewer) as page:
        yield page


@pytest.fixture
def read(page, viewer):
    return read_by(page, viewer)


def read_by(page, viewer):
    """Return the page's result for a file: `planes`, `color`, `names`, `warnings`; or `error`, `kind`, `line`."""

    def read(file, content=None, camera=CAMERA, beside=()):
        viewer.files["tested/file"] = Path(file) if content is None else content
        others = [[Path(other).name, f"/tested/beside/{i}.bob"] for i, other in enumerate(beside)]
        viewer.files.update({url[1:]: Path(other) for (_, url), other in zip(others, beside, strict=True)})
        place = {"file": "/tested/file", "name": Path(file).name, "beside": others, "height": SIZE[0], "width": SIZE[1]}
        angles = {angle: getattr(camera, angle) for angle in ("azimuth", "elevation", "roll", "zoom")}
        found = page.evaluate(ASK, {**place, "camera": angles})
        if "planes" in found:
            found["planes"] = numbers(found["planes"]).reshape(-1, *SIZE)
            color = found["color"]
            found["color"] = None if color is None else numbers(color).reshape(3, *SIZE)
        return found

    return read


def assert_equal_pictures(found, scene, camera=CAMERA, pixels=0):
    """All except a few pixels are within rounding of Python's, in another instruction set and order of sums."""
    assert "error" not in found, found["error"]
    expected = bob.trace(scene, camera, size=SIZE)
    assert expected.depth.any()  # something is seen
    different = (np.abs(found["planes"] - expected.stack()) > 1e-4).any(axis=0)
    assert (found["color"] is not None) == (expected.layout == COLORED)
    if found["color"] is not None:
        different |= (np.abs(found["color"] - np.moveaxis(expected.color, -1, 0)) > 1e-4).any(axis=0)
    assert np.count_nonzero(different) <= pixels


@pytest.fixture
def same(read, tmp_path):
    """Return a check that the page's picture of a file with this content is Python's."""

    def same(name, content, **options):
        file = tmp_path / name
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            scene = bob.load(file)
        found = read(file)
        assert_equal_pictures(found, scene, **options)
        assert len(found["warnings"]) == len(told)
        return found

    return same


# ---- Scenes ----------------------------------------------------------------------------------------------


def test_gallery_is_there(viewer):
    for entry in json.loads((VIEWER / "gallery/index.json").read_bytes()):
        assert f"gallery/{entry['file']}" in viewer.files


def test_gallery_is_what_its_script_writes(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[1] / "docs")
    from page_gallery import FOLDER, write

    write(tmp_path)
    for file in tmp_path.glob("*.bob"):
        made, shipped = bob.load(file).instances, bob.load(FOLDER / file.name).instances
        for one, other in zip(made, shipped, strict=True):
            np.testing.assert_allclose(one.transform, other.transform, atol=1e-12)  # sines differ between machines
            for name, tensor in one.shape.tensors().items():
                np.testing.assert_allclose(tensor, other.shape.tensors()[name], atol=1e-12)
    assert (tmp_path / "index.json").read_bytes() == (FOLDER / "index.json").read_bytes()


BOX = bob.Mesh(
    [(x, y, z) for x in (0, 1) for y in (0, 2) for z in (0, 3)],
    [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
     (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)],
)  # fmt: skip


def test_instances_stand_where_python_places_them(read, tmp_path):
    """Any affine map, a material for each, and shapes of every kind."""
    from bobrossnet.sdf import Mesh, capsule, sphere

    skewed = np.array([(1, 0.5, 0, 3), (0, -1, 0.2, 0), (0.3, 0, 2, -1), (0, 0, 0, 1)])
    matte = bob.Material("#804020", specular=0)
    hill = bob.nurbs_surface(
        [[(x, y, x * (3 - x) * y * (3 - y) / 2) for y in range(4)] for x in range(4)],
        [0, 0, 0, 0, 1, 1, 1, 1],
        [0, 0, 0, 0, 1, 1, 1, 1],
        weights=np.linspace(1, 5, 16).reshape(4, 4),
        trims=[[(0, 0), (1, 0), (1, 1), (0, 1)], [(0.6, 0.4), (0.9, 0.4), (0.9, 0.6), (0.6, 0.6)]],
    )
    arch = bob.nurbs_curve([(0, 0, 0), (0, 0, 3), (0, 3, 3)], [0, 0, 0, 1, 1, 1], [1, 0.5, 1], radius=[0.1, 0.3, 0.1])
    scene = bob.Scene(
        [
            bob.Instance(BOX, skewed, matte, "box"),
            bob.Instance(sphere(1) - sphere(0.6, (1, 0, 0))).scale((1, 2, 0.5)).rotate(1, (1, 2, 3)),
            bob.Instance(sphere(1e3) & capsule((0, 0, 0), (0, 0, 2), 0.5), material=matte).translate((0, -3, 0)),
            bob.Instance(hill).rotate(0.7).translate((-4, 0, 0)),
            bob.Instance(arch, skewed),
            bob.Instance(Mesh(BOX.vertices, BOX.triangles).sdf().shell(0.2) - sphere(1)).translate((4, 0, 0)),
        ]
    )
    bob.save_scene(scene, tmp_path / "all.bob")
    camera = bob.Camera(azimuth=70, elevation=-10, roll=20, zoom=1.5)
    assert_equal_pictures(read(tmp_path / "all.bob", camera=camera), scene, camera, pixels=3)


def test_formulas_and_faces_have_their_colors(read, same, tmp_path):
    from bobrossnet.sdf import box, sphere, torus

    corners = [[(x, y, 0.3 * x * y) for y in (-1, 1)] for x in (-1, 1)]
    sheets = [bob.Face(np.add(corners, (0, 0, i)), [0, 0, 1, 1], [0, 0, 1, 1], color=color)
              for i, color in enumerate(("#c33", None, (0, 0.5, 1)))]  # fmt: skip
    ball = sphere(1).color(lambda p: 0.5 + 0.5 * np.sin(7 * p)) - box(1).translate((0.8, -0.8, 0.5)).color("#fd3")
    scene = bob.Scene(
        [
            bob.Instance(ball, material=bob.Material("#fea")).scale((1, 2, 0.5)).rotate(1, (1, 2, 3)),
            bob.Instance(ball | torus(1.2, 0.2).color("#393").k(0.2)).translate((3, 0, 0)),
            bob.Instance(bob.Brep(sheets)).translate((-4, 0, 0)),
        ]
    )
    bob.save_scene(scene, tmp_path / "colored.bob")
    found = read(tmp_path / "colored.bob")
    assert_equal_pictures(found, scene, pixels=8)
    assert (np.ptp(found["color"], axis=0) > 0.2).sum() > 100
    same("a.sdf", "f = sphere(1).color('#c33') & box(1.5)\nf - cylinder(0.5).color((0, 0.25, 1)).k(0.1)\n", pixels=8)


def test_where_surfaces_coincide_the_same_one_is_seen(read, tmp_path):
    """In any order of the file."""
    colors = [bob.Material((level, level, level)) for level in (0.1, 0.5, 0.9)]
    instances = [bob.Instance(BOX, material=color) for color in colors]
    pictures = []
    for i in range(3):
        bob.save_scene([*instances[i:], *instances[:i]], tmp_path / "box.bob")
        pictures.append(read(tmp_path / "box.bob"))
        assert_equal_pictures(pictures[-1], instances)
    assert np.array_equal(pictures[0]["planes"], pictures[1]["planes"])


@pytest.mark.parametrize("has_own", [True, False], ids=["browser", "core"])
def test_checksums(page, has_own):
    """In one part or several; the core's checksum if browsers do not hash for the page."""
    for size in (0, 3, 55, 56, 64, 119, 120, 1000, 2**20 + 1):
        data = bytes(7 * i % 256 for i in range(size))
        digest = """async ([size, hasOwn]) => {
          const { loadCore } = await import("/core/load.js"), { sha256 } = await import("/core/sha256.js");
          if (!hasOwn) Object.defineProperty(globalThis, "crypto", { value: {}, configurable: true });
          const bytes = Uint8Array.from({ length: size }, (_, i) => 7 * i), core = await loadCore();
          const whole = await sha256(core, bytes), part = (...ends) => bytes.subarray(...ends), third = size / 3;
          const parts = await sha256(core, part(0, third), part(third, third), part(third));
          delete globalThis.crypto;
          return [Array.from(whole), Array.from(parts)];
        }"""
        for found in page.evaluate(digest, [size, has_own]):
            assert bytes(found) == hashlib.sha256(data).digest()


def test_neither_unit_nor_distance_costs_precision(read, tmp_path):
    for name, scale, offset in (("large", 1e90, 1e90), ("small", 1e-90, 0.0), ("far", 1.0, 1e6)):
        mesh = bob.Mesh(BOX.vertices * scale + offset, BOX.triangles)
        bob.save_scene(mesh, tmp_path / f"{name}.bob")
        assert_equal_pictures(read(tmp_path / f"{name}.bob"), BOX, pixels=2)


# ---- Languages -------------------------------------------------------------------------------------------


SQUARES = "x var-x\ny var-y\nz var-z\na square x\nb square y\nc square z\nd add a b\ne add d c\n"


def test_scripts_and_formulas(same):
    same("ball.sdf", "R = 1\nsphere(R) - box(1.2)\n")
    same("unbounded.vm", "x var-x\ny var-y\nr const 0.3\na add x y\nz var-z\nb add a z\nc sub b r\n")
    same("flat.vm", "x var-x\ny var-y\nr const 0.3\na square x\nb square y\nc add a b\nd sub c r\n")
    same("round.vm", f"{SQUARES}r const 9\nf sub e r\n")


def test_mistakes_in_texts_tell_their_line(read):
    wrong = read("a.sdf", b"a = 1\nb = sphere(\n")
    assert wrong["error"].startswith("a.sdf: line 2, column ")
    assert (wrong["kind"], wrong["line"]) == ("CoreError", 2)
    wrong = read("a.vm", b"x var-x\ny nothing x\n")
    assert wrong["error"].startswith("a.vm: line 2: ")
    assert wrong["line"] == 2
    for name, text, what in (
        ("a.sdf", b"plane()", "shape: expected "),
        ("a.sdf", b"sphere(1) & sphere(1).translate(X * 5)", "shape: expected a "),
        ("a.vm", f"{SQUARES}o const 1\nf add e o\n".encode(), "shape: expected a formula that is negative somewhere"),
    ):
        wrong = read(name, text)
        assert wrong["error"].startswith(what)
        assert (wrong["kind"], wrong["line"]) == ("CoreError", None)


# ---- Meshes ----------------------------------------------------------------------------------------------

POINTS = "0 0 0\n1 0 0\n1 2 0\n0 2 0\n0 0 3\n1 0 3\n1 2 3\n0 2 3\n"
SIDES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
FAR = np.array(POINTS.split(), float).reshape(-1, 3) + (4.5e5, 5.2e6, 0)


def ply(form, vertex, corner, faces=SIDES):
    """Return a box with polygons; `vertex` and `corner` are struct's letters."""
    names = {"f": "float", "d": "double", "i": "int", "H": "ushort"}
    head = f"""ply
format {form} 1.0
comment a box
element vertex 8
property {names[vertex]} x
property {names[vertex]} y
property {names[vertex]} z
property uchar red
element face {len(faces)}
property list uchar {names[corner]} vertex_indices
element edge 3
property int vertex1
end_header
"""
    order = "<" if "little" in form else ">"
    body = b"".join(struct.pack(f"{order}3{vertex}B", *map(float, p.split()), 7) for p in POINTS.splitlines())
    for face in faces:
        body += struct.pack(f"{order}B{len(face)}{corner}", len(face), *face)
    return head.encode() + body + bytes(12)


def test_ply(same):
    same("little.ply", ply("binary_little_endian", "f", "i"))
    same("big.ply", ply("binary_big_endian", "d", "H"))
    same("mixed.ply", ply("binary_little_endian", "f", "i", [SIDES[0], (4, 5, 6), (), (0, 1, 2, 3, 4, 5), SIDES[1]]))
    corners = [(0, 2, 1), (0, 3, 2)]  # triangles have a fast path for leading rows
    for form in ("little", "big"):
        same("triangles.ply", ply(f"binary_{form}_endian", "f", "i", [*corners, (4, 5, 6), (4, 6, 7)]))
        same("first.ply", ply(f"binary_{form}_endian", "f", "i", [*corners, *SIDES[1:], corners[0]]))
    header = "ply\nformat ascii 1.0\nelement vertex 8\n"
    axes = "property double x\nproperty double y\nproperty double z\n"
    faces = "element face 6\nproperty list uchar int vertex_index\nend_header\n"
    sides = "".join(f"4 {' '.join(map(str, side))}\n" for side in SIDES)
    same("text.ply", header + axes + faces + POINTS + sides)
    same("text.ply", (header + axes + faces + POINTS + sides).replace("\n", "\r\n"))
    lists = faces.replace("element face", "property list int int of_vertex\nelement face")
    same("lists.ply", header + axes + lists + POINTS.replace("\n", " 2 7 7\n") + sides)
    same("far.ply", header + axes + faces + "".join(f"{x} {y} {z}\n" for x, y, z in FAR) + sides)
    normals = axes + "property float nx\nproperty float ny\nproperty float nz\n"
    points = "".join(f"{p} {p}\n" for p in POINTS.replace("0 0 0", "nan 0 0").replace("nan", "0.1").splitlines())
    same("normals.ply", header + normals + faces + points + sides)
    strips = "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    same("strips.ply", header + axes + strips + POINTS + "9 0 1 3 2 -1 4 5 7 6\n")


def test_obj(same):
    points = "".join(f"v {p}\n" for p in POINTS.splitlines())
    sides = "".join(f"f {' '.join(str(i + 1) for i in side)}\n" for side in SIDES)
    same("a.obj", points + sides)
    same("far.obj", "".join(f"v {x} {y} {z}\n" for x, y, z in FAR) + sides)
    same("relative.obj", points + "o one\nf -8 -7 -6 -5\nv 0 0 9\nf -1 1 2\nusemtl none\nf 1 -1 2 # and a comment\n")
    same("some.obj", points + "vn 0 0 1\nf 1//1 2//1 3//1\nf 5 6 7 8\nf 1/1 2/1 6/1 5/1\nf 1//1 4//9 3//1\n")
    same("longer.obj", points + "f 1 2 \\\n 3 4\n\tf 5 6 7\t8\n")
    same("normals.obj", points + "vn 0 0 1\nvn 1 0 1\nf 1//1 2//2 3//1\nf 5//2 6//2 7//1 8//1\n")
    same("colours.obj", "".join(f"v {p} 1 0.5 0\n" for p in POINTS.splitlines()) + sides)
    found = same("missing.obj", points + sides + "f 1 2 99\n")
    assert found["warnings"] == ["missing.obj: left out 1 of 13 triangles that touch a missing or non-finite vertex"]


def test_stl(same):
    corners = np.array(POINTS.split(), np.float32).reshape(-1, 3)[[(0, 2, 1), (0, 1, 5), (0, 5, 2)]]
    facets = b"".join(struct.pack("<12fH", 9, 9, 9, *facet.ravel(), 0) for facet in corners)
    same("a.stl", b"solid but binary".ljust(80) + struct.pack("<I", 3) + facets)
    text = ""
    for facet in corners:
        vertices = "".join(f"  vertex {x} {y} {z}\n" for x, y, z in facet)
        text += f"facet normal 0 0 1\n outer loop\n{vertices} endloop\nendfacet\n"
    same("text.stl", f"solid caf\u00e9\n{text}endsolid\n")


def test_off(same):
    sides = "".join(f"4 {' '.join(map(str, side))}\n" for side in SIDES)
    same("a.off", f"OFF\n# a box\n8 6 0\n{POINTS}{sides}")
    same("a.off", f"OFF 8 6 12\n\n{POINTS}{sides.replace('0 3 2 1', '0 3 2 1 255 0 0')}")


def glb(tree, binary=b""):
    text = json.dumps({"asset": {"version": "2.0"}, **tree}).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def box_glb(nodes, **more):
    corners = np.array(POINTS.split(), np.float32)
    triangles = np.array([t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))], np.uint16)
    return glb(
        {
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": nodes,
            "meshes": [
                {"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1, "material": 0}]},
                {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]},
            ],
            "buffers": [{"byteLength": corners.nbytes + triangles.nbytes}],
            "bufferViews": [
                {"buffer": 0, "byteLength": corners.nbytes},
                {"buffer": 0, "byteOffset": corners.nbytes, "byteLength": triangles.nbytes},
            ],
            "accessors": [
                {
                    "bufferView": 0,
                    "componentType": 5126,
                    "count": 8,
                    "type": "VEC3",
                    "min": [0, 0, 0],
                    "max": [1, 2, 3],
                },
                {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
            ],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
            "textures": [{"source": 0}],
            "images": [{"uri": "missing.png"}],
            **more,
        },
        corners.tobytes() + triangles.tobytes(),
    )


def test_glb(same, page):
    """Nested nodes, one of them mirrored, y up; the unused picture is not decoded."""
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    turned = {"rotation": [0.5, 0.5, 0.5, 0.5], "children": [1, 2]}
    same("a.glb", box_glb([{"mesh": 1}]))
    mirrored = {"mesh": 0, "scale": [1, -2, 0.5], "translation": [3, 0, 1]}
    same("a.glb", box_glb([turned, mirrored, {"mesh": 1, "scale": [2, 2, 2]}]))
    assert not [url for url in asked if "missing" in url]


def outcome(load, file):
    try:
        return load(file)
    except bob.InputError as error:
        return error


THREEMF_CASES = ["3mf-beams/floor-and-beams", "3mf-colors-of-corners/box", "3mf-names/space", "3mf-slices/box"]


@pytest.mark.parametrize("name", THREEMF_CASES)
def test_cases_of_3mf(name, same):
    same("a.3mf", (Path(__file__).parent / f"cases/{name}.3mf").read_bytes())


def test_3mf_with_textures_and_beams_in_places(same, read, tmp_path):
    core, microsoft = (
        "http://schemas.microsoft.com/3dmanufacturing/core/2015/02",
        "http://schemas.microsoft.com/3dmanufacturing",
    )
    corners = ((0, 0, 0), (1, 0, 0), (1, 1, 0.5), (0, 1, 0))
    vertices = "".join(f"<vertex x='{x}' y='{y}' z='{z}'/>" for x, y, z in corners)
    places = "".join(f"<m:tex2coord u='{u}' v='{v}'/>" for u, v in ((0, 0), (2, 0), (2, 2), (0, 2)))
    beams = "<b:beam v1='0' v2='1' p1='0'/><b:beam v1='1' v2='2' r1='.2' r2='.1'/>"
    text = (
        f"<model unit='inch' xmlns='{core}' xmlns:m='{microsoft}/material/2015/02' "
        f"xmlns:b='{microsoft}/beamlattice/2017/02'><resources>"
        "<m:texture2d id='3' path='/3D/paint.png' tilestyleu='mirror'/>"
        f"<m:texture2dgroup id='4' texid='3'>{places}</m:texture2dgroup>"
        "<m:colorgroup id='5'><m:color color='#FF8000'/></m:colorgroup>"
        f"<object id='1' name='cloth'><mesh><vertices>{vertices}</vertices><triangles>"
        "<triangle v1='0' v2='1' v3='2' pid='4' p1='0' p2='1' p3='2'/><triangle v1='0' v2='2' v3='3' pid='5' p1='0'/>"
        "</triangles></mesh></object>"
        f"<object id='2' name='frame' pid='5'><mesh><vertices>{vertices}</vertices><triangles/>"
        f"<b:beamlattice radius='0.05' minlength='0.001'><b:beams>{beams}</b:beams></b:beamlattice></mesh></object>"
        "<object id='6'><components><component objectid='1'/>"
        "<component objectid='2' transform='0 1 0 -1 0 0 0 0 1 1 0 0'/></components></object></resources>"
        "<build><item objectid='6'/><item objectid='2'/></build></model>"
    )
    texels = np.random.default_rng(3).integers(0, 255, (4, 6, 3), np.uint8)
    content, picture = io.BytesIO(), io.BytesIO()
    Image.fromarray(texels).save(picture, "PNG")
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", text)
        archive.writestr("3D/paint.png", picture.getvalue())
    found = same("a.3mf", content.getvalue(), pixels=2)
    assert sorted(found["names"]) == sorted(instance.name for instance in bob.load(tmp_path / "a.3mf").instances)
    damaged = content.getvalue().replace(b"PK\5\6", b"PK\5\7")
    problem = "expected a zip file that can be unpacked, got another (no directory at its end)"
    assert read("b.3mf", damaged)["error"] == f"b.3mf: {problem}"


def test_formulas_of_3mf(same, tmp_path):
    from bobrossnet.sdf import Mesh, d3

    box = d3.box(1).mesh(0.5)
    carved = d3.sphere(0.7).color("#ff8000") - Mesh(box.vertices, box.triangles).sdf().translate((0.5, 0, 0))
    for name, shape in {"carved": carved, "bent": d3.box((4, 0.6, 0.6)).bend(0.7).color("#0080ff")}.items():
        shape.save(tmp_path / "written.3mf")
        same(f"{name}.3mf", (tmp_path / "written.3mf").read_bytes(), pixels=6)


@pytest.mark.parametrize("name", GLTF_CASES)
def test_cases_of_gltf(name, read):
    """As in Python, where their numbers are tested (test_gltf.py), with the same words."""
    file = Path(__file__).parent / "cases" / name
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        scene = outcome(bob.load, file)
    found = read(file)
    if isinstance(scene, bob.InputError):
        assert found["error"] == str(scene)
        return
    assert found["warnings"] == [str(warning.message) for warning in told]
    assert_equal_pictures(found, scene, pixels=2)


# ---- Colours ---------------------------------------------------------------------------------------------


def test_colors_of_points_and_faces(same):
    head = "ply\nformat ascii 1.0\ncomment TextureFile t.png\nelement vertex 8\nproperty float x\nproperty float y\n"
    head += "property float z\n"
    colors = [f"{37 * i % 256} {91 * i % 256} {255 - 30 * i}" for i in range(8)]
    sides = [f"4 {' '.join(map(str, side))}" for side in SIDES]

    def ply(names, rows, of_faces="", faces=sides):
        points = "".join(f"{point} {row}\n" for point, row in zip(POINTS.splitlines(), rows, strict=True))
        corners = f"element face {len(faces)}\nproperty list uchar int vertex_indices\n{of_faces}end_header\n"
        return head + names + corners + points + "".join(f"{face}\n" for face in faces)

    def properties(kind, *names):
        return "".join(f"property {kind} {name}\n" for name in names)

    none = [""] * 8
    rgb = properties("uchar", "red", "green", "blue")
    found = same("vertices.ply", ply(rgb, colors))
    assert found["color"] is not None
    same("short.ply", ply(properties("ushort", "diffuse_red", "diffuse_green", "diffuse_blue"), ["65535 9000 0"] * 8))
    same("float.ply", ply(properties("float", "red", "green", "blue"), ["1 nan 0.2", *["0.3 7 -2"] * 7]))
    same("mitsuba.ply", ply(properties("float", "color_0", "color_1", "color_2"), ["1 0.5 0.2"] * 8))
    mixed = [f"{side} {color}" for side, color in zip([*sides, "3 0 1 2", "1 0"], colors, strict=True)]
    same("faces.ply", ply("", none, rgb, mixed))
    same("both.ply", ply(rgb, colors, rgb, mixed))
    assert same("white.ply", ply(rgb, ["255 255 255"] * 8))["color"] is None
    found = same("texture.ply", ply(properties("float", "s", "t"), ["0.5 0.5"] * 8))
    assert len(found["warnings"]) == 1

    faces = "".join(f"f {' '.join(str(i + 1) for i in side)}\n" for side in SIDES)
    points = POINTS.splitlines()
    same("some.obj", "".join(f"v {p}{' 0.2 0.7 nan' * (i % 3 == 1)}\n" for i, p in enumerate(points)) + faces)
    normals = faces.replace("f 1 4 3 2", "f 1//1 4//1 3//1 2//1")
    same("normals.obj", "".join(f"v {p} 0.{i} 1 0.5\n" for i, p in enumerate(points)) + "vn 0 0 1\n" + normals)
    assert same("large.obj", "".join(f"v {p} 255 0 0\n" for p in points) + faces)["color"] is None
    found = same("materials.obj", "mtllib a.mtl\n" + "".join(f"v {p}\n" for p in points) + "usemtl a\n" + faces)
    assert len(found["warnings"]) == 1


def textured_glb(channels=3, **changes):
    """Return a box of three materials, one of them with a texture, and vertex colours."""
    texels = np.random.default_rng(0).integers(0, 256, (5, 7, channels), np.uint8)
    picture = io.BytesIO()
    Image.fromarray(texels).save(picture, "PNG")
    corners = np.array(POINTS.split(), np.float32)
    triangles = np.array([t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))], np.uint16)
    places = np.random.default_rng(1).uniform(-1, 2, (8, 2)).astype(np.float32)
    bytes_of_places = np.random.default_rng(2).integers(0, 65536, (8, 2), np.uint16)
    colors = np.random.default_rng(3).integers(0, 256, (8, 4), np.uint8)
    views, accessors, binary = [], [], b""
    kinds = {"float32": 5126, "uint16": 5123, "uint8": 5121}
    for array, kind in ((corners.reshape(-1, 3), "VEC3"), (triangles.reshape(-1), "SCALAR"), (places, "VEC2"),
                        (bytes_of_places, "VEC2"), (colors, "VEC4")):  # fmt: skip
        accessor = {
            "bufferView": len(views),
            "componentType": kinds[str(array.dtype)],
            "count": len(array),
            "type": kind,
        }
        accessors.append(accessor | ({"normalized": True} if array.dtype.kind == "u" and kind != "SCALAR" else {}))
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": array.nbytes})
        binary += array.tobytes() + bytes(-array.nbytes % 4)
    views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(picture.getvalue())})
    binary += picture.getvalue()
    accessors[1]["count"] = 12
    accessors += [accessors[1] | {"byteOffset": 24}, accessors[1] | {"byteOffset": 48}]
    attributes = {"POSITION": 0, "TEXCOORD_0": 2, "TEXCOORD_1": 3}
    tree = {
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "scale": [1, -1, 2]}],
        "meshes": [
            {
                "primitives": [
                    {"attributes": attributes, "indices": 1, "material": 0},
                    {"attributes": attributes | {"COLOR_0": 4}, "indices": 5, "material": 1},
                    {"attributes": attributes | {"COLOR_0": 4}, "indices": 6},
                ]
            }
        ],
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": views,
        "accessors": accessors,
        "materials": [
            {"name": "laid", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0.2}},
            {"pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.5, 0.2, 1], "roughnessFactor": 0.3}},
        ],
        "textures": [{"source": 0}, {"source": 0, "sampler": 0}],
        "images": [{"bufferView": 5, "mimeType": "image/png"}],
        "samplers": [{"wrapS": 33071, "wrapT": 33648}],
    }
    return glb({**tree, **changes}, binary)


def test_materials_and_textures_of_glb(same):
    found = same("a.glb", textured_glb())
    assert found["color"] is not None
    assert sorted(found["names"]) == ["a.glb", "a.glb", "laid"]
    laid = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 1, "texCoord": 1}}, "emissiveFactor": [0, 0.1, 0]}]
    same("other.glb", textured_glb(materials=laid * 2))
    found = same("none.glb", textured_glb(images=[{"bufferView": 0}]))
    assert len(found["warnings"]) == 1
    same("nonsense.glb", textured_glb(materials=[{"pbrMetallicRoughness": {"baseColorFactor": [-3, "a"]}}, 3]))
    same("missing.glb", textured_glb(materials=[{}]))
    clamped = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}}
    found = same("alike.glb", textured_glb(materials=[clamped] * 2))
    assert len(found["names"]) == 2  # names of the two materials, and of faces without one
    moved = {"offset": [0.3, -0.2], "rotation": 0.7, "scale": [1.5, 0.6], "texCoord": 1}
    laid = {"index": 0, "extensions": {"KHR_texture_transform": moved}}
    same("moved.glb", textured_glb(materials=[{"pbrMetallicRoughness": {"baseColorTexture": laid}}] * 2))
    same("coarse.glb", textured_glb(nodes=[{"mesh": 0, "scale": [1, 1, 0.01]}]))  # whose faces meet at small angles


def png_head(width, height):
    """Return a PNG that declares many texels and contains no pixel data."""
    head = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(chunk) - 4) + chunk + struct.pack(">I", zlib.crc32(chunk)) for chunk in (head, b"IDATno")
    )


def of_pictures(pictures, **more):
    """Return a box for each of the pictures, by content, each with a separate material."""
    uris = [{"uri": "data:image/png;base64," + base64.b64encode(picture).decode()} for picture in pictures]
    attributes = {"POSITION": 0, "TEXCOORD_0": 2}
    primitives = [{"attributes": attributes, "indices": 1, "material": i} for i in range(len(pictures))]
    laid = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}, **more} for i in range(len(pictures))]
    points = {"bufferView": 0, "componentType": 5126, "count": 8}
    corners = {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}
    return box_glb(
        [{"mesh": 0}], images=uris, meshes=[{"primitives": primitives}], materials=laid,
        textures=[{"source": i} for i in range(len(pictures))],
        accessors=[points | {"type": "VEC3"}, corners, points | {"type": "VEC2"}],
    )  # fmt: skip


def warnings_of(read, file, content, beside=()):
    """Return the warnings about a file, which are equal in both hosts."""
    file.write_bytes(content)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        bob.load(file)
    expected = [str(warning.message) for warning in told]
    assert read(file, beside=beside)["warnings"] == expected
    return expected


def test_pictures_are_refused_before_they_are_decoded(read, tmp_path):
    """By the sizes in their headers, with Python's words. Each of the first uses up its share of the budget."""
    pictures = [png_head(30_000, 30_000), *(png_head(8192, 8191 - i) for i in range(3))]
    unreadable, most = (
        "expected a picture in PNG, JPEG, WebP or AVIF, got none that can be read",
        "134,217,728 texels in all",
    )
    assert warnings_of(read, tmp_path / "a.glb", of_pictures(pictures)) == [
        "a.glb: texture 0 was left out: expected a picture of at most 67,108,864 texels, got more",
        f"a.glb: texture 1 was left out: {unreadable}",
        f"a.glb: texture 2 was left out: {unreadable}",
        f"a.glb: texture 3 was left out: expected textures of at most {most}, got more",
    ]


def test_equal_pictures_are_decoded_once(read):
    """With 8 x 4,096 x 4,096 texels, the maximum of a file, nine would be too many."""
    file = io.BytesIO()
    Image.fromarray(np.zeros((4096, 4096), np.uint8)).save(file, "PNG")
    assert read("a.glb", of_pictures([file.getvalue()] * 9))["warnings"] == []


def test_masks_count_in_the_budget(read, tmp_path):
    """A mask and a colour combine to a separate picture."""
    Image.new("L", (1024, 1024)).save(tmp_path / "mask.png")
    for i, height in enumerate((8191, 8063)):  # which leaves 16,384 texels
        (tmp_path / f"{i}.png").write_bytes(png_head(8192, height))
    library = "newmtl a\nmap_Kd 0.png\nnewmtl b\nmap_Kd 1.png\nnewmtl c\nmap_d mask.png\n"
    (tmp_path / "a.mtl").write_text(library)
    text = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n"
    text += b"".join(b"usemtl %c\nf 1/1 2/1 3/1\n" % name for name in b"abc")
    beside = [tmp_path / name for name in ("a.mtl", "mask.png", "0.png", "1.png")]
    *_, told = warnings_of(read, tmp_path / "a.obj", text, beside)
    assert told == "a.obj: the mask of c was left out: expected textures of at most 134,217,728 texels in all, got more"


SIZE_OF = """async ([bytes, sizes]) => {
  const { sizeOfPicture } = await import("/files/picture_head.js"), all = Uint8Array.fromBase64(bytes);
  return sizes.map((size) => sizeOfPicture(all.subarray(0, size)) ?? null);
}"""
FORMS = ["PNG", "GIF", "BMP", "JPEG", "progressive JPEG", "WEBP", "lossless WEBP", "WEBP of RGBA", "AVIF of RGBA"]


@pytest.mark.parametrize("form", FORMS)
def test_sizes_of_pictures_are_in_their_heads(form, page):
    *kinds, name = form.removesuffix(" of RGBA").split()
    image = Image.fromarray(np.random.default_rng(0).integers(0, 256, (37, 301, 4), np.uint8))
    image = image if form.endswith("RGBA") else image.convert("RGB")
    more = {"exif": b"Exif\0\0" + bytes(3000), "icc_profile": bytes(70_000)} if name == "JPEG" else {}
    file = io.BytesIO()
    image.save(file, name, **dict.fromkeys(kinds, True), **more)
    data = file.getvalue()
    sizes = page.evaluate(SIZE_OF, [base64.b64encode(data).decode(), [len(data), 0, 1, 2, 3, 5, 8]])
    assert sizes == [{"width": 301, "height": 37}, *[None] * 6]  # the others truncated


@pytest.mark.parametrize("form", ["JPEG", "PNG"])
def test_pictures_lie_as_they_are_stored(form, read, tmp_path):
    """Exif turns photographs, which browsers show upright; texture coordinates refer to the stored texels."""
    exif = Image.Exif()
    exif[0x0112] = 6
    texels = np.repeat(np.repeat([[(230, 25, 25), (25, 200, 25)], [(25, 25, 230), (230, 230, 25)]], 16, 0), 48, 1)
    Image.fromarray(texels.astype(np.uint8)).save(tmp_path / "t.png", form, exif=exif)
    (tmp_path / "a.mtl").write_text("newmtl a\nmap_Kd t.png\n")
    points = "v 0 0 0\nv 0 1 0\nv 0 1 1\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    file = tmp_path / "a.obj"
    file.write_text(f"mtllib a.mtl\n{points}usemtl a\nf 1/1 2/2 3/3 4/4\n")
    found = read(file, beside=[tmp_path / "a.mtl", tmp_path / "t.png"])
    assert_equal_pictures(found, bob.load(file), pixels=3)


def test_materials_share_a_picture(read):
    """In the page's core too: three hundred copies of it would not fit into its memory."""
    array = np.random.default_rng(0).integers(0, 256, (2048, 2048, 3), np.uint8)
    file = io.BytesIO()
    Image.fromarray(array).save(file, "JPEG", quality=30)
    uri = {"uri": "data:image/jpeg;base64," + base64.b64encode(file.getvalue()).decode()}
    count = 300
    primitives = [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1, "material": i} for i in range(count)]
    laid = {"baseColorTexture": {"index": 0}}
    points = {"bufferView": 0, "componentType": 5126, "count": 8}
    corners = {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}
    found = read(
        "a.glb",
        box_glb(
            [{"mesh": 0}], images=[uri], meshes=[{"primitives": primitives}], textures=[{"source": 0}],
            accessors=[points | {"type": "VEC3"}, corners, points | {"type": "VEC2"}],
            materials=[{"pbrMetallicRoughness": laid | {"roughnessFactor": i / count}} for i in range(count)],
        ),
    )  # fmt: skip
    assert "error" not in found, found["error"]
    assert len(found["names"]) == count
    assert found["warnings"] == []
    assert found["color"] is not None


def test_a_picture_with_and_without_its_alpha(same):
    laid = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    same("both.glb", textured_glb(4, materials=[laid | {"alphaMode": "MASK"}, laid]), pixels=2)


def test_cut_outs_of_glb(same):
    """By the alpha of the texture, of vertices and of the factor; with colours of vertices as well."""
    laid, solid = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}, {}
    seen = {}
    for mode in ("MASK", "BLEND", "OPAQUE"):
        seen[mode] = same(
            f"{mode}.glb", textured_glb(4, materials=[laid | {"alphaMode": mode}, {"alphaMode": mode}]), pixels=2
        )
    assert not np.array_equal(seen["MASK"]["planes"], seen["BLEND"]["planes"])  # of vertices
    assert not np.array_equal(seen["BLEND"]["planes"], seen["OPAQUE"]["planes"])
    half = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 1, 1, 0.5]}}
    found = same(
        "factor.glb", textured_glb(4, materials=[half | {"alphaMode": "MASK", "alphaCutoff": 0.2}, solid]), pixels=2
    )
    assert not np.array_equal(found["planes"], seen["MASK"]["planes"])
    gone = {"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.4]}, "alphaMode": "MASK"}
    assert len(same("gone.glb", textured_glb(4, materials=[gone, solid]))["names"]) == 2


def test_cut_outs_in_scene_files(same, read, tmp_path):
    random = np.random.default_rng(5)
    corners, triangles = np.eye(3), [(0, 1, 2)]
    texture, colors = random.integers(0, 256, (4, 6, 4), np.uint8), random.uniform(0.5, 1, (3, 4))
    made = bob.Mesh(
        corners, triangles, colors=colors, uv=random.uniform(-1, 2, (3, 2)), texture=texture, alpha_cutoff=0.4
    )
    bob.save_scene(made, tmp_path / "a.bob")
    found = same("b.bob", (tmp_path / "a.bob").read_bytes(), pixels=1)
    whole = bob.Mesh(corners, triangles, colors=colors[:, :3], uv=made.uv, texture=texture[..., :3])
    bob.save_scene(whole, tmp_path / "whole.bob")
    assert 0 < (found["planes"][2] > 0).sum() < (read(tmp_path / "whole.bob")["planes"][2] > 0).sum()


@pytest.mark.parametrize("channels", [3, 4])
def test_scene_files_share_textures(channels, same, tmp_path):
    texture = np.random.default_rng(0).integers(0, 256, (5, 6, channels), np.uint8)
    uv = [(0, 0), (1, 0), (0, 1)]
    shapes = [bob.Mesh(np.eye(3) + i, [(0, 1, 2)], uv=uv, texture=texture, wrap="clamp") for i in range(3)]
    bob.save_scene(shapes, tmp_path / "shared.bob")
    content = (tmp_path / "shared.bob").read_bytes()
    assert b'"version":"5"' in content
    assert content.count(b'.texture"') == 1
    same("a.bob", content, pixels=2)
    coincident = [shapes[0], bob.Instance(shapes[0], material=bob.Material("#c33")), bob.Mesh(np.eye(3), [(0, 1, 2)])]
    bob.save_scene(coincident, tmp_path / "coincident.bob")
    same("b.bob", (tmp_path / "coincident.bob").read_bytes(), pixels=2)


@pytest.mark.parametrize("number", [-1, 1, 2])
def test_wrong_shared_textures_are_refused(number, read, tmp_path):
    file = tmp_path / "a.bob"
    file.write_bytes(shared_scene(number))
    with pytest.raises(bob.InputError) as error:
        bob.load(file)
    assert read(file)["error"] == str(error.value)


@pytest.mark.parametrize("changes", OTHERS)
def test_other_shared_textures_are_refused(changes, read, tmp_path):
    file = tmp_path / "a.bob"
    file.write_bytes(shared_scene(0, **changes))
    assert read(file)["error"].startswith("a.bob: shapes[1]: ")
    file.write_bytes(shared_scene(0))
    assert "error" not in read(file)


def test_scene_files_have_a_budget_of_texels(browser, viewer, tmp_path, monkeypatch):
    """2^27 texels; the last one is too many. The budget is 128 here, because so many texels take seconds."""
    assert surfaces_of_files.MAX_FILE_TEXELS == 2**27
    monkeypatch.setattr(surfaces_of_files, "MAX_FILE_TEXELS", 128)
    script, budget = viewer.files["files/surface.js"].read_bytes(), b"MAX_FILE_TEXELS = 2 ** 27;"
    assert budget in script
    monkeypatch.setitem(viewer.files, "files/surface.js", script.replace(budget, b"MAX_FILE_TEXELS = 128;"))
    texture, uv = np.zeros((8, 8, 3), np.uint8), np.zeros((3, 2))
    file = tmp_path / "a.bob"
    tensors, instances = {}, []
    look = {"color": [1, 1, 1], "ambient": 0.1, "diffuse": 0.7, "specular": 0.2, "shininess": 32}
    for i, part in enumerate((texture, texture, texture[:1, :1])):
        made = bob.Mesh(np.eye(3) + i, [(0, 1, 2)], uv=uv, texture=part)
        tensors |= {f"{i}.{name}": tensor for name, tensor in made.tensors().items()}
        instances.append({"shape": i, "transform": np.eye(4).tolist(), "name": None, "material": look})
    file.write_bytes(sealed(layout({"shapes": ["mesh"] * 3, "instances": instances}, tensors, "2")))
    with pytest.raises(bob.InputError) as error:
        bob.load(file)
    assert str(error.value) == "a.bob: shapes[2]: expected textures of at most 128 texels in all, got more"
    with opened(browser, viewer) as page:
        assert read_by(page, viewer)(file)["error"] == str(error.value)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"alpha_cutoff": None}, "shapes[0]: alpha_cutoff: expected alphas or texture_alpha together with it"),
        ({"alphas": None, "texture_alpha": None}, "shapes[0]: alpha_cutoff: expected alphas or texture_alpha together"),
        ({"alpha_cutoff": np.array([1.5])}, "shapes[0]: alpha_cutoff: expected"),
        ({"alpha_cutoff": np.array([np.nan])}, "shapes[0]: alpha_cutoff: expected"),
        ({"alpha_cutoff": np.zeros(2)}, "shapes[0]: alpha_cutoff: expected shape"),
        ({"alphas": np.array([0, 0.5, 2], np.float32)}, "shapes[0]: "),
        ({"alphas": np.zeros(2, np.float32)}, "shapes[0]: alphas: expected"),
        ({"colors": None}, "shapes[0]: "),
        ({"texture_alpha": np.zeros(23, np.uint8)}, "shapes[0]: texture_alpha: expected"),
        ({"texture_alpha": np.zeros(24, np.int32)}, "shapes[0]: texture_alpha: expected"),
        ({"uv": None, "texture": None, "texture_layout": None}, "shapes[0]: texture"),
    ],
)
def test_wrong_alphas_of_scene_files_are_refused(changes, message, read, tmp_path):
    """In Python and in the page."""
    made = bob.Mesh(
        np.eye(3), [(0, 1, 2)], colors=np.full((3, 4), 0.5), uv=np.zeros((3, 2)), texture=np.zeros((4, 6, 4), np.uint8)
    )
    tensors = {f"0.{name}": tensor for name, tensor in ({**made.tensors(), **changes}).items() if tensor is not None}
    instance = {"shape": 0, "transform": np.eye(4).tolist(), "name": None}
    instance["material"] = {"color": [1, 1, 1], "ambient": 0.1, "diffuse": 0.7, "specular": 0.2, "shininess": 32}
    (tmp_path / "a.bob").write_bytes(sealed(layout({"shapes": ["mesh"], "instances": [instance]}, tensors, "4")))
    with pytest.raises(bob.InputError) as error:
        bob.load(tmp_path / "a.bob")
    for told in (str(error.value), read(tmp_path / "a.bob")["error"]):
        assert told.startswith(f"a.bob: {message}")
        assert "\n" not in told


# ---- Files with companions -------------------------------------------------------------------------------

SQUARE = "".join(f"v {x} {y} {x * y / 2}\nvt {x / 2} {y / 3}\n" for x, y in ((0, 0), (2, 0), (2, 3), (0, 3), (3, 3)))
LIBRARY = """
newmtl plain
Kd 0.8 0.4
Ks 0.5 0.5 0.5
Ns 20
newmtl laid on
Kd 0.1 0.1 0.1
map_Kd -s 1 1 1 maps\\the texture.png
newmtl clamped
map_Kd -clamp on /home/somebody/the texture.png
newmtl metal
Kd 0.7 0.6 0.2
Pm 1
Pr 0.3
Ke 0 0 0.1
"""


@pytest.fixture
def texture(tmp_path):
    file = tmp_path / "the texture.png"
    Image.fromarray(np.random.default_rng(0).integers(0, 256, (5, 7, 3), np.uint8)).save(file)
    return file


def same_with(read, file, beside, **options):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        scene = bob.load(file)
    found = read(file, beside=beside)
    assert_equal_pictures(found, scene, **options)
    assert len(found["warnings"]) == len(told)
    return found


@pytest.mark.parametrize("normals", ["", "vn 0 0 1\nvn 0.5 0 1\n"])
def test_obj_with_materials_and_textures(read, texture, tmp_path, normals):
    library, file = tmp_path / "a library.mtl", tmp_path / "a.obj"
    library.write_text(LIBRARY.replace("maps\\", "").replace("/home/somebody/", ""))
    corner = "{0}/{0}/1" if normals else "{0}/{0}"
    faces = [
        " ".join(corner.format(i) for i in face) for face in ((1, 2, 3), (1, 3, 4), (3, 4, 5), (4, 2, 5), (2, 3, 5))
    ]
    names = ["plain", "laid on", "clamped", "metal", "unknown"]
    body = "".join(f"usemtl {name}\nf {face}\n" for name, face in zip(names, faces, strict=True))
    file.write_text(f"mtllib a library.mtl\n{normals}{SQUARE}f 1 2 4\n{body}f 1/2 2/9 4\nf 1/1 2/2 -1/-1\n")
    found = same_with(read, file, [texture, library])
    assert sorted(found["names"]) == ["a.obj", "clamped", "laid on", "metal", "plain"]
    assert len(found["warnings"]) == 1  # of the unknown material
    library.write_text(LIBRARY)  # whose paths the page does not need
    assert read(file, beside=[library, texture])["color"] == pytest.approx(found["color"])
    texture.unlink()
    found = same_with(read, file, [library])
    assert len(found["warnings"]) == 3  # of the texture by two names
    library.unlink()
    assert len(same_with(read, file, [])["warnings"]) == 1


def test_obj_with_masks(read, tmp_path):
    """From map_d and from the colours' alpha."""
    random = np.random.default_rng(0)
    pictures = {"leaf.png": (5, 7, 4), "mask.png": (9, 4), "solid.png": (5, 7, 3)}
    for name, shape in pictures.items():
        Image.fromarray(random.integers(0, 256, shape, np.uint8)).save(tmp_path / name)
    maps = ["map_Kd leaf.png", "map_Kd solid.png\nmap_d mask.png", "map_d leaf.png\nKd 1 0 0", "map_Kd solid.png"]
    library, file = tmp_path / "a.mtl", tmp_path / "a.obj"
    library.write_text("".join(f"newmtl {i}\n{lines}\n" for i, lines in enumerate(maps)))
    faces = "".join(
        f"usemtl {i}\nf {face}\n" for i, face in enumerate(("1/1 2/2 3/3", "1/1 3/3 4/4", "3/3 4/4 5/5", "2/2 3/3 5/5"))
    )
    file.write_text(f"mtllib a.mtl\n{SQUARE}{faces}")
    found = same_with(read, file, [library, *(tmp_path / name for name in pictures)], pixels=3)
    library.write_text(library.read_text().replace("map_d", "# map_d"))
    whole = same_with(read, file, [library, *(tmp_path / name for name in pictures)], pixels=3)
    assert (found["planes"][2] > 0).sum() < (whole["planes"][2] > 0).sum()


def test_gltf_with_its_files(read, texture, tmp_path):
    """Equal to the packed file."""
    glb = textured_glb()
    length = struct.unpack("<I", glb[12:16])[0]
    tree, binary = json.loads(glb[20 : 20 + length]), glb[28 + length :]
    (tmp_path / "all.glb").write_bytes(glb)
    expected = read(tmp_path / "all.glb")
    view = tree["bufferViews"].pop()
    (tmp_path / "picture 1.png").write_bytes(binary[view["byteOffset"] :][: view["byteLength"]])
    half = tree["bufferViews"][2]["byteOffset"]
    (tmp_path / "first.bin").write_bytes(binary[:half])
    (tmp_path / "second.bin").write_bytes(binary[half : view["byteOffset"]])
    for later in tree["bufferViews"][2:]:
        later.update(buffer=1, byteOffset=later["byteOffset"] - half)
    tree["buffers"] = [
        {"uri": "first.bin", "byteLength": half},
        {"uri": "second.bin", "byteLength": view["byteOffset"] - half},
    ]
    tree["images"] = [{"uri": "picture%201.png"}]
    file = tmp_path / "a.gltf"
    file.write_text(json.dumps(tree))
    parts = [tmp_path / name for name in ("first.bin", "second.bin", "picture 1.png")]
    found = same_with(read, file, parts)
    np.testing.assert_array_equal(found["color"], expected["color"])
    (tmp_path / "picture 1.png").unlink()
    assert len(same_with(read, file, parts[:2])["warnings"]) == 1
    wrong = read(file, beside=parts[:1])
    assert wrong["error"] == "a.gltf: expected second.bin to be opened together with it, got no such file"
    assert wrong["kind"] == "CoreError"


@needs_models
@pytest.mark.parametrize(
    "name", ["obj_mtl_spider/spider.obj", "obj_mtl_fuze/fuze.obj", "obj_mtl_cornell/CornellBox-Original.obj",
             "gltf_external/coffin_decorated.gltf"]
)  # fmt: skip
def test_real_files_with_what_is_beside_them(name, read):
    file = MODELS / "loader_originals" / name
    beside = [other for other in file.parent.iterdir() if other != file]
    # JPEG decoders may round differently.
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        scene = bob.load(file)
    found, expected = read(file, beside=beside), bob.trace(scene, CAMERA, size=SIZE)
    assert len(found["warnings"]) == len(told)
    difference = np.abs(found["color"] - np.moveaxis(expected.color, -1, 0)).max(axis=0)
    assert np.count_nonzero(difference > 0.01) <= 5
    assert difference.mean() < 1e-3


# ---- NURBS -----------------------------------------------------------------------------------------------


def surface(**fields):
    points = [[x, y, x * (3 - x) * y * (3 - y) / 2] for x in range(4) for y in range(4)]
    knots = [0, 0, 0, 0, 1, 1, 1, 1]
    return {
        "type": "spline",
        "degree_u": 3,
        "degree_v": 3,
        "knotvector_u": knots,
        "knotvector_v": knots,
        "size_u": 4,
        "size_v": 4,
        "control_points": {"points": points, "weights": list(range(1, 17))},
        **fields,
    }


def geomdl(*surfaces):
    return json.dumps({"shape": {"type": "surface", "count": len(surfaces), "data": surfaces}})


def test_nurbs(same):
    hole = {"type": "freeform", "points": [[0.2, 0.2], [0.5, 0.2], [0.5, 0.7]]}
    spline = {"type": "spline", "degree": 2, "knotvector": [0, 0, 0, 1, 1, 1],
              "control_points": {"points": [[0.6, 0.2], [0.9, 0.5], [0.6, 0.8]]}}  # fmt: skip
    both = {"type": "container", "data": [spline, {"type": "freeform", "points": [[0.6, 0.8], [0.6, 0.2]]}]}
    same("plain.json", geomdl(surface()))
    same("holes.json", geomdl(surface(trims={"count": 2, "data": [hole, both]})))
    same("kept.json", geomdl(surface(trims={"data": [{**both, "reversed": 1}]})))
    moved = [[x + 4, y, z] for x, y, z in surface()["control_points"]["points"]]
    found = same("named.json", geomdl(surface(name="a"), surface(name="b", control_points={"points": moved})))
    assert sorted(found["names"]) == ["a", "b"]
    found = same("untrimmed.json", geomdl(surface(trimmed=True)))
    assert found["warnings"] == [
        "untrimmed.json: 1 of 1 faces are trimmed, but the file has no trim curves: they are shown whole"
    ]


# ---- Errors ----------------------------------------------------------------------------------------------

HEADER = (
    b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
)
FACES = b"element face 1\nproperty list int int vertex_indices\nend_header\n"
LOOP = [{"mesh": 1, "children": [1]}, {"children": [0]}]


FORMAT = "expected a format that this page reads"


@pytest.mark.parametrize(
    ("name", "content", "error"),
    [
        ("a.xyz", b"?", f"expected one of {' '.join(READ_IN_PAGE)}, got .xyz; convert it to one"),
        ("a.step", b"?", f"{FORMAT}, got .step; convert it: bobrossnet pack a.bob a.step"),
        ("my part.3DM", b"?", f"{FORMAT}, got .3dm; convert it: bobrossnet pack 'my part.bob' 'my part.3DM'"),
        (f"{'a' * 50}.igs", b"?", f"{FORMAT}, got .igs; convert it: bobrossnet pack scene.bob FILE"),
        ("ply", b"?", f"expected one of {' '.join(READ_IN_PAGE)}, got no ending; add one, as in #part.glb after"),
        ("a.ply", b"", "expected a mesh, got an empty file"),
        ("a.json", b"", "expected a scene, got an empty file"),
        ("a.ply", b"OFF", "expected a PLY, which starts with 'ply', got 'OFF'"),
        ("a.ply", b"ply\nformat ascii 1.0\n", "expected a PLY header that ends in end_header, got none"),
        ("a.ply", HEADER.replace(b"3", b"99999999") + FACES, "expected 99,999,999 vertex, 1 face, got only 0 bytes"),
        ("a.ply", HEADER + FACES + bytes(36) + b"\3\0\0\0\0", "expected 1 face, but the file ends before them"),
        ("a.ply", HEADER + FACES + bytes(36) + b"\xff" * 4, "expected a list no longer than the file, got one of -1"),
        ("a.ply", HEADER + FACES + bytes(36) + bytes(4), "expected triangles, got a point cloud of 3 points"),
        ("a.ply", HEADER + FACES + bytes(36) + struct.pack("<4i", 3, 0, 1, 2), "expected triangles with an area"),
        ("a.ply", HEADER + FACES + bytes(36) + struct.pack("<4i", 3, 0, 1, 3), "expected triangles, got 1 that"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\n", "expected triangles, got a point cloud of 2 points"),
        ("a.stl", bytes(100), "expected an STL of 84 + 50 n bytes for n triangles, got 100 bytes"),
        ("a.off", b"FFO", "expected an OFF, which starts with 'OFF'"),
        ("a.off", b"OFF\n99999999 1 0\n", "expected counts of vertices and faces that the file can hold"),
        ("a.glb", b"glTF", "expected a GLB, which starts with 'glTF'"),
        ("a.glb", box_glb([{"mesh": 1}])[:-9], "expected 932 bytes, as its head says, got 923"),
        ("a.glb", box_glb(LOOP), "expected nodes that form a tree, got one with two parents or inside itself"),
        ("a.glb", box_glb([{"mesh": 1}], buffers=[{"uri": "b.bin"}]), "expected b.bin to be opened together with it"),
        ("a.glb", glb({}), "expected triangles, got none"),
        ("a.json", b"[", "expected a .json file, could not read it (SyntaxError"),
        ("a.json", b"{}", "shape: expected one, got none"),
        ("a.json", geomdl(surface(size_u=5)).encode(), "surface 1: knotvector_u: expected 9 knots, got 8"),
        ("a.json", geomdl(surface(degree_u=9)).encode(), "surface 1: knotvector_u: expected 14 knots, got 8"),
        ("a.json", geomdl(surface(knotvector_v=[0] * 7 + [-1])).encode(), "surface 1: faces[0]: knots_v: expected"),
        ("a.bob", b"x" * 200, "expected a bobrossnet-scene file, got one that starts with"),
        ("a.sdf", b"\xff\xfe", "expected a .sdf file, could not read it (TypeError"),
    ],
)  # fmt: skip
def test_broken_files_are_told_in_one_line(name, content, error, read):
    wrong = read(name, content)
    assert wrong["error"].startswith(f"{name}: {error}")
    assert wrong["kind"] == "CoreError"
    assert len(wrong["error"]) <= 200
    assert "\n" not in wrong["error"]


TRIANGLE = "v 0 0 0\nv 1 0 0\nv 1 1 0\n"
PLY = "ply\nformat ascii 1.0\nelement vertex {rows}\n{x}\nproperty float y\nproperty float z\n"
PLY += "element face 1\n{corners}\nend_header\n0 0 0\n{number} 0 0\n1 1 0\n{length} 0 1 2\n"
SOUND = {
    "rows": 3,
    "x": "property float x",
    "corners": "property list int int vertex_indices",
    "number": 1,
    "length": 3,
}


def ply_text(**change):
    return PLY.format(**{**SOUND, **change}).encode()


def without_types():
    return box_glb([{"mesh": 1}]).replace(b'"type"', b'"kind"')


def without_numbers(number, **fields):
    """Return a file of a NURBS surface with `number` in place of -7."""
    return geomdl(surface(**fields)).replace("-7", number).encode()


def damaged(at, content):
    """Return a GLB with some bytes replaced."""
    whole = box_glb([{"mesh": 1}])
    at += len(whole) if at < 0 else 0
    return whole[:at] + content + whole[at + len(content) :]


def with_mode(mode):
    return box_glb(
        [{"mesh": 0}], meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": mode}]}]
    )


def with_normals(accessor):
    return box_glb([{"mesh": 0}], meshes=[{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": accessor}}]}])


KNOTS = [-7, 0, 0, 0, 1, 1, 1, 1]
BUFFER = 8 + 8 * 12 + 36 * 2  # the second chunk of box_glb, from its header on


@pytest.mark.parametrize(
    ("name", "content", "error"),
    [
        ("a.obj", TRIANGLE.encode() + b"f 1 two 3\n", "expected corners of faces such as 3, 3/1 or 3//2, got 'two'"),
        ("a.obj", TRIANGLE.encode() + b"f 1 2 3x\n", "expected corners of faces such as 3, 3/1 or 3//2, got '3x'"),
        ("a.obj", TRIANGLE.encode() + b"f 1 2//n 3\n", "expected corners of faces such as 3, 3/1 or 3//2, got 'n'"),
        ("a.obj", TRIANGLE.encode() + b"v 0x10 0 0\nf 1 2 3\n", "expected numbers, got others ("),
        ("a.obj", TRIANGLE.encode() + b"vn a b c\nf 1 2 3\n", "expected numbers, got others ("),
        ("a.ply", ply_text(number="0a"), "expected numbers, got others ("),
        ("a.ply", ply_text(number="0x1"), "expected numbers, got others ("),
        ("a.ply", ply_text(length="1e-320"), "expected a whole number, got '1e-320'"),
        ("a.ply", ply_text(rows="3.0"), "expected a whole number, got '3.0'"),
        ("a.ply", ply_text(x="property list int float x"), "expected 3 vertex, but row 2 is missing or too short"),
        ("a.ply", ply_text(x="property list x"), "expected a PLY type such as float or int, got list"),
        ("a.ply", ply_text(corners="property int vertex_indices"), "expected triangles, got a point cloud of 3 points"),
        ("a.glb", without_types(), "accessors[0]: expected a type such as VEC3 and a componentType such as 5126, got "),
        ("a.glb", glb({"asset": {}}), "asset: expected version 2.0, got "),
        ("a.glb", damaged(4, b"\1"), "expected a GLB of version 2, got 1"),
        ("a.glb", damaged(16, b"BIN\0"), "expected a first chunk of JSON, got one of "),
        ("a.glb", damaged(12, b"\xff\xff"), "expected 65"),
        ("a.glb", damaged(-BUFFER, b"\xff"), "expected 1"),
        ("a.glb", damaged(-BUFFER + 4, b"NIB\0"), "bufferViews[0]: expected buffers that hold what"),
        ("a.glb", damaged(-BUFFER, b"\xa7"), "bufferViews[1]: expected buffers that hold what"),
        ("a.glb", with_normals(1), "meshes[0]: NORMAL: expected vectors of type VEC3, got another"),
        ("a.glb", box_glb([{"mesh": 7}]), "nodes[0]: mesh: expected an integer in 0..1, got 7"),
        ("a.glb", box_glb([{"mesh": None}]), "nodes[0]: mesh: expected an integer, got "),
        ("a.glb", box_glb([{"mesh": True}]), "nodes[0]: mesh: expected an integer, got "),
        ("a.glb", box_glb([{"mesh": 1, "matrix": [1] * 15}]), "nodes[0]: matrix: expected shape (16,), got (15,)"),
        ("a.glb", box_glb([{"mesh": 1, "scale": [1, 1, True]}]), "nodes[0]: scale: expected lists of numbers, "),
        ("a.glb", box_glb([{"mesh": 1, "scale": None}]), "nodes[0]: scale: expected "),
        ("a.glb", box_glb([{"mesh": 1, "children": [1]}]), "nodes[0]: children: expected an integer in 0..0, got 1"),
        ("a.glb", box_glb([{"mesh": 1}, *[{}] * 100_000]), "nodes: expected at most 100,000, got 100,001"),
        (
            "a.glb",
            box_glb([{"children": [n + 1]} for n in range(100_000)] + [{"mesh": 1}]),
            "nodes: expected at most 100,000, got 100,001",
        ),
        (
            "a.glb",
            box_glb([{"mesh": 0}] * 1001, meshes=[{"primitives": [{"attributes": {"POSITION": 0}}] * 100}]),
            "primitives: expected at most 100,000, got 100,100",
        ),
        ("a.glb", with_mode(None), "meshes[0]: mode: expected an integer, got "),
        ("a.glb", with_mode(7), "meshes[0]: mode: expected an integer in 0..6, got 7"),
        ("a.glb", box_glb([{"mesh": 1}], extras=float("nan")), "expected "),
        ("a.json", without_numbers("NaN", knotvector_u=KNOTS), "expected "),
        ("a.json", geomdl(surface(name="??")).replace("??", "\xff").encode("latin-1"), "expected "),
        ("a.json", without_numbers("-Infinity", knotvector_u=KNOTS), "expected "),
        ("a.json", without_numbers("true", knotvector_u=KNOTS), "surface 1: knotvector_u: expected lists of numbers"),
        ("a.json", without_numbers('"0"', knotvector_u=KNOTS), "surface 1: knotvector_u: expected lists of numbers"),
        ("a.json", without_numbers("true", size_u=-7), "surface 1: size_u: expected an integer, got "),
        ("a.json", geomdl(surface()).replace('"count": 1', '"count": true').encode(), "count: expected 1, the surf"),
        ("a.json", geomdl(surface()).replace('"count": 1', '"count": null').encode(), "count: expected 1, the surf"),
    ],
)  # fmt: skip
def test_the_page_refuses_what_python_refuses(name, content, error, read, tmp_path):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(bob.InputError) as refused:
        bob.load(path)
    assert str(refused.value).startswith(f"{name}: {error}")
    assert read(name, content)["error"].startswith(f"{name}: {error}")


def test_lines_are_left_out(same):
    lines = {"attributes": {"POSITION": 0}, "mode": 1, "material": 0}
    same(
        "a.glb", box_glb([{"mesh": 0}], meshes=[{"primitives": [lines, {"attributes": {"POSITION": 0}, "indices": 1}]}])
    )


def test_chunks_of_other_kinds_do_not_matter(same):
    whole = box_glb([{"mesh": 1}])
    more = whole + struct.pack("<I4s", 4, b"MORE") + bytes(4)
    same("a.glb", more[:8] + struct.pack("<I", len(more)) + more[12:])
    same("a.glb", whole + b"behind its end")
    same("a.glb", box_glb([{"children": [1]}, {"mesh": 1}]))  # a node without a mesh


def test_numbers_of_texts_are_those_of_python(read, tmp_path):
    for name, content in {
        "a.obj": TRIANGLE.encode() + b"v nan inf +1e999\nf +1 2\v3#x y\n",
        "b.ply": ply_text(number="+10e-1"),
        "c.ply": ply_text(length="+3"),
    }.items():
        (tmp_path / name).write_bytes(content)
        assert_equal_pictures(read(name, content), bob.load(tmp_path / name))


def test_odd_lights_are_refused(read):
    """Lights in scene files, as in Python; the words about environments differ."""
    for light, image, message in ODD_LIGHTS:
        told = read("a.bob", with_light(light, image))["error"]
        assert told.startswith("a.bob: environment: expected" if ".image" in message else f"a.bob: {message}"), told


def test_damaged_scenes_are_refused(read, viewer):
    """For any changed byte of a scene."""
    whole = (VIEWER / "gallery/tanglecube.bob").read_bytes()
    for at in (0, 40, 120, len(whole) // 2, len(whole) - 1):
        damaged = bytearray(whole)
        damaged[at] ^= 1
        assert read("a.bob", bytes(damaged))["error"].startswith("a.bob: expected a ")
    assert read("a.bob", whole[:-1])["error"].endswith("its checksum differs")

    instance = {"shape": 0, "transform": np.eye(4).tolist(), "material": vars(bob.Material()), "name": None}
    tensors = {"0.vertices": np.eye(3), "0.triangles": np.array([[0, 1, 2]], np.int32)}

    def told(kinds=("mesh",), tensors=tensors, **fields):
        scene = {"shapes": list(kinds), "instances": [{**instance, **fields}]}
        return read("a.bob", sealed(layout(scene, tensors)))["error"]

    assert told(shape=1) == "a.bob: instances[0].shape: expected an integer in 0..0, got 1"
    assert told(transform=np.diag([1.0, 1, 0, 1]).tolist()).endswith("got one that is singular")
    assert told(material={**vars(bob.Material()), "ambient": 2}).startswith(
        "a.bob: instances[0].material.ambient: expected"
    )
    place = [[True, 0, 0, 0], *np.eye(4).tolist()[1:]]
    assert told(transform=place).startswith("a.bob: instances[0].transform: expected ")
    formula = {"0.ops": np.array([1], np.uint8), "0.operands": np.zeros((1, 3), np.uint32), "0.values": np.zeros(1)}
    wide = {**formula, "0.bounds": np.array([(-1e308,) * 3, (1e308,) * 3])}
    assert "bounds: expected numbers of at most 1e+100 in size, got -1e+308" in told(kinds=["implicit"], tensors=wide)
    red = {"0.color_ops": np.zeros(2, np.uint8), "0.color_operands": np.zeros((2, 3), np.uint32),
           "0.color_values": np.eye(2)[0], "0.color_roots": np.array([0, 1, 1], np.uint32)}  # fmt: skip
    for changed, what in (
        ({"0.color_ops": np.array([99, 0], np.uint8)}, "color: node 0: expected an op, got an unknown one"),
        ({"0.color_roots": np.array([0, 1, 2], np.uint32)}, "color: expected red, green and blue among the nodes"),
        ({"0.color_values": np.zeros(3)}, "color: expected ops, operands and values of one length"),
        ({"0.color_roots": np.zeros(4, np.uint32)}, "color_roots: expected shape (3), got (4)"),
    ):
        error = told(kinds=["implicit"], tensors={**formula, **red, **changed})
        assert error.startswith(f"a.bob: shapes[0]: {what}")
    part = {name: tensor for name, tensor in red.items() if name != "0.color_ops"}
    assert "color: expected color_ops, color_op" in told(kinds=["implicit"], tensors={**formula, **part})
    corners = {"0.mesh_sizes": np.array([[4, 4]], np.uint32), "0.mesh_vertices": np.eye(4, 3, dtype=np.float32),
               "0.mesh_triangles": np.array([(0, 1, 2), (1, 0, 3), (2, 1, 3), (0, 2, 3)], np.uint32)}  # fmt: skip
    distance = {"0.ops": np.array([1, 2, 3, 30], np.uint8), "0.values": np.zeros(4),
                "0.operands": np.array([*np.zeros((3, 3)), (0, 1, 2)], np.uint32)}  # fmt: skip
    for changed, what in (
        ({}, "formula: node 3: expected the place of a mesh, got another"),
        ({**corners, "0.mesh_triangles": corners["0.mesh_triangles"][:3]}, "formula: expected as many vertices and tr"),
        ({**corners, "0.mesh_triangles": np.zeros((4, 3), np.uint32)}, "formula: expected a closed mesh, got no tri"),
        ({**corners, "0.mesh_sizes": np.array([[4]], np.uint32)}, "mesh_sizes: expected shape (n, 2), got (1, 1)"),
        ({"0.mesh_sizes": corners["0.mesh_sizes"]}, "mesh_sizes: expected mesh_sizes, mesh_vertices and mesh_tri"),
        ({f"0.color_{name[2:]}": tensor for name, tensor in corners.items()}, "color: expected a formula with its me"),
    ):
        error = told(kinds=["implicit"], tensors={**distance, **changed})
        assert error.startswith(f"a.bob: shapes[0]: {what}")
    sheet = bob.nurbs_surface([[(0, 0, 0), (0, 1, 0)], [(1, 0, 0), (1, 1, 0)]], *[[0, 0, 1, 1]] * 2, color="#c33")
    brep = {f"0.{name}": tensor for name, tensor in sheet.tensors().items()}
    for colors, what in (
        (np.ones((2, 3)), "expected one for each of 1 faces, got 2"),
        (np.ones((1, 3)) * 2, "expected n"),
    ):
        error = told(kinds=["brep"], tensors={**brep, "0.face_colors": colors.astype(np.float32)})
        assert error.startswith(f"a.bob: shapes[0]: face_colors: {what}")
    assert told(name=3) == "a.bob: instances[0].name: expected a string, got number 3"
    assert told(kinds=["ball"]).startswith("a.bob: shapes[0]: expected a kind among mesh, implicit, brep, tube")
    assert told(tensors={"0.vertices": np.eye(3)}) == "a.bob: shapes[0]: triangles: expected an array of I32, got none"
    assert told(tensors={**tensors, "1.x": np.eye(3)}).startswith("a.bob: 1.x: expected tensors of 1 shapes")
    assert told(tensors={**tensors, "0.vertices": np.full((3, 3), np.nan)}).endswith("got 9 of 9 NaN or infinite")
    assert told(tensors={**tensors, "0.triangles": np.array([[0, 1, 3]], np.int32)}).endswith("indices in 0..2, got 3")
    many = sealed(layout({"shapes": ["mesh"], "instances": [0] * 100_001}, tensors))
    assert read("a.bob", many)["error"] == "a.bob: instances: expected at most 100,000, got 100,001"


# ---- Real files ------------------------------------------------------------------------------------------

REAL = [
    "scans/stanford_bunny.ply",
    "broken_odd/igea_tristrips.ply",
    "broken_odd/bunny_poly.ply",
    "broken_odd/busted.STL",
    "loader_originals/stl_ascii/Spider_ascii.stl",
    "loader_originals/obj_quads/horse_quad.obj",
    "loader_originals/obj_mtl_spider/spider.obj",
    "loader_originals/ply_vertex_attributes/bunny_attribute_color.ply",
    "loader_originals/ply_ascii/fuze_ascii.ply",
    "loader_originals/obj_vertex_colour/cube_with_vertexcolors.obj",
    "loader_originals/glb_material/CesiumMilkTruck.glb",
    "loader_originals/glb_material/Duck.glb",
    "loader_originals/glb_material/cubevc.glb",
    "loader_originals/glb_nested/nested.glb",
    "loader_originals/off_quads/fandisk_quads.off",
    "nurbs/ducky.nurbs.json",
    "nurbs/mech_part_a.nurbs.json",
    "implicit/quarter.vm",
]


@needs_models
@pytest.mark.parametrize("name", REAL)
def test_real_files(name, read, tmp_path):
    """Without their companion files, which a page lacks."""
    file = tmp_path / Path(name).name
    file.write_bytes((MODELS / name).read_bytes())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of trims missing in a file
        scene = bob.load(file)
    assert_equal_pictures(read(file), scene, pixels=5)


@needs_models
@pytest.mark.parametrize("name", ["BoxWithInfinites.glb", "OutOfMemory.off", "degenerate_mesh.obj", "unparseable.stl"])
def test_real_broken_files(name, read):
    wrong = read(MODELS / "broken_odd" / name)
    assert wrong["error"].startswith(f"{name}: expected ")
    assert wrong["kind"] == "CoreError"
