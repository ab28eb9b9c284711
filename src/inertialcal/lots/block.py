"""A block of units reduced, test by test: the one place where units are worked on, in whatever process that is.

Every unit goes through what a campaign goes through, with its own files, gate and remarks; only the reduction itself is
given all units of the block at once (``Procedure.reduce_many``). What is refused, or breaks down, ends its unit alone.
"""

from __future__ import annotations

import gc
import hashlib
import json
import time
import traceback
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, Literal, TypeVar

from ..campaign.engine.engine import (
    Outlines,
    Prepared,
    open_test,
    order_of,
    placed,
    preparing,
    reduce_alike,
    screened_samples,
)
from ..campaign.engine.reductions import Reduced, waiting_for
from ..campaign.engine.together import Work, ask, together
from ..campaign.engine.whole import Whole, tests_of, whole_of
from ..campaign.file.load import Campaign, campaign_of, standards_of, with_clock
from ..campaign.inputs.gate import Gate
from ..campaign.models.build import model_files_many
from ..campaign.outcome.results_file import sealed
from ..core.errors import DataError, InertialcalError, Problem
from ..core.influence import DIES, OF_UNIT
from ..core.remarks import condensed
from ..core.schema.json_text import json_text
from ..files.binary.curves import curves_bytes
from ..files.binary.parquet import clock_in
from ..files.registry import Columns
from ..files.source import changed_input
from ..signals.blas import one_blas_thread
from ..signals.remembered import looked_at_once
from .rows import UnitRow, quarantined, stream_of
from .stores import Delivery, Place, Shared, UnitStore, file_of

FRAMES = 12  # of a fault that its log holds
Cell = str | int | float | bool
T = TypeVar("T")


@dataclass(frozen=True)
class Job:
    """What all blocks of a lot have in common: plain values, so that any process can be given it.

    Parameters
    ----------
    folder : str
        Of the template.
    raw : bytes
        Its campaign.toml.
    place : Place
        Where recordings lie.
    files : tuple of (str, str or Shared)
        Of each recording, by its name in the campaign.
    options : tuple of (key path, str)
        Keys of the campaign, and the column that stands in place of each.
    archived : bool
        Whether each unit gives what an archive keeps.
    version : str
        Of the code; a worker with another one refuses.
    own : str
        Folder of a unit in the store, as a pattern: what a recording names there, such as its sections, is the unit's.
    """

    folder: str
    raw: bytes
    place: Place
    files: tuple[tuple[str, str | Shared], ...]
    options: tuple[tuple[tuple[str | int, ...], str], ...] = ()
    archived: bool = False
    version: str = ""
    own: str = ""


@dataclass(frozen=True)
class Given:
    """A unit as the table has it: its number from 0, its serial number, and the cells that its reduction depends on."""

    number: int
    serial: str
    cells: tuple[tuple[str, Cell], ...] = ()

    @property
    def texts(self) -> dict[str, str]:
        """Cells as text, by column."""
        return {"serial": self.serial} | {name: str(cell) for name, cell in self.cells}


@dataclass(frozen=True)
class Ended:
    """How a unit ended.

    Parameters
    ----------
    number : int
        In the table.
    status, verdict, reason_code : str
        As its row has them.
    stamps : str
        Size and time of the last change of its files before they were read, as JSON.
    log : str
        Of a fault of the program; empty else.
    results : bytes
        ``results.json`` for an archive; empty where none is asked for, and of a unit in quarantine.
    models : tuple of (str, str)
        Name and text of its model files, for an archive.
    inputs : tuple of (str, str)
        Path and SHA-256, for an archive.
    at_ns : int
        When.
    """

    number: int
    status: Literal["done", "quarantined"]
    verdict: str
    reason_code: str
    stamps: str = ""
    log: str = ""
    results: bytes = b""
    models: tuple[tuple[str, str], ...] = ()
    inputs: tuple[tuple[str, str], ...] = ()
    at_ns: int = 0


@dataclass(frozen=True)
class Block:
    """A block that is done: its rows as an Arrow stream, and how each unit ended, in the same order."""

    rows: bytes
    units: tuple[Ended, ...]


