"""Readers that exceed every limit, for separate processes."""

from bobrossnet.adapters import apart


def eat(size):
    apart.limit(int(size))
    return len(bytes(2 * apart.SPARE_MEMORY))


def spin(size):
    apart.SPARE_SECONDS = 0
    apart.limit(int(size))
    while True:
        pass
