"""Tables of SQLite databases: a column a column, numbers and text told apart by what the cells hold."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...core.errors import DataError
from ...core.remarks import Remark
from ..apart import apart
from ..binary.arrays import number_column
from ..budget import COLUMNS, VALUE, check_count, claim, claim_room, size_on_disk
from ..columns import Column, Content, LongColumns
from ..reader import Reader
from ..source import Loaded
from ..text.layout import BLANKS, judge
from .database import SQLITE, is_bag_2, missing_bytes, opened, whole_pages
from .topics import (
    NO_NUMBERS,
    Topic,
    choose,
    has_temperature,
    in_topic,
    joined,
    left_out,
    on_disk,
    other_topics,
    rank_of,
    time_first,
    with_thermometer,
)

if TYPE_CHECKING:
    from sqlite3 import Connection

BATCH = 2**16  # rows
TEXT_CELL = 128  # bytes of a cell of text while it is judged
NUMBERS = ("integer", "real")


def read_sqlite(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of a table: the one that was named, or the only one with numbers.

    Raises
    ------
    DataError
        ``several_topics``, ``wrong_column``, ``no_channel``, ``too_large``, ``damaged_file``.
    """
    with on_disk(whole_pages(loaded), ".db") as path:
        connection = opened(path, loaded)
        try:
            return _content(connection, loaded, variables)
        finally:
            connection.close()


def _content(connection: Connection, loaded: Loaded, variables: Sequence[str] | None) -> Content:
    tables = connection.execute("SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite_%'")
    topics, columns_of = [], {}
    broken: dict[str, str] = {}
    for name in [str(row[0]) for row in tables]:
        columns = [str(row[1]) for row in connection.execute(f"PRAGMA table_info({_quoted(name)})")]
        check_count(len(columns), COLUMNS, "columns", loaded.path)
        rows, broken[name] = _rows(connection, name)
        query = f"SELECT * FROM {_quoted(name)} LIMIT 1"  # noqa: S608 - quoted
        first = connection.execute(query).fetchone() if rows else ()
        numbers = rows > 1 and any(isinstance(cell, int | float) for cell in first)
        rank = rank_of(((one, None) for one in columns), name) if numbers else NO_NUMBERS
        topics.append(
            Topic(name, " ".join(columns[:6]), rows, rank, has_temperature(((one, None) for one in columns), name))
        )
        columns_of[name] = columns
    beside = _not_taken_over(loaded.path)
    if beside and not any(one.rank > NO_NUMBERS for one in topics):
        raise DataError(beside[0].what, where=loaded.path, do=beside[0].do, code="no_channel")
    chosen = with_thermometer(topics, choose(topics, variables, loaded.path), variables)
    parts = []
    for topic in chosen:
        taken = in_topic(_columns(connection, topic, columns_of[topic.name], loaded), topic.name)
        taken = time_first(taken) if len(chosen) > 1 else taken
        made = {one.name for one in taken}
        remarks = left_out([name for name in columns_of[topic.name] if name not in made], loaded.path)
        missing = missing_bytes(loaded.data)
        if (why := broken[topic.name]) or missing:
            what = f"the database is damaged ({f'{missing:,} bytes at its end are gone' if missing else why})"
            do = "Rows behind that place are not read"
            remarks += (Remark("torn_file", "warning", what, where=loaded.path, count=max(missing, 1), do=do),)
        lines = range(1, (topic.rows or 0) + 1)
        parts.append((topic, Content(taken, f"SQLite, table {topic.name!r}", lines, None, remarks)))
    found = joined(parts, loaded.path, named=bool(variables))
    return replace(found, remarks=(*found.remarks, *beside, *other_topics(topics, chosen, loaded.path)))


def _not_taken_over(path: str) -> tuple[Remark, ...]:
    """Return a remark where rows that were written last lie beside the file, not yet in it."""
    if not size_on_disk(f"{path}-wal"):
        return ()
    what = f"what was written last lies in {os.path.basename(path)}-wal, which is not read"
    do = f"Close the program that writes it, or type: sqlite3 {shlex.quote(path)} 'PRAGMA wal_checkpoint(TRUNCATE)'"
    return (Remark("beside_not_read", "warning", what, where=path, do=do),)


def _rows(connection: Connection, table: str) -> tuple[int, str]:
    """Return how many rows of a table can be read, and why no more can be."""
    import sqlite3  # noqa: PLC0415 - loaded where it is needed

    rows = 0
    try:
        for _ in connection.execute(f"SELECT 1 FROM {_quoted(table)} NOT INDEXED"):  # noqa: S608 - quoted
            rows += 1
    except sqlite3.DatabaseError as error:
        return rows, str(error)
    return rows, ""


def _columns(connection: Connection, topic: Topic, names: Sequence[str], loaded: Loaded) -> tuple[Column, ...]:
    """Return the columns of a table that hold numbers or text."""
    rows = topic.rows or 0
    table = f"(SELECT * FROM {_quoted(topic.name)} NOT INDEXED LIMIT {rows})"  # noqa: S608 - quoted
    kinds: dict[str, set[str]] = {}
    for name in names:
        found = connection.execute(f"SELECT DISTINCT typeof({_quoted(name)}) FROM {table}")  # noqa: S608 - quoted
        kinds[name] = {str(kind) for (kind,) in found}
    quick = [name for name in names if kinds[name] <= {*NUMBERS, "null"} and kinds[name] != {"null"}]
    texts = [name for name in names if "text" in kinds[name] and "blob" not in kinds[name]]
    claim(loaded.path, loaded.on_disk, TEXT_CELL * rows * len(texts) + BATCH * 64 * len(names), f"{rows:,} rows")
    claim_room(loaded.path, loaded.on_disk, VALUE * rows * len(names), f"{rows:,} rows")
    long = LongColumns(rows)
    cells: dict[str, list[str]] = {name: [] for name in texts}
    cursor = connection.execute(f"SELECT {', '.join(map(_quoted, [*quick, *texts])) or 'NULL'} FROM {table}")  # noqa: S608
    while batch := cursor.fetchmany(BATCH):
        by_column = list(zip(*batch, strict=True))
        if quick:
            long.add([_numbers(name, by_column[i], kinds[name]) for i, name in enumerate(quick)])
        for i, name in enumerate(texts, start=len(quick)):
            cells[name] += ["" if cell is None else str(cell).strip(BLANKS) for cell in by_column[i]]
    made = {one.name: one for one in long.columns()}
    for name, own in cells.items():
        judged = judge(own)
        is_text = bool(len(judged.text))
        values = np.array([*own, None], dtype=object)[:-1] if is_text else judged.values
        made[name] = Column(name, values, empty=judged.empty, not_a_number=judged.not_a_number)
    return tuple(made[name] for name in names if name in made)


def _numbers(name: str, cells: Sequence[Any], kinds: set[str]) -> Column:
    if kinds == {"integer"}:
        return Column(name, np.array(cells, dtype=np.int64))
    return number_column(name, np.array([np.nan if cell is None else cell for cell in cells], dtype=float), None)


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


READER = Reader(
    "sqlite", "SQLite", (".db", ".sqlite", ".sqlite3"),
    lambda data, path: data.startswith(SQLITE) and not is_bag_2(data, path),
    apart(read_sqlite, "an SQLite database"), True,
)  # fmt: skip
