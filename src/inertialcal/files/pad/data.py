"""Numbers of an archive data file: records of 32-bit floats, or text; read in blocks, each byte once."""

from __future__ import annotations

import io
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ...core.batches import empty, is_long, put
from ...core.errors import DataError
from ..budget import READ, VALUE, claim, claim_room
from ..source import read_bytes
from .header import PadHeader

BLOCK = 2**18  # records
FLOAT = 4  # bytes
TEXT = 12  # bytes that a byte of text takes at most while it is read
Numbers = NDArray[Any]


class Digest(Protocol):
    """A hash that bytes are fed to."""

    def update(self, data: bytes | memoryview, /) -> None:
        """Take more bytes."""


@dataclass(frozen=True)
class Layout:
    """Columns behind the time: names, and unit of those that have one."""

    names: tuple[str, ...]
    units: tuple[str | None, ...]
    named: bool = True


AXES = Layout(("x", "y", "z"), ("g", "g", "g"))
RAW = Layout(("x", "y", "z", "temperature", "status"), ("g", "g", "g", None, None))  # ossraw
RADIATION = Layout(tuple(f"column_{i}" for i in range(2, 15)), (None,) * 13, named=False)  # radgse


def layout_of(header: PadHeader) -> Layout:
    """Return the columns of a sensor: three axes; for ``ossraw`` temperature and status too; 13 for ``radgse``."""
    said = f"{header.system} {header.sensor}".lower()
    return RAW if "ossraw" in said else RADIATION if "radgse" in said else AXES


def room_of(records: int, columns: int) -> int:
    """Return the bytes that stamps and numbers of some records take, time among the columns."""
    return records * (VALUE + FLOAT * columns)


def read_numbers(path: Path, header: PadHeader, digest: Digest) -> tuple[Numbers, list[Numbers]]:
    """Return time [s since the header's time zero], shape (n,), and the columns behind it.

    Parameters
    ----------
    path : Path
        Data file.
    header : PadHeader
        Of it.
    digest : Digest
        Is fed all bytes of the file.

    Raises
    ------
    DataError
        ``empty_file``; ``truncated``, if the size is no whole number of records; ``damaged_file``; ``too_large``.
    """
    columns = 1 + len(layout_of(header).names)
    try:
        size = path.stat().st_size
        if not size:
            raise DataError("the file is empty", where=str(path), do="Fetch it again", code="empty_file")
        if not header.number_type:
            claim(str(path), size, TEXT * size, f"{size:,} bytes of text")
            return _from_text(path, columns, digest)
        _whole_records(path, size, columns)
        n = size // (FLOAT * columns)
        stored = is_long(room_of(n, columns))
        if stored:
            claim_room(str(path), size, 2 * room_of(n, columns), f"{n:,} records")
        else:
            claim(str(path), size, size + VALUE * READ[1] * n, f"{n:,} records")
        found = [empty(n, np.float32, stored) for _ in range(columns)]
        buffer = np.empty((min(BLOCK, n), columns), dtype=np.dtype(header.number_type))
        with path.open("rb") as stream:
            for first in range(0, n, BLOCK):
                block = buffer[: min(BLOCK, n - first)]
                raw = block.view(np.uint8).data
                if stream.readinto(raw) != block.nbytes:
                    raise DataError(f"ends before record {n}, while it is read", where=str(path), code="damaged_file")
                digest.update(raw)
                for column, numbers in enumerate(found):
                    put(numbers, first, block[:, column])
        return found[0], found[1:]
    except OSError as error:
        what = f"cannot be read: {error.strerror or error}"
        raise DataError(what, where=str(path), code="missing_file") from None


def _whole_records(path: Path, size: int, columns: int) -> None:
    record = FLOAT * columns
    if size % record:
        raise DataError(
            f"{size} bytes are {size // record} records of {columns} numbers and {size % record} bytes more: truncated",
            where=str(path),
            why=f"a record has {record} bytes",
            do="Fetch it again from the archive",
            code="truncated",
        )


def _from_text(path: Path, columns: int, digest: Digest) -> tuple[Numbers, list[Numbers]]:
    data = read_bytes(path)
    digest.update(data)
    try:
        text = data.decode("ascii").replace(",", " ")
        table = np.loadtxt(io.StringIO(text), dtype=np.float64, ndmin=2, comments=None)
    except ValueError as error:
        raise _no_text(path, " ".join(str(error).split())[:160]) from None
    if not len(table) or table.shape[1] != columns:
        raise _no_text(path, f"{table.shape[1] if len(table) else 0} numbers in a row, need {columns}")
    return table[:, 0].copy(), [table[:, column].copy() for column in range(1, columns)]


def _no_text(path: Path, what: str) -> DataError:
    return DataError(
        f"is not the text that its header says: {what}",
        where=str(path),
        do=f"Fetch both files of the pair again ({os.path.basename(path)} and its header)",
        code="damaged_file",
    )
