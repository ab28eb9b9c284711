"""What a reader is: the endings it is known by, how it tells its files, and the columns it gives.

A built-in reader is a module that holds a `Reader`, and a line in ``registry.BUILT_IN``; installed packages add theirs
by the entry point ``inertialcal.readers``. A reader gets a file whole and unpacked (a long one as ``source.FileBytes``,
if it takes files in place), and hands over its columns as they are; units, time, missing values and remarks are then
found as for any other format. ``binary.arrays.number_column`` makes a column of numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ..core.errors import UsageError
from ..core.recording import Recording
from .columns import Content
from .source import Loaded
from .time.window import Window


@dataclass(frozen=True)
class Reader:
    """A reader of files that hold columns."""

    name: str  # That in the registry: ``"parquet"``
    title: str  # As a list of formats names it: ``"Parquet"``
    endings: tuple[str, ...]  # Of the names of such files, in small letters: ``(".parquet",)``
    recognises: Callable[[bytes, str], bool]  # Whether bytes (all of the file, unpacked) and path are of this format
    # Columns of a loaded file; the second argument names the variables to take, where a file holds several sets
    read: Callable[[Loaded, Sequence[str] | None], Content]
    in_place: bool = False  # Whether it reads a long file piece by piece, into ``columns.LongColumns``


@dataclass(frozen=True)
class Request:
    """What a caller says of a recording besides its path; fields as ``files.read`` takes them."""

    units: Mapping[str, str] = field(default_factory=dict)
    sample_rate: float | None = None
    time_column: str | None = None
    required: Sequence[str] = ()
    topics: Sequence[str] | None = None  # Those to take, where a file holds several sets of columns
    window: Window = field(default_factory=Window)
    frame: str | None = None
    decimal: str | None = None
    skip: int | None = None
    dates: str | None = None


def wrong_frame(path: str | Path) -> UsageError:
    """Return the error for ``--frame`` where a format has no frames to choose from."""
    return UsageError(
        f"{path}: --frame given",
        why="only records of the acceleration archive give their coordinate systems",
        do="Leave --frame out",
        code="wrong_frame",
    )


@dataclass(frozen=True)
class ArchiveReader:
    """A reader of records that are several files: found by path, with a time of their own."""

    name: str  # ``"pad"``
    title: str  # As a list of formats names it
    read: Callable[[str | Path, Request], Recording | None]  # Recording of a path; None where it is no such record
