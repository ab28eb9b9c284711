"""JSON lines: an object a line, its keys the columns.

Objects within objects are columns of their own (``gyro.x``), and so are the numbers of a short list (``gyro.1``). Where
a key of the objects says which sensor they are of, each sensor is a topic. A key that an object lacks is an empty cell.
"""

from __future__ import annotations

import json
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...core.key import AXES
from ...core.recording import SECOND
from ...core.remarks import Remark
from ..budget import COLUMNS, LINE, PARTS, VALUE, check_count, claim, claim_room
from ..columns import Column, Content, LongColumns
from ..reader import Reader
from ..source import Loaded, as_data_errors
from ..text.headers import heading
from ..text.layout import BLANKS, judge
from .topics import (
    INERTIAL,
    NO_NUMBERS,
    OTHER,
    Topic,
    choose,
    has_temperature,
    in_topic,
    joined,
    left_out,
    other_topics,
    time_first,
    torn,
    with_thermometer,
)

PIECE = 2**20  # bytes that are looked at together
BATCH = 2**12  # rows
CELL = 128  # bytes of a cell in Python
LIST = 32  # numbers of a list that are columns: a longer one is a series of its own
DEEPEST = 8  # objects within objects
BEGINNING = 2**16  # bytes that tell the format
MARK = b"\xef\xbb\xbf"  # of UTF-8
SENSOR = ("topic", "sensor", "stream", "type")  # keys that may say of which sensor an object is
ALL = "objects"  # the topic where none does
READINGS = ("gyr", "acc", "imu")  # in the name of a sensor
ALIKE = 1000  # objects whose names and types are remembered
DECODER = json.JSONDecoder()
STAMPS = (("sec", "nsec"), ("sec", "nanosec"), ("secs", "nsecs"), ("seconds", "nanos"))
STAMP = "_ns"  # at the end of the name of such a stamp
NUMBER, TEXT = 1, 2  # kinds of cells; 0: none that is filled
Cells = dict[str, Any]  # By column; lists and objects that are no cells too


@dataclass
class _Table:
    """What the objects of a sensor hold."""

    kinds: dict[str, int] = field(default_factory=dict[str, int])  # The most that its cells are, by column
    left_out: dict[str, None] = field(default_factory=dict[str, None])  # Columns of what is no cell
    rows: int = 0
    seen: set[tuple[Any, ...]] = field(default_factory=set[tuple[Any, ...]])  # Names and types of some objects

    def add(self, cells: Cells, where: str) -> None:
        """Take over what an object holds."""
        self.rows += 1
        alike = (*cells, *map(type, cells.values()))
        if alike in self.seen:
            return
        if len(self.seen) < ALIKE:
            self.seen.add(alike)
        for name, value in cells.items():
            if isinstance(value, list | dict):
                self.left_out[name] = None
            else:
                kind = 0 if value is None else TEXT if isinstance(value, str) else NUMBER
                self.kinds[name] = max(kind, self.kinds.get(name, 0))
        check_count(len(self.kinds) + len(self.left_out), COLUMNS, "columns", where)


@dataclass(frozen=True)
class _Survey:
    """What a file holds."""

    tables: dict[str, _Table]  # By sensor
    key: str | None  # That says the sensor
    remarks: tuple[Remark, ...]


