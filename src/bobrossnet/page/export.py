"""Writes the viewer's page to a folder, for any server, or a scene to a single file that needs no server."""

from __future__ import annotations

import base64
import hashlib
import shutil
import zlib
from collections.abc import Mapping
from html import escape
from pathlib import Path

from bobrossnet.adapters.container import packed
from bobrossnet.completion.weights import WEIGHTS
from bobrossnet.page.files import Files, check_built
from bobrossnet.page.joining import BROUGHT, SINGLE, Modules, brought, joined
from bobrossnet.page.look import written
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.support.atomic import check_writable, write_whole
from bobrossnet.support.errors import InputError
from bobrossnet.support.paths import VIEWER
from bobrossnet.tracing.scene import SceneLike, as_scene

NETWORKS = ("default", "filling", "small", "uncertainty")
"""Names of the weights that the page loads."""

STYLE = "html, body { height: 100%; margin: 0; } bob-view { width: 100%; height: 100%; }"

PAGE = """<!doctype html>
<html lang="en">
<head>
  <meta charset="utf-8">
  <meta name="viewport" content="width=device-width, initial-scale=1">
  <meta http-equiv="Content-Security-Policy" content="{policy}">
  <title>{title}</title>
  <style>{style}</style>
</head>
<body>
<bob-view alt="Picture of {title}" camera-controls{look}></bob-view>
<script type="module">{script}</script>
</body>
</html>
"""


def export(files: Files, folder: Path) -> None:
    """Write the page to a folder that any static server can serve.

    Raises
    ------
    InputError
        If the folder can't be written.
    """
    try:
        for path, content in files.items():
            target = folder / path
            target.parent.mkdir(parents=True, exist_ok=True)
            if isinstance(content, bytes):
                target.write_bytes(content)
            else:
                shutil.copyfile(content, target)
    except OSError as error:
        raise InputError(f"{folder}: can't write the page there: {error.strerror}") from error


def export_file(scene: SceneLike, title: str, file: Path, look: Mapping[str, str] | None = None) -> None:
    """Write a scene as a page of one file.

    It works from a disk, from any server, and in an iframe that may run scripts. `look` comes from `look.attributes`.

    Raises
    ------
    InputError
        If the file can't be written, or the package was built without its WebAssembly modules.
    """
    check_writable(file)
    look = look or {}
    parts = {**single_file_parts(scene), "scene.bob": deflated(packed(scene))}
    modules = Modules(VIEWER)
    script = joined(Modules(VIEWER, {BROUGHT: brought(modules, parts)}), SINGLE).replace("</", "<\\/")
    policy = "; ".join(
        [
            "default-src 'none'",
            f"script-src '{_digest(script)}' 'wasm-unsafe-eval'",
            f"style-src '{_digest(STYLE)}'",
            "worker-src blob:",
            "base-uri 'none'",
            "form-action 'none'",
        ]
    )
    shown = written(look)
    text = PAGE.format(title=escape(title), look=shown, policy=policy, style=STYLE, script=script)
    write_whole(file, text.encode())


def single_file_parts(scene: SceneLike) -> dict[str, str]:
    """Return the parts that show a scene, for `joining.brought`: a core for all browsers, the small one for meshes."""
    check_built()
    are_meshes = all(isinstance(instance.shape, Mesh) for instance in as_scene(scene).instances)
    core = "core.mesh.light.wasm" if are_meshes else "core.wasm"
    files = {core: VIEWER / core}
    files |= {f"weights/{name}.safetensors": WEIGHTS / f"{name}.safetensors" for name in NETWORKS}
    return {path: deflated(file.read_bytes()) for path, file in files.items()}


def deflated(data: bytes) -> str:
    """Compress bytes by raw deflate, and encode them in base64."""
    deflate = zlib.compressobj(9, wbits=-15)
    return base64.b64encode(deflate.compress(data) + deflate.flush()).decode()


def _digest(text: str) -> str:
    """Return the digest of an inline text for a content security policy."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
