"""LabVIEW measurement files (LVM): text with a header for the file and one for each segment.

The time is that of the column X_Value, or of X0 and Delta_X; where segments follow each other, each begins at its own
date. A killed logger leaves a torn last row, which is left out.

References
----------
.. [1] National Instruments, Specification for the LabVIEW Measurement File (.lvm), 2023.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.recording import SECOND
from ...core.remarks import Remark
from ..apart import apart
from ..binary.arrays import number_column
from ..budget import PARTS, check_count, claim
from ..columns import Column, Content
from ..reader import Reader
from ..source import Loaded
from ..text.headers import heading
from .topics import NO_NUMBERS, OTHER, Topic, choose, left_out, other_topics, unique

MAGIC = b"LabVIEW Measurement"
END, SPECIAL, SPECIAL_END = "***End_of_Header***", "***Start_Special***", "***End_Special***"
SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";"}
CELL = 120  # bytes of a cell in Python
X, COMMENT = "X_Value", "Comment"
JOINED = 0.5  # of a step: a segment that begins so near behind the one before goes on where it ended


@dataclass
class Segment:
    """A part of a file with a header of its own."""

    head: dict[str, list[str]]  # Values of a key, one a channel
    names: list[str]  # Of the columns: X_Value, the channels, Comment
    rows: list[list[str]] = field(default_factory=list[list[str]])
    numbers: list[int] = field(default_factory=list[int])  # Lines of the rows

    def of_channel(self, key: str, i: int) -> str:
        """Return what a key says of a channel."""
        values = self.head.get(key, [])
        return values[i].strip() if i < len(values) else ""


def read_lvm(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the channels of a file, segment below segment, whatever variables are named.

    Raises
    ------
    DataError
        ``damaged_file``, ``no_channel``, ``too_large``; ``several_clocks`` where channels have times of their own.
    """
    path = loaded.path
    text = loaded.data.decode("utf-8", "replace")
    first = text[:4096]
    separator = next((sign for word, sign in SEPARATORS.items() if re.search(rf"(?im)^Separator.{word}", first)), "\t")
    cells = text.count(separator)
    claim(path, loaded.on_disk, 4 * len(text) + CELL * cells, f"{cells:,} cells")
    head, segments, special = _segments(text, separator)
    segments = [one for one in segments if one.rows]
    if not segments:
        raise DataError("no segment holds a row", where=path, do="Record again", code="no_channel")
    check_count(len(segments), PARTS, "segments", path)
    if head.get("X_Columns", [""])[0].strip().lower() == "multi":
        what, do = "each channel has a column of times of its own (X_Columns Multi)", "Save it with X_Columns One"
        raise DataError(what, where=path, do=do, code="several_clocks")
    if len({tuple(one.names) for one in segments}) > 1:
        raise DataError("segments differ in their channels", where=path, do="Cut the file there", code="several_clocks")
    decimal = head.get("Decimal_Separator", ["."])[0].strip() or "."
    used_x = head.get("X_Columns", ["One"])[0].strip().lower() != "no"
    names = segments[0].names
    channels = [i for i, name in enumerate(names) if name not in (X, COMMENT)]
    clocks: dict[tuple[str, ...], list[int]] = {}
    for number, i in enumerate(channels):
        said = () if used_x else tuple(segments[0].of_channel(key, number) for key in ("Delta_X", "X0", "Samples"))
        clocks.setdefault(said, []).append(i)
    topics, by_name = [], {}
    for own in clocks.values():
        size = sum(_samples(one, channels.index(own[0]), used_x) for one in segments)
        step = "" if used_x else f", step {segments[0].of_channel('Delta_X', channels.index(own[0]))}"
        what = " ".join(names[i] for i in own[:6]) + step
        only_time = all(heading(names[i]).quantity == "time" for i in own)
        topics.append(Topic(names[own[0]], what, size, NO_NUMBERS if only_time else OTHER))
        by_name[names[own[0]]] = own
    chosen = choose(topics, variables, path)
    taken = [i for topic in chosen for i in by_name[topic.name]]
    torn: list[int] = []
    tables, times, rows, missing = [], [], [], 0
    for one in segments:
        table, kept, bad = _table(one, decimal)
        torn += bad
        size = _samples(one, channels.index(taken[0]), used_x)
        missing += max(size - len(table) - len(bad), 0)
        tables.append(table[:size])
        rows += kept[:size]
        times.append(_clock(one, used_x, tables[-1], channels.index(taken[0])))
    table = np.concatenate(tables)
    columns: list[Column] = []
    for name, i in zip(unique([names[i] for i in taken]), taken, strict=True):
        unit = segments[0].of_channel("Y_Unit_Label", channels.index(i))
        columns.append(number_column(name, table[:, i], unit or None))
    time, remarks = _joined(times, path)
    time = tuple(replace(one, name=unique([*(c.name for c in columns), one.name])[-1]) for one in time)
    remarks += left_out([f"{special} special blocks"] if special else [], path)
    if torn:
        what = "rows that are torn, or hold what is no number: left out"
        remarks += (Remark("torn_file", "warning", what, f"{path}:{torn[0]}", len(torn)),)
    if missing:
        what = "rows that the header promises are missing"
        remarks += (Remark("torn_file", "warning", what, path, missing, "Was the logger switched off?"),)
    remarks += other_topics(topics, chosen, path)
    what = f"LabVIEW measurement, {len(segments)} segment(s)"
    return Content((*time, *columns), what, np.array(rows, dtype=np.int64), None, remarks)


