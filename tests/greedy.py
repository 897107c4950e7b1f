"""Readers for separate processes: some exceed every limit, others tell of their process."""

import os
import sys
from functools import partial

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


def shared(crash):
    """Return the process of each of twenty calls; every second one may crash."""
    return apart.divided([partial(_process, crash == "crash" and i % 2 == 1, i) for i in range(20)])


def _process(crash, i):
    if crash:
        os.abort()
    return i, os.getpid()
