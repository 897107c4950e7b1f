"""Errors of unusable inputs, and the checks that raise them.

Every message has the same parts: the argument's name, the expected value, the actual value and, where possible, a
remedy.
"""

from __future__ import annotations

import io
import math
import sys
import warnings
from collections.abc import Iterator, Sequence
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import NDArray


class InputError(ValueError):
    """A value, an array or a file that can't be used."""


class InputTypeError(InputError, TypeError):
    """An input of the wrong type or dtype."""


class InputWarning(UserWarning):
    """A part of an input was unusable and has been omitted."""


def warn_coarse(what: str) -> None:
    """Warn that building a shape reached its budget of work."""
    text = f"shape: its {what} is too intricate to prepare in a few seconds: as exact, but tracing is slow"
    warnings.warn(text, InputWarning, stacklevel=4)


def check_number(
    name: str, value: Any, low: float = -math.inf, high: float = math.inf, *, above: bool = False, hint: str = ""
) -> float:
    """Return `value` as a float if it is a finite real number in [low, high], or (low, high] if `above`."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real):
        raise InputTypeError(f"{name}: expected a number, got {brief(value)}{'; ' + hint if hint else ''}")
    try:
        number = float(value)
    except OverflowError:  # an integer beyond every float
        number = math.copysign(math.inf, 1 if value > 0 else -1)  # type: ignore[operator]
    inside = (low < number if above else low <= number) and number <= high
    if not (math.isfinite(number) and inside):
        raise InputError(f"{name}: expected {_interval(low, high, above)}, got {number:g}{'; ' + hint if hint else ''}")
    return number


def check_integer(name: str, value: Any, low: int, high: int) -> int:
    """Return `value` as an int if it is an integer in [low, high]."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, Integral):
        raise InputTypeError(f"{name}: expected an integer, got {brief(value)}")
    if not low <= int(value) <= high:
        raise InputError(f"{name}: expected an integer in {low}..{high}, got {brief(int(value), of_type=False)}")
    return int(value)


def check_choice(name: str, value: Any, choices: Sequence[str]) -> str:
    """Return `value` if it is one of `choices`."""
    if not isinstance(value, str):
        raise InputTypeError(f"{name}: expected one of {', '.join(choices)}, got {brief(value)}")
    if value not in choices:
        raise InputError(f"{name}: expected one of {', '.join(choices)}, got {brief(value, of_type=False)}")
    return value


def check_array(name: str, value: Any, shape: tuple[int | None, ...], *, hint: str = "") -> NDArray[Any]:
    """Return `value` as an array of numbers of `shape`; None is any length."""
    # The import of numpy.ma takes 15 ms; before it, there are no masked arrays.
    if "numpy.ma" in sys.modules and isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise InputError(f"{name}: expected numbers everywhere, got masked values; fill them first")
    try:
        array = np.asarray(value)
    except Exception as error:  # an object's __array__ can raise anything
        raise InputTypeError(f"{name}: expected an array of numbers, got {brief(value)}") from error
    if array.dtype.kind not in "biuf":
        got = type(value).__name__ if array.ndim == 0 else f"dtype {array.dtype}"
        raise InputTypeError(f"{name}: expected an array of numbers, got {got}")
    fits = array.ndim == len(shape) and all(want in (None, got) for want, got in zip(shape, array.shape, strict=True))
    if not fits:
        wanted = "(" + ", ".join("n" if n is None else str(n) for n in shape) + ("," if len(shape) == 1 else "") + ")"
        raise InputError(f"{name}: expected shape {wanted}, got {array.shape}{'; ' + hint if hint else ''}")
    return array


def shape_of(value: Any) -> tuple[int, ...]:
    """Return the shape of an array; () for any other object, which `check_array` refuses."""
    try:
        shape = np.shape(value)
    except Exception:
        return ()
    return shape if isinstance(shape, tuple) else ()  # some objects have an unrelated `shape`


def check_flag(name: str, value: Any) -> bool:
    """Return `value` as a bool if it is one; otherwise raise InputTypeError."""
    if not isinstance(value, bool | np.bool_) and not (isinstance(value, Integral) and value in (0, 1)):
        raise InputTypeError(f"{name}: expected True or False, got {brief(value)}")
    return bool(value)


def check_callable(name: str, value: Any) -> None:
    """Raise InputTypeError unless `value` is callable or None."""
    if value is not None and not callable(value):
        raise InputTypeError(f"{name}: expected a function, got {brief(value)}")


def each_of(name: str, values: Any, what: str) -> Iterator[Any]:
    """Return an iterator over `values`; `what` describes them in the error if they are not iterable."""
    if isinstance(values, io.IOBase):  # its lines would be taken as values
        raise InputTypeError(f"{name}: expected {what}, got an open file; give its path")
    try:
        return iter(values)
    except Exception:
        raise InputTypeError(f"{name}: expected {what}, got {type(values).__name__}") from None


def check_finite(name: str, array: NDArray[Any]) -> NDArray[Any]:
    """Return `array` if it is finite everywhere; otherwise raise InputError."""
    bad = array.size - int(np.count_nonzero(np.isfinite(array)))
    if bad:
        raise InputError(f"{name}: expected finite numbers, got {bad} of {array.size} NaN or infinite")
    return array


def check_direction(name: str, value: Any) -> tuple[NDArray[np.float64], float]:
    """Return a vector of three finite numbers as one of length 1, and its length, which is above 0."""
    vector = check_finite(name, check_array(name, value, (3,))).astype(np.float64)
    largest = float(np.abs(vector).max())
    if not largest > 0:
        raise InputError(f"{name}: expected a length above 0, got (0, 0, 0)")
    _, exponent = math.frexp(largest)
    scaled = np.ldexp(vector, -exponent)  # its square stays in range, and a power of two rounds nothing
    length = float(np.linalg.norm(scaled))
    return scaled / length, float(np.ldexp(length, exponent))


def _interval(low: float, high: float, above: bool) -> str:
    if math.isinf(low) and math.isinf(high):
        return "a finite number"
    if math.isinf(high):
        return f"a number {'above' if above else 'of at least'} {low:g}"
    return f"a number in {'(' if above else '['}{low:g}, {high:g}]"


def brief(value: Any, *, of_type: bool = True) -> str:
    """Return a short one-line text of a value, prefixed by its type if `of_type`."""
    try:
        text = " ".join(repr(value).encode(errors="backslashreplace").decode().split())
    except ValueError:  # Python prints no integers of thousands of digits
        text = f"{value.bit_length():,} bits" if isinstance(value, int) else "..."
    text = text if len(text) <= 40 else f"{text[:37]}..."
    return f"{type(value).__name__} {text}" if of_type else text