def read_json_lines(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of the objects of a sensor: the one that was named, or the only one with readings.

    Raises
    ------
    DataError
        ``several_topics``, ``wrong_column``, ``no_channel``, ``too_large``, ``too_many``, ``several_clocks``.
    """
    path = loaded.path
    with as_data_errors(path, "JSON lines"):
        survey = _survey(loaded)
        topics = [_topic(name, one) for name, one in survey.tables.items()]
        chosen = with_thermometer(topics, choose(topics, variables, path), variables)
        parts = []
        for one in chosen:
            columns, rows = _columns(loaded, survey, one.name)
            columns = time_first(columns) if len(chosen) > 1 else columns
            gone = [name for name in survey.tables[one.name].left_out if name not in {own.name for own in columns}]
            parts.append((one, Content(in_topic(columns, one.name), "JSON lines", rows, None, left_out(gone, path))))
        found = joined(parts, path, named=bool(variables))
        return replace(found, remarks=(*survey.remarks, *found.remarks, *other_topics(topics, chosen, path)))


def _topic(name: str, table: _Table) -> Topic:
    numbers = [column for column, kind in table.kinds.items() if kind == NUMBER]
    rank = INERTIAL if any(word in name.lower() for word in READINGS) else OTHER
    warm = has_temperature(((one, None) for one in numbers), name)
    return Topic(name, " ".join(list(table.kinds)[:6]), table.rows, rank if numbers else NO_NUMBERS, warm)


def _survey(loaded: Loaded) -> _Survey:
    """Go through all objects: what they hold, and of which sensors they are."""
    path, key = loaded.path, None
    tables: dict[str, _Table] = {}
    bad: list[int] = []
    begin = end = 0  # of the line that is looked at
    for row, line in _lines(loaded.data):
        begin, end = end, end + len(line)
        cells = _cells(line, path)
        if cells is None:
            bad += [row] if line.strip() else []
            continue
        if not tables:
            key = next((one for one in SENSOR if isinstance(cells.get(one), str)), None)
        sensor = _sensor(cells, key)
        if sensor not in tables:
            tables[sensor] = _Table()
            check_count(len(tables), PARTS, "sensors", path)
        tables[sensor].add(cells, path)
    remarks: tuple[Remark, ...] = ()
    if bad and end == len(loaded.data) and bad[-1] == row and not line.endswith(b"\n"):
        remarks += torn(path, end - begin, begin)
        bad.pop()
    if bad:
        what = "lines that are no object: left out"
        remarks += (Remark("damaged_records", "warning", what, f"{path}:{bad[0]}", len(bad)),)
    return _Survey(tables, key, remarks)


def _columns(loaded: Loaded, survey: _Survey, sensor: str) -> tuple[tuple[Column, ...], np.ndarray[Any, Any]]:
    """Return the columns of a sensor, and the line of each row."""
    table = survey.tables[sensor]
    names = [name for name, kind in table.kinds.items() if kind and not (name == survey.key and sensor != ALL)]
    texts = [name for name in names if table.kinds[name] == TEXT]
    numbers = [name for name in names if table.kinds[name] == NUMBER]
    claim(loaded.path, loaded.on_disk, CELL * (table.rows * len(texts) + BATCH * len(names)), f"{table.rows:,} objects")
    claim_room(loaded.path, loaded.on_disk, VALUE * table.rows * (len(names) + 1), f"{table.rows:,} objects")
    long, lines = LongColumns(table.rows), LongColumns(table.rows)
    cells_of: dict[str, list[str]] = {name: [] for name in texts}
    for rows, objects in _batches(loaded, survey.key, sensor):
        lines.add([Column("line", np.array(rows, dtype=np.int64))])
        if numbers:
            long.add([_numbers(name, [cells.get(name) for cells in objects]) for name in numbers])
        for name, cells in cells_of.items():
            cells += [_as_text(one.get(name)) for one in objects]
    made = {one.name: one for one in (long.columns() if numbers else ())}
    for name, cells in cells_of.items():
        judged = judge(cells)
        values = np.array([*cells, None], dtype=object)[:-1] if len(judged.text) else judged.values
        made[name] = Column(name, values, empty=judged.empty, not_a_number=judged.not_a_number)
    return tuple(_within(made[name], made) for name in names), lines.columns()[0].values


def _within(column: Column, others: Container[str]) -> Column:
    """Return a column with what the name of the object or list says that it is of."""
    outer, _, inner = column.name.rpartition(".")
    unit = heading(outer).unit if outer and heading(column.name).unit is None else None
    if not inner.isdigit():
        return replace(column, unit=unit)
    three = [f"{outer}.{i}" in others for i in (1, 2, 3, 4)] == [True, True, True, False]
    return replace(column, unit=unit, matrix=outer, named=False, axis=AXES[int(inner) - 1] if three else "")


def _batches(loaded: Loaded, key: str | None, sensor: str) -> Iterator[tuple[list[int], list[Cells]]]:
    """Yield lines and cells of the objects of a sensor, some at a time."""
    rows, objects = list[int](), list[Cells]()
    for row, line in _lines(loaded.data):
        cells = _cells(line, loaded.path)
        if cells is not None and _sensor(cells, key) == sensor:
            rows.append(row)
            objects.append(cells)
        if len(rows) == BATCH:
            yield rows, objects
            rows, objects = [], []
    if rows:
        yield rows, objects


def _lines(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield the lines of a file with their numbers from 1, each with its end."""
    at, number = 0, 0
    rest = b""
    while at < len(data):
        piece = data[at : at + PIECE]
        at += len(piece)
        *lines, rest = (rest + piece).split(b"\n")
        for line in lines:
            number += 1
            yield number, line + b"\n"
        if len(rest) > LINE:  # too long, or no JSON lines
            break
    if rest:
        yield number + 1, rest


def _cells(line: bytes, path: str) -> Cells | None:
    """Return the cells of an object; None where a line is none."""
    if len(line) > LINE:
        check_count(len(line), LINE, "characters in a line", path)
    try:
        text = line.decode("utf-8-sig")
        found = DECODER.decode(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(found, dict):
        return None
    return dict(_flat(found, "", 1)) if "[" in text or text.find("{", text.find("{") + 1) >= 0 else found


def _flat(found: Mapping[str, Any], within: str, depth: int) -> Iterator[tuple[str, Any]]:
    """Yield the cells of an object by name."""
    for key, value in found.items():
        name = f"{within}{key}"
        if isinstance(value, dict) and (stamp := _stamp(value)) is not None:
            yield f"{name}{STAMP}", stamp
        elif isinstance(value, dict) and depth < DEEPEST:
            yield from _flat(value, f"{name}.", depth + 1)
        elif (
            isinstance(value, list)
            and 0 < len(value) <= LIST
            and not any(isinstance(one, list | dict) for one in value)
        ):
            for i, one in enumerate(value, start=1):
                yield f"{name}.{i}", one
        else:
            yield name, value


def _stamp(found: Mapping[str, Any]) -> int | None:
    """Return an object of seconds and nanoseconds, as ROS and Protobuf write stamps, as one number [ns]."""
    whole, rest = next(((a, b) for a, b in STAMPS if found.keys() == {a, b}), ("", ""))
    if not whole or type(found[whole]) is not int or type(found[rest]) is not int:
        return None
    return int(found[whole]) * SECOND + int(found[rest])


def _sensor(cells: Cells, key: str | None) -> str:
    said = None if key is None else cells.get(key)
    return said if isinstance(said, str) and said else ALL


def _as_text(value: Any) -> str:
    """Return a cell of a column that holds text."""
    return "" if value is None or isinstance(value, list | dict) else str(value).strip(BLANKS)


def _numbers(name: str, cells: Sequence[Any]) -> Column:
    """Return a column of numbers; a cell that is missing is NaN."""
    if all(type(one) is int for one in cells):
        try:
            return Column(name, np.array(cells, dtype=np.int64))
        except OverflowError:
            pass
    empty = [i for i, one in enumerate(cells) if not isinstance(one, int | float)]
    values = np.array([np.nan if not isinstance(one, int | float) else _float(one) for one in cells])
    lost = np.setdiff1d(np.flatnonzero(~np.isfinite(values)), empty)
    values[lost] = np.nan
    return Column(name, values, empty=np.array(empty, dtype=np.int64), not_a_number=lost)


def _float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:  # a whole number beyond all floats
        return np.inf


def is_json_lines(data: bytes, path: str) -> bool:
    """Whether a file begins with two lines that hold an object each, or with one and a part of the next."""
    lines = data[:BEGINNING].removeprefix(MARK).lstrip().split(b"\n", 2)
    if len(lines) < 2 or not lines[0].startswith(b"{") or not lines[1].lstrip().startswith(b"{"):
        return False
    return _cells(lines[0], path) is not None


READER = Reader("json_lines", "JSON lines", (".jsonl", ".ndjson", ".json"), is_json_lines, read_json_lines, True)
