"""Reduce a lot: every unit of a table by one campaign, into one folder.

``OUT/units/part-00000.parquet``, ... hold a row a unit in the order of the table, and ``OUT/lot.json`` says what they
are; both are put in place when all units are done, and hold no clock times. ``OUT/ledger.sqlite`` holds what is done,
so that a lot that was cut off goes on.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property, partial
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from ..campaign.engine.cache import code_digest
from ..campaign.engine.processes import cores
from ..campaign.engine.status import EXIT
from ..core.errors import DataError, InertialcalError, PlanError, Problem, StoreError, UsageError
from ..core.interruption import interruption
from ..core.remarks import Remark
from ..core.show.result_tables import remarks_line
from ..core.show.tables import Block as Part
from ..core.show.tables import Table, html, text
from .block import Block, Given, Job, files_of, log_name, unit_key
from .ledger import FILE, Ledger, Noted
from .lot_file import Lot, SharedFile, load_lot
from .stores import COLUMN, Place, Shared
from .workers import Here, Processes, Workers, conduct

if TYPE_CHECKING:
    from pandas import DataFrame

    from .archiving import LotArchive
    from .study import Study

MOST, SHARES = 100, 8  # units that are worked on together; blocks that a small lot is parted in
FEWER, HEAVY = 50, 50_000_000  # the most of units with much to read: more bytes of recordings would be together
SMALL, LIGHT = (200, 32), 1_000_000  # the same of units with little to read: so many bytes of recordings together
NEVER_KEPT = frozenset({"unreachable", "worker_killed"})  # reasons that say nothing of the recordings: tried again
SECOND = 1.0  # between two lines of progress
FEW = 10  # units in quarantine that are shown
Tell = Callable[[int, int, str], None]


@dataclass(frozen=True, eq=False)
class LotOutcome:
    """What a lot gave.

    Parameters
    ----------
    folder : Path
        Of its files.
    content : dict
        Of ``lot.json``.
    remarks : tuple of Remark
        What reading it and its statistics brought up, and what could not be made of it.
    redone : int
        Units that were reduced now.
    kept : int
        Units that were done before.
    """

    folder: Path
    content: dict[str, object]
    remarks: tuple[Remark, ...] = ()
    redone: int = 0
    kept: int = 0
    archived: int = 0  # Units that an archive did not have
    statistics: Study | None = None  # Over the units; nothing where these failed

    @property
    def counts(self) -> Mapping[str, int]:
        """Units: in all, ``done``, ``quarantined``, and by verdict."""
        found: Mapping[str, int] = self.content["counts"]  # type: ignore[assignment]
        return found

    @property
    def exit_status(self) -> int:
        """3 where a unit, statistics or report failed; else 1 for a FAIL, 4 for one that is INCONCLUSIVE, 0."""
        if self.counts["quarantined"] or any(one.severity == "error" for one in self.remarks):
            return 3
        return next((EXIT[one] for one in ("FAIL", "INCONCLUSIVE") if self.counts[one]), 0)

    @cached_property
    def units(self) -> dict[str, list[object]]:
        """A row a unit, by column: number, serial, status, reason_code, reason, verdict, and the table of units."""
        from .publish import read_units_of  # noqa: PLC0415 - reads all parts

        return read_units_of(self.folder, self.content)

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a unit; its figures stand in the column ``results`` of the files."""
        from ..core.show.frames import frame  # noqa: PLC0415 - starts slowly

        return frame(self.units)

    def parts(self) -> tuple[Part, ...]:
        """Return what is shown: how the units ended, and the first in quarantine."""
        counts = self.counts
        rows = [(name, str(counts[name])) for name in ("units", "done", "PASS", "FAIL", "INCONCLUSIVE", "quarantined")]
        shown: list[Part] = [Table(("", "units"), rows, f"lot {self.content['id']}: {self.folder}", (0,))]
        reasons: Mapping[str, int] = self.content["quarantined"]  # type: ignore[assignment]
        if reasons:
            columns = self.units
            every = zip(columns["serial"], columns["reason_code"], columns["reason"], strict=True)
            first = [(str(serial), str(code), str(reason)) for serial, code, reason in every if code][:FEW]
            caption = "in quarantine: " + ", ".join(f"{n} {code}" for code, n in reasons.items())
            shown.append(Table(("serial", "code", "reason"), first, caption, (0, 1, 2)))
        return (*shown, *(self.statistics.parts() if self.statistics is not None else ()))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text((*self.parts(), *remarks_line(self.remarks)))

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html((*self.parts(), *remarks_line(self.remarks)))


