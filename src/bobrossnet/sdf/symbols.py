"""Formulas from Python functions: a function is called once with symbols, which record its operations."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from numbers import Real
from typing import Any, Literal, TypeAlias, TypeVar

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.support.errors import InputError, InputTypeError

Number: TypeAlias = "Symbol | float"
Rule: TypeAlias = Callable[..., Any]
"""The implementation of a numpy function for scalar symbols and numbers, at least one of them a symbol."""

Paint: TypeAlias = Callable[[_core.Graph], tuple[int, int, int]]
"""Makes the nodes of a colour: red, green and blue."""

Made = TypeVar("Made")

MAX_EXPONENT = 1000  # maximum integer exponent, as in the core


def expression_of(function: Callable[..., Any], arity: int, name: str = "function") -> _core.Expression:
    """Return the formula that a function computes.

    Parameters
    ----------
    function : callable
        Takes `arity` symbols and returns one, or a number. It may use operators, numpy's functions, `np.where`, loops
        and conditions on numbers; it is called once.
    arity : 1, 2 or 3
        The symbols are x, y and z in this order.
    name : str
        Prefix of error messages.

    Notes
    -----
    Values equal numpy's up to the last bits, with these exceptions: `np.where` is NaN where either side is NaN; powers
    of negative numbers are NaN unless the exponent is a constant integer; the sign of zero may be lost.

    Raises
    ------
    InputError
        If the function raises an error, uses the truth value of a condition on symbols, returns a value that is neither
        a symbol nor a number, or takes too many steps.
    """
    return _traced(function, lambda xyz: xyz[:arity], name, _expression)


def color_formula_of(function: Callable[..., Any], name: str = "color") -> _core.ColorFormula:
    """Return the colour formula that a function of x, y and z computes; see `expression_of`.

    Parameters
    ----------
    function : callable
        Takes three symbols and returns three symbols or numbers: red, green and blue, linear.
    name : str
        Prefix of error messages.

    Raises
    ------
    InputError
        As in `expression_of`.
    """
    return _traced(function, list, name, _color_formula)


def color_formula_of_points(function: Callable[..., Any], dimensions: int, name: str = "color") -> _core.ColorFormula:
    """Return the colour formula of a function of points (N, `dimensions`) that returns (N, 3), point by point."""
    return _traced(function, lambda xyz: [_symbols([xyz[:dimensions]])], name, _color_formula)


def formulas_of_points(
    function: Callable[..., Any], dimensions: int, name: str = "function"
) -> tuple[_core.Expression, _core.ColorFormula | None]:
    """Return the formula of a function of points, and the colour formula that it inherits from the shapes it evaluates.

    Parameters
    ----------
    function : callable
        Takes points (N, `dimensions`) and returns N numbers, (N,) or (N, 1), each a function of its point alone.
    dimensions : 2 or 3
    name : str
        Prefix of error messages.

    Raises
    ------
    InputError
        As in `expression_of`.
    """
    return _traced(function, lambda xyz: [_symbols([xyz[:dimensions]])], name, _expression_and_color)


def substitute(
    expression: _core.Expression, points: Symbols, color: _core.ColorFormula | Literal["white"] | None = None
) -> Symbols:
    """Evaluate a formula at symbolic points.

    Parameters
    ----------
    expression : Expression
    points : (N, 2) or (N, 3) Symbols
    color : ColorFormula or "white", optional
        Colour of the shape, carried along by its values; "white" for a shape without a colour.

    Returns
    -------
    (N, 1) Symbols
    """
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise InputError(f"points: expected shape (n, 2) or (n, 3), got {points.shape}")
    if not any(isinstance(value, Symbol) for value in points.flat):
        known = np.zeros((len(points), 3))
        known[:, : points.shape[1]] = points
        return _symbols(expression(known)[:, None])
    graph = _graph(*points.flat)
    rows = [[_node(graph, value) for value in row] + [graph.constant(0)] for row in points]
    values = []
    for row in rows:
        x, y, z = row[:3]
        value = Symbol(graph, graph.substitute(expression, x, y, z))
        if isinstance(color, _core.ColorFormula):
            value.color = _of_formula(color, x, y, z)
        elif color == "white":
            value.color = _white
        values.append([value])
    return _symbols(values)


class Symbol(NDArrayOperatorsMixin):
    """A symbolic number: x, y, z or an expression of them. Supports operators and numpy's functions."""

    __hash__ = None  # type: ignore[assignment]  # equality is a condition
    ndim = 0
    shape = ()
    color: Paint | None = None
    """Colour of the shape that the value comes from, if any."""

    def __init__(self, graph: _core.Graph, node: int) -> None:
        self.graph = graph
        self.node = node

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        return _apply(ufunc, method, inputs, kwargs)

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        return _call(function, args, kwargs)

    def __getattr__(self, name: str) -> Any:
        # On object arrays of symbols numpy calls the elements' methods: sqrt() for np.sqrt.
        ufunc = getattr(np, name, None)
        if isinstance(ufunc, np.ufunc) and ufunc in RULES:
            return functools.partial(ufunc, self)
        raise AttributeError(f"symbols have no attribute {name!r}")

    def __floor__(self) -> Any:
        return np.floor(self)

    def __ceil__(self) -> Any:
        return np.ceil(self)

    def __trunc__(self) -> Any:
        return np.trunc(self)

    def __round__(self, decimals: int | None = None) -> Any:
        return _round(self, decimals or 0)

    def __bool__(self) -> bool:
        raise InputTypeError(
            "a condition on symbols has no truth value while the formula is traced: use np.where(x > 0, a, b), "
            "np.minimum(x, y) for min(x, y), and np.stack([x, y]) for lists and arrays of symbols"
        )

    def __float__(self) -> float:
        raise InputTypeError(
            "a symbol has no value while the formula is traced: use numpy's functions, such as np.sin for math.sin"
        )

    __int__ = __float__

    def __repr__(self) -> str:
        return str(self.graph.expression(self.node))


