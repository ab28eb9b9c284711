"""Shares of one large job on all cores, with the same result whatever their number.

The caller cuts the job into shares that do not depend on the number of cores, and joins the results in their order.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Thread
from typing import TypeVar

Share = TypeVar("Share")
Found = TypeVar("Found")

LARGE = 2**19  # samples from which threads pay
SHARE = 2**20  # samples of a share of a long record


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def pays(n: int) -> bool:
    """Return whether two jobs, each on n samples, are worth a thread of their own."""
    return n >= LARGE and cores() > 1


def shares(n: int) -> list[tuple[int, int]]:
    """Return first and stop of each share of n samples, in order: one of a short record."""
    return [(first, min(first + SHARE, n)) for first in range(0, max(n, 1), SHARE)]


def side_by_side(one: Callable[[], Share], other: Callable[[], Found], n: int) -> tuple[Share, Found]:
    """Return what two functions return that look at n samples each: at the same time, where that pays."""
    if not pays(n):
        return one(), other()
    with ThreadPoolExecutor(1) as pool:
        later = pool.submit(other)
        return one(), later.result()


def each_of(function: Callable[[Share], Found], shares: Sequence[Share], size: int) -> list[Found]:
    """Return the function of each share, in order; at once where the job is large.

    Parameters
    ----------
    function : callable
        Spends its time in compiled code that lets other threads run.
    shares : sequence
        What it is called with.
    size : int
        Samples that all shares look at together.
    """
    workers = min(cores(), len(shares))
    if size < LARGE or workers < 2:
        return [function(share) for share in shares]
    left, found, failed = deque(enumerate(shares)), dict[int, Found](), dict[int, Exception]()

    def work() -> None:
        while left:
            try:
                place, share = left.popleft()
            except IndexError:  # another took the last
                return
            try:
                found[place] = function(share)
            except Exception as error:  # raised again below
                failed[place] = error

    others = [Thread(target=work) for _ in range(workers - 1)]
    for one in others:
        one.start()
    try:
        work()  # as the others do, rather than wait for them
    finally:
        left.clear()
        for one in others:
            one.join()
    if failed:
        raise failed[min(failed)]
    return [found[place] for place in range(len(shares))]
