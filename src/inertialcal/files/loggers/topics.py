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

from ...core.batches import SIZE
from ...core.errors import DataError, Problem
from ...core.remarks import Remark
from ..budget import PARTS, check_count
from ..columns import Column, Content, LongColumns
from ..source import FileBytes, Loaded
from ..text.headers import SENSOR_WORDS, heading, heading_within

INERTIAL, OTHER, NO_NUMBERS = 2, 1, 0  # ranks
CONDITIONS = ("temperature", "pressure", "voltage")  # quantities that change slowly: interpolated to another clock
BEYOND = 3.0  # median steps of such a topic: further from its messages nothing is known
LISTED, NAMED = 12, 5  # topics that a refusal lists, and a remark names


@dataclass(frozen=True)
class Topic:
    """What can be read of a file."""

    name: str  # As the file has it
    what: str = ""  # Its type or its columns, in words
    rows: int | None = None  # Where they are known beforehand
    rank: int = OTHER  # `INERTIAL`, `OTHER`, or `NO_NUMBERS`: nothing in it can be read
    has_temperature: bool = False

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


def has_temperature(columns: Iterable[tuple[str, str | None]], topic: str = "") -> bool:
    """Whether one of the columns, by name and unit, is a temperature."""
    return any(heading_within(name, unit, topic).quantity == "temperature" for name, unit in columns)


def with_thermometer(topics: Sequence[Topic], chosen: Sequence[Topic], wanted: Sequence[str] | None) -> list[Topic]:
    """Return what is read, with the only thermometer of the file where nobody named topics and a sensor has none."""
    found = [one for one in topics if one.has_temperature and one.rank == OTHER and one.rows != 0]
    bare = not wanted and len(chosen) == 1 and chosen[0].rank == INERTIAL and not chosen[0].has_temperature
    return [*chosen, *found] if bare and len(found) == 1 else [*chosen]


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
            what, do = f"no topic {missing[0]!r}", f"The file has: {_listed(readable or topics)}"
            choices = tuple(one.name for one in readable[:LISTED])
            raise DataError(Problem(what, where=path, do=do, code="wrong_column", choices=choices))
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


def time_first(columns: Iterable[Column]) -> tuple[Column, ...]:
    """Return the columns of a table with its time in front, where one is clearly that."""
    return tuple(sorted(columns, key=lambda one: heading_within(one.name, one.unit, one.matrix).quantity != "time"))


def joined(parts: Sequence[tuple[Topic, Content]], path: str, *, named: bool = True) -> Content:
    """Return the columns of several topics, the first column of each being its time.

    Stamps of readings must be the same; temperatures, pressures and voltages of another clock are interpolated.

    Parameters
    ----------
    parts : sequence of (Topic, Content)
        What is to be joined.
    path : str
        File, for messages.
    named : bool
        Whether somebody named them; else what cannot be joined is left out.

    Raises
    ------
    DataError
        ``several_clocks``, if the stamps of readings differ, or no message of another clock is near them.
    """
    (first, content), *others = sorted(parts, key=lambda part: -part[0].rank)
    columns, remarks = list(content.columns), content.remarks
    for topic, other in others:
        own = other.columns
        if not np.array_equal(own[0].values, columns[0].values):
            try:
                own, said = _interpolated(columns[0], first, topic, other, path)
            except DataError as error:
                if named:
                    raise
                what = f"topic {topic.name} is not joined: {error.problems[0].what}"
                own, said = (), (Remark("not_joined", "info", what, where=path),)
            remarks += said
        taken = {one.name for one in columns}
        columns += [replace(one, name=f"{topic.name}.{one.name}") if one.name in taken else one for one in own[1:]]
        remarks += other.remarks
    return replace(content, columns=tuple(columns), remarks=remarks)


def _interpolated(
    clock: Column, first: Topic, topic: Topic, other: Content, path: str
) -> tuple[tuple[Column, ...], tuple[Remark, ...]]:
    """Return slow quantities of a topic at the stamps of another, behind a first column, and a remark on it.

    Between two messages they are taken as straight; where none is near, they are missing.
    """
    time = other.columns[0]
    slow = [one for one in other.columns[1:]
            if one.is_number and heading_within(one.name, one.unit, one.matrix).quantity in CONDITIONS]  # fmt: skip
    kinds = {(heading(one.name, one.unit).unit, one.values.dtype.kind == "M") for one in (time, clock)}
    apart = f"topics {first.name} and {topic.name} have different stamps"
    why = "they cannot share a clock"
    if (
        not slow
        or len(kinds) > 1
        or {time.values.dtype.kind, clock.values.dtype.kind} - set("iufM")
        or len(time.values) < 2
    ):
        raise DataError(apart, path, why, "Read one at a time", "several_clocks")
    zero = time.values[0]
    order = np.argsort(time.values, kind="stable")
    known = (time.values[order] - zero).astype(np.float64)
    reach = BEYOND * float(np.median(np.diff(known)))
    long = LongColumns(len(clock.values))
    empty = 0
    for at in range(0, len(clock.values), SIZE):
        wanted = (clock.values[at : at + SIZE] - zero).astype(np.float64)
        after = np.clip(np.searchsorted(known, wanted), 1, len(known) - 1)
        far = np.minimum(np.abs(wanted - known[after - 1]), np.abs(wanted - known[after])) > reach
        values = [np.where(far, np.nan, np.interp(wanted, known, one.values[order].astype(np.float64))) for one in slow]
        long.add([replace(one, values=part) for one, part in zip(slow, values, strict=True)])
        empty += int(np.sum(far))
    if empty == len(clock.values):
        raise DataError(f"{apart}, none near those of the other", path, why, "Read one at a time", "several_clocks")
    names = ", ".join(one.name for one in slow)
    what = f"{names} of topic {topic.name} ({len(known):,} messages) interpolated to the stamps of {first.name}"
    what += f"; {empty:,} of them have no message near: missing there" if empty else ""
    do = f"To leave it out, name topic {first.name} alone"
    said = Remark("joined_by_time", "warning" if empty else "info", what, where=path, do=do)
    return (clock, *long.columns()), (said,)


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
