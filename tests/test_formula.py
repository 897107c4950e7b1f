"""Formulas: Python functions called with symbols give the values of numpy with numbers."""

from __future__ import annotations

import copy
import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.sdf.symbols import RULES, expression_of, formulas_of_points, substitute

RANDOM = np.random.default_rng(7).uniform(-3, 3, (200, 3))
SPECIAL = np.array([(a, b, c) for a in (0, 1, -1, 2.5) for b in (0, 1, -2, 0.5) for c in (0, -1.5, 3)], np.float64)
POINTS = np.concatenate([RANDOM, SPECIAL])


def quietly(function, *args):
    with np.errstate(all="ignore"):
        return np.asarray(function(*args), np.float64)


def values(expression, points=POINTS):
    return expression(np.ascontiguousarray(points))


def check(function, points=POINTS, rtol=1e-12, atol=1e-14):
    """Check that the formula of a function of x, y and z has the function's values."""
    expected = np.broadcast_to(quietly(function, *points.T), len(points))
    np.testing.assert_allclose(values(expression_of(function, 3), points), expected, rtol, atol)


# ---- Functions of numpy ----------------------------------------------------------------------------------

COMPARISONS = {np.less, np.less_equal, np.greater, np.greater_equal, np.equal, np.not_equal}
OF_CONDITIONS = {np.logical_and, np.bitwise_and, np.logical_or, np.bitwise_or, np.logical_not, np.invert}
POWERS = {np.power, np.float_power}


def applications(ufunc):
    """Yield functions of x, y and z that call the ufunc with symbols, and with a number on either side."""
    if ufunc in OF_CONDITIONS:
        yield lambda x, y, z: np.where(ufunc(*(x > 0.3, y <= 1)[: ufunc.nin]), 1, 0)
    elif ufunc in COMPARISONS:
        yield from (
            lambda x, y, z: ufunc(x, y) * 1.0,
            lambda x, y, z: ufunc(x, 1) * 1.0,
            lambda x, y, z: 1.0 * ufunc(0, y),
        )
    elif ufunc.nin == 1:
        yield lambda x, y, z: ufunc(x)
    else:
        yield from (lambda x, y, z: ufunc(x, y), lambda x, y, z: ufunc(x, 1.5), lambda x, y, z: ufunc(0.7, y))


@pytest.mark.parametrize("ufunc", RULES.keys() - {np.divmod}, ids=lambda ufunc: ufunc.__name__)
def test_every_ufunc_computes_what_it_does_in_numpy(ufunc) -> None:
    # Negative numbers have only integer powers.
    points = POINTS[POINTS[:, 0] > 0] if ufunc in POWERS else POINTS
    for function in applications(ufunc):
        check(function, points)


@pytest.mark.parametrize(
    "ufunc", [np.expm1, np.log1p, np.sinh, np.tanh, np.arcsinh, np.arctanh], ids=lambda ufunc: ufunc.__name__
)
def test_functions_that_are_zero_at_zero_keep_their_digits_there(ufunc) -> None:
    sizes = np.concatenate([np.logspace(-300, 0, 301), np.linspace(0.01, 0.99, 99)])[:, None] * (1 - 1e-9)
    check(lambda x, y, z: ufunc(x), np.concatenate([-sizes, sizes]) * np.ones(3), 1e-13, 0)

    # Floats too: rays hit f(x) = f(c) in a box of half side 1e-5.
    half, c = 1e-5, np.array([0.31, -0.77, 1e-3]) * 1e-5
    rays = np.array([[1.7, 0.1, 0.2], [1.8, -0.6, 0.5]]) * half
    for at in c:
        surface = bob.implicit(lambda x, y, z, at=at: ufunc(x) - float(ufunc(at)), np.outer([-1, 1], 3 * [half]))
        distance = bob.Scene(surface).closest_hits(rays, rays * [-1, 0, 0]).distance
        np.testing.assert_allclose(rays[:, 0] - distance, at, rtol=0, atol=3e-6 * half)


def test_arccosh_keeps_its_digits_near_one() -> None:
    points = (1 + np.logspace(-9, 2, 200))[:, None] * np.ones(3)
    check(lambda x, y, z: np.arccosh(x), points, 1e-13, 0)


