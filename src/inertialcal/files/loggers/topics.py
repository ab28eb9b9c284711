"""Topics: the sets of columns of one clock each that a file of a logger holds, of which one makes a recording.

They are called topics whatever the format calls them: messages of a flight log, groups of channels, sheets, tables,
traces. Where nobody names one, that with inertial readings is taken; where several have them, the file is refused
with the list.
"""

from __future__ import annotations

import importlib
import shlex
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError, Problem
from ...core.remarks import Remark
from ..budget import PARTS, check_count
from ..columns import Column, Content
from ..source import FileBytes, Loaded
from ..text.headers import SENSOR_WORDS, heading_within

INERTIAL, OTHER, NO_NUMBERS = 2, 1, 0  # ranks
LISTED, NAMED = 12, 5  # topics that a refusal lists, and a remark names


@dataclass(frozen=True)
class Topic:
    """What can be read of a file."""

    name: str  # As the file has it
    what: str = ""  # Its type or its columns, in words
    rows: int | None = None  # Where they are known beforehand
    rank: int = OTHER  # `INERTIAL`, `OTHER`, or `NO_NUMBERS`: nothing in it can be read

    def __str__(self) -> str:
        """Return the name, with what is known of it."""
        size = "" if self.rows is None else f"{self.rows:,} rows"
        known = ", ".join(part for part in (self.what, size) if part)
        return f"{self.name} ({known})" if known else self.name


def rank_of(columns: Iterable[tuple[str, str | None]], topic: str = "") -> int:
    """Return the rank of columns by name and unit: `INERTIAL`, if one is an axis of a gyro or an accelerometer.

    An axis that does not say of which sensor it is, is of the one that its topic is called after, as in `in_topic`.
    """
    said = [heading_within(name, unit, topic) for name, unit in columns]
    return INERTIAL if any(one.axis and one.quantity in SENSOR_WORDS for one in said) else OTHER


def in_topic(columns: Iterable[Column], topic: str) -> tuple[Column, ...]:
    """Return the columns of a topic whose name says what theirs do not: ``x`` of a table ``gyroscope``."""
    return tuple(replace(one, matrix=topic) if one.named else one for one in columns)


def choose(topics: Sequence[Topic], wanted: Sequence[str] | None, path: str) -> list[Topic]:
    """Return the topics to read: those that were named, else the one of the highest rank.

    Parameters
    ----------
    topics : sequence of Topic
        All of the file.
    wanted : sequence of str, optional
        Names.
    path : str
        File, for messages.

    Raises
    ------
    DataError
        ``wrong_column``, if there is none of a name; ``several_topics``, if several could be meant; ``no_channel``, if
        none holds numbers.
    """
    check_count(len(topics), PARTS, "topics", path)
    readable = [one for one in topics if one.rank > NO_NUMBERS and one.rows != 0]
    if wanted:
        by_name = {one.name: one for one in topics}
        missing = [name for name in wanted if name not in by_name]
        if missing:
            what = f"no topic {missing[0]!r}"
            raise DataError(what, where=path, do=f"The file has: {_listed(readable or topics)}", code="wrong_column")
        return [by_name[name] for name in dict.fromkeys(wanted)]
    if not readable:
        holds = f"It holds: {_listed(topics)}" if topics else "It holds nothing"
        raise DataError("nothing in it is a series of numbers", where=path, do=holds, code="no_channel")
    highest = max(one.rank for one in readable)
    first = [one for one in readable if one.rank == highest]
    if len(first) > 1:
        raise DataError(
            Problem(
                f"holds {len(first)} recordings: {_listed(first)}",
                where=path,
                why="each has a clock of its own",
                do=f"Choose: --topic {shlex.quote(first[0].name)}",
                code="several_topics",
                choices=tuple(one.name for one in first[:LISTED]),
            )
        )
    return first


def _listed(topics: Sequence[Topic], most: int = LISTED) -> str:
    more = f", ... ({len(topics) - most} more)" if len(topics) > most else ""
    return ", ".join(map(str, topics[:most])) + more


