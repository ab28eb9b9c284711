"""Tests of a campaign reduced: each taken from the cache where it is there, else worked out, on all cores.

A test is what its entry, its recordings, its sensors and the site say, what its files hold, and what the test before it
found. Whether it was worked out here, by another process, or a week ago: what goes on from here has been written as
bytes and read back, so that it is the same in each case.
"""

from __future__ import annotations

import secrets
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from hashlib import sha256
from multiprocessing.connection import wait
from typing import Any, cast

from ...core.errors import InertialcalError, Problem
from ...files.binary.objects import NotStorableError, decode, encode
from ...files.budget import size_on_disk
from ...procedures import procedure_of
from ...procedures.protocol import Result
from ...procedures.recorded import QUANTITIES as RECORDED
from ..file.load import Campaign
from ..file.test_checks import counts_twice
from ..inputs.gate import Gate
from ..inputs.sources import ReadOnce, Store
from .cache import Cache, packages
from .engine import Opened, Prepared, open_test, order_of, placed, prepare, reduce_test, screened_samples
from .processes import Link, can_fork, cores, received, started
from .status import Progress

KIND = "test"
WORTH_IT = 2**20  # bytes of recordings from which a second process is quicker than one
ELSEWHERE = {
    "requirements",
    "tests",
    "recordings",
    "model",
    "decision",
    "certificate",
}  # parts that a reduction does not see
FIELDS = tuple(one.name for one in fields(Prepared) if one.name != "test")


@dataclass(frozen=True, eq=False)
class Reduced:
    """A test that was reduced.

    Parameters
    ----------
    prepared : Prepared
        What was read.
    result : Result
        What was found.
    opened : Opened or None
        With the samples that screening left out, where it left any out.
    sha256 : str
        Of all of that as bytes; a number of chance where it has not been written.
    absent : tuple of str
        Files that were looked for and were not there.
    """

    prepared: Prepared
    result: Result
    opened: Opened | None
    sha256: str
    absent: tuple[str, ...] = ()


def reduce_all(
    campaign: Campaign, store: Store, tell: Progress, cache: Cache | None = None
) -> tuple[dict[int, Reduced], dict[int, tuple[Problem, ...]]]:
    """Return the tests that could be reduced, by number, and why the others could not.

    A test that comes after one which was refused is in neither.

    Parameters
    ----------
    campaign : Campaign
        As read.
    store : Store
        That holds its files.
    tell : callable
        Called with (tests done, tests in all, what comes next).
    cache : Cache, optional
        Where reductions are kept; without one nothing is, and all work is done here.
    """
    work = _Work(campaign, store, tell, cache)
    try:
        while work.waiting:
            work.go_on()
    finally:
        work.dismiss()
    return work.found, work.problems


