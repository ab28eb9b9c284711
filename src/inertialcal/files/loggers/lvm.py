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
from .topics import NO_NUMBERS, Topic, choose, left_out, other_topics, rank_of, unique

MAGIC = b"LabVIEW Measurement"
END, SPECIAL, SPECIAL_END = "***End_of_Header***", "***Start_Special***", "***End_Special***"
SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";"}
CELL = 120  # bytes of a cell in Python
COMMENT = "Comment"
TIME_UNITS = ("s", "ms", "us")
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
    """Return the channels of a file that share a clock, segment below segment.

    Raises
    ------
    DataError
        ``damaged_file``, ``no_channel``, ``too_large``, ``several_topics``, ``wrong_column``; ``several_clocks`` where
        channels have columns of times of their own.
    """
    path = loaded.path
    text = loaded.data.decode("utf-8", "replace")
    first = text[:4096]
    separator = next((sign for word, sign in SEPARATORS.items() if re.search(rf"(?im)^Separator.{word}", first)), "\t")
    cells = text.count(separator)
    claim(path, loaded.on_disk, 4 * len(text) + CELL * cells, f"{cells:,} cells")
    head, segments, special = _segments(text, separator)
    used_x = head.get("X_Columns", ["One"])[0].strip().lower() != "no"
    _check_segments(head, segments, path)
    topics, by_name = _topics(segments, used_x)
    chosen = choose(topics, variables, path)
    taken = [i for topic in chosen for i in by_name[topic.name]]
    if len({_clock_of(segments[0], i, used_x) for i in taken}) > 1:
        raise DataError(
            "these channels have different clocks", where=path, do="Read one at a time", code="several_clocks"
        )
    decimal = head.get("Decimal_Separator", ["."])[0].strip() or "."
    torn: list[int] = []
    tables, times, rows, missing = [], [], [], 0
    for one in segments:
        table, kept, bad = _table(one, decimal)
        torn += bad
        size = _samples(one, taken[0] - 1, used_x)
        missing += max(size - len(table) - len(bad), 0)
        tables.append(table[:size])
        rows += kept[:size]
        times.append(_clock(one, used_x, tables[-1], taken[0] - 1))
    table = np.concatenate(tables)
    remarks = _damage(torn, missing, path) + left_out([f"{special} special blocks"] if special else [], path)
    columns: list[Column] = []
    for name, i in zip(unique([segments[0].names[i] for i in taken]), taken, strict=True):
        unit = segments[0].of_channel("Y_Unit_Label", i - 1) or None
        if unit in TIME_UNITS and heading(name).quantity != "time":  # LabVIEW puts the unit of X there
            what = f"{unit!r} as the unit of {name!r}: ignored"
            remarks += (Remark("unknown_unit", "info", what, where=path, subject=name),)
            unit = None
        columns.append(number_column(name, table[:, i], unit))
    time, said = _joined(times, path)
    time = tuple(replace(one, name=unique([*(c.name for c in columns), one.name])[-1]) for one in time)
    remarks += said + other_topics(topics, chosen, path)
    what = f"LabVIEW measurement, {len(segments)} segment(s)"
    return Content((*time, *columns), what, np.array(rows, dtype=np.int64), None, remarks)


def _check_segments(head: dict[str, list[str]], segments: list[Segment], path: str) -> None:
    """Refuse what is no series of rows; leave out segments without rows."""
    segments[:] = [one for one in segments if one.rows]
    if not segments:
        raise DataError("no segment holds a row", where=path, do="Record again", code="no_channel")
    check_count(len(segments), PARTS, "segments", path)
    if head.get("X_Columns", [""])[0].strip().lower() == "multi":
        what, do = "each channel has a column of times of its own (X_Columns Multi)", "Save it with X_Columns One"
        raise DataError(what, where=path, do=do, code="several_clocks")
    if len({tuple(one.names) for one in segments}) > 1:
        raise DataError("segments differ in their channels", where=path, do="Cut the file there", code="several_clocks")


def _clock_of(one: Segment, i: int, used_x: bool) -> tuple[str, ...]:
    return () if used_x else tuple(one.of_channel(key, i - 1) for key in ("Delta_X", "X0", "Samples"))


