"""Implicit and carved training solids: each family has visible shapes, reproducible from their seeds."""

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.learn.shapes import carved, implicit
from bobrossnet.learn.shapes.copies import around
from bobrossnet.sdf import sphere

FAMILIES = {**implicit.FAMILIES, **carved.FAMILIES}


def scene(name, seed):
    return bob.Scene(FAMILIES[name](np.random.Generator(np.random.Philox(key=[seed, 1]))))


def picture(scene):
    return bob.trace(scene, bob.Camera(azimuth=40, elevation=25), size=(64, 64)).stack()


def test_names_are_unique_and_described():
    assert len(FAMILIES) == len(implicit.FAMILIES) + len(carved.FAMILIES) >= 22
    assert all(family.__doc__ for family in FAMILIES.values())


@pytest.mark.parametrize("name", FAMILIES)
def test_a_family_gives_something_to_see(name):
    shapes = [scene(name, seed) for seed in (0, 1)]
    pictures = [picture(shape) for shape in shapes]
    for shape, pixels in zip(shapes, pictures, strict=True):
        assert np.isfinite(shape.center).all()
        assert 0 < shape.radius < 100
        assert np.isfinite(pixels).all()
        assert 0.02 < (pixels[2] > 0).mean() < 0.95
    assert not np.array_equal(*pictures)
    assert np.array_equal(pictures[0], picture(scene(name, 0)))


@pytest.mark.parametrize("count", [1, 5])
def test_copies_stand_around_the_axis_at_equal_angles(count):
    angles = 2 * np.pi * np.arange(count) / count
    centers = np.stack([2 * np.cos(angles), 2 * np.sin(angles), np.zeros(count)], 1)
    points = np.random.default_rng(0).normal(size=(50, 3))
    nearest = np.linalg.norm(points[:, None] - centers, axis=2).min(1) - 0.3
    assert around(sphere(0.3), count, 2)(points)[:, 0] == pytest.approx(nearest)
