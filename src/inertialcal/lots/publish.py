"""What a lot writes: ``units/part-00000.parquet``, ..., ``lot.json``, ``provenance.json``.

The parts are built aside. ``lot.json`` goes first and comes last: where it stands, it is that of the parts beside it.
The parts stand before statistics and report are begun, so that neither can take them away.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import shutil
import traceback
from array import array
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import lru_cache, partial
from itertools import groupby
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from ..campaign.engine.processes import cores
from ..campaign.outcome.publish import version_of_package, versions
from ..core.errors import DataError, InertialcalError, Problem, StoreError
from ..core.key import AXES
from ..core.remarks import Remark
from ..core.schema.json_text import json_text
from .ledger import Ledger, Noted
from .lot_file import COLUMN, Lot
from .rows import OWN, quarantined, stream_of
from .study import Columns, Study, study
from .table import Figures, figures_of, table_of_figures

FEW = 5  # pairs of units, frames of a fault that are told
LOT, UNITS, PROVENANCE = "lot.json", "units", "provenance.json"
NEW = "units.new"
REPORT = "report.html"
PLACES, FACTORS = ("tested", "time"), ("position", "operator")  # columns, where LOT.toml does not say
PART = 200  # units in a file: whole blocks
GROUP = 50  # units in a row group, or as many times that as stay below
MANY = 10_000  # figures of them: what is in memory at a time
UNLIKE = frozenset({"json", "value", "u", "lo", "hi"})  # cells of lists: no two units have the same
WRITERS = 2  # of files at a time
VERDICTS = ("PASS", "FAIL", "INCONCLUSIVE")
SHOWN = ("number", "serial", "status", "reason_code", "reason", "verdict")


def publish_lot(
    folder: Path,
    lot: Lot,
    version: str,
    noted: Sequence[Noted],
    ledger: Ledger,
    how: Mapping[str, object],
    report: bool = True,
) -> tuple[dict[str, object], Study | None, tuple[Remark, ...]]:
    """Write the parts, the report and ``lot.json``, in place of what stands there.

    Where statistics or report fail, the parts and ``lot.json`` stand all the same, and a remark says what is missing.

    Parameters
    ----------
    folder : Path
        Of the lot.
    lot : Lot
        As read.
    version : str
        Of the code.
    noted : sequence of Noted
        Every unit, in the order of the table.
    ledger : Ledger
        That has their rows.
    how : mapping
        Of the run, for ``provenance.json``.
    report : bool
        Write ``report.html`` too.

    Returns
    -------
    tuple of (dict, Study or None, tuple of Remark)
        Content of ``lot.json``, the statistics, and what failed.

    Raises
    ------
    StoreError
        ``not_writable``; what stands there stays.
    """
    try:
        new = folder / NEW
        shutil.rmtree(new, ignore_errors=True)
        new.mkdir()
        noted, instead, copies = _without_copies(lot, ledger, noted, how.get("archive"))
        with ThreadPoolExecutor(min(cores(), WRITERS)) as pool:
            work = partial(_part, new, lot, ledger, noted, instead)
            written = list(pool.map(work, range(0, len(noted), PART)))
        parts = [one.content for one in written]
        (folder / LOT).unlink(missing_ok=True)
        shutil.rmtree(folder / UNITS, ignore_errors=True)
        os.replace(new, folder / UNITS)
        said = {"made": datetime.now(UTC).isoformat(timespec="seconds"), "versions": versions(),
                "machine": {"system": platform.system(), "machine": platform.machine()},
                "lot": str(lot.path.resolve()), **how}  # fmt: skip
        _write(folder / PROVENANCE, json_text(said))
        (folder / REPORT).unlink(missing_ok=True)
        failed: list[Remark] = []
        found, statistics, page = None, None, ""
        with _told(failed, "statistics", folder):
            found = _study(lot, written)
            statistics = found.content()
        if report and statistics is not None and found is not None:
            with _told(failed, "report", folder):
                from .page import lot_page  # noqa: PLC0415 - draws, which starts slowly

                page = lot_page(found, lot.file.id, lot.file.title)
        if page:
            _write(folder / REPORT, page)
        content: dict[str, object] = {
            "format": "inertialcal-lot", "schema": 1, "id": lot.file.id, "title": lot.file.title,
            "version": version_of_package(), "code": version,
            "template": {"id": lot.template.file.campaign.id, "sha256": lot.template.sha256},
            "units": {"columns": lot.units.names, "sha256": lot.units.sha256},
            "counts": counts(noted),
            "quarantined": dict(sorted(Counter(one.reason_code for one in noted if one.reason_code).items())),
            "parts": parts,
            "statistics": statistics,
            "remarks": [one.to_dict() for one in (*lot.remarks, *copies, *failed)],
        }  # fmt: skip
        _write(folder / LOT, json_text(content))
    except OSError as error:
        raise StoreError(f"cannot write into {folder}: {error.strerror}", code="not_writable") from None
    return content, None if statistics is None else found, (*copies, *failed)


@contextmanager
def _told(failed: list[Remark], what: str, folder: Path) -> Iterator[None]:
    """Turn what fails into a remark, with its log beside the parts."""
    try:
        yield
    except Exception as error:
        log = f"logs/{what}.txt"
        said = " ".join(str(error).split())[:200]
        text = f"no {what}: {said}"
        if not isinstance(error, InertialcalError):
            text = f"no {what}: internal error ({type(error).__name__}: {said}), a fault of inertialcal"
        (folder / log).parent.mkdir(exist_ok=True)
        _write(folder / log, "".join(traceback.format_exception(error, limit=-FEW)))
        do = f"The figures of all units stand in {UNITS}/. Send {log}, then resume the lot: no unit is reduced again"
        failed.append(Remark(f"no_{what}", "error", text, do=do))


def _study(lot: Lot, parts: Sequence[_Part]) -> Study:
    for one in parts:
        if one.failed is not None:
            raise one.failed
    return study(table_of_figures([some for one in parts for some in one.figures]), line_of(lot))


def _without_copies(
    lot: Lot, ledger: Ledger, noted: Sequence[Noted], archive: object
) -> tuple[list[Noted], dict[int, bytes], tuple[Remark, ...]]:
    """Put units in quarantine of which a recording is that of another unit: of what it was tested, nobody knows.

    Of two tests of one unit, the later one. Recordings without readings of a sensor, such as the log of a chamber, may
    be those of several units; so may be a file that the table gives to several rows, or whose channels it tells apart.

    Returns
    -------
    tuple of (list of Noted, dict of int to bytes, tuple of Remark)
        The units as they ended; rows that stand in place of those of the ledger, by number; what is said of them.
    """
    pairs = _copies(lot, ledger, noted)
    if not pairs:
        return list(noted), {}, ()
    serials = lot.units.serials
    said: dict[int, tuple[int, str]] = {}  # unit in quarantine: the one whose recording it has, and its file
    for before, number, of_before, of_number in pairs:
        said.setdefault(number, (before, of_number))
        if serials[before] != serials[number]:
            said.setdefault(before, (number, of_before))
    found, rows = list(noted), dict[int, bytes]()
    for number, (other, path) in sorted(said.items()):
        row = quarantined(number, serials[number], [_copied(serials[number], serials[other], path)])
        found[number] = replace(noted[number], status="quarantined", verdict="", reason_code=row.reason_code)
        rows[number] = stream_of([row])
    every = list(dict.fromkeys((serials[one], serials[two]) for one, two, *_ in pairs))
    told = ", ".join(f"{one} and {two}" if one != two else f"two tests of {one}" for one, two in every[:FEW])
    more = f" and {len(every) - FEW} more" if len(every) > FEW else ""
    what = f"the same recording, byte for byte, of several units: {told}{more}"
    kept = ". The archive has the figures that they gave" if archive else ""
    do = f"One was copied over the other: test them again{kept}"
    return found, rows, (Remark("same_recording", "warning", what, count=len(every), do=do),)


def _copies(lot: Lot, ledger: Ledger, noted: Sequence[Noted]) -> list[tuple[int, int, str, str]]:
    """Return pairs of units that have a recording of one of them in common, the earlier one first, and their files."""
    marks = array("Q", (int(digest[:16], 16) for *_, digest in _readings(lot, ledger, noted)))  # 8 bytes of each
    every, counts = np.unique(np.frombuffer(marks, np.uint64), return_counts=True)
    twice = {int(one) for one in every[counts > 1]}
    pairs = list[tuple[int, int, str, str]]()
    first: dict[str, tuple[int, str, str]] = {}
    for number, source, path, digest in _readings(lot, ledger, noted) if twice else ():
        if int(digest[:16], 16) in twice:
            before, other, of_before = first.setdefault(digest, (number, source, path))
            if other != source and before != number:  # two that are alike in one unit are for its own gate to judge
                pairs.append((before, number, of_before, path))
    return pairs


def _readings(lot: Lot, ledger: Ledger, noted: Sequence[Noted]) -> Iterator[tuple[int, str, str, str]]:
    """Yield the recordings of units that hold their own readings: number, file or rows of a file, file, SHA-256."""
    told_apart = {key[1] for key in lot.changes.values() if key[0] == "recordings" and "channels" in key}
    entries = lot.template.file.recordings
    own = [
        lot.files[name]
        for name, one in entries.items()
        if name not in told_apart and (one.channels is None or any(axis in one.channels for axis in AXES))
    ]
    of_many = _any_of([one.file for one in own if not isinstance(one, str)])
    plain = _any_of([one for one in own if isinstance(one, str)])
    read = lru_cache(maxsize=4)(lambda block: _table(ledger.rows(block), [OWN.index("inputs")])[0].to_pylist())
    for number, one in enumerate(noted):
        for path, digest in map(dict.values, read(one.block)[one.place]):
            if of_many.fullmatch(path):
                yield number, f"{lot.units.serials[number]}\0", path, digest
            elif plain.fullmatch(path):
                yield number, path, path, digest


def _copied(serial: str, other: str, path: str) -> Problem:
    if serial == other:
        what, why = "it is that of an earlier test of this unit, byte for byte", "one test was not made"
        return Problem(what, path, why, do="Test it again, or leave this row out", code="same_recording")
    what = f"it is that of {other}, byte for byte"
    why = "one was copied over the other: nobody knows which unit was tested"
    return Problem(what, path, why, do="Test both again", code="same_recording")


def _any_of(patterns: Sequence[str]) -> re.Pattern[str]:
    """Return what the files of some patterns match."""
    return re.compile("|".join("[^/]*".join(map(re.escape, COLUMN.split(one)[::2])) for one in patterns) or "(?!)")


def line_of(lot: Lot) -> Columns:
    """Return the columns that say where and when units were tested: as LOT.toml has them, else those of usual names."""
    said, names = lot.file.line, lot.units.names
    if said is not None:
        return Columns(said.station, said.place, tuple(said.factors))
    place = next((one for one in PLACES if one in names), "")
    return Columns("station" if "station" in names else "", place, tuple(one for one in FACTORS if one in names))


def _write(path: Path, text: str) -> None:
    new = path.with_name(f"{path.name}.new")
    new.write_text(text, encoding="utf-8", newline="\n")
    os.replace(new, path)


def counts(noted: Sequence[Noted]) -> dict[str, int]:
    """Return how many units there are, by how they ended."""
    ended = Counter(one.status for one in noted)
    verdicts = Counter(one.verdict for one in noted)
    return {"units": len(noted), "done": ended["done"], "quarantined": ended["quarantined"]} | {
        name: verdicts[name] for name in VERDICTS
    }


@dataclass(frozen=True, eq=False)
class _Part:
    """A file of units that is written: what ``lot.json`` says of it, its figures, and what finding them raised."""

    content: dict[str, object]
    figures: tuple[Figures, ...]
    failed: Exception | None


def _part(
    new: Path, lot: Lot, ledger: Ledger, noted: Sequence[Noted], instead: Mapping[int, bytes], first: int
) -> _Part:
    """Write the rows of the units from one on."""
    last = min(first + PART, len(noted))
    name = f"part-{first // PART:05d}.parquet"
    columns = line_of(lot)
    names = [one for one in (columns.station, columns.place, *columns.factors) if one]
    figures: list[Figures] = []
    failed: Exception | None = None
    with ExitStack() as stack:
        writer: pq.ParquetWriter | None = None
        for table in _groups(lot, ledger, noted, instead, range(first, last)):
            if writer is None:
                often = list(_alike(table.schema))
                opened = pq.ParquetWriter(new / name, table.schema, compression="zstd", use_dictionary=often)
                writer = stack.enter_context(opened)
            writer.write_table(table)
            try:
                figures.append(figures_of(table, names))
            except Exception as error:  # the part stands all the same
                failed = failed or error
    digest = hashlib.sha256((new / name).read_bytes()).hexdigest()
    return _Part({"file": f"{UNITS}/{name}", "units": last - first, "sha256": digest}, tuple(figures), failed)


def _groups(
    lot: Lot, ledger: Ledger, noted: Sequence[Noted], instead: Mapping[int, bytes], units: range
) -> Iterator[pa.Table]:
    """Yield the rows of units, as many together as a row group holds: by what is in them, not by their blocks."""
    read = lru_cache(maxsize=3)(lambda block: _table(ledger.rows(block)))  # units done again stand among others
    tables: list[pa.Table] = []
    for start in units[::GROUP]:
        numbers = range(start, min(start + GROUP, units.stop))
        tables.append(_rows(read, noted, instead, numbers))
        most = max(pc.sum(pc.list_value_length(one["results"])).as_py() or 0 for one in tables)
        if numbers.stop == units.stop or most * (len(tables) + 1) > MANY:
            table = pa.concat_tables(tables)
            given = lot.units.table.slice(numbers.stop - len(table), len(table))
            for column in given.column_names:
                if column != "serial":
                    table = table.append_column(column if column not in OWN else f"unit_{column}", given[column])
            yield table.combine_chunks()
            tables = []


def _alike(schema: pa.Schema) -> Iterator[str]:
    """Yield the columns of a schema, as a file names them, whose cells come again."""
    for field in schema:
        if pa.types.is_list(field.type) and pa.types.is_struct(field.type.value_type):
            cells = (one.name for one in field.type.value_type if one.name not in UNLIKE)
            yield from (f"{field.name}.list.element.{one}" for one in cells)
        else:
            yield field.name


def _rows(
    read: Callable[[int], pa.Table], noted: Sequence[Noted], instead: Mapping[int, bytes], units: range
) -> pa.Table:
    """Return the rows of some units: those in the ledger, or in place of them."""
    tables: list[pa.Table] = []
    for (replaced, block, _), run in groupby(units, lambda at: (at in instead, noted[at].block, noted[at].place - at)):
        numbers = list(run)
        if replaced:
            tables += [_table(instead[at]) for at in numbers]
        else:
            tables.append(read(block).slice(noted[numbers[0]].place, len(numbers)))
    return pa.concat_tables(tables).set_column(0, "number", pa.array(units, pa.int64()))


def _table(rows: bytes, columns: Sequence[int] | None = None) -> pa.Table:
    with pa.ipc.open_stream(rows, options=pa.ipc.IpcReadOptions(included_fields=columns)) as stream:
        return stream.read_all()


def read_units_of(folder: Path, content: Mapping[str, object]) -> dict[str, list[object]]:
    """Return a row a unit of what a lot wrote, without the lists of figures, by column.

    Raises
    ------
    DataError
        ``changed`` for a part that is no longer what the lot wrote; ``missing_file``.
    """
    found: list[pa.Table] = []
    parts: Sequence[Mapping[str, str]] = content["parts"]  # type: ignore[assignment]
    for part in parts:
        path = folder / part["file"]
        if not path.is_file():
            raise DataError(
                "no such file", str(path), do="Resume the lot: its files are written again", code="missing_file"
            )
        names = [name for name in pq.read_schema(path).names if name in SHOWN or name not in OWN]
        found.append(pq.read_table(path, columns=names))
    return {str(name): column for name, column in pa.concat_tables(found).to_pydict().items()}
