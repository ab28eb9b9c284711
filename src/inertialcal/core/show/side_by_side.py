"""Rows of two ground models side by side, as they are read: an axis a line, both errors and what they differ by.

Rows are mappings as ``results.json`` holds them, those of one test.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

from ..key import Method, case_of
from .sentence import WrittenRow

R = TypeVar("R", bound=WrittenRow)

ERROR, OTHER, CHANGE = "model_bias_error", "other_model_bias_error", "model_bias_error_change"
REDUCTION = "model_bias_error_reduction"


def pairs_of(rows: Iterable[R]) -> dict[tuple[str, str], dict[str, R]]:
    """Return by axis and flip ("": all of them) the rows of both errors, their change and reduction, by quantity.

    Axes that have no change are left out: there is nothing to set side by side.
    """
    every = [row for row in rows if row["quantity"] in (ERROR, OTHER, CHANGE, REDUCTION) and _is_shown(row)]
    told = {str(row["axis"]) for row in every if row["quantity"] == CHANGE and row["value"] is not None}
    found: dict[tuple[str, str], dict[str, R]] = {}
    for axis in sorted(told):
        for row in every:
            if row["axis"] == axis:
                way = str(row["condition"]) if case_of(row["condition"]).beside else ""
                found.setdefault((axis, way), {})[str(row["quantity"])] = row
    return {key: pair for key, pair in found.items() if CHANGE in pair}


def own_rows(rows: Iterable[R]) -> list[R]:
    """Return the rows without those that stand in the table of both models side by side."""
    every = list(rows)
    beside = (OTHER, CHANGE, REDUCTION) if pairs_of(every) else ()
    return [row for row in every if row["quantity"] not in beside]


def verdict_of(pair: Mapping[str, WrittenRow]) -> str:
    """Return ``nearer`` or ``farther``: from zero than the other, by its interval; else ``not shown``."""
    row = pair.get(REDUCTION)
    interval = None if row is None else row["interval"]
    if interval is None:
        return "not shown"
    lo, hi = (_plain(interval[end]) for end in ("lo", "hi"))
    return "nearer" if lo is not None and lo > 0.0 else "farther" if hi is not None and hi < 0.0 else "not shown"


def _plain(number: Any) -> float | None:
    """Return a number that may know its place in a file."""
    found = getattr(number, "raw", number)
    return None if found is None else float(found)


def _is_shown(row: WrittenRow) -> bool:
    case = case_of(row["condition"])
    return not case.beside or (case.member is not None and case.method is Method.RESULT)
