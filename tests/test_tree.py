"""The built-in scene."""

from __future__ import annotations

import time

import numpy as np

from bobrossnet.shapes.tree import happy_tree


def test_it_is_the_same_for_every_call() -> None:
    one, other = happy_tree(), happy_tree()
    assert np.array_equal(one.vertices, other.vertices)
    assert np.array_equal(one.triangles, other.triangles)


def test_it_is_as_large_as_it_says() -> None:
    tree = happy_tree()
    assert 30_000 < len(tree.triangles) < 130_000
    assert np.isfinite(tree.vertices).all()
    assert tree.triangles.min() == 0
    assert tree.triangles.max() == len(tree.vertices) - 1
    low, high = tree.vertices.min(axis=0), tree.vertices.max(axis=0)
    assert 2.0 < high[2] - low[2] < 2.6
    # As wide as high, otherwise it would be small in the square of its bounding sphere.
    assert np.all(high[:2] - low[:2] > 0.8 * (high[2] - low[2]))


def test_every_edge_is_shared_by_two_triangles_that_turn_the_same_way() -> None:
    triangles = happy_tree().triangles.astype(np.int64)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    key = edges[:, 0] << 32 | edges[:, 1]
    back = edges[:, 1] << 32 | edges[:, 0]
    assert len(np.unique(key)) == len(key)
    assert np.array_equal(np.sort(key), np.sort(back))


def test_the_outside_of_every_part_is_outside() -> None:
    tree = happy_tree()
    part = np.arange(len(tree.vertices))  # the smallest vertex connected to a vertex
    while True:
        least = part[tree.triangles].min(axis=1)
        joined = part.copy()
        for corner in range(3):
            np.minimum.at(joined, tree.triangles[:, corner], least)
        joined = joined[joined]
        if np.array_equal(joined, part):
            break
        part = joined
    # Volumes are taken about a point of each part, to avoid cancellation far from the origin.
    owner = part[tree.triangles[:, 0]]
    a, b, c = (tree.vertices[tree.triangles] - tree.vertices[owner, None]).transpose(1, 0, 2)
    six_volumes = np.bincount(owner, np.einsum("ij,ij->i", a, np.cross(b, c)))
    volumes = six_volumes[np.unique(part)] / 6
    assert 400 < len(volumes) < 1000  # most are leaves, each large enough to be visible when completed
    assert volumes.min() > 0


def test_it_is_there_at_once() -> None:
    best = min(_seconds() for _ in range(3))
    assert best < 1.0  # 0.06 s on the development machine


def _seconds() -> float:
    start = time.thread_time()
    happy_tree()
    return time.thread_time() - start
