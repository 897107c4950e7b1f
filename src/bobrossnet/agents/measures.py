"""Numbers about scenes: their contents, and the differences of two."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.measuring.measure import FaceMeasures, amount_of, triangles_of
from bobrossnet.measuring.overlaps import overlaps
from bobrossnet.measuring.picking import Pick
from bobrossnet.measuring.volumes import Amount, edge_faults, of_triangles
from bobrossnet.picture.camera import VIEWS, Camera
from bobrossnet.picture.order import Size
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.tracing.parts import Part
from bobrossnet.tracing.pixels import pixel_rays, tiled_pixels
from bobrossnet.tracing.scene import Scene

MAX_PARTS = 200
"""Maximum number of parts that are described one by one."""

PRIMITIVES = {"mesh": "triangle", "brep": "face"}
"""The parts of shapes that hits name."""

SIDE = 256
"""Rays along each side of a compared view."""

ONLY_FIRST, ONLY_SECOND, APART = (222, 45, 38), (33, 102, 220), (255, 160, 0)
"""Colours of a picture of differences: surfaces of one scene alone, and others by their difference of depth."""


def described(scene: Scene, warnings: list[str]) -> dict[str, Any]:
    """Return the contents of a scene: kinds, sizes, parts, volumes and overlaps of parts, in the scene's units."""
    box, cache = scene.extent, dict[int, Amount]()
    own = [part for part in scene.parts.walk() if part.own]
    parts = [_of_part(scene, part, cache) for part in own[:MAX_PARTS]]
    found, unchecked = overlaps(scene)
    whole: dict[str, Any] = {
        "kinds": sorted({instance.shape.kind for instance in scene.instances}),
        "unit": scene.unit,
        "size": rounded_all(box.size),
        "bounds": [rounded_all(box.low), rounded_all(box.high)],
        **{f"{noun}s": count for noun, count in scene.counts().items()},
    }
    if len(parts) == len(own):
        volumes = [part["volume"] for part in parts]
        whole |= told_volume(None if None in volumes else sum(volumes))
    return whole | {
        "part_count": len(own),
        "parts": parts,
        "overlaps": [
            {"parts": [*map(str, each.parts)], "volume": rounded(each.volume), "depth": rounded(each.depth)}
            for each in found
        ],
        **({"unchecked_pairs": unchecked} if unchecked else {}),
        "warnings": warnings,
    }


def _of_part(scene: Scene, part: Part, cache: dict[int, Amount]) -> dict[str, Any]:
    """Return the contents of one part."""
    shapes = [(scene.instances[number].shape, stop - start) for number, start, stop in part.own]
    kinds = {shape.kind for shape, _ in shapes}
    told: dict[str, Any] = {"name": str(part), "kind": " and ".join(sorted(kinds))}
    for shape, count in shapes:
        if noun := PRIMITIVES.get(shape.kind):
            told[f"{noun}s"] = told.get(f"{noun}s", 0) + count
    low, high = part.extent
    told["bounds"] = [rounded_all(low), rounded_all(high)]
    if not all(isinstance(shape, Mesh) for shape, _ in shapes):
        amount = amount_of(scene, part.own, cache)
        return told | {"area": rounded(amount.area)} | told_volume(amount.volume) | {"error": rounded(amount.error)}
    vertices, triangles = triangles_of(scene, part.own)
    amount = of_triangles(vertices, triangles)
    told |= {"area": rounded(amount.area)} | told_volume(amount.volume)
    if amount.volume is None:
        told["open_edges"], told["flipped_edges"] = edge_faults(vertices, triangles)
    elif amount.volume < 0:
        told["inside_out"] = True
    return told


def told_pick(found: Pick) -> dict[str, Any]:
    """Return the description of a picked surface for agents, in the scene's units; `highlight` names it to `look`."""
    shape = found.scene.instances[found.instance].shape
    told: dict[str, Any] = {"part": str(found.part)}
    if found.section is not None:
        told["section"] = found.section
    elif found.face is not None:
        told[PRIMITIVES[shape.kind]] = found.face
        told["highlight"] = f"{found.part}#{found.part.number_of(found.instance, found.face)}"
    if found.snapped is not None:
        told["snapped"] = found.snapped
        if found.radius is not None:
            told["radius"] = rounded(found.radius)
    return told | {
        "point": rounded_all(found.point),
        "normal": [round(float(value), 4) + 0.0 for value in found.normal],
    }


