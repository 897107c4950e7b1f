"""Streaming XML parser, with limits that only malicious files reach.

The parser alone would take minutes for some files of 64 MB: tags of four characters, endlessly nested elements, or a
single huge tag, which it rescans with every chunk.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import IO

from bobrossnet.support.errors import InputError

CHUNK = 1 << 20
MAX_TAG = 1 << 20  # bytes of a tag or a comment; real ones have a few hundred
MAX_DEPTH = 100_000  # real ones have ten
MANY = 250_000  # elements that any file may have; beyond, they are as long as the shortest real ones, on average
SHORT = 16  # bytes, where <v x="0" y="0" z="0"/> has 21


def read_xml(
    stream: IO[bytes],
    start: Callable[[str, dict[str, str]], object],
    end: Callable[[str], object],
    data: Callable[[str], object],
) -> None:
    """Report the start of each element with its attributes, its end, and its text, of XML in UTF-8.

    Names in a namespace are "namespace}name". The file's declaration of an encoding does not matter.

    Raises
    ------
    InputError
        If it is not XML, exceeds the limits, or has a document type, whose entities could expand endlessly.
    """
    from xml.parsers.expat import ExpatError, ParserCreate

    depth, left = 0, MANY

    def starts(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth, left
        depth += 1
        left -= 1
        if depth > MAX_DEPTH:
            raise InputError(f"expected XML of at most {MAX_DEPTH:,} levels, got more")
        if left < 0:
            raise InputError(f"expected XML with at most {MANY:,} elements of a few bytes, got more")
        start(name, attributes)

    def ends(name: str) -> None:
        nonlocal depth
        depth -= 1
        end(name)

    def document_type(*_: object) -> None:
        raise InputError("expected XML without a document type and entities, got some")

    parser = ParserCreate("utf-8", "}")
    parser.buffer_text = True
    parser.StartElementHandler = starts
    parser.EndElementHandler = ends
    parser.CharacterDataHandler = data
    parser.StartDoctypeDeclHandler = document_type
    total = 0
    try:
        while chunk := stream.read(CHUNK):
            total += len(chunk)
            left += len(chunk) // SHORT
            parser.Parse(chunk, False)
            if total - parser.CurrentByteIndex > MAX_TAG:  # the start of the unfinished token
                raise InputError(f"expected XML tags of at most {MAX_TAG:,} bytes, got a longer one")
        parser.Parse(b"", True)
    except ExpatError as error:
        raise InputError(f"expected XML, got something else ({error})") from error