FUNCTIONS = {
    "operators": lambda x, y, z: -x + (+y) * z - x / 2 + 3 / (abs(y) + 1) + x**2 - 2 * (1 - z),
    "floor division and remainder": lambda x, y, z: x // 0.7 + y % 1.3 + (-x) % -0.9 + 2.0 // (abs(z) + 1),
    "divmod": lambda x, y, z: np.divmod(x, 0.7)[0] + 10 * np.divmod(y, 0.7)[1],
    "whole powers": lambda x, y, z: x**3 + y**0 + z**1 - x**7 + y**10,
    "negative powers": lambda x, y, z: (x + 5) ** -3 + (y * y + 1) ** -1.0,
    "half powers": lambda x, y, z: abs(x) ** 0.5 + (y * y) ** 1.5 + (z * z + 1) ** -0.5,
    "real powers": lambda x, y, z: abs(x) ** 0.3 + 2.0**y + (z * z + 0.1) ** x,
    "root": lambda x, y, z: np.sqrt(x * x + y * y + z * z) - 1,
    "where": lambda x, y, z: np.where(x > y, x, np.where(z <= 0, y, 3)),
    "where of a number": lambda x, y, z: np.where(np.floor(x), y, z),
    "conditions joined": lambda x, y, z: np.where((x > 0) & ~(y >= 1) | (z < -1), x, y),
    "equal": lambda x, y, z: np.where(x == 1, y, 0) + np.where(y != 1, z, 0),
    "conditions as numbers": lambda x, y, z: (x > 0) * 5 + (y <= 0) - 2.0 * (z == 0),
    "select": lambda x, y, z: np.select([x > 1, y > 1], [x, y * 2], z),
    "select without default": lambda x, y, z: np.select([x > 1, y > 1], [x, y * 2]),
    "clip": lambda x, y, z: np.clip(x, -1, y) + np.clip(z, None, 0.5) + np.clip(y, -1, None),
    "round": lambda x, y, z: np.round(x) + np.round(y, 1) + np.rint(z) + np.fix(x),
    "sums": lambda x, y, z: np.sum([x, y, z], axis=0) + np.mean([x, z], axis=0) + np.prod([x, y], axis=0),
    "extremes": lambda x, y, z: np.max(np.stack([x, y, z]), axis=0) - np.min(np.stack([x, y]), axis=0),
    "norm": lambda x, y, z: np.linalg.norm([x, y, z], axis=0),
    "norms of other orders": lambda x, y, z: sum(
        np.linalg.norm(np.stack([x, y, z]), order, axis=0) for order in (1, np.inf, -np.inf, 3)
    ),
    "stack": lambda x, y, z: np.sum(np.abs(np.stack([x, y, z])) * np.stack([x, x, y]), axis=0),
    "array of symbols": lambda x, y, z: np.linalg.norm(np.sin(np.array([x, y, z])), axis=0),
    "polynomial": lambda x, y, z: np.polyval([1, -2, 3], x) + np.polyval([2, 0.5], y),
    "dot": lambda x, y, z: np.dot([1.0, 2.0, -1.0], np.stack([x, y, z])),
    "numpy's numbers": lambda x, y, z: np.float32(0.5) * x + y * np.int8(3) - np.float64(2) / (z * z + 1) + np.pi,
    "loop": lambda x, y, z: sum(math.sin(i) * np.cos(i * x) / (i + 1) for i in range(20)) + y,
    "no symbols": lambda x, y, z: 2.5,
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_compute_what_they_do_in_numpy(name) -> None:
    check(FUNCTIONS[name], rtol=1e-11 if "power" in name else 1e-12)


def test_python_rounds_symbols_too() -> None:
    function = lambda x, y, z: round(x) + round(y, 1) + math.floor(z) * math.ceil(x) + math.trunc(y)  # noqa: E731
    expected = [function(*map(float, point)) for point in POINTS]
    np.testing.assert_allclose(values(expression_of(function, 3)), expected, 1e-12)


def test_x_y_and_z_are_in_this_order() -> None:
    for arity in (1, 2, 3):
        f = expression_of(lambda *symbols: sum(10**i * symbol for i, symbol in enumerate(symbols)), arity)
        assert values(f, np.array([[1.0, 2, 3]])) == sum((i + 1) * 10**i for i in range(arity))


def test_nothing_and_something_infinite() -> None:
    def special(function, x):
        return values(expression_of(function, 1), np.array([[x, 0.0, 0.0]]))[0]

    assert special(lambda x: 1 / x, 0) == np.inf
    assert special(np.log, 0) == -np.inf
    assert special(lambda x: np.minimum(1 / x, 3), 0) == 3
    assert special(lambda x: np.tanh(x * 1e6), -1) == -1
    for function in (np.sqrt, np.log, lambda x: np.minimum(np.sqrt(x), 0), lambda x: np.sqrt(x) * 0):
        assert np.isnan(special(function, -1))
    # A choice is NaN only if the chosen side is, like numpy's.
    assert special(lambda x: np.where(x > 0, np.sqrt(x), 0), -1) == 0
    assert np.isnan(special(lambda x: np.where(x < 0, np.sqrt(x), 0), -1))


# ---- Random formulas -------------------------------------------------------------------------------------

LEAVES = st.sampled_from("xyz") | st.integers(-4, 4).map(float) | st.integers(-4000, 4000).map(lambda n: n / 1000)
ONE = {
    f.__name__: f
    for f in (np.negative, np.abs, np.square, np.sqrt, np.sin, np.cos, np.arctan, np.exp, np.log, np.floor)
    + (np.sign, np.cbrt, np.rint)
} | {f"power {n}": (lambda a, n=n: a**n) for n in (-3, -1, 1, 2, 3, 5)}
TWO = {
    f.__name__: f for f in (np.add, np.subtract, np.multiply, np.divide, np.minimum, np.maximum, np.hypot, np.mod)
} | {"angle": lambda a, b: np.arctan2(a, 1 + abs(b))}  # off the branch cut, where the sign of zero decides
FOUR = {
    "less": lambda a, b, c, d: np.where(a < b, c, d),
    "at least": lambda a, b, c, d: np.where(a >= b, c, d),
    "either": lambda a, b, c, d: np.where((a > b) | (c <= d), a, d),
}
OPS = ONE | TWO | FOUR
TREES = st.recursive(
    LEAVES,
    lambda tree: (
        st.tuples(st.sampled_from(sorted(ONE)), tree)
        | st.tuples(st.sampled_from(sorted(TWO)), tree, tree)
        | st.tuples(st.sampled_from(sorted(FOUR)), tree, tree, tree, tree)
    ),
    max_leaves=25,
)


def compute(tree, variables, after=lambda value: value):
    if isinstance(tree, tuple):
        name, *operands = tree
        return after(OPS[name](*(compute(operand, variables, after) for operand in operands)))
    return variables[tree] if isinstance(tree, str) else variables["number"](tree)


@given(TREES, st.integers(0, 1000))
@settings(deadline=None, max_examples=300)
def test_random_formulas_compute_what_numpy_does(tree, seed) -> None:
    # Each step is perturbed slightly, several times: where the result changes, rounding decides, and nothing is
    # compared. The same holds for overflows, which simplified formulas have elsewhere.
    random = np.random.default_rng(seed)
    usual = np.ones(len(POINTS), bool)

    def disturbed(value, by=1e-14):
        nonlocal usual
        usual = usual & ~(np.abs(value) > 1e60)
        return value * (1 + random.uniform(-by, by, np.shape(value) or len(POINTS)))

    variables = {"number": np.float64, **dict(zip("xyz", POINTS.T, strict=True))}
    # NaN of numpy's where comes from the chosen side; elsewhere it propagates as here.
    expected = np.broadcast_to(quietly(compute, tree, variables, lambda value: disturbed(value, 0)), len(POINTS))
    others = np.stack([np.broadcast_to(quietly(compute, tree, variables, disturbed), len(POINTS)) for _ in range(24)])

    def function(x, y, z):
        number = lambda value: type(x)(x.graph, x.graph.constant(value))  # noqa: E731  # so that the core folds them
        return compute(tree, {"number": number, "x": x, "y": y, "z": z})

    f = expression_of(function, 3)
    got = values(f)
    with np.errstate(all="ignore"):
        spread = np.abs(others - expected).max(axis=0)
        usual &= spread <= 1e-10 * np.abs(expected)
        wrong = usual & ~np.isnan(got) & (np.abs(got - expected) > 10 * spread + 1e-12 * np.abs(expected))
    assert not wrong.any(), (str(f), POINTS[wrong][0], got[wrong][0], expected[wrong][0])
    if not any(name in str(tree) for name in FOUR):
        assert np.array_equal(np.isnan(got[usual]), np.isnan(expected[usual]))


# ---- Stored formulas -------------------------------------------------------------------------------------


def ops(function, arity=3):
    expression = expression_of(function, arity)
    names = ["constant", "exp", "log", "sqrt", "power", "square", "select"]
    return len(expression), {name for name in names if expression.uses(name)}


def test_what_occurs_twice_is_stored_once() -> None:
    def chain(x, y, z):
        for _ in range(100):
            x = np.sin(x + y) * np.sin(x + y)
        return x

    assert ops(chain) == (2 + 3 * 100, {"square"})
    assert ops(lambda x, y, z: np.sin(x + 1) + np.sin(x + 1.0) * y)[0] == 7
    # Conditions leave no unused nodes.
    assert ops(lambda x, y, z: np.where(x - y < 0, x, y)) == (4, {"select"})
    assert ops(lambda x, y, z: np.where(x - y >= 0, x, y)) == (4, {"select"})


def test_whole_and_half_powers_need_no_exp() -> None:
    assert ops(lambda x, y, z: x**5 + y**2.0 - z ** np.int64(7)) == (8, {"power", "square"})
    assert "exp" not in ops(lambda x, y, z: x**0.5 + y**-1.5)[1]
    assert "exp" in ops(lambda x, y, z: x**0.4)[1]


def test_lengths_are_one_step_for_each_coordinate() -> None:
    f = expression_of(lambda x, y, z: np.sqrt(x * x + y * y + z * z), 3)
    assert (len(f), f.uses("hypot"), f.uses("sqrt")) == (5, True, False)
    assert f == expression_of(lambda x, y, z: np.linalg.norm([x, y, z]), 3)


def test_expressions_are_values() -> None:
    f = expression_of(lambda x, y, z: np.where(x > 0, x**3, np.hypot(y, 2)) - z, 3)
    for other in (
        _core.Expression(f.ops, f.operands, f.values),
        pickle.loads(pickle.dumps(f)),
        copy.deepcopy(f),
        expression_of(lambda x, y, z: np.where(x > 0, x**3, np.hypot(y, 2)) - z, 3),
    ):
        assert other == f
        assert hash(other) == hash(f)
        assert np.array_equal(values(other), values(f))
    assert f != expression_of(lambda x, y, z: x, 3)
    assert f != str(f)
    assert (f.ops.dtype, f.operands.dtype, f.values.dtype) == (np.uint8, np.uint32, np.float64)
    assert (f.ops.shape, f.operands.shape, f.values.shape) == ((len(f),), (len(f), 3), (len(f),))
    f.values[:] = 7  # a copy
    assert np.array_equal(values(f), values(pickle.loads(pickle.dumps(f))))


def test_arrays_that_are_no_formula_are_refused() -> None:
    f = expression_of(lambda x, y, z: x**3 + 2, 3)
    for ops, operands, numbers, message in (
        (f.ops + 200, f.operands, f.values, "unknown"),
        (f.ops, f.operands + 1000, f.values, "come before"),
        (f.ops, f.operands, f.values + 0.5, "whole exponent"),
        (f.ops[:1] * 0, f.operands[:1], f.values[:1] * np.nan, "NaN"),
        (f.ops[:0], f.operands[:0], f.values[:0], "at least one"),
        (f.ops, f.operands, f.values[:-1], "one length"),
    ):
        with pytest.raises(ValueError, match=message):
            _core.Expression(np.asarray(ops, np.uint8), np.asarray(operands, np.uint32), numbers)


def test_values_of_another_graph_are_refused() -> None:
    graph, other = _core.Graph(), _core.Graph()
    other.x()
    for handle in (other.x(), 0, graph.x() + 1, 2**64 - 1):
        with pytest.raises(ValueError, match="a value of this graph"):
            graph.unary("sin", handle)
    with pytest.raises(ValueError, match="number of operands"):
        graph.unary("add", graph.x())
    with pytest.raises(ValueError, match="'sine'"):
        graph.unary("sine", graph.x())


@pytest.mark.parametrize(
    ("function", "text"),
    [
        (lambda x, y, z: x**2 + np.sin(y) - 0.5, "x**2 + sin(y) - 0.5"),
        (lambda x, y, z: (x - (y - z)) * -y, "(x - (y - z)) * -y"),
        (lambda x, y, z: (x - y - z) / (y / z), "(x - y - z) / (y / z)"),
        (lambda x, y, z: (-x) ** 3 + np.where(x < 0, 1, y % 3), "(-x)**3 + where(x < 0, 1, y % 3)"),
        (lambda x, y, z: np.hypot(x, y) + z * -2, "hypot(x, y) + z * -2"),
        (lambda x, y, z: -2.5, "-2.5"),
    ],
)
def test_formulas_can_be_read(function, text) -> None:
    assert str(expression_of(function, 3)) == text


def test_what_is_too_long_to_be_read_is_cut() -> None:
    def grown(x, y, z):
        for i in range(3000):
            x, y = np.sin(x + y) - i, x * y
        return x

    text = str(expression_of(grown, 3))
    assert len(text) == 200
    assert text.endswith("...")


# ---- Errors ----------------------------------------------------------------------------------------------

TRUTH = "a condition on symbols has no truth value while the formula is traced: use np.where"


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda x, y, z: x if x > 0 else y, TRUTH),
        (lambda x, y, z: x if x else y, TRUTH),
        (lambda x, y, z: x and y, TRUTH),
        (lambda x, y, z: -1 < x < 1, TRUTH),
        (lambda x, y, z: min(x, y), r"np.minimum\(x, y\) for min\(x, y\)"),
        (lambda x, y, z: np.maximum(np.array([x, y]), 0), r"np.stack\(\[x, y\]\) for lists and arrays"),
        (lambda x, y, z: np.sort(np.stack([x, y]))[0], TRUTH),
        (lambda x, y, z: math.sin(x), "np.sin for math.sin"),
        (lambda x, y, z: int(x), "no value"),
        (lambda x, y, z: np.full(3, 0.5)[x], "IndexError"),
        (lambda x, y, z: np.stack([x, y])[np.stack([x, y]) > 0], "can't be an index"),
        (lambda x, y, z: np.isnan(x), "np.isnan: not a function of formulas"),
        (lambda x, y, z: x**1001, "exponent: expected a whole number in ±1000, got 1001"),
        (lambda x, y, z: x * math.nan, "expected numbers in a formula, got NaN"),
        (lambda x, y, z: x + "1", "expected symbols and numbers in a formula, got str"),
        (lambda x, y, z: x + 1j, "expected symbols and numbers in a formula, got complex"),
        (lambda x, y, z: None, "returns a symbol or a number, got NoneType"),
        (lambda x, y, z: [x, y], "returns a symbol or a number, got list"),
        (lambda x, y, z: np.stack([x, y]), r"returns a symbol or a number, got an array of shape \(2,\)"),
        (lambda x, y, z: x > 0, "returns a symbol or a number, got a condition"),
        (lambda x, y: x, "expected a formula, got TypeError: .* takes 2 positional arguments"),
        (lambda x, y, z: 1 / 0, "expected a formula, got ZeroDivisionError: division by zero"),
        (lambda x, y, z: x.real, "expected a formula, got AttributeError"),
        (lambda x, y, z: next(iter([])), "expected a formula, got StopIteration"),
        ("x + y", "expected a function, got str"),
    ],
)
def test_what_is_no_formula_is_refused_in_one_line(function, message) -> None:
    with pytest.raises(bob.InputError, match=f"^function: .*{message}") as caught:
        expression_of(function, 3)
    assert "\n" not in str(caught.value)


