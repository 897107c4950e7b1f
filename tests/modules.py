"""Names of the package's modules, found without importing them: packages of `learn` take seconds."""

from __future__ import annotations

from pathlib import Path

import bobrossnet as bob

PACKAGE = Path(bob.__file__).parent

MODULES = sorted(
    ".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")
    for file in PACKAGE.rglob("*.py")
)
