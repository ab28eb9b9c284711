"""Write a recording: CSV, Parquet, NumPy, HDF5, MATLAB or MCAP, by the ending of the name.

What is written reads back the same: numbers with all their digits in their own type (in CSV as the text that
gives the same bits), time to the nanosecond with its gaps, units in headers or metadata, missing values as empty
cells or nulls. The first column is the time. MCAP holds messages of ROS, in their units.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from ...core.errors import DataError, UsageError
from ...core.recording import Recording
from ...core.remarks import Remark
from ...core.show.rounding import uncertainty
from ..source import checked_path
from .array_files import write_hdf5, write_matlab, write_npz
from .atomic import atomic_write
from .csv import write_csv, write_parquet
from .mcap import write_mcap

Writer = Callable[[Path, Recording], tuple[Remark, ...]]
WRITERS: dict[str, Writer] = {
    ".csv": write_csv, ".parquet": write_parquet, ".npz": write_npz, ".h5": write_hdf5, ".mat": write_matlab,
    ".mcap": write_mcap,
}  # fmt: skip


def write(path: str | os.PathLike[str], recording: Recording) -> tuple[Remark, ...]:
    """Write a recording; the file is complete or not there.

    Parameters
    ----------
    path : path
        Its ending decides: ``.csv``, ``.parquet``, ``.npz``, ``.h5``, ``.mat`` or ``.mcap``. A file that is there
        is replaced, but never the one that the recording was read from.
    recording : Recording
        What to write.

    Returns
    -------
    tuple of Remark
        What is not kept or named otherwise.

    Raises
    ------
    UsageError
        ``unsupported_format``, for another ending.
    DataError
        ``overwrites_input``; ``not_numbers`` for a channel that is none; ``time_not_writable``;
        ``names_not_writable`` for names that a CSV cannot hold; ``too_short`` for a file of arrays with
        one sample; ``too_large`` for MATLAB.
    StoreError
        ``not_written``.
    """
    given: object = recording
    if not isinstance(given, Recording):
        what = f"a recording of type {type(given).__name__}"
        raise UsageError(what, do="Give a Recording: read(...)", code="wrong_type")
    writer = writer_for(checked_path(path))
    for channel in recording.channels:
        kind, size = channel.data.dtype.kind, channel.data.dtype.itemsize
        if kind not in "biuf" or size > np.dtype(float).itemsize:
            raise DataError(
                f"column {channel.name!r} holds {channel.data.dtype}, need whole numbers or floats of at most 64 bits",
                where=recording.source.path,
                do="Convert it, or leave it out",
                code="not_numbers",
            )
    if not recording.channels:
        raise DataError("a recording without channels", where=recording.source.path, code="no_channel")
    inputs = [recording.source.path] if recording.source.path else []
    with atomic_write(path, inputs) as aside:
        remarks = writer(aside, recording)
    return (*remarks, *_not_kept(recording, writer is write_parquet))


def writer_for(path: str | os.PathLike[str]) -> Writer:
    """Return the writer for the ending of a name.

    Raises
    ------
    UsageError
        ``unsupported_format``, if there is none.
    """
    ending = Path(path).suffix.lower()
    if ending not in WRITERS:
        raise UsageError(
            f"{str(path)!r}: {f'the ending {ending!r}' if ending else 'no ending'} is not a format that can be written",
            do=f"End the name with {', '.join(WRITERS)}",
            code="unsupported_format",
        )
    return WRITERS[ending]


def _not_kept(recording: Recording, clock: bool) -> Iterator[Remark]:
    if recording.averaging_time is not None:
        what = f"the file does not store the averaging time ({recording.averaging_time:g} s)"
        yield Remark("averaging_time_not_kept", "info", what, do="Give it again where the file is used")
    if recording.clock is not None and not clock:
        what = f"the file does not store to what its clock is known ({uncertainty(100.0 * recording.clock.u)} %)"
        yield Remark("clock_not_kept", "info", what, do="Write Parquet, which keeps it")
