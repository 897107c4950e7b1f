"""JSON, with a line that says where a text is something else."""

from __future__ import annotations

import json
from typing import Any

from bobrossnet.errors import InputError


def read_json(text: str | bytes) -> Any:
    """What a text holds.

    Raises
    ------
    InputError
        If it is not JSON.
    """
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise InputError(f"expected JSON, got something else at {where} ({error.msg})") from error
    except UnicodeDecodeError:
        raise
    except ValueError as error:  # of integers with thousands of digits
        raise InputError("expected JSON of ordinary numbers, got one of thousands of digits") from error
