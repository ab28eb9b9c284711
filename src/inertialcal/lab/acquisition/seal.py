"""Sealing: a recording, finished or not, becomes a Parquet file an instrument, and a summary.

Each file has ``time`` (UTC) and the channels in their units, in the type in which they came. Where the instrument sends
its own time, or a counter and its interval was said, ``time`` is that of its clock, put on the computer's by offset and
drift (`relation`); else it is when the rows came. ``acquisition.json`` says which, with both clocks, save intervals,
remarks and the SHA-256 of every file.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...core.batches import made
from ...core.errors import DataError, StoreError
from ...core.recording import Recording, Times
from ...core.remarks import Remark, gather
from ...files import read
from ...files.loggers.bags import Bag, bag_of
from ...files.loggers.rows import ENCODING, RowLayout, layout_in, reads
from ...files.source import load
from ...files.write.atomic import atomic_write
from ...files.write.recording import write
from .intervals import Intervals
from .live import RENEWED
from .recorder import EVENTS, RECORDING
from .relation import WITHIN, Clocks, OwnTime, Relation

SUMMARY = "acquisition.json"
PIECE = 2**20  # bytes that are hashed at once


@dataclass(frozen=True)
class Sealed:
    """What was sealed of an instrument."""

    name: str
    file: Path
    rows: int
    clocks: Clocks
    time_from: str  # Where ``time`` comes from, in words
    intervals: Intervals | None
    remarks: tuple[Remark, ...]  # Of sealing


@dataclass(frozen=True)
class Summary:
    """What was sealed."""

    folder: Path
    instruments: tuple[Sealed, ...]
    remarks: tuple[Remark, ...]  # Of the acquisition, and of reading its recording
    whole: bool  # The recording was finished

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "acquisition": 1,
            "finished": self.whole,
            "recording": {"file": RECORDING, "sha256": sha256(self.folder / RECORDING)},
            "instruments": [_instrument(one) for one in self.instruments],
            "remarks": [one.to_dict() for one in self.remarks],
        }


def _instrument(one: Sealed) -> dict[str, Any]:
    clocks: dict[str, Any] = {"status": "not_estimated", "reason": one.clocks.reason}
    estimate = one.clocks.estimate
    if estimate is not None:
        (offset, drift), (u_offset, u_drift) = estimate.values.tolist(), estimate.u.tolist()
        dof = float(np.min(estimate.dof))
        clocks = {
            "status": "estimated",
            "instrument_time": {"value": one.clocks.middle, "unit": "s"},
            "offset": {"value": offset, "u": u_offset, "unit": "s", "dof": dof},
            "drift": {"value": drift, "u": u_drift, "unit": "1", "dof": dof},
            "scatter": {"value": one.clocks.scatter, "unit": "s"},
            "rate": {"corrected": not one.clocks.uncertain, "u": one.clocks.rate(one.name).u, "unit": "1"},
        }
    intervals = None
    if one.intervals is not None:
        odd = [{"length": length, "count": count} for length, count in one.intervals.odd.items()]
        intervals = {"nominal": one.intervals.nominal, "unit": "s", "count": one.intervals.count, "odd": odd}
    return {
        "name": one.name, "file": one.file.name, "sha256": sha256(one.file), "rows": one.rows,
        "time_from": one.time_from, "clocks": clocks, "save_intervals": intervals,
    }  # fmt: skip


def seal(folder: str | Path) -> Summary:
    """Write a Parquet file an instrument, and the summary, from the recording in a folder.

    Parameters
    ----------
    folder : path
        Of an acquisition, finished, or ended by a kill or a lost power.

    Raises
    ------
    DataError
        ``missing_file``, ``damaged_file`` if nothing in it is whole.
    StoreError
        ``not_written``.
    """
    folder = Path(folder)
    path = folder / RECORDING
    if not path.exists():
        do = "Name the folder of an acquisition"
        raise DataError("no recording of an acquisition here", str(path), do=do, code="missing_file")
    bag = bag_of(load(path, in_place=True))
    events = list(_events(bag))
    of_file = bag.remarks
    layouts = {
        one.topic: layout_in(one.schema, bag.path) for one in bag.connections.values() if one.encoding == ENCODING
    }
    if not layouts and of_file:
        raise DataError(of_file[0].what, bag.path, "no row before that is whole", code="damaged_file")
    sealed = [one for name, layout in layouts.items() if (one := _sealed(folder, bag, name, layout)) is not None]
    silent = [name for name in layouts if name not in {one.name for one in sealed}]
    missing = [Remark("no_rows", "warning", "no row came", where=name, do="Look at its link") for name in silent]
    own = [remark for one in sealed for remark in one.remarks]
    summary = Summary(folder, tuple(sealed), gather([*events, *missing, *of_file, *own]), not of_file)
    with atomic_write(folder / SUMMARY) as aside:
        aside.write_text(json.dumps(summary.to_dict(), indent=1) + "\n", encoding="utf-8", newline="\n")
    return summary


def _events(bag: Bag) -> Iterator[Remark]:
    """Yield the remarks that were recorded."""
    kept: dict[tuple[str, str, str], Remark] = {}
    for part in bag.messages():
        keys = [key for key, one in bag.connections.items() if one.topic == EVENTS]
        for content in part.content(np.flatnonzero(np.isin(part.keys, keys))):
            try:
                said = json.loads(content)
                if said.pop("kind") == "remark":
                    remark = Remark(**said)
                    if remark.code in RENEWED:
                        kept[remark.code, remark.where, remark.subject] = remark
                    else:
                        yield remark
            except (ValueError, TypeError, KeyError):
                continue
    yield from kept.values()


@dataclass(frozen=True, eq=False)
class _Timed:
    """What was recorded of an instrument, on the computer's clock."""

    recording: Recording
    rows: int
    clocks: Clocks
    time_from: str
    intervals: Intervals | None


