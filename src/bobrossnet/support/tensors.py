"""Safetensors files with a fixed layout, so that equal content makes equal files.

The safetensors package orders a header's strings at random.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

DTYPES = {
    "float64": "F64",
    "float32": "F32",
    "int64": "I64",
    "int32": "I32",
    "uint32": "U32",
    "uint8": "U8",
    "bool": "BOOL",
}


def tensor_file(metadata: Mapping[str, str], tensors: Mapping[str, NDArray[Any]]) -> bytes:
    """Return a file's bytes: strings in the given order, then tensors by decreasing item size, hence aligned."""
    header: dict[str, Any] = {"__metadata__": dict(metadata)}
    body = []
    at = 0
    for name in sorted(tensors, key=lambda name: (-tensors[name].itemsize, name)):
        tensor = tensors[name]
        content = np.ascontiguousarray(tensor, tensor.dtype.newbyteorder("<")).tobytes()
        place = [at, at + len(content)]
        header[name] = {"dtype": DTYPES[tensor.dtype.name], "shape": list(tensor.shape), "data_offsets": place}
        body.append(content)
        at += len(content)
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 8)
    return b"".join([len(text).to_bytes(8, "little"), text, *body])
