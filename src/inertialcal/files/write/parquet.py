"""Recording to Parquet: units in the metadata of each field, a stated sample rate in that of the file."""

from __future__ import annotations

from pathlib import Path

from ...core.recording import Recording
from ...core.remarks import Remark
from ..binary.parquet import RATE_KEYS, UNIT_KEYS
from .file_columns import arrow_array, file_columns, stated_rate


def write_parquet(path: Path, recording: Recording) -> tuple[Remark, ...]:
    """Write a recording; missing values are nulls, instants are timestamps in UTC."""
    import pyarrow as pa  # noqa: PLC0415 - heavy import
    from pyarrow import parquet  # noqa: PLC0415 - heavy import

    columns, remarks = file_columns(recording, in_names=False)
    arrays = [arrow_array(column.values) for column in columns]
    fields = [
        pa.field(column.name, array.type, metadata=None if column.unit is None else {UNIT_KEYS[0]: column.unit})
        for column, array in zip(columns, arrays, strict=True)
    ]
    rate = stated_rate(recording)
    about = None if rate is None else {RATE_KEYS[0]: repr(rate)}
    parquet.write_table(pa.Table.from_arrays(arrays, schema=pa.schema(fields, metadata=about)), path)
    return remarks