def test_the_first_symbols_are_of_no_use_to_the_next_formula() -> None:
    kept = []
    expression_of(lambda x: kept.append(x) or x, 1)
    with pytest.raises(bob.InputError, match="a value of this graph"):
        expression_of(lambda x: x + kept[0], 1)


def test_formulas_have_a_limit() -> None:
    def endless(x):
        while True:
            x = np.sin(x)

    with pytest.raises(bob.InputError, match=r"^function: expected a formula of at most 1048576 steps, got more"):
        expression_of(endless, 1)


# ---- Functions of points ---------------------------------------------------------------------------------


def length(p):
    return np.linalg.norm(p, axis=1)


def box(p, size=(1, 2, 0.5)):
    q = np.abs(p) - np.array(size) / 2
    return length(np.maximum(q, 0)) + np.minimum(np.amax(q, axis=1), 0)


def capsule(p):
    a, b = np.array([[-1.0, 0, 0.5], [0.5, 1, 1]])
    along = np.clip(np.dot(p - a, b - a) / np.dot(b - a, b - a), 0, 1).reshape((-1, 1))
    return length(p - a - np.multiply(along, b - a)) - 0.25


def wedge(p):
    """A convex polygon in x and y with the signs of its corners, as in even-odd tests."""
    corners = np.array([[0.0, 0], [2, 0.3], [1, 2]])
    squared = np.sum((p[:, :2] - corners[0]) ** 2, axis=1)
    sign = np.ones(len(p))
    for i, a in enumerate(corners):
        b = corners[i - 1]
        edge, w = b - a, p[:, :2] - a
        nearest = w - edge * np.clip(np.dot(w, edge) / np.dot(edge, edge), 0, 1).reshape((-1, 1))
        squared = np.minimum(squared, np.sum(nearest * nearest, axis=1))
        c = np.stack([p[:, 1] >= a[1], p[:, 1] < b[1], edge[0] * w[:, 1] > edge[1] * w[:, 0]], axis=-1)
        sign = np.where(np.all(c, axis=1) | np.all(~c, axis=1), -sign, sign)
    return sign * np.sqrt(squared)


