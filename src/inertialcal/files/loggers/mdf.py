"""ASAM MDF 3 and 4, by asammdf: channels in groups, each group with a clock of its own.

Numbers are converted as the file says (linear, rational, tables); channels that this makes text are left out. A file
that was cut off within its last block of data is read as far as its records are whole, if its descriptions stand before
it: the library refuses it, so it is given a copy that says how much is there.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.errors import DataError
from ...core.remarks import Remark
from ..apart import apart
from ..binary.arrays import number_column
from ..budget import PARTS, VALUE, check_count, claim_room
from ..columns import Column, Content, LongColumns
from ..reader import Reader
from ..source import FileBytes, Loaded
from .topics import (
    NO_NUMBERS,
    Topic,
    choose,
    has_temperature,
    in_topic,
    joined,
    left_out,
    library,
    other_topics,
    rank_of,
    torn,
    unique,
    with_thermometer,
)

MAGIC, UNFINISHED = b"MDF     ", b"UnFinMF "
BATCH = 2**18  # rows
HEADER = 64  # byte of the header of either version
BLOCK = 24  # bytes at the begin of a block of version 4: name, length, number of links


def read_mdf(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the channels of a group.

    Raises
    ------
    DataError
        ``several_topics``, ``wrong_column``, ``no_channel``, ``missing_extra``, ``too_large``, ``damaged_file``.
    """
    asammdf = library("asammdf", "an ASAM MDF file", loaded.path)
    shorter = _cut_off(loaded)
    source = loaded.path if isinstance(loaded.data, FileBytes) else io.BytesIO(loaded.data)
    source = source if shorter is None else io.BytesIO(shorter)
    with asammdf.MDF(source) as file:
        check_count(sum(len(group.channels) for group in file.groups), PARTS, "channels", loaded.path)
        names = unique([_name(group, i) for i, group in enumerate(file.groups)])
        topics = [_topic(file, i, name) for i, name in enumerate(names)]
        chosen = with_thermometer(topics, choose(topics, variables, loaded.path), variables)
        parts = [(one, _columns(file, names.index(one.name), one, loaded)) for one in chosen]
        content = joined(parts, loaded.path, named=bool(variables))
        start = file.header.start_time
        said = f"its time zero is {start.isoformat(sep=' ')} by the logger"
        remarks = (*content.remarks, Remark("start_stated", "info", said, where=loaded.path))
        if loaded.data.startswith(UNFINISHED):
            remarks += torn(loaded.path, 0, len(loaded.data), "the logger did not finish it")
        elif shorter is not None:
            remarks += torn(loaded.path, 0, len(loaded.data), "it was cut off within its data")
        remarks += other_topics(topics, chosen, loaded.path)
        return Content(content.columns, f"MDF {file.version}", remarks=remarks)


def _cut_off(loaded: Loaded) -> bytes | None:
    """Return a file that ends within data with as many records as are there; None of one that is whole.

    Raises
    ------
    DataError
        ``damaged_file`` where descriptions lie behind its end: nothing says what its bytes are.
    """
    data, size = loaded.data, len(loaded.data)
    is_4 = data[28:30] == struct.pack("<H", 0) or int.from_bytes(data[28:30], "little") >= 400
    changes = _changes_4(data, size, loaded.path) if is_4 else _changes_3(data, size, loaded.path)
    if not changes:
        return None
    claim_room(loaded.path, loaded.on_disk, size, "a copy of the file")
    copy = bytearray(data[:size])
    for at, new in changes.items():
        copy[at : at + len(new)] = new
    return bytes(copy)


def _inside(data: bytes, form: str, at: int, path: str) -> tuple[int, ...]:
    """Return numbers of a description.

    Raises
    ------
    DataError
        ``damaged_file`` where the file ends before it.
    """
    length = struct.calcsize(form)
    if at + length > len(data):
        what = f"it was cut off: what says its channels stood behind byte {len(data):,}, where it ends"
        why = "without it nothing says what the bytes before are"
        do = "Copy it again from the logger: it is longer there"
        raise DataError(what, path, why, do, "damaged_file")
    return struct.unpack(form, data[at : at + length])


