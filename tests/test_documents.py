"""Documents: their examples run, their links resolve, their constants equal the code's."""

import ast
import doctest
import re
import sys
from importlib import import_module
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from runpy import run_path
from subprocess import PIPE, run

import numpy as np
import pytest
from modules import MODULES
from PIL import Image

import bobrossnet as bob
from bobrossnet.adapters.files import ALL_ENDINGS, CAD_READERS, KINDS, NURBS_READERS
from bobrossnet.sdf.words import WORDS

ROOT = Path(__file__).parent.parent
DOCUMENTS = sorted(
    path.relative_to(ROOT)
    for folder in (
        ".",
        "bench/sparse",
        "docs",
        "docs/quality",
        "docs/reference",
        "docs/site",
        "docs/tutorials",
        "src/bobrossnet/weights",
    )
    for path in (ROOT / folder).glob("*.md")
)


def write_ply(file, mesh):
    rows = [" ".join(map(str, vertex)) for vertex in mesh.vertices.tolist()]
    rows += [" ".join(map(str, (3, *triangle))) for triangle in mesh.triangles.tolist()]
    head = f"ply\nformat ascii 1.0\nelement vertex {len(mesh.vertices)}\n"
    head += "property float x\nproperty float y\nproperty float z\n"
    head += f"element face {len(mesh.triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    file.write_text(head + "\n".join(rows) + "\n")


def python_in(document):
    return re.findall(r"```python\n(.*?)```", (ROOT / document).read_text(), re.DOTALL)


def test_readme_example_runs(tmp_path, monkeypatch):
    (code,) = python_in("README.md")
    monkeypatch.chdir(tmp_path)
    write_ply(tmp_path / "bunny.ply", bob.happy_tree())
    names = {}
    small = code.replace("(480, 640)", "(48, 64)").replace('light="studio"', 'light="studio", size="64x48"')
    exec(small, names)
    assert names["image"].shape == (48, 64)
    assert names["part"].fraction < 0.06
    assert (tmp_path / "bunny.png").exists()
    assert names["frame"].image.shape == (48, 64)


def test_examples_of_tracers_run(tmp_path):
    own, smooth, guided, denoised, pooled = python_in("docs/tracers.md")
    names = {}
    exec(own.replace("(480, 640)", "(48, 64)"), names)
    assert names["frame"].fraction == 1
    exec(smooth, names)
    assert names["frame"].fraction == 1
    exec(guided, names)
    assert names["frame"].gbuffer.guides is not None
    assert names["frame"].color.shape == (48, 64, 3)
    if find_spec("pyoidn"):
        exec(denoised, names)
        assert names["color"].shape == (48, 64, 3)
    (tmp_path / "pooled.py").write_text(
        (own + pooled + "        print(frame.fraction)\n").replace("(480, 640)", "(48, 64)")
    )
    printed = run([sys.executable, tmp_path / "pooled.py"], stdout=PIPE, text=True, check=True, timeout=60).stdout
    assert printed.split()[-1] == "1.0"


def test_examples_of_nurbs_run(tmp_path, monkeypatch, capsys):
    surface, curves = python_in("docs/nurbs.md")
    names = {}
    exec(surface, names)
    assert np.allclose(names["at"][:, :2], [[0.4, 0.5]], atol=1e-5)
    exec(curves, names)
    assert names["picture"].any()

    monkeypatch.chdir(tmp_path)
    run_path(str(ROOT / "examples/nurbs.py"), run_name="__main__")
    assert "1.000000 high, at u = 1.000000" in capsys.readouterr().out
    assert (tmp_path / "vault.png").exists()
    assert [instance.shape.kind for instance in bob.load("vault.bob").instances] == ["brep", "tube"]


def test_example_of_text_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["name_plate.py", "Io"])
    run_path(str(ROOT / "examples/name_plate.py"), run_name="__main__")
    assert capsys.readouterr().out == "name_plate.png and name_plate.stl: Io\n"
    assert (tmp_path / "name_plate.stl").stat().st_size > 100_000
    with Image.open(tmp_path / "name_plate.png") as picture:
        assert picture.size == (960, 320)


def test_a_converging_picture_is_one_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    code = (ROOT / "examples/your_own_tracer.py").read_text()
    for old, new in {"(480, 640)": "(120, 160)", "frame_ms=100": "frame_ms=10"}.items():
        assert old in code
        code = code.replace(old, new)
    exec(code, {"__name__": "__main__"})
    assert [file.name for file in tmp_path.iterdir()] == ["torus.png"]
    assert "100.0 % traced" in capsys.readouterr().out


def test_examples_of_meshes_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["hollow.py"])
    code = (ROOT / "examples/hollow.py").read_text()
    for old, new in {"mesh(0.05)": "mesh(0.1)", ".max() / 100": ".max() / 50", "(640, 480)": "(160, 120)"}.items():
        assert old in code
        code = code.replace(old, new)
    exec(code, {"__name__": "__main__"})
    assert capsys.readouterr().out.startswith("hollow.png and hollow.stl: of Mesh(")
    assert (tmp_path / "hollow.stl").stat().st_size > 100_000
    with Image.open(tmp_path / "hollow.png") as picture:
        colors = np.asarray(picture.convert("RGB")).reshape(-1, 3).astype(int)
    yellow = (colors[:, 0] > colors[:, 2] + 60).mean()  # the inside
    assert 0.05 < yellow < 0.5