class Condition(Symbol):
    """A comparison of symbols, 1 where true and 0 elsewhere. True where `below` < 0, or where not if negated."""

    def __init__(self, graph: _core.Graph, below: int, negated: bool = False) -> None:
        one, zero = graph.constant(1), graph.constant(0)
        super().__init__(graph, graph.select(below, *((zero, one) if negated else (one, zero))))
        self.below = below
        self.negated = negated

    def truth(self) -> int:
        """Return a node that is negative where the condition is true."""
        if not self.negated:
            return self.below
        return self.graph.select(self.below, self.graph.constant(1), self.graph.constant(-1))


class Symbols(np.ndarray[Any, np.dtype[np.object_]]):
    """An array of symbols and numbers, for functions of arrays: points (N, 3) are recorded as one row, x, y and z."""

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        return _apply(ufunc, method, inputs, kwargs)

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        return _call(function, args, kwargs)

    def __getitem__(self, index: Any) -> Any:
        return super().__getitem__(_checked_index(index))

    def __setitem__(self, index: Any, value: Any) -> None:
        super().__setitem__(_checked_index(index), value)


# ---- Tracing ---------------------------------------------------------------------------------------------


def _traced(
    function: Callable[..., Any],
    arguments: Callable[[list[Symbol]], Sequence[Any]],
    name: str,
    made: Callable[[_core.Graph, Any], Made],
) -> Made:
    """Call the function with `arguments` of x, y and z, and convert its result."""
    if not callable(function):
        raise InputTypeError(f"{name}: expected a function, got {type(function).__name__}")
    graph = _core.Graph()
    coordinates = [Symbol(graph, node) for node in (graph.x(), graph.y(), graph.z())]
    try:
        return made(graph, function(*arguments(coordinates)))
    except (InputError, _core.TooLargeError) as error:
        raise (InputTypeError if isinstance(error, TypeError) else InputError)(f"{name}: {error}") from error
    except Exception as error:
        text = " ".join(str(error).split())
        raise InputError(f"{name}: expected a formula, got {type(error).__name__}: {text}") from error


