"""Table: reduced readings, a row a dwell, with the row of the file behind every message.

Cells keep their text until a column is asked for as numbers: what may stand in it depends on who asks.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path
from typing import overload

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array, Numbers
from ...core.recording import Source
from ...core.remarks import Remark
from ...core.show import tables as shown
from ...core.show.result_tables import remarks_line
from ...core.show.tables import Block, ending, html, text
from ...core.unit.magnitudes import are_possible, check_readings
from ..budget import claim
from ..columns import Content, Rows, missing_remarks, nan_in_required
from ..registry import TEXT, find_reader, lines_of, sign_of
from ..source import checked_path, load
from .delimited import cell_columns, column_names, header_again, header_repeated, text_in_numbers
from .grouped import commas, problem, shows_groups, without_groups
from .headers import bare_name, heading
from .layout import BLANKS, CELL, CELL_BYTES, Decimal, judge, kind, sniff, text_of, to_float, without_first
from .results_table import is_results, results_columns

SHOWN = 4  # cells of a column
SHORT = 4_096  # cells of a column whose texts are kept


class NumberCells(Sequence[str]):
    """Cells of a column that was stored as numbers, every one there and finite: text is made where it is read.

    Parameters
    ----------
    stored : ndarray, shape (n,)
        The numbers.
    values : ndarray, shape (n,)
        The same as float64.
    """

    def __init__(self, stored: Numbers, values: Array) -> None:
        self._stored = stored
        self.values = values

    @cached_property
    def _texts(self) -> tuple[str, ...]:
        """With all their digits."""
        return tuple(map(str, self._stored.tolist()))

    @property
    def labels(self) -> NDArray[np.str_]:
        """The same as an array, shape (n,), read-only."""
        return _numbered(self._stored.tobytes(), self._stored.dtype)

    @property
    def all_differ(self) -> bool:
        """Whether no two are equal."""
        ordered = np.sort(self.values)
        return bool((ordered[1:] != ordered[:-1]).all())

    def __len__(self) -> int:
        return len(self._stored)

    @overload
    def __getitem__(self, at: int) -> str: ...
    @overload
    def __getitem__(self, at: slice) -> tuple[str, ...]: ...
    def __getitem__(self, at: int | slice) -> str | tuple[str, ...]:
        """Return the text of one cell, or of some."""
        return self._texts[at]

    def __iter__(self) -> Iterator[str]:
        return iter(self._texts)


@lru_cache(maxsize=64)  # the same in the tables of all units of a lot
def _labels(cells: tuple[str, ...]) -> NDArray[np.str_]:
    found = np.array(cells, dtype=str)
    found.flags.writeable = False
    return found


@lru_cache(maxsize=64)
def _numbered(stored: bytes, dtype: np.dtype[np.integer | np.floating]) -> NDArray[np.str_]:
    return _labels(tuple(map(str, np.frombuffer(stored, dtype).tolist())))


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of text, to be read as numbers where they are."""

    names: tuple[str, ...]  # As the header has them; ``column_3`` where it has none
    cells: tuple[Sequence[str], ...]  # By column, without quotes and outer blanks; an empty one is a missing value
    rows: Rows  # shape (n,): row of the file (counted from 1) of each
    source: Source = field(default_factory=Source)  # File, hash, format
    units: tuple[str | None, ...] = ()  # As the header or a units row say them, as ``core.units`` prints them
    decimal: Decimal = "."  # Decimal sign
    remarks: tuple[Remark, ...] = ()  # What reading it brought up
    sampled: bool = False  # Whether the file states a sample rate, or stamps beside its columns

    def __len__(self) -> int:
        return len(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: a row a column, its first cells, how many remarks."""
        rows = [
            (name, (self.units[i] if i < len(self.units) else None) or "?", ", ".join(cells[:SHOWN]))
            for i, (name, cells) in enumerate(zip(self.names, self.cells, strict=True))
        ]
        caption = f"{ending(self.source.path) or 'table'}: {len(self)} rows, {len(self.names)} columns"
        return (shown.Table(("column", "unit", "first cells"), rows, caption), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())

    def where(self, index: int) -> str:
        """``file:row`` of a row of the table, counted from 0."""
        return f"{self.source.path}:{self.rows[index]}"

    def index(self, name: str) -> int:
        """Position of a column, by its name with or without the unit in brackets.

        Raises
        ------
        DataError
            If there is none of that name; the message lists those there are.
        """
        if self.names.count(name) == 1:
            return self.names.index(name)
        bare = [bare_name(given) for given in self.names]
        if bare.count(name) == 1:
            return bare.index(name)
        raise DataError(
            f"no column {name!r}",
            where=self.source.path,
            do=f"The file has: {', '.join(self.names)}",
            code="wrong_column",
        )

    def text(self, name: str) -> tuple[str, ...]:
        """Cells of a column as they stand in the file.

        Raises
        ------
        DataError
            If there is none of that name.
        """
        return tuple(self.cells[self.index(name)])

    def labels(self, name: str) -> NDArray[np.str_]:
        """Cells of a column as they stand in the file, shape (n,), read-only; those of equal short columns are shared.

        Raises
        ------
        DataError
            If there is none of that name.
        """
        cells = self.cells[self.index(name)]
        if len(cells) > SHORT:
            return np.array(tuple(cells), dtype=str)
        return cells.labels if isinstance(cells, NumberCells) else _labels(tuple(cells))

    def all_differ(self, name: str) -> bool:
        """Return whether a column is one of numbers no two of which are equal."""
        cells = self.cells[self.index(name)]
        return isinstance(cells, NumberCells) and cells.all_differ

    def unit(self, name: str) -> str | None:
        """Return the unit of a column as the file says it; None where it does not."""
        return self.units[self.index(name)] if self.units else None

    def numbers(self, name: str, *, required: bool = True) -> Array:
        """Numbers of a column, shape (n,), NaN where a cell is empty.

        Parameters
        ----------
        name : str
            Column.
        required : bool
            Whether a spelled-out NaN, NA or infinity is refused (the default) or counts as missing.

        Raises
        ------
        DataError
            If there is no such column, it holds text, a number that nothing has (``impossible_value``), or, where
            required, a literal NaN.
        """
        at = self.index(name)
        cells: Sequence[str] = self.cells[at]
        if isinstance(cells, NumberCells):
            check_readings(self.names[at], cells.values, self.unit(name), self.where)
            return cells.values.copy()
        sure = any(shows_groups(one, self.decimal) for one in self.cells if not isinstance(one, NumberCells))
        cells = without_groups(cells, self.decimal, CELL[self.decimal].fullmatch, sure)
        kinds = [kind(cell, self.decimal) for cell in cells]
        numbers = [to_float(c, self.decimal) if k in "if" else np.nan for c, k in zip(cells, kinds, strict=True)]
        values = np.array(numbers, dtype=np.float64)
        text = np.flatnonzero(np.array([k == "t" for k in kinds], dtype=bool) | np.isinf(values))
        if len(text) == 0 and self.decimal == ",":
            self._refuse_grouped(at)
        if len(text):
            raise DataError(text_in_numbers(self.names[at], cells, text, self.rows, self.source.path))
        nan = np.flatnonzero([k == "n" for k in kinds])
        if required and len(nan):
            raise nan_in_required(self.names[at], cells[nan[0]], len(nan), self.where(int(nan[0])))
        check_readings(self.names[at], values, self.unit(name), self.where)
        return values

    def columns(self, names: Sequence[str]) -> Array:
        """Numbers of several columns, shape (k, n), each as `numbers` gives it.

        Raises
        ------
        DataError
            As `numbers`.
        """
        cells = [self.cells[self.index(name)] for name in names]
        found = np.array([one.values for one in cells if isinstance(one, NumberCells)])
        if len(found) == len(names) > 0 and are_possible(found):
            return found
        return np.array([self.numbers(name) for name in names]).reshape(len(names), len(self))

    def _refuse_grouped(self, at: int) -> None:
        """Refuse ``1,242`` where it is 1242, or where nothing in the file says that it is 1.242."""
        said = commas(self.cells[at])
        if said.either is None or (said.whole is None and any(commas(cells).decimal for cells in self._numbers())):
            return
        whole = None if said.whole is None else self.cells[at][said.whole]
        raise DataError(problem(self.names[at], self.cells[at][said.either], self.where(said.either), whole))

    def _numbers(self) -> Iterator[Sequence[str]]:
        """Cells of each column of numbers."""
        return (cells for cells in self.cells if not any(kind(cell, self.decimal) == "t" for cell in cells))

    def missing(self, name: str) -> tuple[Remark, ...]:
        """Remark on the empty cells of a column, and on its literal NaN; none where it is complete."""
        at = self.index(name)
        if isinstance(self.cells[at], NumberCells):
            return ()
        judged = judge(self.cells[at], self.decimal)
        return missing_remarks(self.names[at], judged.empty, judged.not_a_number, self.where)


def read_table(
    path: str | Path, *, topics: Sequence[str] | None = None, decimal: str | None = None, skip: int | None = None
) -> Table:
    """Return a reduced table: text in any layout that ``files.read`` takes, or a binary format.

    Parameters
    ----------
    path, topics, decimal, skip
        As ``files.read`` takes them.

    Raises
    ------
    DataError
        If there is no such file, it is empty or no text, rows differ in width, or a name appears twice.
    """
    loaded = load(checked_path(path, "table"))
    if is_results(loaded.data):
        called, given, units = results_columns(loaded)
        source = Source(loaded.path, loaded.sha256, "results of flips", "results")
        return Table(called, given, np.arange(1, len(given[0]) + 1), source, units)
    reader = find_reader(loaded)
    if reader.name != TEXT:
        content = reader.read(loaded, topics or None)
        return table_of_content(content, Source(loaded.path, loaded.sha256, content.format, reader.name))
    text, remarks = text_of(loaded)
    text = without_first(text, lines_of(skip))
    layout = sniff(text, loaded.path, sign_of(decimal))
    names = column_names(layout, loaded.path)
    number = layout.width * (1 + text.count("\n"))
    claim(loaded.path, loaded.on_disk, 2 * len(text) + CELL_BYTES * number, f"{number:,} cells")
    again = header_again(text, layout)
    if again is not None and not again[1]:
        raise header_repeated(f"{loaded.path}:{again[0]}")
    rows, cells = cell_columns(text, layout, loaded.path)
    units = tuple(heading(name, given or None).unit for name, given in zip(layout.names, layout.units, strict=True))
    return Table(
        names=names,
        cells=tuple(tuple(cell.strip(BLANKS) for cell in column) for column in cells),
        rows=rows,
        source=Source(loaded.path, loaded.sha256, layout.words, reader.name),
        units=units,
        decimal=layout.decimal,
        remarks=remarks + layout.remarks,
        sampled=layout.sample_rate is not None,
    )


def topics_of(path: str | Path) -> tuple[str, ...]:
    """Return the names of the sheets, groups or tables of a file that can be read; none of a text.

    Raises
    ------
    DataError
        As `read_table`.
    """
    loaded = load(checked_path(path, "table"))
    reader = find_reader(loaded)
    try:
        if reader.name != TEXT:
            reader.read(loaded, ("",))
    except DataError as error:
        if not error.problems[0].choices:
            raise
        return error.problems[0].choices
    return ()


def table_of_content(content: Content, source: Source) -> Table:
    """Return a binary format's columns as text, with full digits."""
    cells: list[Sequence[str]] = []
    of_numbers = [i for i, one in enumerate(content.columns) if one.values.dtype.kind in "fiu" and not len(one.empty)]
    values = np.array([content.columns[i].values for i in of_numbers], dtype=np.float64)
    finite = np.flatnonzero(np.isfinite(values).all(axis=1)) if of_numbers else ()
    known = {of_numbers[k]: values[k] for k in finite}
    for i, column in enumerate(content.columns):
        if i in known:
            cells.append(NumberCells(column.values, known[i]))
            continue
        if column.values.dtype.kind == "O" and not len(column.empty):
            cells.append(tuple(column.values.tolist()))
            continue
        gone = set(column.empty.tolist())
        cells.append(tuple("" if at in gone else str(v) for at, v in enumerate(column.values.tolist())))
    return Table(
        names=tuple(column.name for column in content.columns),
        cells=tuple(cells),
        rows=np.arange(1, len(content) + 1),
        source=source,
        units=tuple(heading(column.name, column.unit).unit for column in content.columns),
        remarks=content.remarks,
        sampled=content.sample_rate is not None or content.time_ns is not None,
    )
