"""Rows of two tests side by side, as they are read: an axis a line, both errors and what they differ by.

A procedure declares which error of its tests can stand beside that of another as `Compared`. Rows are mappings as
``results.json`` holds them, those of one test.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TypeVar

from ..key import Method
from ..results import WrittenRow, case_of

R = TypeVar("R", bound=WrittenRow)


@dataclass(frozen=True)
class Compared:
    """An error that stands beside that of another test: its quantities, and what its tables are called."""

    error: str  # Quantity: error of the test
    other: str  # Quantity: error of the other test
    change: str  # Quantity: this error less the other
    reduction: str  # Quantity: how much nearer to zero this one is
    title: str  # Of a table for a terminal, and for a report
    caption: str  # Of a table for a terminal, and for a report

    @property
    def roles(self) -> dict[str, str]:
        """What each quantity is: ``error``, ``other``, ``change`` or ``reduction``."""
        return {self.error: "error", self.other: "other", self.change: "change", self.reduction: "reduction"}


def pairs_of(rows: Iterable[R], compared: Compared | None) -> dict[tuple[str, str], dict[str, R]]:
    """Return by axis and part of the readings ("": all of them) the rows of both errors and of their difference.

    Each by its role: ``error``, ``other``, ``change``, ``reduction``. Axes that have no change are left out: there is
    nothing to set side by side.
    """
    roles = {} if compared is None else compared.roles
    every = [(roles[row["quantity"]], row) for row in rows if row["quantity"] in roles and _is_shown(row)]
    axes = {str(row["axis"]) for role, row in every if role == "change" and row["value"] is not None}
    found: dict[tuple[str, str], dict[str, R]] = {}
    for axis in sorted(axes):
        for role, row in every:
            if row["axis"] == axis:
                way = str(case) if (case := case_of(row)).beside else ""
                found.setdefault((axis, way), {})[role] = row
    return {key: pair for key, pair in found.items() if "change" in pair}


def own_rows(rows: Iterable[R], compared: Compared | None) -> list[R]:
    """Return the rows without those that stand in the table of both tests side by side."""
    every = list(rows)
    if compared is None or not pairs_of(every, compared):
        return every
    return [row for row in every if row["quantity"] not in (compared.other, compared.change, compared.reduction)]


def verdict_of(pair: Mapping[str, WrittenRow]) -> str:
    """Return ``nearer`` or ``farther``: from zero than the other, by its interval; else ``not shown``."""
    row = pair.get("reduction")
    interval = None if row is None else row["interval"]
    if interval is None:
        return "not shown"
    lo, hi = (None if interval[end] is None else float(interval[end]) for end in ("lo", "hi"))
    return "nearer" if lo is not None and lo > 0.0 else "farther" if hi is not None and hi < 0.0 else "not shown"


def _is_shown(row: WrittenRow) -> bool:
    case = case_of(row)
    return not case.beside or (case.member is not None and case.method is Method.RESULT)
