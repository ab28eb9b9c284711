"""Recording to NumPy npz: an array a column, units in the names; the same recording gives the same bytes."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
from numpy.lib import format as npy_format

from ...core.errors import DataError
from ...core.recording import Recording
from ...core.remarks import Remark
from .file_columns import file_columns, stated_rate

RATE = "sample_rate"
FEWEST = 2  # values from which an array in a file is a column


def write_npz(path: Path, recording: Recording) -> tuple[Remark, ...]:
    """Write a recording; missing values are NaN, instants are ``datetime64[ns]`` in UTC.

    Raises
    ------
    DataError
        ``too_short``, for fewer than two samples: one value alone reads back as a constant.
    """
    if len(recording) < FEWEST:
        raise DataError(
            f"{len(recording)} sample(s), need {FEWEST} for a NumPy file",
            where=recording.source.path,
            do="Write CSV or Parquet",
            code="too_short",
        )
    columns, remarks = file_columns(recording, in_names=True)
    arrays = {column.name: column.values for column in columns}
    rate = stated_rate(recording)
    if rate is not None:
        arrays[RATE if RATE not in arrays else f"{RATE}_hz"] = np.array(rate)
    with zipfile.ZipFile(path, "w", allowZip64=True) as archive:
        for name, values in arrays.items():
            member = zipfile.ZipInfo(f"{name}.npy")  # dated 1980, so that the bytes do not change
            with archive.open(member, "w", force_zip64=True) as stream:
                npy_format.write_array(stream, values, allow_pickle=False)
    return remarks