@dataclass(eq=False)
class _Work:
    """What is done of a campaign, and what is not."""

    campaign: Campaign
    store: Store
    tell: Progress
    cache: Cache | None
    found: dict[int, Reduced] = field(default_factory=dict[int, Reduced])
    problems: dict[int, tuple[Problem, ...]] = field(default_factory=dict[int, tuple[Problem, ...]])
    keys: dict[int, str] = field(default_factory=dict[int, str])
    workers: list[_Worker] | None = None  # None before it is known whether they are worth it
    here: set[int] = field(default_factory=set[int])  # Tests that a worker has given back
    gate: Gate = field(default_factory=Gate)

    def __post_init__(self) -> None:
        self.waiting = order_of(self.campaign.file.tests)
        self.total = len(self.waiting)
        self.numbers = {one.id: number for number, one in enumerate(self.campaign.file.tests)}

    def go_on(self) -> None:
        """Take a step: a test is found in the cache, left out, given to a worker, come back from one, or reduced."""
        ready = list(self._ready())
        if self.workers is None and ready:
            self.workers = self._hired()
        given = {one.number for one in self.workers or ()}
        for number in (one for one in ready if one not in given):
            is_done_here = not self.workers or number in self.here
            worker = None if is_done_here else self._worker_for(number)
            if worker is None and not is_done_here:
                continue  # the one that holds its files is at work
            self.tell(len(self.found), self.total, self.campaign.file.tests[number].id)
            if worker is None:
                self._reduce(number)
                return
            worker.begin(number, self._results(number))
        self._gather()

    def _ready(self) -> Iterator[int]:
        """Yield the tests that can be reduced now; those that are kept already are found on the way."""
        for number in list(self.waiting):
            test = self.campaign.file.tests[number]
            before = [self.numbers[name] for name in test.after]
            if any(one not in self.found and one not in self.waiting for one in before):
                self.waiting.remove(number)  # what it comes after was refused, which says why
            elif all(one in self.found for one in before):
                if number in self.keys or not self._is_kept(number):
                    yield number
                else:
                    self.tell(len(self.found), self.total, test.id)

    def _is_kept(self, number: int) -> bool:
        """Take a test from the cache; tell whether it was there. If not, its files are looked at before it is read."""
        if self.cache is None:
            return False
        self.keys[number] = key = self._key(number, self.cache)
        kept = self.cache.get(KIND, key)
        if kept is not None:
            try:
                self._add(number, _read(self.campaign, number, kept))
            except ValueError:  # written by a program that calls itself this one
                kept = None
        for file in _files(self.campaign, number) if kept is None else ():
            self.cache.contents.of(file)
        return kept is not None

    def _key(self, number: int, cache: Cache) -> str:
        file, test = self.campaign.file, self.campaign.file.tests[number]
        recordings = {name: file.recordings[name].model_dump() for name in test.recordings}
        asked = any(one.quantity in RECORDED for one in file.requirements)
        twice = any(counts_twice(file, test, one) for one in file.tests)
        before = [self.found[self.numbers[name]].sha256 for name in test.after]
        rest = repr((file.model_dump(exclude=ELSEWHERE), test.model_dump(), recordings, asked, twice, before))
        return cache.key(str(self.campaign.folder), bool(self.campaign.sha256), rest)

    def _results(self, number: int) -> dict[str, Result]:
        return {name: self.found[self.numbers[name]].result for name in self.campaign.file.tests[number].after}

    def _reduce(self, number: int) -> None:
        try:
            one = reduce(self.campaign, number, self._results(number), self.store, self.gate)
        except InertialcalError as error:
            self.problems[number] = tuple(placed(problem, self.campaign, number) for problem in error.problems)
            self.waiting.remove(number)
            return
        if self.cache is None:
            self._add(number, one)
            return
        try:
            data = as_bytes(one)
        except NotStorableError:
            self._keep(number, one, None)
        else:
            self._keep(number, _read(self.campaign, number, data), data)

    def _keep(self, number: int, one: Reduced, data: bytes | None) -> None:
        """Add a test that was worked out, and keep it for the next run."""
        if self.cache is not None:
            inputs = self.cache.contents.as_read(one.prepared.inputs, one.absent)
            self.cache.put(KIND, self.keys[number], inputs, data)
        self._add(number, one)

    def _add(self, number: int, one: Reduced) -> None:
        self.found[number] = one
        self.waiting.remove(number)

    # ---- other processes --------------------------------------------------------------------------------------

    def _hired(self) -> list[_Worker]:
        """Start as many processes as there are cores and groups of tests; none where one process is as quick."""
        groups = _groups(self.campaign, self.waiting)
        count = min(cores(), len({*groups.values()}))
        files = {file for number in self.waiting for file in _files(self.campaign, number)}
        size = sum(size_on_disk(self.campaign.folder / file) for file in files)
        if self.cache is None or count < 2 or size < WORTH_IT or not can_fork():
            return []
        for one in self.campaign.file.tests:
            procedure_of(one.procedure)  # loaded once, for all
        self.groups, self.of_group = groups, dict[int, _Worker]()
        return [_Worker(self.campaign, self.store) for _ in range(count)]

    def _worker_for(self, number: int) -> _Worker | None:
        """Return the worker that holds the files of a test, else any; None where it is busy, or there is none."""
        if not self.workers:
            return None
        group = self.groups[number]
        if group not in self.of_group:
            free = next((one for one in self.workers if one.number is None), None)
            if free is not None:
                self.of_group[group] = free
            return free
        own = self.of_group[group]
        return own if own.number is None else None

    def _gather(self) -> None:
        """Wait for the next worker that is done."""
        busy = {one.link: one for one in self.workers or () if one.number is not None}
        for link in wait(list(busy)) if busy else ():
            worker = busy[link]  # type: ignore[index]
            number, data = worker.end()
            if data is None:
                self.here.add(number)  # refused: the same again here says why
            else:
                self._keep(number, _read(self.campaign, number, data), data)

    def dismiss(self) -> None:
        """End the processes that were started."""
        for one in self.workers or ():
            one.dismiss()


