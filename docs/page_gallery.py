"""Writes the gallery of the viewer's page, viewer/gallery, from the gallery here.

python docs/page_gallery.py

The built-in scene is not among these files: the page's server and its export make it. The scripts of examples/ are
added when the package is built.
"""

from __future__ import annotations

import json
from pathlib import Path

from gallery import FORMULAS, NURBS, NURBS_HELPERS, ROOT, made

import bobrossnet as bob

FOLDER = ROOT / "viewer/gallery"

SCRIPTS = {
    "csg": "ball, box and cylinders",
    "gear": "gear",
    "tower": "tower",
    "toadstool": "toadstool",
    "vase": "vase with flutes",
}
"""Titles of the scenes in the folder and in examples/."""
IMPLICITS = ["gyroid", "tanglecube", "heart", "metaballs"]
SPLINES = ["a lantern", "a ring of ribbons", "a sea shell", "a flower", "a knot"]


def write(folder: Path) -> None:
    """Write the gallery's scenes and its table of contents."""
    index = [
        *({"file": f"{name}.sdf", "title": title, "kind": "script"} for name, title in SCRIPTS.items()),
        {"file": "happy_tree.bob", "title": "happy tree", "kind": "mesh"},
    ]
    for kind, names, codes, helpers in (
        ("implicit", IMPLICITS, FORMULAS, ""),
        ("NURBS", SPLINES, NURBS, NURBS_HELPERS),
    ):
        for name in names:
            title = name.removeprefix("a ")
            file = f"{title.replace(' ', '_').lower()}.bob"
            bob.save_scene(made(codes[name], helpers), folder / file)
            index.append({"file": file, "title": title, "kind": kind})
    (folder / "index.json").write_text(
        "[\n" + ",\n".join(f"  {json.dumps(entry)}" for entry in index) + "\n]\n", "utf-8"
    )


if __name__ == "__main__":
    write(FOLDER)