@dataclass(eq=False)
class _Unit:
    """A unit at work."""

    given: Given
    campaign: Campaign
    store: UnitStore
    files: tuple[str, ...] = ()
    stamps: Mapping[str, list[int]] = field(default_factory=dict[str, list[int]])
    gate: Gate = field(default_factory=Gate)
    found: dict[int, Reduced] = field(default_factory=dict[int, Reduced])
    problems: dict[int, tuple[Problem, ...]] = field(default_factory=dict[int, tuple[Problem, ...]])


@lru_cache(maxsize=4)
def _template(folder: str, raw: bytes) -> Campaign:
    return campaign_of(Path(folder), raw, elsewhere=True)


def files_of(job: Job, given: Given) -> dict[str, str]:
    """Return the file of each recording of a unit, in the store.

    Raises
    ------
    DataError
        ``bad_path``, ``outside``.
    """
    root = job.place.store if job.place.is_local else ""
    return {
        name: one.of_unit(given.texts, root).file if isinstance(one, Shared) else file_of(one, given.texts, root)
        for name, one in job.files
    }


def own_files(job: Job, given: Given) -> dict[str, dict[str, str]]:
    """Return what else recordings name that lies in the folder of a unit, such as sections, by recording and key."""
    entries = _template(job.folder, job.raw).file.recordings if job.own else {}
    if not entries:
        return {}
    folder = file_of(job.own, given.texts, job.place.store if job.place.is_local else "").rstrip("/")
    set_by_table = {key for key, _ in job.options}
    named = {
        name: {
            key: f"{folder}/{value}"
            for key, value in entry
            if key != "file" and isinstance(value, str) and value and ("recordings", name, key) not in set_by_table
        }
        for name, entry in entries.items()
    }
    there = job.place.files({path for paths in named.values() for path in paths.values()})
    return {name: {key: path for key, path in paths.items() if path in there} for name, paths in named.items()}


def campaign_for(
    job: Job,
    given: Given,
    files: Mapping[str, str],
    root: Path,
    handed: Mapping[str, Columns] | None = None,
    beside: Mapping[str, Mapping[str, str]] | None = None,
) -> Campaign:
    """Return the campaign of a unit: the template with its serial number, its files and what the table changes.

    Raises
    ------
    PlanError
        If what the table says cannot stand there.
    """
    cells = dict(given.cells)
    changes: dict[tuple[str | int, ...], Any] = {
        key: given.serial if column == "serial" else cells[column]
        for key, column in job.options
        if column in cells or column == "serial"
    }
    own = campaign_of(Path(job.folder), job.raw, True, changes) if changes else _template(job.folder, job.raw)
    item = own.file.item.model_copy(update={"serial": given.serial})
    more = beside or {}
    entries = {
        name: one.model_copy(update={**more.get(name, {}), "file": files[name]})
        for name, one in own.file.recordings.items()
    }
    file = own.file.model_copy(update={"item": item, "recordings": entries})
    recordings = (entry.file for entry in entries.values() if entry.channels)
    known = handed or {}
    timed = with_clock(file, (known[one][0].clock if one in known else clock_in(root / one) for one in recordings))
    standards = own.standards if timed is file else standards_of(timed, lambda *key: "")[0]
    return replace(own, folder=root, file=timed, standards=standards)


@contextmanager
def _uncollected() -> Iterator[None]:
    """Look for no unreachable objects meanwhile: each look goes through all that there is, modules and units alike."""
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


@_uncollected()
@one_blas_thread()
@looked_at_once()
def reduce_block(job: Job, units: Sequence[Given]) -> Block:
    """Return a block of units reduced; no unit ends another.

    Parameters
    ----------
    job : Job
        The lot.
    units : sequence of Given
        Of the block, in the order of the table.
    """
    ended: dict[int, tuple[UnitRow, Ended]] = {}
    shared = {name: one for name, one in job.files if isinstance(one, Shared)}
    with Delivery(job.place, shared) as delivery:
        cells = {one.number: one.texts for one in units}
        refused = delivery.load_shared(cells) if shared else {}
        working = []
        for one in units:
            try:
                if one.number in refused:
                    raise refused[one.number]
                working.append(_begun(job, one, delivery))
            except Exception as error:
                ended[one.number] = _quarantined(one, error)
        _reduce(working, ended)
        left = [unit for unit in working if unit.given.number not in ended]
        now = job.place.stamps(tuple(dict.fromkeys(file for unit in left for file in unit.files)))
        for unit, found in zip(left, together([_finished(job, unit, now) for unit in left]), strict=True):
            number = unit.given.number
            ended[number] = _quarantined(unit.given, found, unit) if isinstance(found, Exception) else found
    made = [ended[one.number] for one in units]
    return _block([row for row, _ in made], [one for _, one in made])


