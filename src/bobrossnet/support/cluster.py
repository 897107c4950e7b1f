"""Calls on a Dask cluster, yielded as they finish."""

from __future__ import annotations

import logging
import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from importlib.util import find_spec
from itertools import islice
from typing import Any

from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import one_line

ANSWER_SECONDS = 10
"""Timeout of a scheduler's answer in seconds; at a wrong address, waiting would never end."""


def check_address(scheduler: str) -> str:
    """Return an address, [PROTOCOL://]HOST:PORT; raise InputError for other texts, before the import of Dask."""
    if not re.fullmatch(r"(\w+://)?(\[[^]/]+\]|[^:/\s]+):\d+", scheduler):
        raise InputError(
            f"scheduler: expected a Dask scheduler's address, got {scheduler!r}; "
            "it has a host and a port, as tcp://127.0.0.1:8786"
        )
    return scheduler


def check_scheduler(scheduler: str) -> None:
    """Raise InputError unless a Dask scheduler answers at an address."""
    import asyncio  # takes a tenth of the time of all imports

    check_address(scheduler)
    _check_dask()
    with ThreadPoolExecutor(1) as pool:  # a notebook's thread already runs a loop
        try:
            pool.submit(asyncio.run, asyncio.wait_for(_reach(scheduler), timeout=ANSWER_SECONDS)).result()
        except (OSError, ValueError, asyncio.TimeoutError) as error:
            why = one_line(error) or f"no answer in {ANSWER_SECONDS} seconds"
            raise InputError(f"scheduler: expected a Dask scheduler's address, got {scheduler!r}: {why}") from error


def _check_dask() -> None:
    if find_spec("distributed") is None:  # its import takes two seconds
        raise InputError("scheduler: expected Dask here, found none: pip install 'bobrossnet[cluster]'")


@contextmanager
def connected(scheduler: str | None) -> Iterator[Any]:
    """Provide a client of a Dask scheduler. If it is None, start one in this process, with a thread for each core.

    Raises
    ------
    InputError
        If no scheduler answers at the address, or Dask is not installed.
    """
    if scheduler is not None:
        check_address(scheduler)
    _check_dask()
    from distributed import Client, LocalCluster

    if scheduler is not None:
        check_scheduler(scheduler)
        with Client(scheduler) as client:
            yield client
        return
    # Failures arrive with their results; the log adds only its reaction to Ctrl-C.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with (
        LocalCluster(
            n_workers=1, threads_per_worker=os.cpu_count() or 1, processes=False, dashboard_address=":0"
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client


async def _reach(scheduler: str) -> None:
    """Return if a Dask scheduler answers; a client without one can't be closed, and may block later clients."""
    from distributed import Security
    from distributed.core import connect

    comm = await connect(scheduler, **Security().get_connection_args("client"))
    await comm.close()


def as_done(
    client: Any, function: Callable[..., Any], arguments: Sequence[tuple[Any, ...]]
) -> Iterator[tuple[int, Any]]:
    """Yield the index and the future of each call as it finishes, in any order.

    Only slightly more calls are submitted than can run, so that pending results do not fill the memory.
    """
    from distributed import as_completed

    window = 2 * sum(client.nthreads().values())
    calls: Iterable[tuple[int, tuple[Any, ...]]] = iter(enumerate(arguments))
    index_of = {}

    def submit(count: int) -> list[Any]:
        futures = []
        for index, call in islice(calls, count):
            future = client.submit(function, *call, pure=False)
            index_of[future.key] = index
            futures.append(future)
        return futures

    done = as_completed(submit(max(window, 2)))
    for future in done:
        yield index_of.pop(future.key), future
        done.update(submit(1))
