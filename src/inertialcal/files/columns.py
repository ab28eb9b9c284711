"""Columns: what every reader hands over, before units and clock are known."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.recording import Times
from ..core.remarks import Remark

Rows = NDArray[np.int64]


def no_rows() -> Rows:
    """Return the index of no row at all."""
    return np.empty(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Column:
    """One column of a file.

    Parameters
    ----------
    name : str
        As the file has it; ``column_3``, counted from 1, where it has none.
    values : ndarray, shape (n,)
        Numbers in the type of the file, ``datetime64[ns]``, or objects of type str.
    unit : str or None
        As a units row or the metadata of the format say it.
    named : bool
        Whether the file has a name for it.
    matrix : str
        Name of the matrix that it is a column of; what it says holds for the column too.
    empty, not_a_number : ndarray of int64
        Index of each cell that was empty, and of each that spelled out NaN, NA or infinity. Both hold NaN.
    """

    name: str
    values: NDArray[Any]
    unit: str | None = None
    named: bool = True
    matrix: str = ""
    empty: Rows = field(default_factory=no_rows)
    not_a_number: Rows = field(default_factory=no_rows)

    @property
    def is_number(self) -> bool:
        """Whether the values are numbers."""
        return self.values.dtype.kind in "iuf"

    @property
    def is_complete(self) -> bool:
        """Whether every cell holds a value."""
        return not len(self.empty) and not len(self.not_a_number)


@dataclass(frozen=True, eq=False)
class Content:
    """All columns of a file.

    Parameters
    ----------
    columns : tuple of Column
        All of one length.
    format : str
        In words: ``"text, tab-separated"``.
    rows : ndarray of int64, shape (n,), or None
        Row of the file (counted from 1) of each sample; None where rows have no meaning.
    sample_rate : float or None
        As comments or metadata say it [Hz].
    remarks : tuple of Remark
        What reading it brought up.
    time_ns : ndarray of int64, shape (n,), or None
        Stamps that the format itself gives [ns since 1970 UTC]; then no column is time.
    """

    columns: tuple[Column, ...]
    format: str
    rows: Rows | None = None
    sample_rate: float | None = None
    remarks: tuple[Remark, ...] = ()
    time_ns: Times | None = None

    def place(self, path: str, index: int) -> str:
        """``file:row`` of a sample, or the file and its sample number where rows have no meaning."""
        if self.rows is None:
            return f"{path}: sample {index + 1}"
        return f"{path}:{self.rows[index]}"

    def __len__(self) -> int:
        return len(self.columns[0].values) if self.columns else 0