def _begun(job: Job, given: Given, delivery: Delivery) -> _Unit:
    files = files_of(job, given)
    beside = own_files(job, given)
    every = tuple(dict.fromkeys((*files.values(), *(path for paths in beside.values() for path in paths.values()))))
    shared = {file for name, file in files.items() if isinstance(dict(job.files)[name], Shared)}
    own = [one for one in every if one not in shared]
    stamps = job.place.stamps(every)
    delivery.lay_out(given.number, own)
    root = delivery.root(given.number)
    handed = delivery.handed.get(given.number, {})
    campaign = campaign_for(job, given, files, root, handed, beside)
    store = UnitStore(Path(job.folder), waiting_for(campaign), root=root, handed=handed, alike=delivery.alike)
    return _Unit(given, campaign, store, every, stamps)


def _reduce(working: Sequence[_Unit], ended: dict[int, tuple[UnitRow, Ended]]) -> None:
    """Reduce every test of all units, those of one number together."""
    template = working[0].campaign.file.tests if working else []
    places = {one.id: number for number, one in enumerate(template)}
    outlines: Outlines = {}
    for number in order_of(template):
        before = {name: places[name] for name in template[number].after}
        going = [
            (unit, {name: unit.found[place].result for name, place in before.items()})
            for unit in working
            if unit.given.number not in ended and all(one in unit.found for one in before.values())
        ]
        works = [_preparing(unit, number, results, outlines) for unit, results in going]
        ready = []
        for (unit, results), prepared in zip(going, together(works), strict=True):
            with _apart(unit, number, ended):
                ready.append((unit, results, _sound(prepared)))
        found = reduce_alike([one for _, _, one in ready]) if ready else []
        for (unit, results, prepared), reduced in zip(ready, found, strict=True):
            with _apart(unit, number, ended):
                result = _sound(reduced)
                count = screened_samples(prepared, result)
                opened = open_test(unit.campaign, prepared, count, results, unit.store, unit.gate) if count else None
                unit.found[number] = Reduced(prepared, result, opened, "")


def _preparing(unit: _Unit, number: int, results: Mapping[str, Any], outlines: Outlines) -> Work[Prepared]:
    """Work out a test of a unit, ready to be reduced; what no other test of it reads is let go."""
    recordings = unit.campaign.file.recordings
    files = [recordings[name].file for name in unit.campaign.file.tests[number].recordings]
    read = partial(unit.store.leave, files)
    return preparing(unit.campaign, number, results, unit.store, unit.gate, outlines=outlines, when_read=read)


def _sound(found: T | Exception) -> T:
    """Return what was found; raise the error that is in its place."""
    if isinstance(found, Exception):
        raise found
    return found


@contextmanager
def _apart(unit: _Unit, number: int, ended: dict[int, tuple[UnitRow, Ended]]) -> Iterator[None]:
    """Keep what goes wrong in a test of a unit from the others: a refusal is noted, a fault of the program ends it."""
    try:
        yield
    except InertialcalError as error:
        unit.problems[number] = tuple(placed(one, unit.campaign, number) for one in error.problems)
    except Exception as error:
        ended[unit.given.number] = _quarantined(unit.given, error, unit)