def lot(
    path: str | Path,
    output: str | Path,
    resume: bool = False,
    workers: int | None = None,
    scheduler: str = "",
    archive: str = "",
    progress: Tell | None = None,
    report: bool = True,
) -> LotOutcome:
    """Reduce every unit of a lot.

    Parameters
    ----------
    path : path
        LOT.toml or its folder, or a folder with campaign.toml and a folder a unit.
    output : path
        Folder for what is made.
    resume : bool
        Go on with the lot in that folder: what is done and has not changed is kept.
    workers : int, optional
        Processes; one for each core if not given. 0 works in this process.
    scheduler : str
        Address of a dask scheduler whose workers take the place of processes.
    archive : str
        Address of an archive that each unit is added to.
    progress : callable, optional
        Called with (units done, units in all, what there is to say).
    report : bool
        Write ``report.html``, which takes a few seconds.

    Returns
    -------
    LotOutcome
        Counts, remarks, exit status; the figures stand in the files.

    Raises
    ------
    PlanError, DataError
        If LOT.toml, the campaign or the table of units is wrong. A unit that is refused is quarantined instead.
    UsageError
        ``not_empty`` for a folder that holds something; ``wrong_value``; ``missing_package``.
    StoreError
        If the folder or the archive cannot be written, or the scheduler ends; what is done stays done.
    """
    if workers is not None and workers < 0:
        raise UsageError(f"workers: {workers}", do="Give 1 or more, or 0 for none", code="wrong_value")
    read = load_lot(path)
    folder = Path(output)
    _begin(folder, resume)
    kept = _archive_of(archive, folder) if archive else None
    return _Lot(read, folder, kept, progress or (lambda done, total, what: None), report).reduced(workers, scheduler)


def _archive_of(where: str, folder: Path) -> LotArchive:
    from ..archive import open_archive  # noqa: PLC0415

    open_archive(where)  # refused where its packages are missing, which the next line imports
    from .archiving import LotArchive as Opened  # noqa: PLC0415 - of an extra

    return Opened(where, folder)


def _begin(folder: Path, resume: bool) -> None:
    """Make the folder, or refuse one that is not this lot's to write.

    Raises
    ------
    UsageError
        ``not_empty``.
    StoreError
        ``not_writable``.
    """
    try:
        there = any(folder.iterdir()) if folder.exists() else False
        if there and not resume:
            do = "Name a new folder, or resume the lot there"
            raise UsageError(f"{folder} is not empty", do=do, code="not_empty")
        if there and not (folder / FILE).is_file():
            do = "Name the folder of the lot, or begin a new one"
            raise UsageError(f"{folder} holds no lot that could go on", do=do, code="not_empty")
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StoreError(f"cannot write into {folder}: {error.strerror}", code="not_writable") from None