@pytest.mark.parametrize("name", MODULES)
def test_docstring_examples_run(name):
    assert doctest.testmod(import_module(name)).failed == 0


def anchors(document):
    """Return a document's anchors, as GitHub derives them from its headings."""
    headings = re.findall(r"(?m)^#+ (.*)$", document.read_text())
    texts = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower() for heading in headings]
    return [re.sub(r"[^\w\- ]", "", text).replace(" ", "-") for text in texts]


@pytest.mark.parametrize("document", DOCUMENTS, ids=str)
def test_links_lead_somewhere(document):
    text = re.sub(r"(?s)```.*?```", "", (ROOT / document).read_text())
    for target, anchor in re.findall(r"\]\((?!https?:)([^)#]*)#?([^)]*)\)", text):
        path = (ROOT / document).parent / target if target else ROOT / document
        assert path.exists(), target
        assert not anchor or anchor in anchors(path), f"{target}#{anchor}"


def test_what_is_made_from_the_modelling_table_is_current():
    spec = spec_from_file_location("modelling", ROOT / "docs/modelling.py")
    modelling = module_from_spec(spec)
    spec.loader.exec_module(modelling)
    for path, text in modelling.files().items():
        assert path.read_text() == text, f"{path}: run python docs/modelling.py"


def test_the_stub_of_the_core_is_current(monkeypatch):
    pytest.importorskip("nanobind.stubgen")
    monkeypatch.syspath_prepend(ROOT / "docs")
    stub = import_module("stub")
    assert ast.dump(ast.parse(stub.stub())) == ast.dump(ast.parse(stub.PATH.read_text())), "run python docs/stub.py"


@pytest.fixture
def gallery(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs")
    monkeypatch.chdir(ROOT)
    return import_module("gallery")


def test_gallery_shows_every_word(gallery):
    shown = {section.title: section.code for section in gallery.SECTIONS}
    for title, belongs in import_module("modelling").SECTIONS:
        words = [word.name for word in WORDS if belongs(word)]
        assert list(shown[title]) == words
        for word, code in shown[title].items():
            call = rf"ease\.{word}\)" if title == "Easing functions" else rf"\b{word}\("
            assert re.search(call, code), f"{title}: {word} isn't in {code}"


def test_gallery_pictures_have_something_on_them(gallery):
    for section in gallery.SECTIONS:
        for caption in section.code:
            picture, _ = gallery.draw(section, caption, 16)
            assert np.count_nonzero(picture) > 8, f"{section.title}: {caption}"


def test_gallery_page_is_current(gallery):
    assert (ROOT / "docs/gallery.md").read_text() == gallery.document(), "run python docs/gallery.py"


def test_every_nurbs_file_is_described():
    text = (ROOT / "docs/nurbs.md").read_text()
    assert [ending for ending in (*NURBS_READERS, *CAD_READERS) if f"`{ending}`" not in text] == []


def test_every_file_that_is_read_is_named():
    assert {ending for endings in KINDS.values() for ending in endings} == set(ALL_ENDINGS)
    assert [ending for ending in ALL_ENDINGS if not re.search(rf"\{ending}\b", bob.load.__doc__)] == []
    formats = (ROOT / "docs/formats.md").read_text()
    assert [ending for ending in ALL_ENDINGS if not re.search(rf"\{ending}\b", formats)] == []


def test_map_is_the_tree():
    tree = (ROOT / "CONTRIBUTING.md").read_text().split("## Where things are")[1]
    named = {f"{folder}/" for folder in ("core", "bindings", "src/bobrossnet", "bench", "tests", "examples", "docs")}
    assert all(folder in tree for folder in named)
    package = {
        path.name for path in (ROOT / "src/bobrossnet").iterdir() if path.is_dir() and path.name != "__pycache__"
    }
    core = {path.name for path in (ROOT / "core").iterdir() if path.is_dir()}
    assert all(f"{folder}/" in tree for folder in package | core)


def test_shading_constants_are_the_codes():
    code = (ROOT / "core/tracing/material.h").read_text()
    ambient, diffuse, specular, shininess = re.search(
        r"ambient = (.+), diffuse = (.+), specular = (.+), shininess = (.+);", code
    ).groups()
    light = re.search(r"light_direction\{(.+)f, (.+)f, (.+)\}", code).groups()
    text = (ROOT / "docs/reference/shading.md").read_text()
    assert f"gray = {ambient} + {diffuse} max(0, n·l) + {specular} max(0, n·h)^{shininess}" in text
    assert f"direction ({', '.join(light)})" in text
    crease = re.search(r"crease_angle_degrees = (\d+)", (ROOT / "core/shapes/mesh/normals.h").read_text()).group(1)
    assert f"crease angle of {crease}°" in (ROOT / "docs/reference/meshes.md").read_text()
