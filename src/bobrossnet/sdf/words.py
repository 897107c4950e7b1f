"""Python functions and methods of the modelling language, made from the core's table of words."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.sdf.symbols import (
    Symbol,
    Symbols,
    color_formula_of_points,
    expression_of,
    formulas_of_points,
    substitute,
)
from bobrossnet.shapes.implicit import color_formula
from bobrossnet.support.errors import InputError, InputTypeError, check_array

# Arguments of words, for the stubs of d2 and d3.
Vector: TypeAlias = Sequence[float] | NDArray[Any]
Size: TypeAlias = float | Vector
Points: TypeAlias = Sequence[Vector] | NDArray[Any]
Easing: TypeAlias = Callable[[Any], Any]
Color: TypeAlias = str | Vector | _core.ColorFormula | Callable[[Any], Any]

Own = TypeVar("Own", bound="SDF")
"""The class of a shape, in two or three dimensions."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of a word; `variadic` takes all further positional arguments."""

    name: str
    type: str
    required: bool
    default: Any
    variadic: bool

    def describe(self) -> str:
        """Return the parameter as in a signature: its name, and its default if there is one."""
        if self.variadic:
            return f"*{self.name}"
        return self.name if self.required else f"{self.name}={self._default_text()}"

    def _default_text(self) -> str:
        if self.type == "easing":
            return "ease.linear"
        if isinstance(self.default, tuple):
            return "(" + ", ".join(f"{number:g}" for number in self.default) + ")"
        return f"{self.default:g}" if isinstance(self.default, float) else repr(self.default)


@dataclass(frozen=True)
class Word:
    """A word of the language.

    `dimensions` is the dimension of the shapes that it takes, or makes if its kind is "shape"; 0 for easings.
    """

    index: int
    name: str
    kind: str
    dimensions: int
    result_dimensions: int
    parameters: tuple[Parameter, ...]
    meaning: str

    def describe(self) -> str:
        """Return the call of the word, such as ``sphere(radius=1, center=(0, 0, 0))``."""
        return f"{self.name}({', '.join(parameter.describe() for parameter in self.parameters)})"


def _word(index: int, row: tuple[Any, ...]) -> Word:
    name, kind, dimensions, result_dimensions, parameters, meaning = row
    described = [Parameter(*parameter) for parameter in parameters]
    if kind == "easing":
        described[0] = replace(described[0], required=True)  # without t the core returns the easing itself
    return Word(index, name, kind, dimensions, result_dimensions, tuple(described), meaning)


WORDS = tuple(_word(index, row) for index, row in enumerate(_core.vocabulary()))

TYPES = {
    "number": "number",
    "integer": "whole number",
    "vector": "vector",
    "size": "number or vector",
    "numbers": "number or several",
    "points": "list of vectors",
    "easing": "function of t",
    "color": "colour",
    "sdf": "shape",
}
"""Name of each parameter type in documentation."""


class SDF:
    """Base class of shapes in two and three dimensions: a formula with operators.

    Parameters
    ----------
    function : Expression, or callable
        A formula in x, y (and z), negative inside; or a function of points (n, 2 or 3), called once with symbols, that
        returns one number for each.

    color : str, 3 numbers in 0..1, ColorFormula or callable, optional
        Colour of the shape: sRGB as "#rrggbb", linear RGB, a formula, or a function of points that returns (n, 3).

    Attributes
    ----------
    expression : Expression
    color_formula : ColorFormula or None
    """

    dimensions: int
    expression: _core.Expression
    color_formula: _core.ColorFormula | None
    _k: float | None

    def __call__(self, points: Any) -> Any:
        """Evaluate the signed distances of points.

        Parameters
        ----------
        points : (n, 2) or (n, 3) numbers
            One coordinate for each dimension of the shape.

        Returns
        -------
        (n, 1) float64, negative inside
        """
        if isinstance(points, Symbols):
            return substitute(self.expression, points, self.color_formula or "white")
        points = check_array("points", points, (None, self.dimensions))
        in_space = np.zeros((len(points), 3))
        in_space[:, : self.dimensions] = points
        return self.expression(in_space)[:, None]

    def k(self: Own, k: float | None = None) -> Own:
        """Return the shape with a radius for the rounded edge of the next operator that combines it with another shape.

        Parameters
        ----------
        k : number of at least 0, or None for a sharp edge

        Returns
        -------
        A new shape; this one is unchanged.
        """
        rounded = object.__new__(type(self))
        vars(rounded).update(vars(self))  # cached results are valid for both
        rounded._k = _checked(_core.call_method, self.to_core(), "k", (k,), {}).k
        return rounded

    def to_core(self) -> _core.Sdf:
        """Return the core's shape."""
        return _core.Sdf(self.dimensions, self.expression, self._k, self.color_formula)

    def __or__(self: Own, other: Own) -> Own:
        return self._combined("|", other)

    def __and__(self: Own, other: Own) -> Own:
        return self._combined("&", other)

    def __sub__(self: Own, other: Own) -> Own:
        return self._combined("-", other)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.expression!r})"

    def _combined(self: Own, op: str, other: Own) -> Own:
        if not isinstance(other, SDF):
            return NotImplemented
        shape: Own = _from_core(_checked(_core.combine, op, self.to_core(), other.to_core()))
        return shape


