"""JSON, with errors of one line that name the faulty entry."""

from __future__ import annotations

import json
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from bobrossnet.support.errors import InputError, InputTypeError


def _itself(value: dict[str, Any]) -> dict[str, Any]:
    """The decoder in Python, which Ctrl-C interrupts; the one in C can't be interrupted."""
    return value


def _refuse(word: str) -> NoReturn:
    raise InputError(f"expected JSON, got {word}, which is not a JSON number")


def read_json(text: str | bytes) -> Any:
    """Decode a text.

    Raises
    ------
    InputError
        If it is not JSON.
    """
    try:
        return json.loads(text, object_hook=_itself, parse_constant=_refuse)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise InputError(f"expected JSON, got something else at {where} ({error.msg})") from error
    except (UnicodeDecodeError, InputError):
        raise
    except ValueError as error:  # for integers with thousands of digits
        raise InputError("expected JSON of ordinary numbers, got one of thousands of digits") from error


def numbers(name: str, value: Any) -> NDArray[np.float64]:
    """Return nested lists of numbers as an array.

    Raises
    ------
    InputTypeError
        If a value is not a number; numpy would accept true and "1" as 1.
    """
    try:
        items = np.array(value, dtype=object)
        others = {kind.__name__ for kind in map(type, items.reshape(-1))} - {"int", "float"}
        if others:
            raise ValueError(", ".join(sorted(others)))
        return items.astype(np.float64)
    except (ValueError, OverflowError) as error:
        raise InputTypeError(f"{name}: expected lists of numbers, all of one length, got others ({error})") from error
