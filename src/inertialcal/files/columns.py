"""Columns: what every reader hands over, before units and clock are known."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..core.batches import any_step, batches, empty, is_long, put
from ..core.errors import DataError
from ..core.recording import ClockRate, Times
from ..core.remarks import Remark

Rows = NDArray[np.int64]
T = TypeVar("T")


NO_ROWS: Rows = np.empty(0, dtype=np.int64)


def no_rows() -> Rows:
    """Return the index of no row at all."""
    return NO_ROWS


@dataclass(frozen=True, eq=False)
class Column:
    """One column of a file."""

    name: str  # As the file has it; ``column_3``, counted from 1, where it has none
    values: NDArray[Any]  # shape (n,): numbers in the type of the file, ``datetime64[ns]``, or objects of type str
    unit: str | None = None  # As a units row or the metadata of the format say it
    named: bool = True  # Whether the file has a name for it
    matrix: str = ""  # Name of the matrix, or the topic, that it is a column of; what it says holds for the column too
    axis: str = ""  # Of a matrix of three columns: which of x, y, z it is, if they are those of a sensor
    # Index of each cell that was empty, and of each that spelled out NaN, NA or infinity. Both hold NaN.
    empty: Rows = field(default_factory=no_rows)
    # Index of each cell that was empty, and of each that spelled out NaN, NA or infinity. Both hold NaN.
    not_a_number: Rows = field(default_factory=no_rows)
    naive: bool = False  # Whether some of its instants were text without a time zone, and UTC is assumed

    @property
    def is_number(self) -> bool:
        """Whether the values are numbers."""
        return self.values.dtype.kind in "iuf"

    @property
    def is_complete(self) -> bool:
        """Whether every cell holds a value."""
        return not len(self.empty) and not len(self.not_a_number)


@dataclass(frozen=True, eq=False)
class Content:
    """All columns of a file."""

    columns: tuple[Column, ...]  # All of one length
    format: str  # In words: ``"text, tab-separated"``
    # shape (n,): row of the file (counted from 1) of each sample; None where rows have no meaning
    rows: Rows | range | None = None
    sample_rate: float | None = None  # As comments or metadata say it [Hz]
    remarks: tuple[Remark, ...] = ()  # What reading it brought up
    # shape (n,): stamps that the format itself gives [ns since 1970 UTC]; then no column is time
    time_ns: Times | None = None
    cut_off: float | None = None  # Of the low pass before the samples, as the file says it [Hz]
    clock: ClockRate | None = None  # Of its stamps, as the file says it

    def place(self, path: str, index: int) -> str:
        """``file:row`` of a sample, or the file and its sample number where rows have no meaning."""
        if self.rows is None:
            return f"{path}: sample {index + 1}"
        return f"{path}:{self.rows[index]}"

    def __len__(self) -> int:
        return len(self.columns[0].values) if self.columns else 0


class LongColumns:
    """Columns of numbers or instants, filled a batch at a time; those longer than memory holds lie on the disk.

    Parameters
    ----------
    rows : int
        Of each column, in all; about, where only a reading to the end shows it.
    """

    def __init__(self, rows: int) -> None:
        self._rows, self._filled = rows, 0
        self._values: list[NDArray[Any]] = []
        self._parts: list[list[Column]] = []  # without their values

    def add(self, columns: Sequence[Column]) -> None:
        """Put the next rows below those that are there; each time the same columns, in one order."""
        if not self._values:
            self._stored = is_long(self._rows * sum(one.values.dtype.itemsize for one in columns))
            self._values = [empty(self._rows, one.values.dtype, self._stored) for one in columns]
            self._parts = [[] for _ in columns]
        first, stop = self._filled, self._filled + len(columns[0].values) if columns else self._filled
        if stop > self._rows:
            self._rows = stop + stop // 4
            self._stored = self._stored or is_long(self._rows * sum(one.itemsize for one in self._values))
            self._values = [self._converted(one, one.dtype) for one in self._values]
        for k, one in enumerate(columns):
            kind = np.result_type(self._values[k], one.values)
            if self._values[k].dtype != kind:  # an empty cell among whole numbers
                self._values[k] = self._converted(self._values[k], kind)
            put(self._values[k], first, one.values)
            if not self._parts[k] or not one.is_complete or one.naive:  # then more is to be kept than the values
                gone, nan = one.empty + first, one.not_a_number + first
                self._parts[k].append(replace(one, values=one.values[:0].copy(), empty=gone, not_a_number=nan))
        self._filled = stop

    def columns(self) -> tuple[Column, ...]:
        """Return the columns, filled."""
        return tuple(
            replace(
                parts[0],
                values=values[: self._filled],
                empty=np.concatenate([part.empty for part in parts]),
                not_a_number=np.concatenate([part.not_a_number for part in parts]),
                naive=any(part.naive for part in parts),
            )
            for values, parts in zip(self._values, self._parts, strict=True)
        )

    def _converted(self, values: NDArray[Any], kind: np.dtype[Any]) -> NDArray[Any]:
        out = empty(self._rows, kind, self._stored)
        for first, stop in batches(out[: self._filled], values[: self._filled]):
            put(out, first, values[first:stop])
        return out


def ahead(items: Iterator[T]) -> Generator[T]:
    """Yield items each of which is made, by a thread, while the one before is worked on."""
    with ThreadPoolExecutor(1) as thread:
        coming = thread.submit(next, items, None)
        while (item := coming.result()) is not None:
            coming = thread.submit(next, items, None)
            yield item


def missing_remarks(name: str, empty: Rows, nan: Rows, where: Callable[[int], str]) -> tuple[Remark, ...]:
    """Return remarks on the empty cells of a column and on its literal NaN.

    Parameters
    ----------
    name : str
        Column.
    empty, nan : ndarray of int64
        Index of the cells of each kind.
    where : callable
        Gives ``file:row`` of an index.
    """
    remarks = []
    if len(empty):
        what = f"empty cell in {name!r}: missing"
        remarks.append(Remark("missing_cells", "info", what, where(int(empty[0])), len(empty), subject=name))
    if len(nan):
        what = f"NaN or inf in {name!r}: treated as missing"
        remarks.append(Remark("nan_literal", "warning", what, where(int(nan[0])), len(nan), subject=name))
    return tuple(remarks)


def nan_in_required(name: str, cell: str, count: int, where: str) -> DataError:
    """Return the error for a spelled-out NaN in a column that must hold numbers."""
    more = f" ({count} such cells)" if count > 1 else ""
    return DataError(
        f"literal {cell!r} in required column {name!r}{more}",
        where=where,
        why="a missing value, or a failed computation?",
        do="Leave the cell empty if the value is missing",
        code="nan_in_required",
    )


FEWEST = 2  # rows of zeros, columns
AT_ONCE = 2**16  # rows, where the last few are zeros


def without_unfilled_end(content: Content, path: str) -> Content:
    """Return the content without rows of zeros at its end, remarked and counted."""
    count = _unfilled(content.columns)
    if not count:
        return content
    kept = len(content) - count
    what = "rows of zeros at the end, time included (an unfilled buffer): left out"
    remark = Remark("unfilled_end", "warning", what, where=content.place(path, kept), count=count)
    return replace(
        content,
        columns=tuple(_first(column, kept) for column in content.columns),
        rows=None if content.rows is None else content.rows[:kept],
        remarks=(*content.remarks, remark),
    )


def _unfilled(columns: Sequence[Column]) -> int:
    """Rows of zeros at the end; 0 where some column before them does not always increase to above zero."""
    if len(columns) < FEWEST or not all(c.is_number and c.is_complete for c in columns):
        return 0
    n = len(columns[0].values)
    filled, first = 0, n
    while first > 0 and not filled:  # from the end, which is filled in most records
        stop, first = first, max(first - (AT_ONCE if first < n else FEWEST), 0)
        for column in columns:
            used = np.flatnonzero(column.values[first:stop] != 0)
            filled = max(filled, first + int(used[-1]) + 1 if len(used) else 0)
    if filled < FEWEST or n - filled < FEWEST:
        return 0
    clocks = [
        c for c in columns if c.values[filled - 1] > 0 and not any_step(c.values[:filled], lambda step: ~(step > 0))
    ]
    return n - filled if clocks else 0


def _first(column: Column, kept: int) -> Column:
    return replace(
        column,
        values=column.values[:kept],
        empty=column.empty[column.empty < kept],
        not_a_number=column.not_a_number[column.not_a_number < kept],
    )