class Flat(SDF):
    """A shape in two dimensions. `SDF2` adds the language's operations."""

    dimensions = 2

    def __init__(self, function: Any, color: Any = None) -> None:
        self.expression, self.color_formula = formulas(function, color, 2)
        self._k = None


SHAPES: dict[int, type[Any]] = {}
"""SDF2 and SDF3 by their dimensions."""


def formulas(function: Any, color: Any, dimensions: int) -> tuple[_core.Expression, _core.ColorFormula | None]:
    """Return the formulas for the arguments of SDF2 and SDF3."""
    if isinstance(function, _core.Expression):
        expression, own = function, None
    elif isinstance(function, SDF):
        expression, own = function.expression, function.color_formula
    else:
        expression, own = formulas_of_points(function, dimensions)
    if callable(color) and not isinstance(color, _core.ColorFormula):
        return expression, color_formula_of_points(color, dimensions)
    return expression, own if color is None else color_formula(color)


def shape_words(dimensions: int) -> dict[str, Callable[..., Any]]:
    """Return the functions that make or take shapes of the given dimensions, by name."""
    return {word.name: _function(word) for word in WORDS if word.kind != "easing" and word.dimensions == dimensions}


def easing_words() -> dict[str, Callable[..., Any]]:
    """Return the easing functions by name."""
    return {word.name: _easing(word) for word in WORDS if word.kind == "easing"}


def add_methods(shape: type[Any]) -> None:
    """Add the operations on SDF2 or SDF3 to the class as methods."""
    SHAPES[shape.dimensions] = shape
    for word in WORDS:
        if word.kind == "operation" and word.dimensions == shape.dimensions:
            method = _function(word)
            method.__qualname__ = f"{shape.__name__}.{word.name}"
            parameters = list(_signature(word).parameters.values())
            method.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
                [parameters[0].replace(name="self"), *parameters[1:]]
            )
            setattr(shape, word.name, method)


def _function(word: Word) -> Callable[..., Any]:
    def function(*args: Any, **kwargs: Any) -> Any:
        args = tuple(_to_core(word, index, value) for index, value in enumerate(args))
        kwargs = {name: _to_core(word, name, value) for name, value in kwargs.items()}
        return _from_core(_checked(_core.call, word.index, args, kwargs))

    return _dressed(function, word, f"bobrossnet.sdf.d{word.dimensions}")


def _easing(word: Word) -> Callable[..., Any]:
    def easing(*args: Any, **kwargs: Any) -> Any:
        try:
            bound = _signature(word).bind(*args, **kwargs)
        except TypeError as error:
            raise InputTypeError(f"{word.name}: {error}") from None
        t, *rest = bound.args
        options = dict(zip((parameter.name for parameter in word.parameters[1:]), rest, strict=False))
        expression = _checked(_core.call, word.index, (), options).expression
        if isinstance(t, Symbol | Symbols):
            symbols = np.asarray(t, dtype=object)
            row = np.stack([symbols.reshape(-1), np.zeros(symbols.size, object)], axis=1)
            values = substitute(expression, row.view(Symbols)).reshape(symbols.shape)
            return values if symbols.ndim else values[()]
        numbers = _numbers(word, t)
        points = np.zeros((numbers.size, 3))
        points[:, 0] = numbers.reshape(-1)
        return expression(points).reshape(numbers.shape)[()]

    return _dressed(easing, word, "bobrossnet.sdf.ease")


