"""Recordings of enDAQ (Slam Stick) recorders (IDE), by idelib: calibrated as the recorder says.

A channel of the recorder is a topic: its subchannels share a clock, which starts at the recorder's own time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...core.recording import SECOND
from ...core.remarks import Remark
from ...core.times import instant_text
from ..apart import apart
from ..binary.arrays import number_column
from ..budget import VALUE, claim_room
from ..columns import Column, Content, LongColumns
from ..reader import Reader
from ..source import Loaded
from .topics import (
    INERTIAL,
    NO_NUMBERS,
    OTHER,
    Topic,
    choose,
    has_temperature,
    joined,
    library,
    on_disk,
    other_topics,
    torn,
    unique,
    with_thermometer,
)

MAGIC = b"\x1a\x45\xdf\xa3"
BATCH = 2**16  # rows
HEAD = 16  # bytes of the head of an element, at most
MICRO = 1000  # nanoseconds
INERTIAL_UNITS = ("g", "deg/s", "dps", "rad/s", "m/s^2", "m/s²")
WORDS = {"Acceleration": "acc", "Rotation": "gyro"}


def read_ide(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the subchannels of a channel.

    Raises
    ------
    DataError
        ``several_topics``, ``wrong_column``, ``no_channel``, ``missing_extra``, ``too_large``, ``damaged_file``.
    """
    idelib = library("idelib", "an enDAQ recording (IDE)", loaded.path)
    whole = _whole_until(loaded.data)
    used = loaded if whole == len(loaded.data) else replace(loaded, data=loaded.data[:whole])
    with on_disk(used, ".ide") as path:
        data = idelib.importFile(path)
        recorded = [one for one in data.channels.values() if one.sessions]  # the library adds those of a Slam Stick
        lists = {one.name: one.getSession() for one in recorded}
        topics = [_topic(one, len(lists[one.name])) for one in recorded]
        chosen = with_thermometer(topics, choose(topics, variables, loaded.path), variables)
        parts = [(one, _columns(lists[one.name], one, loaded)) for one in chosen]
        content = joined(parts, loaded.path, named=bool(variables))
        start = data.sessions[0].utcStartTime if data.sessions else None
        remarks = (*content.remarks, *_start(start, loaded.path))
        if whole < len(loaded.data):
            remarks += torn(loaded.path, len(loaded.data) - whole, whole)
        return Content(content.columns, "enDAQ IDE", remarks=(*remarks, *other_topics(topics, chosen, loaded.path)))


def _topic(channel: Any, rows: int) -> Topic:
    units = [_unit(one) for one in channel.subchannels]
    what = ", ".join(
        dict.fromkeys(f"{one.units[0]} [{unit}]" for one, unit in zip(channel.subchannels, units, strict=True))
    )
    rank = INERTIAL if any(unit in INERTIAL_UNITS for unit in units) else OTHER
    warm = has_temperature(zip(map(_name, channel.subchannels), units, strict=True))
    return Topic(channel.name, what, rows, rank if rows > 1 else NO_NUMBERS, warm)


def _unit(subchannel: Any) -> str:
    return str(subchannel.units[1] or "")


def _columns(events: Any, topic: Topic, loaded: Loaded) -> Content:
    """Return the columns of a channel, its clock first."""
    rows, subchannels = topic.rows or 0, events.parent.subchannels
    claim_room(loaded.path, loaded.on_disk, 2 * VALUE * rows * (len(subchannels) + 1), f"{rows:,} rows")
    names = unique([_name(one) for one in subchannels])
    events.removeMean = False
    long = LongColumns(rows)
    for first in range(0, rows, BATCH):
        table = np.asarray(events.arraySlice(first, min(first + BATCH, rows)), dtype=float)
        stamps = np.rint(table[0] * MICRO).astype(np.int64)
        values = [number_column(name, np.ascontiguousarray(row), _unit(one) or None)
                  for name, one, row in zip(names, subchannels, table[1:], strict=True)]  # fmt: skip
        long.add([Column("time", stamps, "ns"), *values])
    return Content(long.columns(), "enDAQ IDE")


def _name(one: Any) -> str:
    """Return what a subchannel is called, its quantity in front; its range, ``X (100g)``, would read as a unit."""
    bare = str(one.name).partition(" (")[0]
    word = WORDS.get(str(one.units[0]), "")
    return f"{word}_{bare}" if word else bare


def _start(seconds: float | None, path: str) -> tuple[Remark, ...]:
    if not seconds:
        return ()
    what = f"its time zero is {instant_text(round(seconds * SECOND))} by the recorder"
    return (Remark("start_stated", "info", what, where=path),)


def _whole_until(data: bytes) -> int:
    """Return the byte at which the last whole element of the outermost level ends (EBML, RFC 8794)."""
    at, size = 0, len(data)
    while at < size:
        head = data[at : at + HEAD]
        name = _width(head, 0)
        length = _width(head, name) if name and len(head) > name else 0
        if not length or len(head) < name + length:
            break
        value = int.from_bytes(head[name : name + length], "big") & ((1 << 7 * length) - 1)
        following = at + name + length + value
        if value == (1 << 7 * length) - 1:  # of unknown size: it goes on to the end
            return size
        if following > size:
            break
        at = following
    return at


def _width(head: bytes, at: int) -> int:
    """Return the bytes of a number whose first byte says its width by its leading zeros; 0 where it says none."""
    return 9 - head[at].bit_length() if head[at] else 0


READER = Reader(
    "ide", "enDAQ IDE", (".ide",), lambda data, path: data.startswith(MAGIC),
    apart(read_ide, "an enDAQ recording (IDE)"), True,
)  # fmt: skip
