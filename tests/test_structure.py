"""The layers: picture depends on neither tracing nor completion, nor these on each other, in any language."""

import posixpath
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "src/bobrossnet"
VIEWER = ROOT / "viewer"

# The folders that each folder may use, besides itself.
CORE = {
    "base": set(),
    "files": {"base", "formula", "shapes", "tracing"},
    "formula": {"base"},
    "modelling": {"base", "formula"},
    "nurbs": {"base"},
    "shapes": {"base", "formula", "nurbs"},
    "picture": {"base"},
    "sampling": {"base", "picture"},
    "reprojection": {"base", "picture"},
    "tracing": {"base", "picture", "sampling", "shapes"},
    "light": {"base", "picture", "shapes", "tracing"},
    "drawing": {"base", "picture", "shapes", "tracing"},
    "completion": {"base", "picture", "sampling"},
    "frame": {"completion", "light", "picture"},
}
PYTHON = {
    "support": set(),
    "picture": {"support"},
    "shapes": {"support"},
    "tracing": {"picture", "shapes", "support"},
    "completion": {"picture", "support"},
    "measuring": {"picture", "shapes", "support", "tracing"},
    "frames": {"completion", "measuring", "picture", "pictures", "support", "tracing"},
    "sdf": {"adapters", "picture", "shapes", "support", "tracing"},  # for the language's word that reads a file
    "adapters": {"picture", "sdf", "shapes", "support", "tracing"},
    "pictures": {"adapters", "completion", "measuring", "picture", "shapes", "support", "tracing"},
    "page": {"adapters", "completion", "picture", "pictures", "shapes", "support", "tracing"},
    "agents": {"adapters", "measuring", "picture", "pictures", "shapes", "support", "tracing"},
}
PAGE = {
    "core": set(),
    "picture": {"core"},
    "shapes": {"core"},
    "tracing": {"core", "picture", "shapes"},
    "completion": {"core", "files", "picture"},
    "files": {"core", "shapes", "tracing"},
    "workers": {"core", "picture", "shapes", "tracing", "completion", "files"},
    "component": {"core", "picture", "shapes", "tracing", "workers"},
    "interface": {"component", "core", "picture", "shapes", "tracing"},
}


def forbidden(used, allowed):
    """Return forbidden uses, and the file of each."""
    return [f"{file.name}: {what}" for file, what in used if what.split("/")[0] not in allowed]


@pytest.mark.parametrize("folder", CORE)
def test_layers_of_the_core(folder):
    folders = {path.name for path in (ROOT / "core").iterdir() if path.is_dir()} - {"fuzz", "tests"}
    assert folders == set(CORE)
    files = [*(ROOT / "core" / folder).rglob("*.h"), *(ROOT / "core" / folder).rglob("*.cpp")]
    used = [(file, name) for file in files for name in re.findall(r'#include "(\w+/.+?)"', file.read_text())]
    assert files
    assert forbidden(used, CORE[folder] | {folder}) == []


def test_the_core_knows_neither_python_nor_browsers():
    text = "".join(file.read_text() for file in (ROOT / "core").glob("**/*.*") if file.suffix in (".h", ".cpp"))
    assert not re.search(r"nanobind|Python\.h|emscripten|export_name", text)
    assert [path.name for path in (ROOT / "core").iterdir() if path.is_file()] == []


@pytest.mark.parametrize("folder", PYTHON)
def test_layers_of_the_package(folder):
    folders = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    assert folders == set(PYTHON) | {"command_line", "learn"}
    files = list((PACKAGE / folder).glob("**/*.py"))
    used = [
        (file, module)
        for file in files
        for module in re.findall(r"^\s*(?:from|import) bobrossnet\.(\w+)", file.read_text(), re.MULTILINE)
        if module in folders
    ]
    assert files
    assert forbidden(used, PYTHON[folder] | {folder}) == []


def test_nothing_imports_learn():
    """Entry points lead to it, so that pictures never wait for torch."""
    files = [file for file in PACKAGE.rglob("*.py") if "learn" not in file.relative_to(PACKAGE).parts]
    assert files
    learn = re.compile(r"^\s*(from|import) bobrossnet\.learn", re.MULTILINE)
    assert [file.name for file in files if learn.search(file.read_text())] == []


@pytest.mark.parametrize("folder", PAGE)
def test_layers_of_the_page(folder):
    files = list((VIEWER / folder).glob("**/*.js"))
    used = []
    for file in files:
        for path in re.findall(r"""(?:from |import\(|import )["'`](\..+?)["'`]""", file.read_text()):
            place = posixpath.normpath(posixpath.join(file.parent.relative_to(VIEWER).as_posix(), path))
            used.append((file, place))
    assert files
    assert forbidden(used, PAGE[folder] | {folder}) == []


def test_what_is_to_be_touched_is_there():
    """Each file named in docs/architecture.md."""
    text = (ROOT / "docs/architecture.md").read_text()
    bases = (ROOT, PACKAGE, ROOT / "core", VIEWER)

    def exists(name):
        return any((base / name).exists() or list(base.glob(f"{name}.*")) for base in bases)

    names = [name for name in re.findall(r"`([\w./{},]+/[\w./{},]*)`", text) if not re.search("NAME|KIND|FORMAT", name)]
    each = [re.fullmatch(r"(.*?)(?:\{(.+)\})?", name).groups() for name in names]
    assert [stem + e for stem, endings in each for e in (endings or "").split(",") if not exists(stem + e)] == []
