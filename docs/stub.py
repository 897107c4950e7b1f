"""Writes the stub of the C++ core from its bindings and their docstrings.

python docs/stub.py
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from nanobind.stubgen import StubGen

from bobrossnet import _core

ROOT = Path(__file__).parent.parent
PATH = ROOT / "src/bobrossnet/_core.pyi"

HEAD = '''"""The C++ core, written by docs/stub.py from bindings/, where the docstrings and the shapes of arrays stand.

Arrays are C-contiguous; none is converted or copied.
"""
'''

LETTERS = {"float": "F", "int": "I", "uint": "U"}


def stub() -> str:
    """Return the stub: types of arrays by short names, without their shapes."""
    made = StubGen(module=_core, include_docstrings=False, quiet=True)
    made.put(_core)
    array = re.compile(r"Annotated\[NDArray\[numpy\.(float|int|uint)(\d+)\], dict\((?:[^()]|\([^()]*\))*\)\]")
    text = made.get()
    used = sorted(set(array.findall(text)), key=lambda each: (each[0], int(each[1])))
    names = "".join(f"{LETTERS[kind]}{bits} = NDArray[numpy.{kind}{bits}]\n" for kind, bits in used)
    text = (
        array.sub(lambda match: f"{LETTERS[match[1]]}{match[2]}", text)
        .replace("Annotated, ", "")
        .replace("NDArray]", "NDArray[Any]]")
    )
    imports, _, rest = text.partition("\n\n\n")
    return f"{HEAD}\n{imports}\n\n{names}\n{rest}"


def main() -> None:
    PATH.write_text(stub(), "utf-8")
    subprocess.run(["ruff", "format", "--quiet", PATH], check=True)


if __name__ == "__main__":
    main()
