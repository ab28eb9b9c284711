"""NumPy files: ``npy`` with one array, ``npz`` with several. Pickled objects are never loaded."""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Sequence
from typing import IO

import numpy as np
from numpy.lib import format as npy_format

from ...core.batches import is_long
from ..budget import PARTS, VALUE, check_count, claim, claim_room, claim_values
from ..columns import Content
from ..formats import members
from ..reader import Reader
from ..source import FileBytes, Loaded, as_data_errors, opened
from .arrays import NamedArray, columns_of, received

MAGIC = b"\x93NUMPY"
HEADER = 1_000_000  # characters: numpy evaluates them


def read_npy(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of an array; Raises as `read_npz`."""
    with as_data_errors(loaded.path, "a NumPy npy file"), opened(loaded.data) as stream:
        arrays = _npy("", stream, len(loaded.data), loaded)
    return columns_of(arrays, "NumPy npy", loaded.path, variables=variables)


def read_npz(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of the arrays of one length.

    Raises
    ------
    DataError
        If it is damaged, holds Python objects, or goes beyond the limits of ``files.budget``.
    """
    with as_data_errors(loaded.path, "a NumPy npz file"):
        arrays = _npz(loaded)
    return columns_of(arrays, "NumPy npz", loaded.path, variables=variables)


def _npz(loaded: Loaded) -> list[NamedArray]:
    """All arrays of an archive; sizes are looked at before anything is unpacked, and hold for what is."""
    arrays: list[NamedArray] = []
    in_place = isinstance(loaded.data, FileBytes)
    with opened(loaded.data) as stream, zipfile.ZipFile(stream) as archive:
        members = [info for info in archive.infolist() if info.filename.endswith(".npy")]
        check_count(len(members), PARTS, "arrays", loaded.path)
        whole = sum(info.file_size for info in members)
        if in_place:
            claim_room(loaded.path, loaded.on_disk, 2 * whole, f"{whole:,} bytes of arrays")
        else:
            claim_values(loaded.path, loaded.on_disk, len(loaded.data) + whole, -(-whole // VALUE), 1)
        for info in members:
            name = info.filename.removesuffix(".npy")
            with archive.open(info) as member:
                if in_place:
                    arrays += _npy(name, member, info.file_size, loaded, is_long(whole))
                    member.read(1)  # its end, where the sum of its bytes is checked
                else:
                    data = member.read(info.file_size)
                    arrays += _npy(name, io.BytesIO(data), len(data), loaded)
            check_count(len(arrays), PARTS, "arrays and fields", loaded.path)
    return arrays


def _npy(name: str, stream: IO[bytes], size: int, loaded: Loaded, stored: bool | None = None) -> list[NamedArray]:
    """One array, or one for each field of a structured array, in a stream of so many bytes."""
    version, in_place = npy_format.read_magic(stream), isinstance(loaded.data, FileBytes)
    begin = stream.tell()
    length = int.from_bytes(stream.read(2 if version == (1, 0) else 4), "little")
    stream.seek(begin)
    check_count(length, HEADER, "characters of header", loaded.path)
    header = npy_format.read_array_header_1_0 if version == (1, 0) else npy_format.read_array_header_2_0
    array = None
    if version in ((1, 0), (2, 0)):
        shape, upside, dtype = header(stream, max_header_size=HEADER)
        needed = math.prod(shape) * dtype.itemsize
        if needed > size - stream.tell() or (shape and not dtype.itemsize):
            what = f"the header says {needed:,} bytes of values, {size - stream.tell():,} are there"
            raise ValueError(what)
        check_count(len(dtype.names or ()), PARTS, "fields", loaded.path)
        if in_place and not dtype.hasobject:
            claim_room(loaded.path, loaded.on_disk, 2 * needed, f"{math.prod(shape):,} values")
            array = received(stream, dtype, shape[::-1] if upside else shape, stored)
            array = array.T if upside else array
        else:
            claim_values(loaded.path, loaded.on_disk, 2 * len(loaded.data), math.prod(shape), 1)
    if array is None:
        claim(loaded.path, loaded.on_disk, 2 * size, f"{size:,} bytes of an array")
        stream.seek(0)
        array = np.asarray(np.load(stream, allow_pickle=False, max_header_size=HEADER))
    if array.dtype.names is None:
        return [NamedArray(name, array)]
    prefix = f"{name}." if name else ""
    return [NamedArray(f"{prefix}{field}", array[field]) for field in array.dtype.names]


NPY = Reader("npy", "NumPy", (".npy",), lambda data, path: data.startswith(MAGIC), read_npy, True)
NPZ = Reader(
    "npz",
    "NumPy",
    (".npz",),
    lambda data, path: any(name.endswith(".npy") for name in members(data)),
    read_npz,
    in_place=True,
)
