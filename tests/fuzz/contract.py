"""The contract of every reader for any bytes: a scene, or a one-line error, in bounded time and memory."""

from __future__ import annotations

import re
import resource
import sys
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import bobrossnet as bob
from bobrossnet.adapters import apart, opencascade, rhino
from bobrossnet.completion.network import make_network
from bobrossnet.completion.weights import read_weights
from bobrossnet.support.errors import InputError, InputWarning

LONGEST = 5.0
"""Seconds of the processor, for files of at most 64 KB."""

MEMORY = 1 << 30
"""Maximum bytes above the process' memory before the call; the system refuses more."""

LITTLE = 1 << 26, 1.0
"""Smaller limits in bytes and seconds than for users' files, since reaching the limits takes time."""

APART = {"step", "iges", "3dm"}
"""Formats read in a separate process, since their libraries crash on damaged files."""

HERE = Path(bob.__file__).parent
READABLE = tuple(map(str, (HERE, sys.prefix, sys.base_prefix, sys.base_exec_prefix, "/usr/lib", "/proc/self", "/sys")))


class BrokenPromise(Exception):  # noqa: N818
    """A violation of the contract by a reader."""


def outcome(file: Path) -> tuple[bool, str]:
    """Return whether a file loads, and a description of its contents or the error.

    Raises
    ------
    BrokenPromise
    """
    start = time.process_time()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            loads, found = True, _weights(file) if file.suffix == ".safetensors" else _scene(file)
        except InputError as error:
            loads, found = False, str(error)
            _check_line(file, found)
        except BrokenPromise:
            raise
        except BaseException as error:
            raise BrokenPromise(f"raised {type(error).__name__}: {error}") from error
    for warning in caught:
        if not issubclass(warning.category, InputWarning):
            raise BrokenPromise(f"warned of {warning.category.__name__}: {warning.message}")
        _check_line(file, str(warning.message))
    seconds = time.process_time() - start
    if seconds > LONGEST:
        raise BrokenPromise(f"took {seconds:.1f} s; {found}")
    return loads, found


def _scene(file: Path) -> str:
    scene = bob.load(file)
    bob.trace(scene, size=(6, 8))
    if file.suffix == ".bob":
        copies = [file.with_name(name) for name in ("first-copy.bob", "second-copy.bob")]
        bob.save_scene(scene, copies[0])
        bob.save_scene(bob.load(copies[0]), copies[1])
        if copies[0].read_bytes() != copies[1].read_bytes():
            raise BrokenPromise("what was saved, loaded and saved again has other bytes")
    return scene.describe()


def _weights(file: Path) -> str:
    metadata, tensors = read_weights(file)
    try:
        make_network(metadata, tensors)
    except ValueError as error:
        raise InputError(f"{file.name}: {error}") from error
    return f"{len(tensors)} tensors"


def _check_line(file: Path, line: str) -> None:
    if not line.isprintable() or len(line) > 600:
        raise BrokenPromise(f"said more than a line: {line[:1000]!r}")
    # Errors found only at a shape's placement lack the file's name.
    if not line.startswith((f"{file.name}: ", "shape: ", "shapes")):
        raise BrokenPromise(f"said a line without the file's name: {line}")
    if "fits into memory" in line and file.suffix[1:] not in APART:  # these have separate limits
        raise BrokenPromise(f"wanted over {MEMORY:,} bytes")


def kind_of(line: str) -> str:
    """Return a line without numbers and quotations: lines of equal kind report the same about different files."""
    line = re.sub(r"'[^']*'|\"[^\"]*\"", "'", line.partition(": ")[2] or line)
    line = re.sub(r"could not read it \((\w+).*", r"could not read it \1", line)
    return re.sub(r"got .*", "got", re.sub(r"[-+]?(?:\d[\d,.]*(?:[eE][-+]?\d+)?|nan|inf)", "0", line))[:80]


# ---- Readers in this process -----------------------------------------------------------------------------


def read_here() -> None:
    """Run crashing libraries in this disposable process: starting another one takes seconds."""
    opencascade.call_apart = rhino.call_apart = _call  # type: ignore[assignment]
    apart.SPARE_MEMORY, apart.SPARE_SECONDS = LITTLE


@contextmanager
def limits_kept() -> Iterator[None]:
    """Restore the process' limits afterwards: each reader sets some."""
    kinds = (resource.RLIMIT_DATA, resource.RLIMIT_CPU)
    before = [resource.getrlimit(kind) for kind in kinds]
    try:
        yield
    finally:
        for kind, limits in zip(kinds, before, strict=True):
            resource.setrlimit(kind, limits)


def _call(module: str, function: str, *arguments: str) -> Any:
    """Replace `adapters.apart.call_apart` without a process, with the same errors."""
    try:
        with limits_kept():
            return getattr(sys.modules[module], function)(*arguments)
    except (InputError, MemoryError, RecursionError):
        raise
    except Exception as error:
        raise RuntimeError(f"{type(error).__name__}: {error}") from error


# ---- Files outside ---------------------------------------------------------------------------------------


class Watch:
    """Raises an error at any open of a file outside some folders and Python's files, and at any process start."""

    def __init__(self, folder: Path) -> None:
        self.folder = str(folder.resolve())
        self.on = False
        sys.addaudithook(self._event)

    def _event(self, event: str, values: tuple[Any, ...]) -> None:
        if not self.on:
            return
        if event == "open":
            path, mode = values[0], values[1] or "r"
            inside = isinstance(path, int) or str(Path(path).resolve()).startswith(self.folder)
            if inside or (str(path).startswith(READABLE) and not set(mode) & set("wax+")):
                return
        elif event == "os.remove":
            if str(values[0]).startswith(self.folder):
                return
        elif event not in ("subprocess.Popen", "socket.connect", "os.system", "os.exec"):
            return
        raise BrokenPromise(f"did something outside of its folder: {event} {values}")
