"""Readers for separate processes: some exceed every limit, others tell of their process."""

import sys

from bobrossnet.adapters import apart


def eat(size):
    apart.limit(int(size))
    return len(bytes(2 * apart.SPARE_MEMORY))


def spin(size):
    apart.SPARE_SECONDS = 0
    apart.limit(int(size))
    while True:
        pass


def imported():
    """Return the modules of this process."""
    return [*sys.modules]
