"""How the clock of an instrument runs against that of the computer: offset and drift, from when its rows came.

A row comes after it was made, by a delay that is never negative and mostly small::

    host_i = offset + (1 + drift) device_i + delay_i,   delay_i >= 0

In each of up to `MOST` blocks of equal length the row with the least delay is kept, and a line is fitted to these by
least squares. Assumed: the least delays of the blocks are independent and alike, and the clocks drift linearly. Then
the uncertainty of the drift is that of the slope, from the scatter about the line, with as many degrees of freedom as
blocks less two. The offset holds the least delay of the link, which rows that go one way cannot tell: its uncertainty
is that of the line alone. A clock that wanders shows as scatter, and makes both uncertain.

Constant memory: when there are too many blocks, two and two become one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array, Component, Estimate
from ...core.recording import SECOND, Times
from ...core.units import convert
from ...files.loggers.rows import RowLayout
from ...statistics.least_squares import fit

MOST, FEWEST = 64, 8  # blocks
FIRST_BLOCK = 0.1  # [s]


@dataclass(frozen=True)
class Clocks:
    """Relation of two clocks."""

    estimate: Estimate | None  # ``offset`` [s] at the middle of the record, and ``drift`` [1]; None: not estimated
    reason: str  # Why it is not estimated
    middle: float  # Time of the instrument that the offset is for [s]
    host_ns: int  # Reading of the computer that the offset counts from
    scatter: float  # Of the least delays about the line [s]

    def host_time(self, device: Array) -> Times:
        """Return the reading of the computer at times of the instrument [s], shape (n,) [ns, monotonic]."""
        assert self.estimate is not None  # noqa: S101 - the caller has looked
        offset, drift = self.estimate.values
        elapsed = offset + (1.0 + drift) * (device - self.middle)
        found: Times = self.host_ns + np.rint(elapsed * SECOND).astype(np.int64)
        return found


class OwnTime:
    """Time of an instrument from its rows, in order: its time, or its counter and the interval that was said.

    A counter is followed over the end of its type. ``restarts`` counts how often the time went back.
    """

    def __init__(self, layout: RowLayout) -> None:
        time, counter = layout.role("time"), layout.role("counter")
        self.channel = time or (counter if layout.interval is not None else None)
        self.interval = 1.0 if layout.interval is None or time is not None else layout.interval
        self.restarts = 0
        self._last: float | None = None
        self._raw = 0

    def seconds(self, values: NDArray[Any]) -> Array:
        """Return the time of each row [s], shape (n,), of the values of `channel` in its own unit."""
        assert self.channel is not None  # noqa: S101 - the caller has looked
        if not len(values):
            return np.empty(0)
        if self.channel.role == "time":
            found = convert(np.asarray(values, float), self.channel.unit, "s")
        else:
            found = self._unwrapped(values)
        self.restarts += int(np.sum(np.diff(found, prepend=found[0] if self._last is None else self._last) < 0))
        self._last = float(found[-1])
        return found

    def _unwrapped(self, values: NDArray[Any]) -> Array:
        size = np.dtype(self.channel.type).itemsize if self.channel is not None else 8
        raw = values.astype(np.int64)
        if self._last is None:
            self._raw, before = int(raw[0]), float(raw[0]) * self.interval
        else:
            before = self._last
        steps = np.diff(raw, prepend=self._raw)
        steps = steps % 2 ** (8 * size) if size <= 2 else steps
        self._raw = int(raw[-1])
        found: Array = before + np.cumsum(steps) * self.interval
        return found


class Relation:
    """What is kept of two clocks while rows come."""

    def __init__(self) -> None:
        self._origin: tuple[float, int] | None = None  # Time of the instrument [s], reading of the computer [ns]
        self._length = FIRST_BLOCK
        self._blocks: dict[int, tuple[float, float, int]] = {}  # by number: time [s], least difference [s], rows

    def add(self, device: Array, host_ns: Times) -> None:
        """Add the last row of each lot: time of the instrument [s], and when it had come [ns, monotonic]."""
        if not len(device):
            return
        if self._origin is None:
            self._origin = (float(device[0]), int(host_ns[0]))
        elapsed = np.asarray(device, float) - self._origin[0]
        apart = (host_ns - self._origin[1]) / SECOND - elapsed
        while np.max(np.abs(elapsed)) / self._length >= MOST:
            self._merge()
        numbers = np.floor(elapsed / self._length).astype(np.int64)
        for number in np.unique(numbers).tolist():
            own = np.flatnonzero(numbers == number)
            best = own[np.argmin(apart[own])]
            self._put(number, (float(elapsed[best]), float(apart[best]), len(own)))

    def _put(self, number: int, block: tuple[float, float, int]) -> None:
        kept = self._blocks.get(number)
        if kept is not None:
            least = min(kept, block, key=lambda one: one[1])
            block = (least[0], least[1], kept[2] + block[2])
        self._blocks[number] = block

    def _merge(self) -> None:
        self._length *= 2.0
        blocks, self._blocks = self._blocks, {}
        for number, block in blocks.items():
            self._put(number // 2, block)

    def found(self) -> Clocks:
        """Return what is known now."""
        counts = np.array([one[2] for one in self._blocks.values()])
        usual = float(np.median(counts)) if len(counts) else 0.0
        kept = [one for one in self._blocks.values() if 2 * one[2] >= usual]  # one that has just begun is no minimum
        if self._origin is None or len(kept) < FEWEST:
            span = f"{len(kept)} blocks of {self._length:g} s, need {FEWEST}"
            return Clocks(None, f"too short a record: {span}", 0.0, 0, 0.0)
        at, apart = np.array([one[0] for one in kept]), np.array([one[1] for one in kept])
        middle = float(np.mean(at))
        line = fit(np.column_stack([np.ones(len(at)), at - middle]), apart, names=("offset", "drift"))
        scatter = Component("scatter of the least delays", "A", line.need_covariance(), line.dof)
        # host = host_0 + (device - device_0) + apart; at the middle: device - device_0 = middle
        estimate = Estimate(("offset", "drift"), line.coefficients, ("s", "1"), (scatter,))
        host_ns = self._origin[1] + round(middle * SECOND)
        return Clocks(estimate, "", self._origin[0] + middle, host_ns, line.scatter)
