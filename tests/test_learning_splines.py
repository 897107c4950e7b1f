"""The NURBS families for training."""

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.learn.shapes.splines import FAMILIES, parts


def made(name, seed):
    return bob.Scene(FAMILIES[name](np.random.Generator(np.random.Philox(key=[seed, 5]))))


def digests(scene):
    """Return the visible properties, which determine every picture."""
    return tuple(sorted(instance.digest() for instance in scene.instances))


@pytest.mark.parametrize("name", FAMILIES)
def test_every_family_can_be_seen_and_is_a_function_of_its_seed(name):
    scenes = [made(name, seed) for seed in range(2)]
    for seed, scene in enumerate(scenes):
        assert 0 < scene.radius < np.inf
        seen = bob.trace(scene, bob.Camera(azimuth=40 + 70 * seed, elevation=35), size=(64, 64))
        assert 0.01 < (seen.gray > 0).mean() < 0.95
    assert digests(scenes[0]) != digests(scenes[1])
    assert digests(made(name, 1)) == digests(scenes[1])


def test_the_families_are_of_many_degrees_rational_and_not():
    faces = [
        face
        for name in FAMILIES
        for instance in made(name, 3).instances
        if isinstance(instance.shape, bob.Brep)
        for face in instance.shape.faces
    ]
    assert {degree for face in faces for degree in (face.degree_u, face.degree_v)} >= {1, 2, 3, 4}
    assert {face.weights is None for face in faces} == {True, False}
    assert any(face.trims for face in faces)


def test_balls_and_tori_are_exact():
    rng = np.random.default_rng(0)
    ball, torus = parts.ball(0.7).faces[0], parts.torus(1.0, 0.3).faces[0]
    sphere = ball.points(rng.uniform(0, 2, 50), rng.uniform(0, 4, 50))
    np.testing.assert_allclose(np.linalg.norm(sphere, axis=1), 0.7, rtol=1e-12)
    x, y, z = torus.points(rng.uniform(0, 4, 50), rng.uniform(0, 4, 50)).T
    np.testing.assert_allclose(np.hypot(np.hypot(x, y) - 1, z), 0.3, rtol=1e-12)


@pytest.mark.parametrize("sides", [3, 4, 7])
def test_rounded_corners_are_arcs(sides):
    """Extruded, so that the outline's points are points of a face."""
    cut = 0.2
    outline = parts.rounded(parts.polygon(sides), cut)
    wall = parts.extruded([outline], 1.0).faces[2]
    arc = wall.points(np.linspace(0, 1, 9), 0)[:, :2]  # the first corner, at (1, 0)
    radius = cut * np.tan(np.pi / 2 - np.pi / sides)
    center = np.array([1 - radius / np.sin(np.pi / 2 - np.pi / sides), 0])
    np.testing.assert_allclose(np.linalg.norm(arc - center, axis=1), radius, rtol=1e-9)


def test_extruded_solids_are_closed():
    """Rays from inside a wall of the solid hit it in every direction."""
    solid = parts.extruded([parts.smooth(parts.star(5, 0.4)), parts.circle(0.3)], 0.5)
    directions = np.random.default_rng(1).normal(size=(2000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    hits = bob.Scene(solid).closest_hits(np.broadcast_to([0.45, 0.0, 0.25], directions.shape), directions)
    assert hits.distance.max() < 2


def test_closed_sweeps_meet_without_a_seam():
    angle = np.arange(12) * np.pi / 6
    path = np.stack([np.cos(angle), np.sin(angle), 0.3 * np.sin(2 * angle)], axis=1)
    face = parts.swept(parts.polygon(6) * 0.2, path, closed=True)
    (u0, u1), (v0, v1) = face.domain
    v = np.linspace(v0, v1, 20)
    np.testing.assert_allclose(face.points(u0, v), face.points(u1, v), atol=1e-12)
    np.testing.assert_allclose(face.normals(u0, v), face.normals(u1, v), atol=1e-9)


def test_pipes_go_straight_between_their_bends():
    corners = np.array([(0, 0, 0), (0, 0, 2), (3, 0, 2), (3, 2, 2)])
    tube = parts.pipe(corners, 0.1, 0.5)
    hits = bob.Scene(tube).closest_hits([(1.5, 5, 2), (0, 5, 1), (0, 5, 2)], [(0, -1, 0)] * 3)
    np.testing.assert_allclose(hits.distance[:2], 4.9, rtol=1e-5)
    assert np.isinf(hits.distance[2])  # the corner itself is cut off
