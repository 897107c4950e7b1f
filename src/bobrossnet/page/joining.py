"""Bundles modules of the page: the page, its element and each kind of worker become one file each.

A module becomes a function that runs once and returns its exports, so that no name has to change. Only the forms of
imports and exports in the page's code are supported; any other form is refused.
"""

from __future__ import annotations

import json
import posixpath
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path

from bobrossnet import __version__

COMPONENT = "component/bob-view.js"

ENTRIES = (
    COMPONENT,
    "interface/main.js",
    "workers/completing.js",
    "workers/reader.js",
    "workers/thread.js",
    "workers/tracer.js",
)
"""Entry modules, which no module imports. Bundled, they keep their paths, so that relative addresses stay valid."""

WORKERS = ("completing", "reader", "thread", "tracer")

SINGLE = "component/single.js"
"""Entry of a single-file page."""

WIDGET = "component/widget.js"
"""Entry of the notebook widget."""

BROUGHT = "core/brought.js"

PLACES = "core/places.js"

VERSION = "core/version.js"

COMMENT = re.compile(
    r"^[ \t]*/\*\*(?:(?!\*/).)*\*/[ \t]*\n|^[ \t]*//[^\n]*\n|/\*\*(?:(?!\*/).)*\*/ ?|(?<=[;,{)])[ \t]+// [^\n]*$",
    re.DOTALL | re.MULTILINE,
)
INDENTATION = re.compile(r"^[ \t]+", re.MULTILINE)
IMPORT = re.compile(r'^import (?:\{([^}]*)\} from )?"([^"]+)";\n', re.MULTILINE)
LATER = re.compile(r'\bimport\("([^"]+)"\)')
EXPORT = re.compile(r"^export (?=(?:async )?(?:function\*?|class|const) )", re.MULTILINE)
EXPORTED = re.compile(r"^export (?:async )?(?:function\*?|class|const) (?:(\w+)|\{([^}]*)\})", re.MULTILINE)
OTHERS = re.compile(r"^(?:import|export)\b.*", re.MULTILINE)


class Modules:
    """The texts of modules, without comments, and with the package's version.

    Parameters
    ----------
    folder : Path
    replaced : mapping of str to str, optional
        Texts that replace files, by path in the folder.
    """

    def __init__(self, folder: Path, replaced: Mapping[str, str] | None = None) -> None:
        self._folder = folder
        self._texts = {VERSION: f'export const VERSION = "{__version__}";\n', **(replaced or {})}

    def __getitem__(self, path: str) -> str:
        if path not in self._texts:
            self._texts[path] = COMMENT.sub("", (self._folder / path).read_text(encoding="utf-8"))
        return self._texts[path]


def joined(modules: Modules, entry: str) -> str:
    """Return the text of a module bundled with all static and dynamic imports.

    Lines are not indented, which would add 3 % to the compressed size.

    Raises
    ------
    ValueError
        If a module has an unsupported import or export, imports a missing export, imports itself, or has relative
        addresses and lies at another depth of folders.
    """
    parts: list[str] = []
    exports: dict[str, list[str]] = {}

    def taken(path: str, found: re.Match[str]) -> str:
        other = _beside(path, found[2])
        if found[1] is None:
            return ""
        if missing := set(re.findall(r"(\w+)(?: as \w+)?", found[1])) - set(exports[other]):
            raise ValueError(f"{path}: expected {', '.join(sorted(missing))} to be exported by {other}")
        renamed = re.sub(r"(\w+) as (\w+)", r"\1: \2", found[1])
        return f"const {{{renamed}}} = {_name(other)};\n"

    def taken_later(path: str, found: re.Match[str]) -> str:
        return f"Promise.resolve({_name(_beside(path, found[1]))})"

    for path in _in_order(modules, entry):
        text = "".join(taken(path, found) for found in IMPORT.finditer(modules[path])) + IMPORT.sub("", modules[path])
        text = LATER.sub(partial(taken_later, path), text)
        if path.count("/") != entry.count("/") and re.search(r"import\.meta|\bimport\(", text):
            raise ValueError(f"{path}: expected no address in a module of another depth than {entry}")
        if path != entry:
            exports[path] = [
                name for one, many in EXPORTED.findall(text) for name in ([one] if one else re.findall(r"\w+", many))
            ]
            text = EXPORT.sub("", text)
            if other := OTHERS.search(text):
                raise ValueError(f"{path}: expected another form than: {other[0]}")
            text = f"const {_name(path)} = (() => {{\n{text}return {{ {', '.join(exports[path])} }};\n}})();\n"
        parts.append(f"// {path}\n{text}")
    return INDENTATION.sub("", "".join(parts))


def brought(modules: Modules, parts: Mapping[str, str]) -> str:
    """Return the module that contains all workers and other parts (core/brought.js).

    Parameters
    ----------
    parts : mapping of str to str
        Deflated bytes in base64, by path.
    """
    workers = {name: joined(modules, f"workers/{name}.js") for name in WORKERS}
    return f"export const BROUGHT = {json.dumps({'workers': workers, 'parts': dict(parts)})};\n"


def places(paths: Iterable[str]) -> str:
    """Return the module with the address of each file (core/places.js), in the form that bundlers follow."""
    entries = "".join(f'"{path}": () => new URL("../{path}", import.meta.url),\n' for path in sorted(paths))
    return f"const PLACES = {{\n{entries}}};\nexport const placeOf = (path) => PLACES[path]();\n"


def _in_order(modules: Modules, entry: str) -> Iterator[str]:
    """Yield the module and its dependencies, each once, after its own dependencies."""
    seen: set[str] = set()

    def visit(path: str, within: tuple[str, ...]) -> Iterator[str]:
        if path in within:
            raise ValueError(f"{path}: expected no module that needs itself, got {' > '.join((*within, path))}")
        if path in seen:
            return
        text = modules[path]
        needed = [found[2] for found in IMPORT.finditer(text)]
        needed += [found[1] for found in LATER.finditer(text)]
        for other in needed:
            yield from visit(_beside(path, other), (*within, path))
        seen.add(path)
        yield path

    yield from visit(entry, ())


def _beside(path: str, relative: str) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(path), relative))


def _name(path: str) -> str:
    """Return the name of a module's exports; no other name has a dollar sign."""
    return "$" + re.sub(r"\W", "_", path.removesuffix(".js"))