def _topics(segments: Sequence[Segment], used_x: bool) -> tuple[list[Topic], dict[str, list[int]]]:
    """Return the sets of channels of one clock, each called after its first, and the columns of each."""
    first, clocks = segments[0], dict[tuple[str, ...], list[int]]()
    for i, name in enumerate(first.names):
        if i > 0 and name != COMMENT:  # the first column is that of X, whatever it is called
            clocks.setdefault(_clock_of(first, i, used_x), []).append(i)
    topics, by_name = [], {}
    for own in clocks.values():
        size = sum(_samples(one, own[0] - 1, used_x) for one in segments)
        step = "" if used_x else f", step {first.of_channel('Delta_X', own[0] - 1)}"
        what = " ".join(first.names[i] for i in own[:6]) + step
        rank = rank_of((first.names[i], first.of_channel("Y_Unit_Label", i - 1) or None) for i in own)
        only_time = all(heading(first.names[i]).quantity == "time" for i in own)
        topics.append(Topic(first.names[own[0]], what, size, NO_NUMBERS if only_time else rank))
        by_name[first.names[own[0]]] = own
    return topics, by_name


def _samples(one: Segment, number: int, used_x: bool) -> int:
    """Return the samples of a channel in a segment, as its header says."""
    said = one.of_channel("Samples", number)
    return int(said) if said.isdigit() and len(said) < 12 and (not used_x or int(said) > 0) else len(one.rows)


def _damage(torn: Sequence[int], missing: int, path: str) -> tuple[Remark, ...]:
    """Return remarks on rows that are torn, and on those that are not there."""
    remarks: tuple[Remark, ...] = ()
    if torn:
        what = "rows that are torn, or hold what is no number: left out"
        remarks += (Remark("torn_file", "warning", what, f"{path}:{torn[0]}", len(torn)),)
    if missing:
        what, do = "rows that the header promises are missing", "Was the logger switched off while it wrote?"
        remarks += (Remark("torn_file", "warning", what, path, missing, do),)
    return remarks


def _segments(text: str, separator: str) -> tuple[dict[str, list[str]], list[Segment], int]:
    """Return the header of the file, its segments, and the number of special blocks."""
    lines = text.split("\n")
    torn_line = 0 if text.endswith("\n") else len(lines)
    reader = _LineReader()
    for number, line in enumerate(lines, start=1):
        reader.take(line.rstrip("\r").split(separator), -number if number == torn_line else number)
    return reader.header, reader.segments, reader.special


class _LineReader:
    """What the lines of a file say, one after the other."""

    def __init__(self) -> None:
        self.header: dict[str, list[str]] = {}
        self.segments: list[Segment] = []
        self.special = 0
        self._head: dict[str, list[str]] = {}
        self._place = "header of the file"  # or "header", "names", "rows", "between", "special"
        self._outside = ""  # the place around a special block

    def take(self, cells: list[str], number: int) -> None:
        """Take over a line; a number below zero is that of a line without an end."""
        first, blank = cells[0].strip(), not "".join(cells).strip()
        if first == SPECIAL:
            self.special += 1
            self._outside, self._place = self._place, "special"
        elif self._place == "special":
            self._place = self._outside if first == SPECIAL_END else "special"
        elif first == END:
            if self._place == "header of the file":
                self.header, self._head, self._place = self._head, {}, "between"
            else:
                self._place = "names"
        elif first == "Channels":
            self._head, self._place = {first: cells[1:]}, "header"
        elif not blank:
            self._content(first, cells, number)

    def _content(self, first: str, cells: list[str], number: int) -> None:
        if self._place.startswith("header"):
            self._head[first] = cells[1:]
        elif self._place == "names":
            names = [cell.strip() for cell in cells]
            while names and not names[-1]:
                names.pop()
            self.segments.append(Segment(self._head, names))
            self._place = "rows"
        elif self._place == "rows":
            self.segments[-1].rows.append(cells)
            self.segments[-1].numbers.append(number)


def _table(one: Segment, decimal: str) -> tuple[NDArray[Any], list[int], list[int]]:
    """Return the numbers of a segment, the lines of its rows, and of those that are left out."""
    values, kept, bad = [], [], []
    last = max((i for i, name in enumerate(one.names) if name != COMMENT), default=0)
    width = len(one.names)
    for row, number in zip(one.rows, one.numbers, strict=True):
        try:
            if len(row) <= last or number < 0:
                raise ValueError(row)
            cells = [cell.strip().replace(decimal, ".") for cell in row[:width]]
            of_row = zip(one.names, cells, strict=False)
            numbers = [np.nan if name == COMMENT or not cell else float(cell) for name, cell in of_row]
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
    if used_x and table.shape[1]:
        seconds = table[:, 0]
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
    parts: list[NDArray[Any]] = []
    for start, seconds in clocks:
        if seconds is None:
            return (), ()
        begins = seconds[0] if len(seconds) else 0.0
        later = 0.0 if start is None or first is None else (start - first).total_seconds()
        step = seconds[1] - seconds[0] if len(seconds) > 1 else 0.0
        goes_on = bool(parts) and begins > parts[-1][-1] - JOINED * step
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
