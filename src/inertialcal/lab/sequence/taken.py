"""Rows of the instruments since a moment, for what is awaited and what is recorded."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.errors import InstrumentError
from ...core.estimate import Array
from ...core.recording import SECOND, Channel, Recording, Times
from ...core.units import convert
from ...files.loggers.rows import Read, RowChannel, RowLayout, Rows, arrivals
from ..instruments.protocol import Batch

UTC_FROM = 10**17  # [ns]: an instrument's own time beyond this is since 1970, as of 1973 on


@dataclass(frozen=True, eq=False)
class Since:
    """Rows of an instrument."""

    layout: RowLayout
    rows: Rows  # shape (n,)
    time_ns: Times  # shape (n,): of the instrument's own clock where it sends it, else UTC when they came [ns]

    def __len__(self) -> int:
        return len(self.rows)

    def values(self, names: tuple[str, ...]) -> Array:
        """Return channels in their units, shape (n, channels)."""
        by_name = {one.name: one for one in self.layout.channels}
        return np.column_stack([np.asarray(by_name[name].values(self.rows), float) for name in names])

    def part(self, first: int, stop: int) -> Since:
        """Return some of them."""
        return Since(self.layout, self.rows[first:stop], self.time_ns[first:stop])

    @property
    def utc(self) -> bool:
        """Whether their clock counts since 1970."""
        return bool(self.time_ns[0] >= UTC_FROM)

    def recording(self) -> Recording:
        """Return them as a recording; channels that hold nothing are left out."""
        time = self.layout.role("time")
        data = {one: one.values(self.rows) for one in self.layout.channels if one is not time}
        channels = tuple(
            Channel(one.name, np.ascontiguousarray(x.astype(x.dtype.newbyteorder("="))), one.unit or None, one.axis)
            for one, x in data.items() if not (x.dtype.kind == "f" and np.isnan(x).all())
        )  # fmt: skip
        return Recording(channels, self.time_ns, epoch="utc" if self.utc else "elapsed")


class Taken:
    """What came since a moment, of each instrument.

    Parameters
    ----------
    layouts : mapping of str to RowLayout
        Of the instruments that give rows.
    """

    def __init__(self, layouts: dict[str, RowLayout]) -> None:
        self._layouts, self.names = layouts, tuple(layouts)
        self._came = threading.Condition()
        self._since = 0
        self._before: dict[str, int] = {}  # Monotonic reading of the last batch [ns]
        self._parts: dict[str, list[tuple[int, Rows, Times]]] = {name: [] for name in layouts}
        self.batches = 0  # since then

    def begin(self, monotonic_ns: int) -> None:
        """Forget what was asked for before this moment."""
        with self._came:
            self._since = monotonic_ns
            for parts in self._parts.values():
                parts[:] = [part for part in parts if part[0] >= monotonic_ns]
            self.batches = sum(map(len, self._parts.values()))

    def take(self, name: str, batch: Batch) -> None:
        """Take rows; those whose reading began before the moment are passed over."""
        asked = batch.at if batch.asked is None else batch.asked
        time = self._layouts[name].role("time")
        if time is None:
            at, last = batch.at, np.array([len(batch.rows) - 1])
            lot = Read(batch.rows, last, np.array([at.utc_ns]), np.array([at.monotonic_ns]))
            time_ns = arrivals(lot, self._before.get(name), self._layouts[name].interval) + at.utc_ns - at.monotonic_ns
            self._before[name] = at.monotonic_ns
        else:
            time_ns = _own_time(time, batch.rows)
        with self._came:
            if asked.monotonic_ns >= self._since:
                self._parts[name].append((asked.monotonic_ns, batch.rows, time_ns))
                self.batches += 1
                self._came.notify_all()

    def of(self, name: str) -> Since:
        """Return what came of an instrument.

        Raises
        ------
        InstrumentError
            ``clock_back`` if its clock went back.
        """
        layout = self._layouts[name]
        with self._came:
            parts = self._parts[name]
            if len(parts) > 1:  # joined once, lest each look joins all
                rows, time_ns = (np.concatenate([part[i] for part in parts]) for i in (1, 2))
                parts[:] = [(parts[0][0], rows, time_ns)]
            _, rows, time_ns = parts[0] if parts else (0, np.empty(0, layout.dtype), np.empty(0, np.int64))
        if np.any(np.diff(time_ns) < 0):
            raise InstrumentError(f"{name}: its clock went back", code="clock_back")
        return Since(layout, rows, time_ns)

    def wait(self, known: int, seconds: float) -> int:
        """Wait until there are more batches than are known, so many seconds of the machine at most; return how many."""
        with self._came:
            if self.batches <= known:
                self._came.wait(seconds)
            return self.batches


def _own_time(channel: RowChannel, rows: Rows) -> Times:
    values: NDArray[np.generic] = channel.values(rows)
    if channel.unit == "ns" and values.dtype.kind in "iu":
        return values.astype(np.int64)
    found: Times = np.rint(convert(np.asarray(values, float), channel.unit, "s") * SECOND).astype(np.int64)
    return found
