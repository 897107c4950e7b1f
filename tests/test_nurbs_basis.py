"""The core's NURBS functions compared with geomdl, and properties of basis functions."""

from __future__ import annotations

import numpy as np
import pytest
from geomdl import NURBS, helpers
from hypothesis import given, settings
from hypothesis import strategies as st

from bobrossnet import _core

degrees = st.integers(1, 9)
seeds = st.integers(0, 2**32 - 1)


@st.composite
def knot_vectors(draw, degree):
    """Draw knots of any range, clamped or not, with inner multiplicities up to the degree."""
    ends = draw(st.sampled_from(["clamped", "unclamped"]))
    before, after = ([degree + 1], [degree + 1]) if ends == "clamped" else ([1] * (degree + 1), [1] * (degree + 1))
    multiplicities = before + draw(st.lists(st.integers(1, degree), max_size=4)) + after
    gaps = draw(st.lists(st.floats(0.1, 1), min_size=len(multiplicities), max_size=len(multiplicities)))
    low, size = draw(st.sampled_from([(0, 1), (-86.9, 100), (1e6, 1e3), (0, 1e-3)]))
    return np.repeat(low + size * np.cumsum(gaps), multiplicities)


def inside(knots, degree, random, count):
    """Return parameters of the domain, including its ends."""
    low, high = knots[degree], knots[-degree - 1]
    return np.concatenate([[low, high], random.uniform(low, high, count)])


@settings(deadline=None, max_examples=150)
@given(st.data(), degrees, seeds)
def test_basis_functions(data, degree, seed):
    knots = data.draw(knot_vectors(degree))
    u = inside(knots, degree, np.random.default_rng(seed), 5)
    order = degree + 2
    spans, values = _core.basis_derivatives(degree, knots, u, order)
    assert spans.dtype == np.int64
    assert values.shape == (len(u), order + 1, degree + 1)
    assert ((knots[spans] <= u) & (u <= knots[spans + 1]) & (knots[spans] < knots[spans + 1])).all()

    sizes = np.abs(values).sum(2)
    assert (values[:, 0] >= 0).all()
    np.testing.assert_allclose(values[:, 0].sum(1), 1, rtol=0, atol=1e-13)
    assert (np.abs(values[:, 1:].sum(2)) <= 1e-13 * sizes[:, 1:]).all()
    assert not values[:, degree + 1 :].any()

    for k, span in enumerate(spans):
        expected = helpers.basis_function_ders(degree, knots.tolist(), int(span), u[k], degree)
        assert (np.abs(values[k, : degree + 1] - expected) <= 1e-9 * sizes[k, : degree + 1, None]).all()


@pytest.mark.parametrize("gap", [1e-290, 1e-305, 1e-320])
def test_basis_functions_of_knots_that_all_but_meet(gap):
    knots = np.array([0, 0, 0, 0, gap, 2 * gap, 3 * gap, 1, 1, 1, 1])
    _, values = _core.basis_derivatives(3, knots, np.array([0, 0.5 * gap, 1.5 * gap, 0.5]), 0)
    np.testing.assert_allclose(values[:, 0].sum(1), 1, rtol=0, atol=1e-13)


@settings(deadline=None, max_examples=60)
@given(st.data(), st.integers(1, 5), st.integers(1, 5), st.integers(0, 3), seeds)
def test_surfaces(data, degree_u, degree_v, order, seed):
    knots_u, knots_v = data.draw(knot_vectors(degree_u)), data.draw(knot_vectors(degree_v))
    random = np.random.default_rng(seed)
    n, m = len(knots_u) - degree_u - 1, len(knots_v) - degree_v - 1
    weights = random.uniform(0.3, 3, (n, m, 1))
    control_points = np.concatenate([weights * random.uniform(-1, 1, (n, m, 3)), weights], axis=2)
    u, v = inside(knots_u, degree_u, random, 3), inside(knots_v, degree_v, random, 3)
    values = _core.surface_derivatives(control_points, knots_u, knots_v, degree_u, degree_v, u, v, order)
    assert values.shape == (len(u), order + 1, order + 1, 3)

    surface = NURBS.Surface(normalize_kv=False)
    surface.degree_u, surface.degree_v = degree_u, degree_v
    surface.set_ctrlpts(control_points.reshape(-1, 4).tolist(), n, m)
    surface.knotvector_u, surface.knotvector_v = knots_u.tolist(), knots_v.tolist()
    known = np.add.outer(np.arange(order + 1), np.arange(order + 1)) <= order
    assert not values[:, ~known].any()
    # Parameters are scaled to a mean span of 1, so that all derivatives of an order have similar size.
    length_u, length_v = np.ptp(knots_u) / (n + degree_u), np.ptp(knots_v) / (m + degree_v)
    scale = length_u ** np.arange(order + 1)[:, None, None] * length_v ** np.arange(order + 1)[:, None]
    # At the domain's end, geomdl uses the empty span after it for unclamped knots.
    for k in np.flatnonzero((u < knots_u[-degree_u - 1]) & (v < knots_v[-degree_v - 1])):
        expected = scale * surface.derivatives(u[k], v[k], order)
        size = max(1.0, np.abs(expected[known]).max())
        np.testing.assert_allclose((scale * values[k])[known], expected[known], rtol=0, atol=1e-9 * size)


def test_many_points_are_computed_alike():
    random = np.random.default_rng(1)
    knots = np.arange(12.0)
    control_points = np.concatenate([random.normal(size=(8, 8, 3)), np.ones((8, 8, 1))], axis=2)
    u, v = random.uniform(3, 8, (2, 3000))
    arguments = (control_points, knots, knots, 3, 3)
    together = _core.surface_derivatives(*arguments, u, v, 2)
    alone = [_core.surface_derivatives(*arguments, u[i : i + 1], v[i : i + 1], 2)[0] for i in range(0, 3000, 100)]
    np.testing.assert_array_equal(together[::100], alone)
    spans, values = _core.basis_derivatives(3, knots, u, 1)
    for i in range(0, 3000, 100):
        span, value = _core.basis_derivatives(3, knots, u[i : i + 1], 1)
        assert span[0] == spans[i]
        np.testing.assert_array_equal(value[0], values[i])


def test_what_would_be_read_out_of_bounds_is_refused():
    knots, u = np.arange(8.0), np.zeros(1)
    for degree in (0, 10):
        with pytest.raises(ValueError, match=r"degree: expected 1..9"):
            _core.basis_derivatives(degree, knots, u, 1)
    for bad in (knots[:7], knots[::-1].copy(), np.full(8, np.nan), np.ones(8)):
        with pytest.raises(ValueError, match="knots: expected"):
            _core.basis_derivatives(3, bad, u, 1)
    control_points = np.ones((4, 4, 4))
    for order in (-1, 101):
        with pytest.raises(ValueError, match=r"order: expected 0..100"):
            _core.basis_derivatives(3, knots, u, order)
        with pytest.raises(ValueError, match=r"order: expected 0..100"):
            _core.surface_derivatives(control_points, knots, knots, 3, 3, u, u, order)
    with pytest.raises(ValueError, match="control_points: expected"):
        _core.surface_derivatives(control_points, knots, np.arange(9.0), 3, 3, u, u, 1)
    with pytest.raises(ValueError, match="v: expected"):
        _core.surface_derivatives(control_points, knots, knots, 3, 3, u, np.zeros(2), 1)
    assert _core.surface_derivatives(control_points, knots, knots, 3, 3, u[:0], u[:0], 1).shape == (0, 2, 2, 3)
