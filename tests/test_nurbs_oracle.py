"""Degenerate NURBS faces, compared with points in double precision: `python tests/nurbs_oracle.py` traces more."""

import numpy as np
import pytest
from nurbs_oracle import KINDS, Surface, examine, repeated, unit

import bobrossnet as bob

SEEDS = {
    "flat, rays within": [2, 8, 17],
    "ruled, rays along": [0, 11],
    "weights within 1e3": [7, 20],
    "weights within 1e5": [2, 11, 20],
    "weights within 1e8": [2, 14, 36, 38],
    "knots 1e-6 apart": [14],
}
"""Seeds of faces that are hard to hit; of other kinds, any."""


@pytest.mark.parametrize("kind", KINDS)
def test_hits_lie_on_awkward_faces_and_no_ray_passes(kind):
    report = examine(kind, SEEDS.get(kind, range(2)), 300)
    assert report.hits > 0.5 * report.rays > 0
    assert report.off == 0
    assert report.missed == 0


def test_no_ray_passes_a_strip():
    face = KINDS["knots 1e-6 apart"][0](np.random.default_rng(97))
    scene, surface = bob.Scene(bob.Brep([face])), Surface(face)
    rng = np.random.default_rng(0)
    places = np.column_stack([np.zeros(2000), np.ones(2000), rng.uniform(0.39, 0.41, 2000), rng.uniform(size=2000)])
    target, along, across = surface.jets(places)
    assert np.linalg.norm(across, axis=1).max() < 1e-5 * scene.radius
    direction = unit(np.cross(along, across)) + 0.5 * unit(rng.normal(size=(2000, 3)))
    origin = target - 3 * scene.radius * direction
    assert (scene.closest_hits(origin, direction).instance >= 0).all()


def test_the_oracle_evaluates_as_the_core_does():
    rng = np.random.default_rng(1)
    face = KINDS["weights within 1e3"][0](rng)
    u, v = rng.random((2, 100))
    surface = Surface(face)
    np.testing.assert_allclose(surface.jets(surface.places(u, v))[0], face.points(u, v), atol=1e-12)


def test_a_face_without_area_but_for_rounding_is_not_there():
    face = repeated(np.random.default_rng((0, 173)))  # all of it on a line
    with pytest.raises(bob.InputError, match="faces: expected at least one face"):
        bob.Scene(bob.Brep([face]))