def assigned(p):
    q = p.copy()
    q[:, 2] = 0
    q[:, [0, 1]] = np.abs(q[:, [1, 0]])
    q -= 0.5
    return np.concatenate([q, p], axis=1).sum(axis=1)


PRIMITIVES = {
    "sphere": lambda p: length(p - np.array([0.5, 0, 1])) - 1,
    "box": box,
    "capsule": capsule,
    "wedge": wedge,
    "assigned": assigned,
    "torus": lambda p: np.hypot(length(p[:, [0, 1]]) - 1, p[:, 2]) - 0.3,
    "columns": lambda p: (p[:, [0]] ** 2 + p[:, 1:2] * 2 - p[:, -1].reshape((-1, 1))),
    "rotated": lambda p: box(np.dot(p, np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]]))),
    "matrix product": lambda p: box(p @ np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]])),
    "einsum": lambda p: np.einsum("ij,ij->i", p, np.cross(p, np.array([1.0, 2, 3])) + 1),
    "zeros and ones": lambda p: length(np.maximum(p, np.zeros_like(p)) + np.ones_like(p)) + np.zeros(len(p)),
    "where": lambda p: np.where(p[:, 0] > 0, length(p), np.abs(p).max(axis=1)),
    "where of rows": lambda p: length(np.where(p > 0.5, p * 2, -p)),
    "repeated": lambda p: box(p - np.array([2, 3, 0]) * np.rint(
        np.divide(p, (2, 3, 0), out=np.zeros_like(p), where=np.array([2, 3, 0]) != 0)
    )),
    "twisted": lambda p: box(np.stack([
        np.cos(p[:, 2]) * p[:, 0] - np.sin(p[:, 2]) * p[:, 1],
        np.sin(p[:, 2]) * p[:, 0] + np.cos(p[:, 2]) * p[:, 1],
        p[:, 2],
    ], axis=-1)),
    "reduced": lambda p: np.maximum.reduce(np.abs((p - 1).T)),
    "transposed": lambda p: sum(x * i for i, x in enumerate(np.transpose(p))),
    "mean and products": lambda p: p.mean(axis=1) + p.prod(axis=1) + np.sum(p[:, None, :] * p[:, :, None], axis=(1, 2)),
    "kept axes": lambda p: p.sum(axis=1, keepdims=True) + np.linalg.norm(p, np.inf, axis=1, keepdims=True),
}  # fmt: skip


