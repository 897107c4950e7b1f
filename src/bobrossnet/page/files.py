"""The files of the viewer's page, by path."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TypeAlias
from urllib.parse import quote

import bobrossnet as bob
from bobrossnet.completion.weights import WEIGHTS
from bobrossnet.page.joining import APART, ENTRIES, Modules, joined
from bobrossnet.page.look import written
from bobrossnet.support.errors import InputError
from bobrossnet.support.paths import VIEWER
from bobrossnet.tracing.scene import SceneLike

GALLERY = "gallery/index.json"
TREE = "gallery/happy_tree.bob"

TYPES = {
    ".bob": "application/octet-stream",
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".md": "text/plain; charset=utf-8",
    ".png": "image/png",
    ".safetensors": "application/octet-stream",
    ".sdf": "text/plain; charset=utf-8",
    ".svg": "image/svg+xml",
    ".txt": "text/plain; charset=utf-8",
    ".vm": "text/plain; charset=utf-8",
    ".wasm": "application/wasm",
}
"""Content types by file ending: browsers refuse modules of another type."""

READ_IN_PAGE = (".ply", ".obj", ".stl", ".off", ".glb", ".gltf", ".3mf", ".json", ".sdf", ".vm", ".bob")
"""Endings that the page reads itself; any other file that Python reads is packed for it."""

LONGEST_STEM = 255 - len(".bob")
"""Maximum bytes of a file name before its ending: disks allow names of 255."""

Files: TypeAlias = Mapping[str, Path | bytes]
"""Served content: a file or bytes by the path from the page's folder."""


def check_built() -> None:
    """Raise InputError if the package was built without its WebAssembly modules."""
    if not (VIEWER / "core.wasm").is_file():
        raise InputError(
            "viewer: expected core.wasm in the package, got none; run `make page` in the clone, which builds it, "
            "or install a wheel"
        )


def title_of(file: str) -> str:
    """Return a file's name without its ending as displayed text: invalid UTF-8 becomes U+FFFD."""
    return os.fsencode(Path(file).stem).decode("utf-8", "replace")


def scene_path(name: str) -> str:
    """Return a scene's path among the page's files, with a name that disks allow."""
    return f"files/{name.encode()[:LONGEST_STEM].decode('utf-8', 'ignore')}.bob"


def scene_address(name: str) -> str:
    """Return the scene's path as a relative URL."""
    return quote(scene_path(name))


def tree() -> bob.Instance:
    """Return the page's default scene."""
    return bob.Instance(bob.happy_tree(), name="happy tree")


@contextmanager
def page_files(
    scene: SceneLike | None = None, name: str = "scene", look: Mapping[str, str] | None = None
) -> Iterator[Files]:
    """Provide all files of the page for the duration of the context.

    Parameters
    ----------
    scene : SceneLike, optional
        The first scene of the page; by default the gallery's first.
    name : str
        The scene's title, and the name of its file.
    look : mapping, optional
        Attributes from `look.attributes`, for all scenes of the page.

    Raises
    ------
    InputError
        If the package was built without its WebAssembly modules.
    """
    check_built()
    files: dict[str, Path | bytes] = {
        file.relative_to(VIEWER).as_posix(): file for file in VIEWER.rglob("*") if file.suffix in TYPES
    }
    files |= {f"weights/{file.name}": file for file in WEIGHTS.glob("*.safetensors")}
    modules = Modules(VIEWER)
    files |= {path: joined(modules, path, APART).encode() for path in (*ENTRIES, *APART)}
    # Windows keeps files that are still being sent at the end of the context.
    with tempfile.TemporaryDirectory(prefix="bobrossnet-view-", ignore_cleanup_errors=True) as folder:
        packed = Path(folder)

        def add(path: str, scene: SceneLike) -> None:
            file = packed / f"{len(files)}.bob"
            bob.save_scene(scene, file)
            files[path] = file

        add(TREE, tree())
        if scene is not None:
            add(scene_path(name), scene)
            gallery = json.loads((VIEWER / GALLERY).read_bytes())
            opened = {"file": f"../{scene_address(name)}", "title": name, "kind": "file"}
            files[GALLERY] = json.dumps([opened, *gallery]).encode()
        if look:
            text = (VIEWER / "index.html").read_text("utf-8")
            files["index.html"] = text.replace("<body>", f"<body{written(look, 'data-')}>", 1).encode()
        yield files