def _samples(one: Segment, number: int, used_x: bool) -> int:
    """Return the samples of a channel in a segment, as its header says."""
    said = one.of_channel("Samples", number)
    return int(said) if said.isdigit() and len(said) < 12 and (not used_x or int(said) > 0) else len(one.rows)


def _segments(text: str, separator: str) -> tuple[dict[str, list[str]], list[Segment], int]:
    """Return the header of the file, its segments, and the number of special blocks."""
    header: dict[str, list[str]] = {}
    head: dict[str, list[str]] = {}
    segments: list[Segment] = []
    inside, of_file, names_next, special, skipped = True, True, False, 0, False
    lines = text.split("\n")
    whole = text.endswith("\n")
    for number, line in enumerate(lines, start=1):
        line = line.rstrip("\r")
        first, *rest = line.split(separator)
        if first.strip() == SPECIAL:
            special, skipped = special + 1, True
        if skipped:
            skipped = first.strip() != SPECIAL_END
            continue
        if names_next and line.strip():
            if first.strip() != X and first.strip().startswith("Channels"):
                names_next, inside = False, True
            else:
                segments.append(Segment(head, [name.strip() for name in [first, *rest]]))
                while segments[-1].names and not segments[-1].names[-1]:
                    segments[-1].names.pop()
                names_next, head = False, {}
                continue
        if first.strip() == END:
            if of_file:
                header, head, of_file = head, {}, False
            else:
                inside, names_next = False, True
        elif not inside and segments and (first.strip() == "Channels" or not line.strip(" \t,;")):
            inside = inside or first.strip() == "Channels"
            if inside:
                head = {"Channels": rest}
        elif inside and line.strip():
            head[first.strip()] = rest
        elif not inside and segments and line.strip():
            segments[-1].rows.append([first, *rest])
            segments[-1].numbers.append(number if whole or number < len(lines) else -number)
    return header, segments, special


def _table(one: Segment, decimal: str) -> tuple[NDArray[Any], list[int], list[int]]:
    """Return the numbers of a segment, the lines of its rows, and of those that are left out."""
    values, kept, bad = [], [], []
    last = max((i for i, name in enumerate(one.names) if name != COMMENT), default=0)
    width = len(one.names)
    for row, number in zip(one.rows, one.numbers, strict=True):
        try:
            if len(row) <= last or number < 0:
                raise ValueError(row)
            cells = [cell.strip().replace(decimal, ".") if decimal != "." else cell.strip() for cell in row[:width]]
            texts = [name == COMMENT for name in one.names]
            numbers = [
                np.nan if is_text or not cell else float(cell) for cell, is_text in zip(cells, texts, strict=False)
            ]
            values.append(numbers + [np.nan] * (width - len(numbers)))
            kept.append(number)
        except ValueError:
            bad.append(abs(number))
    return np.array(values, dtype=float).reshape(len(values), width), kept, bad


def _clock(one: Segment, used_x: bool, table: NDArray[Any], number: int) -> tuple[datetime | None, NDArray[Any] | None]:
    """Return when a segment begins, and the seconds of its rows since then, by the clock of a channel."""
    day, time = one.of_channel("Date", number), one.of_channel("Time", number)
    start: datetime | None = None
    try:
        hours, _, fraction = time.replace(",", ".").partition(".")
        start = datetime.strptime(f"{day} {hours}", "%Y/%m/%d %H:%M:%S")
        start += timedelta(seconds=float(f"0.{fraction or 0}"))
    except ValueError:
        start = None
    if used_x and X in one.names:
        seconds = table[:, one.names.index(X)]
        if len(seconds) < 2 or np.any(np.diff(seconds) != 0):
            return start, seconds
    try:
        zero, step = (float(one.of_channel(key, number).replace(",", ".") or 0) for key in ("X0", "Delta_X"))
    except ValueError:
        return start, None
    return start, zero + step * np.arange(len(table)) if step > 0 else None


def _joined(
    clocks: Sequence[tuple[datetime | None, NDArray[Any] | None]], path: str
) -> tuple[tuple[Column, ...], tuple[Remark, ...]]:
    """Return the time of all segments, from the start of the first, and what is said of it."""
    first = clocks[0][0]
    parts = []
    for start, seconds in clocks:
        if seconds is None:
            return (), ()
        begins = seconds[0] if len(seconds) else 0.0
        later = 0.0 if start is None or first is None else (start - first).total_seconds()
        goes_on = bool(parts) and begins > parts[-1][-1] - JOINED * (
            seconds[1] - seconds[0] if len(seconds) > 1 else 0.0
        )
        parts.append(seconds if goes_on or not parts else seconds + later)
    said = "" if first is None else f"its time zero is {first.isoformat(sep=' ')}, local time of the logger"
    remark = Remark("start_stated", "info", said, where=path)
    time_ns = np.rint(np.concatenate(parts) * SECOND)
    if not np.all(np.isfinite(time_ns)) or np.any(np.abs(time_ns) > 2**62):
        return (), (remark,) if said else ()
    return (Column("time", time_ns.astype(np.int64), "ns"),), (remark,) if said else ()


READER = Reader(
    "lvm", "LabVIEW measurement (LVM)", (".lvm",), lambda data, path: data.startswith(MAGIC),
    apart(read_lvm, "a LabVIEW measurement file"),
)  # fmt: skip