def other_topics(topics: Sequence[Topic], taken: Sequence[Topic], path: str) -> tuple[Remark, ...]:
    """Return a remark on the topics that are not read, with their number."""
    names = {one.name for one in taken}
    others = [one for one in topics if one.name not in names]
    if not others:
        return ()
    what = f"other topics, not read: {_listed(sorted(others, key=lambda one: -one.rank), NAMED)}"
    do = "To read another: --topic NAME"
    return (Remark("other_topics", "info", what, where=path, count=len(others), do=do),)


def left_out(names: Sequence[str], path: str, why: str = "not numbers") -> tuple[Remark, ...]:
    """Return a remark on columns that are not read, with their number."""
    some = ", ".join(names[:NAMED]) + (", ..." if len(names) > NAMED else "")
    remark = Remark("variables_left_out", "info", f"{why}, left out: {some[:120]}", where=path, count=len(names))
    return (remark,) if names else ()


def torn(path: str, rest: int, at: int, why: str = "it ends in the middle of a record") -> tuple[Remark, ...]:
    """Return a remark on what of a file is not whole: so many bytes, from one on; none: what was never written."""
    missing = f"{rest:,} bytes from byte {at:,} on are not read" if rest else "what was not yet written is missing"
    do = "Was the logger switched off while it wrote?"
    return (Remark("torn_file", "warning", f"{why}: {missing}", where=path, count=max(rest, 1), do=do),)


def frame_remark(frame: str, path: str) -> tuple[Remark, ...]:
    """Return a remark on the axes of the readings, as the format or the file states them."""
    return (Remark("frame_stated", "info", f"axes: {frame}", where=path),) if frame else ()


def joined(parts: Sequence[tuple[Topic, Content]], path: str) -> Content:
    """Return the columns of several topics whose stamps are the same, the first column of each being its time.

    Raises
    ------
    DataError
        ``several_clocks``, if they are not.
    """
    (first, content), *others = parts
    columns, remarks = list(content.columns), content.remarks
    for topic, other in others:
        if not np.array_equal(other.columns[0].values, columns[0].values):
            raise DataError(
                f"topics {first.name} and {topic.name} have different stamps",
                where=path,
                why="they cannot share a clock",
                do="Read one at a time",
                code="several_clocks",
            )
        taken = {one.name for one in columns}
        for one in other.columns[1:]:
            name = one.name if one.name not in taken else f"{topic.name}.{one.name}"
            columns.append(Column(name, one.values, one.unit, one.named, one.matrix, one.axis, one.empty,
                                  one.not_a_number))  # fmt: skip
        remarks += other.remarks
    return Content(tuple(columns), content.format, content.rows, content.sample_rate, remarks, content.time_ns)


def stamps(time_ns: NDArray[np.int64], utc: bool) -> Column:
    """Return the time as a column: instants since 1970, or a count of nanoseconds from a zero of its own."""
    return Column("time", time_ns.view("datetime64[ns]")) if utc else Column("time", time_ns, "ns")


def library(name: str, what: str, path: str, doing: str = "reading") -> ModuleType:
    """Return a module of the extra ``formats``.

    Raises
    ------
    DataError
        ``missing_extra``, if it is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        package = name.partition(".")[0]
        raise DataError(
            f"this is {what}: {doing} it needs the package {package}, which is not installed",
            where=path,
            do="Type: pip install 'inertialcal[formats]'",
            code="missing_extra",
        ) from None


@contextmanager
def on_disk(loaded: Loaded, ending: str) -> Iterator[str]:
    """Yield the path of a file with this content: the file itself, or a copy of what was read of it."""
    if isinstance(loaded.data, FileBytes):
        yield loaded.path
        return
    with tempfile.TemporaryDirectory(prefix="inertialcal-") as folder:
        path = Path(folder) / f"file{ending}"
        path.write_bytes(loaded.data)
        yield str(path)


def unique(names: Sequence[str]) -> list[str]:
    """Return the names, those that stand again with a number behind: ``x``, ``x_2``."""
    found: list[str] = []
    for name in names:
        one, number = name, 2
        while one in found:
            one, number = f"{name}_{number}", number + 1
        found.append(one)
    return found
