"""Shapes from meshes and scenes of trimesh, and of libraries with the same attributes."""

from __future__ import annotations

from typing import Any

import numpy as np

from bobrossnet.color import from_srgb
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.tracing.instance import Instance
from bobrossnet.tracing.scene import SceneLike


def is_foreign(value: Any) -> bool:
    """Whether a value is a mesh with `vertices` and `faces`, or a scene with `geometry` and `graph`."""
    return _is_mesh(value) or (hasattr(value, "geometry") and hasattr(value, "graph"))


def shapes_of(value: Any) -> SceneLike:
    """Return the shapes of a mesh or scene, with colours and textures."""
    return _mesh(value) if _is_mesh(value) else _instances(value)


def _is_mesh(value: Any) -> bool:
    return hasattr(value, "vertices") and hasattr(value, "faces")


def _mesh(mesh: Any) -> Mesh:
    visual: Any = getattr(mesh, "visual", None)
    kind = getattr(visual, "kind", None)
    surface: dict[str, Any] = {}
    if kind == "vertex":
        surface = {"colors": _linear(visual.vertex_colors)}
    elif kind == "face":
        surface = {"face_colors": _linear(visual.face_colors)}
    elif kind == "texture" and getattr(visual, "uv", None) is not None:
        material = visual.material
        image = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
        if image is not None:
            # trimesh's v starts at the bottom.
            surface = {"uv": np.asarray(visual.uv) * (1, -1) + (0, 1), "texture": np.asarray(image.convert("RGB"))}
    return Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces), **surface)


def _linear(colors: Any) -> Any:
    """Return linear RGB of (n, 4) uint8 sRGB."""
    return from_srgb(np.asarray(colors)[:, :3] / 255)


def _instances(scene: Any) -> list[Instance]:
    """Return trimesh's placed meshes; a repeated mesh is stored once."""
    placed = [(str(node), *scene.graph.get(node)) for node in scene.graph.nodes_geometry]
    meshes = {name: _mesh(mesh) for name, mesh in scene.geometry.items() if _is_mesh(mesh)}
    return [Instance(meshes[mesh], matrix, name=node) for node, matrix, mesh in placed if mesh in meshes]