def _number(result: Any, expected: str) -> Any:
    """Return a result as one symbol or number; `expected` describes a valid result in the error message."""
    if isinstance(result, np.ndarray) and result.size == 1:
        result = result.reshape(-1)[0]
    if isinstance(result, Condition) or not _is_number(result):
        what = "a condition" if isinstance(result, Condition) else _kind(result)
        raise InputTypeError(f"expected a function that returns {expected}, got {what}")
    return result


def _expression(graph: _core.Graph, result: Any) -> _core.Expression:
    return graph.expression(_node(graph, _number(result, "a symbol or a number")))


def _expression_and_color(graph: _core.Graph, result: Any) -> tuple[_core.Expression, _core.ColorFormula | None]:
    number = _number(result, "a symbol or a number")
    expression = graph.expression(_node(graph, number))
    # The colour's nodes join the graph only now, so that the expression does not depend on them.
    paint = getattr(number, "color", None)
    return expression, None if paint in (None, _white) else graph.color_formula(*paint(graph))


def _color_formula(graph: _core.Graph, result: Any) -> _core.ColorFormula:
    expected = "red, green and blue"
    rgb = _plain(result)
    if isinstance(result, str) or rgb.size != 3:
        raise InputTypeError(f"expected a function that returns {expected}, got {_kind(result)}")
    red, green, blue = (_node(graph, _number(component, expected)) for component in rgb.reshape(-1))
    return graph.color_formula(red, green, blue)


def _kind(value: Any) -> str:
    return f"an array of shape {value.shape}" if isinstance(value, np.ndarray) else type(value).__name__


def _is_number(value: Any) -> bool:
    return isinstance(value, Symbol | Real | np.bool_)


def _node(graph: _core.Graph, value: Any) -> int:
    if isinstance(value, Symbol):
        return value.node
    if not _is_number(value):
        raise InputTypeError(f"expected symbols and numbers in a formula, got {_kind(value)}")
    if math.isnan(value):
        raise InputError("expected numbers in a formula, got NaN")
    return graph.constant(float(value))


def _graph(*values: Any) -> _core.Graph:
    return next(value.graph for value in values if isinstance(value, Symbol))


def _symbols(values: Any) -> Symbols:
    return np.asarray(values, dtype=object).view(Symbols)


def _plain(value: Any) -> NDArray[Any]:
    """Return an array of elements that numpy combines by their own operators."""
    return np.asarray(value, dtype=object)


def _unwrapped(array: Any) -> Any:
    """Return an array as Symbols, and a single element as itself."""
    if isinstance(array, np.ndarray) and array.dtype == object:
        return array.view(Symbols) if array.ndim else array[()]
    return array


def _checked_index(index: Any) -> Any:
    for part in index if isinstance(index, tuple) else (index,):
        if isinstance(part, Symbol) or (isinstance(part, np.ndarray) and part.dtype == object):
            raise InputTypeError("a symbol can't be an index while the formula is traced: use np.where(x > 0, a, b)")
    return index


# ---- numpy's protocols -----------------------------------------------------------------------------------


def _elementwise(rule: Rule, *operands: Any) -> Any:
    """Apply a rule to each element of broadcast operands."""
    if all(_is_number(operand) for operand in operands):
        return rule(*operands)
    arrays = np.broadcast_arrays(*map(_plain, operands))
    result = np.empty(arrays[0].shape, object)
    for index in np.ndindex(result.shape):
        result[index] = rule(*(array[index] for array in arrays))
    return _unwrapped(result)


