"""Digests of the installed package's results, run from an empty folder by the Python with the package.

Standard output is one line of JSON. Every shape except the tree has vertices of exact arithmetic, equal in any library.
"""

from __future__ import annotations

import hashlib
import json
import platform
import sys
from pathlib import Path

import numpy as np
from PIL import Image

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.command_line.cli import main


def waves() -> bob.Mesh:
    """Return a grid of 33 x 33 vertices; heights differ by fractions of a power of two."""
    x, y = np.meshgrid(np.arange(33), np.arange(33))
    vertices = np.stack([x, y, (x * y * 7 % 32) / 4], -1).reshape(-1, 3).astype(np.float32)
    corner = (x + 33 * y)[:-1, :-1].reshape(-1, 1)
    triangles = np.concatenate([corner + [0, 1, 34], corner + [0, 34, 33]])
    return bob.Mesh(vertices, triangles.astype(np.uint32))


def saddle() -> bob.Brep:
    """Return a bicubic patch with control points at multiples of 1/4."""
    u, v = np.meshgrid(np.arange(4), np.arange(4), indexing="ij")
    knots = np.array([0, 0, 0, 0, 1, 1, 1, 1], float)
    points = np.stack([u, v, (u - 1.5) * (v - 1.5)], -1).astype(float)
    return bob.Brep([bob.Face(points, knots, knots)])


def digest(*arrays: np.ndarray) -> str:
    return hashlib.sha256(b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)).hexdigest()[:16]


def completed(shape: object) -> dict[str, str]:
    part = bob.trace(shape, size=(120, 160), fraction=0.05)
    return {"traced": digest(part.mask, part.gray, part.depth, part.normal), "completed": digest(bob.complete(part))}


def rendered() -> str:
    """Return the digest of the built-in tree from 5 % of its pixels, by the command line."""
    main(["render", "--fraction", "5%", "--size", "240x180", "--out", "tree.png"])
    with Image.open("tree.png") as picture:
        return digest(np.asarray(picture))


shapes = {
    "tree": bob.happy_tree(),
    "mesh": waves(),
    "formula": bob.implicit(lambda x, y, z: x**4 + y**4 + z**4 - 5 * (x * x + y * y + z * z) + 11.8),
    "nurbs": saddle(),
}
best = _core.isa()
pictures = {}
for isa in ("baseline", "avx2", "avx512"):
    if _core.set_isa(isa):
        of_shapes = {f"{name}, {kind}": d for name, shape in shapes.items() for kind, d in completed(shape).items()}
        pictures[isa] = {**of_shapes, "tree, rendered": rendered()}
_core.set_isa(best)
json.dump(
    {
        "python": f"{platform.python_version()} {platform.machine()}",
        "package": str(Path(bob.__file__).parent),
        "isa": best,
        "pictures": pictures,
    },
    sys.stdout,
)
