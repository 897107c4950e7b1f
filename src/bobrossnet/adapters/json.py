"""JSON, with a line that says where a text is something else."""

from __future__ import annotations

import json
from typing import Any

from bobrossnet.errors import InputError


def _itself(value: dict[str, Any]) -> dict[str, Any]:
    """Python's own code, in which Ctrl-C is noticed; json has none while it reads a text."""
    return value


def read_json(text: str | bytes) -> Any:
    """What a text holds.

    Raises
    ------
    InputError
        If it is not JSON.
    """
    try:
        return json.loads(text, object_hook=_itself)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise InputError(f"expected JSON, got something else at {where} ({error.msg})") from error
    except UnicodeDecodeError:
        raise
    except ValueError as error:  # of integers with thousands of digits
        raise InputError("expected JSON of ordinary numbers, got one of thousands of digits") from error
