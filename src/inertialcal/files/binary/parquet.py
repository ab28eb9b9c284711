"""Parquet files: units in the metadata of a field (``unit`` or ``units``) or in its name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.errors import DataError
from ...core.remarks import Remark
from ..columns import Column, Content
from ..reader import Reader
from ..source import Loaded, as_data_errors, check_size
from ..text.delimited import arrow_numbers, text_in_numbers
from ..text.layout import judge

MAGIC = b"PAR1"
CELL = 8  # bytes of a value in memory
UNIT_KEYS = (b"unit", b"units")
RATE_KEYS = (b"sample_rate", b"sample_rate_hz", b"fs")


def read_parquet(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return all columns of a Parquet file, whatever variables are named.

    Raises
    ------
    DataError
        If it is damaged, a name appears twice, text stands among numbers, or it is larger than the limits
        of ``files.source``.
    """
    import pyarrow as pa  # noqa: PLC0415 - heavy import
    from pyarrow import parquet  # noqa: PLC0415 - heavy import

    with as_data_errors(loaded.path, "a Parquet file"):
        file = parquet.ParquetFile(pa.BufferReader(loaded.data))
        check_size(loaded.path, CELL * file.metadata.num_rows * file.metadata.num_columns, len(loaded.data))
        table = file.read()
        while any(pa.types.is_struct(kind) for kind in table.schema.types):
            table = table.flatten()
        twice = sorted({name for name in table.column_names if table.column_names.count(name) > 1})
        if twice:
            raise DataError(f"column name {twice[0]!r} appears twice", where=loaded.path, code="duplicate_column")
        columns = [_column(table.column(i), table.schema.field(i), loaded.path) for i in range(table.num_columns)]
        rate = _sample_rate(table.schema.metadata or {})
    kept = tuple(column for column in columns if isinstance(column, Column))
    left_out = [name for name in columns if isinstance(name, str)]
    what = f"neither numbers, dates nor text, left out: {', '.join(left_out)[:120]}"
    remark = Remark("variables_left_out", "info", what, where=loaded.path, count=len(left_out))
    return Content(kept, "Parquet", None, rate, (remark,) if left_out else ())


def _column(values: Any, field: Any, path: str) -> Column | str:
    """One column, or its name if it is neither numbers, dates nor text."""
    import pyarrow as pa  # noqa: PLC0415 - heavy import

    kind, metadata = values.type, field.metadata or {}
    unit = next((metadata[key].decode("utf-8", "replace") for key in UNIT_KEYS if key in metadata), None)
    if pa.types.is_dictionary(kind):
        values, kind = values.cast(kind.value_type), kind.value_type
    if pa.types.is_timestamp(kind):
        stamps, empty = arrow_numbers(values.cast(pa.timestamp("ns")))
        return Column(field.name, stamps, unit, empty=empty)
    if pa.types.is_duration(kind):
        values, unit = values.cast(pa.int64()), kind.unit
    elif pa.types.is_boolean(kind):
        values = values.cast(pa.uint8())
    elif pa.types.is_decimal(kind) or pa.types.is_null(kind):
        values = values.cast(pa.float64(), safe=False)
    elif pa.types.is_string(kind) or pa.types.is_large_string(kind):
        return _text_column(values, field.name, unit, path)
    elif not (pa.types.is_integer(kind) or pa.types.is_floating(kind)):
        return str(field.name)
    if values.null_count and not pa.types.is_floating(values.type):
        values = values.cast(pa.float64(), safe=False)
    numbers, empty = arrow_numbers(values)
    if numbers.dtype.kind != "f":
        return Column(field.name, numbers, unit)
    literal = np.setdiff1d(np.flatnonzero(~np.isfinite(numbers)), empty, assume_unique=True)  # NaN that is no null
    numbers[literal] = np.nan
    return Column(field.name, numbers, unit, empty=empty, not_a_number=literal)


def _text_column(values: Any, name: str, unit: str | None, path: str) -> Column:
    """Text, or numbers that were stored as text."""
    cells = ["" if cell is None else cell for cell in values.to_pylist()]
    judged = judge(cells)
    if len(judged.text):
        rows = np.arange(1, len(cells) + 1)
        raise DataError(text_in_numbers(name, cells, judged.text, rows, path))
    return Column(name, judged.values, unit, empty=judged.empty, not_a_number=judged.not_a_number)


def _sample_rate(metadata: dict[bytes, bytes]) -> float | None:
    """Sample rate in the metadata of the file [Hz]."""
    for key in RATE_KEYS:
        try:
            value = float(metadata[key])
        except (KeyError, ValueError):
            continue
        if np.isfinite(value) and value > 0.0:
            return value
    return None


READER = Reader("parquet", "Parquet", (".parquet",), lambda data, path: data.startswith(MAGIC), read_parquet)
