"""Bundles modules of the page: the page, its element and each kind of worker become one file each.

A module becomes a function that runs once and returns its exports, so that no name has to change. Only the forms of
imports and exports in the page's code are supported; any other form is refused.
"""

from __future__ import annotations

import json
import posixpath
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
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

APART = (
    "component/cube.js",
    "component/handles.js",
    "component/marker.js",
    "component/orientation.js",
    "component/saying.js",
    "component/spots.js",
    "tracing/fitting.js",
    "tracing/picking.js",
)
"""Modules that the element imports where they are wanted; in a page of a single file, they are part of it."""

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


LITERAL = re.compile(r"""\"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*'|/(?:[^/\\\n[]|\\.|\[(?:[^]\\\n]|\\.)*\])+/[a-z]*""")
"""A string or a regular expression."""

WORD = re.compile(r"[\w$#.]+")
BEFORE_LITERAL = "\n(,=:[!&|?{};>"
"""Characters after which a slash begins a regular expression."""

PUNCTUATION = "{}()[],;:=*?&|<>!%+-\n"


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


def joined(modules: Modules, entry: str, apart: Collection[str] = ()) -> str:
    """Return the text of a module bundled with all static and dynamic imports, except dynamic ones of `apart`.

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
        other = _beside(path, found[1])
        if other in apart:
            return f'import("./{posixpath.relpath(other, posixpath.dirname(entry))}")'
        return f"Promise.resolve({_name(other)})"

    for path in _in_order(modules, entry, apart):
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
    return squeezed(INDENTATION.sub("", "".join(parts)))


def squeezed(text: str) -> str:
    """Remove comments that fill a line, and the spaces and line breaks that JavaScript does not need."""
    kept: list[str] = []
    last = "\n"  # the last kept character that is no space
    at = 0
    while at < len(text):
        letter = text[at]
        end = at + 1
        if text.startswith("//", at):
            at = text.index("\n", at)
            continue
        if word := WORD.match(text, at):
            end = word.end()
        elif (letter != "/" or last in BEFORE_LITERAL) and (literal := LITERAL.match(text, at)):
            end = literal.end()
        elif letter == "`":
            end = _template_end(text, at)
        after = text[end : end + 1]
        if letter == " ":
            is_needed = not (last in PUNCTUATION or after in PUNCTUATION) or (last in "+-" and after in "+-")
        else:
            is_needed = letter != "\n" or last not in "\n{([,"
            last = text[end - 1] if is_needed else last
        if is_needed:
            kept.append(text[at:end])
        at = end
    return "".join(kept)


def _template_end(text: str, at: int) -> int:
    """Return the index after the template literal that begins at `at`; its expressions may contain others."""
    depth = 0
    at += 1
    while depth > 0 or text[at] != "`":
        if text[at] == "\\":
            at += 1
        elif depth > 0 and text[at] == "`":
            at = _template_end(text, at) - 1
        elif depth > 0 and (literal := LITERAL.match(text, at)) and text[at] != "/":
            at = literal.end() - 1
        elif text.startswith("${", at):
            depth += 1
            at += 1
        elif depth > 0 and text[at] in "{}":
            depth += 1 if text[at] == "{" else -1
        at += 1
    return at + 1


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


def _in_order(modules: Modules, entry: str, apart: Collection[str]) -> Iterator[str]:
    """Yield the module and its dependencies, each once, after its own dependencies."""
    seen: set[str] = set()

    def visit(path: str, within: tuple[str, ...]) -> Iterator[str]:
        if path in within:
            raise ValueError(f"{path}: expected no module that needs itself, got {' > '.join((*within, path))}")
        if path in seen:
            return
        text = modules[path]
        needed = [_beside(path, found[2]) for found in IMPORT.finditer(text)]
        later = [_beside(path, found[1]) for found in LATER.finditer(text)]
        for other in [*needed, *(each for each in later if each not in apart)]:
            yield from visit(other, (*within, path))
        seen.add(path)
        yield path

    yield from visit(entry, ())


def _beside(path: str, relative: str) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(path), relative))


def _name(path: str) -> str:
    """Return the name of a module's exports; no other name has a dollar sign."""
    return "$" + re.sub(r"\W", "_", path.removesuffix(".js"))
