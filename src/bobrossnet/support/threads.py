"""Work of two threads, and objects shared by threads, also in a process forked while one of them was working."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Sequence
from threading import Lock, RLock, Thread, get_ident
from typing import TYPE_CHECKING, Any
from weakref import WeakSet

from bobrossnet import _core
from bobrossnet.support.errors import InputError

__all__ = ["Turns", "lazy", "together"]

if TYPE_CHECKING:
    from functools import cached_property as lazy  # type checkers know it as a property
else:

    class lazy:  # noqa: N801  as property
        """A cached property, computed at first use; other threads wait for the first one.

        Up to Python 3.11, functools.cached_property has one lock for all objects of a class, so that no two are
        computed at once, and the lock may stay held forever in a forked process.
        """

        def __init__(self, compute):
            self._compute, self.__doc__ = compute, compute.__doc__

        def __set_name__(self, owner, name):
            self._name = name

        def __get__(self, instance, owner=None):
            if instance is None:
                return self
            values, key = instance.__dict__, (id(instance), self._name)
            turn = _COMPUTING.setdefault(key, RLock())
            with turn:
                try:
                    if self._name in values:
                        return values[self._name]
                    return values.setdefault(self._name, self._compute(instance))
                finally:
                    if _COMPUTING.get(key) is turn:
                        del _COMPUTING[key]


_COMPUTING: dict[tuple[int, str], Any] = {}
"""Locks of properties being computed."""


class Turns:
    """Lets threads use an object one at a time.

    Parameters
    ----------
    name : str
        Name of the object's class, for error messages.

    Raises
    ------
    InputError
        On entry: if this thread holds the object already, or if another thread held it when this process was forked,
        which leaves it half changed.
    """

    def __init__(self, name: str) -> None:
        self._name, self._lock = name, Lock()
        self._user = 0  # identifier of the current thread, or 0
        self._is_broken = False
        _TURNS.add(self)

    def __enter__(self) -> None:
        if self._is_broken:
            raise InputError(f"{self._name}: expected one that was idle when this process was forked; make another")
        if self._user == get_ident():
            raise InputError(f"{self._name}: expected one call at a time, got another from within its own tracer")
        self._lock.acquire()
        self._user = get_ident()

    def __exit__(self, *_: object) -> None:
        self._user = 0
        self._lock.release()

    def forked(self) -> None:
        """In a forked process, mark the object as broken if another thread held it."""
        self._is_broken = self._is_broken or (self._lock.locked() and self._user != get_ident())


def together(calls: Sequence[Callable[[], Any]]) -> list[Any]:
    """Return the results of calls, in their order: this thread makes them from the first on, another from the last on.

    Each uses the core's threads, but also has parts for one thread. An exception, such as Ctrl-C in this thread, ends
    both without waiting for the other's current call.
    """
    waiting = deque(enumerate(calls))
    results: list[Any] = [None] * len(waiting)
    failures: list[Exception] = []

    def work(take: Callable[[], tuple[int, Callable[[], Any]]]) -> None:
        while True:
            try:
                i, call = take()
            except IndexError:  # all are taken
                return
            results[i] = call()

    def help_out() -> None:
        try:
            work(waiting.pop)
        except Exception as error:
            failures.append(error)
            waiting.clear()

    other = Thread(target=help_out, daemon=True)
    if _core.thread_count() > 1:
        other.start()
    try:
        work(waiting.popleft)
    finally:
        waiting.clear()
    if other.ident is not None:
        other.join()
    if failures:
        raise failures[0]
    return results


_TURNS: WeakSet[Turns] = WeakSet()


def _begin_fork() -> None:
    _COMPUTING.clear()
    for turns in list(_TURNS):
        turns.forked()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_begin_fork)
