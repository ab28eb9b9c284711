"""Readers of recordings and tables: text, Parquet, MATLAB, HDF5, NumPy.

``read`` gives a Recording, ``read_table`` a reduced table with its rows, ``survey`` what ``info`` shows. A
file is read whole; its format is told by its bytes. Nothing is guessed silently: a unit that nobody said is
None, and whatever was inferred, left out or suspicious is a remark of the Recording.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..core.recording import Recording
    from .table import Table

__all__ = ["read", "read_table"]


def read(
    path: str | Path,
    *,
    units: Mapping[str, str] | None = None,
    sample_rate: float | None = None,
    time_column: str | None = None,
    required: Sequence[str] = (),
    variables: Sequence[str] | None = None,
) -> Recording:
    """Return the recording in a file.

    Parameters
    ----------
    path : str or Path
        CSV and other text (also gzip), Parquet, MATLAB, HDF5, npy, npz.
    units : mapping of str to str, optional
        Unit by column or by group: ``{"gyro": "deg/s", "acc_x": "g", "timestamp": "ns"}``; goes before what
        the file says.
    sample_rate : float, optional
        [Hz]; goes before the stamps and the header, and is remarked where they disagree.
    time_column : str, optional
        Name, or number counted from 1, of the column that is time; by default it is found.
    required : sequence of str, optional
        Columns that must be there, in numbers; a literal NaN in them is refused.
    variables : sequence of str, optional
        Of a MATLAB, HDF5 or npz file, those to take; by default the largest set of one length.

    Returns
    -------
    Recording
        Channels in the type of the file; empty cells are NaN, counted in a remark.

    Raises
    ------
    DataError
        By code: ``missing_file``, ``empty_file``, ``unsupported_format``, ``not_text``, ``damaged_file``,
        ``too_large``, ``ragged_row``, ``duplicate_column``, ``text_in_numbers``, ``nan_in_required``,
        ``wrong_column``, ``unknown_unit``, ``epoch_digits``, ``no_channel``, and those of a time column that
        was named and cannot be time (``not_time``, ``time_missing``, ``time_unit_unknown``).
    UsageError
        If a unit is given to no column (``wrong_column``), cannot belong to it (``unit_mismatch``), or the
        sample rate is not above zero (``sample_rate``).
    """
    from ..core.recording import Source  # noqa: PLC0415 - numpy starts slowly
    from .assemble import assemble  # noqa: PLC0415
    from .content import parse_content  # noqa: PLC0415
    from .source import load  # noqa: PLC0415

    loaded = load(path)
    content = parse_content(loaded, variables)
    packed = ", gzip" if loaded.packed else ""
    return assemble(
        content,
        Source(loaded.path, loaded.sha256, content.format + packed),
        units=units,
        sample_rate=sample_rate,
        time_column=time_column,
        required=required,
    )


def read_table(path: str | Path) -> Table:
    """Return the reduced table in a file: columns of text or numbers, with the row of each.

    Raises
    ------
    DataError
        By code: ``missing_file``, ``empty_file``, ``unsupported_format``, ``not_text``, ``damaged_file``,
        ``too_large``, ``ragged_row``, ``duplicate_column``.
    """
    from .table import read_table as read_rows  # noqa: PLC0415 - numpy starts slowly

    return read_rows(path)
