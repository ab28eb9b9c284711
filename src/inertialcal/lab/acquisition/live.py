"""What a running acquisition shows of itself, for a page or a terminal, from any thread.

Use::

    acquisition = Acquisition(load_lab("LAB.toml"), folder)
    acquisition.start()
    view = acquisition.view()          # state, instruments with channels and units, remarks, step, disk: all frozen
    recent = acquisition.recent("imu", span=10.0, points=500)   # least and most of each pixel, for drawing
    seconds, values = acquisition.samples("imu", 4096)          # single samples, for a rolling Allan deviation
    acquisition.stop()                 # asks it to end; returns at once
    acquisition.wait()                 # until all is on the disk; raises what ended it, if that was a fault
    seal(folder)                       # Parquet and summary

``View.version`` goes up whenever something but samples has changed; ``InstrumentView.rows`` whenever there are new
samples. Nothing here waits for a disk or an instrument. Of each instrument the last `KEPT` samples are held, however
long it runs, in the unit of each channel.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.remarks import Remark
from ...files.loggers.rows import RowLayout, Rows

KEPT = 2**16  # samples of an instrument
LOOKED_AT = 2**13  # samples from which the rate is taken
State = Literal["ready", "running", "stopping", "done", "failed"]


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

    number: int  # From 1; 0 before the first
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


@dataclass(frozen=True, eq=False)
class Recent:
    """The last samples, as few as are drawn."""

    seconds: Array  # shape (points,): end of each, of the clock of the acquisition
    low: Array  # shape (points, channels): least of each channel in it, in its unit
    high: Array  # shape (points, channels): most


class Ring:
    """The last samples of an instrument."""

    def __init__(self, layout: RowLayout, kept: int = KEPT) -> None:
        self.layout, self._kept = layout, kept
        self._values = np.full((kept, len(layout.channels)), np.nan)
        self._seconds = np.zeros(kept)
        self._lock = threading.Lock()
        self.count = 0  # That ever came

    def add(self, rows: Rows, seconds: Array) -> None:
        """Add rows, and when each came [s]."""
        rows, seconds = rows[-self._kept :], seconds[-self._kept :]
        with self._lock:
            places = (self.count + np.arange(len(rows))) % self._kept
            for i, one in enumerate(self.layout.channels):
                self._values[places, i] = one.values(rows)
            self._seconds[places] = seconds
            self.count += len(rows)

    def last(self, count: int) -> tuple[Array, Array]:
        """Return times [s], shape (n,), and values, shape (n, channels), of the last samples, the oldest first."""
        with self._lock:
            places = self._places(count)
            return self._seconds[places], self._values[places]

    def since(self, first: int) -> tuple[int, Array, Array]:
        """Return how many ever came; times [s] and values of those from number ``first`` on that are held."""
        with self._lock:
            places = self._places(max(self.count - first, 0))
            return self.count, self._seconds[places], self._values[places]

    def _places(self, count: int) -> NDArray[np.int64]:
        count = min(count, self.count, self._kept)
        return (self.count - count + np.arange(count)) % self._kept

    def _within(self, span: float, most: int) -> int:
        """Return how many samples the last seconds hold."""
        with self._lock:
            seconds = self._seconds[self._places(most)]
        return len(seconds) - int(np.searchsorted(seconds, seconds[-1] - span)) if len(seconds) else 0

    def row_rate(self, over: float = 5.0) -> float | None:
        """Return how many rows a second came over the last seconds, or between the last two [Hz]."""
        count = max(self._within(over, LOOKED_AT), 2)
        seconds, _ = self.last(count)
        apart = float(seconds[-1] - seconds[0]) if len(seconds) > 1 else 0.0
        return (len(seconds) - 1) / apart if apart > 0 else None

    def recent(self, span: float, points: int) -> Recent:
        """Return least and most of equal parts of the last seconds; parts without a sample are left out."""
        seconds, values = self.last(self._within(span, self._kept))
        if not len(seconds):
            return Recent(seconds, values, values)
        width = span / points
        part = np.floor(seconds / width).astype(np.int64)  # parts do not move while the window does
        begins = np.flatnonzero(np.diff(part, prepend=part[0] - 1))
        ends = ((part[begins] + 1) * width).astype(np.float64)
        return Recent(ends, np.fmin.reduceat(values, begins, axis=0), np.fmax.reduceat(values, begins, axis=0))


def channel_views(layout: RowLayout | None) -> tuple[ChannelView, ...]:
    """Return what is shown of the channels of an instrument."""
    if layout is None:
        return ()
    return tuple(ChannelView(one.name, one.unit, one.axis, one.role) for one in layout.channels)