@pytest.mark.parametrize("name", PRIMITIVES)
def test_functions_of_points_compute_what_they_do_in_numpy(name) -> None:
    f, _ = formulas_of_points(PRIMITIVES[name], 3)
    np.testing.assert_allclose(values(f), np.ravel(PRIMITIVES[name](POINTS)), 1e-12, 1e-13)


def test_functions_of_points_of_the_plane() -> None:
    f, _ = formulas_of_points(lambda p: length(p - np.array([1, 0])) - p.shape[1], 2)
    np.testing.assert_allclose(values(f), np.hypot(POINTS[:, 0] - 1, POINTS[:, 1]) - 2, 1e-12, 1e-13)


OPERATIONS = {
    "dilated": lambda other: lambda p: other(p) - 0.2,
    "translated": lambda other: lambda p: other(p - (0.5, 1, 0)),
    "scaled": lambda other: lambda p: other(p / (1, 2, 3)) * 1,
    "shell": lambda other: lambda p: np.abs(other(p)) - 0.1,
    "elongated": lambda other: lambda p: other(
        np.maximum(np.abs(p) - 0.3, 0) * np.sign(p)
    ) + np.minimum(np.amax(np.abs(p) - 0.3, axis=1), 0).reshape((-1, 1)),
    "circled": lambda other: lambda p: other(
        np.stack([np.hypot(p[:, 0], p[:, 1]), np.arctan2(p[:, 1], p[:, 0]), p[:, 2]], axis=-1)
    ).reshape(-1),
    "united": lambda other: lambda p: np.minimum(other(p), other(p + 1)).reshape((-1, 1)),
    "at a point": lambda other: lambda p: other(np.zeros_like(p)) + other(p),
}  # fmt: skip


