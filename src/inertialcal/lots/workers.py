"""Blocks given to workers, no more at a time than there are, until each is done: processes here, or a dask cluster.

Workers end when and how they like. A block whose worker has ended is given to another; one that has lost two of them is
under suspicion: its units are tried alone, and what ends its worker twice even then is quarantined. The rest of the
block goes on as before, so that what comes out does not depend on which worker ended when. A block that loses workers
though none of its units does (they are too much for the memory together, or somebody ends processes) is worked on unit
by unit in the end.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, ProcessPoolExecutor, wait
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.connection import wait as wait_for
from multiprocessing.process import BaseProcess
from typing import Protocol

import pyarrow as pa

from ..campaign.engine.processes import SIGNALS, can_fork
from ..procedures import all_quantities, loaded_procedures
from .block import Block, Given, Job, killed, reduce_block

SUSPECT = 2  # workers that a block may lose before its units are tried alone
PROBES = 3  # how often that may find no culprit before the units stay alone
STUCK = 5.0  # [s] that a pool may take to see that one of its processes has ended
LOOK = 0.5  # [s] between two looks at whether the other side is still there
KEPT = {-1: -1, -4: 0}  # parameters of mallopt: M_TRIM_THRESHOLD, never; M_MMAP_MAX, no memory outside of the heap
Done = Callable[[Sequence[Given], Block], None]


@dataclass(frozen=True)
class Task:
    """A block that is to be done."""

    units: tuple[Given, ...]
    lost: int = 0  # Workers, since it was begun or looked through
    probes: int = 0  # How often its units were tried alone, and none was it


class Workers(Protocol):
    """Those who work."""

    @property
    def size(self) -> int:
        """How many blocks may be under way."""
        ...

    def begin(self, job: Job, units: Sequence[Given]) -> Future[Block]:
        """Give a block to one of them."""
        ...

    def is_lost(self, error: BaseException) -> bool:
        """Tell whether an error says that a worker has ended."""
        ...

    def check(self) -> None:
        """Refuse to go on where nobody is there any more.

        Raises
        ------
        StoreError
            ``no_scheduler``.
        """
        ...

    def close(self) -> None:
        """End them."""
        ...


def conduct(workers: Workers, job: Job, blocks: Iterator[tuple[Given, ...]], done: Done) -> None:
    """Have every block done.

    Parameters
    ----------
    workers : Workers
        Who work; they are ended, however this ends.
    job : Job
        The lot.
    blocks : iterator of tuple of Given
        Taken as they are needed.
    done : callable
        Called here with the units of a block and what was made of them, as each is done.
    """
    again: deque[Task] = deque()
    suspects: deque[Task] = deque()
    under_way: dict[Future[Block], Task] = {}
    try:
        while True:
            _begin_more(workers, job, under_way, again, blocks, suspects)
            if suspects and not under_way:  # else nobody could say which block ended a worker
                again.append(_probed(workers, job, suspects.popleft(), done))
                continue
            if not under_way:
                return
            for future in _ended(under_way, workers):
                task = under_way.pop(future)
                if not _is_lost(future, workers):
                    if workers.size > 1:  # first: no worker waits while this one is noted
                        _begin_more(workers, job, under_way, again, blocks, suspects)
                    done(task.units, future.result())
                    continue
                task = replace(task, lost=task.lost + 1)
                if task.lost < SUSPECT:
                    again.append(task)
                elif task.probes < PROBES or len(task.units) == 1:
                    suspects.append(task)
                else:
                    again.extend(Task((one,)) for one in task.units)
    finally:
        workers.close()


def _begin_more(
    workers: Workers,
    job: Job,
    under_way: dict[Future[Block], Task],
    again: deque[Task],
    blocks: Iterator[tuple[Given, ...]],
    suspects: deque[Task],
) -> None:
    """Give blocks to workers who have none; none while there are suspects, which are tried alone."""
    while len(under_way) < workers.size and not suspects:
        task = again.popleft() if again else next((Task(units) for units in blocks), None)
        if task is None:
            return
        under_way[workers.begin(job, task.units)] = task


def _ended(under_way: dict[Future[Block], Task], workers: Workers) -> set[Future[Block]]:
    found, _ = wait(under_way, LOOK, FIRST_COMPLETED)
    if not found:
        workers.check()
    return found


def _is_lost(future: Future[Block], workers: Workers) -> bool:
    """Tell whether a block lost its worker; what else went wrong is raised."""
    try:
        error = future.exception()
    except CancelledError as cancelled:
        error = cancelled
    if error is None:
        return False
    workers.check()
    if workers.is_lost(error):
        return True
    raise error


def _probed(workers: Workers, job: Job, task: Task, done: Done) -> Task:
    """Return a block without the units that end their worker when they are alone, twice; those are done."""
    good: list[Given] = []
    for one in task.units:
        for trial in range(SUSPECT):
            future = workers.begin(job, (one,))
            while not future.done():
                _ended({future: task}, workers)
            if not _is_lost(future, workers):
                good.append(one)
                break
            if trial == SUSPECT - 1:
                done((one,), killed((one,)))
    return Task(tuple(good), 0, task.probes + (len(good) == len(task.units)))


class Processes:
    """Processes of this machine; they end with this one, and are replaced where one ends.

    Parameters
    ----------
    count : int
        How many.
    """

    def __init__(self, count: int) -> None:
        self.size = count
        self._others: set[BaseProcess] = set()  # that were there before the pool
        self._pool: ProcessPoolExecutor | None = None
        self._known: set[BaseProcess] = set()  # that were seen in the pool
        self._short: float | None = None  # since when one of them is missing

    def start(self) -> None:
        """Start them: they load what every lot needs."""
        if self._pool is None:
            self._started()

    def begin(self, job: Job, units: Sequence[Given]) -> Future[Block]:
        """Give a block to one of them."""
        if self._pool is not None:
            with suppress(BrokenExecutor):
                return self._pool.submit(reduce_block, job, tuple(units))
        self._end()
        return self._started().submit(reduce_block, job, tuple(units))

    def _started(self) -> ProcessPoolExecutor:
        """Start a pool; its processes are doubles of this one where that is safe, so that nothing is loaded again."""
        loaded_procedures()
        context = get_context("fork" if can_fork() else "spawn")
        self._others = set(active_children())
        pool = ProcessPoolExecutor(self.size, context, _work_for, (os.getpid(),))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of threads: those of libraries, which know of forks
            pool.submit(os.getpid)  # starts them; where they are no doubles, the first of them
        self._pool, self._known, self._short = pool, set(active_children()) - self._others, None
        return pool

    def is_lost(self, error: BaseException) -> bool:
        """Tell whether an error says that a worker has ended."""
        return isinstance(error, BrokenExecutor)

    def check(self) -> None:
        """Go on: processes are replaced as blocks are begun.

        One that was killed while it sent a block leaves the pool waiting for the rest of it, for the pool holds the
        other end too. It is closed here, by which the pool takes them all for ended.
        """
        living = set(active_children()) - self._others
        self._known |= living
        if self._pool is None or self._known <= living:
            self._short = None
            return
        now = time.monotonic()
        self._short = now if self._short is None else self._short
        if now - self._short > STUCK:
            for one in living:
                with suppress(ValueError, OSError):
                    one.kill()
                one.join()
            with suppress(AttributeError, OSError):
                self._pool._result_queue._writer.close()  # type: ignore[attr-defined]

    def close(self) -> None:
        """End them, whatever they do."""
        self._end()

    def _end(self) -> None:
        if self._pool is None:
            return
        for one in set(active_children()) - self._others:  # all: one that is left would wait for the lock of a dead one
            with suppress(ValueError, OSError):
                one.kill()
        self._pool.shutdown(wait=True, cancel_futures=True)
        self._pool = None


def _work_for(parent: int) -> None:
    """Begin as a worker: signals are the parent's to judge, and its end is the end of this process."""
    for name in SIGNALS:
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN if name == "SIGINT" else signal.SIG_DFL)
    signal.set_wakeup_fd(-1)
    above = parent_process()

    def watch() -> None:
        while above is not None and not wait_for([above.sentinel], LOOK):
            if sys.platform != "win32" and os.getppid() != parent:  # doubles hold each other's ends of pipes
                break
        os._exit(1)

    threading.Thread(target=watch, name="parent", daemon=True).start()
    _keep_memory()
    all_quantities()  # loads what is slow


def _keep_memory() -> None:
    """Keep memory that a block frees for the next one: the system would clear it again, 4 % of the time of a block."""
    if sys.platform == "linux":
        with suppress(AttributeError, OSError):  # another library of C
            allocator = ctypes.CDLL(None)
            for parameter, value in KEPT.items():
                allocator.mallopt(parameter, value)
            pa.set_memory_pool(pa.system_memory_pool())  # the one of Arrow gives back too


class Here:
    """No other process: one block after the other, in that of the caller."""

    size = 1

    def start(self) -> None:
        """Load nothing before it is needed."""

    def begin(self, job: Job, units: Sequence[Given]) -> Future[Block]:
        """Do a block now."""
        future: Future[Block] = Future()
        future.set_result(reduce_block(job, units))
        return future

    def is_lost(self, error: BaseException) -> bool:
        """Tell whether an error says that a worker has ended: none can."""
        return False

    def check(self) -> None:
        """Go on."""

    def close(self) -> None:
        """Nothing is left."""
