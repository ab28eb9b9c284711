"""Recording to files of named arrays: NumPy, HDF5, MATLAB.

A sample rate that the stamps do not tell is a number named ``sample_rate``. Missing values are NaN. NumPy has instants;
HDF5 and MATLAB have none, so UTC is in nanoseconds since 1970 there where seconds would lose digits.
"""

from __future__ import annotations

import re
import unicodedata
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy_format
from numpy.typing import NDArray

from ...core.batches import batches
from ...core.errors import DataError
from ...core.recording import Recording
from ...core.remarks import Remark
from ..binary.matlab import UNITS
from ..columns import Column
from ..text.headers import bare_name
from .file_columns import Instants, file_columns, stated_rate

RATE = "sample_rate"
FEWEST = 2  # values from which an array in a file is a column
GROUP = 2**16  # samples that HDF5 packs together
LONGEST = 63  # characters of a name in MATLAB
LARGEST = 2**31 - 2**10  # bytes of an array in MATLAB 5
TEXT = b"MATLAB 5.0 MAT-file, written by inertialcal".ljust(116)  # without a date, so that the bytes do not change


def write_npz(path: Path, recording: Recording) -> tuple[Remark, ...]:
    """Write a recording; missing values are NaN, instants are ``datetime64[ns]`` in UTC.

    Raises
    ------
    DataError
        ``too_short``, for fewer than two samples: one value alone reads back as a constant.
    """
    columns, rate, remarks = _arrays(recording, in_names=True)
    arrays = {column.name: column.values for column in columns} | rate
    with zipfile.ZipFile(path, "w", allowZip64=True) as archive:
        for name, values in arrays.items():
            member = zipfile.ZipInfo(f"{name}.npy")  # dated 1980, so that the bytes do not change
            with archive.open(member, "w", force_zip64=True) as stream:
                npy_format.write_array(stream, values, allow_pickle=False)
    return remarks


def write_hdf5(path: Path, recording: Recording) -> tuple[Remark, ...]:
    """Write a recording, a dataset for each column, its unit as attribute ``units``; Raises as `write_npz`."""
    import h5py  # noqa: PLC0415 - heavy import

    columns, rate, remarks = _arrays(recording, in_names=False, instants="none", legal=_of_hdf5)
    with h5py.File(path, "w", track_order=True) as file:
        for column in columns:
            n = len(column.values)
            packed = {"chunks": (min(n, GROUP),), "shuffle": True, "compression": "gzip", "compression_opts": 1}
            dataset = file.create_dataset(column.name, (n,), column.values.dtype, track_times=False, **packed)
            if column.unit is not None:
                dataset.attrs["units"] = column.unit
            for first, stop in batches(column.values):
                dataset[first:stop] = column.values[first:stop]
        for name, value in rate.items():
            file.create_dataset(name, data=value, track_times=False).attrs["units"] = "Hz"
    return remarks


def write_matlab(path: Path, recording: Recording) -> tuple[Remark, ...]:
    """Write a recording for MATLAB 5 and newer: a column vector for each column, units in the structure ``units``.

    Raises
    ------
    DataError
        As `write_npz`; ``too_large``, for a column beyond 2 GiB.
    """
    from scipy import io as scipy_io  # noqa: PLC0415 - heavy import

    columns, rate, remarks = _arrays(recording, in_names=False, instants="none", legal=_of_matlab)
    largest = max(columns, key=lambda column: column.values.nbytes)
    if largest.values.nbytes > LARGEST:
        raise DataError(
            f"{largest.name!r} takes {largest.values.nbytes:,} bytes, MATLAB 5 files hold {LARGEST:,} at most",
            where=recording.source.path,
            do="Write HDF5 (name ending in .h5), which MATLAB reads with h5read",
            code="too_large",
        )
    arrays: dict[str, Any] = {column.name: _for_matlab(column.values) for column in columns} | rate
    if said := {column.name: column.unit for column in columns if column.unit is not None}:
        arrays[UNITS] = said
    with path.open("wb") as stream:
        scipy_io.savemat(stream, arrays, long_field_names=True, oned_as="column", do_compression=True)
        stream.seek(0)
        stream.write(TEXT)
    return remarks


def _arrays(
    recording: Recording, in_names: bool, instants: Instants = "all", legal: Any = str
) -> tuple[tuple[Column, ...], dict[str, NDArray[Any]], tuple[Remark, ...]]:
    """Return the columns, and the sample rate by its name where the stamps do not tell it."""
    if len(recording) < FEWEST:
        raise DataError(
            f"{len(recording)} sample(s), need {FEWEST} for a file of arrays",
            where=recording.source.path,
            do="Write CSV or Parquet",
            code="too_short",
        )
    columns, remarks = file_columns(recording, in_names, instants, legal)
    rate, name = stated_rate(recording), RATE
    while any(column.name == name for column in columns):
        name += "_"  # which reads as a sample rate all the same
    return columns, {} if rate is None else {name: np.array(rate)}, remarks


def _of_hdf5(name: str) -> str:
    """Return a name that a dataset can have, and that is no table of MATLAB's own; its unit stands apart."""
    return re.sub(r"^[#.]+|/|\0", "_", bare_name(name))


def _of_matlab(name: str) -> str:
    """Return a name that a variable of MATLAB can have; its unit stands apart."""
    plain = unicodedata.normalize("NFKD", bare_name(name)).encode("ascii", "ignore").decode()
    plain = re.sub(r"\W+", "_", plain).strip("_")
    plain = f"{plain}_" if plain == UNITS else plain if plain[:1].isalpha() or not plain else f"x_{plain}"
    return plain[:LONGEST]


def _for_matlab(values: NDArray[Any]) -> NDArray[Any]:
    """Return values in a type that MATLAB has: of floats, single and double."""
    return values.astype(np.float32) if values.dtype == np.float16 else values
