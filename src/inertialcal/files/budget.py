"""How much a file may ask for: memory, and numbers of parts. All limits of the readers stand here.

A small file can declare, or unpack to, more than a machine holds. So whoever is about to allocate says first how much
(`claim`, `claim_recording`) and is refused beyond the ceiling: 1 GiB and three times the file for the whole process,
or what ``--max-memory``, ``max_memory(...)`` or the environment variable INERTIALCAL_MAX_MEMORY says. What costs time
rather than memory is counted (`check_count`).
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING

from ..core.errors import DataError, UsageError

if TYPE_CHECKING:
    from ..core.recording import Recording

FREE = 2**30  # bytes that any file may take
PER_BYTE = 3  # ... and so many more for each byte of the file
ROOM = 16  # bytes in temporary files for each byte of a file
PROCESS = 2**28  # what the interpreter and its libraries take, at most 0.2 GiB
VALUE = 8  # bytes of a number in memory
DOCUMENT = 40  # bytes of a parsed JSON text for each byte of it, at most ({"":{}} in {"":{}})
COLUMNS = 10_000  # columns of a table
PARTS = 10_000  # datasets, members, variables, groups of rows, fields, nested matrices
LINE = 2**20  # characters of a line, unless it is the only one
YAML = 100_000  # characters: its parser takes a second for them
# Columns of 8 bytes that the work on a recording takes, measured: each channel as float64, and time and its judgement.
READ, SURVEY, ANALYSIS = (2.0, 6.0), (1.0, 14.0), (3.3, 15.0)
STREAMED = (0.0, 0.0)  # the same where they are worked on a batch at a time, if they are stored
AS_WIDE = (0.5, 3.0)  # the same where readings stay as wide as in the file and are worked on in pieces
ENVIRONMENT = "INERTIALCAL_MAX_MEMORY"
UNITS = {"": 1, "b": 1, "kb": 10**3, "mb": 10**6, "gb": 10**9, "tb": 10**12,
         "k": 2**10, "m": 2**20, "g": 2**30, "kib": 2**10, "mib": 2**20, "gib": 2**30, "tib": 2**40}  # fmt: skip
_limit: ContextVar[int | None] = ContextVar("max_memory", default=None)


def parse_size(text: str) -> int:
    """Return the bytes of ``"4GiB"``, ``"500 MB"``.

    Raises
    ------
    UsageError
        ``wrong_value``, if it is no size.
    """
    match = re.fullmatch(r"\s*([0-9]{1,15}(?:\.[0-9]{1,6})?)\s*([A-Za-z]{0,3})\s*", text, re.ASCII)
    unit = None if match is None else UNITS.get(match[2].lower())
    if match is None or unit is None or float(match[1]) * unit < 1:
        do = "Write a number with a unit: 4GiB, 500MB"
        raise UsageError(f"--max-memory {text!r}: not a size", do=do, code="wrong_value")
    return int(float(match[1]) * unit)


@contextmanager
def max_memory(size: str | int | None) -> Iterator[None]:
    """Set the ceiling of memory for the files that are read inside.

    Parameters
    ----------
    size : str, int or None
        ``"4GiB"``, ``"500 MB"``, a number of bytes; None for the default: 1 GiB and three times each file.
    """
    token = _limit.set(size if size is None or isinstance(size, int) else parse_size(size))
    try:
        yield
    finally:
        _limit.reset(token)


def ceiling(on_disk: int) -> int:
    """Return the bytes that the process may take for a file of a size [byte]."""
    limit = _limit.get()
    if limit is None and os.environ.get(ENVIRONMENT):
        limit = parse_size(os.environ[ENVIRONMENT])
    return FREE + PER_BYTE * on_disk if limit is None else limit


def claim(where: str, on_disk: int, need: float, what: str, *, least: bool = False) -> None:
    """Refuse what would take more memory than the ceiling, before it is allocated.

    Parameters
    ----------
    where : str
        File.
    on_disk : int
        Its size as it lies there [byte].
    need : float
        Bytes to be held at once for it, its content included.
    what : str
        What takes them, with its count: ``"120,000,000 values"``.
    least : bool
        Whether more may come: how much shows only while it is unpacked.

    Raises
    ------
    DataError
        ``too_large``, with what is needed, the ceiling, and the option that raises it.
    """
    most, whole = ceiling(on_disk), need + PROCESS
    if whole <= most:
        return
    enough = 2 ** max(math.ceil(math.log2((4 if least else 1) * whole / 2**30)), 1)
    raise DataError(
        f"needs {'more than ' if least else ''}{size_text(whole)} of memory, the ceiling is {size_text(most)}",
        where=where,
        why=f"{what} in a file of {size_text(on_disk)}",
        do=f"If the file is right, add --max-memory {enough}GiB",
        code="too_large",
    )


def claim_room(where: str, on_disk: int, size: int, what: str) -> None:
    """Refuse numbers that take more room in temporary files than those of any recording; Raises as `claim`."""
    most = FREE + ROOM * on_disk
    if size > most:
        raise DataError(
            f"needs {size_text(size)} of room for temporary files, the ceiling is {size_text(most)}",
            where=where,
            why=f"{what} in a file of {size_text(on_disk)}",
            do="If the file is right, cut it into parts",
            code="too_large",
        )


def claim_values(where: str, on_disk: int, held: int, rows: int, columns: int) -> None:
    """Refuse columns of numbers that are too many to be read; ``held``: bytes held already. Raises as `claim`."""
    per_column, other = READ
    claim(where, on_disk, held + VALUE * rows * (per_column * columns + other), f"{rows * columns:,} values")


def claim_recording(recording: Recording, work: tuple[float, float]) -> None:
    """Refuse work on a recording (`SURVEY`, `ANALYSIS`, `AS_WIDE`) that would take too much; Raises as `claim`."""
    from ..core.batches import is_stored  # noqa: PLC0415 - numpy starts slowly

    rows, columns, path = len(recording), len(recording.channels), recording.source.path
    if work in (STREAMED, SURVEY) and any(is_stored(one.data) for one in recording.channels):
        return
    per_column, other = ANALYSIS if work == STREAMED else work
    need = VALUE * rows * (per_column * columns + other)
    if need + PROCESS > FREE and path:
        claim(path, size_on_disk(path), need, f"{rows * columns:,} values")


def size_on_disk(path: str | Path) -> int:
    """Return the bytes of a file, or of the files in a folder; 0 where there is none."""
    try:
        if os.path.isdir(path):
            return sum(one.stat().st_size for one in Path(path).rglob("*") if one.is_file())
        return os.stat(path).st_size
    except (OSError, ValueError):
        return 0


def check_count(count: int, most: int, what: str, where: str) -> None:
    """Refuse more parts than can be worked through in seconds.

    Raises
    ------
    DataError
        ``too_many``, with the count and the ceiling.
    """
    if count > most:
        raise DataError(
            f"{count:,} {what}, the ceiling is {most:,}",
            where=where,
            why="no recording has so many; they would take minutes",
            do="Export what you need of it",
            code="too_many",
        )


def size_text(size: float) -> str:
    """Return a size as people write it: ``1.4 kB``, ``2.5 GiB``."""
    for unit, least in (("GiB", 1.0), ("MiB", 0.1)):
        if size >= least * UNITS[unit.lower()]:
            return f"{size / UNITS[unit.lower()]:.3g} {unit}"
    return f"{size / 1000:.3g} kB" if size >= 1000 else f"{size:.0f} bytes"
