"""Mesh files after public bug reports, in Python and in the page: each looks as its format's specification says."""

from pathlib import Path

import numpy as np
import pytest
from loaded import area

import bobrossnet as bob
from bobrossnet.adapters.files import ALL_ENDINGS
from bobrossnet.color import from_srgb
from bobrossnet.support.errors import InputError

CASES = Path(__file__).parent / "cases"
RED = from_srgb(np.array([230, 25, 25]) / 255)
CUBE = {"area": 6.0, "low": (0, 0, 0), "high": (1, 1, 1)}
"""Areas are by the shoelace formula, colours and kinds by the formats' specifications, bytes behind triangles by STL's
counts of attributes."""

FACTS = {
    "3mf-build-of-parts/box.3mf": CUBE,
    "3mf-colors-of-corners/box.3mf": CUBE | {"colors": np.eye(3)[::-1]},
    "3mf-names/space.3mf": CUBE,
    "3mf-slices/box.3mf": CUBE,
    "bom/box.obj": CUBE,
    "bom-mtl/box.obj": CUBE | {"colors": [from_srgb(np.array([0.9, 0.1, 0.1]))]},
    "concave/comb.obj": {"area": 78.0},
    "concave/wall-with-window.obj": {"area": 12.0},
    "map-hash/box.obj": CUBE | {"textures": 1},
    "map-scale/box.obj": CUBE | {"textures": 1, "uv": 3.0},
    "off-colors/of-vertices.off": CUBE | {"colors": [RED]},
    "off-kinds/normals.off": CUBE,
    "off-mixed/hexagonal-prism.off": {"area": 6 + 3 * np.sqrt(3), "triangles": 20},
    "ply-colors/float-255.ply": CUBE | {"colors": [RED]},
    "ply-colors/int.ply": CUBE | {"colors": [RED]},
    "ply-colors/r-g-b.ply": CUBE | {"colors": [RED]},
    "ply-two-textures/box.ply": CUBE | {"textures": 2},
    "stl/bytes-at-the-end.stl": CUBE,
    "stl/bytes-behind-triangles.stl": CUBE,
    "stl/carriage-returns.stl": CUBE,
    "stl/upper-case.stl": CUBE,
}
ERRORS = {
    "3mf-required/box.3mf": "requiredextensions: expected supported extensions, got http://example.com/unknown",
    "bom/utf-16.obj": "expected text in UTF-8, got UTF-16; save it as UTF-8",
    "stl/decimal-commas.stl": "expected numbers with decimal points, got '1,0'; replace decimal commas",
}

FILES = """async ([file, beside]) => {
  const { loadCore } = await import("/core/load.js"), { readFile } = await import("/files/read.js");
  const { Beside } = await import("/files/beside.js");
  const fetched = async (path) => (await fetch(`/tested/cases/${path.replace("#", "%23")}`)).arrayBuffer();
  const last = (path) => path.split("/").at(-1);
  const others = new Beside(beside.map((other) => ({ name: last(other), arrayBuffer: () => fetched(other) })));
  try {
    const core = await loadCore(file.endsWith(".3mf") ? "core" : "core.mesh");
    const { shapes, instances, warnings } = await readFile(core, last(file), await fetched(file), others);
    const of = ({ vertices, triangles, colors = [], uv = [], texture = [] }, i) => ({
      vertices: [...vertices], triangles: [...triangles], colors: [...colors], uv: [...uv], texels: [...texture],
      color: [...instances[i].material.color],
    });
    return { meshes: shapes.map(of), warnings };
  } catch (error) {
    return { error: error.message };
  }
}"""


def facts(meshes):
    """Of all meshes of a file: (vertices, triangles, colours, uv, texels, the material's colour)."""
    corners = np.concatenate([vertices[triangles].reshape(-1, 3) for vertices, triangles, *_ in meshes])
    shown = np.concatenate(
        [np.ones((len(v), 3)) * color * (colors if len(colors) else 1) for v, _, colors, _, _, color in meshes]
    )
    return {
        "area": sum(area(vertices, triangles) for vertices, triangles, *_ in meshes),
        "triangles": sum(len(triangles) for _, triangles, *_ in meshes),
        "low": corners.min(axis=0),
        "high": corners.max(axis=0),
        "colors": np.unique(np.round(shown, 5), axis=0),
        "textures": len({bytes(np.asarray(texels, np.uint8)) for *_, texels, _ in meshes if len(texels)}),
        "uv": max(np.ptp(uv, axis=0).max() if len(uv) else 0.0 for *_, uv, _, _ in meshes),
    }


def assert_facts(found, expected):
    for name, value in expected.items():
        np.testing.assert_allclose(found[name], value, atol=1e-4, err_msg=name)


@pytest.mark.parametrize("name", FACTS)
@pytest.mark.filterwarnings("error")
def test_in_python(name):
    meshes = []
    for instance in bob.load(CASES / name).instances:
        mesh = instance.shape
        some = [[] if array is None else array for array in (mesh.colors, mesh.uv, mesh.texture)]
        meshes.append((mesh.vertices, mesh.triangles, *some, instance.material.color))
    assert_facts(facts(meshes), FACTS[name])


@pytest.mark.parametrize("name", ERRORS)
def test_errors_in_python(name):
    with pytest.raises(InputError) as caught:
        bob.load(CASES / name)
    assert str(caught.value) == f"{Path(name).name}: {ERRORS[name]}"


@pytest.fixture(scope="module")
def read(browser, viewer):
    """Reads a case in the page."""
    for file in CASES.rglob("*.*"):
        viewer.files[f"tested/cases/{file.relative_to(CASES).as_posix()}"] = file
    page = browser.new_page()
    page.goto(viewer.url + "gallery/index.json")

    def read(name):
        files = [file for file in (CASES / name).parent.iterdir() if file.suffix.lower() not in ALL_ENDINGS]
        beside = [file.relative_to(CASES).as_posix() for file in files]  # other models would join the scene
        return page.evaluate(FILES, [name, beside])

    yield read
    page.close()


@pytest.mark.parametrize("name", FACTS)
def test_in_the_page(name, read):
    found = read(name)
    assert found.get("error") is None
    assert found["warnings"] == []
    rows = {"vertices": 3, "triangles": 3, "colors": 3, "uv": 2}
    meshes = []
    for mesh in found["meshes"]:
        arrays = [
            np.array(mesh[key], int if key == "triangles" else float).reshape(-1, width) for key, width in rows.items()
        ]
        meshes.append((*arrays, mesh["texels"], mesh["color"]))
    assert_facts(facts(meshes), FACTS[name])


@pytest.mark.parametrize("name", ERRORS)
def test_errors_in_the_page(name, read):
    assert read(name) == {"error": f"{Path(name).name}: {ERRORS[name]}"}
