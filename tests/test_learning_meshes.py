"""Procedural meshes and evaluation, at toy size."""

import numpy as np
import pytest

from bobrossnet.learn.shapes.meshes import FAMILIES, parts, procedural_mesh


@pytest.mark.parametrize("seed", range(0, 60, 3))
def test_procedural_mesh(seed: int) -> None:
    mesh, again = procedural_mesh(seed), procedural_mesh(seed)
    np.testing.assert_array_equal(mesh.vertices, again.vertices)
    np.testing.assert_array_equal(mesh.triangles, again.triangles)
    size = np.ptp(mesh.vertices, axis=0)
    assert size.max() == pytest.approx(2)
    assert 12 <= len(mesh.triangles) < 500_000
    assert not np.array_equal(mesh.vertices[:50], procedural_mesh(seed + 1).vertices[:50])


@pytest.mark.parametrize("family", list(FAMILIES))
@pytest.mark.parametrize("seed", range(4))
def test_every_family(family: str, seed: int) -> None:
    vertices, triangles = FAMILIES[family](np.random.default_rng(seed))
    assert np.isfinite(vertices).all()
    assert triangles.min() >= 0
    assert triangles.max() < len(vertices)
    assert np.ptp(vertices, axis=0).max() > 0


@pytest.mark.parametrize(
    "part",
    [
        parts.sphere(24),
        parts.torus(1, 0.3),
        parts.box(1, 2, 3),
        parts.box(1, 2, 3, 0.1),
        parts.cylinder(1, 2),
        parts.extrude(parts.round_outline(12), parts.round_outline(12) * 0.5, 0.3),
        parts.isosurface(sum(axis**2 for axis in parts.lattice(20)) - 0.5),  # type: ignore[arg-type]
        parts.isosurface(sum(abs(axis) for axis in parts.lattice(16)) - 0.8),  # type: ignore[arg-type]
        parts.bitmap(np.eye(3, dtype=bool)[[0, 0, 1]], 1, 1),
    ],
    ids=["sphere", "torus", "box", "bevelled", "cylinder", "tube", "ball", "octahedron", "bitmap"],
)
def test_parts_are_closed_and_face_outwards(part: parts.Part) -> None:
    vertices, triangles = part
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    area = np.cross(b - a, c - a)
    np.testing.assert_allclose(area.sum(0), 0, atol=1e-9)  # closed
    assert (a * area).sum() / 6 > 0.1  # volume