@pytest.mark.parametrize("name", OPERATIONS)
def test_operations_on_formulas_compute_what_they_do_in_numpy(name) -> None:
    expression, _ = formulas_of_points(box, 3)
    f, _ = formulas_of_points(OPERATIONS[name](lambda p: substitute(expression, p)), 3)
    expected = OPERATIONS[name](lambda p: box(p).reshape((-1, 1)))(POINTS)
    np.testing.assert_allclose(values(f), np.ravel(expected), 1e-12, 1e-13)


def test_flat_formulas_take_points_of_the_plane_and_of_space() -> None:
    flat = expression_of(lambda x, y: x - 2 * y, 2)
    for columns in ([0, 1], [0, 1, 2]):
        f, _ = formulas_of_points(lambda p, columns=columns: substitute(flat, p[:, columns] * 3), 3)
        np.testing.assert_allclose(values(f), 3 * POINTS[:, 0] - 6 * POINTS[:, 1], 1e-12, 1e-13)
    with pytest.raises(bob.InputError, match=r"points: expected shape \(n, 2\) or \(n, 3\), got \(1, 1\)"):
        formulas_of_points(lambda p: substitute(flat, p[:, :1]), 3)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda p: p, r"got an array of shape \(1, 3\)"),
        (lambda p: p[p[:, 0] > 0], "can't be an index"),
        (lambda p: np.interp(p[:, 0], [0, 1], [2, 3]), "got TypeError"),
        (lambda p: np.linalg.norm(p, 1), "is `axis` missing"),
        (lambda p: np.array([float(v) for v in p[:, 0]]), "np.sin for math.sin"),
        (lambda p: np.select([p[:, 0] > 0], [1, 2]), "a choice for each condition, got 2 for 1"),
    ],
)
def test_what_is_no_formula_of_points_is_refused_in_one_line(function, message) -> None:
    with pytest.raises(bob.InputError, match=f"^shape: .*{message}") as caught:
        formulas_of_points(function, 3, "shape")
    assert "\n" not in str(caught.value)