class _Worker:
    """A process that reduces tests, one after the other; it knows all that its parent knew at its start."""

    def __init__(self, campaign: Campaign, store: Store) -> None:
        self.number: int | None = None
        self.process, self.link = started(_serve, campaign, store)

    def begin(self, number: int, results: Mapping[str, Result]) -> None:
        """Give it a test, and what was found by those that it comes after."""
        self.number = number
        try:
            self.link.send_bytes(encode((number, dict(results)), packages()))
        except (OSError, NotStorableError):
            self.process.terminate()

    def end(self) -> tuple[int, bytes | None]:
        """Return the test it had, and what it made of it; None where it was refused, or the process has ended."""
        assert self.number is not None  # noqa: S101 - who asks has seen that it was at work
        number, self.number = self.number, None
        return number, received(self.link)

    def dismiss(self) -> None:
        """End it, whatever it does."""
        self.link.close()
        self.process.terminate()
        self.process.join()


def _serve(link: Link, campaign: Campaign, store: Store) -> None:
    """Reduce tests until the other end is closed."""
    gate = Gate()
    while (task := received(link)) is not None:
        number, results = cast("tuple[int, dict[str, Result]]", decode(task, packages()))
        try:
            data = as_bytes(reduce(campaign, number, results, store, gate))
        except Exception:
            data = b""
        link.send_bytes(data)


def _files(campaign: Campaign, number: int) -> list[str]:
    """Return the files of the recordings of a test."""
    return [campaign.file.recordings[name].file for name in campaign.file.tests[number].recordings]


def waiting_for(campaign: Campaign) -> Counter[str]:
    """Return how many tests read each file."""
    return Counter(file for number in range(len(campaign.file.tests)) for file in {*_files(campaign, number)})


def _groups(campaign: Campaign, numbers: Sequence[int]) -> dict[int, int]:
    """Return tests with the number of their group: those that share a file, also by way of others, are in one."""
    groups = {number: number for number in numbers}
    first: dict[str, int] = {}
    for number in numbers:
        for file in _files(campaign, number):
            known = groups[first.setdefault(file, number)]
            old = groups[number]
            groups = {one: known if group == old else group for one, group in groups.items()}
    return groups


def reduce(campaign: Campaign, number: int, results: Mapping[str, Result], store: Store, gate: Gate) -> Reduced:
    """Return a test reduced.

    Parameters
    ----------
    campaign : Campaign
        As read.
    number : int
        Of the test.
    results : mapping of str to Result
        Of those that it comes after, by name.
    store : Store
        That holds its files.
    gate : Gate
        That knows columns which other tests read.

    Raises
    ------
    InertialcalError
        If it is refused.
    """
    prepared = prepare(campaign, number, results, store, gate)
    result = reduce_test(prepared)
    count = screened_samples(prepared, result)
    opened = open_test(campaign, prepared, count, results, store, gate) if count else None
    absent: tuple[str, ...] = ()
    if isinstance(store, ReadOnce):
        store.leave(_files(campaign, number))
        absent = tuple(sorted(store.absent))
    return Reduced(prepared, result, opened, secrets.token_hex(), absent)


def as_bytes(one: Reduced) -> bytes:
    """Return a test that was reduced as bytes, without its entry in the campaign.

    Raises
    ------
    NotStorableError
        If a package that adds to this one has made something that has no such form.
    """
    return encode(([getattr(one.prepared, name) for name in FIELDS], one.result, one.opened, one.absent), packages())


def _read(campaign: Campaign, number: int, data: bytes) -> Reduced:
    kept = cast("tuple[list[Any], Result, Opened | None, tuple[str, ...]]", decode(data, packages()))
    parts, result, opened, absent = kept
    prepared = Prepared(campaign.file.tests[number], **dict(zip(FIELDS, parts, strict=True)))
    return Reduced(prepared, result, opened, sha256(data).hexdigest(), absent)
