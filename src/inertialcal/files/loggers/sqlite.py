"""Tables of SQLite databases: a column a column, numbers and text told apart by what the cells hold."""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.errors import DataError
from ...core.remarks import Remark
from ..apart import apart
from ..binary.arrays import number_column
from ..budget import COLUMNS, VALUE, check_count, claim, claim_room
from ..columns import Column, Content, LongColumns
from ..reader import Reader
from ..source import Loaded
from ..text.layout import BLANKS, judge
from .bags import SQLITE, is_bag_2
from .topics import NO_NUMBERS, OTHER, Topic, choose, left_out, on_disk, other_topics

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
    with on_disk(loaded, ".db") as path:
        address = path.replace("%", "%25").replace("?", "%3f").replace("#", "%23")
        connection = sqlite3.connect(f"file:{address}?mode=ro&immutable=1", uri=True)
        try:
            return _content(connection, loaded, variables)
        finally:
            connection.close()


def _content(connection: Any, loaded: Loaded, variables: Sequence[str] | None) -> Content:
    names = [name for (name,) in connection.execute(
        "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite_%'")]  # fmt: skip
    topics, columns_of = [], {}
    for name in names:
        columns = [str(row[1]) for row in connection.execute(f"PRAGMA table_info({_quoted(name)})")]
        check_count(len(columns), COLUMNS, "columns", loaded.path)
        (rows,) = connection.execute(f"SELECT count(*) FROM {_quoted(name)}").fetchone()  # noqa: S608 - quoted
        first = connection.execute(f"SELECT * FROM {_quoted(name)} LIMIT 1").fetchone() or ()  # noqa: S608
        numbers = rows > 1 and any(isinstance(cell, int | float) for cell in first)
        topics.append(Topic(name, " ".join(columns[:6]), rows, OTHER if numbers else NO_NUMBERS))
        columns_of[name] = columns
    chosen = choose(topics, variables, loaded.path)
    if len(chosen) > 1:
        raise DataError("several tables", where=loaded.path, do="Read one at a time", code="several_clocks")
    (topic,) = chosen
    names, rows = columns_of[topic.name], topic.rows or 0
    kinds = {name: _kinds(connection, topic.name, name) for name in names}
    quick = [name for name in names if kinds[name] <= {*NUMBERS, "null"} and kinds[name] != {"null"}]
    texts = [name for name in names if "text" in kinds[name] and "blob" not in kinds[name]]
    claim(loaded.path, loaded.on_disk, TEXT_CELL * rows * len(texts) + BATCH * 64 * len(names), f"{rows:,} rows")
    claim_room(loaded.path, loaded.on_disk, VALUE * rows * len(names), f"{rows:,} rows")
    long = LongColumns(rows)
    cells: dict[str, list[str]] = {name: [] for name in texts}
    done = 0
    damage: tuple[Remark, ...] = ()
    cursor = connection.execute(f"SELECT {', '.join(map(_quoted, [*quick, *texts]))} FROM {_quoted(topic.name)}"  # noqa: S608
                                if quick or texts else "SELECT 1 WHERE 0")  # fmt: skip
    while done < rows:
        try:
            batch = cursor.fetchmany(BATCH)
        except sqlite3.DatabaseError as error:
            what = f"the database is damaged ({error}): {rows - done:,} rows are not read"
            damage = (Remark("torn_file", "warning", what, where=loaded.path, count=rows - done),)
            break
        if not batch:
            break
        table = list(zip(*batch, strict=True))
        if quick:
            long.add([_numbers(name, table[i], kinds[name]) for i, name in enumerate(quick)])
        for i, name in enumerate(texts):
            cells[name] += ["" if cell is None else str(cell).strip(BLANKS) for cell in table[len(quick) + i]]
        done += len(batch)
    made = {one.name: Column(one.name, one.values[:done], one.unit, empty=one.empty) for one in long.columns()}
    for name, own in cells.items():
        judged = judge(own)
        made[name] = Column(name, np.array([*own, None], dtype=object)[:-1] if len(judged.text) else judged.values,
                            empty=judged.empty, not_a_number=judged.not_a_number)  # fmt: skip
    gone = [name for name in names if name not in made]
    remarks = (*left_out(gone, loaded.path), *damage, *other_topics(topics, chosen, loaded.path))
    kept = tuple(made[name] for name in names if name in made)
    return Content(kept, f"SQLite, table {topic.name!r}", range(1, done + 1), None, remarks)


def _kinds(connection: Any, table: str, column: str) -> set[str]:
    query = f"SELECT DISTINCT typeof({_quoted(column)}) FROM {_quoted(table)}"  # noqa: S608 - quoted
    return {kind for (kind,) in connection.execute(query)}


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
