"""The npm package of <bob-view>: its files in a folder, for `npm pack` and `npm publish`.

python -m bobrossnet.page.package FOLDER
"""

from __future__ import annotations

import json
import sys
from importlib.metadata import distribution
from pathlib import Path

from bobrossnet import __version__
from bobrossnet.completion.weights import WEIGHTS
from bobrossnet.page.export import NETWORKS, export
from bobrossnet.page.files import check_built
from bobrossnet.page.joining import APART, COMPONENT, WORKERS, Modules, joined
from bobrossnet.support.paths import VIEWER

NAME = "bob-view"

README = """# &lt;bob-view&gt;

Shows meshes, implicit surfaces and NURBS in a page: a few percent of the pixels are ray traced for each picture as it
turns, the others completed by a tiny network, and all of them traced when it rests. No GPU, no server.

    npm install bob-view

```html
<script type="module" src="node_modules/bob-view/component/bob-view.js"></script>
<bob-view src="part.glb" alt="A bracket with two holes" camera-controls></bob-view>
```

Its files stay as they are beside each other, on any server, also another one that allows it. Attributes are those of
&lt;model-viewer&gt; as far as it has them: `src`, `alt`, `poster`, `camera-orbit`, `field-of-view`, `camera-controls`,
`auto-rotate`, `interaction-prompt`, `background`. Events: `load`, `progress`, `error`, `camera-change`. It reads .ply,
.obj, .stl, .off, .glb, .gltf, .json (geomdl), .sdf, .vm and .bob; the Python package `bobrossnet` makes .bob of other
files, and has the whole documentation.

The licences of the libraries in its WebAssembly modules are in NOTICES.txt.
"""


def write_package(folder: Path) -> None:
    """Write the package's files to a folder.

    Raises
    ------
    InputError
        If the folder can't be written, or the package was built without its WebAssembly modules.
    """
    check_built()
    modules = Modules(VIEWER)
    entries = [COMPONENT, *APART, *(f"workers/{name}.js" for name in WORKERS)]
    description = {
        "name": NAME,
        "version": __version__,
        "description": "An element that shows meshes, implicit surfaces and NURBS, ray traced",
        "license": "MIT",
        "type": "module",
        "exports": {".": f"./{COMPONENT}", "./*": "./*"},
        "sideEffects": [f"./{COMPONENT}"],
    }
    export(
        {
            "package.json": json.dumps(description, indent=2).encode(),
            "README.md": README.encode(),
            "LICENSE": (distribution("bobrossnet").read_text("licenses/LICENSE") or "MIT").encode(),
            "NOTICES.txt": (distribution("bobrossnet").read_text("licenses/vendor/NOTICES.txt") or "").encode(),
            **{entry: joined(modules, entry, APART).encode() for entry in entries},
            **{file.name: file for file in VIEWER.glob("core*.wasm")},
            **{f"weights/{name}.safetensors": WEIGHTS / f"{name}.safetensors" for name in NETWORKS},
        },
        folder,
    )


if __name__ == "__main__":
    write_package(Path(sys.argv[1]))