def _apply(ufunc: np.ufunc, method: str, inputs: Sequence[Any], kwargs: dict[str, Any]) -> Any:
    if method == "reduce":
        return _reduce(ufunc, *inputs, **kwargs)
    if method != "__call__" or ufunc.signature is not None:  # such as np.matmul, done by the elements' operators
        if "out" in kwargs:
            kwargs["out"] = tuple(map(_plain, kwargs["out"]))
        return _unwrapped(getattr(ufunc, method)(*map(_plain, inputs), **kwargs))
    if ufunc not in RULES:
        raise InputTypeError(f"np.{ufunc.__name__}: not a function of formulas")

    def rule(*operands: Any) -> Any:
        symbolic = any(isinstance(operand, Symbol) for operand in operands)
        return _painted(ufunc, RULES[ufunc](*operands), operands) if symbolic else ufunc(*operands)

    result = _elementwise(rule, *inputs)
    out = kwargs.get("out", (None,))[0]
    if kwargs.get("where", True) is not True:
        result = _where(kwargs["where"], result, 0 if out is None else out)
    if out is None:
        return result
    out[...] = result
    return out


def _reduce(
    ufunc: np.ufunc, array: Any, axis: Any = 0, keepdims: bool = False, initial: Any = None, **kwargs: Any
) -> Any:
    if any(kwargs.get(key) is not default for key, default in (("where", True), ("out", None)) if key in kwargs):
        raise InputTypeError(f"np.{ufunc.__name__}: expected no `out` and no `where` in a formula")
    array = _plain(array)
    axes = tuple(range(array.ndim)) if axis is None else np.atleast_1d(axis)
    axes = tuple(int(each) % array.ndim for each in axes)
    rest = tuple(size for each, size in enumerate(array.shape) if each not in axes)
    slices = list(_symbols(np.moveaxis(array, axes, range(len(axes)))).reshape(-1, *rest))
    if initial is not None or not slices:
        slices.insert(0, ufunc.identity if initial is None else initial)
    result = functools.reduce(ufunc, slices)
    if not keepdims:
        return result
    kept = tuple(1 if each in axes else size for each, size in enumerate(array.shape))
    return _symbols(result).reshape(kept)


def _call(function: Any, args: Any, kwargs: Any) -> Any:
    """Call a numpy function that is not a ufunc: by a rule of this module, or by numpy on object arrays.

    The latter is either correct or raises, since it can use only the elements' operators, which have no truth value.
    """
    if function in FUNCTIONS:
        return FUNCTIONS[function](*args, **kwargs)
    result = np.ndarray.__array_function__(_symbols(0), function, (), _lifted(args), _lifted(kwargs))
    return result.view(Symbols) if isinstance(result, np.ndarray) and result.dtype == object else result


def _lifted(value: Any) -> Any:
    """Return the value with each symbol as an array."""
    if isinstance(value, Symbol):
        return _symbols(value)
    if isinstance(value, list | tuple):
        return type(value)(map(_lifted, value))
    if isinstance(value, dict):
        return {key: _lifted(each) for key, each in value.items()}
    return value


# ---- Colours ---------------------------------------------------------------------------------------------
#
# Values of shapes carry colours along, as in core/modelling/colored.h. A colour's nodes are made only after the
# formula, which is therefore the same with and without colours.


def _white(graph: _core.Graph) -> tuple[int, int, int]:
    """Paint of a shape without a colour."""
    one = graph.constant(1)
    return one, one, one


def _of_formula(color: _core.ColorFormula, x: int, y: int, z: int) -> Paint:
    return lambda graph: graph.substitute_color(color, x, y, z)


def _painted(ufunc: np.ufunc, result: Any, operands: Sequence[Any]) -> Any:
    """Return a rule's result with the colour of its operands.

    That is the only colour there is, or the colour of the lower or higher value. Other mixtures of two shapes have no
    colour.
    """
    shapes = [(operand, operand.color) for operand in operands if isinstance(operand, Symbol) and operand.color]
    if not shapes or not isinstance(result, Symbol) or isinstance(result, Condition):
        return result
    (a, paint_a), (b, paint_b) = shapes[0], shapes[-1]
    if paint_a is paint_b:
        result.color = paint_a
    elif ufunc in LOWER:
        result.color = _choosing(b, a, paint_b, paint_a)
    elif ufunc in HIGHER and _white in (paint_a, paint_b):  # a white shape only cuts
        result.color = paint_b if paint_a is _white else paint_a
    elif ufunc in HIGHER:
        result.color = _choosing(a, b, paint_b, paint_a)
    return result