def recorded(folder: Path, name: str) -> Recording:
    """Return what was recorded of an instrument so far, as it would be sealed now.

    Raises
    ------
    DataError
        ``missing_rows`` if none of its rows is on the disk.
    """
    bag = bag_of(load(folder / RECORDING, in_place=True))
    for _ in bag.messages():  # what topics there are
        pass
    schemas = [one.schema for one in bag.connections.values() if one.encoding == ENCODING and one.topic == name]
    timed = _timed(folder, bag, name, layout_in(schemas[0], bag.path)) if schemas else None
    if timed is None:
        raise DataError(f"no row of {name} is on the disk", str(folder / RECORDING), code="missing_rows")
    return timed.recording


def _timed(folder: Path, bag: Bag, name: str, layout: RowLayout) -> _Timed | None:
    """Return what was recorded of an instrument; None of one that gave no row."""
    own, relation, rows = OwnTime(layout), Relation(layout.clock_within or WITHIN), 0
    intervals = None if layout.interval is None else Intervals(layout.interval)
    offset: int | None = None
    for one in reads(bag, name, layout):
        offset = int(one.utc_ns[0] - one.monotonic_ns[0]) if offset is None else offset
        rows += len(one.rows)
        if own.channel is None:
            continue
        seconds = own.seconds(own.channel.values(one.rows))
        relation.add(seconds[one.last], one.monotonic_ns)
        if intervals is not None:
            intervals.add(seconds)
    if offset is None:
        return None
    clocks = relation.found() if own.channel is not None else _none("it sends neither its time nor a counter")
    if own.restarts:
        clocks = _none(f"its clock went back {own.restarts} times")
    recording = read(folder / RECORDING, topics=[name])
    time_from = "when the rows came"
    if clocks.estimate is not None and own.channel is not None:
        time_ns = _on_computer(recording, layout, clocks, offset)
        began = np.datetime64(int(time_ns[0]), "ns").astype("datetime64[s]")
        recording = replace(recording, time_ns=time_ns, clock=clocks.rate(f"acquire: clock of {name} from {began}Z"))
        by = "offset alone, at its own rate" if clocks.uncertain else "offset and drift"
        time_from = f"{own.channel.name}, put on the computer's clock by {by}"
    return _Timed(recording, rows, clocks, time_from, intervals)


def _sealed(folder: Path, bag: Bag, name: str, layout: RowLayout) -> Sealed | None:
    """Write the file of an instrument; return None of one that gave no row."""
    timed = _timed(folder, bag, name, layout)
    if timed is None:
        return None
    target = folder / f"{name}.parquet"
    remarks = write(target, replace(timed.recording, remarks=()))
    kept = [one for one in timed.recording.remarks if one.code in ("messages_missing", "damaged_records")]
    if timed.clocks.uncertain:
        what = f"drift against the computer's clock: {timed.clocks.uncertain}; not used, times keep its own rate"
        do = "Record longer, or on a computer that does less; if it may be so far off, say so in LAB.toml: clock_within"
        kept.append(Remark("clock_uncertain", "warning", what, where=name, do=do))
    return Sealed(name, target, timed.rows, timed.clocks, timed.time_from, timed.intervals, (*kept, *remarks))


def _none(reason: str) -> Clocks:
    return Clocks(None, reason, 0.0, 0, 0.0)


def _on_computer(recording: Recording, layout: RowLayout, clocks: Clocks, offset: int) -> Times:
    """Return the time of each row by the instrument's clock, put on that of the computer [ns, UTC], shape (n,)."""
    own = OwnTime(layout)
    assert own.channel is not None  # noqa: S101 - it has clocks
    data = recording.channel(own.channel.name).data

    def part(first: int, stop: int) -> Times:
        return clocks.host_time(own.seconds(data[first:stop])) + offset

    return made(len(data), np.int64, part, data)


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file.

    Raises
    ------
    StoreError
        ``not_readable``.
    """
    digest = hashlib.sha256()
    try:
        with path.open("rb") as stream:
            while block := stream.read(PIECE):
                digest.update(block)
    except OSError as error:
        raise StoreError(f"cannot be read: {error.strerror}", str(path), code="not_readable") from None
    return digest.hexdigest()
