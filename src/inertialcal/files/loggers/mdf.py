"""ASAM MDF 3 and 4, by asammdf: channels in groups, each group with a clock of its own.

Numbers are converted as the file says (linear, rational, tables); channels that this makes text are left out.
"""

from __future__ import annotations

import io
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
from .topics import NO_NUMBERS, OTHER, Topic, choose, joined, left_out, library, other_topics, torn, unique

MAGIC, UNFINISHED = b"MDF     ", b"UnFinMF "
BATCH = 2**18  # rows


def read_mdf(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the channels of a group.

    Raises
    ------
    DataError
        ``several_topics``, ``wrong_column``, ``no_channel``, ``missing_extra``, ``too_large``, ``damaged_file``.
    """
    asammdf = library("asammdf", "an ASAM MDF file", loaded.path)
    source = loaded.path if isinstance(loaded.data, FileBytes) else io.BytesIO(loaded.data)
    with asammdf.MDF(source) as file:
        check_count(sum(len(group.channels) for group in file.groups), PARTS, "channels", loaded.path)
        names = unique([_name(group, i) for i, group in enumerate(file.groups)])
        topics = [_topic(file, i, name) for i, name in enumerate(names)]
        chosen = choose(topics, variables, loaded.path)
        parts = [(one, _columns(file, names.index(one.name), one, loaded)) for one in chosen]
        content = joined(parts, loaded.path)
        start = file.header.start_time
        said = f"its time zero is {start.isoformat(sep=' ')} by the logger"
        remarks = (*content.remarks, Remark("start_stated", "info", said, where=loaded.path))
        if loaded.data.startswith(UNFINISHED):
            remarks += torn(loaded.path, 0, len(loaded.data), "the logger did not finish it")
        remarks += other_topics(topics, chosen, loaded.path)
        return Content(content.columns, f"MDF {file.version}", remarks=remarks)


def _name(group: Any, number: int) -> str:
    acquisition = getattr(group.channel_group, "acq_name", "") or getattr(group.channel_group, "comment", "")
    return str(acquisition).strip() or f"group {number}"


def _master(file: Any, number: int) -> int | None:
    found = file.masters_db.get(number)
    return None if found is None else int(found)


def _topic(file: Any, number: int, name: str) -> Topic:
    group = file.groups[number]
    names = [one.name for i, one in enumerate(group.channels) if i != _master(file, number)]
    rows = int(group.channel_group.cycles_nr)
    return Topic(name, " ".join(names[:6]), rows, OTHER if names and rows > 1 else NO_NUMBERS)


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
    return Content(long.columns(), "MDF", remarks=left_out(list(others), loaded.path))


READER = Reader(
    "mdf", "ASAM MDF", (".mf4", ".mdf", ".dat"), lambda data, path: data.startswith((MAGIC, UNFINISHED)),
    apart(read_mdf, "an ASAM MDF file"), True,
)  # fmt: skip