def told_face(face: FaceMeasures) -> dict[str, Any]:
    """Return the description of a picked face for agents."""
    told: dict[str, Any] = {"kind": face.kind}
    for name in ("radius", "major_radius", "half_angle", "area", "thickness"):
        if (value := getattr(face, name)) is not None:
            told[name] = rounded(value)
    for name in ("center", "axis"):
        if (place := getattr(face, name)) is not None:
            told[name] = rounded_all(place)
    return told | {"unit": face.unit}


def told_volume(volume: float | None) -> dict[str, Any]:
    """Return a volume for agents, None for an open surface."""
    return {"closed": volume is not None, "volume": None if volume is None else rounded(volume)}


def compared(first: Scene, second: Scene) -> dict[str, Any]:
    """How two scenes differ as they stand: by silhouettes and depths in all `VIEWS`.

    Returns
    -------
    dict
        For each view the silhouettes' intersection over union and the largest difference of depth, in units, where both
        have a surface; and the sizes.
    """
    both = Scene([first, second])
    views = {}
    for name in VIEWS:
        depths = _depths(first, second, Camera.named(name), both, (SIDE, SIDE))
        hit = np.isfinite(depths)
        overlap, union = int(hit.all(axis=0).sum()), int(hit.any(axis=0).sum())
        views[name] = {
            "silhouette_iou": round(overlap / union, 5) if union else 1.0,
            "largest_depth_difference": float(f"{_apart(depths).max(initial=0):.4g}"),
        }
    return {"size": [rounded_all(scene.extent.size) for scene in (first, second)], "views": views}


def differences(first: Scene, second: Scene, camera: Camera, both: Scene, size: Size) -> NDArray[np.uint8]:
    """Draw where two scenes differ, (H, W, 3): red where only the first has a surface, blue where only the second, and
    else from gray to orange by the difference of depth. The camera refers to the scene `both`."""
    depths = _depths(first, second, camera, both, size)
    first_hit, second_hit = np.isfinite(depths)
    apart = _apart(depths)
    picture = np.full((*size, 3), 255, np.uint8)
    share = (apart / max(float(apart.max(initial=0)), 1e-5 * both.radius))[..., None]
    surfaces = ((1 - share) * 200 + share * APART).astype(np.uint8)
    for where, color in (
        (first_hit & second_hit, surfaces),
        (first_hit & ~second_hit, np.array(ONLY_FIRST, np.uint8)),
        (second_hit & ~first_hit, np.array(ONLY_SECOND, np.uint8)),
    ):
        picture = np.where(where[..., None], color, picture)
    return picture


def _depths(first: Scene, second: Scene, camera: Camera, both: Scene, size: Size) -> NDArray[np.float64]:
    """Return the distances of both scenes' surfaces along a camera's rays, (2, H, W); infinite for a miss."""
    pixels = tiled_pixels(size)
    which, origins, directions = pixel_rays(camera, both.center, both.radius, size, pixels)
    rows, columns = pixels[which].T
    depths = np.full((2, *size), np.inf)
    for depth, scene in zip(depths, (first, second), strict=True):
        depth[rows, columns] = scene.closest_hits(origins, directions).distance
    return depths


def _apart(depths: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the differences of depth, (H, W), 0 where a scene has no surface."""
    found = np.isfinite(depths).all(axis=0)
    first, second = np.where(found, depths, 0)
    apart: NDArray[np.float64] = np.abs(first - second)
    return apart


def rounded(number: float) -> float:
    """A length in six digits: single precision has no more."""
    return float(f"{number:.6g}")


def rounded_all(numbers: Any) -> list[float]:
    """Lengths in six digits."""
    return [rounded(float(number)) for number in numbers]
