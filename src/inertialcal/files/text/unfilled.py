"""Unfilled end of a buffer: rows of nothing but zeros behind a time that had gone forward.

A logger that allots its array beforehand leaves them when it is stopped early. They are no measurement: kept,
they would read as a sensor that falls to zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...core.remarks import Remark
from ..columns import Column, Content

FEWEST = 2  # rows of zeros, columns


def without_unfilled_end(content: Content, path: str) -> Content:
    """Return the content without rows of zeros at its end, remarked and counted."""
    count = _unfilled(content.columns)
    if not count:
        return content
    kept = len(content) - count
    what = "row of zeros only, time included, at the end (the unfilled end of a buffer): left out"
    remark = Remark("unfilled_end", "warning", what, where=content.place(path, kept), count=count)
    return replace(
        content,
        columns=tuple(_first(column, kept) for column in content.columns),
        rows=None if content.rows is None else content.rows[:kept],
        remarks=(*content.remarks, remark),
    )


def _unfilled(columns: Sequence[Column]) -> int:
    """Rows of zeros at the end; 0 where some column before them does not always increase to above zero."""
    if len(columns) < FEWEST or not all(c.is_number and c.is_complete for c in columns):
        return 0
    n = len(columns[0].values)
    used = np.zeros(n, dtype=bool)
    for column in columns:
        used |= column.values != 0
    filled = int(np.flatnonzero(used)[-1]) + 1 if used.any() else 0
    if filled < FEWEST or n - filled < FEWEST:
        return 0
    clocks = [c for c in columns if c.values[filled - 1] > 0 and np.all(np.diff(c.values[:filled]) > 0)]
    return n - filled if clocks else 0


def _first(column: Column, kept: int) -> Column:
    return replace(
        column,
        values=column.values[:kept],
        empty=column.empty[column.empty < kept],
        not_a_number=column.not_a_number[column.not_a_number < kept],
    )
