"""Numbers about scenes: what they consist of, and how two of them differ."""

from __future__ import annotations

from typing import Any

import numpy as np

from bobrossnet.measuring.picking import Pick
from bobrossnet.measuring.volumes import closed_volume
from bobrossnet.picture.camera import VIEWS, Camera
from bobrossnet.shapes.affine import mapped
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.tracing.pixels import pixel_rays, tiled_pixels
from bobrossnet.tracing.scene import Scene

MAX_PARTS = 200
"""That are described one by one."""

PRIMITIVES = {"mesh": "triangle", "brep": "face"}
"""The parts of shapes that hits name."""

SIDE = 256
"""Rays along each side of a compared view."""


def described(scene: Scene, warnings: list[str]) -> dict[str, Any]:
    """What is in a scene: kinds, sizes, parts, and the volume of closed meshes, in the scene's units."""
    box = scene.extent
    parts = []
    for instance, (low, high) in zip(scene.instances[:MAX_PARTS], scene.boxes, strict=False):
        part: dict[str, Any] = {"name": instance.name, "kind": instance.shape.kind}
        part |= {f"{noun}s": count for noun, count in instance.shape.counts().items()}
        part["bounds"] = [rounded_all(low), rounded_all(high)]
        if isinstance(instance.shape, Mesh):
            volume = closed_volume(mapped(instance.transform, instance.shape.vertices), instance.shape.triangles)
            part |= told_volume(volume)
            if volume is not None and volume * np.linalg.det(instance.transform[:3, :3]) < 0:
                part["inside_out"] = True
        parts.append(part)
    return {
        "unit": scene.unit,
        "size": rounded_all(box.size),
        "bounds": [rounded_all(box.low), rounded_all(box.high)],
        "part_count": len(scene.instances),
        "parts": parts,
        "warnings": warnings,
    }


def told_pick(found: Pick) -> dict[str, Any]:
    """What agents are told of a picked surface, in the scene's units."""
    instance = found.scene.instances[found.instance]
    return {
        "part": found.instance,
        "name": instance.name,
        **({} if found.face is None else {PRIMITIVES[instance.shape.kind]: found.face}),
        "point": rounded_all(found.point),
        "normal": [round(float(value), 4) + 0.0 for value in found.normal],
    }


def told_volume(volume: float | None) -> dict[str, Any]:
    """What agents are told of a `closed_volume`."""
    return {"closed": volume is not None, "volume": None if volume is None else rounded(volume)}


def compared(first: Scene, second: Scene) -> dict[str, Any]:
    """How two scenes differ as they stand: by silhouettes and depths in all `VIEWS`.

    Returns
    -------
    dict
        For each view the silhouettes' intersection over union and the largest difference of depth, in units, where both
        have a surface; and the sizes.
    """
    boxes = first.extent, second.extent
    low, high = np.minimum(boxes[0].low, boxes[1].low), np.maximum(boxes[0].high, boxes[1].high)
    center, radius = (low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, 1e-300)
    views, size = {}, (SIDE, SIDE)
    for name in VIEWS:
        _, origins, directions = pixel_rays(Camera.named(name), center, radius, size, tiled_pixels(size))
        depths = [scene.closest_hits(origins, directions).distance for scene in (first, second)]
        hit = [np.isfinite(depth) for depth in depths]
        both = hit[0] & hit[1]
        union = int((hit[0] | hit[1]).sum())
        views[name] = {
            "silhouette_iou": round(int(both.sum()) / union, 5) if union else 1.0,
            "largest_depth_difference": float(f"{np.abs(depths[0][both] - depths[1][both]).max(initial=0):.4g}"),
        }
    return {"size": [rounded_all(box.size) for box in boxes], "views": views}


def rounded(number: float) -> float:
    """A length in six digits: single precision has no more."""
    return float(f"{number:.6g}")


def rounded_all(numbers: Any) -> list[float]:
    """Lengths in six digits."""
    return [rounded(float(number)) for number in numbers]
