"""The npm package of <bob-view>: its files in a folder, for `npm pack` and `npm publish`.

python -m bobrossnet.page.package FOLDER TSC
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib.metadata import distribution
from pathlib import Path

from bobrossnet import __version__
from bobrossnet.completion.weights import WEIGHTS
from bobrossnet.page.export import NETWORKS, export
from bobrossnet.page.files import check_built
from bobrossnet.page.joining import APART, COMPONENT, PLACES, WORKERS, Modules, joined, places
from bobrossnet.page.manifest import NAME, manifest, rows, types
from bobrossnet.support.paths import VIEWER

README = Path(__file__).with_name("npm.md")
"""Its words in capitals are replaced."""

KEYWORDS = ("3d", "3d-viewer", "cad", "custom-element", "glb", "gltf", "nurbs", "ray-tracing", "sdf", "web-component")


def write_package(folder: Path) -> None:
    """Write the package's files to a folder.

    Raises
    ------
    InputError
        If the folder can't be written, or the package was built without its WebAssembly modules.
    """
    check_built()
    workers = [f"workers/{name}.js" for name in WORKERS]
    data = {
        **{file.name: file for file in VIEWER.glob("core*.wasm")},
        **{f"weights/{name}.safetensors": WEIGHTS / f"{name}.safetensors" for name in NETWORKS},
    }
    modules = Modules(VIEWER, {PLACES: places([*workers, *data])})
    description = {
        "name": NAME,
        "version": __version__,
        "description": "An element that shows meshes, implicit surfaces and NURBS, ray traced",
        "keywords": KEYWORDS,
        "license": "MIT",
        "type": "module",
        "exports": {
            ".": {"types": "./types/index.d.ts", "default": f"./{COMPONENT}"},
            **{f"./{name}": {"types": f"./types/{name}.d.ts"} for name in ("react", "vue")},
            "./*": "./*",
        },
        "types": "./types/index.d.ts",
        "customElements": "./custom-elements.json",
        "sideEffects": [f"./{COMPONENT}", "./workers/*.js"],
        **_addresses(os.environ.get("GITHUB_REPOSITORY")),
    }
    export(
        {
            "package.json": json.dumps(description, indent=2).encode(),
            "README.md": _readme().encode(),
            "custom-elements.json": manifest(VIEWER).encode(),
            **{f"types/{name}": text.encode() for name, text in types(VIEWER).items()},
            "LICENSE": (distribution("bobrossnet").read_text("licenses/LICENSE") or "MIT").encode(),
            "NOTICES.txt": (distribution("bobrossnet").read_text("licenses/vendor/NOTICES.txt") or "").encode(),
            **{entry: joined(modules, entry, APART).encode() for entry in (COMPONENT, *APART, *workers)},
            **data,
        },
        folder,
    )


def write_types(folder: Path, tsc: Path) -> None:
    """Add the types that TypeScript's compiler makes of the modules' comments."""
    options = "--allowJs --declaration --emitDeclarationOnly --target esnext --module esnext --moduleResolution bundler"
    places = ["--types", "", "--rootDir", str(VIEWER), "--outDir", str(folder / "types")]
    subprocess.run([tsc, VIEWER / COMPONENT, *options.split(), *places], check=True)


def _readme() -> str:
    """Return the package's front page, with the tables of the element."""
    text = README.read_text("utf-8").replace("VERSION", __version__)
    for kind in ("attribute", "event"):
        lines = [f"| {kind} | |", "|---|---|", *(f"| `{name}` | {told} |" for name, told in rows(VIEWER, kind))]
        text = text.replace(f"{kind.upper()}S", "\n".join(lines))
    return text


def _addresses(repository: str | None) -> dict[str, object]:
    """Return the addresses of the source and the documents of OWNER/NAME on GitHub, whose workflow publishes."""
    if not repository:
        return {}
    owner, _, name = repository.partition("/")
    return {
        "repository": {"type": "git", "url": f"git+https://github.com/{repository}.git"},
        "homepage": f"https://{owner}.github.io/{name}/",
        "bugs": f"https://github.com/{repository}/issues",
    }


if __name__ == "__main__":
    write_package(Path(sys.argv[1]))
    write_types(*map(Path, sys.argv[1:]))