def _numbers(word: Word, t: Any) -> NDArray[np.float64]:
    try:
        return np.asarray(t, np.float64)
    except (TypeError, ValueError):
        raise InputTypeError(f"{word.name}: t: expected a number or an array, got {type(t).__name__}") from None


def _dressed(function: Callable[..., Any], word: Word, module: str) -> Callable[..., Any]:
    """Return the function with its name, docstring and signature, for `help` and editors."""
    function.__name__ = function.__qualname__ = word.name
    function.__module__ = module
    function.__signature__ = _signature(word)  # type: ignore[attr-defined]
    lines = [word.meaning]
    if word.parameters:
        lines += ["", "Parameters", "----------"]
        lines += [_documented(word, parameter) for parameter in word.parameters]
    function.__doc__ = "\n".join(lines)
    return function


def _documented(word: Word, parameter: Parameter) -> str:
    if word.kind == "easing" and parameter.name == "t":
        return "t : number or array of numbers, 0..1"
    name = f"*{parameter.name}" if parameter.variadic else parameter.name
    kind = TYPES[parameter.type]
    if parameter.type in ("vector", "size", "points", "sdf"):
        kind = kind.replace("vector", f"{word.dimensions}D vector").replace("shape", f"{word.dimensions}D shape")
    optional = ", optional" if not (parameter.required or parameter.variadic) else ""
    return f"{name} : {kind}{optional}"


def _signature(word: Word) -> inspect.Signature:
    parameters: list[inspect.Parameter] = []
    for parameter in word.parameters:
        if parameter.variadic:
            parameters.append(inspect.Parameter(parameter.name, inspect.Parameter.VAR_POSITIONAL))
            continue
        after_variadic = parameters and parameters[-1].kind == inspect.Parameter.VAR_POSITIONAL
        kind = inspect.Parameter.KEYWORD_ONLY if after_variadic else inspect.Parameter.POSITIONAL_OR_KEYWORD
        default = inspect.Parameter.empty if parameter.required else _python_default(parameter)
        parameters.append(inspect.Parameter(parameter.name, kind, default=default))
    return inspect.Signature(parameters)


def _python_default(parameter: Parameter) -> Any:
    if parameter.type == "easing":
        return _linear
    if isinstance(parameter.default, tuple):
        return tuple(map(_whole, parameter.default))
    return _whole(parameter.default)


def _whole(value: Any) -> Any:
    """Return 1 for 1.0, which reads better."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


class _Default:
    """ease.linear as a default in signatures, printed by its name."""

    def __repr__(self) -> str:
        return "ease.linear"


_linear = _Default()


def _to_core(word: Word, place: int | str, value: Any) -> Any:
    """Convert a value to the core's types; the core converts numbers and vectors itself."""
    if isinstance(value, SDF):
        return value.to_core()
    if callable(value) and not isinstance(value, type | _core.ColorFormula):
        names = [parameter.name for parameter in word.parameters]
        name = names[min(place, len(names) - 1)] if isinstance(place, int) else place
        if any(parameter.name == name and parameter.type == "color" for parameter in word.parameters):
            return color_formula_of_points(value, word.dimensions, f"{word.name}: {name}")
        return _core.Easing(expression_of(value, 1, f"{word.name}: {name}"))
    return value


def _from_core(value: Any) -> Any:
    if not isinstance(value, _core.Sdf):
        return value
    shape = SHAPES[value.dimensions](value.expression, color=value.color)
    shape._k = value.k
    return shape


def _checked(function: Callable[..., Any], *args: Any) -> Any:
    """Call the core, with its errors raised as the package's errors."""
    try:
        return function(*args)
    except _core.CallTypeError as error:
        raise InputTypeError(str(error)) from None
    except (_core.CallError, _core.TooLargeError) as error:
        raise InputError(str(error)) from None