@dataclass(eq=False)
class _Lot:
    """A lot at work."""

    lot: Lot
    folder: Path
    archive: LotArchive | None
    tell: Tell
    report: bool = True
    started: float = field(default_factory=time.monotonic)
    at_once: int = 0  # Units that all workers do at a time
    counted_from: tuple[float, int] = (0.0, 0)  # When, and units done then: what the time left is told by
    told: float = 0.0
    done: int = 0
    quarantined: int = 0
    redone: int = 0
    added: int = 0

    @cached_property
    def job(self) -> Job:
        """What all blocks have in common."""
        file = self.lot.file
        files = {
            name: Shared(one.file, one.serial, tuple(one.match.items())) if isinstance(one, SharedFile) else one
            for name, one in self.lot.files.items()
        }
        options = tuple((self.lot.changes[key], column) for key, column in file.options.items())
        place = Place(self.lot.store, file.endpoint, file.region)
        if place.is_local:
            place = Place(str(Path(place.store).resolve()))
        template = str(self.lot.template.folder.resolve())
        named = tuple(files.items())
        return Job(template, self.lot.raw, place, named, options, bool(self.archive), code_digest(), file.folder)

    @cached_property
    def given(self) -> list[Given]:
        """Every unit."""
        names = [name for name in self.lot.columns if name != "serial"]
        columns = [self.lot.units.cells(name) for name in names]
        found = []
        for number, serial in enumerate(self.lot.units.serials):
            cells = ((name, column[number]) for name, column in zip(names, columns, strict=True))
            kept = tuple((name, cell if isinstance(cell, str | int | float) else str(cell))
                         for name, cell in cells if cell is not None)  # fmt: skip
            found.append(Given(number, serial, kept))
        return found

    @cached_property
    def keys(self) -> list[str]:
        """By which each unit is known in the ledger.

        Raises
        ------
        PlanError
            ``duplicate_unit`` for two rows that mean the same unit and the same files.
        """
        keys = [unit_key(one) for one in self.given]
        first: dict[str, int] = {}
        problems = []
        for number, key in enumerate(keys):
            if (before := first.setdefault(key, number)) != number:
                serial = self.given[number].serial
                what = f"unit {serial!r} stands in rows {before + 1} and {number + 1}, with the same files"
                do = "Delete one; a unit that was tested twice needs files of its own for each time"
                problems.append(Problem(what, self.lot.file.units, "it would count twice", do, "duplicate_unit"))
        if problems:
            raise PlanError(problems[:FEW])
        return keys

    def reduced(self, workers: int | None, scheduler: str) -> LotOutcome:
        """Reduce what is missing, then write the files."""
        who: Workers = self._workers(workers, scheduler)  # processes load what they need while the lot is looked at
        try:
            return self._reduced(who, scheduler)
        finally:
            who.close()

    def _reduced(self, who: Workers, scheduler: str) -> LotOutcome:
        from .publish import publish_lot  # noqa: PLC0415 - starts slowly: processes load meanwhile

        keys = self.keys
        if not self.job.place.is_local:
            self.job.place.stamps([self.lot.file.units])  # refused at once
        if not (self.folder / FILE).is_file():
            self._check_there()
        interruption.note(self.folder, complete=False, then="Go on with it by --resume")
        ledger = Ledger(self.folder)
        try:
            known = self._known(ledger)
            missing = [number for number, key in enumerate(keys) if key not in known]
            self.done = len(keys) - len(missing)
            self.quarantined = sum(one.status == "quarantined" for one in known.values())
            if missing:
                self.at_once = who.size * self.block
                self._say(f"{len(missing)} of {len(keys)} units to reduce")
                conduct(who, self.job, self._blocks(missing), partial(self._note, ledger))
            self._to_archive(ledger)
            self._say("writing")
            ledger.sweep()
            noted = ledger.units()
            with interruption.held():
                content, statistics, failed = publish_lot(
                    self.folder,
                    self.lot,
                    self.job.version,
                    [noted[key] for key in keys],
                    ledger,
                    {"workers": who.size, "scheduler": scheduler, "archive": self.archive.name if self.archive else ""},
                    self.report,
                )
            interruption.note(self.folder)
        finally:
            ledger.close()
        return LotOutcome(
            self.folder,
            content,
            (*self.lot.remarks, *failed, *(statistics.remarks if statistics is not None else ())),
            self.redone,
            len(keys) - self.redone,
            self.added,
            statistics,
        )

    def _workers(self, workers: int | None, scheduler: str) -> Workers:
        if scheduler:
            from .cluster import Cluster  # noqa: PLC0415 - of an extra

            if workers is not None:
                what, do = "workers and a scheduler", "A cluster has its own workers: leave their number out"
                raise UsageError(f"{what}: one of them", do=do, code="wrong_value")
            return Cluster(scheduler)
        count = cores() if workers is None else workers
        units = len(self.lot.units.serials)
        found = Processes(min(count, -(-units // max(1, min(MOST, units // SHARES))))) if count else Here()
        found.start()
        return found

    @cached_property
    def block(self) -> int:
        """Units that are worked on together; no figure depends on it. What few bytes tell is read fastest by many."""
        n, (most, shares) = len(self.given), SMALL
        usual, larger = max(1, min(MOST, n // SHARES)), min(most, n // shares)
        if usual <= FEWER and larger <= usual:
            return usual
        size = self._bytes_of_unit() or LIGHT
        if usual * size > HEAVY:
            usual = min(usual, FEWER)
        return max(usual, min(larger, int(LIGHT / size)))

    def _bytes_of_unit(self) -> float:
        """Return how large the recordings of a unit are, as they lie: a file of several units is shared among them."""
        total, n = 0.0, len(self.given)
        for name, one in self.job.files:
            columns = COLUMN.findall(one.file if isinstance(one, Shared) else one)
            cells = [] if "serial" in columns else [one.texts for one in self.given] if columns else [{}]
            files = len({tuple(map(texts.get, columns)) for texts in cells}) or n
            some: set[str] = set()
            for unit in self.given[:FEW]:
                with suppress(InertialcalError):  # a bad path is the unit's own
                    some.add(files_of(self.job, unit)[name])
            sizes = [size for size, _ in self.job.place.stamps(list(some)).values()]
            total += sum(sizes) / max(len(sizes), 1) * files / n
        return total

    def _known(self, ledger: Ledger) -> dict[str, Noted]:
        """Return what is done and holds: of the same campaign, code and inputs.

        Raises
        ------
        DataError
            ``missing_file`` where no recording of what is done is there any more: it is not thrown away for that.
        """
        before = [one for one in ledger.units().values() if one.status == "done" and one.stamps]
        if before and not any(self.job.place.stamps(list(one.stamps)) for one in before):
            what = f"none of the recordings of the {len(before)} units that are done is there any more"
            do = "Put them back where the lot finds them. What is done stands as it was"
            raise DataError(what, self.job.place.store, "no unit could be reduced again", do, "missing_file")
        digest = sha256(f"{self.lot.digest()} {self.job.version}".encode()).hexdigest()
        if ledger.said("of", digest) != digest:
            ledger.forget_all()
        ledger.say("of", digest)
        noted, waiting = ledger.units(), ledger.waiting()
        archive = self.archive
        found = {}
        for one, key in zip(self.given, self.keys, strict=True):
            known = noted.get(key)
            if known is None or known.reason_code in NEVER_KEPT:
                continue
            if archive is not None and known.status == "done" and archive.name != known.archived and key not in waiting:
                continue
            if known.stamps and self.job.place.stamps(list(known.stamps)) != known.stamps:
                continue
            if known.status == "quarantined" and self._now_there(one, known):
                continue
            found[key] = known
        return found

    def _check_there(self) -> None:
        """Refuse a lot in which no unit has a recording that a test needs: a path in LOT.toml is wrong, not every unit.

        Raises
        ------
        DataError
            ``missing_file``.
        """
        sought = {name for test in self.lot.template.file.tests for name in test.recordings}
        for first in range(0, len(self.given), MOST):
            files: dict[str, set[str]] = {name: set() for name in sought}
            for one in self.given[first : first + MOST]:
                with suppress(InertialcalError):  # a bad path is the unit's own
                    for name, file in files_of(self.job, one).items():
                        files.get(name, set()).add(file)
            there = self.job.place.files(set().union(*files.values()))
            sought -= {name for name, own in files.items() if own & there}
            if not sought:
                return
        problems = []
        for name in sorted(sought):
            of = self.lot.files[name]
            what = f"recording {name}: no unit has {of if isinstance(of, str) else of.file}"
            do = f"Correct files.{name} in LOT.toml, or put the recordings there"
            problems.append(Problem(what, self.job.place.store, "every unit would be refused", do, "missing_file"))
        raise DataError(problems)

    def _now_there(self, given: Given, known: Noted) -> bool:
        """Whether files are there now that were not when a unit was refused."""
        try:
            files = list(dict.fromkeys(files_of(self.job, given).values()))
        except Exception:
            return False
        return bool(self.job.place.stamps(files).keys() - known.stamps.keys())

    def _blocks(self, missing: Sequence[int]) -> Iterator[tuple[Given, ...]]:
        """Yield what is missing block by block; a unit is always in the same block."""
        blocks: dict[int, list[Given]] = {}
        for number in missing:
            blocks.setdefault(number // self.block, []).append(self.given[number])
        yield from (tuple(units) for units in blocks.values())

    def _note(self, ledger: Ledger, units: Sequence[Given], block: Block) -> None:
        if not units:
            return
        with interruption.held():
            ledger.note([self.keys[one.number] for one in units], block)
        for one in block.units:
            if one.log:
                path = self.folder / log_name(one.number)
                path.parent.mkdir(exist_ok=True)
                path.write_text(one.log, encoding="utf-8", newline="\n")
        self.done += len(units)
        self.redone += len(units)
        self.quarantined += sum(one.status == "quarantined" for one in block.units)
        self._to_archive(ledger)
        total, now = len(self.given), time.monotonic()
        if self.counted_from[1] == 0 and self.redone >= self.at_once:
            self.counted_from = now, self.redone  # the first block of each worker takes longer: it loads, or compiles
        if self.done == total or now - self.told > SECOND:
            self.told = now
            since, before = self.counted_from if 0 < self.counted_from[1] < self.redone else (self.started, 0)
            left = (now - since) / (self.redone - before) * (total - self.done)
            self._say(f"units, {_span(left)} left" + f", {self.quarantined} in quarantine" * (self.quarantined > 0))

    def _to_archive(self, ledger: Ledger) -> None:
        if self.archive is not None:
            with interruption.held():
                self.added += self.archive.take(ledger)

    def _say(self, what: str) -> None:
        self.tell(self.done, len(self.given), what)


def _span(seconds: float) -> str:
    """Return a time left as people say it."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    return f"{whole // 60} min {whole % 60} s" if whole < 3600 else f"{whole // 3600} h {whole % 3600 // 60} min"