def _choosing(lower: Symbol, higher: Symbol | int, yes: Paint, no: Paint) -> Paint:
    """Return one paint where the first value is below the second, otherwise the other."""

    def paint(graph: _core.Graph) -> tuple[int, int, int]:
        below = _difference(lower, higher).node
        red, green, blue = (graph.select(below, *pair) for pair in zip(yes(graph), no(graph), strict=True))
        return red, green, blue

    return paint


# ---- numpy functions that are not ufuncs -----------------------------------------------------------------


def _where(condition: Any, a: Any, b: Any) -> Any:
    return _elementwise(_choice, condition, a, b)


def _choice(condition: Any, a: Any, b: Any) -> Any:
    if not isinstance(condition, Symbol):
        return a if condition else b
    if not isinstance(condition, Condition):
        condition = condition != 0
    graph = condition.graph
    yes, no = (b, a) if condition.negated else (a, b)
    chosen = Symbol(graph, graph.select(condition.below, _node(graph, yes), _node(graph, no)))
    paints = [value.color for value in (yes, no) if isinstance(value, Symbol) and value.color]
    if len(paints) == 2:
        chosen.color = _choosing(Symbol(graph, condition.below), 0, *paints)
    elif paints:
        chosen.color = paints[0]
    return chosen


def _select(conditions: Sequence[Any], choices: Sequence[Any], default: Any = 0) -> Any:
    if len(conditions) != len(choices):
        raise InputError(f"np.select: expected a choice for each condition, got {len(choices)} for {len(conditions)}")
    result = default
    for condition, choice in zip(reversed(conditions), reversed(choices), strict=True):
        result = _where(condition, choice, result)
    return result


def _clip(a: Any, a_min: Any = None, a_max: Any = None, *, min: Any = None, max: Any = None) -> Any:
    low, high = (a_min if min is None else min), (a_max if max is None else max)
    if low is not None:
        a = np.maximum(a, low)
    return a if high is None else np.minimum(a, high)


def _norm(x: Any, ord: Any = None, axis: Any = None, keepdims: bool = False) -> Any:
    array = _symbols(x)
    if axis is None:
        if ord is not None and array.ndim != 1:
            raise InputTypeError("np.linalg.norm: expected vectors in a formula, got a matrix; is `axis` missing?")
        axis = tuple(range(array.ndim))
    elif not isinstance(axis, int):
        raise InputTypeError("np.linalg.norm: expected vectors in a formula, got two axes")
    size = np.abs(array)
    if ord in (None, 2):
        return np.sqrt(np.sum(np.square(array), axis=axis, keepdims=keepdims))
    if ord == math.inf:
        return np.max(size, axis=axis, keepdims=keepdims)
    if ord == -math.inf:
        return np.min(size, axis=axis, keepdims=keepdims)
    return np.sum(size**ord, axis=axis, keepdims=keepdims) ** (1 / ord)


def _round(a: Any, decimals: int = 0) -> Any:
    return np.rint(a) if decimals == 0 else np.rint(a * 10.0**decimals) / 10.0**decimals


FUNCTIONS: dict[Any, Rule] = {
    np.where: _where,
    np.select: _select,
    np.clip: _clip,
    np.linalg.norm: _norm,
    np.round: _round,
    np.around: _round,
    np.fix: lambda a: np.trunc(a),
}

# ---- Ufuncs ----------------------------------------------------------------------------------------------

UNARY = {
    np.negative: "negate",
    np.absolute: "absolute",
    np.fabs: "absolute",
    np.square: "square",
    np.sqrt: "sqrt",
    np.sin: "sin",
    np.cos: "cos",
    np.tan: "tan",
    np.arcsin: "asin",
    np.arccos: "acos",
    np.arctan: "atan",
    np.exp: "exp",
    np.log: "log",
    np.floor: "floor",
    np.ceil: "ceil",
    np.rint: "round",
}

