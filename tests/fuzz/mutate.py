"""Deterministic mutants of files, by bytes, words, numbers and lines, inside the containers of formats."""

from __future__ import annotations

import io
import json
import re
import struct
import zipfile
from collections.abc import Callable
from random import Random
from typing import TypeAlias

from bobrossnet.adapters.container import START, sealed

LARGEST = 1 << 16
"""Maximum bytes of a mutant: unbounded growth would only slow the fuzzer."""

NUMBER = re.compile(rb"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
WORD = re.compile(rb"[A-Za-z_][A-Za-z_0-9]+")
NUMBERS = [
    b"0", b"-0", b"1", b"-1", b"2", b"3", b"7", b"9", b"10", b"255", b"256", b"65536", b"2147483647", b"2147483648",
    b"-2147483648", b"4294967295", b"9007199254740993", b"18446744073709551616", b"0.5", b"1e-9", b"1e-320", b"1e38",
    b"1e100", b"1e308", b"1e999", b"-1e308", b"nan", b"NaN", b"inf", b"-Infinity", b"1_0", b"0x10", b"+1", b".5", b"1.",
    b"01", b"", b"null", b"[]", b"{}", b'""', b"true", b"9" * 400, "\u0663".encode(),
]  # fmt: skip
LAYOUTS = ["B", "<H", ">H", "<I", ">I", "<i", "<Q", "<f", "<d", ">d"]
INTEGERS = [0, 1, 2, 3, 4, 8, 127, 128, 255, 256, 65535, 1 << 16, (1 << 31) - 1, 1 << 31, (1 << 32) - 1, (1 << 64) - 1]
FLOATS = [0.0, -0.0, 1.0, -1.0, 1e-320, 1e-30, 1e30, 1e38, 1e100, 1e308, float("inf"), float("-inf"), float("nan")]

Bytes: TypeAlias = Callable[[bytes, Random, list[bytes]], bytes]
"""Maps a file, a random generator and other files of the format to a mutant."""


def mutant(ending: str, random: Random, files: list[bytes]) -> bytes:
    """Return one of the files with several changes.

    Parameters
    ----------
    ending : of the format, without the dot
    """
    data = random.choice(files)
    wrapped = WRAPPED.get(ending)
    for _ in range(random.choice((1, 1, 1, 2, 3, 6))):
        # Contents are mutated more often than containers: checksums and lengths would reject almost all of the latter.
        try:
            change = wrapped if wrapped and random.random() < 0.9 else plain
            data = change(data, random, files)[:LARGEST]
        except Exception:  # no longer a valid container
            data = plain(data, random, files)
    return data


# ---- Bytes and text --------------------------------------------------------------------------------------


def plain(data: bytes, random: Random, files: list[bytes]) -> bytes:
    """Change bytes or text once."""
    text = data[:512].isascii() and b"\0" not in data[:512]
    return random.choice(TEXT if text or random.random() < 0.2 else BINARY)(data or b"\n", random, files)


def flip(data: bytes, random: Random, files: list[bytes]) -> bytes:
    at = random.randrange(len(data))
    return data[:at] + bytes([data[at] ^ 1 << random.randrange(8)]) + data[at + 1 :]


def put(data: bytes, random: Random, files: list[bytes]) -> bytes:
    """Overwrite bytes by a number."""
    layout = random.choice(LAYOUTS)
    size = struct.calcsize(layout)
    if layout[-1] in "fd":
        value = random.choice(FLOATS)
        content = struct.pack(layout, value if abs(value) < 1e39 or layout[-1] == "d" else float("inf"))
    else:
        bits = 8 * size
        content = (random.choice(INTEGERS) % (1 << bits)).to_bytes(size, "big" if layout[0] == ">" else "little")
    at = random.randrange(len(data)) // (size if random.random() < 0.7 else 1)
    at = min(at * size, max(len(data) - size, 0))
    return data[:at] + content + data[at + size :]


def _part(data: bytes, random: Random) -> tuple[int, int]:
    start = random.randrange(len(data))
    return start, min(len(data), start + random.choice((1, 2, 4, 8, 12, 24, 50, 100, 500)))


def drop(data: bytes, random: Random, files: list[bytes]) -> bytes:
    start, end = _part(data, random)
    return data[:start] + data[end:]


def repeat(data: bytes, random: Random, files: list[bytes]) -> bytes:
    start, end = _part(data, random)
    return data[:end] + data[start:end] * random.choice((1, 1, 2, 10, 300)) + data[end:]


def cut(data: bytes, random: Random, files: list[bytes]) -> bytes:
    return data[: random.randrange(len(data))]


def splice(data: bytes, random: Random, files: list[bytes]) -> bytes:
    other = random.choice(files) or b"\n"
    start, end = _part(other, random)
    at, _ = _part(data, random)
    return data[:at] + other[start:end] + data[at + (end - start) * random.randrange(2) :]


def number(data: bytes, random: Random, files: list[bytes]) -> bytes:
    """Replace a number by another number or word."""
    found = list((NUMBER if random.random() < 0.9 else WORD).finditer(data))
    if not found:
        return flip(data, random, files)
    at = random.choice(found)
    return data[: at.start()] + random.choice(NUMBERS) + data[at.end() :]


def word(data: bytes, random: Random, files: list[bytes]) -> bytes:
    """Replace a word by a word of another file of the format, or insert it next to it."""
    words = WORD.findall(random.choice(files))
    found = list(WORD.finditer(data))
    if not words or not found:
        return flip(data, random, files)
    at = random.choice(found)
    start = at.start() if random.random() < 0.7 else at.end()
    return data[:start] + random.choice(words) + data[at.end() :]


def lines(data: bytes, random: Random, files: list[bytes]) -> bytes:
    """Remove, repeat or swap lines, or parts separated by commas or brackets."""
    between = random.choice([b"\n", b"\n", b",", b";", b" ", b"<", b"}"])
    parts = data.split(between)
    i, j = random.randrange(len(parts)), random.randrange(len(parts))
    change = random.randrange(4)
    if change == 0:
        del parts[i]
    elif change == 1:
        parts[i : i + 1] = [parts[i]] * random.choice((2, 2, 3, 300))
    elif change == 2:
        parts[i], parts[j] = parts[j], parts[i]
    else:
        parts[i] = random.choice(random.choice(files).split(between))
    return between.join(parts)


BINARY: list[Bytes] = [flip, put, put, put, drop, repeat, cut, splice, number, word]
TEXT: list[Bytes] = [number, number, number, word, word, lines, lines, lines, flip, drop, repeat, cut, splice]


# ---- Contents of containers ------------------------------------------------------------------------------


def glb(data: bytes, random: Random, files: list[bytes]) -> bytes:
    """Mutate the JSON or the numbers after it, and correct both lengths."""
    (length,) = struct.unpack("<12xI", data[:16])
    tree, body = data[20 : 20 + length], data[28 + length :]
    if random.random() < 0.75:
        tree = random.choice(TEXT)(tree, random, [tree])
    else:
        body = random.choice(BINARY)(body or b"\0", random, [body])
    tree += b" " * (-len(tree) % 4)
    size = struct.pack("<4s2I", b"glTF", 2, 28 + len(tree) + len(body))
    return size + struct.pack("<I4s", len(tree), b"JSON") + tree + struct.pack("<I4s", len(body), b"BIN\0") + body


def zipped(data: bytes, random: Random, files: list[bytes]) -> bytes:
    """Mutate one of the files in a zip file."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        content = {info.filename: archive.read(info) for info in archive.infolist()}
    name = random.choice(list(content))
    content[name] = random.choice(TEXT)(content[name] or b" ", random, list(content.values()))[:LARGEST]
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for each, text in content.items():
            archive.writestr(zipfile.ZipInfo(each), text, zipfile.ZIP_DEFLATED)
    return made.getvalue()


def tensors(data: bytes, random: Random, files: list[bytes]) -> bytes:
    """Mutate a safetensors file's header, its scene, or the numbers, and correct length and checksum."""
    length = int.from_bytes(data[:8], "little")
    header, body = data[8 : 8 + length], data[8 + length :]
    where = random.random()
    if where < 0.4 and b'"scene":' in header:
        tree = json.loads(header)
        scene = tree["__metadata__"]["scene"].encode()
        tree["__metadata__"]["scene"] = random.choice(TEXT)(scene, random, [scene]).decode(errors="replace")
        header = json.dumps(tree, separators=(",", ":")).encode()
    elif where < 0.7:
        start = len(START) + 64 if header.startswith(START) else 0
        header = header[:start] + random.choice(TEXT)(header[start:], random, [header])
    else:
        body = random.choice(BINARY)(body or b"\0", random, [body])
    header = header.rstrip() + b" " * (-len(header.rstrip()) % 8)
    made = len(header).to_bytes(8, "little") + header + body
    return sealed(made) if header.startswith(START) else made


def columns(data: bytes, random: Random, files: list[bytes]) -> bytes:
    """Mutate the contents of an IGES line, in the 72 columns before its section letter."""
    found = data.splitlines()
    i = random.randrange(len(found))
    inner, tail = found[i][:72], found[i][72:]
    wide = 64 if tail[:1] == b"P" else 72
    changed = random.choice((number, number, number, word, flip, splice, lines))(
        inner[:wide].rstrip() or b" ", random, files
    )
    if random.random() < 0.3:  # directory entries are right-justified fields of eight
        at = 8 * random.randrange(9)
        changed = inner[:at] + random.choice(NUMBERS)[:8].rjust(8) + inner[at + 8 :]
        wide = 72
    changed = changed.replace(b"\n", b" ")[:wide].ljust(wide) + inner[wide:]
    found[i] = changed[:72] + tail
    return b"\n".join(found) + b"\n"


WRAPPED: dict[str, Bytes] = {
    "glb": glb,
    "3mf": zipped,
    "bob": tensors,
    "safetensors": tensors,
    "iges": columns,
}
