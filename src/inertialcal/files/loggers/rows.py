"""Rows of an acquisition in MCAP: what `inertialcal acquire` records.

A message holds the rows of one instrument that came together, packed as its schema says; its time of recording is UTC,
its time of publication the monotonic reading of the same moment, and its sequence number goes up by one: what was lost
in the middle of a file is seen. Rows that came together are spread evenly over the time since those before them, but by
no more than the interval that the instrument was said to have.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.recording import SECOND, Times
from ...core.remarks import Remark
from ..binary.arrays import number_column
from ..budget import COLUMNS, check_count, claim_room
from ..columns import Column, Content, LongColumns
from .topics import stamps

if TYPE_CHECKING:
    from .bags import Bag, Messages

ENCODING, LIBRARY = "inertialcal.rows", "inertialcal.acquire"  # of messages; who wrote the file
HEAD = 22  # bytes of channel, sequence and both times in front of the content of a message
Role = Literal["reading", "time", "counter"]
Rows = NDArray[np.void]


@dataclass(frozen=True)
class RowChannel:
    """One number of a row, as it comes: ``value * scale + offset`` is in the unit."""

    name: str
    type: str  # As numpy names it, without byte order: ``"int32"``, ``"float64"``
    unit: str = ""  # Empty: not known
    scale: float = 1.0
    offset: float = 0.0
    axis: str = ""  # ``"x"``, ``"y"``, ``"z"``, or empty
    role: Role = "reading"  # ``"time"``: the instrument's own clock; ``"counter"``: goes up by one with each row

    def values(self, rows: Rows) -> NDArray[Any]:
        """Return its numbers in its unit, shape (n,): in the type in which they came, unless they are scaled."""
        raw = rows[self.name]
        return raw if (self.scale, self.offset) == (1.0, 0.0) else raw * self.scale + self.offset


@dataclass(frozen=True)
class RowLayout:
    """Channels of a row, in order."""

    channels: tuple[RowChannel, ...]
    interval: float | None = None  # From row to row, as it was said [s]
    clock_within: float | None = None  # What its clock may be off, as it was said, relative [1]

    @property
    def dtype(self) -> np.dtype[np.void]:
        """Type of rows as they are recorded: packed, little endian."""
        return np.dtype([(one.name, np.dtype(one.type).newbyteorder("<")) for one in self.channels])

    def role(self, role: Role) -> RowChannel | None:
        """Return the channel of a role."""
        return next((one for one in self.channels if one.role == role), None)

    def schema(self) -> bytes:
        """Return it as the schema of messages."""
        said = {"interval": self.interval, "clock_within": self.clock_within}
        return json.dumps({**said, "channels": [asdict(one) for one in self.channels]}).encode()


def layout_in(schema: bytes, path: str) -> RowLayout:
    """Return the layout that a schema states.

    Raises
    ------
    DataError
        ``damaged_file``.
    """
    try:
        said = json.loads(schema)
        interval, within = (None if one is None else float(one) for one in (said["interval"], said.get("clock_within")))
        found = RowLayout(tuple(_channel(one) for one in said["channels"]), interval, within)
        check_count(len(found.channels), COLUMNS, "channels", path)
        if any(dtype.kind not in "iuf" for dtype, *_ in (found.dtype.fields or {}).values()):
            raise ValueError
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        raise DataError("the schema of a topic is damaged", where=path, code="damaged_file") from None
    return found


def _channel(said: dict[str, Any]) -> RowChannel:
    found = RowChannel(**said)
    texts = (found.name, found.type, found.unit, found.axis, found.role)
    if not all(isinstance(one, str) for one in texts):
        raise ValueError
    if not (np.isfinite(found.scale) and np.isfinite(found.offset)):
        raise ValueError
    return found


@dataclass(frozen=True, eq=False)
class Read:
    """Messages of one instrument that follow each other: rows, and for each message when they came."""

    rows: Rows  # shape (n,)
    last: Times  # shape (m,): index of the last row of each message
    utc_ns: Times  # shape (m,)
    monotonic_ns: Times  # shape (m,)


def reads(bag: Bag, topic: str, layout: RowLayout) -> Iterator[Read]:
    """Yield what was recorded of an instrument, up to where the file stops being whole; remarks go to the bag."""
    due, missing = None, 0
    for part in bag.messages():
        found = read_of(part, bag, topic, layout)
        if found is None:
            continue
        lot, sequence = found
        begin = sequence[0] if due is None else due
        missing += int(np.sum((np.diff(sequence, prepend=begin - 1) - 1) % 2**32))
        due = int(sequence[-1]) + 1
        yield lot
    if missing:
        what = f"messages of topic {topic} that are missing inside the file"
        do = "Copy it again from the computer that recorded: it was damaged since"
        bag.remarks += (Remark("messages_missing", "warning", what, where=bag.path, count=missing, do=do),)


def read_of(part: Messages, bag: Bag, topic: str, layout: RowLayout) -> tuple[Read, Times] | None:
    """Return what some messages hold of an instrument, and their sequence numbers; None if that is nothing.

    Raises
    ------
    DataError
        ``damaged_file``.
    """
    keys = [key for key, one in bag.connections.items() if one.topic == topic]
    own = np.flatnonzero(np.isin(part.keys, keys))
    if not len(own):
        return None
    heads = np.frombuffer(part.data, np.uint8)[(part.first[own] - HEAD)[:, None] + np.arange(HEAD)]
    sequence = np.ascontiguousarray(heads[:, 2:6]).view("<u4")[:, 0].astype(np.int64)
    monotonic = np.ascontiguousarray(heads[:, 14:22]).view("<i8")[:, 0]
    content, size = b"".join(part.content(own)), layout.dtype.itemsize
    counts = (part.stop - part.first)[own]
    if np.any(counts % size) or not len(content):
        raise DataError(f"messages of topic {topic} are no rows", where=bag.path, code="damaged_file")
    last = np.cumsum(counts // size) - 1
    return Read(np.frombuffer(content, layout.dtype), last, part.time_ns[own], monotonic), sequence


def arrivals(read: Read, before: int | None, interval: float | None) -> Times:
    """Return when each row came [ns, monotonic], shape (n,): those of a message evenly since the one before it."""
    counts = np.diff(read.last, prepend=-1)
    apart = np.diff(read.monotonic_ns, prepend=read.monotonic_ns[0] if before is None else before)
    step = np.maximum(apart, 0) / counts
    if before is None:
        step[0] = (step[1] if len(step) > 1 else 0.0) if interval is None else interval * SECOND
    step = step if interval is None else np.minimum(step, interval * SECOND)
    behind = np.repeat(read.last, counts) - np.arange(len(read.rows))
    found: Times = np.repeat(read.monotonic_ns, counts) - np.rint(behind * np.repeat(step, counts)).astype(np.int64)
    return found


def rows_content(bag: Bag, topic: str, layout: RowLayout) -> Content:
    """Return the readings of an instrument."""
    count = sum(len(one.rows) for one in reads(bag, topic, layout))
    if not count:
        raise DataError(f"no row of topic {topic} is whole", where=bag.path, code="damaged_file")
    claim_room(bag.path, bag.size, 8 * count * (len(layout.channels) + 1), f"{count:,} rows")
    long, before = LongColumns(count), None
    offset: int | None = None
    for one in reads(bag, topic, layout):
        offset = int(one.utc_ns[0] - one.monotonic_ns[0]) if offset is None else offset
        time_ns = arrivals(one, before, layout.interval) + offset
        before = int(one.monotonic_ns[-1])
        long.add([Column("0", time_ns), *(Column(each.name, each.values(one.rows)) for each in layout.channels)])
    time_ns, *values = (column.values for column in long.columns())
    made = [
        number_column(each.name, data, each.unit or None) for each, data in zip(layout.channels, values, strict=True)
    ]
    return Content((stamps(time_ns, utc=True), *made), bag.title)
