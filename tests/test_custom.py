"""Custom shapes and operations, written as functions of points."""

from __future__ import annotations

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.sdf import SDF2, SDF3, X, box, circle, ease, op2, op3, op23, op32, rectangle, sdf2, sdf3, sphere

pytestmark = pytest.mark.usefixtures("no_methods_are_left")

SPACE = np.random.default_rng(3).uniform(-2, 2, (300, 3))
PLANE = SPACE[:, :2].copy()


def agree(shape, expected, points=SPACE) -> None:
    np.testing.assert_allclose(shape(points), np.reshape(expected, (-1, 1)), 1e-12, 1e-13)


def test_shapes_in_space() -> None:
    def rounded(radius=1.0, *, corner=0.2):
        """A ball of another norm."""

        def f(p):
            return np.sum(np.abs(p) ** 4, axis=1) ** 0.25 - radius - corner

        return f

    made = sdf3(rounded)
    assert isinstance(made(), SDF3)
    assert (made.__name__, made.__doc__) == ("rounded", "A ball of another norm.")
    agree(made(0.5), rounded(0.5)(SPACE))
    agree(made(corner=0), rounded(corner=0)(SPACE))
    # The language's operations work on custom shapes too.
    agree(made().translate(X) | sphere(), np.minimum(rounded()(SPACE - X), np.linalg.norm(SPACE, axis=1) - 1))


def test_shapes_in_the_plane() -> None:
    @sdf2
    def heart(size=1.0):
        def f(p):
            x, y = np.abs(p[:, 0]) / size, p[:, 1] / size
            return (x * x + y * y - 1) ** 3 - x * x * y**3

        return f

    x, y = PLANE.T / 1.5
    assert isinstance(heart(), SDF2)
    agree(heart(1.5), (x * x + y * y - 1) ** 3 - x * x * y**3, PLANE)
    assert isinstance(heart().extrude(1), SDF3)


def test_operations_in_space_are_functions_and_methods() -> None:
    @op3
    def wavy(other, height=0.1, frequency=5):
        def f(p):
            return other(p) + height * np.sin(frequency * p[:, [2]])

        return f

    expected = np.linalg.norm(SPACE, axis=1) - 1 + 0.3 * np.sin(5 * SPACE[:, 2])
    agree(wavy(sphere(), 0.3), expected)
    agree(sphere().wavy(height=0.3), expected)
    agree(bob.implicit(lambda x, y, z: np.sqrt(x * x + y * y + z * z) - 1).wavy(0.3), expected)
    assert not hasattr(SDF2, "wavy")


def test_operations_that_move_points() -> None:
    @op3
    def swirled(other, k):
        def f(p):
            x, y, z = p[:, 0], p[:, 1], p[:, 2]
            c, s = np.cos(k * z), np.sin(k * z)
            return other(np.stack([c * x - s * y, s * x + c * y, z], axis=-1))

        return f

    agree(box((1, 2, 3)).swirled(0.7), box((1, 2, 3)).twist(0.7)(SPACE))


def test_operations_in_the_plane() -> None:
    @op2
    def thick(other, by):
        return lambda p: np.abs(other(p)) - by

    agree(circle(1).thick(0.1), np.abs(np.linalg.norm(PLANE, axis=1) - 1) - 0.1, PLANE)


def test_operations_between_the_plane_and_space() -> None:
    @op23
    def pulled(other, h):
        def f(p):
            d = other(p[:, [0, 1]])
            w = np.concatenate([d.reshape(-1, 1), np.abs(p[:, 2]).reshape(-1, 1) - h / 2], axis=1)
            return np.minimum(np.maximum(w[:, 0], w[:, 1]), 0) + np.linalg.norm(np.maximum(w, 0), axis=1)

        return f

    @op32
    def cut(other, z=0.0):
        return lambda p: other(np.concatenate([p, np.full((len(p), 1), z)], axis=1))

    assert isinstance(rectangle(1).pulled(2), SDF3)
    agree(rectangle(1).pulled(2), rectangle(1).extrude(2)(SPACE))
    assert isinstance(sphere().cut(), SDF2)
    agree(sphere().cut(0.5), np.linalg.norm(np.c_[PLANE, np.full(len(PLANE), 0.5)], axis=1) - 1, PLANE)


def test_easings_and_shapes_mix_with_symbols() -> None:
    @op3
    def tapered(other, e):
        return lambda p: other(p * (1 + e(np.clip(p[:, [2]], 0, 1))))

    scale = 1 + ease.in_out_quad(np.clip(SPACE[:, [2]], 0, 1))
    agree(sphere().tapered(ease.in_out_quad), np.linalg.norm(SPACE * scale, axis=1) - 1)


def test_shapes_can_be_made_of_other_shapes() -> None:
    @op3
    def doubled(other):
        return other | other.translate(X)

    agree(sphere().doubled(), (sphere() | sphere().translate(X))(SPACE))


def test_mistakes_are_named_after_the_word() -> None:
    @sdf3
    def broken():
        return lambda p: p[:, 0] if p[0, 0] > 0 else p[:, 1]

    with pytest.raises(bob.InputError, match=r"^broken: a condition on symbols has no truth value"):
        broken()

    @sdf3
    def forgotten():
        pass

    with pytest.raises(bob.InputError, match=r"^forgotten: expected a function, got NoneType"):
        forgotten()
