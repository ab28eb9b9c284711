"""The data behind a figure as CSV, inside the page: all digits, a line a row."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from typing import Any

from .numbers import clean

FORMULA = ("=", "+", "-", "@", "\t", "\n")  # a spreadsheet would run a text that begins so


def curve_csv(curve: Mapping[str, Any]) -> str:
    """Return a curve of results.json as CSV; the unit stands in the head of each column.

    Parameters
    ----------
    curve : mapping
        With ``columns``: ``{name: {"unit", "values"}}``, all equally long.
    """
    columns = curve["columns"]
    heads = [f"{name} [{column['unit']}]" if column["unit"] else name for name, column in columns.items()]
    return _written(heads, list(zip(*(column["values"] for column in columns.values()), strict=True)))


def rows_csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return rows of results.json as CSV; what is nested in a row is left out."""
    heads = [name for name, value in rows[0].items() if not isinstance(value, Mapping | list)] if rows else []
    return _written(heads, [[row[name] for name in heads] for row in rows])


def _written(heads: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow([_cell(head) for head in heads])
    writer.writerows([_cell(value) for value in row] for row in rows)
    return buffer.getvalue()


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        text = clean(value).replace("\r", "\n")  # csv quotes the latter alone
        return f"'{text}" if text.startswith(FORMULA) else text
    return repr(value)
