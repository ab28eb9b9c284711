"""Readers of recordings and tables: text, Parquet, MATLAB, HDF5, NumPy, pairs of the acceleration archive.

``read`` gives a Recording, ``read_table`` a reduced table with its rows, ``survey`` what ``info`` shows. The format of
a file is told by its bytes; a long one is read piece by piece where its reader can. Nothing is guessed silently: a unit
that nobody said is None, and whatever was inferred, left out or suspicious is a remark of the Recording.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..core.estimate import Array
    from ..core.recording import Recording
    from .text.table import Table

__all__ = ["read", "read_table"]


def read(
    path: str | Path | Recording | Array,
    *,
    units: Mapping[str, str] | None = None,
    sample_rate: float | None = None,
    time_column: str | None = None,
    required: Sequence[str] = (),
    topics: Sequence[str] | None = None,
    start: object = None,
    stop: object = None,
    mission_start: object = None,
    frame: str | None = None,
    decimal: str | None = None,
    skip: int | None = None,
    dates: str | None = None,
) -> Recording:
    """Return the recording in a file.

    Parameters
    ----------
    path : str or Path, Recording, or array of shape (n,) or (n, axes)
        A Recording, or an array with its sample rate, is taken as it is, also as the only one of a list. Files: CSV
        and other text (also gzip), Parquet, MATLAB, HDF5, npy, npz, Arrow, WAV, LVM, SQLite, bags, ArduPilot logs;
        with the extra ``formats`` PX4 logs, workbooks, TDMS, UFF 58, MDF, IDE, miniSEED; data file or header of a pair
        of the acceleration archive (PAD), or a folder of such pairs; what a reader of another distribution takes
        (entry point ``inertialcal.readers``).
    units : mapping of str to str, optional
        Unit by column or by group: ``{"gyro": "deg/s", "acc_x": "g", "timestamp": "ns"}``; goes before what
        the file says.
    sample_rate : float, optional
        [Hz]; goes before the stamps and the header, and is remarked where they disagree.
    time_column : str, optional
        Name, or number counted from 1, of the column that is time; by default it is found.
    required : sequence of str, optional
        Columns that must be there, in numbers; a literal NaN in them is refused.
    topics : sequence of str, optional
        Of a file with several sets of columns, those to take: topics of a bag, messages of a flight log, groups of
        channels, a sheet, a table, variables of a MATLAB, HDF5 or npz file (by default the largest set of one length).
    start, stop : str, int, float or datetime, optional
        Keep the samples from start on and before stop: UTC, UNIX seconds, GMT day of the year or mission elapsed
        time, as ``core.times.read_instant`` takes them; seconds or DDD/HH:MM:SS where the recording counts from its
        own time zero.
    mission_start : str, int, float or datetime, optional
        Instant at which mission elapsed time is zero.
    frame : {"data", "sensor"}, optional
        Of a PAD recording: axes as the data are, or those of the sensor, turned by what the header says.
    decimal : {"comma", "point"}, optional
        Decimal sign of a text; by default the file decides, and is refused where it does not (``grouped_digits``).
    skip : int, optional
        Lines of a text before its table; by default they are found.
    dates : {"day-first", "month-first"}, optional
        Order of dates like 3/4/2024; by default the file decides, and is refused where it does not
        (``ambiguous_date``).

    Returns
    -------
    Recording
        Channels in the type of the file; empty cells are NaN, counted in a remark.

    Raises
    ------
    DataError
        By code: ``missing_file``, ``empty_file``, ``unsupported_format``, ``not_text``, ``damaged_file``,
        ``too_large``, ``ragged_row``, ``duplicate_column``, ``text_in_numbers``, ``nan_in_required``,
        ``grouped_digits``, ``wrong_column``, ``unknown_unit``, ``epoch_digits``, ``no_channel``, ``no_time``,
        ``missing_extra``, ``several_topics``, ``several_clocks``,
        ``nothing_left``, ``broken_plugin``, ``ambiguous_date``, those of a time column that was named and cannot be
        time (``not_time``,
        ``time_missing``, ``time_unit_unknown``), and those of ``pad.read_pad``.
    UsageError
        If a unit is given to no column (``wrong_column``), cannot belong to it (``unit_mismatch``), the
        sample rate is not above zero (``sample_rate``), a time is none (``wrong_time``), or a frame or a time
        column is asked for where there is none (``wrong_frame``, ``wrong_column``).
    """
    if isinstance(path, list | tuple):
        from .memory import the_only  # noqa: PLC0415 - numpy starts slowly

        path = the_only(path)
    if not isinstance(path, str | PathLike):
        from .memory import recording_of  # noqa: PLC0415 - numpy starts slowly
        from .time.window import Window as Times  # noqa: PLC0415
        from .time.window import cut  # noqa: PLC0415

        return cut(recording_of(path, units, sample_rate), Times(start, stop, mission_start))
    from .reader import Request  # noqa: PLC0415 - numpy starts slowly
    from .registry import read_recording  # noqa: PLC0415
    from .time.dates import check_dates  # noqa: PLC0415
    from .time.window import Window  # noqa: PLC0415

    window = Window(start, stop, mission_start)
    request = Request(
        units or {}, sample_rate, time_column, required, topics, window, frame, decimal, skip, check_dates(dates)
    )
    return read_recording(path, request)


def read_table(
    path: str | Path, *, topics: Sequence[str] | None = None, decimal: str | None = None, skip: int | None = None
) -> Table:
    """Return the reduced table in a file: columns of text or numbers, with the row of each.

    Parameters
    ----------
    path, topics, decimal, skip
        As `read` takes them.

    Raises
    ------
    DataError
        By code: ``missing_file``, ``empty_file``, ``unsupported_format``, ``not_text``, ``damaged_file``,
        ``too_large``, ``ragged_row``, ``duplicate_column``.
    """
    from .text.table import read_table as read_rows  # noqa: PLC0415 - numpy starts slowly

    return read_rows(path, topics=topics, decimal=decimal, skip=skip)
