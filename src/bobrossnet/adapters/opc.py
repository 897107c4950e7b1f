"""Packages: zip files of parts and relationships, by the Open Packaging Conventions (ISO/IEC 29500-2)."""

from __future__ import annotations

import posixpath
from pathlib import Path
from urllib.parse import unquote
from zipfile import ZipFile, ZipInfo

from bobrossnet.adapters.xml import read_xml
from bobrossnet.support.errors import InputError

ROOT_RELATIONS = "_rels/.rels"


class Package:
    """The parts of a package by their names: in any case, and with or without percent-encoding."""

    def __init__(self, file: Path, archive: ZipFile) -> None:
        self.file, self.archive = file, archive
        self._unpacked: dict[str, int] = {}
        parts = archive.infolist()
        self._parts = {_decoded(info.filename): info for info in parts}
        self._parts |= {_plain(info.filename): info for info in parts}

    def part(self, path: str) -> ZipInfo | None:
        """Return the part at a path from the package's root, or None."""
        return self._parts.get(_plain(path)) or self._parts.get(_decoded(path))

    def ending_in(self, ending: str) -> list[ZipInfo]:
        return [info for info in self.archive.infolist() if info.filename.lower().endswith(ending)]

    def target(self, kind: str) -> ZipInfo | None:
        """Return the target of the package's first relationship of a type that ends in `kind`."""
        relations = self.part(ROOT_RELATIONS)
        found: list[str] = []

        def start(_: str, get: dict[str, str]) -> None:
            if get.get("Type", "").endswith(kind) and get.get("TargetMode", "Internal") == "Internal":
                found.append(get.get("Target", ""))

        if relations is not None:
            self.count("relationships", relations)
            with self.archive.open(relations) as stream:
                read_xml(stream, start, lambda _: None)
        return self.part(found[0]) if found else None

    def count(self, content: str, info: ZipInfo) -> None:
        """Append a part to the parts of the same content, before it is unpacked.

        Raises
        ------
        InputError
            If these unpack to far more than the file's size.
        """
        total = self._unpacked[content] = self._unpacked.get(content, 0) + info.file_size
        # Coordinates shrink to a third or a tenth of their text, pictures not at all, only bombs to a hundredth.
        if total > 1 << 26 and total > 100 * self.file.stat().st_size:
            raise InputError(f"expected {content}, got a zip file that unpacks to {total:,} bytes")


def _plain(path: str) -> str:
    """A part's name in lower case, from the root, without "." and ".."."""
    return posixpath.normpath("/" + path.replace("\\", "/").lower().lstrip("/"))


def _decoded(path: str) -> str:
    return _plain(unquote(path))
