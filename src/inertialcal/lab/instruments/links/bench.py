"""The bench of a simulated rig: its unit and what moves it as one instrument, with all recordings of a campaign in it.

``recording`` (a number, in the order of the campaign) powers the unit up as that recording begins; told again, it stays
on. A recording of a table then waits: ``rate`` has it go on to the next dwell at that rate, ramp first. Others run at
once. What was told is done from the next row on; a rate that does not come any more in the recording brings no rows.
A plan's bench (`links.planned`) does the same with what its schedule sets: a temperature, an angle, a position.

A rehearsal is the same each time: rows depend on what was told, not on when.
"""

from __future__ import annotations

import threading
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from ....core.errors import InstrumentError
from ....core.estimate import Array
from ....core.recording import SECOND, Recording
from ....files.loggers.rows import Rows
from ....procedures.rehearsed import Stretch
from ....rigs import RIGS
from ...clock import Clock
from ..dialect import CommandsEntry, Dialect, FieldEntry, FrameEntry, SettingEntry
from ..frames import STAMP, frames
from .link import LinkEntry, LinkKind

AT_ONCE = 4096  # rows
SHORTEST = 3  # samples of a dwell
SAME = 1e-6  # difference of what is told that is none, in its unit
LOOK = 0.05  # [s] of the machine between two looks where nothing is to come


@dataclass(frozen=True, eq=False)
class Bench:
    """What a rig has recorded, as rows of one layout."""

    dialect: Dialect
    rows: tuple[Rows, ...]  # Of each recording
    stretches: tuple[tuple[Stretch, ...], ...]  # Of each recording
    names: tuple[str, ...]  # Files of the recordings, as the campaign has them


class BenchLink:
    """A bench, told what to do and read like an instrument on a line."""

    whole = False
    begins_whole = True

    def __init__(self, bench: Bench, clock: Clock) -> None:
        self.bench, self.clock = bench, clock
        self._told = threading.Condition()
        self._recording, self._next = -1, 0
        self._sent: list[bytes] = []
        self._due: Array = np.empty(0)
        self._stamps = np.empty(0, np.int64)
        self._at, self._begin, self._last_ns = 0, 0.0, 0

    def open(self) -> None:
        """Begin."""

    def read(self, wait: float) -> list[bytes]:
        """Return the rows that are due by now; none as soon as it is told something."""
        with self._told:
            sent = self._sent
            if self._at >= len(sent):
                self._told.wait(LOOK)
                return []
            left = self._begin + self._due[self._at] - self.clock.seconds()
            if left > 0.0:
                self._told.wait(self.clock.real(min(left, wait)))
            if sent is not self._sent:
                return []
            elapsed = self.clock.seconds() - self._begin
            stop = min(int(np.searchsorted(self._due, elapsed, side="right")), self._at + AT_ONCE)
            found, self._at = b"".join(sent[self._at : stop]), max(stop, self._at)
            self._last_ns = int(self._stamps[self._at - 1]) if self._at else self._last_ns
        return [found] if found else []

    def write(self, data: bytes) -> None:
        """Do what is told."""
        for line in data.decode("ascii", "replace").splitlines():
            word, _, number = line.partition(" ")
            with self._told:
                if word == "RECORDING":
                    self._power_up(int(number) - 1)
                elif word == "GO":
                    self._go(float(number))
                else:
                    self._send(None)
                self._told.notify_all()

    def close(self, again: bool = False) -> None:
        """End."""
        with self._told:
            self._send(None)
            self._told.notify_all()

    def _power_up(self, number: int) -> None:
        if number == self._recording:
            return
        known = 0 <= number < len(self.bench.rows)
        self._recording, self._next = number if known else -1, 0
        stretches = self.bench.stretches[number] if known else ()
        self._send(stretches[0] if stretches and np.isnan(stretches[0][2]) else None)

    def _go(self, value: float) -> None:
        stretches = self.bench.stretches[self._recording] if self._recording >= 0 else ()
        for number in (*range(self._next, len(stretches)), self._next - 1):  # the last one again where none comes
            if number >= 0 and abs(stretches[number][2] - value) <= SAME:
                self._next = number + 1
                self._send(stretches[number])
                return
        self._send(None)

    def _send(self, stretch: Stretch | None) -> None:
        """Send a stretch from now on, in place of what was to come."""
        self._sent, self._due, self._at = [], np.empty(0), 0
        if stretch is None:
            return
        first, stop, _ = stretch
        rows = self.bench.rows[self._recording][first:stop].copy()
        step = int(np.median(np.diff(rows[STAMP]))) if len(rows) > 1 else 0
        self._due = (rows[STAMP] - rows[STAMP][0] + step) / SECOND
        rows[STAMP] += max(self._last_ns + step - int(rows[STAMP][0]), 0)  # done again: its clock goes on
        self._stamps = rows[STAMP]
        self._sent, self._begin = list(frames(rows, self.bench.dialect)), self.clock.seconds()