def _changes_4(data: bytes, size: int, path: str) -> dict[int, bytes]:
    """Return what a file of version 4 must say instead, by byte: length of data, records of a group."""
    changes = dict[int, bytes]()
    (group,) = _inside(data, "<Q", HEADER + BLOCK, path)
    for _ in range(PARTS):
        if not group:
            break
        following, first, content, _ = _inside(data, "<4Q", group + BLOCK, path)
        if content and data[content : content + 4] == b"##DT" and first:
            (length,) = _inside(data, "<Q", content + 8, path)
            another, *_ = _inside(data, "<6Q", first + BLOCK, path)
            _, rows, _, _, _, record, invalid = _inside(data, "<QQHHIII", first + BLOCK + 48, path)
            if content + length > size and not another and record + invalid:
                there = max(0, size - content - BLOCK) // (record + invalid)
                changes[content + 8] = struct.pack("<Q", BLOCK + there * (record + invalid))
                changes[first + BLOCK + 56] = struct.pack("<Q", min(rows or there, there))
        group = following
    return changes


def _changes_3(data: bytes, size: int, path: str) -> dict[int, bytes]:
    """Return the same of a file of version 3: records of a group."""
    changes = dict[int, bytes]()
    if data[24:26] != b"\x00\x00":  # of a big-endian computer
        return changes
    (group,) = _inside(data, "<I", HEADER + 4, path)
    for _ in range(PARTS):
        if not group:
            break
        following, first, _, content = _inside(data, "<4I", group + 4, path)
        if content and first:
            another, *_ = _inside(data, "<I", first + 4, path)
            record, rows = _inside(data, "<HI", first + 20, path)
            there = max(0, size - content) // max(record, 1)
            if record and there < rows and not another:
                changes[first + 22] = struct.pack("<I", there)
        group = following
    return changes


def _name(group: Any, number: int) -> str:
    acquisition = getattr(group.channel_group, "acq_name", "") or getattr(group.channel_group, "comment", "")
    return str(acquisition).strip() or f"group {number}"


def _master(file: Any, number: int) -> int | None:
    found = file.masters_db.get(number)
    return None if found is None else int(found)


def _topic(file: Any, number: int, name: str) -> Topic:
    group = file.groups[number]
    channels = [one for i, one in enumerate(group.channels) if i != _master(file, number)]
    said = [(one.name, str(one.unit).strip() or None) for one in channels]
    rows = int(group.channel_group.cycles_nr)
    rank = rank_of(said, name) if channels and rows > 1 else NO_NUMBERS
    return Topic(name, " ".join(one.name for one in channels[:6]), rows, rank, has_temperature(said, name))


def _columns(file: Any, number: int, topic: Topic, loaded: Loaded) -> Content:
    """Return the columns of a group, its clock first."""
    group, rows, master = file.groups[number], topic.rows or 0, _master(file, number)
    claim_room(loaded.path, loaded.on_disk, 2 * VALUE * rows * len(group.channels), f"{rows:,} records")
    kept = [i for i in range(len(group.channels)) if i != master]
    titles = dict(zip(kept, unique([group.channels[i].name for i in kept]), strict=True))
    others: dict[str, None] = {}
    long = LongColumns(rows)
    for first in range(0, rows, BATCH):
        columns: list[Column] = []
        for i in kept:
            signal = file.get(group=number, index=i, record_offset=first, record_count=min(BATCH, rows - first),
                              ignore_invalidation_bits=True)  # fmt: skip
            if not columns and master is not None:
                columns.append(Column("time", np.asarray(signal.timestamps, dtype=float), "s"))
            values = np.asarray(signal.samples)
            if values.ndim != 1 or values.dtype.kind not in "biuf" or titles[i] in others:
                others[titles[i]] = None
                continue
            bits = signal.invalidation_bits
            if bits is not None and np.any(bits):
                values = np.where(np.asarray(bits, dtype=bool), np.nan, values.astype(float))
            columns.append(number_column(titles[i], values, str(signal.unit).strip() or None))
        if any(len(one.values) != min(BATCH, rows - first) for one in columns):
            raise DataError(f"records of group {topic.name} are missing", where=loaded.path, code="damaged_file")
        long.add(columns)
    return Content(in_topic(long.columns(), topic.name), "MDF", remarks=left_out(list(others), loaded.path))


READER = Reader(
    "mdf", "ASAM MDF", (".mf4", ".mdf", ".dat"), lambda data, path: data.startswith((MAGIC, UNFINISHED)),
    apart(read_mdf, "an ASAM MDF file"), True,
)  # fmt: skip
