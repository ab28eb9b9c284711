"""A recording as the columns of a file: time first, titles that read back, numbers in plain types."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError, InertialcalError
from ...core.recording import Recording
from ...core.remarks import Remark
from ..columns import Column, Content
from ..info.describe import describe
from ..time.clock import find_clock
from .time_column import time_column
from .titles import channel_titles

if TYPE_CHECKING:
    from pyarrow import Array as ArrowArray


def file_columns(
    recording: Recording, in_names: bool, instants: bool = True
) -> tuple[tuple[Column, ...], tuple[Remark, ...]]:
    """Return the columns of a file, and remarks on their names.

    Parameters
    ----------
    recording : Recording
        What to write.
    in_names : bool
        Whether the unit of a column has no other place than its name.
    instants : bool
        Whether the format has a type for instants of any year.

    Raises
    ------
    DataError
        ``time_not_writable``, if the stamps have no form that reads back, or something else would read as time.
    """
    titles, remarks = channel_titles(recording, in_names)
    columns = [
        Column(title.name, plain_numbers(channel.data), title.unit)
        for title, channel in zip(titles, recording.channels, strict=True)
    ]
    time = time_column(recording, in_names, instants)
    found = (*([] if time is None else [time]), *columns)
    if len(recording):
        _check_clock(found, recording)
    return found, remarks


def _check_clock(columns: tuple[Column, ...], recording: Recording) -> None:
    """Refuse columns of which the reader would take another one for the time."""
    described, _ = describe(columns, {}, "")
    expected = None if recording.time_ns is None else 0
    try:
        taken = find_clock(described, Content(columns, ""), "").column
        reads = f"{columns[taken].name!r} would be read as the time" if taken is not None else "there would be no time"
    except InertialcalError as error:
        taken, reads = -1, error.problems[0].what
    if taken != expected:
        raise DataError(
            f"the time of the recording would not read back: {reads}",
            where=recording.source.path,
            do="Rename that column, or sort the rows by time",
            code="time_not_writable",
        )


def plain_numbers(data: NDArray[Any]) -> NDArray[Any]:
    """Return numbers in the byte order of the machine; truth values as 0 and 1, as they are read."""
    if data.dtype.kind == "b":
        return data.astype(np.uint8)
    return np.ascontiguousarray(data, dtype=data.dtype.newbyteorder("="))


def arrow_array(values: NDArray[Any]) -> ArrowArray:
    """Return a column for Arrow: NaN as null, instants in UTC."""
    import pyarrow as pa  # noqa: PLC0415 - heavy import

    if values.dtype.kind == "M":
        return pa.array(values.astype(np.int64), pa.timestamp("ns", tz="UTC"))
    return pa.array(values, from_pandas=True)


def stated_rate(recording: Recording) -> float | None:
    """Return the sample rate [Hz] where the stamps do not tell it: it was said, or there is no time.

    The interval that is read back from it may differ in the last bit.
    """
    if recording.interval_from == "column":
        return None
    return recording.sample_rate
