"""Figures and remarks as parts of what is shown: rounded to their uncertainty, with interval and degrees of freedom.

Rows are mappings as ``results.json`` holds them (``Row.to_dict``).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..key import Method
from ..remarks import Remark
from ..results import WrittenRow, case_of
from .rounding import PLAIN, dof, near, number, settled, settled_ends, settled_number
from .rows import case_words, full_name, missing_of, quantity_name
from .tables import Block, Details, Table, clean

FEW = 3  # digits of an upper limit
WHOLE = 1e3  # values from here on are told with more than three digits
HEADS = ("quantity", "axis", "value ± u", "unit", "95 % interval", "dof")
RIGHT = (2, 4, 5)


def figure(row: WrittenRow | None) -> str:
    """Return value and standard uncertainty; an upper limit is marked as one."""
    if row is None:
        return ""
    if row["status"] == "upper_limit" and row["u"] is None:
        return f"< {settled_number(row['value'], FEW)}"
    return ("< " if row["status"] == "upper_limit" else "") + settled(row["value"], row["u"])


def figure_beside(row: Mapping[str, Any] | None, result: Mapping[str, Any] | None) -> str:
    """Return a figure that stands beside a result; with the digits of the result where it has no ``u``."""
    if row is None or row["u"] is not None or result is None or row["status"] == "upper_limit":
        return figure(row)
    return near(row["value"], result["u"])


def interval(row: Mapping[str, Any] | None) -> str:
    """Return the ends of the interval; nothing where there is none."""
    ends = row["interval"] if row is not None else None
    return "" if row is None or ends is None else settled_ends(row["value"], row["u"], ends["lo"], ends["hi"])


def degrees(row: Mapping[str, Any] | None) -> str:
    """Return the degrees of freedom."""
    return "" if row is None else dof(row["dof"])


def estimate_table(rows: Sequence[Mapping[str, Any]], caption: str = "") -> tuple[Block, ...]:
    """Return the figures that were estimated as a grid, and a line a reason for those that were not."""
    return (*estimated(rows, caption), *not_estimated(rows))


def estimated(rows: Sequence[Mapping[str, Any]], caption: str = "") -> tuple[Block, ...]:
    """Return the figures that were estimated as a grid; the caption alone where there are none."""
    found = [
        (full_name(row), row["axis"], figure(row), row["unit"], interval(row), degrees(row))
        for row in rows
        if row["status"] != "not_estimated"
    ]
    if found:
        return (Table(HEADS, found, caption, RIGHT),)
    return (caption,) if caption else ()


def folded(summary: str, lines: Sequence[str]) -> tuple[Block, ...]:
    """Return lines folded under a summary, which has their count in place of ``{n}``; nothing where there are none."""
    return (Details(summary.replace("{n}", str(len(lines))), tuple(lines)),) if lines else ()


def not_estimated(rows: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """Return a line a reason why figures were not estimated, with what is known of each."""
    reasons = {reason: dict.fromkeys(map(_told, found)) for reason, found in missing_of(rows).items()}
    return tuple(clean(f"not estimated: {', '.join(names)}: {reason}") for reason, names in reasons.items())


def _told(row: Mapping[str, Any]) -> str:
    """Return which figure a row is, or for one beside the result of what it is."""
    case = case_of(row)
    if case.beside and (case.method is not Method.TEXTBOOK or case.member is not None):
        return case_words(case)
    value = row["value"]
    known = "" if value is None else f" ({number(value, 3 if abs(value) < WHOLE else PLAIN)} {row['unit']})"
    name = quantity_name(row) if case.beside else full_name(row)
    return f"{name} {row['axis']}".strip() + known


def remarks_line(remarks: Iterable[Remark]) -> tuple[Block, ...]:
    """Return the remarks folded under their counts, the serious ones first; nothing where there are none."""
    every = tuple(remarks)
    counts = {word: [one for one in every if one.severity == word] for word in ("error", "warning", "info")}
    parts = [f"{len(found)} {_plural(word, len(found))}" for word, found in counts.items() if found]
    if not parts:
        return ()
    lines = tuple(str(one) for found in counts.values() for one in found)
    return (Details(f"remarks: {', '.join(parts)} (see .remarks)", lines),)


def _plural(word: str, count: int) -> str:
    return f"{word}s" if count > 1 and word != "info" else word
