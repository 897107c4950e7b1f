"""Objects that threads share, also in a process that was forked while one of them was at work."""

from __future__ import annotations

import os
from threading import Lock, RLock, get_ident
from typing import TYPE_CHECKING, Any
from weakref import WeakSet

from bobrossnet.support.errors import InputError

__all__ = ["Turns", "lazy"]

if TYPE_CHECKING:
    from functools import cached_property as lazy  # which tools take for a property
else:

    class lazy:  # noqa: N801  as property
        """A property that is computed when first asked for and then kept. Another thread that asks waits for the first.

        The lock of functools.cached_property is one for all objects of a class up to Python 3.11, so that no two of
        them are computed at once, and in a forked process it may stay locked for ever.
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
"""The locks of what is being computed."""


class Turns:
    """Lets the threads that use an object take turns.

    Parameters
    ----------
    name : str
        Of the object's class, for messages.

    Raises
    ------
    InputError
        On entering: if the thread is within already, or another one was as this process was forked from its parent,
        which leaves the object half changed.
    """

    def __init__(self, name: str) -> None:
        self._name, self._lock = name, Lock()
        self._user = 0  # a thread
        self._is_broken = False
        _TURNS.add(self)

    def __enter__(self) -> None:
        if self._is_broken:
            raise InputError(
                f"{self._name}: expected one that no other thread used as this process was forked; make another"
            )
        if self._user == get_ident():
            raise InputError(f"{self._name}: expected one call at a time, got another from within its own tracer")
        self._lock.acquire()
        self._user = get_ident()

    def __exit__(self, *_: object) -> None:
        self._user = 0
        self._lock.release()

    def forked(self) -> None:
        """Find out, in a forked process, whether it can still be used."""
        self._is_broken = self._is_broken or (self._lock.locked() and self._user != get_ident())


_TURNS: WeakSet[Turns] = WeakSet()


def _begin_fork() -> None:
    _COMPUTING.clear()
    for turns in list(_TURNS):
        turns.forked()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_begin_fork)
