"""What an acquisition shows of itself, for a page or a terminal, from any thread: `Shown`.

Use::

    acquisition = Acquisition(load_lab("LAB.toml"), folder)      # or Followed(folder): that of another process
    acquisition.start()
    view = acquisition.view()          # state, instruments with channels and units, remarks, step, disk: all frozen
    recent = acquisition.recent("imu", width=0.02, first=-500)   # least and most of each pixel, for drawing
    seconds, values = acquisition.samples("imu", 4096)          # single samples, for a rolling Allan deviation
    acquisition.publish("face 2 of 6: hold still")              # a text of whoever leads the test; shown, and recorded
    acquisition.stop()                 # asks it to end; returns at once
    acquisition.wait()                 # until all is on the disk; raises what ended it, if that was a fault
    seal(folder)                       # Parquet and summary

``View.version`` goes up whenever something but samples has changed; ``InstrumentView.rows`` whenever there are new
samples. Nothing here waits for a disk or an instrument. Of each instrument the last `KEPT` samples are held, however
long it runs, in the unit of each channel.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.recording import SECOND, Times
from ...core.remarks import Remark
from ...files.loggers.rows import Read, RowLayout, arrivals
from .intervals import Intervals
from .relation import OwnTime

KEPT = 2**16  # samples of an instrument
LOOKED_AT = 2**13  # samples from which the rate is taken
UNSORTED = 2**12  # rows that may wait until they are sorted into what is shown
REMARKS = 200  # that are shown
# remarks of which the latest counts: it holds all that the earlier ones said
RENEWED = frozenset(
    {"save_intervals", "disk_filling", "glitch", "disturbed", "saturated", "stuck", "repeated", "missing"}
)
OF_COUNTS = {"damaged": "damaged_rows", "doubled": "doubled_rows", "late": "late_rows", "lost": "lost_rows"}
# reading: what was recorded so far is gone through. stalled: no sign of life. died: cut off by a kill or lost power
State = Literal["ready", "reading", "running", "stalled", "stopping", "done", "failed", "died"]


@dataclass(frozen=True)
class ChannelView:
    """A channel."""

    name: str
    unit: str  # Empty: not known
    axis: str
    role: str  # ``"reading"``, ``"time"`` or ``"counter"``


@dataclass(frozen=True)
class InstrumentView:
    """An instrument."""

    name: str
    identity: str  # Who it says it is; empty where it was not asked
    channels: tuple[ChannelView, ...]
    connected: bool
    rows: int  # That came
    acknowledged: int  # Of them, that are on the disk
    row_rate: float | None  # Over the last seconds [Hz]; None before there are two rows
    damaged: int
    doubled: int
    late: int
    lost: int
    intervals: str  # ``"3 s x17 for 2 s"``; empty where all are as they should be


@dataclass(frozen=True)
class StepView:
    """Where the sequence is."""

    number: int  # From 1
    count: int
    name: str
    left: float  # Of its hold [s]
    values: tuple[tuple[str, float, str], ...]  # That were set last: ``"table.rate"``, value, unit


@dataclass(frozen=True)
class Told:
    """A remark, and when it was last made."""

    utc_ns: int
    remark: Remark


@dataclass(frozen=True)
class View:
    """All of it at a moment."""

    version: int
    state: State
    title: str
    elapsed: float  # [s]
    utc_ns: int
    instruments: tuple[InstrumentView, ...]
    step: StepView | None  # None: there are no steps
    remarks: tuple[Told, ...]  # The latest last; equal ones once, with their count
    written: int  # [byte]
    free: int | None  # Of the disk [byte]; None before it was looked at
    full_in: float | None  # When the disk will be full [s]; None where that is not known
    status: str = ""  # As whoever leads the test says it; the latest
    why: str = ""  # What ended it, or is the matter with it
    run: int = 0  # Goes up when another recording is followed


@dataclass(frozen=True, eq=False)
class Recent:
    """The last samples in parts of equal length of the clock, as few as are drawn; empty parts are left out."""

    parts: Times  # shape (points,): number of each; part n lasts from n to n + 1 widths of the clock
    low: Array  # shape (points, channels): least of each channel in it, in its unit
    high: Array  # shape (points, channels): most
    newest: float  # When the last sample of all had come [s]; NaN before there is one


class Shown(Protocol):
    """An acquisition that is looked at: one of this process, or `followed.Followed` of another."""

    def seconds(self) -> float:
        """Return the reading of the clock that stamps the samples [s]."""
        ...

    def view(self) -> View:
        """Return all that is shown but samples."""
        ...

    def recent(self, name: str, width: float, first: int) -> Recent:
        """Return least and most of each channel in each part from one on; of a negative number, in so many parts."""
        ...

    def samples(self, name: str, count: int) -> tuple[Array, Array]:
        """Return times [s], shape (n,), and values, shape (n, channels), of the last samples of an instrument."""
        ...


class Ring:
    """The last samples of an instrument."""

    def __init__(self, layout: RowLayout, kept: int = KEPT) -> None:
        self._kept = kept
        self._values = np.full((kept, len(layout.channels)), np.nan)
        self._seconds = np.zeros(kept)
        self.count = 0  # That ever came

    def add(self, values: Sequence[NDArray[np.generic]], seconds: Array) -> None:
        """Add samples, each channel of shape (n,), and when each came [s]."""
        n = min(len(seconds), self._kept)
        begin = (self.count + len(seconds) - n) % self._kept
        room = min(n, self._kept - begin)  # the rest goes to the front
        for here, there in ((slice(begin, begin + room), slice(len(seconds) - n, len(seconds) - n + room)),
                            (slice(0, n - room), slice(len(seconds) - n + room, len(seconds)))):  # fmt: skip
            for i, one in enumerate(values):
                self._values[here, i] = one[there]
            self._seconds[here] = seconds[there]
        self.count += len(seconds)

    def since(self, seconds: float) -> int:
        """Return how many samples came at a time or later, at most as many as are held."""
        begin, held = self.count % self._kept, min(self.count, self._kept)
        newer = self._seconds[:begin]
        found = begin - int(np.searchsorted(newer, seconds))
        if found == begin and held > begin:
            found += self._kept - begin - int(np.searchsorted(self._seconds[begin:], seconds))
        return min(found, held)

    def last(self, count: int) -> tuple[Array, Array]:
        """Return times [s], shape (n,), and values, shape (n, channels), of the last samples, the oldest first."""
        count = min(count, self.count, self._kept)
        end = self.count % self._kept
        if count <= end:
            return self._seconds[end - count : end].copy(), self._values[end - count : end].copy()
        old = slice(self._kept - (count - end), self._kept)
        return (np.concatenate((self._seconds[old], self._seconds[:end])),
                np.concatenate((self._values[old], self._values[:end])))  # fmt: skip

    def row_rate(self, over: float = 5.0) -> float | None:
        """Return how many rows a second came over the last seconds, or between the last two [Hz]."""
        newest = self._seconds[(self.count - 1) % self._kept]
        count = max(min(self.since(newest - over), LOOKED_AT), 2)
        apart = float(newest - self._seconds[(self.count - count) % self._kept]) if self.count >= count else 0.0
        return (count - 1) / apart if apart > 0 else None

    def recent(self, width: float, first: int) -> Recent:
        """Return least and most in parts, which do not move while time goes on."""
        newest = float(self._seconds[(self.count - 1) % self._kept]) if self.count else np.nan
        if not self.count:
            return Recent(np.empty(0, np.int64), self._values[:0], self._values[:0], newest)
        first = int(newest // width) + 1 + first if first < 0 else first
        seconds, values = self.last(self.since(first * width))
        part = np.floor(seconds / width).astype(np.int64)
        begins = np.flatnonzero(np.diff(part, prepend=part[:1] - 1))
        if not len(begins):
            return Recent(part, values, values, newest)
        return Recent(
            part[begins], np.fmin.reduceat(values, begins, axis=0), np.fmax.reduceat(values, begins, axis=0), newest
        )


class Track:
    """What is known of the rows of an instrument: the last samples, save intervals, its own time."""

    def __init__(self, layout: RowLayout) -> None:
        self.layout, self.rows = layout, 0
        self.channels = channel_views(layout)
        self._ring, self._own = Ring(layout), OwnTime(layout)
        self._intervals = None if layout.interval is None else Intervals(layout.interval)
        self._lock = threading.Lock()
        self._waiting: list[Read] = []
        self._count = 0  # Rows that wait
        self._before: int | None = None  # Monotonic reading of the last lot [ns]

    def add(self, lot: Read) -> None:
        """Add rows; they are sorted in when somebody looks, or when they are many."""
        with self._lock:
            self._waiting.append(lot)
            self._count += len(lot.rows)
            self.rows += len(lot.rows)
            if self._count >= UNSORTED:
                self._sort()

    def _sort(self) -> None:
        waiting, self._waiting, self._count = self._waiting, [], 0
        if not waiting:
            return
        lot = waiting[0]
        if len(waiting) > 1:
            ends = np.cumsum([0, *(len(one.rows) for one in waiting[:-1])])
            lot = Read(
                np.frombuffer(b"".join(one.rows.tobytes() for one in waiting), waiting[0].rows.dtype),
                np.concatenate([one.last + end for one, end in zip(waiting, ends, strict=True)]),
                np.concatenate([one.utc_ns for one in waiting]), np.concatenate([one.monotonic_ns for one in waiting]),
            )  # fmt: skip
        came = arrivals(lot, self._before, self.layout.interval) / SECOND
        self._before = int(lot.monotonic_ns[-1])
        self._ring.add([one.values(lot.rows) for one in self.layout.channels], came)
        if self._intervals is not None:
            channel = self._own.channel
            self._intervals.add(came if channel is None else self._own.seconds(channel.values(lot.rows)))

    def samples(self, count: int) -> tuple[Array, Array]:
        """Return times [s], shape (n,), and values, shape (n, channels), of the last samples."""
        with self._lock:
            self._sort()
            return self._ring.last(count)

    def from_sample(self, first: int, most: int | None = None) -> tuple[int, Array, Array]:
        """Return samples from a number on that are held, at most so many: number of the first, times [s], values."""
        with self._lock:
            self._sort()
            seconds, values = self._ring.last(self._ring.count - max(first, 0))
            return self._ring.count - len(seconds), seconds[:most], values[:most]

    def recent(self, width: float, first: int) -> Recent:
        """Return least and most of each channel in parts."""
        with self._lock:
            self._sort()
            return self._ring.recent(width, first)

    def row_rate(self) -> float | None:
        """Return how many rows a second came of late [Hz]."""
        with self._lock:
            self._sort()
            return self._ring.row_rate()

    def odd_intervals(self) -> tuple[int, str]:
        """Return how many save intervals are longer or shorter than they should be, and which."""
        with self._lock:
            self._sort()
            return (0, "") if self._intervals is None else (sum(self._intervals.odd.values()), str(self._intervals))


class Remarks:
    """The latest remarks: equal ones once, with their count."""

    def __init__(self) -> None:
        self._told: dict[tuple[str, str, str], Told] = {}

    def add(self, utc_ns: int, remark: Remark) -> None:
        """Add one."""
        key = (remark.code, remark.where, remark.subject if remark.code in RENEWED else remark.what)
        known = self._told.pop(key, None)
        if known is not None and remark.code not in RENEWED:
            remark = replace(remark, count=remark.count + known.remark.count)
        self._told[key] = Told(utc_ns, remark)
        while len(self._told) > REMARKS:
            self._told.pop(next(iter(self._told)))

    @property
    def told(self) -> tuple[Told, ...]:
        """All of them, the latest last."""
        return tuple(self._told.values())


def channel_views(layout: RowLayout) -> tuple[ChannelView, ...]:
    """Return what is shown of the channels of an instrument."""
    return tuple(ChannelView(one.name, one.unit, one.axis, one.role) for one in layout.channels)