# ---- Implicit surfaces -----------------------------------------------------------------------------------


def test_implicit_surfaces_hold_their_formula_and_box() -> None:
    shape = bob.implicit(lambda x, y, z: x**2 + y**2 + z**2 - 1)
    assert isinstance(shape, bob.Implicit)
    assert str(shape.expression) == "x**2 + y**2 + z**2 - 1"
    assert shape.bounds is None
    shape = bob.implicit(lambda x, y, z: np.sin(x), ((-1, -2, -3), (1, 2, 3)))
    assert shape.expression == expression_of(lambda x, y, z: np.sin(x), 3)
    assert np.array_equal(shape.bounds, [[-1, -2, -3], [1, 2, 3]])
    shape = bob.Implicit(shape.expression, shape.bounds)
    assert repr(shape) == "Implicit(sin(x), bounds=[[-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]])"


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        (3, r"^bounds: expected shape \(2, 3\), got \(\)"),
        (((0, 0, 0), (1, 1, math.inf)), "^bounds: expected finite numbers"),
        (((0, 0, 0), (1, 1, 0)), "^bounds: expected each low below its high"),
        (((-1.5e308, 0, 0), (1.5e308, 1, 1)), r"^bounds: expected numbers of at most 1e\+100 in size, got 1\.5e\+308"),
        ("box", "^bounds: expected an array of numbers"),
    ],
)
def test_bounds_are_a_box(bounds, message) -> None:
    with pytest.raises(bob.InputError, match=message):
        bob.implicit(lambda x, y, z: x, bounds)


def test_implicit_surfaces_are_made_of_formulas() -> None:
    with pytest.raises(bob.InputTypeError, match=r"^expression: expected an Expression, got function; bobrossnet.impl"):
        bob.Implicit(lambda x, y, z: x)
