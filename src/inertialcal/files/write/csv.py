"""Recording to CSV: a header with units, commas, decimal point, empty cells for missing values.

A float is written with the fewest digits that give back its bits; a column of floats that are all whole keeps
its points (``2.0``), so that it is not taken for counts. A sample rate that the stamps do not tell stands in a
comment line above the header.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...core.batches import batches, every
from ...core.errors import DataError, InertialcalError
from ...core.recording import SECOND, Recording
from ...core.remarks import Remark
from ...core.show.tables import csv_cell
from ..binary.parquet import CLOCK_KEY, RATE_KEYS, UNIT_KEYS, clock_text
from ..columns import Column
from ..text.delimited import parse
from ..text.layout import SAMPLE
from .file_columns import arrow_array, file_columns, stated_rate

GROUP = 2**20  # rows that are in memory at once, and of a group of a Parquet file
Cells = Callable[[int, int], Any]  # samples first to stop of a column, as Arrow's
STEPS = (("s", SECOND), ("ms", SECOND // 1000), ("us", SECOND // 1_000_000), ("ns", 1))  # of instants


def write_csv(path: Path, recording: Recording) -> tuple[Remark, ...]:
    """Write a recording as comma-separated text in UTF-8.

    Raises
    ------
    DataError
        ``names_not_writable``, if the names would not be read as a header.
    """
    named, remarks = file_columns(recording, in_names=True, instants="tellable")
    columns = tuple(replace(one, name=csv_cell(one.name)) for one in named)
    changed = tuple(
        Remark("column_renamed", "warning", f"column {old.name!r} is written as {new.name!r}: a spreadsheet would "
               "run it as a formula", do="Write Parquet, which keeps the name", subject=old.name)
        for old, new in zip(named, columns, strict=True)
        if old.name != new.name
    )  # fmt: skip
    cells = [_cells(column, alone=len(columns) == 1) for column in columns]
    head = _head(columns, stated_rate(recording))
    _check_header(head, cells, columns, recording)
    with path.open("wb") as stream:
        stream.write(head.encode())
        for first, stop in batches(*(column.values for column in columns), size=GROUP):
            _write_rows(cells, first, stop, stream)
    return remarks + changed


def _head(columns: Sequence[Column], rate: float | None) -> str:
    text = io.StringIO()
    text.write("" if rate is None else f"# sample rate: {rate!r} Hz\n")
    csv.writer(text, lineterminator="\n").writerow([column.name for column in columns])
    return text.getvalue()


def _cells(column: Column, alone: bool) -> Cells:
    """Return what gives some samples of a column for Arrow, that it writes as they shall stand."""
    import pyarrow as pa  # noqa: PLC0415 - heavy import
    from pyarrow import compute as pc  # noqa: PLC0415 - heavy import

    values = column.values
    floats = values.dtype.kind == "f"
    step = _step(values) if values.dtype.kind == "M" else None
    whole = floats and every(values, _all_whole)
    gaps = alone and floats and not every(values, lambda part: not np.any(np.isnan(part)))

    def part(first: int, stop: int) -> Any:
        array = arrow_array(values[first:stop])
        if step is not None:
            return array.cast(pa.timestamp(step, tz="UTC"))
        if whole:
            text = array.cast(pa.float64()).cast(pa.string())
            pointed = pc.binary_join_element_wise(text, "0", ".")
            array = pc.if_else(pc.match_substring_regex(text, "[.en]"), text, pointed)
        if gaps:  # quoted, because a blank line would not be a row
            array = pc.fill_null(array.cast(pa.string()), "")
        return array

    return part


def _all_whole(values: Any) -> bool:
    finite = values[np.isfinite(values)]
    return bool(np.all(finite == np.rint(finite)))


def _step(instants: Any) -> str:
    """Return the coarsest step of an instant that keeps every stamp."""
    time_ns = instants.view(np.int64)
    return next(
        unit for unit, size in STEPS if not any(np.any(time_ns[first:stop] % size) for first, stop in batches(time_ns))
    )


def _write_rows(cells: Sequence[Cells], first: int, stop: int, stream: Any) -> None:
    import pyarrow as pa  # noqa: PLC0415 - heavy import
    from pyarrow import csv as arrow_csv  # noqa: PLC0415 - heavy import

    table = pa.Table.from_arrays([one(first, stop) for one in cells], names=[str(i) for i in range(len(cells))])
    quoted = len(cells) == 1 and pa.types.is_string(table.column(0).type)
    options = arrow_csv.WriteOptions(include_header=False, quoting_style="all_valid" if quoted else "none")
    arrow_csv.write_csv(table, stream, options)


def _check_header(head: str, cells: Sequence[Cells], columns: Sequence[Column], recording: Recording) -> None:
    """Read the beginning as a reader will: its layout is judged from there."""
    if not len(recording):
        return
    beginning = io.BytesIO()
    _write_rows(cells, 0, min(SAMPLE, len(recording)), beginning)
    names = [column.name for column in columns]
    try:
        found = [column.name for column in parse(head + beginning.getvalue().decode(), recording.source.path).columns]
    except InertialcalError as error:
        found = [error.problems[0].what]
    if found != names:
        raise DataError(
            f"the names {', '.join(names)[:120]} would not be recognised as a CSV header",
            where=recording.source.path,
            why=f"they would read as {', '.join(found)[:120]}",
            do="Write Parquet (name ending in .parquet), or rename the columns",
            code="names_not_writable",
        )


def write_parquet(path: Path, recording: Recording) -> tuple[Remark, ...]:
    """Write a recording; missing values are nulls, instants are timestamps in UTC."""
    import pyarrow as pa  # noqa: PLC0415 - heavy import
    from pyarrow import parquet  # noqa: PLC0415 - heavy import

    columns, remarks = file_columns(recording, in_names=False)
    values = [column.values for column in columns]
    fields = [
        pa.field(
            column.name,
            arrow_array(column.values[:0]).type,
            metadata=None if column.unit is None else {UNIT_KEYS[0]: column.unit},
        )
        for column in columns
    ]
    rate = stated_rate(recording)
    about: dict[bytes, bytes] = {} if rate is None else {RATE_KEYS[0]: repr(rate).encode()}
    if recording.clock is not None:
        about[CLOCK_KEY] = clock_text(recording.clock)
    schema = pa.schema(fields, metadata=about or None)
    with parquet.ParquetWriter(path, schema) as writer:
        for first, stop in batches(*values, size=GROUP):
            part = [arrow_array(one[first:stop]) for one in values]
            writer.write_table(pa.Table.from_arrays(part, schema=schema), row_group_size=GROUP)
        if not len(values[0]):
            writer.write_table(schema.empty_table())
    return remarks