@lru_cache(maxsize=4)
def bench_of(rig: str, seed: int) -> Bench:
    """Return the bench of a rig.

    Raises
    ------
    UsageError
        If there is no such rig.
    InstrumentError
        ``no_time`` if its recordings have no time.
    """
    twin = RIGS.named(rig).twin(seed)
    recordings = twin.recordings
    applied = applied_columns(twin.campaign)
    if any(one.stamps is None for one in recordings.values()):
        raise InstrumentError(f"rig {rig} has recordings without a time", code="no_time")
    stretches = {file: _stretches(one, applied.get(file, ("", ""))[0]) for file, one in recordings.items()}
    told = ("rate", next(iter(applied.values()))[1]) if applied else ("", "")
    return build_bench(f"bench of the rig {rig}", recordings, stretches, "recording", *told)


def build_bench(
    title: str, recordings: Mapping[str, Recording], stretches: Mapping[str, tuple[Stretch, ...]], power_up: str,
    told: str, unit: str,
) -> Bench:  # fmt: skip
    """Return a bench of recordings.

    Parameters
    ----------
    title : str
        Of its dialect.
    recordings, stretches : mapping
        By name, in order: rows, and which of them follow what is told.
    power_up, told, unit : str
        Names of what is set: the number of a recording, and what the machine is told, with its unit; empty: nothing.
    """
    fields = [FieldEntry(name=STAMP, type="int64", unit="ns", role="time")]
    units: dict[str, str] = {}
    for one in recordings.values():
        units |= {channel.name: channel.unit or "" for channel in one.channels}
    for name, own_unit in units.items():
        own = [one.channel(name).data for one in recordings.values() if name in one.names]
        whole = len(own) == len(recordings) and all(data.dtype.kind in "iu" for data in own)
        fields.append(FieldEntry(name=name, type="int64" if whole else "float64", unit=own_unit))
    settings = {power_up: SettingEntry(unit="", set=("RECORDING {value:.0f}",))}
    if told:
        settings[told] = SettingEntry(unit=unit, set=("GO {value:.9f}",))
    dialect = Dialect(
        title=title, frame=FrameEntry(kind="packets", sync="AA 55", checksum="crc32"),
        fields=tuple(fields), commands=CommandsEntry(safe=("SAFE",)), settings=settings,
    )  # fmt: skip
    rows = tuple(_rows(one, dialect) for one in recordings.values())
    return Bench(dialect, rows, tuple(stretches[name] for name in recordings), tuple(recordings))


def applied_columns(campaign: str) -> dict[str, tuple[str, str]]:
    """Return column and unit of the rate of the table in each recording of a campaign, by its file."""
    found = {}
    for one in tomllib.loads(campaign)["recordings"].values():
        applied = one.get("channels", {}).get("applied")
        if applied is not None:
            found[str(one["file"])] = (str(applied["column"]), str(applied["unit"]))
    return found


def _rows(recording: Recording, dialect: Dialect) -> Rows:
    layout, stamps = dialect.layout, recording.stamps
    assert layout is not None  # noqa: S101 - made above
    assert stamps is not None  # noqa: S101 - looked at
    rows = np.empty(len(recording), layout.dtype)
    for one in layout.channels:
        there = one.name in recording.names
        rows[one.name] = stamps if one.name == STAMP else recording.channel(one.name).data if there else np.nan
    return rows


def _stretches(recording: Recording, column: str) -> tuple[Stretch, ...]:
    """Return the dwells of a recording, each with the ramp before it; the whole where nothing is applied."""
    if not column:
        return ((0, len(recording), np.nan),)
    rate = np.asarray(recording.channel(column).data, float)
    edges = [0, *(np.flatnonzero(np.diff(rate) != 0.0) + 1).tolist(), len(rate)]
    found: list[Stretch] = []
    begin = 0
    for first, stop in pairwise(edges):
        if stop - first >= SHORTEST:
            found.append((begin, stop, float(rate[first])))
            begin = stop
    return tuple(found)


def _make(entry: LinkEntry, folder: Path, clock: Clock) -> BenchLink:
    return BenchLink(bench_of(entry.rig, entry.seed), clock)


def _dialect(entry: LinkEntry, folder: Path) -> Dialect:
    return bench_of(entry.rig, entry.seed).dialect


KIND = LinkKind("bench", ("rig", "seed"), 1, _make, _dialect, paced=True)