LOWER: set[np.ufunc] = {np.minimum, np.fmin}
HIGHER: set[np.ufunc] = {np.maximum, np.fmax}

BINARY = {
    np.add: "add",
    np.subtract: "subtract",
    np.multiply: "multiply",
    np.divide: "divide",
    np.minimum: "minimum",
    np.maximum: "maximum",
    np.fmin: "minimum",
    np.fmax: "maximum",
    np.hypot: "hypot",
    np.arctan2: "atan2",
    np.remainder: "modulo",
}


def _unary(op: str) -> Rule:
    return lambda a: Symbol(a.graph, a.graph.unary(op, a.node))


def _binary(op: str) -> Rule:
    def rule(a: Number, b: Number) -> Symbol:
        graph = _graph(a, b)
        return Symbol(graph, graph.binary(op, _node(graph, a), _node(graph, b)))

    return rule


def _power(base: Number, exponent: Number) -> Any:
    graph = _graph(base, exponent)
    symbol = Symbol(graph, _node(graph, base))
    if not isinstance(exponent, Symbol):
        if float(exponent).is_integer():
            if abs(exponent) > MAX_EXPONENT:
                raise InputError(f"exponent: expected a whole number in ±{MAX_EXPONENT}, got {exponent:g}")
            return Symbol(graph, graph.unary("power", symbol.node, int(exponent)))
        if float(2 * exponent).is_integer():
            return np.sqrt(symbol) ** int(2 * exponent)
    return np.exp(np.log(symbol) * exponent)


def _less(a: Number, b: Number) -> Condition:
    return Condition(_graph(a, b), _difference(a, b).node)


def _not_less(a: Number, b: Number) -> Condition:
    return Condition(_graph(a, b), _difference(a, b).node, negated=True)


def _difference(a: Number, b: Number) -> Any:
    return np.subtract(a, b)


def _not_equal(a: Number, b: Number) -> Condition:
    return Condition(_graph(a, b), (-abs(_difference(a, b))).node)


def _not(a: Symbol) -> Condition:
    return Condition(a.graph, a.below, not a.negated) if isinstance(a, Condition) else (a == 0)


def _all(a: Any, b: Any) -> Any:
    return _joined("maximum", a, b)


def _any(a: Any, b: Any) -> Any:
    return _joined("minimum", a, b)


def _joined(op: str, a: Any, b: Any) -> Condition:
    graph = _graph(a, b)

    def truth(value: Any) -> int:
        if not isinstance(value, Symbol):
            return graph.constant(-1 if value else 1)
        return value.truth() if isinstance(value, Condition) else (value != 0).truth()

    return Condition(graph, graph.binary(op, truth(a), truth(b)))


def _fmod(a: Number, b: Number) -> Any:
    return np.copysign(np.remainder(np.abs(a), np.abs(b)), a)


# Near 0, exponentials and logarithms minus their value at 0 lose digits by cancellation; series do not.


def _meeting(below: Any, a: Any, b: Any) -> Symbol:
    """Return a where `below` < 0, otherwise b; the two are equal at the boundary."""
    graph = below.graph
    return Symbol(graph, graph.piecewise(below.node, a.node, b.node))


def _near_zero(a: Symbol, within: float, near: Callable[[Any], Any], far: Any) -> Any:
    """Return near(a) for a in ±within, otherwise `far`. `near` gets a clipped argument, for tight bounds."""
    return _meeting(np.abs(a) - within, near(np.clip(a, -within, within)), far)


def _sinh_series(a: Any) -> Any:
    """Evaluate the Taylor series, accurate in ±1 to 1e-14."""
    sum_ = 1
    for n in range(16, 0, -2):
        sum_ = 1 + sum_ * (a * a) / (n * (n + 1))
    return a * sum_


def _arctanh_series(a: Any) -> Any:
    """Evaluate the Taylor series, accurate in ±0.25 to 1e-14."""
    sum_ = 1 / 21
    for n in range(19, 0, -2):
        sum_ = 1 / n + sum_ * (a * a)
    return a * sum_


