"""Workers of a dask cluster: the same blocks, on any number of machines that reach the store."""

from __future__ import annotations

import time
from collections.abc import Sequence
from concurrent.futures import CancelledError, Future
from typing import Any

from ..core.errors import StoreError, UsageError
from .block import Block, Given, Job, reduce_block

CONNECT = 10.0  # [s]
PATIENCE = 10.0  # [s] that a scheduler, or all of its workers, may be away
AHEAD = 2  # blocks under way for each thread of a worker


class Cluster:
    """Workers of a scheduler.

    Parameters
    ----------
    scheduler : str
        Its address, ``tcp://HOST:8786``.

    Raises
    ------
    UsageError
        ``missing_package``; ``wrong_value`` for what is no address.
    StoreError
        ``no_scheduler``; ``no_workers``.
    """

    def __init__(self, scheduler: str) -> None:
        try:
            import distributed  # noqa: PLC0415 - an extra
        except ModuleNotFoundError as error:
            do = "Type: pip install 'inertialcal[fleet]'"
            raise UsageError(f"--scheduler needs {error.name}", do=do, code="missing_package") from None
        if "://" not in scheduler:
            do = "Write it with its protocol: tcp://HOST:8786"
            raise UsageError(f"--scheduler {scheduler}: no address", do=do, code="wrong_value")
        self.address = scheduler
        package: Any = distributed
        self._killed: type[BaseException] = package.KilledWorker
        try:
            self._client: Any = package.Client(scheduler, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError, ImportError, RuntimeError) as error:
            do = "Start it, and workers of one thread each"
            said = " ".join(str(error).split())[:160]
            raise StoreError(f"no scheduler answers: {said}", scheduler, do=do, code="no_scheduler") from None
        self._away = 0.0
        threads = self._threads()
        if not threads:
            self._client.close()
            do = "Start one, of one thread, for this scheduler"
            raise StoreError("the scheduler has no workers", scheduler, do=do, code="no_workers")
        self.size = AHEAD * threads
        self._executor: Any = self._client.get_executor(pure=False, retries=AHEAD)

    def _threads(self) -> int:
        return sum(int(one["nthreads"]) for one in self._client.scheduler_info(n_workers=-1)["workers"].values())

    def begin(self, job: Job, units: Sequence[Given]) -> Future[Block]:
        """Give a block to one of them."""
        future: Future[Block] = self._executor.submit(reduce_block, job, tuple(units))
        return future

    def is_lost(self, error: BaseException) -> bool:
        """Tell whether an error says that a block has ended as many workers as the scheduler allows.

        Raises
        ------
        StoreError
            ``no_scheduler``, where it says that the scheduler has ended.
        """
        if isinstance(error, CancelledError | OSError):
            raise self._gone("the scheduler does not answer any more", "no_scheduler") from None
        return isinstance(error, self._killed)

    def check(self) -> None:
        """Refuse to go on without a scheduler, or without workers, for longer than it takes to start them again.

        Raises
        ------
        StoreError
            ``no_scheduler``, ``no_workers``.
        """
        running = self._client.status == "running"
        if running and self._threads():
            self._away = 0.0
            return
        self._away = self._away or time.monotonic()
        if time.monotonic() - self._away > PATIENCE:
            if running:
                raise self._gone("the scheduler has no workers any more", "no_workers")
            raise self._gone("the scheduler does not answer any more", "no_scheduler")

    def _gone(self, what: str, code: str) -> StoreError:
        do = "Start it again, then resume: what is done stays done"
        return StoreError(what, self.address, do=do, code=code)

    def close(self) -> None:
        """Leave the cluster to itself."""
        self._client.close(timeout=1.0)
