"""NumPy files: ``npy`` with one array, ``npz`` with several. Pickled objects are never loaded."""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Sequence

import numpy as np
from numpy.lib import format as npy_format

from ..columns import Content
from ..formats import members
from ..reader import Reader
from ..source import Loaded, as_data_errors, check_size
from .arrays import NamedArray, columns_of

MAGIC = b"\x93NUMPY"


def read_npy(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of an array; Raises as `read_npz`."""
    with as_data_errors(loaded.path, "a NumPy npy file"):
        arrays = _npy("", loaded.data, loaded.path)
    return columns_of(arrays, "NumPy npy", loaded.path, variables=variables)


def read_npz(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of the arrays of one length.

    Raises
    ------
    DataError
        If it is damaged, holds Python objects, or unpacks beyond the limits of ``files.source``.
    """
    with as_data_errors(loaded.path, "a NumPy npz file"):
        arrays = _npz(loaded)
    return columns_of(arrays, "NumPy npz", loaded.path, variables=variables)


def _npz(loaded: Loaded) -> list[NamedArray]:
    """All arrays of an archive; sizes are looked at before anything is unpacked."""
    arrays = []
    with zipfile.ZipFile(io.BytesIO(loaded.data)) as archive:
        members = [info for info in archive.infolist() if info.filename.endswith(".npy")]
        check_size(loaded.path, sum(info.file_size for info in members), len(loaded.data))
        for info in members:
            with archive.open(info) as member:
                data = member.read(info.file_size)
            arrays += _npy(info.filename.removesuffix(".npy"), data, loaded.path)
    return arrays


def _npy(name: str, data: bytes, path: str) -> list[NamedArray]:
    """One array, or one for each field of a structured array."""
    stream = io.BytesIO(data)
    version = npy_format.read_magic(stream)
    header = {(1, 0): npy_format.read_array_header_1_0}.get(version, npy_format.read_array_header_2_0)
    if version in ((1, 0), (2, 0)):
        shape, _, dtype = header(stream)
        check_size(path, math.prod(shape) * dtype.itemsize, max(len(data), 1))
    stream.seek(0)
    array = np.asarray(np.load(stream, allow_pickle=False))
    if array.dtype.names is None:
        return [NamedArray(name, array)]
    prefix = f"{name}." if name else ""
    return [NamedArray(f"{prefix}{field}", array[field]) for field in array.dtype.names]


NPY = Reader("npy", "NumPy", (".npy",), lambda data, path: data.startswith(MAGIC), read_npy)
NPZ = Reader(
    "npz", "NumPy", (".npz",), lambda data, path: any(name.endswith(".npy") for name in members(data)), read_npz
)
