"""Windows and Pyodide, simulated on Linux: the package's modules see only features of these systems.

    python tests/systems.py win32 -c CODE

Only imports of the package itself are simulated. Python's modules and other packages keep all of Linux.
"""

from __future__ import annotations

import builtins
import errno
import os
import signal
import socket
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

FOLDER = str(Path(__file__).parent)

MISSING_MODULES = {
    "win32": {"fcntl", "grp", "posix", "pty", "pwd", "readline", "resource", "syslog", "termios", "tty"},
    "emscripten": {
        "_multiprocessing",
        "_posixshmem",
        "concurrent.futures.process",
        "curses",
        "fcntl",
        "grp",
        "multiprocessing",
        "pty",
        "readline",
        "resource",
        "syslog",
        "termios",
    },
}

WINDOWS_SIGNALS = {"SIGABRT", "SIGBREAK", "SIGFPE", "SIGILL", "SIGINT", "SIGSEGV", "SIGTERM"}
SIGBREAK = signal.SIGUSR1
"""Simulates SIGBREAK, which Linux lacks."""

EXCLUSIVE = socket.SO_KEEPALIVE
"""Simulates SO_EXCLUSIVEADDRUSE, which Linux lacks."""

# Python's documentation marks these as Unix only; of the constants, all except Windows' are.
WINDOWS_OPEN = {"O_APPEND", "O_CREAT", "O_EXCL", "O_RDONLY", "O_RDWR", "O_TRUNC", "O_WRONLY"}
UNIX_CALLS = """chown fchmod fchown fork forkpty get_blocking getegid geteuid getgid getloadavg getpgid getpriority
    getsid getuid killpg lchown lockf mkfifo mknod nice pathconf pipe2 posix_spawn pread pwrite register_at_fork
    sched_getaffinity sendfile set_blocking setgid setpgid setpriority setsid setuid statvfs sync sysconf uname wait
    wait3 wait4 waitid"""
PROCESS_CALLS = "fork forkpty kill killpg pipe2 posix_spawn register_at_fork sched_getaffinity wait waitpid"


class _Stand(ModuleType):
    """A module with replaced or missing attributes."""

    def __init__(self, real: ModuleType, missing: Any = (), **other: Any) -> None:
        super().__init__(real.__name__)
        self.__dict__.update(_real=real, _missing=frozenset(missing), **other)

    def __getattr__(self, name: str) -> Any:
        if name in self._missing:
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r} here")
        return getattr(self._real, name)

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(self._real, name, value)


def play(system: str) -> None:
    """Make later imports of the package see `system`, "win32" or "emscripten"."""
    real_import = builtins.__import__
    stands = _windows() if system == "win32" else _emscripten()
    stands["sys"] = _Stand(sys, platform=system)

    def found(name: str, globals: Any = None, locals: Any = None, fromlist: Any = (), level: int = 0) -> Any:
        if level == 0 and str((globals or {}).get("__name__")).partition(".")[0] == "bobrossnet":
            if name in MISSING_MODULES[system]:
                raise ModuleNotFoundError(f"No module named {name!r}", name=name)
            if name in stands:
                return stands[name]
        return real_import(name, globals, locals, fromlist, level)

    builtins.__import__ = found
    if system == "win32":
        _refuse_open_files()
        _have_children_play(system)


def _windows() -> dict[str, ModuleType]:
    import ctypes

    def set_signal(sent: int, handler: Any) -> Any:
        if sent not in known:
            raise ValueError("invalid signal value")
        return signal.signal(sent, handler)

    def kill(*_: Any) -> None:
        raise AssertionError("os.kill: ends a process at once, whatever the signal")

    def library(name: str | None, *arguments: Any) -> Any:
        if name is None:
            raise TypeError("LoadLibrary() argument 1 must be str, not None")
        raise FileNotFoundError(errno.ENOENT, "Could not find module", name)

    known = {SIGBREAK, *(getattr(signal, name) for name in WINDOWS_SIGNALS if hasattr(signal, name))}
    constants = {name for name in dir(os) if name.startswith(("O_", "W")) and name.isupper()} - {"W_OK"}
    unix = {*UNIX_CALLS.split(), *constants - WINDOWS_OPEN}
    lost = {name for name in dir(signal) if name.startswith("SIG") and name[3:4] != "_"} - WINDOWS_SIGNALS
    calls = {"alarm", "pause", "pthread_kill", "pthread_sigmask", "setitimer", "sigwait", "siginterrupt"}
    return {
        "os": _Stand(os, unix, name="nt", O_BINARY=0, kill=kill),
        "signal": _Stand(signal, lost | calls, SIGBREAK=SIGBREAK, signal=set_signal),
        "socket": _Stand(socket, {"AF_UNIX", "SO_REUSEPORT", "socketpair"}, SO_EXCLUSIVEADDRUSE=EXCLUSIVE),
        "ctypes": _Stand(ctypes, CDLL=library),
    }


def _emscripten() -> dict[str, ModuleType]:
    import concurrent.futures
    import subprocess
    import threading

    def start(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOTSUP, "emscripten does not support processes.")

    class Thread(threading.Thread):
        def start(self) -> None:
            raise RuntimeError("can't start new thread")

    class Pool(concurrent.futures.ThreadPoolExecutor):
        def submit(self, *_: Any, **__: Any) -> Any:
            raise RuntimeError("can't start new thread")

    return {
        "os": _Stand(os, PROCESS_CALLS.split(), cpu_count=lambda: 1),
        "subprocess": _Stand(subprocess, Popen=start, run=start),
        "threading": _Stand(threading, Thread=Thread),
        "concurrent.futures": _Stand(concurrent.futures, {"ProcessPoolExecutor"}, ThreadPoolExecutor=Pool),
    }


def _refuse_open_files() -> None:
    """Refuse to remove or replace files that this process has open."""

    def check(path: Any, folder: int | None = None) -> None:
        if folder is not None:
            path = os.path.join(os.readlink(f"/proc/self/fd/{folder}"), path)
        there = os.path.realpath(path)
        for handle in os.listdir("/proc/self/fd"):
            if os.path.realpath(f"/proc/self/fd/{handle}") == there:
                raise PermissionError(errno.EACCES, "The process cannot access the file", os.fspath(path))

    def removing(real: Any) -> Any:
        def remove(path: Any, *, dir_fd: int | None = None) -> None:
            check(path, dir_fd)
            real(path, dir_fd=dir_fd)

        return remove

    def moving(real: Any) -> Any:
        def move(source: Any, target: Any, **options: Any) -> None:
            check(source)
            check(target)
            real(source, target, **options)

        return move

    os.unlink, os.remove = removing(os.unlink), removing(os.remove)  # type: ignore[assignment]
    os.replace, os.rename = moving(os.replace), moving(os.rename)  # type: ignore[assignment]


def _have_children_play(system: str) -> None:
    """Simulate in child processes, too; multiprocessing's children run this file again."""
    from bobrossnet.adapters import reader

    begin = f"import sys; sys.path.insert(0, {FOLDER!r}); import systems; systems.play({system!r}); "
    reader.COMMAND = reader.COMMAND.replace("from bobrossnet", f"{begin}from bobrossnet")


if __name__ in ("__main__", "__mp_main__"):
    if __name__ == "__main__":
        os.environ["PLAYED"] = sys.argv[1]  # inherited by the processes of multiprocessing
    play(os.environ["PLAYED"])
    if __name__ == "__main__":
        code, sys.argv = sys.argv[3], ["-c", *sys.argv[4:]]
        exec(compile(code, "CODE", "exec"), {"__name__": "code"})
