"""Formulas as people have them: some jump, and some are turned by angles that depend on the point."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.sdf import SDF3, d3

CASES = Path(__file__).parent / "cases"


def test_a_pyramid_from_below() -> None:
    """Its base is where its formula jumps: flat, of one gray, and with sharp edges in a mesh."""
    scene = bob.load(CASES / "jumps/pyramid.sdf")
    frame = bob.trace(scene, bob.Camera(elevation=-35), size=(120, 160))
    assert len(np.unique(frame.gray.round(4))) == 4  # of the background, the base and two faces
    mesh = scene.mesh(0.02)
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(1 + np.sqrt(5), abs=1e-3)


@pytest.mark.parametrize(("name", "radius", "height"), [("bend", 2.03, 0.3), ("twist", 1.52, 4)])
def test_turns_keep_distances_from_the_axis(name: str, radius: float, height: float) -> None:
    (low, high) = bob.load(CASES / f"unbounded-or-not/{name}.sdf").boxes[0]
    assert np.allclose([-low[2], high[2]], height, rtol=0.03)
    assert (np.abs([low[:2], high[:2]]) < 1.05 * radius).all()
    corners = np.array([[x, y] for x in (low[0], high[0]) for y in (low[1], high[1])])
    assert np.hypot(*corners.T).max() > 0.9 * radius


@pytest.mark.parametrize(
    "shape",
    [
        d3.capsule((-3, 0, 0), (3, 0, 0), 0.2).bend(1),
        d3.box((0.4, 3, 8)).twist(20).translate((5, 0, 0)).rotate(1, (1, 1, 0)),
        d3.box((4, 0.6, 0.6)).twist(2.5).bend(0.7) | d3.box(1),
    ],
)
def test_turned_shapes_have_bounds(shape: SDF3) -> None:
    low, high = bob.Scene(shape).boxes[0]
    points = np.random.default_rng(3).uniform(1.5 * low - 0.5 * high, 1.5 * high - 0.5 * low, (100_000, 3))
    inside = points[np.asarray(shape(points)).ravel() <= 0]
    assert len(inside)
    assert ((inside >= low) & (inside <= high)).all()


def test_what_has_no_end_is_refused() -> None:
    with pytest.raises(bob.InputError, match="may reach beyond 1e9 from the origin"):
        bob.Scene(d3.slab(z0=0, z1=1).bend(1))