def _tanh_of_sinh(a: Any) -> Any:
    return a / np.hypot(a, 1)


def _arcsinh_series(a: Any) -> Any:
    return _arctanh_series(_tanh_of_sinh(a))


def _expm1(a: Symbol) -> Any:
    return _near_zero(a, 1, lambda a: 2 * _sinh_series(a / 2) * np.exp(a / 2), np.exp(a) - 1)


def _sinh(a: Symbol) -> Any:
    return _near_zero(a, 1, _sinh_series, (np.exp(a) - np.exp(-a)) / 2)


def _tanh(a: Symbol) -> Any:
    return _near_zero(a, 1, lambda a: _tanh_of_sinh(_sinh_series(a)), 1 - 2 / (np.exp(2 * a) + 1))


def _log1p(a: Symbol) -> Any:
    return _near_zero(a, 0.4, lambda a: 2 * _arctanh_series(a / (a + 2)), np.log(a + 1))


def _arctanh(a: Symbol) -> Any:
    return _near_zero(a, 0.25, _arctanh_series, np.log((1 + a) / (1 - a)) / 2)


def _arcsinh(a: Symbol) -> Any:
    size = np.log(np.abs(a) + np.hypot(a, 1))
    return _near_zero(a, 0.25, _arcsinh_series, _meeting(a, -size, size))


def _arccosh(a: Symbol) -> Any:
    sinh = np.sqrt(a - 1) * np.sqrt(a + 1)
    return _near_zero(sinh, 0.25, _arcsinh_series, np.log(a + sinh))


DERIVED: dict[np.ufunc, Rule] = {
    np.power: _power,
    np.float_power: _power,
    np.floor_divide: lambda a, b: np.floor(np.divide(a, b)),
    np.divmod: lambda a, b: (np.floor_divide(a, b), np.remainder(a, b)),
    np.fmod: _fmod,
    np.positive: lambda a: a,
    np.conjugate: lambda a: a,
    np.reciprocal: lambda a: 1 / a,
    np.sign: lambda a: _choice(a < 0, -1, _choice(a > 0, 1, 0)),
    np.copysign: lambda a, b: _choice(b < 0, -np.abs(a), np.abs(a)),
    np.heaviside: lambda a, b: _choice(a < 0, 0, _choice(a > 0, 1, b)),
    np.trunc: lambda a: _choice(a < 0, np.ceil(a), np.floor(a)),
    np.cbrt: lambda a: np.copysign(np.exp(np.log(np.abs(a)) / 3), a),
    np.exp2: lambda a: np.exp(a * math.log(2)),
    np.expm1: _expm1,
    np.log2: lambda a: np.log(a) / math.log(2),
    np.log10: lambda a: np.log(a) / math.log(10),
    np.log1p: _log1p,
    np.sinh: _sinh,
    np.cosh: lambda a: (np.exp(a) + np.exp(-a)) / 2,
    np.tanh: _tanh,
    np.arcsinh: _arcsinh,
    np.arccosh: _arccosh,
    np.arctanh: _arctanh,
    np.degrees: lambda a: a * (180 / math.pi),
    np.rad2deg: lambda a: a * (180 / math.pi),
    np.radians: lambda a: a * (math.pi / 180),
    np.deg2rad: lambda a: a * (math.pi / 180),
    np.less: _less,
    np.greater: lambda a, b: _less(b, a),
    np.greater_equal: _not_less,
    np.less_equal: lambda a, b: _not_less(b, a),
    np.not_equal: _not_equal,
    np.equal: lambda a, b: _not(_not_equal(a, b)),
    np.logical_not: _not,
    np.invert: _not,
    np.logical_and: _all,
    np.bitwise_and: _all,
    np.logical_or: _any,
    np.bitwise_or: _any,
}

RULES: dict[np.ufunc, Rule] = {
    **{ufunc: _unary(op) for ufunc, op in UNARY.items()},
    **{ufunc: _binary(op) for ufunc, op in BINARY.items()},
    **DERIVED,
}
