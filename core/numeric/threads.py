"""Work on several items at once: numpy and scipy let other threads run while they compute."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import islice
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

# More threads wait for the memory more than they compute.
_MOST = 4


def in_threads(function: Callable[[Item], Result], items: Iterable[Item], threads: int) -> Iterator[Result]:
    """Results of a function for each of some items, in their order.

    Items are taken in the caller's thread, each when a thread is free for it, so that no more than ``threads`` of them
    are in memory beside the results.

    Parameters
    ----------
    function : callable
        Changes nothing that another call looks at.
    items : iterable
    threads : int
        At least 1; no more than `_MOST` are used.
    """
    threads = min(threads, _MOST)
    if threads < 2:
        yield from map(function, items)
        return
    source = iter(items)
    with ThreadPoolExecutor(threads) as pool:
        running: deque[Future[Result]] = deque(pool.submit(function, item) for item in islice(source, threads))
        while running:
            result = running.popleft().result()
            running.extend(pool.submit(function, item) for item in islice(source, 1))
            yield result