def _finished(job: Job, unit: _Unit, now: Mapping[str, list[int]]) -> Work[tuple[UnitRow, Ended]]:
    """Work out the row of a unit whose tests were reduced: models, verdicts, remarks.

    ``now``: stamps of all files as they are after that.
    """
    given = unit.given
    prepared, tested = yield from tests_of(unit.campaign, unit.found, unit.problems)
    whole = yield from whole_of(unit.campaign, prepared, tested)
    changed = [changed_input(one) for one in unit.files if now.get(one) != unit.stamps.get(one)]
    if changed:
        raise DataError(changed)
    figures, verdict = whole.figures, whole.verdict
    models: tuple[tuple[str, str], ...] = ()
    if whole.modelled is not None:
        models = tuple(sorted((yield from ask(model_files_many, whole.modelled)).items()))
    inputs = tuple(sorted((path, one) for path, one in whole.inputs.items() if path in unit.files))
    remarks = [(one.test.id, remark) for one in whole.tested for remark in condensed(one.remarks)]
    if whole.modelled is not None:
        closed = condensed(remark for one in whole.modelled.every for remark in one.remarks)
        remarks += [("closed loop", remark) for remark in closed]
    row = UnitRow(
        given.number,
        given.serial,
        "done",
        verdict,
        figures.found,
        figures.verdicts,
        remarks,
        models,
        inputs,
        shares=frozenset(
            name for name, one in unit.campaign.standards.items() if one.redrawn_by not in (*OF_UNIT, *DIES)
        ),
    )
    kept = _for_archive(whole) if job.archived else b""
    stamps = json.dumps(unit.stamps, sort_keys=True)
    more = {"results": kept, "models": models, "inputs": tuple(sorted(whole.inputs.items()))} if kept else {}
    return row, Ended(given.number, "done", verdict, "", stamps, at_ns=time.time_ns(), **more)  # type: ignore[arg-type]


def _for_archive(whole: Whole) -> bytes:
    """Return the ``results.json`` of a unit, as `run` writes it."""
    results = sealed(whole.results, curves_bytes(whole.results["curves"]))
    return json_text({name: part for name, part in results.items() if name != "curves"}).encode()


def _quarantined(given: Given, error: Exception, unit: _Unit | None = None) -> tuple[UnitRow, Ended]:
    """Return the row of a unit that was refused, or in which the program failed."""
    log = ""
    if isinstance(error, InertialcalError):
        problems = list(error.problems)
    else:
        said = " ".join(str(error).split())[:200]
        what = f"internal error ({type(error).__name__}: {said}): this is a fault of inertialcal, not of the recordings"
        problems = [Problem(what, do=f"Send {log_name(given.number)} with its recordings", code="internal")]
        log = "".join(traceback.format_exception(error, limit=-FRAMES))
    if unit is not None:
        prefix = f"{unit.campaign.folder}/"
        problems = [replace(one, what=one.what.replace(prefix, ""), where=one.where.removeprefix(prefix))
                    for one in problems]  # fmt: skip
    stamps = json.dumps({} if unit is None else unit.stamps, sort_keys=True)
    row = quarantined(given.number, given.serial, list(dict.fromkeys(problems)))
    return row, Ended(given.number, "quarantined", "", row.reason_code, stamps, log, at_ns=time.time_ns())


def log_name(number: int) -> str:
    """Return the name of the log of a fault of the program in a unit, in the folder of the lot."""
    return f"logs/unit-{number:05d}.txt"


def killed(units: Sequence[Given]) -> Block:
    """Return the rows of units that ended their process each time they were tried alone."""
    what = "the process that reduced this unit ended twice without a word"
    why = "memory that ran out, or a library that failed, leaves no reason"
    do = "Look at its recordings: are they far longer than those of other units?"
    problems = [Problem(what, "", why, do, "worker_killed")]
    rows = [quarantined(one.number, one.serial, problems) for one in units]
    now = time.time_ns()
    return _block(rows, [Ended(one.number, "quarantined", "", "worker_killed", "{}", at_ns=now) for one in units])


def _block(rows: Sequence[UnitRow], ended: Sequence[Ended]) -> Block:
    return Block(stream_of(rows), tuple(ended))


def unit_key(given: Given) -> str:
    """Return by what a unit is known from one run of a lot to the next: its serial number and what its reduction needs.

    Patterns, options and the campaign are those of the lot; they stand in the digest of the lot.
    """
    text = json.dumps([given.serial, *given.cells], sort_keys=True, default=str)
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()
