"""glTF files of kinds that readers get wrong, by their paths in tests/cases.

The numbers follow from the specification, or come from three.js. Bounds are in the file's axes, y up.
"""

from typing import NamedTuple

QUADRANTS = "quadrants"
"""Four colours on each face."""


class Case(NamedTuple):
    bounds: list[list[float]] | None = None
    """Lowest and highest corner of each instance, one after the other."""
    area: float | None = None
    color: str | tuple[float, float, float] | None = None
    """Of its first material or of its vertices, linear RGB; or of its texture."""
    warning: str | None = None
    error: str | None = None


BOX = [[-0.5, -0.5, -0.5, 0.5, 0.5, 0.5]]
RED, PALE_RED = (0.9, 0.1, 0.1), (0.9, 0.02, 0.02)

CASES = {
    "draco/every-kind.glb": Case([[-1.1525, -1, -1.016, 7.1525, 1, 1.2], [1.18, -0.5, -1.016, 4.82, 1, 1.2]], 44.1557),
    "emissive-map/box.glb": Case(BOX, 6, QUADRANTS, "box.glb: not shown: emission maps"),
    "fan/disk.glb": Case([[-1, -1, 0, 1, 1, 0]], 3),
    "gray-of-16-bits/box.glb": Case(BOX, 6, "gradient"),
    "instancing/four-boxes.glb": Case([[-2.5, -0.5, -0.5, 2.5, 2.5, 0.5]], 3 * 6 + 6 / 4, RED),
    "meshopt/ball.glb": Case([[-0.9993, -0.995, -0.9993, 0.9993, 0.995, 0.9993]], 12.4692),
    "metal-map/plastic-by-factors.glb": Case(BOX, 6),
    "metal-map/plastic-by-map.glb": Case(BOX, 6),
    "morph/weight-of-mesh.glb": Case([[-0.5, -0.5, -0.5, 0.5, 2.5, 0.5]], 14, RED),
    "quantized/places-of-integers.glb": Case(BOX, 6, QUADRANTS),
    "quantized/points-normalized.glb": Case(BOX, 6, QUADRANTS),
    "required-extension/box.glb": Case(error="extensionsRequired: expected extensions that are known, got 'EXAMPLE_"),
    "skin/joint-moves.glb": Case([[-2, -1, -1, 0, 1, 1], [1.5, -0.5, -0.5, 2.5, 0.5, 0.5]], 30, RED),
    "skin/node-is-ignored.glb": Case([*BOX, [1.5, -0.5, -0.5, 2.5, 0.5, 0.5]], 12, RED),
    "sparse/colors.glb": Case(BOX, 6, PALE_RED),
    "sparse/points.glb": Case([[-0.5, -0.5, -0.5, 0.5, 2.5, 0.5]], 14),
    "spec-gloss/box.glb": Case(BOX, 6, QUADRANTS, "box.glb: not shown: specular colours"),
}
