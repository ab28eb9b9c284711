"""Other processes at work on the same: doubles of this one, which know all that it knows and give back bytes.

A process is doubled (``fork``) where that is safe: on Linux, while no other thread of Python is at work. Nothing has to
be loaded again. Elsewhere all work is done here. A double says nothing and writes nothing; a signal ends it, and so
does the end of this process.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Sequence
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import TypeVar

Link = Connection
T = TypeVar("T")
SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")


def can_fork() -> bool:
    """Tell whether this process can be doubled."""
    return sys.platform == "linux" and threading.active_count() == 1


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def started(work: Callable[..., None], *words: object) -> tuple[BaseProcess, Link]:
    """Return a double of this process that calls ``work(link, *words)``, and the other end of the link."""
    context = get_context("fork")
    own, other = context.Pipe()
    process = context.Process(target=_alone, args=(work, own, other, words), daemon=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads: those of libraries, which know of forks
        process.start()
    other.close()
    return process, own


def _alone(work: Callable[..., None], parent: Link, link: Link, words: Sequence[object]) -> None:
    parent.close()  # else the end of the parent would not show
    for name in SIGNALS:
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_DFL)
    signal.set_wakeup_fd(-1)
    try:
        work(link, *words)
    except OSError:  # the parent has ended
        return


def received(link: Link) -> bytes | None:
    """Return what comes over a link; None for nothing, and where the other end is closed."""
    try:
        return link.recv_bytes() or None
    except (EOFError, OSError):
        return None


def each(work: Callable[[T], bytes], things: Sequence[T], least: int) -> list[bytes]:
    """Return what some work makes of each of several things, which must not be nothing.

    Parameters
    ----------
    work : callable
        Makes bytes of one; it is called in any process.
    things : sequence
        Each of about the same work.
    least : int
        How many a process must have to be worth its start.
    """
    count = min(cores(), len(things) // least) if can_fork() else 1
    shares = [list(range(first, len(things), count)) for first in range(count)] if count > 1 else []
    doubles = [started(_share, work, [things[at] for at in own]) for own in shares[1:]]
    found: dict[int, bytes] = {}
    try:
        found |= {at: work(things[at]) for at in (shares[0] if shares else range(len(things)))}
        for own, (_, link) in zip(shares[1:], doubles, strict=True):
            for at in own:
                data = received(link)
                found[at] = work(things[at]) if data is None else data  # it has ended, whatever of
    finally:
        for process, link in doubles:
            link.close()
            process.terminate()
            process.join()
    return [found[at] for at in range(len(things))]


def _share(link: Link, work: Callable[[T], bytes], things: Sequence[T]) -> None:
    for one in things:
        try:
            data = work(one)
        except Exception:
            return
        link.send_bytes(data)
